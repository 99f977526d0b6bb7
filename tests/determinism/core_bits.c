/*
 * Prints a line for each of many problems: kind, number, a hash over its inputs, and one over all that the core
 * answers. `other_architecture` compares the lines of two machines.
 */
#include "support/draw.h"
#include "support/grasps.h"
#include "support/island.h"

#include <pinch/lcp.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ISLANDS = 200, GRASPS = 100, LCPS = 200, SIZE = 12 };

typedef uint64_t hash;

/* Not a number is one value here, whatever its sign and payload. */
static void add(hash *h, const double *values, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        uint64_t bits = 0x7ff8000000000000u;
        if (!isnan(values[i])) memcpy(&bits, &values[i], sizeof bits);
        *h = (*h ^ bits) * 0xff51afd7ed558ccdu;
        *h ^= *h >> 32;
    }
}

static void add_bytes(hash *h, const void *bytes, size_t size)
{
    for (size_t i = 0; i < size; i++) *h = (*h ^ ((const unsigned char *)bytes)[i]) * 0x100000001b3u;
}

static void print(const char *kind, int number, hash inputs, hash answer)
{
    printf("%s %d %016llx %016llx\n", kind, number, (unsigned long long)inputs, (unsigned long long)answer);
}

static void solve_islands(void)
{
    pinch_step_solver *solver;
    if (pinch_step_solver_create(&solver) != PINCH_OK) exit(1);
    pinch_solver_settings settings = pinch_default_solver_settings();
    settings.max_iterations = 2000;
    for (int kind = 0; kind < ISLAND_KIND_COUNT; kind++)
        for (int n = 0; n < ISLANDS; n++) {
            static island made;
            pinch_step_result result;
            hash inputs = 0, answer = 0;
            island_make(&made, (island_kind)kind, (uint64_t)n + 1);
            pinch_problem *p = &made.problem;
            bool soft = n % 2 && kind != ISLAND_DRIVES; /* in the system of forces, which has no massless bodies */
            for (int i = 0; i < p->contact_count; i++) p->contacts[i].may_soften = soft;
            add_bytes(&inputs, p->bodies, (size_t)p->body_count * sizeof *p->bodies);
            add_bytes(&inputs, p->contacts, (size_t)p->contact_count * sizeof *p->contacts);
            add_bytes(&inputs, p->rows, (size_t)p->row_count * sizeof *p->rows);
            if (pinch_step_solve(solver, p, &settings, &result) != PINCH_OK) exit(1);
            double status = (double)result.solve.status;
            add(&answer, &status, 1);
            for (int i = 0; i < p->body_count; i++) add(&answer, p->bodies[i].velocity_end, 6);
            for (int i = 0; i < p->contact_count; i++) {
                add(&answer, p->contacts[i].force, 4);
                add(&answer, p->contacts[i].elastic_end, 3);
                add(&answer, p->contacts[i].slip, 3);
            }
            for (int i = 0; i < p->row_count; i++) add(&answer, &p->rows[i].force, 1);
            char name[64];
            snprintf(name, sizeof name, "island-%s-%s", island_kind_name((island_kind)kind),
                     soft ? "forces" : "velocities");
            print(name, n, inputs, answer);
        }
    pinch_step_solver_destroy(solver);
}

static void solve_grasps(int faces, const char *name)
{
    pinch_statics *statics;
    pinch_random random;
    pinch_random_seed(&random, 3);
    if (pinch_statics_create(GRASP_MAX_FINGERS, 8, &statics) != PINCH_OK) exit(1);
    pinch_statics_settings settings = pinch_default_statics_settings();
    if (faces) {
        settings.formulation = PINCH_FORMULATION_LCP;
        settings.faces = faces;
    }
    for (int n = 0; n < GRASPS; n++) {
        test_grasp g;
        pinch_finger_result fingers[GRASP_MAX_FINGERS];
        pinch_statics_result result;
        hash inputs = 0, answer = 0;
        memset(&g, 0, sizeof g);
        grasp_random(&random, &g);
        for (int i = 0; i < g.grasp.finger_count; i++) {
            const pinch_finger *f = &g.fingers[i];
            add(&inputs, f->point, 3);
            add(&inputs, f->normal, 3);
            add(&inputs, f->stiffness, 3);
        }
        add(&inputs, g.grasp.wrench, 6);
        pinch_status status = pinch_statics_solve(statics, &g.grasp, &settings, fingers, &result);
        double outcome = status == PINCH_OK ? (double)result.solve.status : -1.0;
        add(&answer, &outcome, 1);
        for (int i = 0; i < g.grasp.finger_count && status == PINCH_OK; i++) add(&answer, fingers[i].r, 4);
        if (status == PINCH_OK) add(&answer, result.translation, 3);
        print(name, n, inputs, answer);
    }
    pinch_statics_destroy(statics);
}

/* M = B B^T + skew part + a little on the diagonal */
static void draw_lcp(pinch_random *random, int n, double *m, double *q)
{
    double b[SIZE * SIZE];
    for (int i = 0; i < n * n; i++) b[i] = 2 * pinch_random_uniform(random) - 1;
    for (int i = 0; i < n; i++) {
        q[i] = 2 * pinch_random_uniform(random) - 1;
        for (int j = 0; j < n; j++) {
            double sum = i == j ? 0.1 : b[i * n + j] - b[j * n + i];
            for (int k = 0; k < n; k++) sum += b[i * n + k] * b[j * n + k];
            m[i * n + j] = sum;
        }
    }
}

static void solve_lcps(void)
{
    pinch_lcp_workspace *workspace;
    pinch_random random;
    pinch_random_seed(&random, 4);
    if (pinch_lcp_workspace_create(SIZE, &workspace) != PINCH_OK) exit(1);
    for (int n = 0; n < LCPS; n++) {
        double m[SIZE * SIZE], q[SIZE], z[SIZE], w[SIZE];
        pinch_lcp p = {.size = 2 + n % (SIZE - 1), .m = m, .q = q};
        draw_lcp(&random, p.size, m, q);
        for (int s = 0; s < PINCH_SOLVER_COUNT; s++) {
            pinch_solver_settings settings = pinch_default_solver_settings();
            pinch_solver_result result;
            hash inputs = 0, answer = 0;
            settings.solver = (pinch_solver)s;
            settings.max_iterations = 2000;
            memset(z, 0, sizeof z);
            add(&inputs, m, (size_t)(p.size * p.size));
            add(&inputs, q, (size_t)p.size);
            if (pinch_lcp_solve(&p, &settings, workspace, z, w, &result) != PINCH_OK) exit(1);
            double status = (double)result.status;
            add(&answer, &status, 1);
            add(&answer, z, (size_t)p.size);
            add(&answer, w, (size_t)p.size);
            char name[64];
            snprintf(name, sizeof name, "lcp-%s", pinch_solver_name(settings.solver));
            print(name, n, inputs, answer);
        }
    }
    pinch_lcp_workspace_destroy(workspace);
}

int main(void)
{
    solve_lcps();
    solve_islands();
    solve_grasps(0, "grasp-exact-cone");
    solve_grasps(8, "grasp-eight-facets");
    return 0;
}
