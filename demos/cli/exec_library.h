#ifndef PINCH_EXEC_LIBRARY_H
#define PINCH_EXEC_LIBRARY_H

#include "command.h"

/*
 * Finds the library that `pinch exec` loads before a program's others, and tries it: a loader that cannot take it says
 * so and runs the program without. COMMAND_SYSTEM: there is none, or it cannot be loaded; the reason is on standard
 * error.
 */
command_status exec_find_library(char *path, size_t size);

#endif
