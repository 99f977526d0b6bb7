/* Pictures by gnuplot, which runs as a program of its own. */
#ifndef PINCH_BENCH_PLOTS_H
#define PINCH_BENCH_PLOTS_H

#include "common/command_status.h"

#include <stdbool.h>
#include <stdio.h>

/* The folder is there afterwards; COMMAND_SYSTEM, with a message, where it cannot be. */
command_status plots_folder(const char *folder);

/* folder/stem.dat, to be written; NULL, with a message, where it cannot be. */
FILE *plots_data(const char *folder, const char *stem);

/*
 * folder/stem.svg and .png: `settings` are gnuplot commands before the plot, a line each; `plots` what comes after
 * "plot", in which every "%s" stands for "folder/". False: gnuplot is missing or failed.
 */
bool plots_draw(const char *folder, const char *stem, const char *settings, const char *plots);

/* The message for that. */
void plots_complain(const char *folder, const char *stem);

#endif
