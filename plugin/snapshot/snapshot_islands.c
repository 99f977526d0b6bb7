#include "snapshot/archive.h"
#include "snapshot/snapshot.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

/* Bytes that an archive has at least for one of each, and the most unknowns that a memory may be of. */
enum {
    DRIVE_BYTES = 44,
    MEMORY_BYTES = 12,
    BACKED_OFF_BYTES = 26,
    ACCOUNT_BYTES = 61,
    IDLE_BYTES = 130,
    MOST_UNKNOWNS = 1 << 15
};

static void archive_drives(pinch_archive *a, pinch_drives *drives)
{
    PINCH_ARCHIVE_LIST(a, *drives, DRIVE_BYTES);
    for (int i = 0; i < drives->count; i++) {
        pinch_archive_body(a, &drives->items[i].body, false);
        PINCH_ARCHIVE(a, drives->items[i].axis);
        PINCH_ARCHIVE(a, drives->items[i].force);
        PINCH_ARCHIVE(a, drives->items[i].speed);
    }
    pinch_archive_index(a, &drives->index, PINCH_ITEM_KEYS(*drives, pinch_drive, body), drives->count);
}

/* Archives the arrays of a memory, which lie in buffers while they are read. */
static void archive_factors(pinch_archive *a, const pinch_step_factors *f, double *lu, int *pivot,
                            unsigned char *states)
{
    size_t n = (size_t)f->unknowns;
    pinch_archive_bytes(a, a->reading ? lu : (double *)f->lu, n * n * sizeof *lu);
    pinch_archive_bytes(a, a->reading ? pivot : (int *)f->pivot, n * sizeof *pivot);
    pinch_archive_bytes(a, a->reading ? states : (unsigned char *)f->states, (size_t)f->element_count);
}

/* Reads the arrays, and makes the memory hold them. */
static void read_factors(pinch_archive *a, pinch_step_factors *f, pinch_step_memory *memory)
{
    size_t n = (size_t)f->unknowns;
    double *lu = malloc(n * n * sizeof *lu);
    int *pivot = malloc(n * sizeof *pivot);
    unsigned char *states = malloc((size_t)f->element_count + 1);
    if (lu && pivot && states) {
        archive_factors(a, f, lu, pivot, states);
        f->lu = lu, f->pivot = pivot, f->states = states;
        if (a->status == PINCH_OK) pinch_archive_fail(a, pinch_step_memory_write(memory, f));
    } else {
        pinch_archive_fail(a, PINCH_OUT_OF_MEMORY);
    }
    free(lu);
    free(pivot);
    free(states);
}

/* A memory is tagged with the address of its island's first body. */
static void archive_tag(pinch_archive *a, uint64_t *tag)
{
    dBodyID body = (dBodyID)(uintptr_t)*tag;
    pinch_archive_old_body(a, &body);
    *tag = (uintptr_t)body;
}

static void archive_memory(pinch_archive *a, pinch_step_memory *memory)
{
    pinch_step_factors f = {0};
    if (!a->reading) f = pinch_step_memory_read(memory);
    archive_tag(a, &f.tag);
    pinch_archive_count(a, &f.unknowns, sizeof(double), MOST_UNKNOWNS);
    pinch_archive_count(a, &f.element_count, 1, MOST_UNKNOWNS);
    if (f.unknowns == 0 || a->status != PINCH_OK) return;
    if (a->reading)
        read_factors(a, &f, memory);
    else
        archive_factors(a, &f, NULL, NULL, NULL);
}

static void archive_memories(pinch_archive *a, pinch_island_graph *graph)
{
    int count = graph->memories.count;
    pinch_archive_count(a, &count, MEMORY_BYTES, MOST_UNKNOWNS * 1024);
    if (a->reading && !PINCH_RESERVE(graph->memories, count)) pinch_archive_fail(a, PINCH_OUT_OF_MEMORY);
    for (int k = 0; k < count && a->status == PINCH_OK; k++) {
        if (a->reading) {
            pinch_archive_fail(a, pinch_step_memory_create(&graph->memories.items[k]));
            if (a->status != PINCH_OK) return;
            graph->memories.count++;
        }
        archive_memory(a, graph->memories.items[k]);
    }
}

static void archive_backoff(pinch_archive *a, pinch_backoff *backoff)
{
    PINCH_ARCHIVE_LIST(a, *backoff, BACKED_OFF_BYTES);
    for (int i = 0; i < backoff->count; i++) {
        pinch_backed_off *entry = &backoff->items[i];
        pinch_archive_old_body(a, &entry->body);
        PINCH_ARCHIVE(a, entry->until);
        PINCH_ARCHIVE(a, entry->span);
        PINCH_ARCHIVE(a, entry->size);
        pinch_archive_flag(a, &entry->joints);
        pinch_archive_flag(a, &entry->swept);
    }
    pinch_archive_index(a, &backoff->index, PINCH_ITEM_KEYS(*backoff, pinch_backed_off, body), backoff->count);
    PINCH_ARCHIVE(a, backoff->dropped_step);
}

static void archive_accounts(pinch_archive *a, pinch_joint_accounts *accounts)
{
    PINCH_ARCHIVE_LIST(a, *accounts, ACCOUNT_BYTES);
    for (int i = 0; i < accounts->count; i++) {
        pinch_joint_account *account = &accounts->items[i];
        pinch_archive_old_body(a, &account->body);
        PINCH_ARCHIVE(a, account->energy);
        PINCH_ARCHIVE(a, account->pace);
        PINCH_ARCHIVE(a, account->saved);
        PINCH_ARCHIVE(a, account->push);
        PINCH_ARCHIVE(a, account->push_pace);
        PINCH_ARCHIVE(a, account->push_slowed_step);
        pinch_archive_flag(a, &account->torn);
        PINCH_ARCHIVE(a, account->seen);
    }
    pinch_archive_index(a, &accounts->index, PINCH_ITEM_KEYS(*accounts, pinch_joint_account, body), accounts->count);
}

static void archive_sleep(pinch_archive *a, pinch_sleep *sleep)
{
    PINCH_ARCHIVE_LIST(a, *sleep, IDLE_BYTES);
    for (int i = 0; i < sleep->count; i++) {
        pinch_idle_body *idle = &sleep->items[i];
        pinch_archive_old_body(a, &idle->body);
        PINCH_ARCHIVE(a, idle->steps);
        PINCH_ARCHIVE(a, idle->time);
        PINCH_ARCHIVE(a, idle->linear);
        PINCH_ARCHIVE(a, idle->angular);
        PINCH_ARCHIVE(a, idle->push);
        PINCH_ARCHIVE(a, idle->samples);
        pinch_archive_flag(a, &idle->has_mean);
        PINCH_ARCHIVE(a, idle->patience);
        pinch_archive_flag(a, &idle->was_put_to_sleep);
        PINCH_ARCHIVE(a, idle->seen);
        bool counts = idle->steps >= 0 && idle->steps <= PINCH_MOST_IDLE_STEPS && idle->samples >= 0 &&
                      idle->samples <= PINCH_MOST_IDLE_STEPS && idle->seen >= 0 && idle->seen <= LONG_MAX / 2;
        if (!counts || idle->patience < 1 || idle->patience > PINCH_MOST_PATIENCE)
            pinch_archive_fail(a, PINCH_INVALID_ARGUMENT);
    }
    pinch_archive_index(a, &sleep->index, PINCH_ITEM_KEYS(*sleep, pinch_idle_body, body), sleep->count);
}

void pinch_archive_islands(pinch_archive *a, pinch_island_graph *graph)
{
    archive_drives(a, &graph->bodies.drives);
    archive_memories(a, graph);
    archive_backoff(a, &graph->backoff);
    archive_accounts(a, &graph->accounts);
    archive_sleep(a, &graph->sleep);
}
