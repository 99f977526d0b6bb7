#include "command_status.h"

#include "terminal.h"

#include <stdarg.h>
#include <stdio.h>

void command_error(const char *name, const char *format, ...)
{
    char text[2048];
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    fprintf(stderr, "pinch %s: ", name);
    terminal_text(text, stderr);
    fputs(length >= (int)sizeof text ? "...\n" : "\n", stderr);
}
