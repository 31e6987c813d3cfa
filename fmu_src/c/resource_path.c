/* From the resource URI that a host passes to a path that can be opened. */
#include <stdlib.h>
#include <string.h>

#include "front.h"

static int hex(char c)
{
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

static void percent_decode(char *text)
{
    char *to = text;
    for (const char *from = text; *from; from++) {
        if (from[0] == '%' && hex(from[1]) >= 0 && hex(from[2]) >= 0) {
            *to++ = (char)(hex(from[1]) * 16 + hex(from[2]));
            from += 2;
        } else {
            *to++ = *from;
        }
    }
    *to = '\0';
}

/* Where the path begins in file:/path, file:///path, file://localhost/path, file:///C:/path and file://server/share. */
static const char *after_scheme(const char *uri)
{
    const char *path = uri + strlen("file:");
    if (strncmp(path, "//localhost/", 12) == 0) path += 11;
    else if (strncmp(path, "///", 3) == 0) path += 2;
#ifdef _WIN32
    const char *letter = path[0] == '/' ? path + 1 : path;
    if (letter[0] && letter[1] == ':') return letter;
#else
    if (strncmp(path, "//", 2) == 0) path += 1;
#endif
    return path;
}

char *resource_path(const char *uri)
{
    const bool is_uri = strncmp(uri, "file:", 5) == 0;
    const char *begin = is_uri ? after_scheme(uri) : uri;
    size_t length = strlen(begin);
    char *path = malloc(length + 1);
    if (!path) return NULL;
    memcpy(path, begin, length + 1);
    if (is_uri) percent_decode(path); /* a plain path may well hold a percent sign */
    length = strlen(path);
    while (length > 1 && (path[length - 1] == '/' || path[length - 1] == '\\')) path[--length] = '\0';
    return path;
}
