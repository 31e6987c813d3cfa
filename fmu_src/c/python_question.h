/* What the Python on PATH says of itself. */
#ifndef PSP_PYTHON_QUESTION_H
#define PSP_PYTHON_QUESTION_H

#include <stdbool.h>

#include "names.h"

typedef struct {
    char executable[1024];
    char version[32];
    char bits[8];
    char library[1024]; /* "" if it has none that could be loaded */
    char said[512];     /* in place of an answer: its last message, an error if there is one */
    bool found;         /* there is a Python on PATH */
} Answer;

/* Asks in the environment of this process, or, if `without` is not NULL, with that environment variable unset. */
Answer ask_python_on_path(const char *without);

/* Whether it answered at all. */
bool answered(const Answer *answer);

#endif
