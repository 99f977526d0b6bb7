/*
 * The layer notes what ODE does not show of joints, from the calls that the program makes. A joint of each such kind is
 * made through the layer, with its bodies moved between the calls, and stepped with a contact that carries nothing:
 * Pinch must solve it from the first step on, and move the bodies as ODE does by itself.
 */
#include "support/cmocka_all.h"

#include <ode/ode.h>

#include <math.h>
#include <pinch/ode_dropin.h>
#include <string.h>

enum { STEPS = 20 };
static const double H = 1e-3;

typedef struct pair {
    dWorldID world;
    dBodyID a, b;
    dGeomID ball, ground;
} pair;

static void turn(dBodyID body, double x, double y, double z, double angle)
{
    dQuaternion q;
    dQFromAxisAndAngle(q, x, y, z, angle);
    dBodySetQuaternion(body, q);
}

static void make_pair(pair *p)
{
    dMass mass;
    p->world = dWorldCreate();
    dWorldSetGravity(p->world, 0.1, 0.2, -9.81);
    dWorldSetCFM(p->world, 0);
    dMassSetBoxTotal(&mass, 0.3, 0.1, 0.2, 0.3);
    p->a = dBodyCreate(p->world);
    p->b = dBodyCreate(p->world);
    dBodySetMass(p->a, &mass);
    dBodySetMass(p->b, &mass);
    dBodySetPosition(p->a, 0.1, 0.2, 0.3);
    dBodySetPosition(p->b, -0.1, 0.1, 0.4);
    dBodySetAngularVel(p->a, 1, -2, 0.5);
    turn(p->b, 1, 2, 3, 0.7);
    p->ball = dCreateSphere(NULL, 0.01);
    p->ground = dCreateSphere(NULL, 0.01);
    dGeomSetBody(p->ball, p->a);
}

static void destroy_pair(pair *p)
{
    dGeomDestroy(p->ball);
    dGeomDestroy(p->ground);
    dWorldDestroy(p->world);
}

/* Between two calls: what has been set stays as it was set. */
static void stir(pair *p)
{
    turn(p->a, 0.3, -1, 0.2, 0.02);
    dBodySetPosition(p->a, 0.11, 0.19, 0.3);
}

static void hinge(pair *p)
{
    dJointID j = dJointCreateHinge(p->world, NULL);
    dJointAttach(j, p->a, p->b);
    dJointSetHingeAnchor(j, 0, 0.1, 0.3);
    dJointSetHingeAxis(j, 0.6, 0, 0.8);
    stir(p);
}

static void hinge_of_long_axis(pair *p)
{
    dJointID j = dJointCreateHinge(p->world, NULL);
    dJointAttach(j, p->a, NULL);
    dJointSetHingeAnchor(j, 0, 0.1, 0.3);
    dJointSetHingeAxisOffset(j, 1.2, 0, 1.6, 0.3);
    stir(p);
}

static void slider_aside(pair *p)
{
    dJointID j = dJointCreateSlider(p->world, NULL);
    dJointAttach(j, p->a, NULL);
    dJointSetSliderAxisDelta(j, 0.6, 0, 0.8, 0.001, 0.002, -0.001);
    stir(p);
}

static void double_hinge(pair *p)
{
    dJointID j = dJointCreateDHinge(p->world, NULL);
    dJointAttach(j, p->a, p->b);
    dJointSetDHingeAxis(j, 0.6, 0, 0.8);
    stir(p);
    dJointSetDHingeAnchor1(j, 0.1, 0.1, 0.3);
    dJointSetDHingeAnchor2(j, -0.1, 0.1, 0.3);
}

static void prismatic_rotoide(pair *p)
{
    dJointID j = dJointCreatePR(p->world, NULL);
    dJointAttach(j, p->a, p->b);
    dJointSetPRAxis1(j, 0, 1, 0);
    dJointSetPRAxis2(j, 0.6, 0, 0.8);
    stir(p);
    dJointSetPRAnchor(j, 0, 0.1, 0.3);
    turn(p->a, 0, 0, 1, 0.01);
}

static void prismatic_universal(pair *p)
{
    dJointID j = dJointCreatePU(p->world, NULL);
    dJointAttach(j, p->a, p->b);
    dJointSetPUAxis1(j, 0, 1, 0);
    dJointSetPUAxis2(j, 0.6, 0, 0.8);
    dJointSetPUAxis3(j, 0.8, 0, -0.6);
    dJointSetPUAnchorOffset(j, 0, 0.1, 0.3, 0.08, 0, -0.06);
    stir(p);
}

static void piston(pair *p)
{
    dJointID j = dJointCreatePiston(p->world, NULL);
    dJointAttach(j, p->a, p->b);
    dJointSetPistonAxis(j, 0.6, 0, 0.8);
    stir(p);
    dJointSetPistonAnchor(j, 0, 0.1, 0.3);
}

static void euler_motor(pair *p)
{
    dJointID j = dJointCreateAMotor(p->world, NULL);
    dJointAttach(j, p->a, p->b);
    dJointSetAMotorMode(j, dAMotorEuler);
    dJointSetAMotorAxis(j, 0, 1, 1, 0, 0);
    dJointSetAMotorAxis(j, 2, 2, 0, 0, 1);
    for (int i = 0; i < 3; i++) dJointSetAMotorParam(j, dParamLoStop + i * dParamGroup, -0.001 * i);
    stir(p);
}

/* Set before they are attached. */
static void plane_motors(pair *p)
{
    dJointID j = dJointCreatePlane2D(p->world, NULL);
    dJointSetPlane2DXParam(j, dParamVel, 0.1);
    dJointSetPlane2DXParam(j, dParamFMax, 2);
    dJointSetPlane2DAngleParam(j, dParamFMax, 0.01);
    dJointAttach(j, p->a, NULL);
}

static void linear_motor(pair *p)
{
    dJointID j = dJointCreateLMotor(p->world, NULL);
    dJointSetLMotorNumAxes(j, 2);
    dJointAttach(j, p->a, p->b);
    dJointSetLMotorAxis(j, 0, 2, 0.6, 0, 0.8);
    dJointSetLMotorAxis(j, 1, 0, 0, 1, 0);
    for (int i = 0; i < 2; i++) dJointSetLMotorParam(j, dParamFMax + i * dParamGroup, 3);
    turn(p->b, 3, 2, 1, 0.4);
}

static void gears(pair *p)
{
    dJointID j = dJointCreateTransmission(p->world, NULL);
    dJointAttach(j, p->a, p->b);
    dJointSetTransmissionAnchor1(j, 0.1, 0.2, 0.3);
    dJointSetTransmissionAnchor2(j, -0.1, 0.1, 0.3);
    dJointSetTransmissionAxis(j, 0, 0, 1);
    dJointSetTransmissionRatio(j, 2);
}

static const struct {
    const char *name;
    void (*make)(pair *p);
} kinds[] = {{"hinge", hinge},
             {"hinge of a long axis", hinge_of_long_axis},
             {"slider set aside", slider_aside},
             {"double hinge", double_hinge},
             {"PR", prismatic_rotoide},
             {"PU", prismatic_universal},
             {"piston", piston},
             {"Euler motor", euler_motor},
             {"plane motors", plane_motors},
             {"linear motor", linear_motor},
             {"gears", gears}};

/* A contact far from pressing, with a body that stands still, has Pinch look at the joint. */
static void touch(pair *p, dJointGroupID group)
{
    dContact contact;
    memset(&contact, 0, sizeof contact);
    contact.surface.mode = dContactSoftCFM;
    contact.surface.soft_cfm = 1;
    contact.geom.normal[2] = 1;
    contact.geom.depth = 1e-12;
    const double *x = dBodyGetPosition(p->a);
    for (int i = 0; i < 3; i++) contact.geom.pos[i] = x[i];
    contact.geom.g1 = p->ball;
    contact.geom.g2 = p->ground;
    dJointAttach(dJointCreateContact(p->world, group, &contact), p->a, NULL);
}

#undef dWorldStep
static void step_by_ode(dWorldID world)
{
    dWorldStep(world, H);
}

static double apart(dBodyID a, dBodyID b)
{
    const double *v[2] = {dBodyGetLinearVel(a), dBodyGetLinearVel(b)};
    const double *w[2] = {dBodyGetAngularVel(a), dBodyGetAngularVel(b)};
    double most = 0;
    for (int i = 0; i < 3; i++) {
        double size = 1 + dCalcVectorLength3(v[1]) + dCalcVectorLength3(w[1]);
        most = fmax(most, fmax(fabs(v[0][i] - v[1][i]), fabs(w[0][i] - w[1][i])) / size);
    }
    return most;
}

static void every_kind_is_noted(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        pair with, without;
        make_pair(&with);
        make_pair(&without);
        kinds[k].make(&with);
        kinds[k].make(&without);
        pinch_dropin_reset_statistics();
        dJointGroupID group = dJointGroupCreate(0);
        double most = 0;
        for (int i = 0; i < STEPS; i++) {
            touch(&with, group);
            assert_int_equal(pinch_dropin_world_step(with.world, H), 1);
            dJointGroupEmpty(group);
            touch(&without, group);
            step_by_ode(without.world);
            dJointGroupEmpty(group);
            most = fmax(most, fmax(apart(with.a, without.a), apart(with.b, without.b)));
        }
        pinch_ode_stats stats = pinch_dropin_statistics().ode;
        if (stats.joints_solved != STEPS || most > 1e-9)
            print_error("%s: %ld solved, %ld left, %ld unmodelled, off by %g\n", kinds[k].name, stats.joints_solved,
                        stats.joints_left, stats.joints_unmodelled, most);
        assert_int_equal(stats.joints_solved, STEPS);
        assert_true(most <= 1e-9);
        dJointGroupDestroy(group);
        destroy_pair(&with);
        destroy_pair(&without);
    }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_kind_is_noted),
    };
    int failed = cmocka_run_group_tests_name("what the layer notes of joints", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
