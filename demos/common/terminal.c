#include "terminal.h"

#include "utf8.h"

#include <limits.h>
#include <stdarg.h>
#include <string.h>

/* ---- Texts. ---- */

static bool is_obeyed(unsigned long code)
{
    bool control = code < 0x20 || (code >= 0x7f && code < 0xa0);
    bool line_or_paragraph = code == 0x2028 || code == 0x2029;
    bool direction = (code >= 0x202a && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
    return control || line_or_paragraph || direction;
}

/* The number of bytes of the character that a text begins with; 0 where it is not to be written as it is. */
static int length_of_shown(const char *text)
{
    unsigned long code;
    int length = utf8_read(text, &code);
    return length && !is_obeyed(code) ? length : 0;
}

/* Writes at most so many characters of a text, and returns how many columns they take. Without a stream it counts. */
static int write_text(const char *text, int most, FILE *stream)
{
    int columns = 0;
    for (int i = 0; i < most && *text; i++) {
        int length = length_of_shown(text);
        if (stream && length) fwrite(text, 1, (size_t)length, stream);
        if (stream && !length) fprintf(stream, "\\x%02x", (unsigned char)*text);
        columns += length ? 1 : 4;
        text += length ? length : 1;
    }
    return columns;
}

void terminal_text(const char *text, FILE *stream)
{
    write_text(text, INT_MAX, stream);
}

bool terminal_shows(const char *text)
{
    for (int length; *text; text += length)
        if (!(length = length_of_shown(text))) return false;
    return true;
}

/* ---- Formats. ---- */

/* A conversion of a format: what stands from its % on. */
typedef struct conversion {
    char flags[8];
    int width, precision; /* -1: none is given */
    char size[4];         /* "l" of a long, for example */
    char type;
} conversion;

static const char *read_number(const char *at, va_list *arguments, int *number)
{
    *number = 0;
    if (*at == '*') {
        *number = va_arg(*arguments, int);
        return at + 1;
    }
    for (; *at >= '0' && *at <= '9'; at++) *number = 10 * *number + (*at - '0');
    return at;
}

/* Copies the leading characters that are among `known`, of which a text has room for `most`. */
static const char *read_letters(const char *at, const char *known, char *text, size_t most)
{
    size_t count = strspn(at, known);
    size_t kept = count < most ? count : most;
    memcpy(text, at, kept);
    text[kept] = '\0';
    return at + count;
}

/* Returns where the format goes on. */
static const char *read_conversion(const char *at, va_list *arguments, conversion *c)
{
    *c = (conversion){.width = -1, .precision = -1};
    at = read_letters(at, "-+ #0", c->flags, sizeof c->flags - 1);
    if (*at == '*' || (*at >= '1' && *at <= '9')) at = read_number(at, arguments, &c->width);
    if (*at == '.') at = read_number(at + 1, arguments, &c->precision);
    at = read_letters(at, "hlz", c->size, sizeof c->size - 1);
    c->type = *at;
    return *at ? at + 1 : at;
}

static void put_padding(int columns, FILE *stream)
{
    for (; columns > 0; columns--) fputc(' ', stream);
}

static void put_text(const conversion *c, const char *text, FILE *stream)
{
    int most = c->precision >= 0 ? c->precision : INT_MAX;
    int room = c->width - write_text(text, most, NULL);
    bool left = strchr(c->flags, '-') != NULL;
    if (!left) put_padding(room, stream);
    write_text(text, most, stream);
    if (left) put_padding(room, stream);
}

/* Anything but a text is written by fprintf, by a format of this one conversion. */
static void put_number(const conversion *c, va_list *arguments, FILE *stream)
{
    char width[16] = "", precision[16] = "", format[64];
    if (c->width >= 0) snprintf(width, sizeof width, "%d", c->width);
    if (c->precision >= 0) snprintf(precision, sizeof precision, ".%d", c->precision);
    snprintf(format, sizeof format, "%%%s%s%s%s%c", c->flags, width, precision, c->size, c->type);
    if (strchr("eEfFgG", c->type))
        fprintf(stream, format, va_arg(*arguments, double));
    else if (strcmp(c->size, "ll") == 0)
        fprintf(stream, format, va_arg(*arguments, long long));
    else if (strcmp(c->size, "l") == 0)
        fprintf(stream, format, va_arg(*arguments, long));
    else if (strcmp(c->size, "z") == 0)
        fprintf(stream, format, va_arg(*arguments, size_t));
    else
        fprintf(stream, format, va_arg(*arguments, int));
}

/* A va_list as a parameter may be a pointer, whose address another function could not take. */
static void put_all(FILE *stream, const char *format, va_list *arguments)
{
    while (*format) {
        size_t plain = strcspn(format, "%");
        fwrite(format, 1, plain, stream);
        format += plain;
        if (!*format) return;
        conversion c;
        format = read_conversion(format + 1, arguments, &c);
        if (c.type == 's')
            put_text(&c, va_arg(*arguments, const char *), stream);
        else if (c.type == '%')
            fputc('%', stream);
        else
            put_number(&c, arguments, stream);
    }
}

void terminal_print(FILE *stream, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    put_all(stream, format, &arguments);
    va_end(arguments);
}
