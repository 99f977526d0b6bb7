/* The module that is linked with MPI. */
#define _POSIX_C_SOURCE 200809L

#include "mpi_link.h"

#include <limits.h>
#include <mpi.h>
#include <stdlib.h>
#include <time.h>

enum { TAG = 1 };

static bool send_text(int to, const char *text, size_t length)
{
    return length <= INT_MAX && MPI_Send(text, (int)length, MPI_CHAR, to, TAG, MPI_COMM_WORLD) == MPI_SUCCESS;
}

/* Receiving as MPI does keeps a processor busy, which a rank that waits would take from one that computes. So it looks
 * and sleeps in turns. */
static char *receive_text(double seconds, int *from)
{
    const struct timespec nap = {0, 200000};
    double waited = 0.0;
    for (;; waited += 2e-4) {
        int there, length;
        MPI_Status status;
        if (MPI_Iprobe(MPI_ANY_SOURCE, TAG, MPI_COMM_WORLD, &there, &status) != MPI_SUCCESS) return NULL;
        if (there) {
            MPI_Get_count(&status, MPI_CHAR, &length);
            char *text = malloc((size_t)length + 1);
            if (!text) return NULL;
            MPI_Recv(text, length, MPI_CHAR, status.MPI_SOURCE, TAG, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
            text[length] = '\0';
            *from = status.MPI_SOURCE;
            return text;
        }
        if (waited >= seconds || nanosleep(&nap, NULL) != 0) return NULL;
    }
}

static void finish(void)
{
    MPI_Finalize();
}

static void abort_all(int status)
{
    MPI_Abort(MPI_COMM_WORLD, status);
}

__attribute__((visibility("default"))) const mpi_link *pinch_mpi_start(void);

const mpi_link *pinch_mpi_start(void)
{
    static mpi_link functions = {0, 0, send_text, receive_text, finish, abort_all};
    if (MPI_Init(NULL, NULL) != MPI_SUCCESS) return NULL;
    MPI_Comm_rank(MPI_COMM_WORLD, &functions.rank);
    MPI_Comm_size(MPI_COMM_WORLD, &functions.size);
    return &functions;
}
