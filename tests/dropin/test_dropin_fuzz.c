/*
 * Makes random calls of the functions that the drop-in layer stands in for, in any order that is legal for ODE, under
 * the sanitizers. A model beside it knows which contact joints are alive and act, and the statistics must agree with it
 * at every step.
 */

#include "support/cmocka_all.h"

#include "support/draw.h"

#include <pinch/ode_dropin.h>

#include <string.h>

enum { WORLDS = 3, BODIES = 6, GEOMS = 10, JOINTS = 24, GROUPS = 4, CALLS_A_SEED = 2000 };

typedef struct joint {
    dJointID id; /* NULL: a free place */
    int group;   /* -1: none */
    int body[2]; /* of its world, -1: none */
    bool disabled;
} joint;

typedef struct world {
    dWorldID id; /* NULL: a free place */
    dSpaceID space;
    dBodyID body[BODIES];
    dGeomID geom[GEOMS];
    joint joint[JOINTS];
} world;

typedef struct play {
    pinch_random random;
    world worlds[WORLDS];
    dJointGroupID groups[GROUPS];
    long steps;
} play;

static int pick(play *p, int count)
{
    return draw_index(&p->random, count);
}

static double uniform(play *p, double low, double high)
{
    return draw_uniform(&p->random, low, high);
}

/* -------------------------------------------------------------------------------------------------- lives of things */

static void create_world(play *p, world *w)
{
    memset(w, 0, sizeof *w);
    w->id = dWorldCreate();
    w->space = dSimpleSpaceCreate(NULL);
    dWorldSetGravity(w->id, 0, 0, uniform(p, -10, 0));
    if (pick(p, 3) == 0) dWorldSetAutoDisableFlag(w->id, 1);
    w->geom[0] = dCreatePlane(w->space, 0, 0, 1, 0);
}

static void destroy_world(play *p, world *w)
{
    bool space_first = pick(p, 2);
    if (space_first) dSpaceDestroy(w->space);
    dWorldDestroy(w->id); /* what is left of its joints in groups is nobody's */
    if (!space_first) dSpaceDestroy(w->space);
    memset(w, 0, sizeof *w);
}

static void place(play *p, dBodyID body)
{
    double x[9];
    for (int i = 2; i >= 0; i--) x[i] = uniform(p, i < 2 ? -1 : 0, 1);
    for (int i = 5; i >= 3; i--) x[i] = uniform(p, -1, 1);
    for (int i = 8; i >= 6; i--) x[i] = uniform(p, -1, 1);
    dBodySetPosition(body, x[0], x[1], x[2]);
    dBodySetLinearVel(body, x[3], x[4], x[5]);
    dBodySetAngularVel(body, x[6], x[7], x[8]);
}

static void change_body(play *p, world *w)
{
    int k = pick(p, BODIES);
    dBodyID body = w->body[k];
    if (!body) {
        dMass mass;
        dMassSetSphereTotal(&mass, exp(uniform(p, -2, 2)), 0.3);
        w->body[k] = body = dBodyCreate(w->id);
        dBodySetMass(body, &mass);
        place(p, body);
        return;
    }
    switch (pick(p, 6)) {
    case 0:
        dBodyDestroy(body); /* detaches its geoms and its joints, from both bodies */
        w->body[k] = NULL;
        for (int i = 0; i < JOINTS; i++)
            if (w->joint[i].body[0] == k || w->joint[i].body[1] == k) w->joint[i].body[0] = w->joint[i].body[1] = -1;
        return;
    case 1:
        dBodySetKinematic(body);
        return;
    case 2:
        dBodySetDynamic(body);
        return;
    case 3:
        dBodyDisable(body);
        return;
    case 4:
        dBodyEnable(body);
        return;
    default:
        place(p, body);
    }
}

static void change_geom(play *p, world *w)
{
    int k = pick(p, GEOMS);
    if (w->geom[k]) {
        dGeomDestroy(w->geom[k]);
        w->geom[k] = NULL;
        return;
    }
    w->geom[k] = pick(p, 2) ? dCreateSphere(w->space, uniform(p, 0.1, 0.5)) : dCreateBox(w->space, 0.3, 0.4, 0.5);
    dGeomSetBody(w->geom[k], w->body[pick(p, BODIES)]);
    if (pick(p, 4) == 0) {
        pinch_material tip = pinch_default_material();
        assert_int_equal(pinch_dropin_set_material(w->id, w->geom[k], &tip), PINCH_OK);
    }
}

static void clean_space(world *w)
{
    dSpaceClean(w->space);
    memset(w->geom, 0, sizeof w->geom);
}

/* ---------------------------------------------------------------------------------------------------------- contacts
 */

static void draw_surface(play *p, dSurfaceParameters *s)
{
    s->mode = 0;
    if (pick(p, 2)) s->mode |= dContactApprox1;
    if (pick(p, 8) == 0) s->mode |= dContactMu2;
    if (pick(p, 4) == 0) s->mode |= dContactSoftERP;
    if (pick(p, 3) == 0) s->mode |= dContactSoftCFM;
    if (pick(p, 6) == 0) s->mode |= dContactBounce;
    if (pick(p, 8) == 0) s->mode |= dContactMotion1;
    if (pick(p, 8) == 0) s->mode |= dContactSlip1 | dContactSlip2;
    if (pick(p, 8) == 0) s->mode |= dContactRolling;
    s->mu = pick(p, 10) ? uniform(p, 0, 2) : dInfinity;
    s->mu2 = uniform(p, 0, 2);
    s->rho = s->rho2 = s->rhoN = uniform(p, 0, 0.1);
    s->bounce = uniform(p, 0, 1);
    s->bounce_vel = 0.1;
    s->soft_erp = uniform(p, 0, 1);
    s->soft_cfm = pick(p, 4) ? exp(uniform(p, -15, -3)) : 0;
    s->motion1 = uniform(p, -1, 1);
    s->slip1 = s->slip2 = uniform(p, 0, 0.1);
}

static dContact draw_contact(play *p, const world *w)
{
    dContact contact;
    memset(&contact, 0, sizeof contact);
    draw_surface(p, &contact.surface);
    for (int i = 0; i < 3; i++) contact.geom.pos[i] = uniform(p, -0.5, 0.5);
    draw_direction(&p->random, contact.geom.normal);
    contact.geom.depth = uniform(p, 0, 0.01);
    contact.geom.g1 = w->geom[pick(p, GEOMS)];
    contact.geom.g2 = pick(p, 8) ? w->geom[pick(p, GEOMS)] : NULL;
    return contact;
}

static void attach(play *p, const world *w, joint *j)
{
    int body[2];
    for (int side = 0; side < 2; side++) {
        body[side] = pick(p, BODIES);
        if (!w->body[body[side]] || pick(p, 4) == 0) body[side] = -1;
    }
    if (body[0] == body[1]) body[1] = -1;
    for (int side = 0; side < 2; side++) j->body[side] = body[side];
    dJointAttach(j->id, body[0] >= 0 ? w->body[body[0]] : NULL, body[1] >= 0 ? w->body[body[1]] : NULL);
}

static void change_joint(play *p, world *w)
{
    joint *j = &w->joint[pick(p, JOINTS)];
    if (!j->id) {
        dContact contact = draw_contact(p, w);
        j->group = pick(p, GROUPS + 1) - 1;
        j->body[0] = j->body[1] = -1;
        j->disabled = false;
        j->id = dJointCreateContact(w->id, j->group >= 0 ? p->groups[j->group] : NULL, &contact);
        if (pick(p, 10)) attach(p, w, j);
        return;
    }
    switch (pick(p, 4)) {
    case 0:
        attach(p, w, j);
        return;
    case 1:
        dJointDestroy(j->id); /* ODE ignores it for a joint of a group */
        if (j->group < 0) j->id = NULL;
        return;
    case 2:
        dJointDisable(j->id);
        j->disabled = true;
        return;
    default:
        dJointEnable(j->id);
        j->disabled = false;
    }
}

static void empty_group(play *p)
{
    int k = pick(p, GROUPS);
    if (pick(p, 3)) {
        dJointGroupEmpty(p->groups[k]);
    } else {
        dJointGroupDestroy(p->groups[k]);
        p->groups[k] = dJointGroupCreate(0);
    }
    for (int i = 0; i < WORLDS; i++)
        for (int n = 0; n < JOINTS; n++)
            if (p->worlds[i].joint[n].group == k) p->worlds[i].joint[n].id = NULL;
}

/* ------------------------------------------------------------------------------------------------------------- steps
 */

static bool dynamic(const world *w, int body)
{
    return body >= 0 && !dBodyIsKinematic(w->body[body]);
}

static void expect_finite(play *p, const world *w)
{
    for (int k = 0; k < BODIES; k++) {
        if (!w->body[k]) continue;
        const dReal *x = dBodyGetPosition(w->body[k]), *v = dBodyGetLinearVel(w->body[k]);
        assert_true(isfinite(x[0] + x[1] + x[2]) && isfinite(v[0] + v[1] + v[2]));
        /* contacts out of nowhere may throw a body far: it comes back */
        if (fabs(x[0]) + fabs(x[1]) + fabs(x[2]) + fabs(v[0]) + fabs(v[1]) + fabs(v[2]) > 100) place(p, w->body[k]);
    }
}

static void step(play *p, world *w)
{
    long acting = 0, idle = 0;
    for (int i = 0; i < JOINTS; i++) {
        const joint *j = &w->joint[i];
        if (!j->id) continue;
        bool acts = !j->disabled && (dynamic(w, j->body[0]) || dynamic(w, j->body[1]));
        acting += acts;
        idle += !acts;
    }
    pinch_dropin_stats before = pinch_dropin_statistics();
    assert_int_equal(pick(p, 2) ? dWorldStep(w->id, 0.005) : dWorldQuickStep(w->id, 0.005), 1);
    pinch_dropin_stats after = pinch_dropin_statistics();
    assert_int_equal(after.contacts_offered - before.contacts_offered, acting);
    assert_int_equal(after.contacts_idle - before.contacts_idle, idle);
    assert_int_equal(after.steps - before.steps, 1);
    assert_int_equal(after.ode.contacts_left, after.ode.contacts_left_by_scope + after.ode.contacts_left_unsupported +
                                                  after.ode.contacts_left_unsolved);
    for (int i = 0; i < JOINTS; i++) /* as the program left it */
        if (w->joint[i].id) assert_int_equal(dJointIsEnabled(w->joint[i].id), !w->joint[i].disabled);
    expect_finite(p, w);
    p->steps++;
}

static void one_call(play *p)
{
    world *w = &p->worlds[pick(p, WORLDS)];
    if (!w->id) {
        create_world(p, w);
        return;
    }
    int call = pick(p, 1000);
    if (call < 2)
        destroy_world(p, w);
    else if (call < 6)
        clean_space(w);
    else if (call < 30)
        empty_group(p);
    else if (call < 90)
        step(p, w);
    else if (call < 250)
        change_body(p, w);
    else if (call < 400)
        change_geom(p, w);
    else
        change_joint(p, w);
}

static void any_legal_order(void **state)
{
    (void)state;
    int seeds = draw_count(10000000) / CALLS_A_SEED;
    long steps = 0;
    for (int seed = 1; seed <= seeds; seed++) {
        static play p;
        memset(&p, 0, sizeof p);
        pinch_random_seed(&p.random, (uint64_t)seed);
        for (int k = 0; k < GROUPS; k++) p.groups[k] = dJointGroupCreate(0);
        for (int call = 0; call < CALLS_A_SEED; call++) one_call(&p);
        for (int i = 0; i < WORLDS; i++)
            if (p.worlds[i].id) destroy_world(&p, &p.worlds[i]);
        for (int k = 0; k < GROUPS; k++) dJointGroupDestroy(p.groups[k]);
        steps += p.steps;
    }
    assert_true(steps > 10 * seeds);
}

/* ODE warns of worlds that are destroyed before their groups: legal, and done on purpose. */
static void say_nothing(int number, const char *text, va_list arguments)
{
    (void)number;
    (void)text;
    (void)arguments;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_legal_order),
    };
    dInitODE();
    dSetMessageHandler(say_nothing);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
