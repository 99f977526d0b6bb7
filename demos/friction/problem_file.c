#define _POSIX_C_SOURCE 200809L

#include "problem_file.h"

#include "common/input_file.h"
#include "common/own_place.h"
#include "common/pipe.h"
#include "fclib_link.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#define MODULE "libpinch_fclib.so"

/* A process that reads a file may take this many seconds of a processor; the largest files of the collection take one.
 */
enum { MOST_SECONDS = 60 };
/* Above these sizes the collection has nothing, and memory would not do for what is made of them. */
enum { MOST_CONTACTS = 200000, MOST_FREEDOMS = 2000000, MOST_ENTRIES = 100000000 };

/* How the process ends that reads the file. */
enum { READER_SENT, READER_FAILED, READER_NO_MEMORY, READER_NO_LIBRARY };

/* FCLIB and HDF5 do not say why they fail. The last error of the C library does, where it was memory: they ask the
 * system for nothing afterwards that could fail. */
static int reason_to_fail(void)
{
    return errno == ENOMEM ? READER_NO_MEMORY : READER_FAILED;
}

static void end_by_exit(void)
{
    _exit(reason_to_fail());
}

static void end_by_signal(int number)
{
    (void)number;
    _exit(reason_to_fail());
}

/* FCLIB ends the process or crashes on files that are broken, and HDF5 writes to standard error: it works in a process
 * of its own, which nobody hears. */
static _Noreturn void read_and_send(const char *module, const char *path, int to)
{
    static const int crashes[] = {SIGSEGV, SIGBUS, SIGFPE, SIGABRT, SIGILL};
    struct rlimit limit = {MOST_SECONDS, MOST_SECONDS};
    setrlimit(RLIMIT_CPU, &limit);
    int nowhere = open("/dev/null", O_RDWR);
    for (int i = 0; i < 3 && nowhere >= 0; i++) dup2(nowhere, i);
    for (size_t i = 0; i < sizeof crashes / sizeof *crashes; i++) signal(crashes[i], end_by_signal);
    if (atexit(end_by_exit) != 0) _exit(READER_NO_MEMORY);
    void *library = dlopen(module, RTLD_NOW | RTLD_LOCAL), *symbol = library ? dlsym(library, FCLIB_SEND) : NULL;
    fclib_send send_file;
    if (!symbol) _exit(errno == ENOMEM ? READER_NO_MEMORY : READER_NO_LIBRARY);
    memcpy(&send_file, &symbol, sizeof send_file);
    errno = 0;
    _exit(send_file(path, to) ? READER_SENT : reason_to_fail());
}

static bool sizes_fit(const fclib_head *h)
{
    if (h->dimension < 2 || h->dimension > 3 || h->contacts < 0 || h->contacts > MOST_CONTACTS) return false;
    if (h->w_count < 0 || h->w_count > MOST_ENTRIES || h->h_count < 0 || h->h_count > MOST_ENTRIES) return false;
    int rows = h->contacts * h->dimension;
    if (!h->global) return h->w_size == rows && h->freedoms == 0 && h->h_count == 0;
    return h->freedoms > 0 && h->freedoms <= MOST_FREEDOMS && h->w_size == h->freedoms && h->h_rows == h->freedoms &&
           h->h_columns == rows;
}

static bool entries_fit(const friction_matrix *m)
{
    for (size_t k = 0; k < m->count; k++) {
        const friction_entry *e = &m->entries[k];
        if (e->row < 0 || e->row >= m->rows || e->column < 0 || e->column >= m->columns || !isfinite(e->value))
            return false;
    }
    return true;
}

static bool numbers_fit(const double *x, int count, double least)
{
    for (int i = 0; i < count; i++)
        if (!isfinite(x[i]) || !(x[i] >= least)) return false;
    return true;
}

static double *receive_numbers(int from, int count, bool *all)
{
    double *x = malloc(sizeof *x * ((size_t)count + 1));
    if (x) *all = *all && pipe_receive(from, x, sizeof *x * (size_t)count);
    return x;
}

static bool receive_matrix(int from, int rows, int columns, int count, friction_matrix *m, bool *all)
{
    *m = (friction_matrix){rows, columns, (size_t)count, malloc(sizeof *m->entries * ((size_t)count + 1))};
    if (!m->entries) return false;
    *all = *all && pipe_receive(from, m->entries, sizeof *m->entries * m->count);
    return true;
}

static command_status receive_file(int from, friction_file *f, char *error)
{
    fclib_head h;
    bool all = true;
    snprintf(error, 512, "expected a file of FCLIB, but its library fails on it");
    if (!pipe_receive(from, &h, sizeof h)) return COMMAND_BAD_INPUT;
    if (h.error[0]) {
        snprintf(error, 512, "%.127s", h.error);
        return COMMAND_BAD_INPUT;
    }
    snprintf(error, 512, "expected matrices and vectors whose sizes agree, at most %d contacts", MOST_CONTACTS);
    if (!sizes_fit(&h)) return COMMAND_BAD_INPUT;
    int rows = h.contacts * h.dimension;
    f->global = h.global;
    f->dimension = h.dimension;
    f->contacts = h.contacts;
    f->freedoms = h.freedoms;
    bool room = receive_matrix(from, h.w_size, h.w_size, h.w_count, &f->w, &all);
    if (room && h.global) room = receive_matrix(from, h.freedoms, rows, h.h_count, &f->h, &all);
    if (room) room = (f->free = receive_numbers(from, rows, &all)) != NULL;
    if (room && h.global) room = (f->force = receive_numbers(from, h.freedoms, &all)) != NULL;
    if (room) room = (f->coefficients = receive_numbers(from, h.contacts, &all)) != NULL;
    if (!room) {
        snprintf(error, 512, "out of memory");
        return COMMAND_SYSTEM;
    }
    snprintf(error, 512, "expected finite numbers, entries inside their matrices, and friction of at least 0");
    return all && entries_fit(&f->w) && entries_fit(&f->h) && numbers_fit(f->free, rows, -INFINITY) &&
                   numbers_fit(f->force, h.freedoms, -INFINITY) && numbers_fit(f->coefficients, h.contacts, 0)
               ? COMMAND_DONE
               : COMMAND_BAD_INPUT;
}

static command_status read_apart(const char *module, const char *path, friction_file *file, char *error)
{
    int ends[2];
    snprintf(error, 512, "no process to read it in: %s", strerror(errno));
    if (pipe(ends) != 0) return COMMAND_SYSTEM;
    pid_t child = fork();
    if (child == 0) {
        close(ends[0]);
        read_and_send(module, path, ends[1]);
    }
    close(ends[1]);
    command_status status = child < 0 ? COMMAND_SYSTEM : receive_file(ends[0], file, error);
    close(ends[0]);
    int end = 0;
    while (child > 0 && waitpid(child, &end, 0) < 0 && errno == EINTR) continue;
    if (status != COMMAND_BAD_INPUT || !WIFEXITED(end)) return status;
    if (WEXITSTATUS(end) == READER_NO_MEMORY)
        snprintf(error, 512, "out of memory, or the file asks for more than there is");
    if (WEXITSTATUS(end) == READER_NO_LIBRARY) snprintf(error, 512, MODULE " cannot be loaded");
    return WEXITSTATUS(end) == READER_NO_MEMORY || WEXITSTATUS(end) == READER_NO_LIBRARY ? COMMAND_SYSTEM : status;
}

command_status friction_file_read(const char *path, friction_file *file, char *error)
{
    static const char *const places[] = {MODULE, PINCH_LIBRARY_FROM_COMMAND "/" MODULE, NULL};
    char module[4096], fault[128];
    memset(file, 0, sizeof *file);
    if (!own_place_find(places, module, sizeof module)) {
        snprintf(error, 512,
                 "this pinch was built without FCLIB (" MODULE " is missing); install libfclib-dev and build again");
        return COMMAND_SYSTEM;
    }
    FILE *stream = input_open_regular(path, fault);
    if (!stream) {
        snprintf(error, 512, "%s", *fault ? fault : "out of memory");
        return *fault ? COMMAND_BAD_INPUT : COMMAND_SYSTEM;
    }
    fclose(stream);
    command_status status = read_apart(module, path, file, error);
    if (status != COMMAND_DONE) friction_file_free(file);
    return status;
}

void friction_file_free(friction_file *file)
{
    free(file->w.entries);
    free(file->h.entries);
    free(file->free);
    free(file->force);
    free(file->coefficients);
    memset(file, 0, sizeof *file);
}
