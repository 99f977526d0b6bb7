#define _POSIX_C_SOURCE 200809L

#include "jobs.h"

#include <errno.h>
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
static void do_work(const job_list *list, const job *j)
{
    json_t *document = NULL;
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
    fflush(NULL); /* what is buffered would be written twice */
    j->process = j->document && j->messages ? fork() : -1;
    if (j->process == 0) do_work(list, j);
    if (j->process > 0) return true;
    if (j->document) fclose(j->document);
    if (j->messages) fclose(j->messages);
    j->process = 0;
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

static void report_killed(const job_list *list, int index, int signal, char **messages)
{
    char text[512];
    snprintf(text, sizeof text, "pinch: %s: the process ended by signal %d\n", list->name(list->context, index),
             signal);
    size_t before = *messages ? strlen(*messages) : 0;
    char *more = realloc(*messages, before + strlen(text) + 1);
    if (!more) return;
    strcpy(more + before, text);
    *messages = more;
}

static void finish(const job_list *list, job *j, int ended, job_result *results)
{
    job_result *r = &results[j->index];
    r->messages = text_of(j->messages);
    r->status = WIFEXITED(ended) ? (command_status)WEXITSTATUS(ended) : COMMAND_SYSTEM;
    if (WIFSIGNALED(ended)) report_killed(list, j->index, WTERMSIG(ended), &r->messages);
    rewind(j->document);
    r->document = json_loadf(j->document, 0, NULL); /* an empty file gives NULL */
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

/* Waits until one of the processes ends. */
static bool wait_for_one(const job_list *list, job *places, job_result *results, int *finished)
{
    int ended;
    pid_t process;
    do process = waitpid(-1, &ended, 0);
    while (process < 0 && errno == EINTR);
    for (int i = 0; i < list->at_a_time && process > 0; i++) {
        if (places[i].process != process) continue;
        *finished = places[i].index;
        finish(list, &places[i], ended, results);
        return true;
    }
    return false;
}

bool jobs_run(const job_list *list, job_result *results)
{
    job *places = calloc((size_t)list->at_a_time, sizeof *places);
    memset(results, 0, sizeof *results * (size_t)list->count);
    if (!places) return false;
    int next = 0, running = 0, done = 0, finished = -1;
    bool fine = true;
    while (done < list->count && fine) {
        show_progress(list, done, finished);
        for (int i = 0; i < list->at_a_time && next < list->count; i++) {
            if (places[i].process != 0) continue;
            if (!start(list, &places[i], next)) break; /* try again when another process has ended */
            next++;
            running++;
        }
        fine = running > 0 && wait_for_one(list, places, results, &finished);
        done += fine;
        running -= fine;
    }
    if (fine) show_progress(list, done, -1);
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
