#include "python_resources.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "library.h"
#include "python_host.h"

#ifdef _WIN32
#include <windows.h>
#define EXPORT_LIBRARY "/binaries/win64/pythonfmu-export.dll"
#else
#define EXPORT_LIBRARY "/binaries/linux64/libpythonfmu-export.so"
#endif

static FILE *open_resource(const char *resources, const char *name, const char *ending)
{
    char path[2048];
    const int length = snprintf(path, sizeof path, "%s/%s%s", resources, name, ending);
    return length > 0 && length < (int)sizeof path ? fopen(path, "r") : NULL;
}

const char *first_line(const char *resources, const char *name, char *buffer, size_t size)
{
    FILE *stream = resources ? open_resource(resources, name, "") : NULL;
    buffer[0] = '\0';
    if (stream) {
        if (fgets(buffer, (int)size, stream)) buffer[strcspn(buffer, "\r\n")] = '\0';
        fclose(stream);
    }
    return buffer;
}

const char *openable(const char *resources, char *buffer, size_t size)
{
#ifdef _WIN32
    wchar_t wide[1024], brief[1024];
    bool ascii = true;
    for (const char *c = resources; *c; c++) ascii = ascii && (unsigned char)*c < 128;
    if (!ascii && MultiByteToWideChar(CP_UTF8, 0, resources, -1, wide, 1024) && GetShortPathNameW(wide, brief, 1024) &&
        WideCharToMultiByte(CP_UTF8, 0, brief, -1, buffer, (int)size, NULL, NULL))
        return buffer;
#endif
    (void)buffer, (void)size;
    return resources;
}

bool readable(Front *front, const char *resources)
{
    char module[256];
    Excerpt excerpt;
    if (!resources || resources[0] == '\0') {
        front_fail(front, "fmi2Instantiate was called without a resource location: pass the URI of the FMU's resources");
        return false;
    }
    if (!text_is_utf8(resources)) { /* pythonfmu crashes on it */
        front_fail(front, "the FMU's resources lie in %s, whose name is no UTF-8: extract the FMU into another folder",
                   text_excerpt(resources, &excerpt));
        return false;
    }
    if (strstr(resources, "%20") || strstr(resources, "file://")) { /* pythonfmu would replace them */
        front_fail(front, "the FMU's resources lie in %s, and pythonfmu cannot open a path with '%%20' in it: extract the "
                          "FMU into another folder", text_excerpt(resources, &excerpt));
        return false;
    }
    first_line(resources, "slavemodule.txt", module, sizeof module);
    FILE *stream = module[0] ? open_resource(resources, module, ".py") : NULL;
    if (!stream) {
        front_fail(front, "the FMU's resources cannot be read in %s: extract the whole FMU and pass the URI of its folder "
                          "'resources'", text_excerpt(resources, &excerpt));
        return false;
    }
    fclose(stream);
    return true;
}

/* Hash of a file's content; 0 if it cannot be read. */
static uint64_t hash_of(const char *path)
{
    uint64_t hash = 0;
    FILE *stream = fopen(path, "rb");
    long size = stream && fseek(stream, 0, SEEK_END) == 0 ? ftell(stream) : 0;
    char *bytes = size > 0 ? malloc((size_t)size) : NULL;
    if (bytes && fseek(stream, 0, SEEK_SET) == 0 && fread(bytes, 1, (size_t)size, stream) == (size_t)size)
        hash = front_hash(bytes, (size_t)size);
    free(bytes);
    if (stream) fclose(stream);
    return hash;
}

void *open_pythonfmu(Front *front, const char *resources)
{
    char path[2048], name[64], why[512];
    snprintf(path, sizeof path, "%s%s", resources, EXPORT_LIBRARY);
    const uint64_t hash = hash_of(path);
    snprintf(name, sizeof name, "_psp_pythonfmu_%08lx%08lx", (unsigned long)(hash >> 32), (unsigned long)(hash & 0xffffffff));
    void *library = hash ? python_recall(name) : NULL;
    if (library) return library;
    library = library_open(path, false);
    if (library && hash) python_remember(name, library);
    if (library) return library;
    library_error(why, sizeof why);
    front_fail(front, "%s cannot be loaded (%s): %s", path, why,
               strstr(why, "map segment") ? "its folder allows no programs (mounted noexec), let the host extract FMUs into "
                                            "another one, TMPDIR"
                                          : "extract the whole FMU, and install what this message names");
    return NULL;
}
