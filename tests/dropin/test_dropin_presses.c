/*
 * Motors of limited force press bodies into each other, into springs and onto thin sheets. They meet with some overlap,
 * as steps are long, and come out of it against the motors. Then they lie on each other, as rigid bodies do.
 */
#include "support/cmocka_all.h"

#include <ode/ode.h>

#include <math.h>
#include <pinch/ode_dropin.h>
#include <string.h>

enum { MOST_BODIES = 5, MOST_FOUND = 16 };

typedef struct press {
    dWorldID world;
    dJointGroupID contacts;
    dGeomID geom[MOST_BODIES];
    int count;
    double step;
    pinch_dropin_stats before;
} press;

static void begin(press *p, double step)
{
    memset(p, 0, sizeof *p);
    p->step = step;
    p->world = dWorldCreate();
    p->contacts = dJointGroupCreate(0);
    p->before = pinch_dropin_statistics();
}

static dBodyID add_box(press *p, double mass, double x, double y, double z)
{
    dMass m;
    dBodyID body = dBodyCreate(p->world);
    dMassSetBoxTotal(&m, mass, x, y, z);
    dBodySetMass(body, &m);
    p->geom[p->count] = dCreateBox(NULL, x, y, z);
    dGeomSetBody(p->geom[p->count++], body);
    return body;
}

/* Puts a body on a slider, whose motor moves it along at a speed (m/s) by no more than a force (N). */
static dJointID add_slider(press *p, dBodyID body, double speed, double force)
{
    dJointID slider = dJointCreateSlider(p->world, NULL);
    dJointAttach(slider, body, NULL);
    dJointSetSliderAxis(slider, 1, 0, 0);
    dJointSetSliderParam(slider, dParamVel, speed);
    dJointSetSliderParam(slider, dParamFMax, force);
    return slider;
}

/* Steps on for a time (s). Geoms meet their neighbours in the order in which they were added. */
static void run(press *p, double time)
{
    dContact found[MOST_FOUND];
    for (long n = 0, steps = lround(time / p->step); n < steps; n++) {
        for (int i = 0; i + 1 < p->count; i++) {
            memset(found, 0, sizeof found);
            int count = dCollide(p->geom[i], p->geom[i + 1], MOST_FOUND, &found->geom, sizeof *found);
            for (int k = 0; k < count; k++) {
                found[k].surface.mode = dContactApprox1;
                found[k].surface.mu = 0.3;
                dJointAttach(dJointCreateContact(p->world, p->contacts, &found[k]), dGeomGetBody(p->geom[i]),
                             dGeomGetBody(p->geom[i + 1]));
            }
        }
        dWorldStep(p->world, p->step);
        dJointGroupEmpty(p->contacts);
    }
}

static void end(press *p)
{
    pinch_dropin_stats after = pinch_dropin_statistics();
    assert_int_equal(after.ode.contacts_left, p->before.ode.contacts_left);
    assert_int_equal(after.ode.fallback_islands, p->before.ode.fallback_islands);
    for (int i = 0; i < p->count; i++) dGeomDestroy(p->geom[i]);
    dJointGroupDestroy(p->contacts);
    dWorldDestroy(p->world);
}

/* A body that is pressed onto another one is in it by next to nothing. */
static void assert_lies_within(double overlap, double most)
{
    assert_close(overlap, 0.5 * most, 0.5 * most);
}

static const double EDGE = 0.02, JAW = 0.01;

/* Makes a row of cubes between two jaws that motors of 50 N close, or one motor against a jaw that does not move.
 * Returns how far (m) all of them are in each other after a time. */
static double overlap_of_row(double step, int cubes, bool both_drive, double time)
{
    static const double GAP = 1e-4, SPEED = 0.3, FORCE = 50;
    press p;
    begin(&p, step);
    double pitch = EDGE + GAP, half = 0.5 * cubes * pitch + 0.5 * JAW + 0.1 * JAW;
    dBodyID left = add_box(&p, 0.05, JAW, EDGE, EDGE);
    dBodySetPosition(left, -half, 0, 0);
    for (int i = 0; i < cubes; i++)
        dBodySetPosition(add_box(&p, 0.05, EDGE, EDGE, EDGE), (i - 0.5 * (cubes - 1)) * pitch, 0, 0);
    dBodyID right = add_box(&p, 0.05, JAW, EDGE, EDGE);
    dBodySetPosition(right, half, 0, 0);
    add_slider(&p, left, SPEED, FORCE);
    if (both_drive)
        add_slider(&p, right, -SPEED, FORCE);
    else
        dBodySetKinematic(right);
    run(&p, time);
    double between = dBodyGetPosition(right)[0] - dBodyGetPosition(left)[0] - JAW;
    end(&p);
    return cubes * EDGE - between;
}

/* A jaw that is pushed back has to go back by the sum of all overlaps between it and what does not give way. */
static void test_overlaps_in_a_row(void **state)
{
    (void)state;
    static const double LITTLE = 1e-4;
    assert_lies_within(overlap_of_row(0.005, 1, false, 1), LITTLE);
    assert_lies_within(overlap_of_row(0.01, 1, false, 1), LITTLE);
    assert_lies_within(overlap_of_row(0.01, 3, true, 1), LITTLE);
    assert_lies_within(overlap_of_row(0.01, 1, true, 1), LITTLE);
}

/* Puts a body on a slider with a spring (N/m, N s/m) that holds it where it is. */
static void add_spring(press *p, dBodyID body, double stiffness, double damping)
{
    dJointID slider = add_slider(p, body, 0, 0);
    double sum = p->step * stiffness + damping;
    dJointSetSliderParam(slider, dParamLoStop, 0);
    dJointSetSliderParam(slider, dParamHiStop, 0);
    dJointSetSliderParam(slider, dParamStopERP, p->step * stiffness / sum);
    dJointSetSliderParam(slider, dParamStopCFM, 1 / sum);
}

/* A motor of 20 N presses a pad onto a body that a spring of 2,000 N/m and 20 N s/m holds: it goes back by 10 mm, and
 * the pad lies on it. */
static void test_against_a_spring(void **state)
{
    (void)state;
    static const double FORCE = 20, STIFFNESS = 2000, DAMPING = 20, STEPS[2] = {0.01, 0.002};
    for (int i = 0; i < 2; i++) {
        press p;
        begin(&p, STEPS[i]);
        dBodyID pad = add_box(&p, 0.05, EDGE, EDGE, EDGE), held = add_box(&p, 0.05, EDGE, EDGE, EDGE);
        dBodySetPosition(pad, -EDGE - 1e-4, 0, 0);
        add_spring(&p, held, STIFFNESS, DAMPING);
        add_slider(&p, pad, 0.5, FORCE);
        run(&p, 2);
        double at = dBodyGetPosition(held)[0];
        assert_close(at, FORCE / STIFFNESS, 1e-6);
        assert_lies_within(dBodyGetPosition(pad)[0] + EDGE - at, 1e-4);
        end(&p);
    }
}

/* A body that moves whatever it meets pushes another one against a spring, stops, and stays where it is. It has done
 * all the work, and nothing is left to be made up for. */
static void test_driven_onto_a_spring(void **state)
{
    (void)state;
    static const double STEP = 0.0005, STIFFNESS = 1e5, DAMPING = 10, SPEED = 0.1, TIME = 0.2;
    press p;
    begin(&p, STEP);
    dBodyID pusher = add_box(&p, 1, EDGE, EDGE, EDGE), pushed = add_box(&p, 0.2, EDGE, EDGE, EDGE);
    dBodyID held = add_box(&p, 0.05, EDGE, EDGE, EDGE);
    dBodySetKinematic(pusher);
    dBodySetPosition(pusher, -EDGE - 1e-4, 0, 0);
    dBodySetPosition(held, EDGE + 1e-4, 0, 0);
    add_spring(&p, held, STIFFNESS, DAMPING);
    dBodySetLinearVel(pusher, SPEED, 0, 0);
    run(&p, TIME);
    dBodySetLinearVel(pusher, 0, 0, 0);
    run(&p, 1);
    assert_lies_within(dBodyGetPosition(pusher)[0] + EDGE - dBodyGetPosition(pushed)[0], 1e-5);
    assert_lies_within(dBodyGetPosition(pushed)[0] + EDGE - dBodyGetPosition(held)[0], 1e-5);
    assert_close(dBodyGetPosition(held)[0], SPEED * TIME + EDGE - 1e-4, 1e-5);
    end(&p);
}

/* A block of 2 kg lies on a sheet of 10 g and 2 mm, which a motor pulls along. A light body may not sink in by a
 * hundredth of its length: it may by one of its thickness for long, and comes up from what a jerk does to it. */
static void test_on_a_thin_sheet(void **state)
{
    (void)state;
    static const double STEP = 0.01, THICKNESS = 0.002, PULL = 2; /* m/s^2 */
    press p;
    begin(&p, STEP);
    dWorldSetGravity(p.world, 0, 0, -9.81);
    dBodyID table = add_box(&p, 1, 4, 2, 0.1), sheet = add_box(&p, 0.01, 0.8, 0.3, THICKNESS);
    dBodyID block = add_box(&p, 2, 0.1, 0.1, 0.1);
    dBodySetKinematic(table);
    dBodySetPosition(table, 0, 0, -0.05);
    dBodySetPosition(sheet, 0, 0, 0.5 * THICKNESS);
    dBodySetPosition(block, 0, 0, THICKNESS + 0.05);
    dJointID motor = dJointCreateLMotor(p.world, NULL);
    dJointAttach(motor, sheet, NULL);
    dJointSetLMotorNumAxes(motor, 1);
    dJointSetLMotorAxis(motor, 0, 0, 1, 0, 0);
    dJointSetLMotorParam(motor, dParamFMax, 1000);
    run(&p, 0.2);
    double deepest = 0;
    for (double speed = PULL * STEP; speed < 0.6; speed += PULL * STEP) {
        dJointSetLMotorParam(motor, dParamVel, speed);
        run(&p, STEP);
        deepest = fmax(deepest, 0.5 * THICKNESS - dBodyGetPosition(sheet)[2]);
    }
    assert_true(dBodyGetLinearVel(sheet)[0] > 0.55);
    assert_lies_within(deepest, 0.25 * THICKNESS);
    assert_lies_within(0.5 * THICKNESS - dBodyGetPosition(sheet)[2], 0.01 * THICKNESS);
    end(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_overlaps_in_a_row),
        cmocka_unit_test(test_against_a_spring),
        cmocka_unit_test(test_driven_onto_a_spring),
        cmocka_unit_test(test_on_a_thin_sheet),
    };
    dInitODE2(0);
    int failed = cmocka_run_group_tests_name("dropin_presses", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
