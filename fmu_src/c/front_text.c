/* Text: whether it is UTF-8, what of it may stand in a message, and sentences with numbers, whatever the host's locale. */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "front.h"

/* Bytes of the character that begins at `at`, 0 if none does: no overlong form, no surrogate, none above U+10FFFF. */
static size_t character(const char *at)
{
    const unsigned char *byte = (const unsigned char *)at;
    const unsigned first = byte[0];
    const size_t size = first < 0x80 ? 1 : first < 0xC2 ? 0 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : first < 0xF5 ? 4 : 0;
    for (size_t i = 1; i < size; i++) {
        if ((byte[i] & 0xC0) != 0x80) return 0;
    }
    if ((first == 0xE0 && byte[1] < 0xA0) || (first == 0xED && byte[1] > 0x9F)) return 0;
    if ((first == 0xF0 && byte[1] < 0x90) || (first == 0xF4 && byte[1] > 0x8F)) return 0;
    return size;
}

bool text_is_utf8(const char *text)
{
    for (size_t size; *text; text += size) {
        size = character(text);
        if (size == 0) return false;
    }
    return true;
}

static bool is_control(const char *at)
{
    const unsigned char first = (unsigned char)at[0], next = (unsigned char)at[1];
    return first < 0x20 || first == 0x7F || (first == 0xC2 && next < 0xA0);
}

void text_for_logger(const char *text, bool is_format, char *clean)
{
    for (size_t size; *text; text += size ? size : 1) {
        size = character(text);
        if (size == 0 || is_control(text)) {
            *clean++ = '?';
            continue;
        }
        if (is_format && *text == '%') *clean++ = '%';
        memcpy(clean, text, size);
        clean += size;
    }
    *clean = '\0';
}

const char *text_excerpt(const char *text, Excerpt *excerpt)
{
    const size_t length = strlen(text), room = sizeof excerpt->text / 2 - 4;
    if (length < sizeof excerpt->text) return text;
    size_t head = room, tail = length - room; /* not in the middle of a character */
    while (head > room - 4 && ((unsigned char)text[head] & 0xC0) == 0x80) head--;
    while (tail < length && ((unsigned char)text[tail] & 0xC0) == 0x80) tail++;
    memcpy(excerpt->text, text, head);
    memcpy(excerpt->text + head, " ... ", 5);
    memcpy(excerpt->text + head + 5, text + tail, length - tail + 1);
    return excerpt->text;
}

/* A conversion of our sentences: %d, %lu, %s, %g and %.10g; `kind` is 0 for any other. */
typedef struct {
    int precision; /* -1: none given */
    char kind;
} Conversion;

/* Reads the conversion behind a percent sign; where the text goes on. */
static const char *read_conversion(const char *at, Conversion *found)
{
    found->precision = *at == '.' ? 0 : -1;
    if (*at == '.') at++;
    for (; *at >= '0' && *at <= '9'; at++) found->precision = 10 * found->precision + (*at - '0');
    if (*at == 'l') at++;
    found->kind = *at && strchr("dusg%", *at) ? *at : '\0';
    return *at ? at + 1 : at;
}

enum { MOST_NUMBERS = 12 };

/* The numbers of a message. */
static int numbers_of(const char *format, va_list arguments, double numbers[MOST_NUMBERS])
{
    Conversion found;
    int count = 0;
    for (const char *at = strchr(format, '%'); at && count < MOST_NUMBERS; at = strchr(at, '%')) {
        at = read_conversion(at + 1, &found);
        if (found.kind == 'g') numbers[count++] = va_arg(arguments, double);
        else if (found.kind == 's') (void)va_arg(arguments, const char *);
        else if (found.kind == 'd') (void)va_arg(arguments, int);
        else if (found.kind == 'u') (void)va_arg(arguments, unsigned long);
        else if (found.kind != '%') break;
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

/* What has been written of a sentence; `length` goes on where there is no room. */
typedef struct {
    char *text;
    size_t size, length;
} Sentence;

static void put(Sentence *sentence, const char *piece, size_t length)
{
    const size_t room = sentence->length < sentence->size ? sentence->size - sentence->length : 0;
    if (room > 0) memcpy(sentence->text + sentence->length, piece, length < room ? length : room);
    sentence->length += length;
}

/* The C library writes the decimal separator of the host's locale, which may be several bytes, and which another thread
 * may change meanwhile: whatever is no digit, sign or letter becomes a point. */
static void put_number(Sentence *sentence, double value, int digits)
{
    char number[64];
    snprintf(number, sizeof number, "%.*g", digits, value);
    for (const char *at = number; *at;) {
        const size_t plain = strspn(at, "+-0123456789abcdefghijklmnopqrstuvwxyz()");
        put(sentence, at, plain);
        at += plain;
        if (*at) put(sentence, ".", 1);
        while (*at && !strchr("+-0123456789abcdefghijklmnopqrstuvwxyz()", *at)) at++;
    }
}

static void put_whole(Sentence *sentence, bool negative, unsigned long value)
{
    char digits[24], *at = digits + sizeof digits;
    do *--at = (char)('0' + value % 10);
    while ((value /= 10) > 0);
    if (negative) *--at = '-';
    put(sentence, at, (size_t)(digits + sizeof digits - at));
}

static size_t length_up_to(const char *text, int most)
{
    size_t length = 0;
    while ((most < 0 || length < (size_t)most) && text[length]) length++;
    return length;
}

int front_print(char *text, size_t size, const char *format, va_list arguments)
{
    double numbers[MOST_NUMBERS];
    Sentence sentence = {text, size, 0};
    Conversion found;
    bool alike = false;
    va_list copy;
    va_copy(copy, arguments);
    const int count = numbers_of(format, copy, numbers);
    va_end(copy);
    for (int i = 0; i < count; i++)
        for (int k = 0; k < i; k++) alike = alike || look_alike(numbers[i], numbers[k]);
    for (const char *at = format; *at;) {
        const size_t plain = strcspn(at, "%");
        put(&sentence, at, plain);
        at += plain;
        if (!*at) break;
        at = read_conversion(at + 1, &found);
        if (found.kind == 'g') {
            put_number(&sentence, va_arg(arguments, double), alike ? 17 : found.precision < 0 ? 6 : found.precision);
        } else if (found.kind == 's') {
            const char *piece = va_arg(arguments, const char *);
            put(&sentence, piece, length_up_to(piece, found.precision));
        } else if (found.kind == 'd') {
            const long value = va_arg(arguments, int);
            put_whole(&sentence, value < 0, value < 0 ? 0ul - (unsigned long)value : (unsigned long)value);
        } else if (found.kind == 'u') {
            put_whole(&sentence, false, va_arg(arguments, unsigned long));
        } else if (found.kind == '%') {
            put(&sentence, "%", 1);
        } else {
            break; /* not one of our sentences */
        }
    }
    if (size > 0) text[sentence.length < size ? sentence.length : size - 1] = '\0';
    return (int)sentence.length;
}
