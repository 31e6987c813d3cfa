/* Messages to the host's logger, and the log categories of the FMI standard. */
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "front.h"

static const char *const CATEGORIES[] = {"logAll", "logStatusWarning", "logStatusDiscard", "logStatusError",
                                         "logStatusFatal"};
enum { CATEGORY_COUNT = 5 };

static unsigned category_bit(const char *name)
{
    for (unsigned k = 0; name && k < CATEGORY_COUNT; k++) {
        if (strcmp(name, CATEGORIES[k]) == 0) return 1u << k;
    }
    return 0;
}

static void warn_of_unknown(Front *front, size_t count, const fmi2String names[])
{
    Excerpt excerpt;
    for (size_t i = 0; i < count; i++) {
        if (category_bit(names[i]) != 0) continue;
        front_log(front, fmi2Warning,
                  "fmi2SetDebugLogging does not know the log category '%s', which enables nothing: choose from "
                  "logStatusWarning, logStatusDiscard, logStatusError, logStatusFatal and logAll",
                  names[i] ? text_excerpt(names[i], &excerpt) : "(null)");
    }
}

/* What explains a failure is passed on whatever the host has enabled: the status alone would tell it nothing. */
static bool wanted(const Front *front, fmi2Status status)
{
    return status >= fmi2Error || (front->logging && (front->categories & (LOG_ALL | 1u << status)) != 0);
}

void front_choose_categories(Front *front, bool logging, size_t count, const fmi2String names[])
{
    unsigned categories = count == 0 ? LOG_ALL : 0;
    const bool heard_before = wanted(front, fmi2Warning); /* so that somebody learns of a name that enables nothing */
    for (size_t i = 0; i < count; i++) categories |= category_bit(names[i]);
    if (heard_before) warn_of_unknown(front, count, names);
    front->logging = logging;
    front->categories = categories;
    if (!heard_before) warn_of_unknown(front, count, names);
}

/* As text that any logger shows as it is: the format itself, so that those which ignore further arguments show it too. */
static void hand_over(Front *front, fmi2Status status, const char *message, char *clean)
{
    text_for_logger(message, true, clean);
    front->logger(front->environment, front->name, status, CATEGORIES[status], clean);
}

void front_log_list(Front *front, fmi2Status status, const char *format, va_list arguments)
{
    char text[1024], clean[2 * sizeof text], *longer = NULL;
    va_list copy;
    if (status == fmi2Error) status = front_failure(front);
    if (status > front->worst) front->worst = status;
    if (!front->logger || !wanted(front, status)) return;
    va_copy(copy, arguments);
    const size_t size = (size_t)front_print(text, sizeof text, format, copy) + 1;
    va_end(copy);
    if (size > sizeof text && (longer = malloc(3 * size)) != NULL) front_print(longer, size, format, arguments);
    if (longer) hand_over(front, status, longer, longer + size);
    else hand_over(front, status, text, clean); /* cut if it was too long, but better than nothing */
    free(longer);
}

void front_log(Front *front, fmi2Status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    front_log_list(front, status, format, arguments);
    va_end(arguments);
}

fmi2Status front_fail(Front *front, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    front_log_list(front, fmi2Error, format, arguments);
    va_end(arguments);
    return front_failure(front);
}
