#ifndef PINCH_EXEC_LAUNCH_H
#define PINCH_EXEC_LAUNCH_H

#include "command.h"

/*
 * Becomes the program arguments[0], with the preloaded library before its others; returns only where that fails, with
 * the reason on standard error and the status to exit with (126, 127, 2 or 3). stats: a file name, "-" for standard
 * error, NULL for none. The file is there before the program runs, with no steps in it, so that a program that Pinch
 * does not reach leaves it behind as well.
 */
command_status exec_launch(const char *stats, char **arguments, int count);

#endif
