#include "html.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

void html_text(const char *text, FILE *stream)
{
    for (; *text; text++) {
        switch (*text) {
        case '&':
            fputs("&amp;", stream);
            break;
        case '<':
            fputs("&lt;", stream);
            break;
        case '>':
            fputs("&gt;", stream);
            break;
        case '"':
            fputs("&quot;", stream);
            break;
        case '\'':
            fputs("&#39;", stream);
            break;
        default:
            if ((unsigned char)*text >= ' ' && *text != 127) fputc(*text, stream);
        }
    }
}

void html_number(double value, FILE *stream)
{
    char text[32];
    if (!isfinite(value)) {
        fputs("&ndash;", stream);
        return;
    }
    snprintf(text, sizeof text, "%.3g", value);
    char *power = strchr(text, 'e');
    if (power) *power = '\0';
    if (text[0] == '-')
        fprintf(stream, "&minus;%s", text + 1);
    else
        fputs(text, stream);
    if (power) {
        int exponent = atoi(power + 1);
        fprintf(stream, "&#8239;&times;&#8239;10<sup>%s%d</sup>", exponent < 0 ? "&minus;" : "", abs(exponent));
    }
}

const char *html_run_class(size_t run)
{
    static const char *const classes[] = {"s0", "s1", "s2", "s3", "s4", "s5", "s6", "s7", "s8", "s9"};
    return classes[run % 10];
}
