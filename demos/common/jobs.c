#define _DEFAULT_SOURCE /* MAP_ANONYMOUS */
#define _POSIX_C_SOURCE 200809L

#include "jobs.h"
#include "process.h"
#include "progress.h"
#include "terminal.h"

#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* A process that is running, and the files that it writes to. Files do not fill up as pipes do. */
typedef struct job {
    pid_t process; /* 0: no process */
    int index;
    FILE *document, *messages;
} job;

int jobs_default(void)
{
    long processors = sysconf(_SC_NPROCESSORS_ONLN);
    return processors > 0 ? (int)processors : 1;
}

/* Runs in the child and never returns. */
static void do_work(const job_list *list, const job *j, job_share *share, pid_t parent)
{
    json_t *document = NULL;
    process_follow_parent(parent);
    if (dup2(fileno(j->messages), STDERR_FILENO) < 0) _exit(COMMAND_SYSTEM);
    command_status status = list->work(list->context, j->index, share, &document);
    if (document &&
        (json_dumpf(document, j->document, JSON_COMPACT | JSON_REAL_PRECISION(17)) != 0 || fflush(j->document) != 0)) {
        terminal_print(stderr, "pinch: %s: the result cannot be written\n", list->name(list->context, j->index));
        status = COMMAND_SYSTEM;
    }
    fflush(stderr);
    _exit((int)status);
}

static bool start(const job_list *list, job *j, job_share *share, int index)
{
    j->index = index;
    j->document = tmpfile();
    j->messages = tmpfile();
    pid_t parent = getpid();
    fflush(NULL); /* what is buffered would be written twice */
    j->process = j->document && j->messages ? fork() : -1;
    if (j->process == 0) do_work(list, j, share, parent);
    if (j->process > 0) return true;
    int error = errno;
    if (j->document) fclose(j->document);
    if (j->messages) fclose(j->messages);
    j->process = 0;
    errno = error;
    return false;
}

static char *text_of(FILE *stream)
{
    long length = fseek(stream, 0, SEEK_END) == 0 ? ftell(stream) : -1;
    char *text = length > 0 ? malloc((size_t)length + 1) : NULL;
    if (!text) return NULL;
    rewind(stream);
    text[fread(text, 1, (size_t)length, stream)] = '\0';
    return text;
}

/* Appends "pinch: NAME: what" to the messages. */
static void add_message(const job_list *list, int index, const char *what, char **messages)
{
    char *more = NULL;
    size_t size;
    FILE *stream = open_memstream(&more, &size);
    if (!stream) return;
    if (*messages) fputs(*messages, stream);
    terminal_print(stream, "pinch: %s: %s\n", list->name(list->context, index), what);
    if (fclose(stream) == 0) {
        free(*messages);
        *messages = more;
    } else {
        free(more);
    }
}

/* A job that ended well has a document. Without one it has failed, whatever its exit status says. */
static void finish(const job_list *list, job *j, int ended, job_result *results)
{
    char what[64];
    job_result *r = &results[j->index];
    r->messages = text_of(j->messages);
    r->status = WIFEXITED(ended) ? (command_status)WEXITSTATUS(ended) : COMMAND_SYSTEM;
    rewind(j->document);
    r->document = json_loadf(j->document, 0, NULL); /* an empty file gives NULL */
    if (WIFSIGNALED(ended) && process_interrupted()) {
        r->status = COMMAND_SYSTEM; /* mark_interrupted says why */
    } else if (WIFSIGNALED(ended)) {
        snprintf(what, sizeof what, "the process ended by signal %d", WTERMSIG(ended));
        add_message(list, j->index, what, &r->messages);
    } else if (!r->document && (r->status == COMMAND_DONE || !r->messages)) {
        if (r->status == COMMAND_DONE) r->status = COMMAND_SYSTEM;
        add_message(list, j->index, "the process ended without a result", &r->messages);
    }
    fclose(j->document);
    fclose(j->messages);
    j->process = 0;
}

/* ---- How far the work has come. ---- */

void job_share_start(job_share *share, long all, double step)
{
    share->step = step;
    share->all = all;
}

void job_share_step(job_share *share)
{
    share->done++;
}

/* A job that has not begun counts as much as the mean of those that have. One that has ended is done, even where it
 * gave up early. */
static void show_progress(const job_list *list, const job_share *shares, const job_result *results, int done,
                          progress *line)
{
    char what[160];
    int known = 0;
    double steps = 0, all = 0, time = 0, duration = 0;
    if (!progress_is_due(line)) return;
    for (int i = 0; i < list->count; i++) {
        const job_share *s = &shares[i];
        bool ended = results[i].document || results[i].messages;
        if (s->all == 0) continue;
        known++;
        steps += (double)(ended ? s->all : s->done);
        all += (double)s->all;
        time += s->step * (double)(ended ? s->all : s->done);
        duration += s->step * (double)s->all;
    }
    if (known == 0) return;
    double others = (double)list->count / known;
    snprintf(what, sizeof what, "%d of %d scenes, %.0f of %s%.0f steps, %.4g s of %s%.4g s simulated", done,
             list->count, steps, known < list->count ? "about " : "", all * others, time,
             known < list->count ? "about " : "", duration * others);
    progress_tell(line, what, steps / (all * others));
}

static job *place_of(const job_list *list, job *places, pid_t process)
{
    for (int i = 0; i < list->at_a_time; i++)
        if (places[i].process == process) return &places[i];
    return NULL;
}

/* Ends all processes that are running. */
static void stop_all(const job_list *list, const job *places)
{
    for (int i = 0; i < list->at_a_time; i++)
        if (places[i].process > 0) kill(places[i].process, SIGKILL);
}

/* Waits until one of the processes ends, or for a moment where a line is shown meanwhile. A process of another origin,
 * which whoever started this program left as its child, is passed over. A signal that was kept ends all jobs, and they
 * are waited for as usual. Returns false where waiting failed; *place is NULL where none has ended yet. */
static bool wait_for_one(const job_list *list, job *places, bool shown, int *ended, job **place)
{
    *place = NULL;
    while (!*place) {
        if (process_interrupted()) stop_all(list, places);
        pid_t process = waitpid(-1, ended, shown ? WNOHANG : 0);
        if (process < 0 && errno != EINTR) return false;
        *place = process > 0 ? place_of(list, places, process) : NULL;
        if (process == 0) {
            nanosleep(&(struct timespec){.tv_nsec = 20 * 1000 * 1000}, NULL);
            return true;
        }
    }
    return true;
}

/* A job that the signal kept from ending has no answer. */
static void mark_interrupted(const job_list *list, job_result *results)
{
    for (int i = 0; i < list->count; i++)
        if (!results[i].document) results[i].status = (command_status)(COMMAND_INTERRUPTED + process_interrupted());
}

/* The jobs that run, and what is known of all. */
typedef struct desk {
    job *places; /* list->at_a_time */
    job_share *shares;
    int next, running, done;
    progress line;
} desk;

/* Starts jobs where there is room, and waits for one. Returns false where no job can run or be waited for. */
static bool go_on(const job_list *list, desk *d, job_result *results)
{
    int how;
    job *ended = NULL;
    for (int i = 0; i < list->at_a_time && d->next < list->count && !process_interrupted(); i++) {
        if (d->places[i].process != 0) continue;
        /* where it does not start, it is tried again when another one has ended */
        if (!start(list, &d->places[i], &d->shares[d->next], d->next)) break;
        d->next++;
        d->running++;
    }
    if (d->running == 0) return process_interrupted() != 0;
    if (!wait_for_one(list, d->places, d->line.wanted, &how, &ended)) return false;
    if (ended) {
        finish(list, ended, how, results);
        d->done++;
        d->running--;
    }
    show_progress(list, d->shares, results, d->done, &d->line);
    return true;
}

bool jobs_run(const job_list *list, job_result *results)
{
    size_t size = ((size_t)list->count + 1) * sizeof(job_share);
    desk d = {.places = calloc((size_t)list->at_a_time, sizeof *d.places),
              .shares = mmap(NULL, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)};
    bool fine = d.places && d.shares != MAP_FAILED;
    memset(results, 0, sizeof *results * (size_t)list->count);
    process_keep_signals();
    progress_start(&d.line, list->progress);
    while (fine && d.done < list->count && (d.running > 0 || !process_interrupted())) fine = go_on(list, &d, results);
    if (process_interrupted()) mark_interrupted(list, results);
    progress_end(&d.line);
    int error = errno;
    if (d.shares != MAP_FAILED) munmap(d.shares, size);
    free(d.places);
    errno = error;
    return fine;
}

void jobs_free(job_result *results, int count)
{
    for (int i = 0; i < count; i++) {
        json_decref(results[i].document);
        free(results[i].messages);
    }
}
