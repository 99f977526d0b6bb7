/* The module that is linked with MPI. */
#define _POSIX_C_SOURCE 200809L

#include "mpi_link.h"

#include <limits.h>
#include <mpi.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { TAG = 1, MOST_UNDER_WAY = 64 };

/* Texts on their way, those that were sent first at the front. */
static struct {
    char *text;
    MPI_Request request;
} under_way[MOST_UNDER_WAY];
static int under_way_count;

/* Lets go of the texts that have arrived; first waits for that of the oldest `wait` ones. */
static bool let_go(int wait)
{
    bool good = true;
    int left = 0;
    for (int i = 0; i < under_way_count; i++) {
        int arrived = 1;
        if (i < wait)
            good = MPI_Wait(&under_way[i].request, MPI_STATUS_IGNORE) == MPI_SUCCESS && good;
        else
            good = MPI_Test(&under_way[i].request, &arrived, MPI_STATUS_IGNORE) == MPI_SUCCESS && good;
        if (arrived)
            free(under_way[i].text);
        else
            under_way[left++] = under_way[i];
    }
    under_way_count = left;
    return good;
}

/* A long text is not taken before the receiver looks, and waiting for that would take a processor from a trial. So the
 * sender computes on meanwhile, until many are on their way.
 */
static bool send_text(int to, const char *text, size_t length)
{
    if (!let_go(under_way_count == MOST_UNDER_WAY ? 1 : 0) || length > INT_MAX) return false;
    char *sent = malloc(length + 1);
    if (!sent) return false;
    memcpy(sent, text, length);
    under_way[under_way_count].text = sent;
    if (MPI_Isend(sent, (int)length, MPI_CHAR, to, TAG, MPI_COMM_WORLD, &under_way[under_way_count].request) !=
        MPI_SUCCESS) {
        free(sent);
        return false;
    }
    under_way_count++;
    return true;
}

/* Receiving as MPI does keeps a processor busy, which a rank that waits would take from one that computes. So it looks
 * and sleeps in turns. A look costs some 30 us with what the system does to wake a process, and as much again to the
 * process that it drives from its processor; the nap keeps that below 0.3 % of a processor, and is short beside the
 * batches that lie ready with those who compute.
 */
static char *receive_text(double seconds, int *from)
{
    const struct timespec nap = {0, 20000000};
    double waited = 0.0;
    for (;; waited += 1e-9 * (double)nap.tv_nsec) {
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
    (void)let_go(under_way_count);
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
