/*
 * Memory that runs out at any moment of a solve: the call says so, nothing leaks, and the next call gives the bits that
 * it would have given. This program is linked with an arena whose arrays are allocations of their own (the definition
 * PINCH_ARENA_APART), so that each can fail alone, and so that the address sanitizer sees where each ends.
 */
#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/grasps.h"
#include "support/island.h"

#include <pinch/friction.h>
#include <pinch/lcp.h>
#include <stdlib.h>
#include <string.h>

/* ---- the allocator, which the linker puts in the place of the C library's ---- */

static long asked, fails_at; /* 0: never */

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *old, size_t size);

void *__wrap_malloc(size_t size)
{
    return ++asked == fails_at ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t count, size_t size)
{
    return ++asked == fails_at ? NULL : __real_calloc(count, size);
}

void *__wrap_realloc(void *old, size_t size)
{
    return ++asked == fails_at ? NULL : __real_realloc(old, size);
}

/* ---- any solve ---- */

/* Makes a problem, and solves it: allocations of the solve alone count. Writes what it answers into `answer`. */
typedef struct task {
    const char *name;
    pinch_status (*solve)(const struct task *t, unsigned char *answer, size_t *size);
    int kind, seed;
    bool soft;
    int faces;
    pinch_solver solver;
} task;

enum { MOST_BYTES = 1 << 16 };

static pinch_status solve_failing_at(const task *t, long k, unsigned char *answer, size_t *size, long *count)
{
    *size = 0;
    asked = 0;
    fails_at = 0;
    memset(answer, 0, MOST_BYTES);
    fails_at = k;
    pinch_status status = t->solve(t, answer, size);
    fails_at = 0;
    if (count) *count = asked;
    return status;
}

static void append(unsigned char *answer, size_t *size, const void *data, size_t bytes)
{
    assert_true(*size + bytes <= MOST_BYTES);
    memcpy(answer + *size, data, bytes);
    *size += bytes;
}

/* In a quick run only some of the allocations fail, other ones for each task. */
static void starve(const task *t)
{
    static unsigned char whole[MOST_BYTES], answer[MOST_BYTES];
    size_t size, again;
    long count, refused = 0, most = draw_full() ? 1000000 : 60;
    assert_int_equal(solve_failing_at(t, 0, whole, &size, &count), PINCH_OK);
    long stride = count / most + 1;
    for (long k = 1 + t->seed % stride; k <= count; k += stride) {
        pinch_status status = solve_failing_at(t, k, answer, &again, NULL);
        refused += status == PINCH_OUT_OF_MEMORY;
        if (status == PINCH_OUT_OF_MEMORY) continue;
        /* what does without that memory has to come to the same answer */
        assert_int_equal(status, PINCH_OK);
        assert_int_equal(again, size);
        assert_memory_equal(answer, whole, size);
    }
    assert_true(count == 0 || refused > 0);
    assert_int_equal(solve_failing_at(t, 0, answer, &again, NULL), PINCH_OK);
    assert_memory_equal(answer, whole, size);
}

/* ---- islands: one solver for all, which has to outlive every failure ---- */

static pinch_step_solver *solver;

static pinch_status solve_island(const task *t, unsigned char *answer, size_t *size)
{
    static island made;
    pinch_step_result result;
    pinch_solver_settings settings = pinch_default_solver_settings();
    memset(&made, 0, sizeof made);
    island_make(&made, (island_kind)t->kind, (uint64_t)t->seed);
    pinch_problem *p = &made.problem;
    p->faces = t->faces;
    for (int i = 0; i < p->contact_count; i++) {
        p->contacts[i].may_soften = t->soft;
        if (t->faces) p->contacts[i].friction[1] = p->contacts[i].friction[0];
    }
    settings.solver = t->solver;
    settings.max_iterations = 500;
    pinch_step_solver_trim(solver, 0);
    asked = 0;
    pinch_status status = pinch_step_solve(solver, p, &settings, &result);
    append(answer, size, &result.solve.status, sizeof result.solve.status);
    for (int i = 0; i < p->body_count; i++)
        append(answer, size, p->bodies[i].velocity_end, sizeof p->bodies[i].velocity_end);
    for (int i = 0; i < p->contact_count; i++) append(answer, size, p->contacts[i].force, sizeof p->contacts[i].force);
    for (int i = 0; i < p->row_count; i++) append(answer, size, &p->rows[i].force, sizeof p->rows[i].force);
    return status;
}

static void test_islands(void **state)
{
    (void)state;
    assert_int_equal(pinch_step_solver_create(&solver), PINCH_OK);
    for (int kind = 0; kind < ISLAND_KIND_COUNT; kind++)
        for (int seed = 1; seed <= 6; seed++) {
            task t = {.solve = solve_island, .kind = kind, .seed = seed, .solver = PINCH_SOLVER_NSNMGK};
            t.soft = seed % 2 && kind != ISLAND_DRIVES; /* drives have no mass, which the forces as unknowns need */
            starve(&t);
        }
    pinch_step_solver_destroy(solver);
}

/* Methods that are there for reference allocate their matrices in every solve. */
static void test_islands_by_pivots(void **state)
{
    (void)state;
    assert_int_equal(pinch_step_solver_create(&solver), PINCH_OK);
    for (int seed = 1; seed <= 6; seed++) {
        task t = {.solve = solve_island, .kind = ISLAND_HARD, .seed = seed, .faces = 4};
        t.solver = seed % 2 ? PINCH_SOLVER_LEMKE : PINCH_SOLVER_PGS;
        starve(&t);
    }
    pinch_step_solver_destroy(solver);
}

static void test_creation(void **state)
{
    (void)state;
    pinch_step_solver *made = NULL;
    pinch_lcp_workspace *workspace = NULL;
    pinch_statics *statics = NULL;
    asked = 0;
    fails_at = 1;
    assert_int_equal(pinch_step_solver_create(&made), PINCH_OUT_OF_MEMORY);
    assert_null(made);
    bool enough = false;
    for (long k = 1; !enough; k++) {
        asked = 0;
        fails_at = k;
        pinch_status status = pinch_lcp_workspace_create(9, &workspace);
        enough = status == PINCH_OK;
        assert_true(enough || (status == PINCH_OUT_OF_MEMORY && !workspace));
    }
    pinch_lcp_workspace_destroy(workspace);
    enough = false;
    for (long k = 1; !enough; k++) {
        asked = 0;
        fails_at = k;
        pinch_status status = pinch_statics_create(5, 8, &statics);
        enough = status == PINCH_OK;
        assert_true(enough || (status == PINCH_OUT_OF_MEMORY && !statics));
    }
    pinch_statics_destroy(statics);
    fails_at = 0;
}

/* ---- rigid frictional problems: points of mass on a floor, tied to each other by contacts ---- */

static pinch_status solve_friction(const task *t, unsigned char *answer, size_t *size)
{
    enum { POINTS = 6, AXES = 3 };
    pinch_random random;
    double g[2][AXES * AXES] = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {-1, 0, 0, 0, -1, 0, 0, 0, -1}};
    int freedoms[POINTS];
    pinch_friction_contact contacts[POINTS];
    pinch_random_seed(&random, (uint64_t)t->seed);
    for (int i = 0; i < POINTS; i++) {
        freedoms[i] = AXES;
        contacts[i] = (pinch_friction_contact){.body = {i, i - 1}, .g = {g[0], i > 0 ? g[1] : NULL}, .friction = 0.5};
        for (int k = 0; k < AXES; k++) contacts[i].free[k] = draw_uniform(&random, -1, k == 0 ? 0.2 : 1);
    }
    pinch_friction_problem p = {POINTS, freedoms, POINTS, contacts};
    pinch_friction_result result;
    pinch_solver_settings settings = pinch_default_solver_settings();
    settings.tolerance = 1e-8;
    pinch_status status = pinch_friction_solve(&p, &settings, &result);
    for (int i = 0; i < POINTS; i++) append(answer, size, contacts[i].impulse, sizeof contacts[i].impulse);
    return status;
}

static void test_friction(void **state)
{
    (void)state;
    for (int seed = 1; seed <= 5; seed++) {
        task t = {.solve = solve_friction, .seed = seed};
        starve(&t);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_islands),
        cmocka_unit_test(test_islands_by_pivots),
        cmocka_unit_test(test_creation),
        cmocka_unit_test(test_friction),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
