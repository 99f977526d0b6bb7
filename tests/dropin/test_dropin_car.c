/*
 * A car runs on hinge-2 joints. ODE has no getters for some of their state, which was noted when the axes were set, so
 * that Pinch solves the whole car. It stands on a slope with its brakes on and drives; in the air ODE solves it.
 */
#include "support/cmocka_all.h"

#define PINCH_DROPIN_NO_MACROS
#include <ode/ode.h>

#include <math.h>
#include <pinch/ode_dropin.h>
#include <string.h>

enum { WHEELS = 4, STEPS_A_SECOND = 200 };
static const double H = 1.0 / STEPS_A_SECOND, RADIUS = 0.25, BEFORE = 0.6, BESIDE = 0.55, TILT = 0.2; /* m, m, m, rad */

/* How the axes are set; UNSEEN: by ODE's own functions, which Pinch does not see. */
typedef enum axes_by { AXES = 0, ONE_BY_ONE, ATTACHED_AGAIN, UNSEEN, WAYS } axes_by;

typedef struct car {
    bool with_pinch;
    dWorldID world;
    dSpaceID space;
    dJointGroupID contacts;
    dBodyID chassis, wheel[WHEELS];
    dJointID joint[WHEELS];
    bool touches;
} car;

/* The steering axis leans by TILT: the angle that is to be kept is not a right one. */
static void set_axes(dJointID joint, axes_by by)
{
    const dVector3 up = {0, sin(TILT), cos(TILT)}, across = {0, 1, 0};
    if (by == AXES || by == ATTACHED_AGAIN) {
        pinch_dropin_joint_set_hinge2_axes(joint, up, across);
    } else if (by == ONE_BY_ONE) {
        pinch_dropin_joint_set_hinge2_axis1(joint, up[0], up[1], up[2]);
        pinch_dropin_joint_set_hinge2_axis2(joint, across[0], across[1], across[2]);
    } else {
        dJointSetHinge2Axes(joint, up, across);
    }
}

static void add_wheel(car *c, int k, axes_by by, double z)
{
    double x = k < 2 ? BEFORE : -BEFORE, y = k % 2 ? BESIDE : -BESIDE;
    dMass mass;
    dMassSetSphereTotal(&mass, 2, RADIUS);
    c->wheel[k] = dBodyCreate(c->world);
    dBodySetMass(c->wheel[k], &mass);
    dBodySetPosition(c->wheel[k], x, y, z);
    dGeomSetBody(dCreateSphere(c->space, RADIUS), c->wheel[k]);
    c->joint[k] = by == UNSEEN ? dJointCreateHinge2(c->world, NULL) : pinch_dropin_joint_create_hinge2(c->world, NULL);
    if (by == UNSEEN)
        dJointAttach(c->joint[k], c->chassis, c->wheel[k]);
    else
        pinch_dropin_joint_attach(c->joint[k], c->chassis, c->wheel[k]);
    dJointSetHinge2Anchor(c->joint[k], x, y, z);
    set_axes(c->joint[k], by);
    if (by == ATTACHED_AGAIN) { /* ODE takes the angle anew */
        dBodyID chassis = dJointGetBody(c->joint[k], 0);
        pinch_dropin_joint_attach(c->joint[k], NULL, NULL);
        pinch_dropin_joint_attach(c->joint[k], chassis, c->wheel[k]);
    }
    dJointSetHinge2Param(c->joint[k], dParamLoStop, 0);
    dJointSetHinge2Param(c->joint[k], dParamHiStop, 0);
    dJointSetHinge2Param(c->joint[k], dParamSuspensionERP, 0.4);
    dJointSetHinge2Param(c->joint[k], dParamSuspensionCFM, 0.002);
}

static void make(car *c, axes_by by, bool with_pinch, double height)
{
    memset(c, 0, sizeof *c);
    c->with_pinch = with_pinch;
    c->world = dWorldCreate();
    c->space = dHashSpaceCreate(NULL);
    c->contacts = dJointGroupCreate(0);
    dWorldSetGravity(c->world, 0, 0, -9.81);
    dCreatePlane(c->space, 0, 0, 1, 0);
    dMass mass;
    c->chassis = dBodyCreate(c->world);
    dMassSetBoxTotal(&mass, 20, 1.6, 0.8, 0.2);
    dBodySetMass(c->chassis, &mass);
    dBodySetPosition(c->chassis, 0, 0, height + RADIUS + 0.2);
    for (int k = 0; k < WHEELS; k++) add_wheel(c, k, by, height + RADIUS);
    dRandSetSeed(1);
    pinch_dropin_reset_statistics();
}

static void destroy(car *c)
{
    dJointGroupDestroy(c->contacts);
    dSpaceDestroy(c->space);
    pinch_dropin_world_destroy(c->world);
}

/* Motors of the wheels: to this speed, rad/s, with this torque at most, N m. */
static void drive(car *c, double speed, double torque)
{
    for (int k = 0; k < WHEELS; k++) {
        dJointSetHinge2Param(c->joint[k], dParamVel2, speed);
        dJointSetHinge2Param(c->joint[k], dParamFMax2, torque);
    }
}

static void near_callback(void *data, dGeomID a, dGeomID b)
{
    car *c = data;
    dContact contact[4];
    memset(contact, 0, sizeof contact);
    if (dGeomGetBody(a) && dGeomGetBody(b)) return;
    int count = dCollide(a, b, 4, &contact[0].geom, sizeof contact[0]);
    for (int i = 0; i < count; i++) {
        contact[i].surface.mode = dContactApprox1;
        contact[i].surface.mu = 1;
        dJointID joint = c->with_pinch ? pinch_dropin_joint_create_contact(c->world, c->contacts, &contact[i])
                                       : dJointCreateContact(c->world, c->contacts, &contact[i]);
        dJointAttach(joint, dGeomGetBody(a), dGeomGetBody(b));
        c->touches = true;
    }
}

static void step(car *c, double seconds)
{
    for (int i = 0; i < seconds * STEPS_A_SECOND; i++) {
        dSpaceCollide(c->space, c, near_callback);
        assert_int_equal(c->with_pinch ? pinch_dropin_world_quick_step(c->world, H) : dWorldQuickStep(c->world, H), 1);
        if (c->with_pinch)
            pinch_dropin_joint_group_empty(c->contacts);
        else
            dJointGroupEmpty(c->contacts);
    }
}

static double speed_of(const car *c)
{
    double most = dCalcVectorLength3(dBodyGetLinearVel(c->chassis));
    for (int k = 0; k < WHEELS; k++) most = fmax(most, dCalcVectorLength3(dBodyGetLinearVel(c->wheel[k])));
    return most;
}

/* The farthest that an axle's angle with its steering axis is from what was made, rad. */
static double bent(const car *c)
{
    double most = 0;
    for (int k = 0; k < WHEELS; k++) {
        dVector3 up, across;
        dJointGetHinge2Axis1(c->joint[k], up);
        dJointGetHinge2Axis2(c->joint[k], across);
        double off = fabs(asin(dCalcVectorDot3(up, across)) - TILT);
        assert_true(off >= 0);
        most = fmax(most, off);
    }
    return most;
}

/* On a slope of 3 degrees, whichever way the joints were made; those that Pinch could not see are ODE's. */
static void a_car_stands_with_its_brakes_on(void **state)
{
    (void)state;
    car native;
    make(&native, UNSEEN, false, 0);
    dWorldSetGravity(native.world, 0.5, 0, -9.8);
    drive(&native, 0, 100);
    step(&native, 4);
    for (axes_by by = 0; by < WAYS; by++) {
        car c;
        make(&c, by, true, 0);
        dWorldSetGravity(c.world, 0.5, 0, -9.8);
        drive(&c, 0, 100);
        step(&c, 4);
        pinch_ode_stats stats = pinch_dropin_statistics().ode;
        if (by == UNSEEN) {
            assert_true(stats.joints_solved == 0 && stats.joints_left > 0);
        } else {
            double speed = speed_of(&c);
            print_message("way %d: %g m/s, without Pinch %g; axles bent by %g rad, %g\n", by, speed, speed_of(&native),
                          bent(&c), bent(&native));
            assert_true(speed < 1e-9 && bent(&c) < 1e-4);
            assert_int_equal(stats.joints_left, 0);
            assert_int_equal(stats.fallback_islands, 0);
            assert_true(stats.joints_solved > 0 && stats.step_mismatch < 1e-9 && stats.step_mismatch_angular < 1e-9);
            const double *ours = dBodyGetPosition(c.chassis), *odes = dBodyGetPosition(native.chassis);
            assert_close(ours[2], odes[2], 1e-3);
        }
        destroy(&c);
    }
    destroy(&native);
}

/* Dropped by 5 cm: in the air as ODE has it, but that Pinch solves the joints; then away. */
static void a_car_drives(void **state)
{
    (void)state;
    enum { IN_THE_AIR = 15, SECONDS = 5 };
    const double turning = 8; /* rad/s */
    car both[2];
    for (int k = 0; k < 2; k++) {
        make(&both[k], AXES, k == 1, 0.05);
        drive(&both[k], -turning, 5);
        dBodySetAngularVel(both[k].chassis, 0.1, 0.2, 0.3);
        step(&both[k], (double)IN_THE_AIR / STEPS_A_SECOND);
        assert_false(both[k].touches);
    }
    pinch_ode_stats air = pinch_dropin_statistics().ode;
    assert_true(air.joints_solved == IN_THE_AIR * WHEELS && air.joints_left == 0 && air.step_mismatch < 1e-12);
    for (int i = 0; i < 3; i++)
        assert_close(dBodyGetPosition(both[1].chassis)[i], dBodyGetPosition(both[0].chassis)[i], 1e-3);
    for (int k = 0; k < 2; k++) {
        dRandSetSeed(2);
        step(&both[k], SECONDS);
    }
    pinch_ode_stats stats = pinch_dropin_statistics().ode;
    const double *odes = dBodyGetPosition(both[0].chassis), *ours = dBodyGetPosition(both[1].chassis);
    double way = hypot(ours[0], ours[1]), odes_way = hypot(odes[0], odes[1]);
    print_message("%g m, without Pinch %g; %g m/s, %g\n", way, odes_way, speed_of(&both[1]), speed_of(&both[0]));
    assert_int_equal(stats.joints_left, 0);
    assert_true(stats.joints_solved > (SECONDS - 1) * STEPS_A_SECOND * WHEELS);
    assert_close(speed_of(&both[1]), turning * RADIUS, 1e-3);
    assert_close(way, odes_way, 0.02 * odes_way);
    assert_true(bent(&both[1]) < 1e-3);
    destroy(&both[0]);
    destroy(&both[1]);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_car_stands_with_its_brakes_on),
        cmocka_unit_test(a_car_drives),
    };
    int failed = cmocka_run_group_tests_name("a car in a drop-in", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
