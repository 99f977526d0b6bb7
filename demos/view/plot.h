#ifndef PINCH_VIEW_PLOT_H
#define PINCH_VIEW_PLOT_H

#include "common/command_status.h"

#include <stdbool.h>
#include <stddef.h>

/* Curves on one pair of axes, as SVG and PNG in the colours of the pages. Labels stand at the curves' ends, and powers
 * of ten are written as such. */

enum { PLOT_MOST_LINES = 8 };

typedef struct plot_line {
    const char *label;
    size_t count;
    const double *x, *y; /* a value that is no number, or not above zero on a logarithmic axis, breaks the curve */
    bool dashed;
    bool marked; /* are its points shown? */
} plot_line;

typedef struct plot {
    const char *title, *x_label, *y_label;
    bool log_x, log_y;
    int count;
    plot_line lines[PLOT_MOST_LINES];
} plot;

/* Makes the folder where it is not there. COMMAND_SYSTEM where that fails, COMMAND_BAD_INPUT for control characters in
 * the name; each with a message of the command. */
command_status plot_folder(const char *command, const char *folder);

/* Writes folder/stem.svg, .png, and the numbers as .dat: for each curve its points, and two empty lines. Returns
 * COMMAND_SYSTEM, with a message, where a file could not be written. */
command_status plot_write(const char *command, const char *folder, const char *stem, const plot *p);

#endif
