#include "command_status.h"

#include "terminal.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

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

command_status command_cannot_write(const char *name, const char *path)
{
    int error = errno;
    command_error(name, "%s: cannot be written%s%s", path, error != 0 ? ": " : "", error != 0 ? strerror(error) : "");
    return COMMAND_SYSTEM;
}
