/* What a floor of compliance falsifies: how far forces are from the law as prescribed, and when the step says that it
 * is too soft to count as converged. */
#include "support/cmocka_all.h"

#include <math.h>
#include <pinch/problem.h>
#include <string.h>

static const double GRAVITY = 9.81, ERP = 0.2, CFM = 1e-12, LIGHT = 1, HEAVY = 100;

enum { BALLS = 22 };

/* Pairs of balls, a heavy one on a light one, and that on the ground, on contacts that were solved with this floor
 * before. */
typedef struct column {
    pinch_body bodies[BALLS];
    pinch_contact contacts[BALLS];
    pinch_contact asked[BALLS]; /* as prescribed */
    pinch_problem problem;
    double inertia[BALLS]; /* W of the contacts, 1/kg */
} column;

static void add_ball(column *l, int b, double mass, double radius)
{
    pinch_body *body = &l->bodies[b];
    body->mass = mass;
    body->radius = radius;
    for (int i = 0; i < 3; i++) body->inertia[4 * i] = 0.4 * mass * radius * radius;
    body->position[2] = radius * (2 * (b % 2) + 1);
    body->velocity[2] = -l->problem.step * GRAVITY;
}

static void add_contact(column *l, int k, double load, double floor)
{
    double h = l->problem.step, softened = fmax(CFM, floor * h * l->inertia[k]);
    pinch_contact *c = &l->contacts[k];
    c->body1 = k;
    c->body2 = k % 2 == 0 ? PINCH_STATIC_BODY : k - 1;
    c->model = PINCH_CONTACT_FRICTIONLESS;
    memcpy(c->position, l->bodies[k].position, sizeof c->position);
    c->position[2] -= l->bodies[k].radius;
    c->normal[2] = c->tangent1[0] = 1;
    for (int i = 0; i < 3; i++) {
        c->stiffness[i] = ERP / (h * CFM);
        c->damping[i] = (1 - ERP) / CFM;
    }
    c->depth = load * h * softened / ERP; /* where it rests at that floor */
    c->max_force = INFINITY;
    c->may_soften = true;
    c->floor = floor;
    c->force[0] = load;
    l->asked[k] = *c;
}

static void make(column *l, int balls, double h, double radius, double floor)
{
    memset(l, 0, sizeof *l);
    l->problem = (pinch_problem){
        .step = h, .body_count = balls, .contact_count = balls, .bodies = l->bodies, .contacts = l->contacts};
    for (int k = 0; k < balls; k += 2) {
        l->inertia[k] = 1 / LIGHT;
        l->inertia[k + 1] = 1 / LIGHT + 1 / HEAVY;
        add_ball(l, k, LIGHT, radius);
        add_ball(l, k + 1, HEAVY, radius);
        add_contact(l, k, (LIGHT + HEAVY) * GRAVITY, floor);
        add_contact(l, k + 1, HEAVY * GRAVITY, floor);
    }
}

static pinch_step_result solve_in(column *l, int iterations)
{
    pinch_step_solver *solver;
    pinch_step_result result;
    pinch_solver_settings settings = pinch_default_solver_settings();
    settings.max_iterations = iterations;
    assert_int_equal(pinch_step_solver_create(&solver), PINCH_OK);
    assert_int_equal(pinch_step_solve(solver, &l->problem, &settings, &result), PINCH_OK);
    pinch_step_solver_destroy(solver);
    assert_int_equal(result.solve.status, PINCH_SOLVE_CONVERGED);
    return result;
}

/* From other forces than those at rest the floor's answer takes an iteration, and none is left for a stiffer floor. */
static pinch_step_result solve_at_floor(column *l)
{
    for (int k = 0; k < l->problem.contact_count; k++) l->contacts[k].force[0] *= 0.5;
    pinch_step_result result = solve_in(l, 1);
    int level = (int)fmax(0, ceil(log(l->asked[0].floor / 1e-4) / log(5) - 1e-6));
    assert_int_equal(result.floor_level, level);
    return result;
}

static pinch_step_result solve(column *l)
{
    return solve_in(l, pinch_default_solver_settings().max_iterations);
}

/* The law that was asked for, written out, in the measure of stiff contacts: a force and the velocity that it brings.
 */
static double missed(const column *l)
{
    double most = 0, h = l->problem.step;
    for (int k = 0; k < BALLS; k++) {
        const pinch_contact *c = &l->contacts[k], *asked = &l->asked[k];
        double w = l->bodies[k].velocity_end[2] - (k % 2 ? l->bodies[k - 1].velocity_end[2] : 0);
        double law = asked->stiffness[0] * (asked->depth - h * w) - asked->damping[0] * w;
        most = fmax(most, fabs(c->force[0] - fmax(law, 0)) * CFM / (CFM + h * l->inertia[k]));
    }
    return most;
}

static void test_a_floor_falsifies_forces_by_its_own_size(void **state)
{
    (void)state;
    static const double floors[] = {1e-4, 5e-4, 2.5e-3, 0.9e-2, 1.1e-2, 1.25e-2, 6.25e-2};
    for (size_t i = 0; i < sizeof floors / sizeof *floors; i++) {
        column l;
        make(&l, BALLS, 1e-3, 0.1, floors[i]);
        pinch_step_result r = solve_at_floor(&l);
        assert_close(r.floor_residual, missed(&l), 1e-6 * r.floor_residual);
        assert_close(r.floor_residual, floors[i] * r.force_scale, 1e-3 * r.floor_residual);
        assert_int_equal(r.too_soft, floors[i] > 1e-2);
    }
}

/* The load sinks by load h C/ERP more, C being what the floor makes of the compliance, and the heavy ball with both
 * contacts below it. */
static void test_small_bodies_may_not_sink(void **state)
{
    (void)state;
    static const double floor = 1e-3, h = 5e-3;
    double inertia = 1 / LIGHT + 1 / HEAVY; /* of the contact between the balls, which sinks more */
    double sinks = HEAVY * GRAVITY * h * (floor * h * inertia - CFM) / ERP;
    double both = sinks + (LIGHT + HEAVY) * GRAVITY * h * (floor * h / LIGHT - CFM) / ERP;
    for (int is_small = 0; is_small < 2; is_small++) {
        column l;
        make(&l, BALLS, h, (is_small ? 0.98 : 1.02) * both / 1e-2 / 2, floor);
        pinch_step_result r = solve_at_floor(&l);
        assert_close(r.floor_depth, sinks, 1e-6 * sinks);
        assert_true(r.floor_residual < 1e-2 * r.force_scale);
        assert_int_equal(r.too_soft, is_small);
    }
}

/* Equal balls in one column: each sinks with all contacts below it, none of which sinks far by itself. */
static void test_courses_add_up(void **state)
{
    (void)state;
    static const double floor = 1e-3, h = 5e-3;
    for (int is_small = 0; is_small < 2; is_small++) {
        column l;
        double most = 0, all = 0;
        make(&l, BALLS, h, 1, floor);
        for (int k = 0; k < BALLS; k++) {
            l.inertia[k] = k > 0 ? 2 / LIGHT : 1 / LIGHT;
            double load = (BALLS - k) * LIGHT * GRAVITY, sinks = load * h * (floor * h * l.inertia[k] - CFM) / ERP;
            all += sinks;
            most = fmax(most, sinks);
        }
        assert_true(all > 10 * most);
        double radius = (is_small ? 0.98 : 1.02) * all / 1e-2 / 2;
        memset(l.bodies, 0, sizeof l.bodies);
        memset(l.contacts, 0, sizeof l.contacts);
        for (int k = 0; k < BALLS; k++) {
            add_ball(&l, k, LIGHT, radius);
            l.bodies[k].position[2] = (2 * k + 1) * radius;
            add_contact(&l, k, (BALLS - k) * LIGHT * GRAVITY, floor);
            l.contacts[k].body2 = k > 0 ? k - 1 : PINCH_STATIC_BODY;
        }
        pinch_step_result r = solve_at_floor(&l);
        assert_close(r.floor_depth, most, 1e-6 * most);
        assert_true(r.floor_residual < 1e-2 * r.force_scale);
        assert_int_equal(r.too_soft, is_small);
    }
}

/* Whatever step raised it, a floor that would not count is left where the stiffer one has an answer. */
static void test_a_floor_that_would_not_count_is_left(void **state)
{
    (void)state;
    static const double floors[] = {1.1e-2, 6.25e-2, 0.3};
    for (size_t i = 0; i < sizeof floors / sizeof *floors; i++) {
        column l;
        for (int balls = 2; balls <= BALLS; balls += BALLS - 2) {
            make(&l, balls, 1e-3, 0.1, floors[i]);
            pinch_step_result r = solve(&l);
            assert_true(r.gave_way && !r.too_soft);
            assert_true(l.contacts[0].floor <= 1e-2);
        }
    }
}

/* Small balls that sink too far at a floor which would count for larger ones, the first floor, too, have a stiffer one.
 */
static void test_a_floor_that_lets_bodies_sink_is_left(void **state)
{
    (void)state;
    static const double floors[] = {1e-4, 1e-3}, h = 5e-3;
    for (int i = 0; i < 2; i++)
        for (int balls = 2; balls <= BALLS; balls += BALLS - 2) {
            column l;
            double sinks = HEAVY * GRAVITY * h * h * floors[i] * (1 / LIGHT + 1 / HEAVY) / ERP;
            make(&l, balls, h, 0.8 * sinks / 1e-2 / 2, floors[i]);
            pinch_step_result r = solve(&l);
            assert_true(r.gave_way && !r.too_soft);
            assert_true(l.contacts[0].floor < floors[i]);
        }
}

/* A ball between two walls that are too close overlaps with both of them at any floor, and the force is larger by what
 * the floor is stiffer. That is no softening, and stays as it is. */
static void test_a_jam_is_not_too_soft(void **state)
{
    (void)state;
    static const double floors[] = {1e-4, 1e-3, 5e-3}, h = 5e-3, RADIUS = 0.05, OVERLAP = 3e-3;
    for (size_t i = 0; i < sizeof floors / sizeof *floors; i++) {
        column l;
        make(&l, 2, h, RADIUS, floors[i]);
        l.problem.body_count = 1;
        l.bodies[0].velocity[2] = 0;
        l.contacts[1].body1 = 0;
        l.contacts[1].body2 = PINCH_STATIC_BODY;
        l.contacts[1].normal[2] = -1;
        for (int k = 0; k < 2; k++) {
            l.contacts[k].depth = OVERLAP;
            l.contacts[k].force[0] = 0;
        }
        pinch_step_result r = solve(&l);
        double pressed = ERP * OVERLAP / h / (floors[i] * h / LIGHT);
        assert_close(l.contacts[0].force[0], pressed, 1e-6 * pressed);
        assert_close(l.contacts[1].force[0], pressed, 1e-6 * pressed);
        assert_true(OVERLAP > 1e-2 * 2 * RADIUS && r.floor_depth < 1e-6 * OVERLAP);
        assert_false(r.too_soft);
    }
}

/* A joint that is said twice holds a ball which is pressed against it. Contact and joint share the overlap by how
 * compliant they are, and a floor that is much softer than the joint would leave all of it to the contact. */
static void test_a_jam_against_joints_is_shared(void **state)
{
    (void)state;
    static const double floor = 1e-6, h = 5e-3, RADIUS = 0.05, OVERLAP = 3e-3, YIELD = 1e-9;
    column l;
    make(&l, 2, h, RADIUS, floor);
    pinch_joint_row row = {.body1 = 0,
                           .body2 = PINCH_STATIC_BODY,
                           .j1 = {0, 0, 1},
                           .yield = YIELD,
                           .low = -INFINITY,
                           .high = INFINITY},
                    rows[2] = {row, row};
    l.problem.body_count = l.problem.contact_count = 1;
    l.problem.row_count = 2;
    l.problem.rows = rows;
    l.bodies[0].velocity[2] = 0;
    l.contacts[0].depth = OVERLAP;
    pinch_step_result r = solve(&l);
    const pinch_contact *c = &l.contacts[0];
    assert_true(r.gave_way && !r.too_soft);
    assert_true(c->compliance[0] < YIELD / 2 && c->compliance[0] < floor * h / LIGHT);
    assert_close(c->floor, floor, 1e-15); /* the next step begins no stiffer than that */
    double pressed = ERP * OVERLAP / h / (c->compliance[0] + YIELD / 2);
    assert_close(c->force[0], pressed, 1e-6 * pressed);
    for (int k = 0; k < 2; k++) {
        assert_close(rows[k].force, -pressed / 2, 1e-6 * pressed);
        assert_close(rows[k].violation, -l.bodies[0].velocity_end[2], 1e-9);
    }
}

/* Contacts that are as soft as that by themselves are solved as they were asked for. */
static void test_soft_contacts_are_not_too_soft(void **state)
{
    (void)state;
    column l;
    make(&l, BALLS, 1e-3, 0.1, 6.25e-2);
    for (int k = 0; k < BALLS; k++)
        for (int i = 0; i < 3; i++) {
            l.contacts[k].stiffness[i] *= CFM / 1e-3;
            l.contacts[k].damping[i] *= CFM / 1e-3;
        }
    pinch_step_result r = solve(&l);
    assert_close(r.floor_residual, 0, 0);
    assert_close(r.floor_depth, 0, 0);
    assert_false(r.too_soft);
}

/* A floor stays for its steps; then it is lowered where it lets something sink, the less the longer it has stayed, and
 * where it does not, how often it was raised is forgotten. */
static void test_a_floor_stays_for_its_steps(void **state)
{
    (void)state;
    enum { HOLD = 3 };
    static const double floor = 1e-3, h = 5e-3;
    static const int spans[] = {0, 20, 40, 1280};
    static const double lowered[] = {0.95, 0.95, 0.975, 1 - 0.05 / 64};
    for (int i = 0; i < 12; i++) {
        column l;
        bool held = i % 3 == 0, sinks = i % 3 < 2;
        int span = spans[i / 3];
        make(&l, BALLS, h, sinks ? 0.1 : 100, floor);
        for (int k = 0; k < BALLS; k++) {
            l.contacts[k].hold = held ? HOLD : 0;
            l.contacts[k].hold_span = span;
        }
        (void)solve_at_floor(&l);
        for (int k = 0; k < BALLS; k++) {
            assert_int_equal(l.contacts[k].hold, held ? HOLD - 1 : 0);
            assert_int_equal(l.contacts[k].hold_span, sinks ? span : 0);
            assert_close(l.contacts[k].floor, held || !sinks ? floor : lowered[i / 3] * floor, 1e-15);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_floor_falsifies_forces_by_its_own_size),
        cmocka_unit_test(test_small_bodies_may_not_sink),
        cmocka_unit_test(test_courses_add_up),
        cmocka_unit_test(test_a_floor_that_would_not_count_is_left),
        cmocka_unit_test(test_a_floor_that_lets_bodies_sink_is_left),
        cmocka_unit_test(test_a_jam_is_not_too_soft),
        cmocka_unit_test(test_a_jam_against_joints_is_shared),
        cmocka_unit_test(test_soft_contacts_are_not_too_soft),
        cmocka_unit_test(test_a_floor_stays_for_its_steps),
    };
    return cmocka_run_group_tests_name("floors", tests, NULL, NULL);
}
