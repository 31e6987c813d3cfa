/* Going through a time in which commands on their way take effect: mirrors segments() in
 * psp_model/vehicles/actuation.py. */
#ifndef PSP_PIECES_H
#define PSP_PIECES_H

#include "actuation.h"

/* Where the command is that is the k-th to take effect. */
static inline int64_t row_of(const Actuators *actuators, int64_t k)
{
    const int64_t place = actuators->first + k;
    return place < actuators->rows ? place : place - actuators->rows;
}

/* How far one has come through a time tau, in pieces with one command each. */
typedef struct {
    const Actuators *of;
    const double *command; /* in effect */
    int64_t next;          /* command on its way */
    double passed, tau, now; /* time since the rows were written, and in this time */
    bool ended;
} Pieces;

static inline Pieces pieces(const Actuators *of, double tau)
{
    const Pieces fresh = {of, of->command, 0, 0.0, tau, 0.0, false};
    return fresh;
}

/* The same for another time from the end of this one on. */
static inline Pieces pieces_after(const Pieces *before, double tau)
{
    const double passed = before->passed + before->tau;
    const Pieces fresh = {before->of, before->command, before->next, passed, tau, 0.0, false};
    return fresh;
}

/* The command of the next piece and its length; NULL at the end. */
static inline const double *next_piece(Pieces *at, double *span)
{
    const double *command = at->command;
    if (at->ended) return NULL;
    for (; at->next < at->of->count; at->next++) {
        const OnItsWay *following = &at->of->queue[row_of(at->of, at->next)];
        const double due = following->due - at->passed, begun = at->now;
        if (due > at->tau) break;
        at->command = following->a;
        if (due > begun) {
            *span = due - begun;
            at->now = due;
            at->next++;
            return command;
        }
        command = following->a;
    }
    at->ended = true;
    *span = at->tau - at->now;
    return command;
}

#endif
