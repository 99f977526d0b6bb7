#define _GNU_SOURCE /* O_CLOEXEC and pthread_atfork, on any C library */

#include "preload/report.h"

#include "dropin/layer.h"
#include "preload/end_by_signal.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <time.h>
#include <unistd.h>

enum { MOST_TEXT = 8192, MOST_PATH = 4096 };

static char path[MOST_PATH]; /* empty: nobody asked */
static bool to_stream, original;
static pthread_mutex_t writing = PTHREAD_MUTEX_INITIALIZER;

static bool read_number(const char *name, double *value)
{
    const char *text = getenv(name);
    if (!text) return false;
    char *end;
    double number = strtod(text, &end);
    if (end == text || *end || !isfinite(number)) return false;
    *value = number;
    return true;
}

static void read_settings(pinch_ode_settings *settings)
{
    static const char *const scopes[] = {"all", "soft", "material"};
    static pinch_ode_record_folder folder;
    double number;
    const char *scope = getenv(PINCH_ENV_SCOPE), *solver = getenv(PINCH_ENV_SOLVER);
    for (int i = 0; scope && i < 3; i++)
        if (strcmp(scope, scopes[i]) == 0) settings->scope = (pinch_ode_scope)i;
    if (solver) (void)pinch_solver_from_name(solver, &settings->solver.solver);
    if (read_number(PINCH_ENV_RATIO, &number)) settings->tangential_ratio = number;
    if (read_number(PINCH_ENV_TOLERANCE, &number)) settings->solver.tolerance = number;
    if (read_number(PINCH_ENV_MAX_ITERATIONS, &number) && number >= 1 && number <= 1e9)
        settings->solver.max_iterations = (int)number;
    if (settings->solver.goal > settings->solver.tolerance) settings->solver.goal = settings->solver.tolerance;
    folder.path = getenv(PINCH_ENV_RECORD);
    if (!folder.path || !(folder.path = strdup(folder.path))) return; /* the program may change its environment */
    folder.most = read_number(PINCH_ENV_RECORD_MOST, &number) && number >= 0 && number <= 1e6 ? (int)number : 0;
    settings->recorder = pinch_ode_record_into_folder;
    settings->recorder_context = &folder;
    settings->record_all = getenv(PINCH_ENV_RECORD_ALL) != NULL;
}

/* A forked child reports what it does itself, if it does anything. */
static void in_child(void)
{
    original = false;
    (void)pthread_mutex_init(&writing, NULL);
    pinch_dropin_reset_statistics();
}

void pinch_report_start(void)
{
    pinch_ode_settings settings = pinch_ode_default_settings();
    read_settings(&settings);
    (void)pinch_layer_plain_numbers();
    (void)pinch_dropin_set_settings(&settings); /* the layer's handlers of a fork come before this one's */
    (void)pthread_atfork(NULL, NULL, in_child);

    const char *file = getenv(PINCH_ENV_STATS), *process = getenv(PINCH_ENV_PROCESS);
    if (!file || strlen(file) >= sizeof path) return;
    strcpy(path, file);
    to_stream = strcmp(path, "-") == 0;
    original = process && strtol(process, NULL, 10) == (long)getpid();
}

static bool write_whole(int stream, const char *text, size_t length)
{
    while (length > 0) {
        ssize_t n = write(stream, text, length);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        text += n;
        length -= (size_t)n;
    }
    return true;
}

static void say(const char *text)
{
    (void)write_whole(STDERR_FILENO, text, strlen(text));
}

/* Makes a file that nobody can have put in place of this one: its name cannot be guessed, and it is new. */
static int open_beside(char *name, size_t size)
{
    uint64_t number;
    if (getrandom(&number, sizeof number, 0) != (ssize_t)sizeof number) return -1;
    snprintf(name, size, "%s.%016llx", path, (unsigned long long)number);
    return open(name, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
}

/* Replaces the file as a whole: writes it under another name first. */
static bool replace_file(const char *text)
{
    char temporary[MOST_PATH + 32];
    int stream = open_beside(temporary, sizeof temporary);
    if (stream < 0) return false;
    bool good = write_whole(stream, text, strlen(text));
    good = close(stream) == 0 && good && rename(temporary, path) == 0;
    if (!good) (void)unlink(temporary);
    return good;
}

static bool write_report(const pinch_dropin_stats *stats, const pinch_ode_settings *settings)
{
    char text[MOST_TEXT];
    int length = pinch_layer_write_statistics(stats, settings, text, sizeof text);
    if (length <= 0 || length >= MOST_TEXT) return false;
    return to_stream ? write_whole(STDERR_FILENO, text, (size_t)length) : replace_file(text);
}

void pinch_report_now(void)
{
    if (!*path || to_stream || pthread_mutex_trylock(&writing) != 0) return;
    int error = errno;
    pinch_dropin_stats stats = pinch_dropin_statistics();
    pinch_ode_settings settings = pinch_dropin_settings();
    if (stats.steps > 0) (void)write_report(&stats, &settings);
    errno = error;
    pthread_mutex_unlock(&writing);
}

/* In the handler of a signal. Where the layer is at work just then, the file from the last second stays. */
static void report_before_the_end(void)
{
    pinch_dropin_stats stats;
    pinch_ode_settings settings;
    if (pinch_layer_statistics_now(&stats, &settings) && stats.steps > 0) (void)write_report(&stats, &settings);
}

/* Programs set their handlers before they begin to step, and ask then what the handlers were: it is too early before
 * the first step. */
static void watch_signals(void)
{
    pinch_end_by_signal(report_before_the_end);
}

void pinch_report_sometimes(void)
{
    static pthread_once_t first = PTHREAD_ONCE_INIT;
    static atomic_long last = -1;
    struct timespec now;
    if (!*path) return;
    (void)pthread_once(&first, watch_signals);
    long before = atomic_load_explicit(&last, memory_order_relaxed);
    if (clock_gettime(CLOCK_MONOTONIC, &now) != 0 || (long)now.tv_sec == before) return;
    if (atomic_compare_exchange_strong(&last, &before, (long)now.tv_sec)) pinch_report_now();
}

void pinch_report_backoff(long step)
{
    enum { MOST_LINES = 10 }; /* there are programs with thousands of worlds */
    static atomic_int lines;
    char text[256];
    if (atomic_fetch_add_explicit(&lines, 1, memory_order_relaxed) >= MOST_LINES) return;
    snprintf(
        text, sizeof text,
        "pinch exec: in step %ld of a world, bodies were left to ODE for a while, because Pinch could not solve them "
        "well, or not fast enough\n",
        step);
    say(text);
}

/* Tells whether a child of this process has written the file. `pinch exec` has put one there that counts no step. */
static bool somebody_stepped(void)
{
    char text[MOST_TEXT];
    int stream = open(path, O_RDONLY | O_CLOEXEC);
    if (stream < 0) return false;
    ssize_t n = read(stream, text, sizeof text - 1);
    close(stream);
    text[n > 0 ? n : 0] = '\0';
    return n > 0 && !strstr(text, "\"steps\": 0,");
}

static const double MUCH = 0.05; /* of all */

/* Whoever runs a program with Pinch wants to know where it was ODE that solved it. Without Newton's steps a solver
 * leaves it every contact, whatever the contact is like. */
static void say_what_fell_back(const pinch_dropin_stats *stats, const pinch_ode_settings *settings)
{
    double left = (double)stats->ode.contacts_left_unsolved + (double)stats->ode.contacts_left_unsupported +
                  (double)stats->contacts_refused + (double)stats->contacts_unrecorded;
    double solved = (double)stats->ode.contacts_solved;
    char text[256];
    if (!(left > MUCH * (left + solved))) return;
    int length = snprintf(text, sizeof text, "pinch exec: ODE solved %.0f %% of the contacts, because ",
                          100 * left / (left + solved));
    if (pinch_solver_takes_newton_steps(&settings->solver))
        snprintf(text + length, sizeof text - (size_t)length, "Pinch could not\n");
    else
        snprintf(text + length, sizeof text - (size_t)length, "the solver %s solves none (--solver)\n",
                 pinch_solver_name(settings->solver.solver));
    say(text);
}

/* And where answers are not what they should be. */
static void say_what_did_not_converge(const pinch_dropin_stats *stats)
{
    double part = (double)stats->ode.unconverged_steps / (double)stats->ode.steps;
    char text[256];
    if (!(part > MUCH)) return;
    snprintf(text, sizeof text,
             "pinch exec: %.0f %% of the steps did not converge: contacts were softer than prescribed, left to ODE, or "
             "not verified (--stats tells)\n",
             100 * part);
    say(text);
}

void pinch_report_end(void)
{
    pinch_dropin_stats stats = pinch_dropin_statistics();
    pinch_ode_settings settings = pinch_dropin_settings();
    bool stepped = stats.steps > 0;
    if (stepped) say_what_fell_back(&stats, &settings);
    if (stepped) say_what_did_not_converge(&stats);
    if (!*path || (!stepped && !original)) return;
    bool written = (!to_stream && !stepped) || write_report(&stats, &settings);
    if (!stepped && (to_stream || !somebody_stepped()))
        say("pinch exec: no ODE world was stepped by Pinch in this process\n");
    if (stepped && !to_stream && !written) say("pinch exec: the statistics could not be written\n");
}
