#include "support/joint_rig.h"

#include "support/cmocka_all.h"

#include <string.h>

const char *const joint_partner_names[JOINT_PARTNERS] = {"two bodies", "the static world", "a kinematic body"};
const char *const joint_variant_names[JOINT_VARIANTS] = {"free",      "motor",  "weak motor",    "low stop",
                                                         "high stop", "locked", "motor at stop", "bouncing stop"};

static void random_pose(pinch_random *random, dBodyID body, double reach)
{
    double frame[9], x[3];
    dMatrix3 R;
    draw_frame(random, frame);
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) R[4 * i + j] = frame[3 * i + j];
        R[4 * i + 3] = 0;
    }
    dBodySetRotation(body, R);
    for (int i = 2; i >= 0; i--) x[i] = draw_uniform(random, -reach, reach);
    dBodySetPosition(body, x[0], x[1], x[2]);
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

static void random_anchor_and_axes(joint_rig *r, double x[3], double n[3], double t[3])
{
    random_anchor(r, x);
    draw_direction(&r->random, n);
    draw_tangent(&r->random, n, t);
}

static dJointID make_prismatic_rotoide(joint_rig *r, dBodyID a, dBodyID b)
{
    double x[3], n[3], t[3];
    dJointID j = dJointCreatePR(r->world, NULL);
    dJointAttach(j, a, b);
    random_anchor_and_axes(r, x, n, t);
    dJointSetPRAnchor(j, x[0], x[1], x[2]);
    dJointSetPRAxis1(j, n[0], n[1], n[2]);
    dJointSetPRAxis2(j, t[0], t[1], t[2]);
    if (draw_chance(&r->random, 0.5)) {
        dJointSetPRParam(j, dParamVel2, draw_uniform(&r->random, -5, 5));
        dJointSetPRParam(j, dParamFMax2, draw_log_uniform(&r->random, 1e-3, 10));
    }
    return j;
}

static dJointID make_prismatic_universal(joint_rig *r, dBodyID a, dBodyID b)
{
    double x[3], n[3], t[3], p[3], offset = draw_uniform(&r->random, -0.05, 0.05);
    dJointID j = dJointCreatePU(r->world, NULL);
    dJointAttach(j, a, b);
    random_anchor_and_axes(r, x, n, t);
    draw_direction(&r->random, p);
    dJointSetPUAxis1(j, n[0], n[1], n[2]);
    dJointSetPUAxis2(j, t[0], t[1], t[2]);
    dJointSetPUAxis3(j, p[0], p[1], p[2]);
    if (a && b)
        dJointSetPUAnchorOffset(j, x[0], x[1], x[2], offset * p[0], offset * p[1], offset * p[2]);
    else
        dJointSetPUAnchor(j, x[0], x[1], x[2]);
    if (draw_chance(&r->random, 0.5)) {
        dJointSetPUParam(j, dParamVel1, draw_uniform(&r->random, -5, 5));
        dJointSetPUParam(j, dParamFMax1, draw_log_uniform(&r->random, 1e-3, 10));
        dJointSetPUParam(j, dParamLoStop2, 0.01);
        dJointSetPUParam(j, dParamHiStop2, 0.3);
    }
    return j;
}

static void set_prismatic_universal(dJointID j, int parameter, dReal value)
{
    dJointSetPUParam(j, parameter | dParamGroup3, value);
}

static dJointID make_piston(joint_rig *r, dBodyID a, dBodyID b)
{
    double x[3], n[3], t[3];
    dJointID j = dJointCreatePiston(r->world, NULL);
    dJointAttach(j, a, b);
    random_anchor_and_axes(r, x, n, t);
    dJointSetPistonAnchor(j, x[0], x[1], x[2]);
    dJointSetPistonAxis(j, n[0], n[1], n[2]);
    if (draw_chance(&r->random, 0.5)) {
        dJointSetPistonParam(j, dParamVel2, draw_uniform(&r->random, -5, 5));
        dJointSetPistonParam(j, dParamFMax2, draw_log_uniform(&r->random, 1e-3, 10));
    }
    return j;
}

/* Half of them have both anchors in one place. */
static dJointID make_double_ball(joint_rig *r, dBodyID a, dBodyID b)
{
    double x[3], y[3];
    dJointID j = dJointCreateDBall(r->world, NULL);
    dJointAttach(j, a, b);
    random_anchor(r, x);
    random_anchor(r, y);
    const double *second = draw_chance(&r->random, 0.5) ? x : y;
    dJointSetDBallAnchor1(j, x[0], x[1], x[2]);
    dJointSetDBallAnchor2(j, second[0], second[1], second[2]);
    dJointSetDBallParam(j, dParamERP, 0.7);
    dJointSetDBallParam(j, dParamCFM, draw_chance(&r->random, 0.5) ? 0 : 1e-2);
    return j;
}

static dJointID make_double_hinge(joint_rig *r, dBodyID a, dBodyID b)
{
    double x[3], n[3], t[3];
    dJointID j = dJointCreateDHinge(r->world, NULL);
    dJointAttach(j, a, b);
    random_anchor_and_axes(r, x, n, t);
    dJointSetDHingeAxis(j, n[0], n[1], n[2]);
    dJointSetDHingeAnchor1(j, x[0], x[1], x[2]);
    dJointSetDHingeAnchor2(j, x[0] + 0.04 * t[0], x[1] + 0.04 * t[1], x[2] + 0.04 * t[2]);
    dJointSetDHingeParam(j, dParamERP, 0.6);
    return j;
}

static dJointID new_transmission(joint_rig *r, dBodyID a, dBodyID b, int mode)
{
    dJointID j = dJointCreateTransmission(r->world, NULL);
    dJointAttach(j, a, b);
    dJointSetTransmissionMode(j, mode);
    dJointSetTransmissionParam(j, dParamERP, 0.3);
    dJointSetTransmissionParam(j, dParamCFM, draw_chance(&r->random, 0.5) ? 0 : 1e-2);
    return j;
}

static void set_wheels(dJointID j, const double *x, const double *y)
{
    dJointSetTransmissionAnchor1(j, x[0], x[1], x[2]);
    dJointSetTransmissionAnchor2(j, y[0], y[1], y[2]);
}

static dJointID make_gears(joint_rig *r, dBodyID a, dBodyID b)
{
    double x[3], n[3], t[3];
    dJointID j = new_transmission(r, a, b, dTransmissionParallelAxes);
    random_anchor_and_axes(r, x, n, t);
    const double y[3] = {x[0] + 0.06 * t[0], x[1] + 0.06 * t[1], x[2] + 0.06 * t[2]};
    set_wheels(j, x, y);
    dJointSetTransmissionAxis(j, n[0], n[1], n[2]);
    dJointSetTransmissionRatio(j, draw_uniform(&r->random, 0.5, 3));
    if (draw_chance(&r->random, 0.5)) {
        dJointSetTransmissionBacklash(j, 1e-4);
        dJointSetTransmissionParam(j, dParamCFM, 1e-2); /* without, ODE divides by zero in the gap */
    }
    return j;
}

static dJointID make_bevel_gears(joint_rig *r, dBodyID a, dBodyID b)
{
    double x[3], y[3], n[3], t[3];
    dJointID j = new_transmission(r, a, b, dTransmissionIntersectingAxes);
    random_anchor_and_axes(r, x, n, t);
    for (int i = 0; i < 3; i++) {
        y[i] = x[i] + 0.03 * t[i] + 0.04 * n[i];
        t[i] += 0.3 * n[i]; /* ODE turns an axis over where the two are more than a right angle apart */
    }
    set_wheels(j, x, y);
    dJointSetTransmissionAxis1(j, n[0], n[1], n[2]);
    dJointSetTransmissionAxis2(j, t[0], t[1], t[2]);
    return j;
}

static dJointID make_chain_drive(joint_rig *r, dBodyID a, dBodyID b)
{
    double x[3], n[3], t[3];
    dJointID j = new_transmission(r, a, b, dTransmissionChainDrive);
    random_anchor_and_axes(r, x, n, t);
    const double y[3] = {x[0] + 0.1 * t[0], x[1] + 0.1 * t[1], x[2] + 0.1 * t[2]};
    set_wheels(j, x, y);
    dJointSetTransmissionAxis(j, n[0], n[1], n[2]);
    dJointSetTransmissionRadius1(j, 0.02);
    dJointSetTransmissionRadius2(j, 0.03);
    return j;
}

static dJointID make_plane(joint_rig *r, dBodyID a, dBodyID b)
{
    (void)b;
    static void (*const set[3])(dJointID, int, dReal) = {dJointSetPlane2DXParam, dJointSetPlane2DYParam,
                                                         dJointSetPlane2DAngleParam};
    const double *x = dBodyGetPosition(a);
    dBodySetPosition(a, x[0], x[1], 0);
    for (int i = 0; i < 3; i++) r->tip_normal[i] *= i < 2;
    double length = hypot(r->tip_normal[0], r->tip_normal[1]);
    for (int i = 0; i < 2; i++) r->tip_normal[i] /= length;
    dBodySetPosition(r->tip_body, x[0] - 0.0299 * r->tip_normal[0], x[1] - 0.0299 * r->tip_normal[1], 0);
    dJointID j = dJointCreatePlane2D(r->world, NULL);
    dJointAttach(j, a, NULL);
    assert_int_equal(pinch_ode_note_joint(r->plugin, j), PINCH_OK);
    for (int i = 0; i < 3; i++) {
        double velocity = draw_uniform(&r->random, -0.3, 0.3), force = draw_log_uniform(&r->random, 1e-2, 10);
        if (draw_chance(&r->random, 0.5) || dCalcVectorLength3(dBodyGetLinearVel(a)) < 0.1) continue;
        set[i](j, dParamVel, velocity);
        set[i](j, dParamFMax, force);
        assert_int_equal(pinch_ode_note_plane_motor(r->plugin, j, i, dParamVel, velocity), PINCH_OK);
        assert_int_equal(pinch_ode_note_plane_motor(r->plugin, j, i, dParamFMax, force), PINCH_OK);
    }
    return j;
}

/* The outer axes are perpendicular when they are set. Each kind of angle has a motor or a stop that it is at. */
static dJointID make_euler_motor(joint_rig *r, dBodyID a, dBodyID b)
{
    dJointID j = dJointCreateAMotor(r->world, NULL);
    double n[3], t[3];
    dJointAttach(j, a, b);
    draw_direction(&r->random, n);
    draw_tangent(&r->random, n, t);
    dJointSetAMotorMode(j, dAMotorEuler);
    dJointSetAMotorAxis(j, 0, 1, n[0], n[1], n[2]);
    dJointSetAMotorAxis(j, 2, 2, t[0], t[1], t[2]);
    for (int i = 0; i < 3; i++) {
        if (draw_chance(&r->random, 0.5)) {
            dJointSetAMotorParam(j, dParamVel + i * dParamGroup, draw_uniform(&r->random, -5, 5));
            dJointSetAMotorParam(j, dParamFMax + i * dParamGroup, draw_log_uniform(&r->random, 1e-3, 10));
        } else {
            dJointSetAMotorParam(j, dParamLoStop + i * dParamGroup, draw_uniform(&r->random, -0.05, 0.01));
            dJointSetAMotorParam(j, dParamHiStop + i * dParamGroup, 0.1);
        }
    }
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
    double frame_axis[9];
    draw_frame(&r->random, frame_axis);
    dJointSetLMotorNumAxes(j, axes);
    for (int i = 0; i < axes; i++) {
        int frame = b && a ? draw_index(&r->random, 3) : draw_index(&r->random, 2);
        dJointSetLMotorAxis(j, i, frame, frame_axis[3 * i], frame_axis[3 * i + 1], frame_axis[3 * i + 2]);
        assert_int_equal(pinch_ode_note_linear_motor(r->plugin, j, i, frame), PINCH_OK);
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
    {"plane-2D", false, false, false, false, true, make_plane, NULL, NULL},
    {"angular motor", false, true, false, true, true, make_amotor, dJointSetAMotorParam, amotor_angle},
    {"linear motor", false, true, true, false, true, make_lmotor, dJointSetLMotorParam, NULL},
    {"PR", false, true, true, true, true, make_prismatic_rotoide, dJointSetPRParam, dJointGetPRPosition},
    {"PU", false, true, true, true, true, make_prismatic_universal, set_prismatic_universal, dJointGetPUPosition},
    {"piston", false, true, true, true, true, make_piston, dJointSetPistonParam, dJointGetPistonPosition},
    {"double ball", false, false, false, false, true, make_double_ball, NULL, NULL},
    {"double hinge", false, false, false, false, true, make_double_hinge, NULL, NULL},
    {"gears", true, false, false, false, true, make_gears, NULL, NULL},
    {"bevel gears", true, false, false, false, true, make_bevel_gears, NULL, NULL},
    {"chain drive", true, false, false, false, false, make_chain_drive, NULL, NULL},
    {"Euler motor", false, false, false, false, true, make_euler_motor, NULL, NULL},
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
    case JOINT_BOUNCING:
        kind->set(j, dParamHiStop, here + 10 * unit);
        kind->set(j, dParamLoStop, here + 0.01 * unit);
        kind->set(j, dParamStopERP, 0.3);
        if (v == JOINT_BOUNCING) kind->set(j, dParamBounce, 0.5);
        if (v != JOINT_MOTOR_AT_STOP) break;
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
    if (kind->make != make_plane) (void)pinch_ode_note_joint(r->plugin, joint); /* of those that are to be noted */
    return joint;
}

bool joint_rig_possible(const joint_kind *kind, joint_partner with, bool swapped, joint_variant v)
{
    if (kind->needs_two && with == JOINT_STATIC_WORLD) return false;
    if (kind->make == make_plane && (with != JOINT_STATIC_WORLD || swapped)) return false;
    if (v != JOINT_FREE && !kind->motorized) return false;
    return kind->has_stops || v == JOINT_FREE || v == JOINT_MOTOR || v == JOINT_WEAK_MOTOR;
}

bool joint_rig_mends(const joint_kind *kind, joint_partner with, bool swapped)
{
    bool mirrored = kind->make == make_prismatic_rotoide || kind->make == make_piston || kind->make == make_euler_motor;
    return mirrored && with == JOINT_STATIC_WORLD && swapped;
}

bool joint_rig_leaps(const joint_kind *kind, joint_partner with, bool swapped)
{
    bool mirrored =
        kind->make == make_prismatic_rotoide || kind->make == make_prismatic_universal || kind->make == make_piston;
    return mirrored && with == JOINT_STATIC_WORLD && swapped;
}

int joint_rig_steps(const joint_kind *kind, joint_partner with, bool swapped, int most)
{
    bool wheels = kind->make == make_gears || kind->make == make_bevel_gears || kind->make == make_chain_drive;
    if (joint_rig_leaps(kind, with, swapped)) return 1;
    return wheels && most > 10 ? 10 : most;
}
