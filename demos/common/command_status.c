#include "command_status.h"

#include <stdarg.h>
#include <stdio.h>

void command_error(const char *name, const char *format, ...)
{
    va_list arguments;
    fprintf(stderr, "pinch %s: ", name);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}
