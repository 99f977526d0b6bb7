#ifndef PINCH_STUDY_CREW_H
#define PINCH_STUDY_CREW_H

#include <stdbool.h>
#include <stddef.h>

/* Those who compute trials: processes of this machine, or ranks of MPI. They are handed batches of trials and answer
 * with a line of JSON for each. */

typedef struct crew crew;

/* Trials that follow each other, and what is to be done with them. The numbers are the work's own. */
typedef struct crew_order {
    long first;
    int count; /* >= 1 */
    int kind;
    double value;
} crew_order;

typedef enum crew_event_type {
    CREW_NOTHING = 0, /* the time is over, or a signal came */
    CREW_LINE,        /* a trial's answer */
    CREW_LOST         /* the worker ended; what it had been handed and not answered is not done */
} crew_event_type;

typedef struct crew_event {
    crew_event_type type;
    int worker;
    char *line; /* CREW_LINE: the caller frees it */
    int signal; /* CREW_LOST: that ended it; 0: none */
} crew_event;

struct crew {
    int size; /* workers, >= 1 */
    void *state;
    /* Hands the order to the worker. Returns false where it cannot be reached. */
    bool (*hand_out)(crew *c, int worker, const crew_order *order);
    crew_event (*wait)(crew *c, double seconds);
    /* Replaces a lost worker. Returns false where that is not possible. */
    bool (*replace)(crew *c, int worker);
    /* Ends all workers: after what they are doing, or at once. */
    void (*end)(crew *c, bool at_once);
};

/* The work of one trial of an order: the answer as a text without line breaks, which the caller frees. NULL: no memory.
 */
typedef char *(*crew_work)(void *context, const crew_order *order, long index);

/* An order as a line, and back. */
enum { CREW_ORDER_TEXT = 128 };
int crew_order_write(const crew_order *order, char text[CREW_ORDER_TEXT]); /* its length */
bool crew_order_read(const char *text, crew_order *order);

/* processes.c: `size` processes, each with its own copy of this one's memory. Returns false where none could be
 * started.
 */
bool crew_of_processes(crew *c, int size, crew_work work, void *context);

/* ranks.c */

/* Was this process started by mpirun, srun or the like? */
bool crew_under_mpi(void);
/* Loads the module that is linked with MPI, and starts it. Returns false, with a reason in `error`, where that fails.
 */
bool crew_start_mpi(const char *module, int *rank, int *size, char *error, size_t room);
/* Leaves MPI, where it was started: with status 0 when all ranks have come to their ends, otherwise at once. */
void crew_leave_mpi(int status);
/* In all ranks but 0: works off orders until rank 0 ends it. Returns false after a failure. */
bool crew_work_as_rank(crew_work work, void *context);
/* In rank 0: the others as a crew. There must be at least two ranks. */
void crew_of_ranks(crew *c);

#endif
