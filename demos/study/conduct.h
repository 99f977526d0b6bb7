#ifndef PINCH_STUDY_CONDUCT_H
#define PINCH_STUDY_CONDUCT_H

#include "crew.h"
#include "results.h"

/* Hands the trials that are missing in the results out to the crew, and writes their answers, until all are there, the
 * limit is reached, or a signal comes. */

/* How a call went. */
typedef struct conduct_run {
    int workers;
    long trials;    /* that were answered */
    double elapsed; /* s, from the first order to the last answer */
    double busy;    /* the part of it that the workers spent in trials, 0 to 1, mean over them */
} conduct_run;

typedef struct conduct_settings {
    long limit;    /* most trials of this call; LONG_MAX: no limit */
    bool progress; /* on standard error */
    /* Orders that are worked off instead of the missing trials; NULL: none */
    const crew_order *list;
    size_t list_count;
    conduct_run *run; /* set at the end; NULL: not wanted */
} conduct_settings;

/* The kind of an order: trials of the study, or see beside_refine. */
enum { CONDUCT_TRIALS = 0 };

/* The work of a crew for a study, which is the context. */
char *conduct_work(void *s, const crew_order *order, long index);

/* COMMAND_DONE also where the limit ended it; COMMAND_INTERRUPTED + N after signal N; otherwise error->text says what
 * went wrong. What was answered is committed in any case, as far as it can be written. */
command_status conduct(const study *s, results *r, crew *c, const conduct_settings *settings, results_error *error);

#endif
