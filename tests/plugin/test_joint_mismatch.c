/*
 * What the contact solver predicts is what ODE's own step arrives at, for every joint it knows, however the joint is
 * attached, with motors and stops, while contacts act. Measured here from the bodies' velocities, not from the plugin's
 * statistics.
 */
#include "support/cmocka_all.h"

#include "support/draw.h"

#include <pinch/ode.h>
#include <string.h>

static const double STEP = 1e-3;

typedef enum partner { TWO_BODIES = 0, STATIC_WORLD, KINEMATIC_BODY, PARTNERS } partner;
typedef enum variant {
    FREE = 0,
    MOTOR,
    WEAK_MOTOR,
    AT_LOW_STOP,
    AT_HIGH_STOP,
    LOCKED,
    MOTOR_AT_STOP,
    VARIANTS
} variant;

static const char *const partner_names[] = {"two bodies", "the static world", "a kinematic body"};
static const char *const variant_names[] = {"free",      "motor",  "weak motor",   "low stop",
                                            "high stop", "locked", "motor at stop"};

/* A body with a fingertip on it, another body, a joint between them. */
typedef struct rig {
    dWorldID world;
    pinch_ode *plugin;
    dBodyID body[2];
    dGeomID geom, tip;
    dBodyID tip_body;
    double tip_normal[3]; /* into the body */
    pinch_random random;
} rig;

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
static void rig_make(rig *r, uint64_t seed, partner with, double speed)
{
    memset(r, 0, sizeof *r);
    pinch_random_seed(&r->random, seed);
    r->world = dWorldCreate();
    dWorldSetGravity(r->world, 0.3, -0.2, -9.81);
    dWorldSetCFM(r->world, 0); /* else ODE's rows are soft by 1e-10, which is tested by itself */
    pinch_ode_settings settings = pinch_ode_default_settings();
    assert_int_equal(pinch_ode_create(r->world, &settings, &r->plugin), PINCH_OK);
    for (int i = 0; i < (with == STATIC_WORLD ? 1 : 2); i++) {
        r->body[i] = dBodyCreate(r->world);
        dMass mass;
        dMassSetBoxTotal(&mass, draw_uniform(&r->random, 0.1, 0.5), 0.02, 0.05, 0.08);
        dBodySetMass(r->body[i], &mass);
        random_pose(&r->random, r->body[i], 0.05);
        random_velocity(&r->random, r->body[i], speed, 20 * speed);
        if (i == 1 && with == KINEMATIC_BODY) dBodySetKinematic(r->body[i]);
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

static void rig_free(rig *r)
{
    pinch_ode_destroy(r->plugin);
    dGeomDestroy(r->geom);
    dGeomDestroy(r->tip);
    dWorldDestroy(r->world);
}

typedef struct joint_kind {
    const char *name;
    bool needs_two, motorized, linear, has_stops;
    dJointID (*make)(rig *r, dBodyID a, dBodyID b);
    void (*set)(dJointID joint, int parameter, dReal value);
    double (*position)(dJointID joint);
} joint_kind;

static void random_anchor(rig *r, double x[3])
{
    const double *p = dBodyGetPosition(r->body[0]);
    for (int i = 0; i < 3; i++) x[i] = p[i] + draw_uniform(&r->random, -0.05, 0.05);
}

static dJointID make_ball(rig *r, dBodyID a, dBodyID b)
{
    double x[3];
    dJointID j = dJointCreateBall(r->world, NULL);
    dJointAttach(j, a, b);
    random_anchor(r, x);
    dJointSetBallAnchor(j, x[0], x[1], x[2]);
    return j;
}

static dJointID make_hinge(rig *r, dBodyID a, dBodyID b)
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

static dJointID make_slider(rig *r, dBodyID a, dBodyID b)
{
    double n[3];
    dJointID j = dJointCreateSlider(r->world, NULL);
    dJointAttach(j, a, b);
    draw_direction(&r->random, n);
    dJointSetSliderAxis(j, n[0], n[1], n[2]);
    return j;
}

static dJointID make_universal(rig *r, dBodyID a, dBodyID b)
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

static dJointID make_hinge2(rig *r, dBodyID a, dBodyID b)
{
    double x[3], n[3], t[3];
    dJointID j = dJointCreateHinge2(r->world, NULL);
    dJointAttach(j, a, b);
    random_anchor(r, x);
    draw_direction(&r->random, n);
    draw_tangent(&r->random, n, t);
    dJointSetHinge2Anchor(j, x[0], x[1], x[2]);
    dJointSetHinge2Axes(j, n, t);
    dJointSetHinge2Param(j, dParamSuspensionERP, 0.4);
    dJointSetHinge2Param(j, dParamSuspensionCFM, draw_chance(&r->random, 0.5) ? 0 : 1e-2);
    return j;
}

static dJointID make_fixed(rig *r, dBodyID a, dBodyID b)
{
    dJointID j = dJointCreateFixed(r->world, NULL);
    dJointAttach(j, a, b);
    dJointSetFixed(j);
    return j;
}

static dJointID make_plane(rig *r, dBodyID a, dBodyID b)
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

static dJointID make_amotor(rig *r, dBodyID a, dBodyID b)
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

static dJointID make_lmotor(rig *r, dBodyID a, dBodyID b)
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

static const joint_kind kinds[] = {
    {"ball", false, false, false, false, make_ball, NULL, NULL},
    {"hinge", false, true, false, true, make_hinge, dJointSetHingeParam, dJointGetHingeAngle},
    {"slider", false, true, true, true, make_slider, dJointSetSliderParam, dJointGetSliderPosition},
    {"universal", false, true, false, true, make_universal, dJointSetUniversalParam, dJointGetUniversalAngle1},
    {"hinge2", true, true, false, true, make_hinge2, dJointSetHinge2Param, dJointGetHinge2Angle1},
    {"fixed", false, false, false, false, make_fixed, NULL, NULL},
    {"plane-2D", false, false, false, false, make_plane, NULL, NULL},
    {"angular motor", false, true, false, true, make_amotor, dJointSetAMotorParam, amotor_angle},
    {"linear motor", false, true, true, false, make_lmotor, dJointSetLMotorParam, NULL},
};
enum { KINDS = sizeof kinds / sizeof kinds[0] };

/* Motors and stops at the joint's present position. */
static void set_variant(const joint_kind *kind, dJointID j, variant v)
{
    double here = kind->position ? kind->position(j) : 0, unit = kind->linear ? 0.01 : 0.1;
    switch (v) {
    case MOTOR:
        kind->set(j, dParamVel, 3 * unit);
        kind->set(j, dParamFMax, 1e3);
        break;
    case WEAK_MOTOR:
        kind->set(j, dParamVel, 30 * unit);
        kind->set(j, dParamFMax, kind->linear ? 0.1 : 1e-3);
        break;
    case AT_LOW_STOP:
    case MOTOR_AT_STOP:
        kind->set(j, dParamHiStop, here + 10 * unit);
        kind->set(j, dParamLoStop, here + 0.01 * unit);
        kind->set(j, dParamStopERP, 0.3);
        if (v == AT_LOW_STOP) break;
        kind->set(j, dParamVel, -unit);
        kind->set(j, dParamFMax, kind->linear ? 1 : 1e-2);
        kind->set(j, dParamFudgeFactor, 1);
        break;
    case AT_HIGH_STOP:
        kind->set(j, dParamLoStop, here - 10 * unit);
        kind->set(j, dParamHiStop, here - 0.01 * unit);
        break;
    case LOCKED:
        kind->set(j, dParamLoStop, here);
        kind->set(j, dParamHiStop, here);
        kind->set(j, dParamLoStop, here);
        break;
    default:
        break;
    }
}

typedef struct point_motion {
    double linear[3], angular[3];
} point_motion;

/* The velocity that the body has now, at a point given relative to where it was. */
static point_motion motion_of(dBodyID body, const double *was, const double *point)
{
    point_motion m;
    memset(&m, 0, sizeof m);
    if (!body) return m;
    const double *v = dBodyGetLinearVel(body), *w = dBodyGetAngularVel(body);
    double arm[3];
    for (int i = 0; i < 3; i++) arm[i] = point[i] - was[i];
    dCalcVectorCross3(m.linear, w, arm);
    for (int i = 0; i < 3; i++) {
        m.linear[i] += v[i];
        m.angular[i] = w[i];
    }
    return m;
}

/*
 * One step with a contact; the largest difference between the relative velocity solved for and the one that came out,
 * m/s at the contact. *force: the contact's normal force.
 */
static double step_and_compare(rig *r, double *force)
{
    dContact contact;
    memset(&contact, 0, sizeof contact);
    if (dCollide(r->geom, r->tip, 1, &contact.geom, sizeof contact.geom) == 1)
        assert_int_equal(pinch_ode_add_contact(r->plugin, &contact, r->body[0], r->tip_body), PINCH_OK);
    double was[2][3];
    for (int i = 0; i < 3; i++) {
        was[0][i] = dBodyGetPosition(r->body[0])[i];
        was[1][i] = dBodyGetPosition(r->tip_body)[i];
    }
    assert_int_equal(pinch_ode_solve(r->plugin, STEP), PINCH_OK);
    const pinch_ode_contact *list;
    pinch_ode_contact solved[8];
    int count;
    pinch_ode_contacts(r->plugin, &list, &count);
    assert_in_range(count, 0, 8);
    memcpy(solved, list, sizeof *list * (size_t)count);
    assert_int_equal(pinch_ode_advance(r->plugin, STEP), PINCH_OK);
    double most = 0;
    *force = 0;
    for (int k = 0; k < count; k++) {
        int first = solved[k].geom1 == r->geom ? 0 : 1;
        point_motion m1 = motion_of(first == 0 ? r->body[0] : r->tip_body, was[first], solved[k].position);
        point_motion m2 = motion_of(first == 0 ? r->tip_body : r->body[0], was[1 - first], solved[k].position);
        for (int i = 0; i < 3; i++)
            most = fmax(most, fabs(m1.linear[i] - m2.linear[i] - solved[k].relative_velocity[i]));
        *force += solved[k].normal_force;
    }
    return most;
}

static dJointID attach(const joint_kind *kind, rig *r, partner with, bool swapped)
{
    dBodyID other = with == STATIC_WORLD ? NULL : r->body[1];
    return swapped ? kind->make(r, other, r->body[0]) : kind->make(r, r->body[0], other);
}

/*
 * From a joint without errors: rounding. Velocities of 1 m/s, forces of 100 N on 0.1 kg and a conditioning of 1e3 of
 * the joint rows (lever arms of a few millimetres): 1e-11 m/s.
 */
static void test_first_step_is_exact(void **state)
{
    (void)state;
    int wrong = 0, cases = 0, touched = 0;
    for (int k = 0; k < KINDS; k++)
        for (partner with = 0; with < PARTNERS; with++)
            for (int swapped = 0; swapped < 2; swapped++)
                for (variant v = 0; v < VARIANTS; v++) {
                    const joint_kind *kind = &kinds[k];
                    bool plane = kind->make == make_plane;
                    if (kind->needs_two && with == STATIC_WORLD) continue;
                    if (plane && (with != STATIC_WORLD || swapped)) continue;
                    if (v != FREE && !kind->motorized) continue;
                    if ((v == AT_LOW_STOP || v == AT_HIGH_STOP || v == LOCKED || v == MOTOR_AT_STOP) &&
                        !kind->has_stops)
                        continue;
                    double worst = 0, force, pressed = 0;
                    for (uint64_t seed = 1; seed <= 5; seed++) {
                        rig r;
                        rig_make(&r, seed, with, 0.5);
                        dJointID j = attach(kind, &r, with, swapped);
                        set_variant(kind, j, v);
                        worst = fmax(worst, step_and_compare(&r, &force));
                        pinch_ode_stats stats = pinch_ode_statistics(r.plugin);
                        worst = fmax(worst, fmax(stats.step_mismatch, 0.1 * stats.step_mismatch_angular));
                        pressed = fmax(pressed, force);
                        assert_int_equal(stats.fallback_islands, 0);
                        assert_int_equal(stats.joints_unmodelled, 0);
                        rig_free(&r);
                    }
                    cases++;
                    touched += pressed > 0;
                    if (worst <= 1e-11) continue;
                    wrong++;
                    print_error("%s with %s%s, %s: off by %g m/s\n", kind->name, partner_names[with],
                                swapped ? " (swapped)" : "", variant_names[v], worst);
                }
    assert_true(cases > 150);
    assert_int_equal(touched, cases);
    assert_int_equal(wrong, 0);
}

static double spin_of(const rig *r)
{
    double most = 0;
    for (int i = 0; i < 2 && r->body[i]; i++) most = fmax(most, dCalcVectorLength3(dBodyGetAngularVel(r->body[i])));
    return most;
}

/*
 * In motion ODE corrects orientation errors for which it has no getters. A step at the rate w leaves an error of the
 * second order, (h w)^2; ERP takes a part p of it away per step, so it stays below (h w)^2 / p, and is corrected at the
 * rate p/h times that: h w^2. Twice that for two bodies that turn, and as much again for the angular motion it excites;
 * at the contact, 2 cm away and behind lever arms of up to three times that, a tenth of it in m/s.
 */
static void test_motion_errs_by_second_order(void **state)
{
    (void)state;
    int wrong = 0;
    for (int k = 0; k < KINDS; k++)
        for (partner with = 0; with < PARTNERS; with++)
            for (int swapped = 0; swapped < 2; swapped++) {
                const joint_kind *kind = &kinds[k];
                if (kind->needs_two && with == STATIC_WORLD) continue;
                if (kind->make == make_plane && (with != STATIC_WORLD || swapped)) continue;
                for (uint64_t seed = 1; seed <= 3; seed++) {
                    rig r;
                    double force, fastest = 0, worst = 0;
                    rig_make(&r, seed, with, 0.05);
                    dWorldSetGravity(r.world, 0, 0, 0);
                    attach(kind, &r, with, swapped);
                    for (int step = 0; step < 100; step++) {
                        fastest = fmax(fastest, spin_of(&r));
                        worst = fmax(worst, step_and_compare(&r, &force));
                        fastest = fmax(fastest, spin_of(&r));
                    }
                    pinch_ode_stats stats = pinch_ode_statistics(r.plugin);
                    double second_order = 4 * STEP * fastest * fastest + 1e-10;
                    if (stats.step_mismatch_angular > second_order || worst > 0.1 * second_order ||
                        stats.step_mismatch > 0.1 * second_order) {
                        wrong++;
                        print_error(
                            "%s with %s%s, seed %d: off by %g m/s at the contact, %g m/s, %g rad/s; spin %g rad/s "
                            "allows %g\n",
                            kind->name, partner_names[with], swapped ? " (swapped)" : "", (int)seed, worst,
                            stats.step_mismatch, stats.step_mismatch_angular, fastest, second_order);
                    }
                    assert_int_equal(stats.fallback_islands, 0);
                    rig_free(&r);
                }
            }
    assert_int_equal(wrong, 0);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_first_step_is_exact),
        cmocka_unit_test(test_motion_errs_by_second_order),
    };
    int failed = cmocka_run_group_tests_name("joints against ODE's step", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
