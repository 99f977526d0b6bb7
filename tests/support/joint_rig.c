#include "support/joint_rig.h"

#include "support/cmocka_all.h"

#include <string.h>

const char *const joint_partner_names[JOINT_PARTNERS] = {"two bodies", "the static world", "a kinematic body"};
const char *const joint_variant_names[JOINT_VARIANTS] = {"free",      "motor",  "weak motor",   "low stop",
                                                         "high stop", "locked", "motor at stop"};

static void random_pose(pinch_random *random, dBodyID body, double reach)
{
    double frame[9];
    dMatrix3 R;
    draw_frame(random, frame);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) R[4 * i + j] = frame[3 * i + j];
        R[4 * i + 3] = 0;
    }
    dBodySetRotation(body, R);
    dBodySetPosition(body, draw_uniform(random, -reach, reach), draw_uniform(random, -reach, reach),
                     draw_uniform(random, -reach, reach));
}

static void random_velocity(pinch_random *random, dBodyID body, double linear, double angular)
{
    double v[3], w[3];
    draw_direction(random, v);
    draw_direction(random, w);
    dBodySetLinearVel(body, linear * v[0], linear * v[1], linear * v[2]);
    dBodySetAngularVel(body, angular * w[0], angular * w[1], angular * w[2]);
}

/* The first body is a sphere geom of 2 cm about a lopsided mass; the tip a kinematic ball that presses on it. */
void joint_rig_make(joint_rig *r, uint64_t seed, joint_partner with, double speed, bool by_ode)
{
    memset(r, 0, sizeof *r);
    pinch_random_seed(&r->random, seed);
    r->world = dWorldCreate();
    dWorldSetGravity(r->world, 0.3, -0.2, -9.81);
    dWorldSetCFM(r->world, 0); /* else ODE's rows are soft by 1e-10, which is tested by itself */
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.joints_by_ode = by_ode;
    assert_int_equal(pinch_ode_create(r->world, &settings, &r->plugin), PINCH_OK);
    for (int i = 0; i < (with == JOINT_STATIC_WORLD ? 1 : 2); i++) {
        r->body[i] = dBodyCreate(r->world);
        dMass mass;
        dMassSetBoxTotal(&mass, draw_uniform(&r->random, 0.1, 0.5), 0.02, 0.05, 0.08);
        dBodySetMass(r->body[i], &mass);
        random_pose(&r->random, r->body[i], 0.05);
        random_velocity(&r->random, r->body[i], speed, 20 * speed);
        if (i == 1 && with == JOINT_KINEMATIC_BODY) dBodySetKinematic(r->body[i]);
    }
    r->geom = dCreateSphere(NULL, 0.02);
    dGeomSetBody(r->geom, r->body[0]);
    r->tip_body = dBodyCreate(r->world);
    dBodySetKinematic(r->tip_body);
    r->tip = dCreateSphere(NULL, 0.01);
    dGeomSetBody(r->tip, r->tip_body);
    const double *x = dBodyGetPosition(r->body[0]);
    draw_direction(&r->random, r->tip_normal);
    dBodySetPosition(r->tip_body, x[0] - 0.0299 * r->tip_normal[0], x[1] - 0.0299 * r->tip_normal[1],
                     x[2] - 0.0299 * r->tip_normal[2]);
    random_velocity(&r->random, r->tip_body, 0.1 * speed, 0);
    pinch_material material = pinch_default_material();
    assert_int_equal(pinch_ode_set_material(r->plugin, r->tip, &material), PINCH_OK);
}

void joint_rig_free(joint_rig *r)
{
    pinch_ode_destroy(r->plugin);
    dGeomDestroy(r->geom);
    dGeomDestroy(r->tip);
    dWorldDestroy(r->world);
}

static void random_anchor(joint_rig *r, double x[3])
{
    const double *p = dBodyGetPosition(r->body[0]);
    for (int i = 0; i < 3; i++) x[i] = p[i] + draw_uniform(&r->random, -0.05, 0.05);
}

static dJointID make_ball(joint_rig *r, dBodyID a, dBodyID b)
{
    double x[3];
    dJointID j = dJointCreateBall(r->world, NULL);
    dJointAttach(j, a, b);
    random_anchor(r, x);
    dJointSetBallAnchor(j, x[0], x[1], x[2]);
    return j;
}

static dJointID make_hinge(joint_rig *r, dBodyID a, dBodyID b)
{
    double x[3], n[3];
    dJointID j = dJointCreateHinge(r->world, NULL);
    dJointAttach(j, a, b);
    random_anchor(r, x);
    draw_direction(&r->random, n);
    dJointSetHingeAnchor(j, x[0], x[1], x[2]);
    dJointSetHingeAxis(j, n[0], n[1], n[2]);
    return j;
}

static dJointID make_slider(joint_rig *r, dBodyID a, dBodyID b)
{
    double n[3];
    dJointID j = dJointCreateSlider(r->world, NULL);
    dJointAttach(j, a, b);
    draw_direction(&r->random, n);
    dJointSetSliderAxis(j, n[0], n[1], n[2]);
    return j;
}

static dJointID make_universal(joint_rig *r, dBodyID a, dBodyID b)
{
    double x[3], n[3], t[3];
    dJointID j = dJointCreateUniversal(r->world, NULL);
    dJointAttach(j, a, b);
    random_anchor(r, x);
    draw_direction(&r->random, n);
    draw_tangent(&r->random, n, t);
    dJointSetUniversalAnchor(j, x[0], x[1], x[2]);
    dJointSetUniversalAxis1(j, n[0], n[1], n[2]);
    dJointSetUniversalAxis2(j, t[0], t[1], t[2]);
    return j;
}

static dJointID make_hinge2(joint_rig *r, dBodyID a, dBodyID b)
{
    double x[3], n[3], t[3], tilt = draw_uniform(&r->random, -1, 1); /* the axes need not be perpendicular */
    dJointID j = dJointCreateHinge2(r->world, NULL);
    dJointAttach(j, a, b);
    random_anchor(r, x);
    draw_direction(&r->random, n);
    draw_tangent(&r->random, n, t);
    for (int i = 0; i < 3; i++) t[i] += tilt * n[i];
    dJointSetHinge2Anchor(j, x[0], x[1], x[2]);
    dJointSetHinge2Axes(j, n, t);
    dJointSetHinge2Param(j, dParamSuspensionERP, 0.4);
    dJointSetHinge2Param(j, dParamSuspensionCFM, draw_chance(&r->random, 0.5) ? 0 : 1e-2);
    dJointSetHinge2Param(j, dParamVel2, draw_uniform(&r->random, -5, 5));
    dJointSetHinge2Param(j, dParamFMax2, draw_chance(&r->random, 0.5) ? 0 : draw_log_uniform(&r->random, 1e-3, 10));
    return j;
}

static dJointID make_fixed(joint_rig *r, dBodyID a, dBodyID b)
{
    dJointID j = dJointCreateFixed(r->world, NULL);
    dJointAttach(j, a, b);
    dJointSetFixed(j);
    return j;
}

static dJointID make_plane(joint_rig *r, dBodyID a, dBodyID b)
{
    (void)b;
    const double *x = dBodyGetPosition(a);
    dBodySetPosition(a, x[0], x[1], 0);
    for (int i = 0; i < 3; i++) r->tip_normal[i] *= i < 2;
    double length = hypot(r->tip_normal[0], r->tip_normal[1]);
    for (int i = 0; i < 2; i++) r->tip_normal[i] /= length;
    dBodySetPosition(r->tip_body, x[0] - 0.0299 * r->tip_normal[0], x[1] - 0.0299 * r->tip_normal[1], 0);
    dJointID j = dJointCreatePlane2D(r->world, NULL);
    dJointAttach(j, a, NULL);
    return j;
}

static dJointID make_amotor(joint_rig *r, dBodyID a, dBodyID b)
{
    dJointID j = dJointCreateAMotor(r->world, NULL);
    dJointAttach(j, a, b);
    dJointSetAMotorMode(j, dAMotorUser);
    int axes = 1 + draw_index(&r->random, 3);
    double frame[9];
    draw_frame(&r->random, frame);
    dJointSetAMotorNumAxes(j, axes);
    for (int i = 0; i < axes; i++) {
        int relative = b && a ? draw_index(&r->random, 3) : draw_index(&r->random, 2);
        dJointSetAMotorAxis(j, i, relative, frame[3 * i], frame[3 * i + 1], frame[3 * i + 2]);
        dJointSetAMotorAngle(j, i, 0.1);
        dJointSetAMotorParam(j, dParamVel + i * dParamGroup, draw_uniform(&r->random, -5, 5));
        dJointSetAMotorParam(j, dParamFMax + i * dParamGroup, draw_log_uniform(&r->random, 1e-3, 10));
    }
    return j;
}

static double amotor_angle(dJointID j)
{
    return dJointGetAMotorAngle(j, 0);
}

static dJointID make_lmotor(joint_rig *r, dBodyID a, dBodyID b)
{
    dJointID j = dJointCreateLMotor(r->world, NULL);
    dJointAttach(j, a, b);
    int axes = 1 + draw_index(&r->random, 3);
    double frame[9];
    draw_frame(&r->random, frame);
    dJointSetLMotorNumAxes(j, axes);
    for (int i = 0; i < axes; i++) {
        /* ODE has no getter that tells whether the axis it returns turns with a body: world axes only */
        dJointSetLMotorAxis(j, i, 0, frame[3 * i], frame[3 * i + 1], frame[3 * i + 2]);
        dJointSetLMotorParam(j, dParamVel + i * dParamGroup, draw_uniform(&r->random, -0.2, 0.2));
        dJointSetLMotorParam(j, dParamFMax + i * dParamGroup, draw_log_uniform(&r->random, 1e-2, 100));
    }
    return j;
}

const joint_kind joint_kinds[] = {
    {"ball", false, false, false, false, true, make_ball, NULL, NULL},
    {"hinge", false, true, false, true, true, make_hinge, dJointSetHingeParam, dJointGetHingeAngle},
    {"slider", false, true, true, true, true, make_slider, dJointSetSliderParam, dJointGetSliderPosition},
    {"universal", false, true, false, true, true, make_universal, dJointSetUniversalParam, dJointGetUniversalAngle1},
    {"hinge2", true, true, false, true, true, make_hinge2, dJointSetHinge2Param, dJointGetHinge2Angle1},
    {"fixed", false, false, false, false, true, make_fixed, NULL, NULL},
    {"plane-2D", false, false, false, false, false, make_plane, NULL, NULL},
    {"angular motor", false, true, false, true, true, make_amotor, dJointSetAMotorParam, amotor_angle},
    {"linear motor", false, true, true, false, false, make_lmotor, dJointSetLMotorParam, NULL},
};
const int joint_kind_count = sizeof joint_kinds / sizeof joint_kinds[0];

/* Motors and stops at the joint's present position. */
void joint_rig_set(const joint_kind *kind, dJointID j, joint_variant v)
{
    double here = kind->position ? kind->position(j) : 0, unit = kind->linear ? 0.01 : 0.1;
    switch (v) {
    case JOINT_MOTOR:
        kind->set(j, dParamVel, 3 * unit);
        kind->set(j, dParamFMax, 1e3);
        break;
    case JOINT_WEAK_MOTOR:
        kind->set(j, dParamVel, 30 * unit);
        kind->set(j, dParamFMax, kind->linear ? 0.1 : 1e-3);
        break;
    case JOINT_AT_LOW_STOP:
    case JOINT_MOTOR_AT_STOP:
        kind->set(j, dParamHiStop, here + 10 * unit);
        kind->set(j, dParamLoStop, here + 0.01 * unit);
        kind->set(j, dParamStopERP, 0.3);
        if (v == JOINT_AT_LOW_STOP) break;
        kind->set(j, dParamVel, -unit);
        kind->set(j, dParamFMax, kind->linear ? 1 : 1e-2);
        kind->set(j, dParamFudgeFactor, 1);
        break;
    case JOINT_AT_HIGH_STOP:
        kind->set(j, dParamLoStop, here - 10 * unit);
        kind->set(j, dParamHiStop, here - 0.01 * unit);
        break;
    case JOINT_LOCKED:
        kind->set(j, dParamLoStop, here);
        kind->set(j, dParamHiStop, here);
        kind->set(j, dParamLoStop, here);
        break;
    default:
        break;
    }
}

dJointID joint_rig_attach(const joint_kind *kind, joint_rig *r, joint_partner with, bool swapped)
{
    dBodyID other = with == JOINT_STATIC_WORLD ? NULL : r->body[1];
    dJointID joint = swapped ? kind->make(r, other, r->body[0]) : kind->make(r, r->body[0], other);
    (void)pinch_ode_note_joint(r->plugin, joint); /* of those that are to be noted */
    return joint;
}

bool joint_rig_possible(const joint_kind *kind, joint_partner with, bool swapped, joint_variant v)
{
    if (kind->needs_two && with == JOINT_STATIC_WORLD) return false;
    if (kind->make == make_plane && (with != JOINT_STATIC_WORLD || swapped)) return false;
    if (v != JOINT_FREE && !kind->motorized) return false;
    return kind->has_stops || v == JOINT_FREE || v == JOINT_MOTOR || v == JOINT_WEAK_MOTOR;
}
