/* Saved states: the backend's, with what the front remembers, and their serialised form. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "front.h"

#define STATE_VERSION 1u

/* What stands before the backend's bytes; `sum` is over everything after itself. */
typedef struct {
    char kind[8];
    uint64_t sum;
    uint64_t identity;
    uint64_t size;
    uint32_t version;
    uint32_t reserved;
    Progress progress;
} Header;

static const char KIND[8] = {'P', 'S', 'P', 's', 't', 'a', 't', 'e'};

uint64_t front_hash(const void *bytes, size_t size)
{
    const unsigned char *byte = bytes;
    uint64_t hash = UINT64_C(14695981039346656037);
    for (size_t i = 0; i < size; i++) hash = (hash ^ byte[i]) * UINT64_C(1099511628211);
    return hash;
}

static SavedState *is_ours(Front *front, fmi2FMUstate handle)
{
    SavedState *state = front->states;
    while (state && state != handle) state = state->next;
    return state;
}

/* `handle` as a state of this instance, or NULL, which is logged. */
static SavedState *find_state(Front *front, Call call, fmi2FMUstate handle)
{
    SavedState *state = is_ours(front, handle);
    if (!state)
        front_fail(front, "%s was called with a state that is not one of this instance: pass one from fmi2GetFMUstate or "
                          "fmi2DeSerializeFMUstate that was not freed", front_call_name(call));
    return state;
}

static SavedState *new_state(Front *front)
{
    SavedState *state = calloc(1, sizeof *state);
    if (!state) front_fail(front, "there is no memory left for another saved state: free some of them");
    return state;
}

static void unlink_and_free(Front *front, SavedState *state)
{
    SavedState **link = &front->states;
    while (*link != state) link = &(*link)->next;
    *link = state->next;
    backend_free_state(front->backend, state->backend);
    free(state);
}

void front_free_states(Front *front)
{
    while (front->states) unlink_and_free(front, front->states);
}

/* Puts `state` on the instance's list if `status` is good, else frees it; the status of the call. */
static fmi2Status keep(Front *front, SavedState *state, fmi2Status status, fmi2FMUstate *handle)
{
    status = front_judge(front, status);
    if (status == fmi2OK) {
        state->next = front->states;
        front->states = state;
        *handle = state;
    } else {
        free(state);
    }
    return front_leave(front, status);
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *handle)
{
    fmi2Status status;
    Front *front = front_enter(c, CALL_GET_STATE, &status);
    if (!front) return status;
    if (!front_has(front, CALL_GET_STATE, 1, handle, handle)) return front_leave(front, fmi2Error);
    const Progress progress = front->progress; /* before a failure here changes it */
    if (*handle) { /* the host hands back a state to be overwritten */
        SavedState *old = find_state(front, CALL_GET_STATE, *handle);
        if (!old) return front_leave(front, fmi2Error);
        unlink_and_free(front, old);
        *handle = NULL;
    }
    SavedState *state = new_state(front);
    if (!state) return front_leave(front, fmi2Error);
    state->progress = progress;
    return keep(front, state, backend_get_state(front->backend, &state->backend), handle);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate handle)
{
    fmi2Status status;
    Front *front = front_enter(c, CALL_SET_STATE, &status);
    if (!front) return status;
    const SavedState *state = find_state(front, CALL_SET_STATE, handle);
    status = front_judge(front, state ? backend_set_state(front->backend, state->backend) : fmi2Error);
    if (state && status == fmi2OK) front->progress = state->progress;
    return front_leave(front, status);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *handle)
{
    fmi2Status status;
    Front *front = front_enter(c, CALL_FREE_STATE, &status);
    if (!front) return status;
    if (!handle || !*handle) return front_leave(front, fmi2OK); /* as the standard has it */
    if (front->progress.mode == IN_ERROR && !is_ours(front, *handle)) return front_leave(front, fmi2Error); /* said enough */
    SavedState *state = find_state(front, CALL_FREE_STATE, *handle);
    if (!state) return front_leave(front, fmi2Error);
    unlink_and_free(front, state);
    *handle = NULL;
    return front_leave(front, fmi2OK);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate handle, size_t *size)
{
    fmi2Status status;
    Front *front = front_enter(c, CALL_STATE_SIZE, &status);
    if (!front) return status;
    const SavedState *state = find_state(front, CALL_STATE_SIZE, handle);
    if (!state || !front_has(front, CALL_STATE_SIZE, 1, size, size)) return front_leave(front, fmi2Error);
    status = front_judge(front, backend_state_size(front->backend, state->backend, size));
    if (status == fmi2OK) *size += sizeof(Header);
    return front_leave(front, status);
}

/* The sum over a serialised state, all but the kind and the sum itself. */
static uint64_t sum_of(const fmi2Byte bytes[], size_t size)
{
    const size_t skipped = offsetof(Header, identity);
    return front_hash(bytes + skipped, size - skipped);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate handle, fmi2Byte bytes[], size_t size)
{
    fmi2Status status;
    size_t needed = 0;
    Front *front = front_enter(c, CALL_SERIALIZE_STATE, &status);
    if (!front) return status;
    const SavedState *state = find_state(front, CALL_SERIALIZE_STATE, handle);
    if (!state || !front_has(front, CALL_SERIALIZE_STATE, 1, bytes, bytes)) return front_leave(front, fmi2Error);
    status = backend_state_size(front->backend, state->backend, &needed);
    if (front_judge(front, status) != fmi2OK) return front_leave(front, status);
    if (size < needed + sizeof(Header))
        return front_leave(front, front_fail(front, "fmi2SerializeFMUstate was given %lu bytes, but the state takes %lu: "
                                                    "ask fmi2SerializedFMUstateSize first", (unsigned long)size,
                                             (unsigned long)(needed + sizeof(Header))));
    Header header = {.identity = front->identity, .size = needed, .version = STATE_VERSION, .progress = state->progress};
    status = backend_write_state(front->backend, state->backend, bytes + sizeof header, needed);
    memcpy(header.kind, KIND, sizeof KIND);
    memcpy(bytes, &header, sizeof header);
    header.sum = sum_of(bytes, sizeof header + needed);
    memcpy(bytes, &header, sizeof header);
    memset(bytes + sizeof header + needed, 0, size - needed - sizeof header);
    return front_leave(front, status);
}

fmi2Status front_refuse_state(Front *front)
{
    return front_fail(front, "fmi2DeSerializeFMUstate was given a state that no run can come to, though its checksum fits: "
                             "pass what fmi2SerializeFMUstate wrote");
}

/* Whether what the front remembers can be so: any host can forge a sum. */
static bool can_be(const Header *header)
{
    const Progress *progress = &header->progress;
    const uint32_t mode = progress->mode, modes = INSTANTIATED | INITIALIZATION | STEP_COMPLETE | STEP_FAILED | TERMINATED |
                                                  IN_ERROR;
    return header->reserved == 0 && (mode & modes) == mode && mode != 0 && (mode & (mode - 1)) == 0 &&
           progress->has_stop <= 1 && progress->setup <= 1 && progress->last_step <= fmi2Error &&
           isfinite(progress->time) && isfinite(progress->start) && progress->elapsed >= 0.0 && isfinite(progress->elapsed) && progress->steps < UINT64_C(1) << 53 &&
           isfinite(progress->last_success) && progress->last_success >= progress->time &&
           !isnan(progress->stop);
}

/* Whether the bytes are a whole and undamaged state of this very build; if not, says why. */
static bool intact(Front *front, const fmi2Byte bytes[], size_t size, Header *header)
{
    memset(header, 0, sizeof *header);
    if (size >= sizeof *header) memcpy(header, bytes, sizeof *header);
    if (size < sizeof KIND || memcmp(bytes, KIND, sizeof KIND) != 0)
        front_fail(front, "fmi2DeSerializeFMUstate was given %lu bytes that are not a saved state of a platoon: pass what "
                          "fmi2SerializeFMUstate wrote", (unsigned long)size);
    else if (size < sizeof *header || header->size > size - sizeof *header)
        front_fail(front, "fmi2DeSerializeFMUstate was given a state cut off at %lu bytes: save it again",
                   (unsigned long)size);
    else if (header->sum != sum_of(bytes, sizeof *header + (size_t)header->size))
        front_fail(front, "fmi2DeSerializeFMUstate was given a damaged state, its checksum does not fit: save it again");
    else if (header->version != STATE_VERSION || header->identity != front->identity)
        front_fail(front, "fmi2DeSerializeFMUstate was given a state of another FMU or of another version of it: states "
                          "fit the very build that saved them");
    else if (!can_be(header))
        front_refuse_state(front);
    else
        return true;
    return false;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *handle)
{
    fmi2Status status;
    Header header;
    Front *front = front_enter(c, CALL_DESERIALIZE_STATE, &status);
    if (!front) return status;
    if (!front_has(front, CALL_DESERIALIZE_STATE, 1, bytes, handle) || !intact(front, bytes, size, &header))
        return front_leave(front, fmi2Error);
    SavedState *state = new_state(front);
    if (!state) return front_leave(front, fmi2Error);
    state->progress = header.progress;
    status = backend_read_state(front->backend, &header.progress, bytes + sizeof header, (size_t)header.size,
                                &state->backend);
    return keep(front, state, status, handle);
}
