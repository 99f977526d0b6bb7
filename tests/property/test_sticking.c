/*
 * A step may have several answers: an object that rests in its grasp goes on resting in one of them and is let go in
 * another. As long as the one in which everything sticks is within the limits of friction, it has to be the answer,
 * whatever the stiffness, the mass and the step are.
 */
#include "support/cmocka_all.h"

#include "support/draw.h"

#include <pinch/problem.h>
#include <string.h>

enum { N = 6, ROWS = 3, MOST_CONTACTS = 4, LOADS = 400 };

typedef struct held_body {
    pinch_problem problem;
    pinch_body body;
    pinch_contact contacts[MOST_CONTACTS];
} held_body;

/* Tilts a direction by a random angle of at most `most`. */
static void draw_tilted(pinch_random *random, const double d[3], double most, double n[3])
{
    double t[3], angle = draw_uniform(random, 0, most);
    draw_tangent(random, d, t);
    for (int i = 0; i < 3; i++) n[i] = cos(angle) * d[i] + sin(angle) * t[i];
}

/* A contact that presses the body with the force f within its friction cone. */
static void add_contact(pinch_random *random, held_body *g, const double place[3], const double f[3], double k)
{
    pinch_contact *c = &g->contacts[g->problem.contact_count++];
    double along[3], t2[3], size = length(f);
    c->body1 = 0;
    c->body2 = PINCH_STATIC_BODY;
    c->model = draw_chance(random, 0.5) ? PINCH_CONTACT_SOFT : PINCH_CONTACT_HARD;
    c->friction[0] = c->friction[1] = draw_uniform(random, 0.4, 0.9);
    c->torsional_friction = 0.01;
    c->max_force = INFINITY;
    for (int i = 0; i < 3; i++) along[i] = f[i] / size;
    draw_tilted(random, along, 0.7 * atan(c->friction[0]), c->normal);
    draw_tangent(random, c->normal, c->tangent1);
    cross(c->normal, c->tangent1, t2);
    memcpy(c->position, place, sizeof c->position);
    c->stiffness[0] = k;
    c->stiffness[1] = draw_uniform(random, 0.5, 1) * k;
    c->stiffness[2] = 1e-4 * k;
    if (draw_chance(random, 0.5)) c->damping[0] = c->damping[1] = 0.3 * sqrt(k * g->body.mass);
    c->force[0] = dot(f, c->normal);
    c->force[1] = dot(f, c->tangent1);
    c->force[2] = dot(f, t2);
    c->depth = c->force[0] / k;
    for (int i = 0; i < 2; i++) c->elastic[i] = -c->force[1 + i] / c->stiffness[1];
}

/* h^2 k / m, by which forces follow from velocities. Beyond the first, the velocities of a step with facets are too
 * coarse for the check of its answer, and beyond the second now and then those of any step. */
static const double FACETED = 1e4, STIFFEST = 1e5;

/* Pairs of contacts that press against each other along the line between them, which hold a body in balance. */
static void draw_grip(pinch_random *random, held_body *g)
{
    memset(g, 0, sizeof *g);
    pinch_body *b = &g->body;
    double size = draw_log_uniform(random, 0.01, 0.1), k = draw_log_uniform(random, 1e4, 1e7);
    b->mass = draw_log_uniform(random, 1e-3, 1);
    b->radius = size;
    for (int i = 0; i < 3; i++) b->inertia[4 * i] = draw_uniform(random, 0.3, 0.5) * b->mass * size * size;
    g->problem = (pinch_problem){.step = draw_log_uniform(random, 1e-3, 2e-2),
                                 .faces = draw_chance(random, 0.2) ? 12 : 0,
                                 .body_count = 1,
                                 .bodies = &g->body,
                                 .contacts = g->contacts};
    double h2 = g->problem.step * g->problem.step;
    k = fmin(k, STIFFEST * b->mass / h2);
    if (k > FACETED * b->mass / h2) g->problem.faces = 0;
    double grip = 9.81 * b->mass * draw_log_uniform(random, 2, 10);
    for (int pairs = 1 + draw_index(random, 2); pairs > 0; pairs--) {
        double a[3], c[3], f[3], back[3], way = 0;
        draw_direction(random, a);
        draw_tilted(random, a, 0.4, c);
        for (int i = 0; i < 3; i++) {
            a[i] *= size;
            c[i] *= -size;
            f[i] = c[i] - a[i];
        }
        way = length(f);
        for (int i = 0; i < 3; i++) back[i] = -(f[i] *= grip / way);
        add_contact(random, g, a, f, k);
        add_contact(random, g, c, back, k);
    }
}

/* Rows of the grasp matrix: the velocity of the body's point along the contact's axes. */
static void rows_of(const pinch_contact *c, double G[ROWS][N])
{
    double axis[ROWS][3];
    memcpy(axis[0], c->normal, sizeof axis[0]);
    memcpy(axis[1], c->tangent1, sizeof axis[1]);
    cross(axis[0], axis[1], axis[2]);
    for (int row = 0; row < ROWS; row++) {
        memcpy(G[row], axis[row], sizeof axis[row]);
        cross(c->position, axis[row], G[row] + 3);
    }
}

/* Solves A x = b by Gauss' elimination of a positive definite matrix. */
static void eliminate(double A[N][N], double b[N])
{
    for (int j = 0; j < N; j++)
        for (int i = j + 1; i < N; i++) {
            double part = A[i][j] / A[j][j];
            for (int k = j; k < N; k++) A[i][k] -= part * A[j][k];
            b[i] -= part * b[j];
        }
    for (int i = N - 1; i >= 0; i--) {
        for (int k = i + 1; k < N; k++) b[i] -= A[i][k] * b[k];
        b[i] /= A[i][i];
    }
}

static double conductance_of(const pinch_contact *c, int row, double h)
{
    return h * c->stiffness[row > 0] + c->damping[row > 0];
}

/* The forces of a step in which all contacts stick. Tells whether they are within their limits, and not near them. */
static bool all_stick(const held_body *g, double force[MOST_CONTACTS][ROWS])
{
    double A[N][N] = {{0}}, v[N] = {0}, G[ROWS][N], h = g->problem.step;
    const pinch_body *b = &g->body;
    for (int i = 0; i < N; i++) A[i][i] = i < 3 ? b->mass : b->inertia[4 * (i - 3)];
    for (int i = 0; i < N; i++) v[i] = A[i][i] * b->velocity[i];
    for (int k = 0; k < g->problem.contact_count; k++) {
        const pinch_contact *c = &g->contacts[k];
        rows_of(c, G);
        for (int row = 0; row < ROWS; row++) {
            force[k][row] = c->stiffness[row > 0] * (row == 0 ? c->depth : -c->elastic[row - 1]);
            for (int i = 0; i < N; i++) {
                v[i] += h * G[row][i] * force[k][row];
                for (int j = 0; j < N; j++) A[i][j] += h * conductance_of(c, row, h) * G[row][i] * G[row][j];
            }
        }
    }
    for (int k = 0; k < g->problem.contact_count; k++) { /* torsion, which elastic[2] twists */
        const pinch_contact *c = &g->contacts[k];
        if (c->model != PINCH_CONTACT_SOFT) continue;
        for (int i = 0; i < 3; i++) {
            v[3 + i] -= h * c->normal[i] * c->stiffness[2] * c->elastic[2];
            for (int j = 0; j < 3; j++) A[3 + i][3 + j] += h * h * c->stiffness[2] * c->normal[i] * c->normal[j];
        }
    }
    eliminate(A, v);
    bool within = true;
    for (int k = 0; k < g->problem.contact_count; k++) {
        const pinch_contact *c = &g->contacts[k];
        rows_of(c, G);
        for (int row = 0; row < ROWS; row++)
            for (int i = 0; i < N; i++) force[k][row] -= conductance_of(c, row, h) * G[row][i] * v[i];
        double torsion = c->stiffness[2] * (c->elastic[2] + h * dot(c->normal, v + 3));
        double part = c->model == PINCH_CONTACT_SOFT ? torsion / (c->torsional_friction * force[k][0]) : 0;
        double reach = hypot(hypot(force[k][1], force[k][2]) / (c->friction[0] * force[k][0]), part);
        within = within && force[k][0] > 0 && reach < 0.98;
    }
    return within;
}

static void go_on(held_body *g)
{
    memcpy(g->body.velocity, g->body.velocity_end, sizeof g->body.velocity);
    for (int k = 0; k < g->problem.contact_count; k++) {
        pinch_contact *c = &g->contacts[k];
        memcpy(c->elastic, c->elastic_end, sizeof c->elastic);
        c->depth -= g->problem.step * c->relative_velocity[0];
    }
}

/* Loads a grip little by little until not everything can stick any more, and to MOST times the weight of the body.
 * Returns how many steps were compared. */
static int load(pinch_step_solver *solver, pinch_random *random, held_body *g)
{
    pinch_solver_settings settings = pinch_default_solver_settings();
    static const double MOST = 8;
    double direction[3], force[MOST_CONTACTS][ROWS];
    draw_direction(random, direction);
    for (int step = 0; step < LOADS; step++) {
        double weight = MOST * 9.81 * g->body.mass * (step + 1) / LOADS;
        for (int i = 0; i < 3; i++) {
            g->body.external[i] = weight * direction[i];
            g->body.velocity[i] += g->problem.step * weight * direction[i] / g->body.mass;
        }
        if (!all_stick(g, force)) return step;
        pinch_step_result result;
        assert_int_equal(pinch_step_solve(solver, &g->problem, &settings, &result), PINCH_OK);
        assert_int_equal(result.solve.status, PINCH_SOLVE_CONVERGED);
        for (int k = 0; k < g->problem.contact_count; k++) {
            const pinch_contact *c = &g->contacts[k];
            assert_int_equal(c->state, PINCH_CONTACT_STICK);
            for (int row = 0; row < ROWS; row++)
                assert_true(fabs(c->force[row] - force[k][row]) <= 1e-6 * length(force[k]));
        }
        go_on(g);
    }
    return LOADS;
}

static void what_sticks_goes_on_sticking(void **state)
{
    (void)state;
    pinch_step_solver *solver;
    assert_int_equal(pinch_step_solver_create(&solver), PINCH_OK);
    int compared = 0, held = 0, count = draw_count(10000);
    for (int seed = 1; seed <= count; seed++) {
        pinch_random random;
        held_body g;
        pinch_random_seed(&random, (uint64_t)seed);
        draw_grip(&random, &g);
        int steps = load(solver, &random, &g);
        compared += steps;
        held += steps >= LOADS / 8;
    }
    pinch_step_solver_destroy(solver);
    print_message("%d of %d grips hold their weight; %d steps compared\n", held, count, compared);
    assert_true(held > count / 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_sticks_goes_on_sticking)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
