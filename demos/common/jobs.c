#define _POSIX_C_SOURCE 200809L

#include "jobs.h"
#include "process.h"

#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
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
static void do_work(const job_list *list, const job *j, pid_t parent)
{
    json_t *document = NULL;
    process_follow_parent(parent);
    if (dup2(fileno(j->messages), STDERR_FILENO) < 0) _exit(COMMAND_SYSTEM);
    command_status status = list->work(list->context, j->index, &document);
    if (document &&
        (json_dumpf(document, j->document, JSON_COMPACT | JSON_REAL_PRECISION(17)) != 0 || fflush(j->document) != 0)) {
        fprintf(stderr, "pinch: %s: the result cannot be written\n", list->name(list->context, j->index));
        status = COMMAND_SYSTEM;
    }
    fflush(stderr);
    _exit((int)status);
}

static bool start(const job_list *list, job *j, int index)
{
    j->index = index;
    j->document = tmpfile();
    j->messages = tmpfile();
    pid_t parent = getpid();
    fflush(NULL); /* what is buffered would be written twice */
    j->process = j->document && j->messages ? fork() : -1;
    if (j->process == 0) do_work(list, j, parent);
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
    char text[512];
    snprintf(text, sizeof text, "pinch: %s: %s\n", list->name(list->context, index), what);
    size_t before = *messages ? strlen(*messages) : 0;
    char *more = realloc(*messages, before + strlen(text) + 1);
    if (!more) return;
    strcpy(more + before, text);
    *messages = more;
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
    } else if (r->status == COMMAND_DONE && !r->document) {
        r->status = COMMAND_SYSTEM;
        add_message(list, j->index, "the process ended without a result", &r->messages);
    }
    fclose(j->document);
    fclose(j->messages);
    j->process = 0;
}

static void show_progress(const job_list *list, int done, int last)
{
    enum { WIDTH = 30 };
    char bar[WIDTH + 1];
    if (!list->progress) return;
    int filled = list->count > 0 ? WIDTH * done / list->count : WIDTH;
    for (int i = 0; i < WIDTH; i++) bar[i] = i < filled ? '#' : '-';
    bar[WIDTH] = '\0';
    fprintf(stderr, "\r\033[K[%s] %d of %d%s%.40s", bar, done, list->count, last >= 0 ? ", " : "",
            last >= 0 ? list->name(list->context, last) : "");
    if (done == list->count) fputs("\r\033[K", stderr);
    fflush(stderr);
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

/* Waits until one of the processes ends. A process of another origin, which whoever started this program left as its
 * child, is passed over. A signal that was kept ends all jobs, and they are waited for as usual. Returns the place;
 * NULL where waiting failed. */
static job *wait_for_one(const job_list *list, job *places, int *ended)
{
    for (;;) {
        if (process_interrupted()) stop_all(list, places);
        pid_t process = waitpid(-1, ended, 0);
        if (process < 0 && errno != EINTR) return NULL;
        job *place = process > 0 ? place_of(list, places, process) : NULL;
        if (place) return place;
    }
}

/* A job that the signal kept from ending has no answer. */
static void mark_interrupted(const job_list *list, job_result *results)
{
    for (int i = 0; i < list->count; i++)
        if (!results[i].document) results[i].status = (command_status)(COMMAND_INTERRUPTED + process_interrupted());
}

bool jobs_run(const job_list *list, job_result *results)
{
    job *places = calloc((size_t)list->at_a_time, sizeof *places);
    memset(results, 0, sizeof *results * (size_t)list->count);
    if (!places) return false;
    int next = 0, running = 0, done = 0, last = -1;
    bool fine = true;
    process_keep_signals();
    while (done < list->count && fine && (running > 0 || !process_interrupted())) {
        show_progress(list, done, last);
        for (int i = 0; i < list->at_a_time && next < list->count && !process_interrupted(); i++) {
            if (places[i].process != 0) continue;
            if (!start(list, &places[i], next)) break; /* try again when another process has ended */
            next++;
            running++;
        }
        if (running == 0) break;
        int ended;
        job *place = wait_for_one(list, places, &ended);
        fine = place != NULL;
        if (!fine) break;
        last = place->index;
        finish(list, place, ended, results);
        done++;
        running--;
    }
    if (process_interrupted())
        mark_interrupted(list, results);
    else
        fine = fine && done == list->count;
    if (fine) show_progress(list, list->count, -1);
    free(places);
    return fine;
}

void jobs_free(job_result *results, int count)
{
    for (int i = 0; i < count; i++) {
        json_decref(results[i].document);
        free(results[i].messages);
    }
}
