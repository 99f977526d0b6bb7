/*
 * Checkpoints of a run: the input says which bytes of a good one are changed. As it is, no changed one may be taken.
 * With checksums made anew for the change, whatever is taken must be safe to step and to save again.
 */
#include "support/started_run.h"
#include "target.h"

#include <stdlib.h>
#include <string.h>

enum { BEFORE = 30, AFTER = 2 };

static scene *shared;
static unsigned char *good;
static size_t good_size, snapshot_at; /* where the plugin's snapshot begins */

static started_run start(void)
{
    started_run r = run_start(shared);
    if (!r.s) target_found("the scene cannot be started");
    return r;
}

static void make_good_one(void)
{
    scene_error error;
    dInitODE2(0);
    if (scene_load(PINCH_SCENE, &shared, &error) != SCENE_OK) target_found("%s", error.text);
    shared->solver.max_iterations = 100; /* a good step takes a few; forged numbers take as many as they get */
    started_run r = start();
    for (int i = 0; i < BEFORE; i++) (void)simulation_step(r.s);
    if (!simulation_checkpoint(r.s, &good, &good_size)) target_found("no checkpoint");
    run_end(&r);
    static const char format[] = "pinch-ode/16";
    for (size_t at = 0; at + sizeof format < good_size && snapshot_at == 0; at++)
        if (memcmp(good + at, format, sizeof format) == 0) snapshot_at = at;
    if (snapshot_at == 0) target_found("a checkpoint without a snapshot");
}

/* The checksums of plugin and run, which are not secret: 64-bit words mixed in one by one, and FNV-1a. */
static void sum_anew(unsigned char *bytes, size_t size)
{
    size_t end = size - 2 * sizeof(uint64_t);
    uint64_t inner = 0x9e3779b97f4a7c16u, outer = 0xcbf29ce484222325u;
    for (size_t at = snapshot_at; at < end; at += 8) {
        uint64_t word = 0;
        memcpy(&word, bytes + at, end - at < 8 ? end - at : 8);
        inner = (inner ^ word) * 0xff51afd7ed558ccdu;
        inner ^= inner >> 32;
    }
    memcpy(bytes + end, &inner, sizeof inner);
    for (size_t i = 0; i < size - sizeof outer; i++) outer = (outer ^ bytes[i]) * 0x100000001b3u;
    memcpy(bytes + size - sizeof outer, &outer, sizeof outer);
}

/* Steps what was taken, as far as its numbers let it, and saves it. */
static void go_on(started_run *r)
{
    unsigned char *bytes = NULL;
    size_t size;
    for (int i = 0; i < AFTER; i++)
        if (simulation_step(r->s) != WORLD_OK) return;
    if (!simulation_checkpoint(r->s, &bytes, &size)) target_found("what was taken cannot be saved");
    free(bytes);
}

/* Where forged numbers make ODE give up a step, its world is left as it is, and with it what ODE had allocated. */
__attribute__((visibility("default"))) const char *__lsan_default_suppressions(void); /* for the sanitizer's library */
const char *__lsan_default_suppressions(void)
{
    return "leak:libode.so\n";
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (!good) make_good_one();
    target_bytes b = {data, size};
    bool forged = target_byte(&b) & 1;
    unsigned char *bytes = malloc(good_size);
    if (!bytes) return 0;
    memcpy(bytes, good, good_size);
    while (b.left >= 4) {
        size_t at = target_byte(&b);
        at = (at << 8 | target_byte(&b)) << 8;
        at = (at | target_byte(&b)) % good_size;
        bytes[at] ^= (unsigned char)target_byte(&b);
    }
    if (forged) sum_anew(bytes, good_size);
    bool same = memcmp(bytes, good, good_size) == 0;
    started_run r = start();
    checkpoint_status status = simulation_resume(r.s, bytes, good_size);
    if (same != (status == CHECKPOINT_FINE) && (same || !forged))
        target_found("status %d of a %s checkpoint", (int)status, same ? "good" : "damaged");
    if (status == CHECKPOINT_FINE) go_on(&r);
    run_end(&r);
    free(bytes);
    return 0;
}
