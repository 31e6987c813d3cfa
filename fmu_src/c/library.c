#ifndef _WIN32
#define _GNU_SOURCE /* RTLD_DEFAULT */
#endif

#include "library.h"

#include <stdio.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>

void *library_open(const char *path, bool global)
{
    wchar_t wide[1024];
    (void)global;
    if (!MultiByteToWideChar(CP_UTF8, 0, path, -1, wide, 1024)) return NULL;
    for (wchar_t *c = wide; *c; c++) {
        if (*c == L'/') *c = L'\\';
    }
    return (void *)LoadLibraryExW(wide, NULL, LOAD_WITH_ALTERED_SEARCH_PATH);
}

bool library_function(void *library, const char *name, void *function)
{
    HMODULE module = library ? (HMODULE)library : GetModuleHandleW(L"python3.dll");
    FARPROC found = module ? GetProcAddress(module, name) : NULL;
    memcpy(function, &found, sizeof found);
    return found != NULL;
}

const char *library_error(char *buffer, size_t size)
{
    snprintf(buffer, size, "Windows error %lu", (unsigned long)GetLastError());
    return buffer;
}

#else
#include <dlfcn.h>

void *library_open(const char *path, bool global) { return dlopen(path, RTLD_NOW | (global ? RTLD_GLOBAL : RTLD_LOCAL)); }

bool library_function(void *library, const char *name, void *function)
{
    void *found = dlsym(library ? library : RTLD_DEFAULT, name);
    memcpy(function, &found, sizeof found);
    return found != NULL;
}

const char *library_error(char *buffer, size_t size)
{
    const char *why = dlerror();
    snprintf(buffer, size, "%s", why ? why : "no reason given");
    return buffer;
}
#endif
