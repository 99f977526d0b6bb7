/* The paper's figures: log10 of the residual against the iterations, NSNGRK and NSNMGK. gnuplot draws them. */
#define _POSIX_C_SOURCE 200809L

#include "bench.h"

#include <errno.h>
#include <math.h>
#include <string.h>
#include <sys/stat.h>

/* Figures 2, 4, 6, 8 and 10 of the paper. */
static const struct {
    const char *example;
    int faces;
    int figure;
} figures[] = {{"1", 4, 2}, {"1b", 4, 4}, {"2", 5, 6}, {"3", 5, 8}, {"4", 8, 10}};
enum { FIGURES = sizeof figures / sizeof figures[0] };

static void write_progress(void *context, int iteration, double residual)
{
    fprintf(context, "%d %.6g\n", iteration, log10(residual));
}

static bool write_curve(const char *folder, const char *stem, const char *method, const paper_example *e, int faces,
                        pinch_solver solver, pinch_statics *statics)
{
    char file[1024];
    snprintf(file, sizeof file, "%s/%s-%s.dat", folder, stem, method);
    FILE *stream = fopen(file, "w");
    if (!stream) {
        command_error("bench", "%s: cannot be written: %s", file, strerror(errno));
        return false;
    }
    fprintf(stream, "# iteration log10(residual)\n");
    pinch_statics_settings settings = paper_settings(faces, solver, 1);
    settings.solver.progress = write_progress;
    settings.solver.progress_context = stream;
    pinch_statics_result result;
    pinch_statics_solve(statics, &e->grasp, &settings, e->results, &result);
    bool written = !ferror(stream);
    return fclose(stream) == 0 && written;
}

/* gnuplot's strings are single-quoted: a quote in a path is doubled */
static void quote(const char *text, char *quoted, size_t size)
{
    size_t used = 0;
    for (; *text && used + 2 < size; text++) {
        if (*text == '\'') quoted[used++] = '\'';
        quoted[used++] = *text;
    }
    quoted[used] = '\0';
}

static bool draw(const char *folder, const char *stem, const char *title)
{
    static const struct {
        const char *suffix, *terminal;
    } formats[] = {{"svg", "svg size 800,560 font 'sans,14' background 'white'"},
                   {"png", "pngcairo size 1200,840 font 'sans,14'"}};
    char at[2048];
    quote(folder, at, sizeof at);
    FILE *gnuplot = popen("gnuplot", "w");
    if (!gnuplot) return false;
    fprintf(gnuplot,
            "set title '%s'\nset xlabel 'IT (iterations)'\nset ylabel 'log10 RES'\nset grid\nset key top right\n",
            title);
    for (int i = 0; i < 2; i++) {
        fprintf(gnuplot, "set terminal %s\nset output '%s/%s.%s'\n", formats[i].terminal, at, stem, formats[i].suffix);
        fprintf(gnuplot,
                "plot '%s/%s-nsngrk.dat' with lines lw 2 title 'NSNGRK (seed 1)', "
                "'%s/%s-nsnmgk.dat' with lines lw 2 title 'NSNMGK'\n",
                at, stem, at, stem);
    }
    return pclose(gnuplot) == 0;
}

static command_status plot_figure(const char *folder, int figure, const paper_example *e, pinch_statics *statics)
{
    char stem[64], title[128], faces[32] = "";
    int n = figures[figure].faces;
    if (e->frictional) snprintf(faces, sizeof faces, "-%d-faces", n);
    snprintf(stem, sizeof stem, "example-%s%s", e->name, faces);
    snprintf(title, sizeof title, "Example %s%s%.0d%s: residual against iterations (Figure %d of the paper)", e->name,
             e->frictional ? ", " : "", e->frictional ? n : 0, e->frictional ? " faces" : "", figures[figure].figure);
    if (!write_curve(folder, stem, "nsngrk", e, n, PINCH_SOLVER_NSNGRK, statics) ||
        !write_curve(folder, stem, "nsnmgk", e, n, PINCH_SOLVER_NSNMGK, statics))
        return COMMAND_SYSTEM;
    if (draw(folder, stem, title)) return COMMAND_DONE;
    command_error("bench", "gnuplot is missing or failed: %s/%s-*.dat hold the curves, nothing was drawn", folder,
                  stem);
    return COMMAND_SYSTEM;
}

command_status paper_plot(const char *folder, paper_example *examples, int count, pinch_statics *statics)
{
    if (mkdir(folder, 0777) != 0 && errno != EEXIST) {
        command_error("bench", "%s: cannot be created: %s", folder, strerror(errno));
        return COMMAND_SYSTEM;
    }
    for (int i = 0; i < FIGURES; i++)
        for (int k = 0; k < count; k++) {
            if (strcmp(examples[k].name, figures[i].example) != 0) continue;
            command_status status = plot_figure(folder, i, &examples[k], statics);
            if (status != COMMAND_DONE) return status;
        }
    return COMMAND_DONE;
}
