/*
 * Included before all else in the sources of a program that is built a second time, with the drop-in layer and a
 * referee (judged.c).
 */
#ifndef PINCH_PROGRAM_JUDGED_H
#define PINCH_PROGRAM_JUDGED_H

#include <ode/ode.h>

#include <pinch/ode_dropin.h>

int program_main(int argc, char **argv);
#define main program_main

#endif
