#include "command_status.h"

#include <stdarg.h>
#include <stdio.h>

/* File names and keys come from anywhere. A control character in them would reach the terminal as a command, so it is
 * written as its number. */
void message_print(const char *text, FILE *stream)
{
    for (; *text; text++) {
        unsigned char c = (unsigned char)*text;
        if (c < 0x20 || c == 0x7f)
            fprintf(stream, "\\x%02x", c);
        else
            fputc(c, stream);
    }
}

void command_error(const char *name, const char *format, ...)
{
    char text[2048];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    fprintf(stderr, "pinch %s: ", name);
    message_print(text, stderr);
    fputs(length >= (int)sizeof text ? "...\n" : "\n", stderr);
}
