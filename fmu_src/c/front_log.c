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

enum { MOST_NUMBERS = 12, LONGEST_FORMAT = 1024 };

/* The numbers of a message; those behind a conversion that is not one of our sentences' are left out. */
static int numbers_of(const char *format, va_list arguments, double numbers[MOST_NUMBERS])
{
    int count = 0;
    for (const char *at = strchr(format, '%'); at && count < MOST_NUMBERS; at = strchr(at + 1, '%')) {
        at += 1 + strspn(at + 1, ".0123456789");
        if (*at == 'g') numbers[count++] = va_arg(arguments, double);
        else if (*at == 's') (void)va_arg(arguments, const char *);
        else if (*at == 'd') (void)va_arg(arguments, int);
        else if (*at != '%') break;
    }
    return count;
}

static bool look_alike(double a, double b)
{
    char one[32], other[32];
    if (!(a < b || a > b)) return false; /* equal, or not numbers */
    snprintf(one, sizeof one, "%.10g", a);
    snprintf(other, sizeof other, "%.10g", b);
    return strcmp(one, other) == 0;
}

int front_print(char *text, size_t size, const char *format, va_list arguments)
{
    double numbers[MOST_NUMBERS];
    char exact[LONGEST_FORMAT];
    bool alike = false;
    va_list copy;
    va_copy(copy, arguments);
    const int count = numbers_of(format, copy, numbers);
    va_end(copy);
    for (int i = 0; i < count; i++)
        for (int k = 0; k < i; k++) alike = alike || look_alike(numbers[i], numbers[k]);
    if (!alike || strlen(format) >= sizeof exact) return vsnprintf(text, size, format, arguments);
    memcpy(exact, format, strlen(format) + 1);
    for (char *at = exact; (at = strstr(at, "%.10g")) != NULL; at++) memcpy(at, "%.17g", 5);
    return vsnprintf(text, size, exact, arguments);
}

void front_log(Front *front, fmi2Status status, const char *format, ...)
{
    char text[1024], *message = text;
    va_list arguments;
    if (status > front->worst) front->worst = status;
    if (!front->logger || !wanted(front, status)) return;
    va_start(arguments, format);
    const int length = front_print(text, sizeof text, format, arguments);
    va_end(arguments);
    if (length >= (int)sizeof text && (message = malloc((size_t)length + 1)) != NULL) {
        va_start(arguments, format);
        front_print(message, (size_t)length + 1, format, arguments);
        va_end(arguments);
    }
    if (!message) message = text; /* cut, but better than nothing */
    front->logger(front->environment, front->name, status, CATEGORIES[status], "%s", message);
    if (message != text) free(message);
}
