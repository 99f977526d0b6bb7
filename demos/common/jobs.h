#ifndef PINCH_COMPARE_JOBS_H
#define PINCH_COMPARE_JOBS_H

#include "command_status.h"

#include <jansson.h>
#include <stdbool.h>

/* Pieces of work in processes of their own, so many at a time: what one of them does to memory, random numbers or ODE's
 * globals, or a crash, is nothing to the others, and the results do not depend on how many run at once. */

typedef struct job_result {
    command_status status;
    json_t *document; /* NULL: none */
    char *messages;   /* what the process wrote to standard error; NULL: nothing */
} job_result;

typedef struct job_list {
    int count, at_a_time;
    command_status (*work)(void *context, int index, json_t **document); /* in the process of its own */
    const char *(*name)(void *context, int index);                       /* for the progress bar and messages */
    void *context;
    bool progress; /* a bar on standard error */
} job_list;

/* results: list->count of them, in order. false: no process could be started or followed; the reason is in errno. */
bool jobs_run(const job_list *list, job_result *results);
void jobs_free(job_result *results, int count);

/* One for each processor that there is. */
int jobs_default(void);

#endif
