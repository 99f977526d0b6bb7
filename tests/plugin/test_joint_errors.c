/*
 * The rows of every kind of joint take its error of position back: moved a little, the joint's bodies change each row's
 * right-hand side by the part ERP/h of what the row itself says that the motion does, and against it. Differences of
 * the rows' own errors show this without ODE's solver. ODE has joints for which it does not hold (prismatic_rows.c,
 * motor_rows.c).
 */
#include "support/cmocka_all.h"

#include "joints/joint_rows.h"

#include "support/joint_rig.h"

#include <string.h>

static const double STEP = 1e-3;

typedef struct probe {
    joint_rig rig;
    dJointID joint;
    dBodyID body[2];
    pinch_joint_poses poses;
    pinch_joint_row row[PINCH_JOINT_MAX_ROWS];
    pinch_joint_rows rows;
    int held; /* the first rows: no motors and stops */
} probe;

static void read_rows(probe *p)
{
    pinch_axis_reading reading;
    pinch_step_context context = {.world = p->rig.world, .h = STEP, .number = 1, .settings = {.joints_by_ode = false}};
    int hint = 0;
    pinch_joint_pose *pose = pinch_joint_pose_of(&p->poses, p->joint, p->body, &hint);
    memset(&reading, 0, sizeof reading);
    memset(&p->rows, 0, sizeof p->rows);
    p->rows.row = p->row;
    p->rows.reading = &reading;
    if (dJointGetType(p->joint) == dJointTypeHinge) pinch_read_hinge(p->joint, p->body, &reading);
    pinch_joint_rows_of(&context, p->joint, p->body, NULL, pose, &p->rows);
}

static void probe_make(probe *p, const joint_kind *kind, uint64_t seed, joint_partner with, bool swapped)
{
    memset(p, 0, sizeof *p);
    joint_rig_make(&p->rig, seed, with, 0, false);
    p->joint = joint_rig_attach(kind, &p->rig, with, swapped);
    pinch_joint_pose pose;
    assert_true(pinch_modelled_joint_bodies(p->joint, p->body));
    dJointType type = dJointGetType(p->joint);
    if (type == dJointTypePlane2D) assert_true(pinch_joint_is_new(&p->poses, p->joint, type, 0));
    if (pinch_joint_pose_now(p->joint, &pose)) assert_true(pinch_joint_pose_keep(&p->poses, &pose));
    read_rows(p);
    while (p->held < p->rows.count && isinf(p->row[p->held].low) && isinf(p->row[p->held].high)) p->held++;
}

static void probe_free(probe *p)
{
    pinch_joint_poses_free(&p->poses);
    joint_rig_free(&p->rig);
}

typedef struct place {
    dVector3 x;
    dQuaternion q;
} place;

static place place_of(dBodyID body)
{
    place here;
    memcpy(here.x, dBodyGetPosition(body), sizeof here.x);
    memcpy(here.q, dBodyGetQuaternion(body), sizeof here.q);
    return here;
}

/* Moves a body from a place: by m[0..2] (m), and about its centre by m[3..5] (rad). */
static void move_from(dBodyID body, const place *from, const double m[6])
{
    dQuaternion turn, q;
    double angle = dCalcVectorLength3(m + 3);
    memcpy(q, from->q, sizeof q);
    if (angle > 0) {
        dQFromAxisAndAngle(turn, m[3], m[4], m[5], angle);
        dQMultiply0(q, turn, from->q);
    }
    dBodySetPosition(body, from->x[0] + m[0], from->x[1] + m[1], from->x[2] + m[2]);
    dBodySetQuaternion(body, q);
}

/* Differences of all right-hand sides per unit of the bodies' six motions each. */
static void differences(probe *p, double change[PINCH_JOINT_MAX_ROWS][12])
{
    static const double MOVED = 1e-6;
    int count = p->rows.count;
    memset(change, 0, PINCH_JOINT_MAX_ROWS * sizeof *change);
    for (int k = 0; k < 12 && p->body[k / 6]; k++) {
        dBodyID body = p->body[k / 6];
        place from = place_of(body);
        for (int side = -1; side <= 1; side += 2) {
            double m[6] = {0};
            m[k % 6] = side * MOVED;
            move_from(body, &from, m);
            read_rows(p);
            assert_int_equal(p->rows.count, count);
            for (int i = 0; i < count; i++) change[i][k] += side * p->row[i].rhs / (2 * MOVED);
        }
        move_from(body, &from, (const double[6]){0});
    }
    read_rows(p);
}

static double dot12(const double *a, const double *b)
{
    double sum = 0;
    for (int k = 0; k < 12; k++) sum += a[k] * b[k];
    return sum;
}

static void take_off(double *a, const double *unit)
{
    double part = dot12(a, unit);
    for (int k = 0; k < 12; k++) a[k] -= part * unit[k];
}

/* Takes off what the joint's other rows hold: a row may be written for motions that these allow. */
static void take_off_others(const probe *p, int of, double *row, double *change)
{
    double basis[PINCH_JOINT_MAX_ROWS][12];
    int count = 0;
    for (int i = 0; i < p->held; i++) {
        double *next = basis[count];
        if (i == of) continue;
        memcpy(next, p->row[i].j1, 6 * sizeof *next);
        memcpy(next + 6, p->row[i].j2, 6 * sizeof *next);
        for (int k = 0; k < count; k++) take_off(next, basis[k]);
        double size = sqrt(dot12(next, next));
        for (int k = 0; k < 12; k++) next[k] /= size;
        count++;
    }
    for (int i = 0; i < count; i++) {
        take_off(row, basis[i]);
        take_off(change, basis[i]);
    }
}

/*
 * The differences are -J ERP/h, up to what an error of position changes in the rows' directions; those of a motor's
 * speed are 0. Returns how far off the worst row is, as a part of its own length. How far a stop's coordinate changes
 * is ODE's matter where the joint itself is torn apart: there it is that it changes against the row.
 */
static double worst_row(probe *p)
{
    double change[PINCH_JOINT_MAX_ROWS][12], worst = 0;
    differences(p, change);
    for (int i = 0; i < p->rows.count; i++) {
        double row[12] = {0};
        memcpy(row, p->row[i].j1, 6 * sizeof *row);
        if (p->body[1]) memcpy(row + 6, p->row[i].j2, 6 * sizeof *row);
        take_off_others(p, i, row, change[i]);
        double erp = -STEP * dot12(change[i], row) / dot12(row, row), off[12] = {0};
        for (int k = 0; k < 12 && i < p->held; k++) off[k] = STEP * change[i][k] + erp * row[k];
        worst = fmax(worst, erp < -1e-6 || erp > 1.1 ? INFINITY : sqrt(dot12(off, off) / dot12(row, row)));
    }
    return worst;
}

/* The bodies are off by up to `by` m, and by ten times that in rad, as levers are of some centimetres. */
static void displace(probe *p, double by)
{
    for (int side = 0; side < 2 && p->body[side]; side++) {
        double m[6];
        for (int i = 0; i < 6; i++) m[i] = draw_uniform(&p->rig.random, -by, by) * (i < 3 ? 1 : 10);
        if (dJointGetType(p->joint) == dJointTypePlane2D) m[3] = m[4] = 0; /* ODE corrects its height alone */
        place from = place_of(p->body[side]);
        move_from(p->body[side], &from, m);
    }
}

/* ODE has the force of a PU across its axis act at the first body's own anchor, wherever the second's has slid to, by
 * up to 0.05 m here. */
static double allowed(const joint_kind *kind, double by)
{
    return strcmp(kind->name, "PU") == 0 ? 0.05 : 1e-5 + 1e3 * by; /* rows turn, with levers of millimetres */
}

static int check_kind(const joint_kind *kind, joint_partner with, bool swapped, joint_variant v, double by)
{
    int wrong = 0;
    for (uint64_t seed = 1; seed <= 3; seed++) {
        probe p;
        probe_make(&p, kind, seed, with, swapped);
        joint_rig_set(kind, p.joint, v);
        displace(&p, by);
        read_rows(&p);
        double off = worst_row(&p);
        if (!(off < allowed(kind, by))) {
            wrong++;
            print_error("%s with %s%s, %s, seed %d, displaced by %g m: off by %g\n", kind->name,
                        joint_partner_names[with], swapped ? " (swapped)" : "", joint_variant_names[v], (int)seed, by,
                        off);
        }
        probe_free(&p);
    }
    return wrong;
}

/* The prismatic axis of a PU that is attached as (0, body) is ODE's in its rows, and another one in the position that
 * it shows, where the body was turned when the axis was set: its stops do not go with its position then. */
static bool has_two_axes(const joint_kind *kind, joint_partner with, bool swapped, joint_variant v)
{
    return v != JOINT_FREE && v != JOINT_MOTOR && strcmp(kind->name, "PU") == 0 && with == JOINT_STATIC_WORLD &&
           swapped;
}

static void test_errors_are_taken_back(void **state)
{
    (void)state;
    static const joint_variant variants[] = {JOINT_FREE, JOINT_MOTOR, JOINT_AT_LOW_STOP, JOINT_AT_HIGH_STOP,
                                             JOINT_LOCKED};
    int wrong = 0, cases = 0;
    for (int k = 0; k < joint_kind_count; k++)
        for (joint_partner with = 0; with < JOINT_PARTNERS; with++)
            for (int swapped = 0; swapped < 2; swapped++)
                for (size_t v = 0; v < sizeof variants / sizeof *variants; v++) {
                    const joint_kind *kind = &joint_kinds[k];
                    if (!joint_rig_possible(kind, with, swapped, variants[v]) || !kind->known) continue;
                    if (has_two_axes(kind, with, swapped, variants[v])) continue;
                    cases++;
                    wrong += check_kind(kind, with, swapped, variants[v], 0);
                    wrong += check_kind(kind, with, swapped, variants[v], 1e-5);
                }
    assert_true(cases > 200);
    assert_int_equal(wrong, 0);
}

/*
 * A box of 0.1 kg rests on the ground for 10 s, held by a PR or piston with a vertical axis that is attached as (0,
 * body). Its arm to the anchor is 1e-12 m by rounding: with ODE's sign it grows by 1.2 in a step, to metres within two
 * seconds. Every row holds, and the speed is rounding.
 */
static void test_a_mirrored_joint_rests(void **state)
{
    (void)state;
    for (int piston = 0; piston < 2; piston++) {
        joint_rig r;
        joint_rig_make(&r, 1, JOINT_STATIC_WORLD, 0, false);
        dGeomID ground = dCreatePlane(NULL, 0, 0, 1, 0);
        dBodyID body = r.body[0];
        dMatrix3 upright;
        dRSetIdentity(upright);
        dBodySetRotation(body, upright);
        dBodySetPosition(body, 1e-12, 0, 0.02);
        dWorldSetGravity(r.world, 0, 0, -9.81);
        dJointID joint = piston ? dJointCreatePiston(r.world, NULL) : dJointCreatePR(r.world, NULL);
        dJointAttach(joint, NULL, body);
        if (piston) {
            dJointSetPistonAnchor(joint, 0, 0, 0.02);
            dJointSetPistonAxis(joint, 0, 0, 1);
        } else {
            dJointSetPRAnchor(joint, 0, 0, 0.02);
            dJointSetPRAxis1(joint, 0, 0, 1);
            dJointSetPRAxis2(joint, 0, 1, 0);
        }
        assert_int_equal(pinch_ode_note_joint(r.plugin, joint), PINCH_OK);
        for (int step = 0; step < 1000; step++) {
            dContact contact;
            memset(&contact, 0, sizeof contact);
            contact.surface.mu = 0.5;
            if (dCollide(r.geom, ground, 1, &contact.geom, sizeof contact.geom) == 1)
                assert_int_equal(pinch_ode_add_contact(r.plugin, &contact, body, NULL), PINCH_OK);
            assert_int_equal(pinch_ode_step(r.plugin, 0.01), PINCH_OK);
        }
        assert_true(pinch_ode_statistics(r.plugin).joints_solved > 900);
        assert_true(dCalcVectorLength3(dBodyGetLinearVel(body)) < 1e-9);
        assert_true(hypot(dBodyGetPosition(body)[0], dBodyGetPosition(body)[1]) < 1e-9);
        dGeomDestroy(ground);
        joint_rig_free(&r);
    }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_errors_are_taken_back),
        cmocka_unit_test(test_a_mirrored_joint_rests),
    };
    int failed = cmocka_run_group_tests_name("errors of joints", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
