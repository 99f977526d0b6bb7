#ifndef PINCH_STUDY_MPI_LINK_H
#define PINCH_STUDY_MPI_LINK_H

#include <stdbool.h>
#include <stddef.h>

/* Messages between the ranks of an MPI program. The module libpinch_mpi.so has the functions, and it alone is linked
 * with MPI, so that the command runs where there is none. It is loaded when the process was started by mpirun or srun.
 */
typedef struct mpi_link {
    int rank, size;
    bool (*send)(int to, const char *text, size_t length);
    /* The next message as a text, which the caller frees; NULL where none came within `seconds`. */
    char *(*receive)(double seconds, int *from);
    void (*finish)(void);      /* waits for all ranks */
    void (*abort)(int status); /* ends all ranks at once */
} mpi_link;

/* The module's only symbol, by which it is started: a function of this type. NULL after a failure. */
typedef const mpi_link *(*mpi_link_start)(void);
#define MPI_LINK_START "pinch_mpi_start"

#endif
