/* Newton's steps of a mechanism in its contacts alone: the same velocities and the same answer as on all bodies and
 * joints. */
#include "support/cmocka_all.h"

#include "force/force_joints.h"
#include "support/draw.h"

#include <pinch/problem.h>
#include <string.h>

enum { LINKS = 14, BALL = 3, MOST_CONTACTS = 4, TRIALS = 20000 };

/* A tree of bodies on ball joints, closed to a loop now and then, with contacts that press on some of them. */
typedef struct mechanism {
    pinch_body bodies[LINKS];
    pinch_contact contacts[MOST_CONTACTS];
    pinch_joint_row rows[BALL * (LINKS + 1)];
    pinch_problem problem;
} mechanism;

static void add_ball(mechanism *m, int body1, int body2, const double anchor[3], pinch_random *random)
{
    for (int i = 0; i < BALL; i++) {
        pinch_joint_row *row = &m->rows[m->problem.row_count++];
        const int body[2] = {body1, body2};
        double *const j[2] = {row->j1, row->j2}, axis[3] = {i == 0, i == 1, i == 2};
        row->body1 = body1;
        row->body2 = body2;
        row->low = -INFINITY;
        row->high = INFINITY;
        row->rhs = draw_uniform(random, -0.01, 0.01);
        for (int side = 0; side < 2; side++) {
            double arm[3];
            if (body[side] < 0) continue;
            for (int k = 0; k < 3; k++) arm[k] = anchor[k] - m->bodies[body[side]].position[k];
            memcpy(j[side], axis, sizeof axis);
            cross(arm, axis, j[side] + 3);
            for (int k = 0; k < 6 && side; k++) j[side][k] = -j[side][k];
        }
    }
}

static void add_body(mechanism *m, int b, pinch_random *random)
{
    pinch_body *body = &m->bodies[b];
    body->mass = draw_log_uniform(random, 0.1, 10);
    body->radius = 0.1;
    for (int i = 0; i < 3; i++) {
        body->inertia[4 * i] = 0.004 * body->mass * draw_uniform(random, 0.8, 1.2);
        body->position[i] = draw_uniform(random, -1, 1);
    }
    for (int i = 0; i < 6; i++) body->velocity[i] = draw_uniform(random, -1, 1);
}

static void add_contact(mechanism *m, int k, pinch_random *random)
{
    pinch_contact *c = &m->contacts[k];
    c->body1 = draw_index(random, LINKS);
    c->body2 = draw_chance(random, 0.3) ? (c->body1 + 1) % LINKS : PINCH_STATIC_BODY;
    c->model = PINCH_CONTACT_HARD;
    draw_direction(random, c->normal);
    draw_tangent(random, c->normal, c->tangent1);
    for (int i = 0; i < 3; i++) c->position[i] = m->bodies[c->body1].position[i] - 0.1 * c->normal[i];
    c->depth = draw_uniform(random, 0, 1e-3);
    c->stiffness[0] = c->stiffness[1] = 1e4;
    c->damping[0] = c->damping[1] = 100;
    c->friction[0] = c->friction[1] = draw_uniform(random, 0, 1);
    c->max_force = INFINITY;
    c->may_soften = true;
    for (int i = 0; i < 3; i++) c->force[i] = draw_uniform(random, 0, 10);
}

static void make(mechanism *m, pinch_random *random)
{
    memset(m, 0, sizeof *m);
    m->problem = (pinch_problem){.step = 0.005,
                                 .body_count = LINKS,
                                 .contact_count = MOST_CONTACTS,
                                 .bodies = m->bodies,
                                 .contacts = m->contacts,
                                 .rows = m->rows};
    for (int b = 0; b < LINKS; b++) {
        add_body(m, b, random);
        int parent = draw_chance(random, 0.7) ? b - 1 : draw_index(random, b + 1) - 1;
        if (b > 0 || draw_chance(random, 0.5)) add_ball(m, b, parent, m->bodies[b].position, random);
    }
    if (draw_chance(random, 0.3)) add_ball(m, LINKS - 1, PINCH_STATIC_BODY, m->bodies[0].position, random);
    for (int k = 0; k < MOST_CONTACTS; k++) add_contact(m, k, random);
}

/* Builds the system; `condense` as a solve would. */
static void build(pinch_arena *arena, mechanism *m, pinch_mobility *mobility, bool condense, pinch_force_system *s)
{
    assert_true(pinch_mobility_build(arena, &m->problem, PINCH_ELIMINATE_WHERE_CHEAP, mobility));
    assert_true(pinch_force_system_build(arena, &m->problem, mobility, s));
    s->budget = INFINITY;
    pinch_force_warm_start(s, &m->problem);
    pinch_force_set_floor(s, 1e-4);
    s->joints_tried = true;
    if (condense) assert_true(pinch_force_factor_joints(arena, s) && pinch_force_condense(arena, s));
}

/* The same forces move all contacts alike, and the multipliers found for them satisfy all rows. */
static void test_velocities(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 24);
    int condensed = 0, count = draw_count(TRIALS);
    for (int trial = 0; trial < count; trial++) {
        mechanism m;
        pinch_mobility mobility;
        pinch_force_system s;
        pinch_arena arena;
        double there[MOST_CONTACTS][3], largest = 1;
        pinch_arena_init(&arena);
        make(&m, &random);
        build(&arena, &m, &mobility, true, &s);
        if (s.condensed) {
            condensed++;
            pinch_force_enter_contacts(&s);
            (void)pinch_force_evaluate(&s);
            for (int k = 0; k < MOST_CONTACTS; k++)
                memcpy(there[k], s.condensed->w + s.condensed->first[k], sizeof there[k]);
            s.in_contacts = false;
            pinch_force_satisfy_rows(&s, true);
            (void)pinch_force_evaluate(&s);
            for (int i = 0; i < s.multiplier_count; i++) largest = fmax(largest, fabs(s.multipliers[i].y));
            assert_true(s.row_off * s.scale < 1e-9 * largest);
            for (int k = 0; k < MOST_CONTACTS; k++) {
                double w[3];
                pinch_force_element_velocity(&s.elements[k], s.q, w);
                for (int i = 0; i < 3; i++) assert_close(there[k][i], w[i], 1e-9 * largest);
            }
        }
        pinch_arena_free(&arena);
    }
    assert_true(condensed > count / 2);
}

/* A solve ends in the same forces, whichever steps it takes. */
static void test_answers(void **state)
{
    (void)state;
    pinch_random random;
    pinch_solver_settings settings = pinch_default_solver_settings();
    pinch_random_seed(&random, 25);
    int compared = 0, count = draw_count(TRIALS);
    for (int trial = 0; trial < count; trial++) {
        mechanism m;
        pinch_mobility mobility[2];
        pinch_force_system s[2];
        pinch_solver_result result[2];
        pinch_arena arena[2];
        make(&m, &random);
        for (int way = 0; way < 2; way++) {
            pinch_arena_init(&arena[way]);
            build(&arena[way], &m, &mobility[way], way == 1, &s[way]);
            assert_true(pinch_force_newton(&arena[way], &s[way], &settings, 25, &result[way]));
        }
        bool both = result[0].status == PINCH_SOLVE_CONVERGED && result[1].status == PINCH_SOLVE_CONVERGED;
        for (int k = 0; k < MOST_CONTACTS && both; k++)
            for (int i = 0; i < 3; i++)
                assert_close(pinch_force_values(&s[0].elements[k], PINCH_FORCE_R)[i],
                             pinch_force_values(&s[1].elements[k], PINCH_FORCE_R)[i], 1e-6 * fmax(s[0].force, 1));
        compared += both && s[1].condensed;
        for (int way = 0; way < 2; way++) pinch_arena_free(&arena[way]);
    }
    assert_true(compared > count / 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_velocities),
        cmocka_unit_test(test_answers),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
