#ifndef PINCH_RUN_H
#define PINCH_RUN_H

#include "command.h"
#include "scenes/world/simulation.h"

/* How `pinch run` presents a finished run. */

/* "converged" when every step was solved and verified, in one way or another; otherwise how it failed. */
pinch_solve_status run_status(const world *w);

/* The JSON document of interfaces.md, section 3. false: no memory. */
bool run_print_json(const world *w, const simulation_result *r, FILE *stream);

/* The table a person reads. */
void run_print_table(const world *w, const simulation_result *r, FILE *stream);

/* The header line, and a row for the step just done. */
void run_csv_header(const world *w, FILE *stream);
void run_csv_row(const world *w, FILE *stream);

/* What the finger's tip has left of its friction: 1 - |r_t| / (mu r_n) with the torsional part; NAN where undefined. */
double run_slip_margin(const world_finger *finger);

#endif
