/* Messages to the host's logger, and the log categories of the FMI standard. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "front.h"

static const char *const CATEGORIES[] = {"logAll", "logStatusWarning", "logStatusDiscard", "logStatusError",
                                         "logStatusFatal"};
enum { CATEGORY_COUNT = 5, LOG_ALL = 1u };

bool front_choose_categories(Front *front, size_t count, const fmi2String names[])
{
    bool known = true;
    front->categories = 0;
    for (size_t i = 0; i < count; i++) {
        unsigned bit = 0;
        for (unsigned k = 0; k < CATEGORY_COUNT; k++) {
            if (names[i] && strcmp(names[i], CATEGORIES[k]) == 0) bit = 1u << k;
        }
        if (bit == 0) {
            known = false;
            front_log(front, fmi2Warning,
                      "fmi2SetDebugLogging does not know the log category '%.100s': choose from logStatusWarning, "
                      "logStatusDiscard, logStatusError, logStatusFatal and logAll",
                      names[i] ? names[i] : "(null)");
        }
        front->categories |= bit;
    }
    return known;
}

/* Without debug logging, what explains a returned status is still passed on, as the standard has it ("logger" was
 * called); with a list of categories the host has said exactly what it wants. */
static bool wanted(const Front *front, fmi2Status status)
{
    if (!front->logging) return status != fmi2OK;
    return front->categories == 0 || (front->categories & (LOG_ALL | 1u << status)) != 0;
}

void front_log(Front *front, fmi2Status status, const char *format, ...)
{
    char text[1024], *message = text;
    va_list arguments;
    if (status > front->worst) front->worst = status;
    if (!front->logger || !wanted(front, status)) return;
    va_start(arguments, format);
    const int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    if (length >= (int)sizeof text && (message = malloc((size_t)length + 1)) != NULL) {
        va_start(arguments, format);
        vsnprintf(message, (size_t)length + 1, format, arguments);
        va_end(arguments);
    }
    if (!message) message = text; /* cut, but better than nothing */
    front->logger(front->environment, front->name, status, CATEGORIES[status], "%s", message);
    if (message != text) free(message);
}
