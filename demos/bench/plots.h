/* Plots by gnuplot, which runs as a program of its own. */
#ifndef PINCH_BENCH_PLOTS_H
#define PINCH_BENCH_PLOTS_H

#include "common/command_status.h"

#include <stdbool.h>
#include <stdio.h>

/* Makes the folder where it is not there. COMMAND_SYSTEM, with a message, where that fails.
 * COMMAND_BAD_INPUT where the name has a line feed or the like, which gnuplot would take for the end of a command. */
command_status plots_folder(const char *folder);

/* Opens folder/stem.dat for writing. NULL, with a message, where that fails. */
FILE *plots_data(const char *folder, const char *stem);

/* Draws folder/stem.svg and .png. `settings` are gnuplot commands before the plot, a line each. `plots` is what comes
 * after "plot"; every "%s" in it stands for "folder/". Returns false where gnuplot is missing or failed. */
bool plots_draw(const char *folder, const char *stem, const char *settings, const char *plots);

/* Prints the message for that case. */
void plots_complain(const char *folder, const char *stem);

#endif
