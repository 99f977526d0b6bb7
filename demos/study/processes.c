/* Workers that are processes of this machine. A trial that crashes ends its process alone, and every process goes on
 * with trial after trial: starting one costs as much as a short trial. */
#define _GNU_SOURCE

#include "crew.h"

#include "common/command_status.h"
#include "common/pipe.h"
#include "common/process.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

typedef struct worker {
    pid_t process;              /* 0: none */
    int orders;                 /* lines of crew_order_write go here */
    int answers;                /* lines are read here */
    char *text;                 /* read, up to `used` of `room` bytes */
    size_t used, room, scanned; /* the first `scanned` bytes have no line feed */
} worker;

typedef struct processes {
    int size;
    worker *workers;
    crew_work work;
    void *context;
} processes;

/* ---- In the worker. ---- */

/* Works until the orders end. Never returns. */
static void work_off(const processes *p, int orders, int answers)
{
    char text[CREW_ORDER_TEXT];
    crew_order order;
    FILE *stream = fdopen(orders, "r");
    while (stream && fgets(text, sizeof text, stream) && crew_order_read(text, &order))
        for (int i = 0; i < order.count; i++) {
            char *line = p->work(p->context, &order, order.first + i);
            size_t length = line ? strlen(line) : 0;
            if (!line || (line[length] = '\n', !pipe_send(answers, line, length + 1))) _exit(COMMAND_SYSTEM);
            free(line);
        }
    _exit(COMMAND_DONE);
}

/* ---- In the one who hands out. ---- */

static void close_pair(int pair[2])
{
    if (pair[0] >= 0) close(pair[0]);
    if (pair[1] >= 0) close(pair[1]);
}

/* A worker keeps its own pipes alone. It must not hold those of its siblings, or their ends would go unseen, nor the
 * lock of the results, which ends with the process that writes them. */
static void keep_only(int one, int other)
{
    unsigned low = (unsigned)(one < other ? one : other), high = (unsigned)(one < other ? other : one);
    if (low > 3) close_range(3, low - 1, 0);
    if (high > low + 1) close_range(low + 1, high - 1, 0);
    close_range(high + 1, ~0u, 0);
}

static bool start(processes *p, worker *w)
{
    int orders[2] = {-1, -1}, answers[2] = {-1, -1};
    if (pipe(orders) != 0 || pipe(answers) != 0) {
        close_pair(orders);
        return false;
    }
    pid_t parent = getpid();
    fflush(NULL); /* what is buffered would be written twice */
    w->process = fork();
    if (w->process == 0) {
        process_follow_parent(parent);
        keep_only(orders[0], answers[1]);
        work_off(p, orders[0], answers[1]);
    }
    close(orders[0]);
    close(answers[1]);
    w->orders = orders[1];
    w->answers = answers[0];
    w->used = w->scanned = 0;
    if (w->process > 0) return true;
    close(orders[1]);
    close(answers[0]);
    w->process = 0;
    return false;
}

int crew_order_write(const crew_order *order, char text[CREW_ORDER_TEXT])
{
    return snprintf(text, CREW_ORDER_TEXT, "%ld %d %d %.17g\n", order->first, order->count, order->kind, order->value);
}

bool crew_order_read(const char *text, crew_order *order)
{
    return sscanf(text, "%ld %d %d %lf", &order->first, &order->count, &order->kind, &order->value) == 4;
}

static bool hand_out(crew *c, int number, const crew_order *order)
{
    processes *p = c->state;
    char text[CREW_ORDER_TEXT];
    int length = crew_order_write(order, text);
    return pipe_send(p->workers[number].orders, text, (size_t)length);
}

static crew_event lose(processes *p, int number)
{
    worker *w = &p->workers[number];
    int ended = 0;
    close(w->orders);
    close(w->answers);
    while (waitpid(w->process, &ended, 0) < 0 && errno == EINTR) continue;
    w->process = 0;
    return (crew_event){CREW_LOST, number, NULL, WIFSIGNALED(ended) ? WTERMSIG(ended) : 0};
}

/* The next whole line that the worker has written; NULL where there is none yet. */
static char *take_line(worker *w)
{
    char *end = memchr(w->text + w->scanned, '\n', w->used - w->scanned);
    w->scanned = w->used;
    if (!end) return NULL;
    size_t length = (size_t)(end - w->text);
    char *line = malloc(length + 1);
    if (!line) return NULL;
    memcpy(line, w->text, length);
    line[length] = '\0';
    memmove(w->text, end + 1, w->used - length - 1);
    w->used -= length + 1;
    w->scanned = 0;
    return line;
}

/* Reads what there is. Returns false at the end. */
static bool read_some(worker *w)
{
    if (w->used == w->room) {
        size_t room = w->room ? 2 * w->room : (size_t)1 << 16;
        char *more = realloc(w->text, room);
        if (!more) return false;
        w->text = more;
        w->room = room;
    }
    ssize_t got = read(w->answers, w->text + w->used, w->room - w->used);
    if (got < 0 && errno == EINTR) return true;
    if (got <= 0) return false;
    w->used += (size_t)got;
    return true;
}

static crew_event wait_for(crew *c, double seconds)
{
    processes *p = c->state;
    struct pollfd polled[1024];
    crew_event nothing = {.type = CREW_NOTHING};
    for (int i = 0; i < p->size; i++) {
        char *line = p->workers[i].used > p->workers[i].scanned ? take_line(&p->workers[i]) : NULL;
        if (line) return (crew_event){CREW_LINE, i, line, 0};
        polled[i] = (struct pollfd){.fd = p->workers[i].process > 0 ? p->workers[i].answers : -1, .events = POLLIN};
    }
    if (poll(polled, (nfds_t)p->size, (int)(1000 * seconds)) <= 0) return nothing;
    for (int i = 0; i < p->size; i++) {
        if (!polled[i].revents) continue;
        if (!read_some(&p->workers[i])) return lose(p, i);
        char *line = take_line(&p->workers[i]);
        if (line) return (crew_event){CREW_LINE, i, line, 0};
    }
    return nothing;
}

static bool replace(crew *c, int number)
{
    processes *p = c->state;
    return start(p, &p->workers[number]);
}

static void end(crew *c, bool at_once)
{
    processes *p = c->state;
    for (int i = 0; i < p->size; i++) {
        worker *w = &p->workers[i];
        if (w->process > 0) {
            if (at_once) kill(w->process, SIGKILL);
            (void)lose(p, i);
        }
        free(w->text);
    }
    free(p->workers);
    free(p);
}

bool crew_of_processes(crew *c, int size, crew_work work, void *context)
{
    processes *p = calloc(1, sizeof *p);
    if (p) p->workers = calloc((size_t)size, sizeof *p->workers);
    if (!p || !p->workers) {
        free(p);
        return false;
    }
    *p = (processes){size, p->workers, work, context};
    *c = (crew){size, p, hand_out, wait_for, replace, end};
    signal(SIGPIPE, SIG_IGN); /* a worker that has ended is noticed when its answers end */
    for (int i = 0; i < size; i++)
        if (!start(p, &p->workers[i])) {
            end(c, true);
            return false;
        }
    return true;
}
