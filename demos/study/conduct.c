/* From missing trials to rows of the results. */
#define _POSIX_C_SOURCE 200809L

#include "conduct.h"
#include "beside.h"
#include "trial.h"

#include "common/measure.h"
#include "common/process.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { TEXT_FORMAT = JSON_COMPACT | JSON_REAL_PRECISION(17) };

/* Objects within a row go into the results as texts. The worker writes them, so that the process that collects the
 * rows need not read all their numbers and write them again.
 */
static bool write_objects_as_texts(json_t *row)
{
    const char *key;
    json_t *value, *part;
    void *next;
    size_t i;
    json_object_foreach_safe(row, next, key, value)
    {
        json_array_foreach(value, i, part) if (!write_objects_as_texts(part)) return false;
        if (!json_is_object(value)) continue;
        char *text = json_dumps(value, TEXT_FORMAT);
        bool good = text && json_object_set_new(row, key, json_string(text)) == 0;
        free(text);
        if (!good) return false;
    }
    return true;
}

char *conduct_work(void *s, const crew_order *order, long index)
{
    json_t *answer = order->kind == CONDUCT_TRIALS ? trial_run(s, index) : beside_refine(s, order, index);
    char *text = answer && write_objects_as_texts(answer) ? json_dumps(answer, TEXT_FORMAT) : NULL;
    json_decref(answer);
    return text;
}

/* Two batches for each worker: while it works on one, the next is on its way. */
enum { BATCHES = 2, MOST_IN_BATCH = 64 };

typedef struct desk {
    const study *s;
    results *r;
    crew *c;
    const conduct_settings *settings;
    results_error *error;
    crew_order (*held)[BATCHES]; /* by each worker, the unanswered part, in the order in which they were handed out */
    bool *gone;                  /* workers that could not be replaced */
    size_t again_count, again_room;
    crew_order *again;                       /* to hand out once more, because a worker was lost */
    crew_order suspect;                      /* at which a worker was lost last; count 0: none */
    long next;                               /* the first trial, or order of the list, that was not looked at */
    long handed, answered, succeeded, found; /* in this call; found: there before */
    double mean;                             /* wall time of a trial, s, of the latest ones */
    double started, committed, shown;
    double busy, last; /* s: spent in trials by all workers; when the last answer came */
} desk;

/* ---- Handing out. ---- */

static bool put_back(desk *d, crew_order b)
{
    if (b.count <= 0) return true;
    if (d->again_count == d->again_room) {
        size_t room = 2 * d->again_room + 8;
        crew_order *more = realloc(d->again, room * sizeof *more);
        if (!more) return false;
        d->again = more;
        d->again_room = room;
    }
    d->again[d->again_count++] = b;
    return true;
}

/* So many trials take about a quarter of a second. */
static int batch_size(const desk *d)
{
    double size = d->answered > 0 ? 0.25 / fmax(d->mean, 1e-6) : 1.0;
    double share = (double)(d->s->samples - d->next) / (2.0 * BATCHES * d->c->size); /* the last ones are shared out */
    return (int)fmax(1.0, fmin(fmin(size, share), MOST_IN_BATCH));
}

static bool next_of_list(desk *d, crew_order *b)
{
    if (d->next < (long)d->settings->list_count) *b = d->settings->list[d->next++];
    return true;
}

/* The next trials that are missing. Returns false after a failure; a count of 0 says that there are none. */
static bool next_batch(desk *d, crew_order *b)
{
    *b = (crew_order){.kind = CONDUCT_TRIALS};
    if (d->again_count > 0) {
        *b = d->again[--d->again_count];
        return true;
    }
    if (d->settings->list) return next_of_list(d, b);
    int most = batch_size(d);
    for (; d->next < d->s->samples && b->count < most && d->handed < d->settings->limit; d->next++) {
        int has = results_has(d->r, d->next, d->error);
        if (has < 0) return false;
        d->found += has;
        if (has && b->count > 0) break;
        if (has) continue;
        if (b->count++ == 0) b->first = d->next;
        d->handed++;
    }
    return true;
}

static bool hand_out(desk *d)
{
    for (int w = 0; w < d->c->size; w++)
        for (int i = 0; i < BATCHES && !d->gone[w]; i++) {
            if (d->held[w][i].count > 0) continue;
            if (!next_batch(d, &d->held[w][i])) return false;
            if (d->held[w][i].count == 0) break;
            /* a worker that cannot be reached is lost, which the crew reports in its time */
            (void)d->c->hand_out(d->c, w, &d->held[w][i]);
        }
    return true;
}

static bool is_idle(const desk *d)
{
    for (int w = 0; w < d->c->size; w++)
        if (d->held[w][0].count > 0) return false;
    return true;
}

/* ---- Answers. ---- */

static bool add(desk *d, const crew_order *order, const json_t *answer)
{
    return order->kind == CONDUCT_TRIALS ? results_add(d->r, answer, d->error)
                                         : results_add_refinements(d->r, answer, d->error);
}

static bool take_line(desk *d, const crew_event *event)
{
    crew_order *held = d->held[event->worker];
    json_t *trial = json_loads(event->line, 0, NULL);
    free(event->line);
    if (!trial || held[0].count == 0) {
        json_decref(trial);
        d->error->status = COMMAND_SYSTEM;
        snprintf(d->error->text, sizeof d->error->text, "a worker's answer cannot be read");
        return false;
    }
    bool good = add(d, &held[0], trial);
    double time = json_number_value(json_object_get(trial, "wall_time"));
    d->mean = d->answered > 0 ? 0.95 * d->mean + 0.05 * time : time;
    d->busy += time;
    d->last = clock_seconds();
    d->answered++;
    d->succeeded += json_is_true(json_object_get(trial, "success"));
    json_decref(trial);
    held[0].first++;
    if (--held[0].count == 0) {
        memmove(held, held + 1, (BATCHES - 1) * sizeof *held);
        held[BATCHES - 1].count = 0;
    }
    return good;
}

/* A trial that has ended two workers is recorded as crashed. */
static bool add_crash(desk *d, const crew_order *order, int signal)
{
    long index = order->first;
    char message[128];
    if (signal)
        snprintf(message, sizeof message, "the process ended by signal %d", signal);
    else
        snprintf(message, sizeof message, "the process ended without a result");
    const char *status = signal ? "crashed" : "no_memory";
    json_t *trial =
        order->kind != CONDUCT_TRIALS
            ? beside_crash(order, status)
            : json_pack("{s:I, s:o, s:s, s:b, s:i, s:f, s:f, s:s, s:{}, s:[], s:[{s:s, s:s, s:s}]}", "index",
                        (json_int_t)index, "inputs", study_draw(d->s, index), "status", status, "success", 0, "exit",
                        signal ? 128 + signal : 3, "wall_time", 0.0, "run_time", 0.0, "hash", "", "recorded",
                        "directions", "errors", "direction", "", "status", status, "message", message);
    bool good = add(d, order, trial);
    json_decref(trial);
    d->answered++;
    return good;
}

static bool is_suspect(const desk *d, const crew_order *order)
{
    const crew_order *s = &d->suspect;
    return s->count > 0 && s->first == order->first && s->kind == order->kind && s->value == order->value;
}

/* What a lost worker held is handed out again. Where the same trial has ended a worker before, it is recorded as
 * crashed and not tried again. */
static bool take_loss(desk *d, const crew_event *event)
{
    crew_order *held = d->held[event->worker];
    bool good = true;
    if (held[0].count > 0 && is_suspect(d, &held[0])) {
        good = add_crash(d, &held[0], event->signal);
        held[0].first++;
        held[0].count--;
    } else if (held[0].count > 0) {
        d->suspect = held[0];
    }
    for (int i = BATCHES; i-- > 0;) {
        good = put_back(d, held[i]) && good;
        held[i].count = 0;
    }
    d->gone[event->worker] = !d->c->replace(d->c, event->worker);
    for (int w = 0; w < d->c->size && good; w++)
        if (!d->gone[w]) return true;
    if (!good) return false;
    d->error->status = COMMAND_SYSTEM;
    snprintf(d->error->text, sizeof d->error->text, "all workers are lost; what was done is kept");
    return false;
}

/* ---- Progress. ---- */

static void show_progress(desk *d, bool last)
{
    double now = clock_seconds();
    bool terminal = isatty(STDERR_FILENO);
    if (!d->settings->progress || (!last && now - d->shown < (terminal ? 0.5 : 60.0))) return;
    d->shown = now;
    if (last && terminal) fputs("\r\033[K", stderr);
    if (last) return;
    long to_do = d->s->samples - d->found;
    if (d->settings->limit < to_do) to_do = d->settings->limit;
    double rate = (double)d->answered / fmax(now - d->started, 1e-9);
    if (d->settings->list) {
        to_do = (long)d->settings->list_count;
        fprintf(stderr, "%s%ld of %ld refinements", terminal ? "\r\033[K" : "", d->answered, to_do);
    } else {
        fprintf(stderr, "%s%ld of %ld trials, %.1f %% succeeded, %.3g/s", terminal ? "\r\033[K" : "",
                d->answered + d->found, d->s->samples,
                d->answered > 0 ? 100.0 * (double)d->succeeded / (double)d->answered : 0.0, rate);
    }
    if (d->answered > 0) {
        double left = (double)(to_do - d->answered) / rate;
        if (left >= 3600)
            fprintf(stderr, ", %.1f h left", left / 3600);
        else if (left >= 60)
            fprintf(stderr, ", %.0f min left", left / 60);
        else
            fprintf(stderr, ", %.0f s left", fmax(left, 0.0));
    }
    if (!terminal) fputc('\n', stderr);
    fflush(stderr);
}

/* ---- All of it. ---- */

/* A transaction for what comes in within a quarter of a second: a commit costs as much as many trials' rows. */
static bool commit_in_time(desk *d)
{
    const double span = 0.25;
    double now = clock_seconds();
    if (now - d->committed < span && !is_idle(d)) return true;
    d->committed = now;
    return results_commit(d->r, d->error);
}

static bool work(desk *d)
{
    for (;;) {
        if (process_interrupted()) return true;
        if (!hand_out(d)) return false;
        if (is_idle(d)) return true;
        crew_event event = d->c->wait(d->c, 0.2);
        if (event.type == CREW_LINE && !take_line(d, &event)) return false;
        if (event.type == CREW_LOST && !process_interrupted() && !take_loss(d, &event)) return false;
        if (!commit_in_time(d)) return false;
        show_progress(d, false);
    }
}

command_status conduct(const study *s, results *r, crew *c, const conduct_settings *settings, results_error *error)
{
    desk d = {.s = s, .r = r, .c = c, .settings = settings, .error = error};
    d.held = calloc((size_t)c->size, sizeof *d.held);
    d.gone = calloc((size_t)c->size, sizeof *d.gone);
    d.started = d.committed = d.shown = clock_seconds();
    *error = (results_error){.status = COMMAND_SYSTEM, .text = "out of memory"};
    bool good = d.held && d.gone && work(&d);
    show_progress(&d, true);
    if (settings->run) {
        double elapsed = d.answered > 0 ? d.last - d.started : 0.0;
        *settings->run = (conduct_run){c->size, d.answered, elapsed, d.busy / (fmax(elapsed, 1e-9) * c->size)};
    }
    results_error late;
    bool committed = results_commit(r, good ? error : &late);
    free(d.held);
    free(d.gone);
    free(d.again);
    if (!good || !committed) return error->status;
    return process_interrupted() ? (command_status)(COMMAND_INTERRUPTED + process_interrupted()) : COMMAND_DONE;
}
