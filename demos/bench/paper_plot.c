/* The paper's figures: log10 of the residual against the iterations, NSNGRK and NSNMGK. gnuplot draws them. */
#include "bench.h"
#include "gnuplot.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

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

static bool write_curve(const char *folder, const char *stem, const char *method, const paper_example *e,
                        pinch_statics_settings settings, pinch_statics *statics)
{
    char name[128];
    snprintf(name, sizeof name, "%s-%s", stem, method);
    FILE *stream = gnuplot_data(folder, name);
    if (!stream) return false;
    fprintf(stream, "# iteration log10(residual)\n");
    settings.solver.progress = write_progress;
    settings.solver.progress_context = stream;
    pinch_statics_result result;
    pinch_statics_solve(statics, &e->grasp, &settings, e->results, &result);
    bool written = !ferror(stream);
    return fclose(stream) == 0 && written;
}

static bool draw(const char *folder, const char *stem, const char *title, uint64_t seed)
{
    char settings[512], plots[512];
    snprintf(settings, sizeof settings,
             "set title '%s'\nset xlabel 'IT (iterations)'\nset ylabel 'log10 RES'\nset grid\nset key top right\n",
             title);
    snprintf(plots, sizeof plots,
             "'%%s%s-nsngrk.dat' with lines lw 2 title 'NSNGRK (seed %" PRIu64 ")', "
             "'%%s%s-nsnmgk.dat' with lines lw 2 title 'NSNMGK'",
             stem, seed, stem);
    return gnuplot_draw(folder, stem, settings, plots);
}

static command_status plot_figure(const char *folder, uint64_t seed, int figure, const paper_example *e,
                                  pinch_statics *statics)
{
    char stem[64], title[128], faces[32] = "";
    int n = figures[figure].faces;
    if (e->frictional) snprintf(faces, sizeof faces, "-%d-faces", n);
    snprintf(stem, sizeof stem, "example-%s%s", e->name, faces);
    snprintf(title, sizeof title, "Example %s%s%.0d%s: residual against iterations (Figure %d of the paper)", e->name,
             e->frictional ? ", " : "", e->frictional ? n : 0, e->frictional ? " faces" : "", figures[figure].figure);
    if (!write_curve(folder, stem, "nsngrk", e, paper_settings(n, PINCH_SOLVER_NSNGRK, seed), statics) ||
        !write_curve(folder, stem, "nsnmgk", e, paper_settings(n, PINCH_SOLVER_NSNMGK, seed), statics))
        return COMMAND_SYSTEM;
    if (draw(folder, stem, title, seed)) return COMMAND_DONE;
    gnuplot_complain(folder, stem);
    return COMMAND_SYSTEM;
}

command_status paper_plot(const char *folder, uint64_t seed, paper_example *examples, int count, pinch_statics *statics)
{
    if (gnuplot_folder(folder) != COMMAND_DONE) return COMMAND_SYSTEM;
    for (int i = 0; i < FIGURES; i++)
        for (int k = 0; k < count; k++) {
            if (strcmp(examples[k].name, figures[i].example) != 0) continue;
            command_status status = plot_figure(folder, seed, i, &examples[k], statics);
            if (status != COMMAND_DONE) return status;
        }
    return COMMAND_DONE;
}
