/*
 * Compares the statics with a slow motion. The same grasp, with the statics' frozen geometry, is taken through closing
 * and wrench by the implicit steps of pinch_step_solve, which shares no code with the statics' solvers. What the
 * statics call unstable must leave; what they say is held must end with the same forces.
 */
#include "support/arithmetic.h"
#include "support/cmocka_all.h"
#include "support/draw.h"
#include "support/grasps.h"

#include <stdlib.h>
#include <string.h>

static int count = 3; /* of each kind; 100 in full runs */

enum { RAMP = 6000, HOLD = 16000 }; /* steps: a slow motion */

/* In units of what the softest spring gives under the unit force: what has left its grip, and where no other finger on
 * the way will catch it any more. */
static const double LEFT = 300.0, GONE = 1e4;

typedef struct motion {
    pinch_step_solver *solver;
    pinch_problem problem;
    pinch_body body;
    pinch_contact contacts[GRASP_MAX_FINGERS];
    double u[6];     /* displacement of the centre of mass, rotation */
    double softest;  /* N/m */
    double give;     /* m: of the softest spring under the unit force */
    bool lost_count; /* a step was not solved */
} motion;

/* The unit of force: the wrench, or what closing against all the others can build up. */
static double force_unit(const pinch_grasp *g)
{
    double k = 0.0, unit = fmax(length(g->wrench), length(g->wrench + 3) / g->radius);
    for (int i = 0; i < g->finger_count; i++) k += g->fingers[i].stiffness[0];
    for (int i = 0; i < g->finger_count; i++) {
        double kn = g->fingers[i].stiffness[0];
        unit = fmax(unit, g->fingers[i].closing * kn * (k - kn) / k);
    }
    return unit;
}

static void start(motion *m, const pinch_grasp *g)
{
    m->softest = INFINITY;
    for (int i = 0; i < g->finger_count; i++) {
        const pinch_finger *f = &g->fingers[i];
        m->softest = fmin(m->softest,
                          fmin(f->stiffness[0], f->model == PINCH_CONTACT_FRICTIONLESS ? INFINITY : f->stiffness[1]));
        pinch_contact *c = &m->contacts[i];
        *c = (pinch_contact){.body1 = 0,
                             .body2 = PINCH_STATIC_BODY,
                             .model = f->model,
                             .friction = {f->friction, f->friction},
                             .torsional_friction = f->torsional_friction,
                             .max_force = f->max_force};
        memcpy(c->position, f->point, sizeof c->position);
        memcpy(c->normal, f->normal, sizeof c->normal);
        memcpy(c->tangent1, f->tangent1, sizeof c->tangent1);
        memcpy(c->stiffness, f->stiffness, sizeof c->stiffness);
    }
    memset(m->u, 0, sizeof m->u);
    m->lost_count = false;
    m->give = force_unit(g) / m->softest;
    /* so light that the slow loading finds it in equilibrium, and implicit steps damp what is left: h^2 k/m = 0.1 for
     * the softest spring */
    const double h = 1e-3, mass = 10.0 * m->softest * h * h;
    m->body = (pinch_body){.mass = mass, .radius = g->radius};
    for (int j = 0; j < 3; j++) m->body.inertia[4 * j] = mass * g->radius * g->radius;
    m->problem = (pinch_problem){
        .step = h, .body_count = 1, .contact_count = g->finger_count, .bodies = &m->body, .contacts = m->contacts};
}

static void step(motion *m, const pinch_grasp *g, double closing, double load)
{
    double h = m->problem.step, radius2 = g->radius * g->radius;
    for (int j = 0; j < 6; j++) {
        m->body.external[j] = load * g->wrench[j];
        m->body.velocity[j] += h * m->body.external[j] / (m->body.mass * (j < 3 ? 1.0 : radius2));
    }
    for (int i = 0; i < g->finger_count; i++) {
        const pinch_finger *f = &g->fingers[i];
        const double *t = m->u, *r = m->u + 3, *p = f->point, *n = f->normal;
        double moved[3] = {t[0] + r[1] * p[2] - r[2] * p[1], t[1] + r[2] * p[0] - r[0] * p[2],
                           t[2] + r[0] * p[1] - r[1] * p[0]};
        m->contacts[i].depth = closing * f->closing - (n[0] * moved[0] + n[1] * moved[1] + n[2] * moved[2]);
    }
    pinch_solver_settings settings = pinch_default_solver_settings();
    pinch_step_result result;
    assert_int_equal(pinch_step_solve(m->solver, &m->problem, &settings, &result), PINCH_OK);
    if (result.solve.status != PINCH_SOLVE_CONVERGED) {
        m->lost_count = true;
        return;
    }
    for (int j = 0; j < 6; j++) {
        m->body.velocity[j] = m->body.velocity_end[j];
        m->u[j] += h * m->body.velocity[j];
    }
    for (int i = 0; i < g->finger_count; i++)
        memcpy(m->contacts[i].elastic, m->contacts[i].elastic_end, sizeof m->contacts[i].elastic);
}

/* Grows from 0 to 1 by a ramp, at once or as those of a run. */
static double grown(double time, bool smooth)
{
    double t = fmin(1.0, fmax(0.0, time / RAMP));
    return smooth ? t * t * (3.0 - 2.0 * t) : t;
}

/* True when the object got `far` away. */
static bool move(motion *m, const pinch_grasp *g, double far, bool smooth)
{
    start(m, g);
    for (int k = 1; k <= 2 * RAMP + HOLD && !m->lost_count; k++) {
        step(m, g, grown(k, smooth), grown(k - RAMP, smooth));
        if (length(m->u) + length(m->u + 3) * g->radius > far * m->give) return true;
    }
    return false;
}

static bool suitable(const test_grasp *g)
{
    if (g->grasp.planar) return false; /* the step knows no plane */
    for (int i = 0; i < g->grasp.finger_count; i++)
        if (g->fingers[i].force_controlled) return false;
    return true;
}

static void what_is_unstable_leaves_and_what_is_held_stays(void **state)
{
    (void)state;
    enum { MOST = 100 };
    double difference[MOST];
    int held = 0, stayed = 0, same = 0, left = 0, unstable = 0, unsolved = 0;
    pinch_statics *statics;
    motion m;
    assert_int_equal(pinch_statics_create(GRASP_MAX_FINGERS, 0, &statics), PINCH_OK);
    assert_int_equal(pinch_step_solver_create(&m.solver), PINCH_OK);
    pinch_random random;
    pinch_random_seed(&random, 51);
    for (int i = 0; i < 100000 && (held < count || unstable < count); i++) {
        test_grasp g;
        grasp_random(&random, &g);
        if (!suitable(&g)) continue;
        pinch_statics_settings settings = pinch_default_statics_settings();
        pinch_finger_result f[GRASP_MAX_FINGERS];
        pinch_statics_result r;
        assert_int_equal(pinch_statics_solve(statics, &g.grasp, &settings, f, &r), PINCH_OK);
        if (r.solve.status == PINCH_SOLVE_UNSTABLE && unstable < count) {
            unstable++;
            bool gone = move(&m, &g.grasp, LEFT, false);
            left += gone;
            unsolved += m.lost_count;
            if (!gone) print_message("grasp %d: %s\n", i, m.lost_count ? "a step was not solved" : "stayed");
        }
        if (r.solve.status == PINCH_SOLVE_CONVERGED && held < count) {
            bool gone = move(&m, &g.grasp, GONE, false);
            double worst = 0.0;
            for (int k = 0; k < g.grasp.finger_count; k++)
                for (int j = 0; j < 4; j++)
                    if (j < 3 || f[k].r[3] != 0.0)
                        worst = fmax(worst, fabs(m.contacts[k].force[j] - f[k].r[j]) / (j < 3 ? 1.0 : g.grasp.radius));
            difference[held++] = gone || m.lost_count ? 1.0 : worst / r.verification.force_scale;
            stayed += !gone && !m.lost_count;
            same += difference[held - 1] <= 0.01;
            if (difference[held - 1] > 0.01)
                print_message("grasp %d: held, %s, forces differ by %.2g\n", i,
                              m.lost_count ? "a step was not solved"
                              : gone       ? "left"
                                           : "stayed",
                              difference[held - 1]);
        }
    }
    pinch_step_solver_destroy(m.solver);
    pinch_statics_destroy(statics);
    qsort(difference, (size_t)held, sizeof *difference, ascending);
    print_message(
        "%d of %d unstable ones left (%d not solved), %d of %d held ones stayed; forces differ by %.2g in the "
        "median, %.2g in nine of ten\n",
        left, unstable, unsolved, stayed, held, difference[held / 2], difference[held * 9 / 10]);
    assert_int_equal(unstable, count);
    /* Where the object has no equilibrium for a while it moves freely, and where it comes to rest may depend on its
     * mass and the speed of the load: over other seeds 1 of 2,400 unstable ones was caught by chance, and 1 in 40 held
     * ones ends with forces that differ by more than 1 % of the force scale. */
    assert_int_equal(left, unstable);
    assert_int_equal(unsolved, 0);
    assert_int_equal(stayed, held);
    assert_true(same >= held - held / 20);
    assert_true(difference[held / 2] <= 1e-4);
}

/* Three hard fingers on faces of a cube that meet in a corner, with round numbers; no load. */
static void draw_corner(pinch_random *random, test_grasp *g)
{
    static const double CLOSING[] = {2e-4, 5e-4, 1e-3}, HALF = 0.05;
    double friction = 0.1 * (6 + draw_index(random, 8));
    memset(g, 0, sizeof *g);
    g->grasp = (pinch_grasp){.finger_count = 3, .fingers = g->fingers, .radius = HALF * sqrt(3.0)};
    for (int i = 0; i < 3; i++) {
        pinch_finger *f = &g->fingers[i];
        *f = (pinch_finger){.model = PINCH_CONTACT_HARD,
                            .stiffness = {1e4, 2e4 / 3},
                            .friction = friction,
                            .closing = CLOSING[draw_index(random, 3)],
                            .max_force = INFINITY};
        for (int j = 0; j < 3; j++) f->point[j] = 0.01 * (draw_index(random, 7) - 3);
        f->point[i] = i < 2 ? -HALF : HALF;
        grasp_set_normal(f, i == 0, i == 1, -(i == 2));
    }
}

/* Returns the largest normal force, N. */
static double press(const pinch_finger_result *f, int fingers)
{
    double most = 0.0;
    for (int k = 0; k < fingers; k++) most = fmax(most, f[k].r[0]);
    return most;
}

/* All forces of such a grasp grow in proportion, and the object beside its fingers is an equilibrium, too. */
static void what_a_slow_closing_holds_is_held(void **state)
{
    (void)state;
    enum { CORNERS = 100 };
    int held = 0, same = 0, lost = 0;
    pinch_statics *statics;
    motion m;
    assert_int_equal(pinch_statics_create(GRASP_MAX_FINGERS, 0, &statics), PINCH_OK);
    assert_int_equal(pinch_step_solver_create(&m.solver), PINCH_OK);
    pinch_random random;
    pinch_random_seed(&random, 3);
    for (int i = 0; i < 100000 && held < CORNERS; i++) {
        test_grasp g;
        draw_corner(&random, &g);
        pinch_statics_settings settings = pinch_default_statics_settings();
        pinch_finger_result f[3];
        pinch_statics_result r;
        settings.one_step = true;
        assert_int_equal(pinch_statics_solve(statics, &g.grasp, &settings, f, &r), PINCH_OK);
        if (r.solve.status != PINCH_SOLVE_CONVERGED || press(f, 3) < 0.1) continue;
        settings.one_step = false;
        assert_int_equal(pinch_statics_solve(statics, &g.grasp, &settings, f, &r), PINCH_OK);
        if (move(&m, &g.grasp, GONE, true) || m.lost_count || m.contacts[0].force[0] < 0.1) continue;
        held++;
        double worst = 0.0;
        for (int k = 0; k < 3; k++)
            for (int j = 0; j < 3; j++) worst = fmax(worst, fabs(m.contacts[k].force[j] - f[k].r[j]));
        bool close = r.solve.status == PINCH_SOLVE_CONVERGED && worst <= 0.01 * r.verification.force_scale;
        same += close;
        lost += r.solve.status != PINCH_SOLVE_CONVERGED || press(f, 3) < 0.01;
        if (!close) print_message("corner %d: forces differ by %.2g N\n", i, worst);
    }
    pinch_step_solver_destroy(m.solver);
    pinch_statics_destroy(statics);
    print_message("%d of %d corners have the forces of a slow closing, %d are lost\n", same, held, lost);
    assert_int_equal(held, CORNERS);
    assert_int_equal(lost, 0);
    /* which fingers slip first depends on how the object swings, too */
    assert_true(same >= held - held / 10);
}

int main(int argc, char **argv)
{
    if (getenv("PINCH_TEST_FULL") || (argc > 1 && strcmp(argv[1], "--full") == 0)) count = 100;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_unstable_leaves_and_what_is_held_stays),
        cmocka_unit_test(what_a_slow_closing_holds_is_held),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
