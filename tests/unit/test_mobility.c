/* In reduced coordinates jointed bodies must move as the joints allow, and their inertia must be the identity. */
#include "support/cmocka_all.h"

#include "kinematics/mobility.h"
#include "support/draw.h"
#include "support/island.h"

#include <string.h>

static double row_length(const pinch_joint_row *row)
{
    double sum = 0;
    for (int i = 0; i < 6; i++) sum += row->j1[i] * row->j1[i] + row->j2[i] * row->j2[i];
    return sqrt(sum);
}

static void times_mass(const pinch_body *b, const double *v, double *p)
{
    for (int i = 0; i < 3; i++) {
        p[i] = b->mass * v[i];
        p[3 + i] = 0;
        for (int j = 0; j < 3; j++) p[3 + i] += b->inertia[3 * i + j] * v[3 + j];
    }
}

static void velocities(const pinch_problem *p, const pinch_mobility *m, const double *x, double *v)
{
    for (int b = 0; b < p->body_count; b++) pinch_mobility_velocity(m, b, x, v + 6 * b);
}

/* A jointed island with some of its hard rows said twice, turned and scaled: redundant, not contradictory. */
static void make_jointed(island *made, uint64_t seed, pinch_random *random)
{
    island_make(made, ISLAND_JOINTS, seed);
    pinch_problem *p = &made->problem;
    int count = p->row_count;
    for (int k = 0; k < count && p->row_count < ISLAND_ROWS; k++) {
        if (!pinch_row_is_hard(&p->rows[k]) || !draw_chance(random, 0.2)) continue;
        double scale = draw_log_uniform(random, 0.1, 10);
        pinch_joint_row *twin = &p->rows[p->row_count++];
        *twin = p->rows[k];
        for (int i = 0; i < 6; i++) {
            twin->j1[i] *= scale;
            twin->j2[i] *= scale;
        }
        twin->rhs *= scale;
    }
}

/* Tolerances: a few hundred multiplications of numbers of the size of the compared ones, 1e-11 of it. */
static void test_random_clusters(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 5);
    pinch_arena arena;
    pinch_arena_init(&arena);
    int redundant = 0, trees = 0, others = 0;
    for (uint64_t seed = 1; seed <= 600; seed++) {
        static island made;
        double x[48], v[48], v0[48], u[48][48];
        make_jointed(&made, seed, &random);
        pinch_problem *p = &made.problem;
        pinch_mobility m;
        pinch_arena_reset(&arena);
        assert_true(pinch_mobility_build(&arena, p, PINCH_ELIMINATE_ALL, &m));
        int hard = 0;
        for (int k = 0; k < p->row_count; k++) hard += pinch_row_is_hard(&p->rows[k]);
        redundant += m.unknowns > 6 * p->body_count - hard;
        for (int k = 0; k < m.cluster_count; k++) {
            trees += m.clusters[k].tree && m.clusters[k].body_count > 1;
            others += m.clusters[k].factor && m.clusters[k].body_count > 1;
        }
        assert_true(m.unknowns <= 6 * p->body_count && m.unknowns >= 6 * p->body_count - hard);

        memset(x, 0, sizeof x);
        velocities(p, &m, x, v0);
        for (int f = 0; f < m.unknowns; f++) { /* columns of U */
            x[f] = 1;
            velocities(p, &m, x, u[f]);
            x[f] = 0;
            for (int i = 0; i < 6 * p->body_count; i++) u[f][i] -= v0[i];
        }
        double fastest = 0;
        for (int i = 0; i < 6 * p->body_count; i++) fastest = fmax(fastest, fabs(v0[i]));
        for (int f = 0; f < m.unknowns; f++) x[f] = draw_uniform(&random, -1, 1);
        velocities(p, &m, x, v);

        for (int k = 0; k < p->row_count; k++) { /* J v+ = c for any q, J U = 0 */
            const pinch_joint_row *row = &p->rows[k];
            if (!pinch_row_is_hard(row)) continue;
            double size = 0;
            for (int f = 0; f < m.unknowns; f++)
                for (int i = 0; i < 6 * p->body_count; i++) size = fmax(size, fabs(u[f][i]));
            size = (size + fastest) * row_length(row) * 1e-11;
            assert_close(island_row_velocity(row, v), row->rhs, 10 * size);
            for (int f = 0; f < m.unknowns; f++) assert_close(island_row_velocity(row, u[f]), 0, size);
        }
        for (int f = 0; f < m.unknowns; f++) /* U^T M U = I */
            for (int g = 0; g < m.unknowns; g++) {
                double sum = 0;
                for (int b = 0; b < p->body_count; b++) {
                    double momentum[6];
                    times_mass(&p->bodies[b], u[g] + 6 * b, momentum);
                    for (int i = 0; i < 6; i++) sum += u[f][6 * b + i] * momentum[i];
                }
                assert_close(sum, f == g, 1e-11);
            }
    }
    pinch_arena_free(&arena);
    assert_true(redundant > 50 && trees > 50 && others > 50);
}

/*
 * A wrench applied to the bodies, momentum in the reduced coordinates q = h U^T f: with the multipliers that come back,
 * M (v+ - v*) = h (f + J^T lambda) holds for every body.
 */
static void test_multipliers(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 6);
    pinch_arena arena;
    pinch_arena_init(&arena);
    for (uint64_t seed = 1; seed <= 300; seed++) {
        static island made;
        double x[48], v[48], f[48], left[48], v0[48];
        make_jointed(&made, seed, &random);
        pinch_problem *p = &made.problem;
        pinch_mobility m;
        pinch_arena_reset(&arena);
        assert_true(pinch_mobility_build(&arena, p, PINCH_ELIMINATE_ALL, &m));
        for (int i = 0; i < 6 * p->body_count; i++) f[i] = draw_uniform(&random, -10, 10);
        memset(x, 0, sizeof x);
        velocities(p, &m, x, v0);
        double q[48];
        for (int k = 0; k < m.unknowns; k++) { /* q = h U^T f */
            x[k] = 1;
            velocities(p, &m, x, v);
            x[k] = 0;
            q[k] = 0;
            for (int i = 0; i < 6 * p->body_count; i++) q[k] += p->step * (v[i] - v0[i]) * f[i];
        }
        velocities(p, &m, q, v);
        pinch_mobility_joint_forces(&m, p, f);
        double size = 10;
        for (int b = 0; b < p->body_count; b++) {
            double gain[6], momentum[6];
            for (int i = 0; i < 6; i++) gain[i] = v[6 * b + i] - p->bodies[b].velocity[i];
            times_mass(&p->bodies[b], gain, momentum);
            for (int i = 0; i < 6; i++) {
                left[6 * b + i] = momentum[i] / p->step - f[6 * b + i];
                size = fmax(size, fabs(momentum[i] / p->step));
            }
        }
        for (int k = 0; k < p->row_count; k++) {
            const pinch_joint_row *row = &p->rows[k];
            if (!pinch_row_is_hard(row)) continue;
            for (int i = 0; i < 6; i++) {
                if (row->body1 >= 0) left[6 * row->body1 + i] -= row->force * row->j1[i];
                if (row->body2 >= 0) left[6 * row->body2 + i] -= row->force * row->j2[i];
            }
        }
        for (int i = 0; i < 6 * p->body_count; i++) assert_close(left[i], 0, 1e-10 * size);
    }
    pinch_arena_free(&arena);
}

static void test_refuses_what_has_no_inertia(void **state)
{
    (void)state;
    static island made;
    pinch_arena arena;
    pinch_mobility m;
    pinch_arena_init(&arena);
    for (int jointed = 0; jointed < 2; jointed++) {
        island_make(&made, jointed ? ISLAND_JOINTS : ISLAND_HARD, 3);
        made.bodies[0].inertia[8] = -1e-9;
        pinch_arena_reset(&arena);
        assert_false(pinch_mobility_build(&arena, &made.problem, PINCH_ELIMINATE_ALL, &m));
    }
    pinch_arena_free(&arena);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_random_clusters),
        cmocka_unit_test(test_multipliers),
        cmocka_unit_test(test_refuses_what_has_no_inertia),
    };
    return cmocka_run_group_tests_name("mobility", tests, NULL, NULL);
}
