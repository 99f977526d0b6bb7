#include "csv.h"

#include <string.h>

void csv_text(const char *text, const char *suffix, FILE *stream)
{
    if (!strpbrk(text, ",\"\r\n")) {
        fprintf(stream, "%s%s", text, suffix);
        return;
    }
    fputc('"', stream);
    for (; *text; text++) {
        if (*text == '"') fputc('"', stream);
        fputc(*text, stream);
    }
    fprintf(stream, "%s\"", suffix);
}
