/*
 * Joint forces from Pinch's own solve against ODE's worldstep, which solves the same rows once more: what the bodies
 * do, what the joints report, how far they drift, whatever the program does to them meanwhile.
 */
#include "support/cmocka_all.h"

#include "support/joint_rig.h"

#include <string.h>

static const double STEP = 1e-3;

/* The same rig twice: the joints by Pinch, and by ODE. */
typedef struct twins {
    joint_rig rig[2];
    dJointID joint[2];
    dJointFeedback feedback[2];
    double velocity_off, feedback_off; /* largest difference so far, relative where the numbers are large */
} twins;

static void twins_make(twins *t, const joint_kind *kind, uint64_t seed, joint_partner with, bool swapped,
                       joint_variant v)
{
    memset(t, 0, sizeof *t);
    for (int k = 0; k < 2; k++) {
        joint_rig_make(&t->rig[k], seed, with, 0.2, k == 1);
        t->joint[k] = joint_rig_attach(kind, &t->rig[k], with, swapped);
        joint_rig_set(kind, t->joint[k], v);
        dJointSetFeedback(t->joint[k], &t->feedback[k]);
    }
}

static void twins_free(twins *t)
{
    for (int k = 0; k < 2; k++) joint_rig_free(&t->rig[k]);
}

static void copy_state(dBodyID from, dBodyID to)
{
    const double *x = dBodyGetPosition(from), *v = dBodyGetLinearVel(from), *w = dBodyGetAngularVel(from);
    dBodySetPosition(to, x[0], x[1], x[2]);
    dBodySetQuaternion(to, dBodyGetQuaternion(from));
    dBodySetLinearVel(to, v[0], v[1], v[2]);
    dBodySetAngularVel(to, w[0], w[1], w[2]);
}

/* The tip goes along with the body, always 0.1 mm deep. */
static void press(joint_rig *r)
{
    const double *x = dBodyGetPosition(r->body[0]), *v = dBodyGetLinearVel(r->body[0]), *n = r->tip_normal;
    dBodySetPosition(r->tip_body, x[0] - 0.0299 * n[0], x[1] - 0.0299 * n[1], x[2] - 0.0299 * n[2]);
    dBodySetLinearVel(r->tip_body, v[0], v[1], v[2]);
    dBodySetAngularVel(r->tip_body, 0, 0, 0);
    dContact contact;
    memset(&contact, 0, sizeof contact);
    assert_int_equal(dCollide(r->geom, r->tip, 1, &contact.geom, sizeof contact.geom), 1);
    assert_int_equal(pinch_ode_add_contact(r->plugin, &contact, r->body[0], r->tip_body), PINCH_OK);
}

static double off(const double *a, const double *b)
{
    double most = 0;
    for (int i = 0; i < 3; i++) most = fmax(most, fabs(a[i] - b[i]) / fmax(1, fabs(b[i])));
    return most;
}

/* One step of both from the same state. */
static void twins_step(twins *t)
{
    for (int k = 0; k < 2; k++)
        if (t->rig[0].body[k]) copy_state(t->rig[0].body[k], t->rig[1].body[k]);
    for (int k = 0; k < 2; k++) {
        press(&t->rig[k]);
        assert_int_equal(pinch_ode_step(t->rig[k].plugin, STEP), PINCH_OK);
    }
    for (int k = 0; k < 2 && t->rig[0].body[k]; k++) {
        double linear = off(dBodyGetLinearVel(t->rig[0].body[k]), dBodyGetLinearVel(t->rig[1].body[k]));
        double angular = off(dBodyGetAngularVel(t->rig[0].body[k]), dBodyGetAngularVel(t->rig[1].body[k]));
        t->velocity_off = fmax(t->velocity_off, fmax(linear, angular));
    }
    const dJointFeedback *f = t->feedback;
    t->feedback_off = fmax(t->feedback_off, fmax(off(f[0].f1, f[1].f1), off(f[0].t1, f[1].t1)));
    t->feedback_off = fmax(t->feedback_off, fmax(off(f[0].f2, f[1].f2), off(f[0].t2, f[1].t2)));
}

/* Velocities of 1 m/s and 100 rad/s, forces of 1 to 1000 N, lever arms of millimetres: 1e-9 of them. */
static void test_every_joint(void **state)
{
    (void)state;
    int wrong = 0, cases = 0;
    for (int k = 0; k < joint_kind_count; k++)
        for (joint_partner with = 0; with < JOINT_PARTNERS; with++)
            for (int swapped = 0; swapped < 2; swapped++)
                for (joint_variant v = 0; v < JOINT_VARIANTS; v++) {
                    const joint_kind *kind = &joint_kinds[k];
                    if (!joint_rig_possible(kind, with, swapped, v)) continue;
                    enum { STEPS = 50 };
                    for (uint64_t seed = 1; seed <= 2; seed++) {
                        twins t;
                        twins_make(&t, kind, seed, with, swapped, v);
                        for (int step = 0; step < STEPS; step++) twins_step(&t);
                        pinch_ode_stats stats = pinch_ode_statistics(t.rig[0].plugin);
                        pinch_ode_stats other = pinch_ode_statistics(t.rig[1].plugin);
                        assert_int_equal(stats.fallback_islands, 0);
                        assert_int_equal(stats.joints_solved, kind->known ? STEPS : 0);
                        assert_int_equal(stats.joints_left, kind->known ? 0 : STEPS);
                        assert_int_equal(other.joints_solved, 0);
                        assert_true(dJointIsEnabled(t.joint[0]));
                        cases++;
                        if (!(t.velocity_off < 1e-9 && t.feedback_off < 1e-9)) {
                            wrong++;
                            print_error("%s with %s%s, %s, seed %d: velocities off by %g, feedback by %g\n", kind->name,
                                        joint_partner_names[with], swapped ? " (swapped)" : "", joint_variant_names[v],
                                        (int)seed, t.velocity_off, t.feedback_off);
                        }
                        twins_free(&t);
                    }
                }
    assert_true(cases > 300);
    assert_int_equal(wrong, 0);
}

static const joint_kind *kind_named(const char *name)
{
    for (int k = 0; k < joint_kind_count; k++)
        if (strcmp(joint_kinds[k].name, name) == 0) return &joint_kinds[k];
    fail();
    return NULL;
}

/* What programs do to a hinge between steps. */
static void interfere(twins *t, int step, joint_partner with)
{
    for (int k = 0; k < 2; k++) {
        joint_rig *r = &t->rig[k];
        dBodyID other = with == JOINT_STATIC_WORLD ? NULL : r->body[1];
        const double *x = dBodyGetPosition(r->body[0]);
        switch (step) {
        case 20:
            dJointSetHingeAxis(t->joint[k], 0.6, 0, 0.8);
            break;
        case 40:
            dJointAttach(t->joint[k], other, r->body[0]);
            dJointSetHingeAnchor(t->joint[k], x[0], x[1] + 0.03, x[2]);
            dJointSetHingeAxis(t->joint[k], 0, 1, 0);
            break;
        case 60: /* most likely to come back in the same place of memory */
            dJointDestroy(t->joint[k]);
            t->joint[k] = dJointCreateHinge(r->world, NULL);
            dJointAttach(t->joint[k], r->body[0], other);
            dJointSetHingeAnchor(t->joint[k], x[0] + 0.02, x[1], x[2]);
            dJointSetHingeAxis(t->joint[k], 0, -0.8, 0.6);
            dJointSetFeedback(t->joint[k], &t->feedback[k]);
            break;
        case 80:
            dJointSetHingeParam(t->joint[k], dParamFMax, 0.01);
            dJointSetHingeParam(t->joint[k], dParamVel, 2);
            break;
        case 100:
            dJointDisable(t->joint[k]);
            memset(&t->feedback[k], 0, sizeof t->feedback[k]);
            break;
        case 120: /* apart by now: the hinge pulls them together */
            dJointEnable(t->joint[k]);
            break;
        case 400: /* not where it was measured from: the angle alone changes */
            dJointSetHingeAxisOffset(t->joint[k], 0, 0, 1, 0.3);
            break;
        default:
            break;
        }
    }
}

static void test_joints_that_change(void **state)
{
    (void)state;
    for (joint_partner with = 0; with < JOINT_PARTNERS; with++) {
        twins t;
        twins_make(&t, kind_named("hinge"), 11, with, false, JOINT_FREE);
        for (int step = 0; step < 500; step++) {
            interfere(&t, step, with);
            if (step == 101) assert_false(dJointIsEnabled(t.joint[0]));
            twins_step(&t);
            if (t.velocity_off > 1e-9 || t.feedback_off > 1e-8)
                print_error("%s, step %d: velocities off by %g, feedback by %g\n", joint_partner_names[with], step,
                            t.velocity_off, t.feedback_off);
            assert_true(t.velocity_off <= 1e-9 && t.feedback_off <= 1e-8);
        }
        pinch_ode_stats stats = pinch_ode_statistics(t.rig[0].plugin);
        assert_int_equal(stats.joints_solved, 380);
        assert_int_equal(stats.joints_left, 100); /* an offset of the angle hides where the second axis is */
        twins_free(&t);
    }
}

/* A chain that hangs from the world or a body, on hinges, universal and ball joints in turn. */
enum { LINKS = 6 };
static const double LENGTH = 0.1; /* m */

typedef struct chain {
    dBodyID link[LINKS];
    dJointID joint[LINKS];
    double axis[LINKS][2][3]; /* of the hinges, in the frames of the two bodies */
} chain;

static void to_frame(dBodyID body, const double axis[3], double out[3])
{
    dVector3 v;
    dBodyVectorFromWorld(body, axis[0], axis[1], axis[2], v);
    for (int i = 0; i < 3; i++) out[i] = body ? v[i] : axis[i];
}

/* Stretched out along x from (x, 0, z) on. */
static void chain_make(chain *c, dWorldID world, dBodyID from, double x, double z)
{
    memset(c, 0, sizeof *c);
    for (int k = 0; k < LINKS; k++) {
        dMass mass;
        dMassSetBoxTotal(&mass, 0.1, LENGTH, 0.02, 0.03);
        c->link[k] = dBodyCreate(world);
        dBodySetMass(c->link[k], &mass);
        dBodySetPosition(c->link[k], x + (k + 0.5) * LENGTH, 0, z);
        dBodyID above = k > 0 ? c->link[k - 1] : from;
        double at = x + k * LENGTH;
        const double axis[3] = {0, 0.8, k == 4 ? 0.6 : -0.6};
        switch (k % 4) {
        case 0:
        case 1:
            c->joint[k] = dJointCreateHinge(world, NULL);
            dJointAttach(c->joint[k], c->link[k], above);
            dJointSetHingeAnchor(c->joint[k], at, 0, z);
            dJointSetHingeAxis(c->joint[k], axis[0], axis[1], axis[2]);
            to_frame(c->link[k], axis, c->axis[k][0]);
            memcpy(c->axis[k][1], axis, sizeof axis); /* the links are made unturned */
            break;
        case 2:
            c->joint[k] = dJointCreateUniversal(world, NULL);
            dJointAttach(c->joint[k], above, c->link[k]);
            dJointSetUniversalAnchor(c->joint[k], at, 0, z);
            dJointSetUniversalAxis1(c->joint[k], 0, 0, 1);
            dJointSetUniversalAxis2(c->joint[k], 0, 1, 0);
            break;
        default:
            c->joint[k] = dJointCreateBall(world, NULL);
            dJointAttach(c->joint[k], c->link[k], above);
            dJointSetBallAnchor(c->joint[k], at, 0, z);
        }
    }
}

/* How far apart the links' ends are, m, and the hinges' axes, rad; the largest. */
static void chain_errors(const chain *c, dBodyID from, double x, double z, double *gap, double *tilt)
{
    for (int k = 0; k < LINKS; k++) {
        dVector3 mine, its = {x, 0, z};
        dBodyID above = k > 0 ? c->link[k - 1] : from;
        dBodyGetRelPointPos(c->link[k], -0.5 * LENGTH, 0, 0, mine);
        if (k > 0)
            dBodyGetRelPointPos(above, 0.5 * LENGTH, 0, 0, its);
        else if (from)
            dBodyGetRelPointPos(from, 0, 0, 0, its);
        *gap = fmax(*gap, dCalcPointsDistance3(mine, its));
        if (k % 4 > 1) continue;
        dVector3 a, b, across;
        const double *one = c->axis[k][0], *two = c->axis[k][1];
        dBodyVectorToWorld(c->link[k], one[0], one[1], one[2], a);
        memcpy(b, two, 3 * sizeof *two);
        if (above) dBodyVectorToWorld(above, two[0], two[1], two[2], b);
        dCalcVectorCross3(across, a, b);
        *tilt = fmax(*tilt, dCalcVectorLength3(across));
    }
}

static double kinetic_and_height(dBodyID body)
{
    dMass mass;
    dVector3 w, L;
    dBodyGetMass(body, &mass);
    const double *v = dBodyGetLinearVel(body), *turn = dBodyGetAngularVel(body);
    dBodyVectorFromWorld(body, turn[0], turn[1], turn[2], w);
    dMultiply0_331(L, mass.I, w);
    return 0.5 * mass.mass * dCalcVectorDot3(v, v) + 0.5 * dCalcVectorDot3(w, L) +
           9.81 * mass.mass * dBodyGetPosition(body)[2];
}

typedef struct swing {
    double gap, tilt;  /* m, rad: the largest */
    double start, top; /* J: energy, and the most of it */
    long solved, left; /* joints */
} swing;

/* A ball on the ground, heavy against the chain that swings from its centre, through everything, for five seconds. */
static swing swing_chain(pinch_ode_stepper stepper, bool by_ode)
{
    dWorldID world = dWorldCreate();
    dWorldSetGravity(world, 0, 0, -9.81);
    dGeomID ground = dCreatePlane(NULL, 0, 0, 1, 0), geom = dCreateSphere(NULL, 0.1);
    dBodyID ball = dBodyCreate(world);
    dMass mass;
    dMassSetSphereTotal(&mass, 3, 0.1);
    dBodySetMass(ball, &mass);
    dBodySetPosition(ball, 0, 0, 0.1);
    dGeomSetBody(geom, ball);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = stepper;
    settings.joints_by_ode = by_ode;
    pinch_ode *plugin;
    assert_int_equal(pinch_ode_create(world, &settings, &plugin), PINCH_OK);
    pinch_material material = pinch_default_material();
    assert_int_equal(pinch_ode_set_material(plugin, ground, &material), PINCH_OK);
    chain c;
    chain_make(&c, world, ball, 0, 0.1);
    swing s = {0, 0, 0, -INFINITY, 0, 0};
    for (int step = 0; step < 5000; step++) {
        dContact contact[4];
        memset(contact, 0, sizeof contact);
        int count = dCollide(ground, geom, 4, &contact[0].geom, sizeof contact[0]);
        for (int k = 0; k < count; k++)
            assert_int_equal(pinch_ode_add_contact(plugin, &contact[k], NULL, ball), PINCH_OK);
        double energy = kinetic_and_height(ball);
        for (int k = 0; k < LINKS; k++) energy += kinetic_and_height(c.link[k]);
        if (step == 0) s.start = energy;
        s.top = fmax(s.top, energy);
        assert_int_equal(pinch_ode_step(plugin, STEP), PINCH_OK);
        chain_errors(&c, ball, 0, 0, &s.gap, &s.tilt);
    }
    pinch_ode_stats stats = pinch_ode_statistics(plugin);
    assert_int_equal(stats.fallback_islands, 0);
    s.solved = stats.joints_solved;
    s.left = stats.joints_left;
    pinch_ode_destroy(plugin);
    dGeomDestroy(geom);
    dGeomDestroy(ground);
    dWorldDestroy(world);
    return s;
}

/* The chain whips about, so that runs of other bits part: compared is what they have in common. */
static void test_swinging_chain(void **state)
{
    (void)state;
    swing theirs = swing_chain(PINCH_ODE_WORLDSTEP, true);
    for (pinch_ode_stepper stepper = 0; stepper < 2; stepper++) {
        swing ours = swing_chain(stepper, false);
        assert_true(ours.solved > 4500 * LINKS && ours.left == 0);
        assert_true(ours.gap < 1.2 * theirs.gap && ours.tilt < 1.2 * theirs.tilt);
        assert_true(ours.top <= ours.start && theirs.top <= theirs.start);
    }
}

/* Three fingers of two hinged links about a ball. */
enum { FINGERS = 3, HAND_JOINTS = 2 * FINGERS };

typedef struct hand {
    dWorldID world;
    pinch_ode *plugin;
    dBodyID ball, link[HAND_JOINTS];
    dJointID hinge[HAND_JOINTS];
    dJointFeedback feedback[HAND_JOINTS];
    dGeomID ball_geom, tip[FINGERS];
} hand;

static void add_link(hand *h, int k, double c, double s, double reach)
{
    dMass mass;
    bool first = k % 2 == 0;
    dMassSetCapsuleTotal(&mass, 0.03, 3, 0.006, 0.05);
    h->link[k] = dBodyCreate(h->world);
    dBodySetMass(h->link[k], &mass);
    dBodySetPosition(h->link[k], reach * c, reach * s, first ? -0.075 : -0.025);
    h->hinge[k] = dJointCreateHinge(h->world, NULL);
    if (first) /* to the world, one of them the other way round */
        dJointAttach(h->hinge[k], k == 0 ? NULL : h->link[k], k == 0 ? h->link[k] : NULL);
    else
        dJointAttach(h->hinge[k], h->link[k], h->link[k - 1]);
    dJointSetHingeAnchor(h->hinge[k], reach * c, reach * s, first ? -0.1 : -0.05);
    dJointSetHingeAxis(h->hinge[k], s, -c, 0);
    dJointSetFeedback(h->hinge[k], &h->feedback[k]);
}

static void hand_make(hand *h, pinch_ode_stepper stepper)
{
    const double radius = 0.03, tip = 0.01;
    memset(h, 0, sizeof *h);
    h->world = dWorldCreate();
    dWorldSetGravity(h->world, 0, 0, -9.81);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.stepper = stepper;
    assert_int_equal(pinch_ode_create(h->world, &settings, &h->plugin), PINCH_OK);
    dMass mass;
    dMassSetSphereTotal(&mass, 0.1, radius);
    h->ball = dBodyCreate(h->world);
    dBodySetMass(h->ball, &mass);
    h->ball_geom = dCreateSphere(NULL, radius);
    dGeomSetBody(h->ball_geom, h->ball);
    pinch_material material = pinch_default_material();
    for (int finger = 0; finger < FINGERS; finger++) {
        double angle = 2 * M_PI * finger / FINGERS, c = cos(angle), s = sin(angle);
        add_link(h, 2 * finger, c, s, radius + tip);
        add_link(h, 2 * finger + 1, c, s, radius + tip);
        h->tip[finger] = dCreateSphere(NULL, tip);
        dGeomSetBody(h->tip[finger], h->link[2 * finger + 1]);
        dGeomSetOffsetPosition(h->tip[finger], 0, 0, 0.025);
        assert_int_equal(pinch_ode_set_material(h->plugin, h->tip[finger], &material), PINCH_OK);
    }
}

static void hand_free(hand *h)
{
    pinch_ode_destroy(h->plugin);
    dGeomDestroy(h->ball_geom);
    for (int k = 0; k < FINGERS; k++) dGeomDestroy(h->tip[k]);
    dWorldDestroy(h->world);
}

static void hand_touch(hand *h)
{
    for (int finger = 0; finger < FINGERS; finger++) {
        dContact contact;
        memset(&contact, 0, sizeof contact);
        if (dCollide(h->ball_geom, h->tip[finger], 1, &contact.geom, sizeof contact.geom) == 1)
            assert_int_equal(pinch_ode_add_contact(h->plugin, &contact, h->ball, h->link[2 * finger + 1]), PINCH_OK);
    }
}

/* Presses with 2 N a finger, springs about the posture; returns what is left of a link's linear momentum balance, N. */
static double hand_step(hand *h)
{
    double before[HAND_JOINTS][3], most = 0;
    for (int k = 0; k < HAND_JOINTS; k++) {
        double angle = dJointGetHingeAngle(h->hinge[k]), rate = dJointGetHingeAngleRate(h->hinge[k]);
        double press = (k == 0 ? -1 : 1) * 2 * 0.05 * (2 - k % 2);
        dJointAddHingeTorque(h->hinge[k], press - 0.5 * angle - 5e-3 * rate);
        memcpy(before[k], dBodyGetLinearVel(h->link[k]), sizeof before[k]);
    }
    hand_touch(h);
    assert_int_equal(pinch_ode_step(h->plugin, STEP), PINCH_OK);
    const pinch_ode_contact *list;
    int count;
    assert_int_equal(pinch_ode_contacts(h->plugin, &list, &count), PINCH_OK);
    for (int k = 0; k < HAND_JOINTS; k++) {
        double left[3] = {0, 0, 0.03 * 9.81};
        for (int i = 0; i < 3; i++) {
            left[i] += 0.03 * (dBodyGetLinearVel(h->link[k])[i] - before[k][i]) / STEP - h->feedback[k].f1[i];
            if (k % 2 == 0) left[i] -= h->feedback[k + 1].f2[i];
            for (int c = 0; c < count; c++) {
                if (list[c].body1 == h->link[k]) left[i] -= list[c].force[i];
                if (list[c].body2 == h->link[k]) left[i] += list[c].force[i];
            }
            most = fmax(most, fabs(left[i]));
        }
    }
    return most;
}

/* The ball comes to rest in the hand, and every link's forces balance: contacts, feedback, weight. */
static void test_hand(void **state)
{
    (void)state;
    for (pinch_ode_stepper stepper = 0; stepper < 2; stepper++) {
        hand h;
        hand_make(&h, stepper);
        double left = 0;
        for (int step = 0; step < 3000; step++) left = fmax(left, hand_step(&h));
        pinch_ode_stats stats = pinch_ode_statistics(h.plugin);
        const double *v = dBodyGetLinearVel(h.ball), *x = dBodyGetPosition(h.ball);
        assert_true(left < 1e-9);
        assert_true(dCalcVectorLength3(v) < 1e-12 && fabs(x[2]) < 1e-3);
        assert_int_equal(stats.joints_solved, 3000 * HAND_JOINTS);
        assert_true(stats.step_mismatch < 1e-10 && stats.step_mismatch_angular < 1e-8);
        hand_free(&h);
    }
}

/* Where ODE has a say in how joints share a load, it gets them all. */
static void test_left_to_ode(void **state)
{
    (void)state;
    enum { DOUBLED = 0, LOOSE_CONTACT, ANOTHER_TYPE, CASES };
    for (int kind = 0; kind < CASES; kind++) {
        hand h;
        hand_make(&h, PINCH_ODE_WORLDSTEP);
        dJointGroupID group = dJointGroupCreate(0);
        if (kind == DOUBLED || kind == ANOTHER_TYPE) {
            dJointID more = kind == DOUBLED ? dJointCreateHinge(h.world, NULL) : dJointCreatePR(h.world, NULL);
            dJointAttach(more, kind == DOUBLED ? h.link[3] : h.ball, kind == DOUBLED ? h.link[2] : NULL);
            if (kind == DOUBLED) {
                dVector3 anchor, axis;
                dJointGetHingeAnchor(h.hinge[3], anchor);
                dJointGetHingeAxis(h.hinge[3], axis);
                dJointSetHingeAnchor(more, anchor[0] + 0.01 * axis[0], anchor[1] + 0.01 * axis[1], anchor[2]);
                dJointSetHingeAxis(more, axis[0], axis[1], axis[2]);
            }
        }
        for (int step = 0; step < 20; step++) {
            if (kind == LOOSE_CONTACT) { /* the program's own, which it has not handed over */
                dContact contact;
                memset(&contact, 0, sizeof contact);
                contact.geom.normal[2] = 1;
                contact.geom.depth = 1e-6;
                dJointAttach(dJointCreateContact(h.world, group, &contact), h.ball, NULL);
            }
            hand_step(&h);
            dJointGroupEmpty(group);
        }
        pinch_ode_stats stats = pinch_ode_statistics(h.plugin);
        assert_int_equal(stats.joints_solved, 0);
        assert_true(stats.joints_left >= 20 * HAND_JOINTS);
        dJointGroupDestroy(group);
        hand_free(&h);
    }
}

/* A joint that is gone when ODE steps carries nothing, and the others are ODE's for that step. */
static void test_joint_destroyed_after_the_solve(void **state)
{
    (void)state;
    hand h;
    hand_make(&h, PINCH_ODE_WORLDSTEP);
    for (int step = 0; step < 20; step++) hand_step(&h);
    pinch_ode_reset_statistics(h.plugin);
    hand_touch(&h);
    assert_int_equal(pinch_ode_solve(h.plugin, STEP), PINCH_OK);
    dJointDestroy(h.hinge[5]);
    assert_int_equal(pinch_ode_advance(h.plugin, STEP), PINCH_OK);
    pinch_ode_stats stats = pinch_ode_statistics(h.plugin);
    assert_int_equal(stats.joints_solved, 0);
    assert_int_equal(stats.joints_left, HAND_JOINTS);
    for (int k = 0; k < HAND_JOINTS - 1; k++) assert_true(dJointIsEnabled(h.hinge[k]));
    hand_touch(&h);
    assert_int_equal(pinch_ode_step(h.plugin, STEP), PINCH_OK);
    stats = pinch_ode_statistics(h.plugin);
    assert_true(stats.joints_solved > 0);
    hand_free(&h);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_joint),    cmocka_unit_test(test_joints_that_change),
        cmocka_unit_test(test_swinging_chain), cmocka_unit_test(test_hand),
        cmocka_unit_test(test_left_to_ode),    cmocka_unit_test(test_joint_destroyed_after_the_solve),
    };
    int failed = cmocka_run_group_tests_name("joint forces", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
