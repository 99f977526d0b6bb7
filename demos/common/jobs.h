#ifndef PINCH_COMPARE_JOBS_H
#define PINCH_COMPARE_JOBS_H

#include "command_status.h"

#include <jansson.h>
#include <stdbool.h>

/* Pieces of work in processes of their own, several at a time. A piece cannot disturb another one through memory,
 * random numbers, ODE's globals or a crash, and the results do not depend on how many run at once. */

typedef struct job_result {
    command_status status;
    json_t *document; /* NULL: none */
    char *messages;   /* what the process wrote to standard error; NULL: nothing */
} job_result;

typedef struct job_list {
    int count, at_a_time;
    command_status (*work)(void *context, int index, json_t **document); /* runs in the child */
    const char *(*name)(void *context, int index);                       /* for the progress bar and messages */
    void *context;
    bool progress; /* show a bar on standard error */
} job_list;

/* `results` has room for list->count results and gets them in order. Returns false when no process could be started or
 * followed; the reason is in errno. */
bool jobs_run(const job_list *list, job_result *results);
void jobs_free(job_result *results, int count);

/* The number of processors. */
int jobs_default(void);

#endif
