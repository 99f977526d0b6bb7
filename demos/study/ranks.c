/* Workers that are ranks of MPI. Rank 0 hands out and writes, the others compute. When one of them dies, MPI ends all
 * of them; what was committed is kept. */
#include "crew.h"
#include "mpi_link.h"

#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool crew_under_mpi(void)
{
    /* Open MPI, and the process managers of MPICH, Intel MPI and Slurm */
    static const char *const signs[] = {"OMPI_COMM_WORLD_SIZE", "PMIX_RANK", "PMI_RANK"};
    for (size_t i = 0; i < sizeof signs / sizeof *signs; i++)
        if (getenv(signs[i])) return true;
    return false;
}

static const mpi_link *mpi; /* NULL: not started */

bool crew_start_mpi(const char *module, int *rank, int *size, char *error, size_t room)
{
    /* global, because MPI loads parts of its own that look for its symbols */
    void *library = dlopen(module, RTLD_NOW | RTLD_GLOBAL);
    void *symbol = library ? dlsym(library, MPI_LINK_START) : NULL;
    mpi_link_start start;
    if (!symbol) {
        snprintf(error, room, "%s", dlerror());
        return false;
    }
    memcpy(&start, &symbol, sizeof start);
    mpi = start();
    if (!mpi) {
        snprintf(error, room, "MPI could not be started");
        return false;
    }
    *rank = mpi->rank;
    *size = mpi->size;
    return true;
}

void crew_leave_mpi(int status)
{
    if (!mpi) return;
    if (status == 0)
        mpi->finish();
    else
        mpi->abort(status);
}

bool crew_work_as_rank(crew_work work, void *context)
{
    for (;;) {
        int from;
        crew_order order;
        char *text = mpi->receive(3600.0, &from);
        if (!text) continue;
        bool good = crew_order_read(text, &order);
        free(text);
        if (!good || order.count == 0) return good;
        for (int i = 0; i < order.count; i++) {
            char *line = work(context, &order, order.first + i);
            if (!line || !mpi->send(0, line, strlen(line))) return false;
            free(line);
        }
    }
}

/* ---- Rank 0. ---- */

static bool hand_out(crew *c, int worker, const crew_order *order)
{
    (void)c;
    char text[CREW_ORDER_TEXT];
    int length = crew_order_write(order, text);
    return mpi->send(worker + 1, text, (size_t)length);
}

static crew_event wait_for(crew *c, double seconds)
{
    (void)c;
    int from;
    char *line = mpi->receive(seconds, &from);
    return line ? (crew_event){CREW_LINE, from - 1, line, 0} : (crew_event){.type = CREW_NOTHING};
}

static bool replace(crew *c, int worker)
{
    (void)c;
    (void)worker;
    return false;
}

/* At once is for crew_leave_mpi, when the results are closed. */
static void end(crew *c, bool at_once)
{
    const crew_order none = {.count = 0};
    for (int i = 0; i < c->size && !at_once; i++) (void)hand_out(c, i, &none);
}

void crew_of_ranks(crew *c)
{
    *c = (crew){mpi->size - 1, NULL, hand_out, wait_for, replace, end};
}
