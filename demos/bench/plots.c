#define _POSIX_C_SOURCE 200809L

#include "plots.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>

command_status plots_folder(const char *folder)
{
    for (const char *c = folder; *c; c++)
        if ((unsigned char)*c < 0x20) {
            command_error("bench", "--plot: expected a name without control characters, got \"%s\"", folder);
            return COMMAND_BAD_INPUT;
        }
    if (mkdir(folder, 0777) == 0 || errno == EEXIST) return COMMAND_DONE;
    command_error("bench", "%s: cannot be created: %s", folder, strerror(errno));
    return COMMAND_SYSTEM;
}

FILE *plots_data(const char *folder, const char *stem)
{
    char file[1024];
    snprintf(file, sizeof file, "%s/%s.dat", folder, stem);
    FILE *stream = fopen(file, "w");
    if (!stream) command_error("bench", "%s: cannot be written: %s", file, strerror(errno));
    return stream;
}

/* gnuplot's strings are single-quoted, and a quote in a path is doubled. */
static void quote(const char *text, char *quoted, size_t size)
{
    size_t used = 0;
    for (; *text && used + 2 < size; text++) {
        if (*text == '\'') quoted[used++] = '\'';
        quoted[used++] = *text;
    }
    quoted[used] = '\0';
}

static void write_plots(FILE *gnuplot, const char *plots, const char *at)
{
    fputs("plot ", gnuplot);
    for (const char *c = plots; *c; c++) {
        if (c[0] == '%' && c[1] == 's') {
            fprintf(gnuplot, "%s/", at);
            c++;
        } else {
            fputc(*c, gnuplot);
        }
    }
    fputc('\n', gnuplot);
}

bool plots_draw(const char *folder, const char *stem, const char *settings, const char *plots)
{
    static const struct {
        const char *suffix, *terminal;
    } formats[] = {{"svg", "svg size 800,560 font 'sans,14' background 'white'"},
                   {"png", "pngcairo size 1200,840 font 'sans,14'"}};
    char at[2048];
    quote(folder, at, sizeof at);
    FILE *gnuplot = popen("gnuplot", "w");
    if (!gnuplot) return false;
    fputs(settings, gnuplot);
    for (int i = 0; i < 2; i++) {
        fprintf(gnuplot, "set terminal %s\nset output '%s/%s.%s'\n", formats[i].terminal, at, stem, formats[i].suffix);
        write_plots(gnuplot, plots, at);
    }
    return pclose(gnuplot) == 0;
}

void plots_complain(const char *folder, const char *stem)
{
    command_error("bench", "gnuplot is missing or failed: %s/%s*.dat hold the data, nothing was drawn", folder, stem);
}
