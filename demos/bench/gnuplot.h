/* Pictures by gnuplot, which runs as a program of its own. */
#ifndef PINCH_BENCH_GNUPLOT_H
#define PINCH_BENCH_GNUPLOT_H

#include "cli/command.h"

#include <stdio.h>

/* The folder is there afterwards; COMMAND_SYSTEM, with a message, where it cannot be. */
command_status gnuplot_folder(const char *folder);

/* folder/stem.dat, to be written; NULL, with a message, where it cannot be. */
FILE *gnuplot_data(const char *folder, const char *stem);

/*
 * folder/stem.svg and .png: `settings` are gnuplot commands before the plot, a line each; `plots` what comes after
 * "plot", in which every "%s" stands for "folder/". False: gnuplot is missing or failed.
 */
bool gnuplot_draw(const char *folder, const char *stem, const char *settings, const char *plots);

/* The message for that. */
void gnuplot_complain(const char *folder, const char *stem);

#endif
