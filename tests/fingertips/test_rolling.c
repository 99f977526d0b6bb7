/*
 * What rolls builds up no shear, does not slip and gains no energy, however far it goes. Bodies roll freely on ODE's
 * plane and on a box through the plugin's own interface, and between two pads that move against each other.
 */
#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/scene_run.h"

#include <float.h>
#include <stdio.h>
#include <string.h>

static const double PI = 3.141592653589793, RADIUS = 0.01, MASS = 0.1;

typedef enum roller { BALL = 0, CYLINDER, CAPSULE, ROLLERS } roller;
static const char *const roller_names[] = {"sphere", "cylinder", "capsule"};

typedef struct track {
    dWorldID world;
    dBodyID body;
    dGeomID geom, floor;
    pinch_ode *plugin;
} track;

static void make_track(track *t, roller kind, bool plane, double length, double inclination)
{
    dMass mass;
    t->world = dWorldCreate();
    dWorldSetGravity(t->world, 0, 0, -9.81);
    t->body = dBodyCreate(t->world);
    dBodySetFiniteRotationMode(t->body, 1);
    if (kind == BALL) {
        t->geom = dCreateSphere(NULL, RADIUS);
        dMassSetSphereTotal(&mass, MASS, RADIUS);
    } else {
        bool capsule = kind == CAPSULE;
        t->geom = capsule ? dCreateCapsule(NULL, RADIUS, 0.04) : dCreateCylinder(NULL, RADIUS, 0.04);
        (capsule ? dMassSetCapsuleTotal : dMassSetCylinderTotal)(&mass, MASS, 3, RADIUS, 0.04);
    }
    dBodySetMass(t->body, &mass);
    dGeomSetBody(t->geom, t->body);
    if (kind != BALL) { /* its axis, local z, along world y, or off it */
        dQuaternion lie, turn, q;
        dQFromAxisAndAngle(lie, 1, 0, 0, -PI / 2);
        dQFromAxisAndAngle(turn, 0, 0, 1, inclination);
        dQMultiply0(q, turn, lie);
        dBodySetQuaternion(t->body, q);
    }
    t->floor = plane ? dCreatePlane(NULL, 0, 0, 1, 0) : dCreateBox(NULL, 2 * length + 1, 2 * length + 1, 0.1);
    if (!plane) dGeomSetPosition(t->floor, 0, 0, -0.05);
    pinch_ode_settings settings = pinch_ode_default_settings();
    assert_int_equal(pinch_ode_create(t->world, &settings, &t->plugin), PINCH_OK);
    pinch_material m = pinch_default_material();
    m.damping[0] = 60;
    m.damping[1] = 40;
    assert_int_equal(pinch_ode_set_material(t->plugin, t->floor, &m), PINCH_OK);
    dBodySetPosition(t->body, 0, 0, RADIUS - MASS * 9.81 / m.stiffness[0]);
}

static void free_track(track *t)
{
    pinch_ode_destroy(t->plugin);
    dGeomDestroy(t->geom);
    dGeomDestroy(t->floor);
    dWorldDestroy(t->world);
}

static void step_track(track *t, double h)
{
    dContact contacts[8] = {0};
    int n = dCollide(t->geom, t->floor, 8, &contacts[0].geom, sizeof contacts[0]);
    for (int i = 0; i < n; i++)
        assert_int_equal(pinch_ode_add_contact(t->plugin, &contacts[i], dGeomGetBody(contacts[i].geom.g1),
                                               dGeomGetBody(contacts[i].geom.g2)),
                         PINCH_OK);
    assert_int_equal(pinch_ode_step(t->plugin, h), PINCH_OK);
}

typedef struct reading {
    double normal, shear, slip;
} reading;

static reading read_track(const track *t)
{
    const pinch_ode_contact *list;
    int count;
    reading r = {0};
    assert_int_equal(pinch_ode_contacts(t->plugin, &list, &count), PINCH_OK);
    for (int k = 0; k < count; k++) {
        r.normal += list[k].normal_force;
        r.shear += dCalcVectorLength3(list[k].tangential);
        r.slip += dCalcVectorLength3(list[k].slip);
    }
    return r;
}

/* A thousand revolutions, ten in quick runs, at a speed of 10 rad/s: with and without an axis askew to the world's. */
static void rolls_freely(roller kind, bool plane, double inclination, double h)
{
    double turns = draw_full() ? 1000 : 10, spin = 2 * PI / 0.2, settle = 0.5, duration = settle + turns * 0.2;
    double direction[2] = {cos(inclination), sin(inclination)};
    track t;
    make_track(&t, kind, plane, duration * spin * RADIUS, inclination);
    dBodySetLinearVel(t.body, spin * RADIUS * direction[0], spin * RADIUS * direction[1], 0);
    dBodySetAngularVel(t.body, -spin * direction[1], spin * direction[0], 0);
    double energy = 0, gained = 0, shear = 0, slip = 0;
    dVector3 from = {0};
    for (long k = 1; k * h <= duration; k++) {
        step_track(&t, h);
        reading r = read_track(&t);
        slip += r.slip;
        if (k * h < settle) continue; /* it starts with the full radius, and the contact is half the overlap higher */
        double now = body_kinetic_energy(t.body);
        if (energy == 0) {
            energy = now;
            for (int i = 0; i < 3; i++) from[i] = dBodyGetPosition(t.body)[i];
        }
        gained = fmax(gained, now / energy - 1);
        shear = fmax(shear, r.shear / r.normal);
    }
    const double *x = dBodyGetPosition(t.body);
    double lost = 1 - body_kinetic_energy(t.body) / energy, way = hypot(x[0] - from[0], x[1] - from[1]);
    print_message("%-8s on a %-5s askew %.1f, step %.4g s: %.1f m, shear %.1e of the normal force, slip %.1e m, "
                  "energy gained %.1e lost %.1e\n",
                  roller_names[kind], plane ? "plane" : "box", inclination, h, way, shear, slip, gained, lost);
    assert_close(slip, 0, 0);
    assert_true(shear <= 1e-9);
    assert_true(gained <= 1e-9);                                                /* rounding of a thousand turns */
    assert_close(way, turns * 2 * PI * RADIUS, 0.02 * turns * 2 * PI * RADIUS); /* it did roll */
    assert_int_equal(pinch_ode_statistics(t.plugin).unconverged_steps, 0);
    free_track(&t);
}

static void test_rolls_freely(void **state)
{
    (void)state;
    for (int plane = 0; plane < 2; plane++)
        for (int kind = 0; kind < ROLLERS; kind++) {
            rolls_freely((roller)kind, plane, 0, 1e-3);
            rolls_freely((roller)kind, plane, 0.7, 1e-3);
        }
    rolls_freely(BALL, true, 0.3, 5e-4);
    rolls_freely(BALL, false, 0.3, 5e-3);
}

/*
 * Between pads that move against each other at speed v each, after they have got there. ODE rounds the orientation in
 * every step: like a random walk, the axis of a roller comes off the square to the pads' way. What touches along a line
 * is steered by that and rolls sideways, which pulls at both pads' contacts, the farther the more. That much shear is
 * right; a sphere, which turns about any axis, has none of it.
 */
static void rolls_between(const char *shape, double speed, double h)
{
    const double TANGENTIAL = 13300; /* N/m */
    double turns = draw_full() ? 1000 : 10, start = 1, duration = start + turns * 2 * PI * RADIUS / speed;
    double reach = speed * (duration - 0.9); /* uniform motion from 0.9 s on, in a ramp of 0.2 s before */
    char text[4096];
    int used = snprintf(text, sizeof text,
                        "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0], \"object\": {\"shape\": %s, \"mass\": "
                        "0.1, \"orientation\": [0.7071067811865476, 0.7071067811865476, 0, 0]}, \"fingers\": [",
                        shape);
    for (int side = 0; side < 2; side++) {
        int sign = side ? -1 : 1;
        used += snprintf(text + used, sizeof text - (size_t)used,
                         "%s{\"point\": [0, 0, %g], \"normal\": [0, 0, %d], \"tip\": {\"type\": \"box\", \"size\": "
                         "[0.01, 0.06, %.17g]}, \"model\": \"hard\", \"stiffness\": {\"normal\": 20000, "
                         "\"tangential\": %.17g}, \"damping\": "
                         "{\"normal\": 20, \"tangential\": 13.3}, \"friction\": 0.8, \"closing\": 0.0005, \"ramp\": "
                         "0.3, \"drive\": {\"type\": \"path\", \"points\": [{\"time\": 0.5, \"translation\": [0, 0, "
                         "0]}, {\"time\": 0.9, \"translation\": [%.17g, 0, 0]}, {\"time\": %.17g, \"translation\": "
                         "[%.17g, 0, 0]}]}}",
                         side ? ", " : "", -sign * RADIUS, sign, 2 * reach + 2, TANGENTIAL, sign * 0.4 * speed,
                         duration + 1, sign * speed * (duration + 1 - 0.5));
    }
    snprintf(text + used, sizeof text - (size_t)used, "], \"simulation\": {\"step\": %.17g, \"duration\": %.17g}}", h,
             duration);
    scene *s = scene_from_text(text);
    world *w = world_of(s);
    world_run_until(w, start);
    double energy = body_kinetic_energy(w->object), gained = 0, shear = 0, yaw = 0, sideways = 0;
    while (w->time < duration) {
        assert_int_equal(world_advance(w), WORLD_OK);
        const double *R = dBodyGetRotation(w->object);
        yaw = fmax(yaw, fabs(R[2] / R[6]));
        sideways += R[2] / R[6] * speed * h;
        if (w->time < start + 0.5) { /* the start's vibrations die away */
            energy = body_kinetic_energy(w->object);
            continue;
        }
        gained = fmax(gained, body_kinetic_energy(w->object) / energy - 1);
        for (int i = 0; i < 2; i++) {
            const world_finger_state *f = &w->fingers[i].state;
            shear = fmax(shear, dCalcVectorLength3(f->tangential_force) / f->normal_force);
        }
    }
    double slipped = fmax(w->fingers[0].state.slip_total, w->fingers[1].state.slip_total);
    bool steers = !strstr(shape, "sphere");
    double steered = !steers ? 0 : TANGENTIAL * fabs(sideways) / w->fingers[0].state.normal_force;
    print_message("%.10s.. between pads, step %.4g s: %.3g rad/s, shear %.1e of the normal force, %.1e at most by "
                  "steering, slip %.1e m, energy gained %.1e, off the middle %.1e m\n",
                  shape + 10, h, dCalcVectorLength3(dBodyGetAngularVel(w->object)), shear, steered, slipped, gained,
                  dCalcVectorLength3(dBodyGetPosition(w->object)));
    assert_close(slipped, 0, 0);
    assert_true(shear <= 2e-10 + steered);
    if (steers) assert_true(yaw <= 2 * DBL_EPSILON * sqrt(duration / h));
    assert_true(gained <= 1e-9);
    /* the pads give, the object does not: it rolls on its own radius, and not on that less the overlap of 0.5 mm */
    double spin = dCalcVectorLength3(dBodyGetAngularVel(w->object));
    assert_close(spin, speed / RADIUS, 1e-6 * speed / RADIUS);
    assert_int_equal(pinch_ode_statistics(w->plugin).unconverged_steps, 0);
    world_free(w);
    scene_free(s);
}

static void test_rolls_between_pads(void **state)
{
    (void)state;
    rolls_between("{\"type\": \"sphere\", \"radius\": 0.01}", 0.3, 1e-3);
    rolls_between("{\"type\": \"cylinder\", \"radius\": 0.01, \"length\": 0.04}", 0.3, 1e-3);
    rolls_between("{\"type\": \"capsule\", \"radius\": 0.01, \"length\": 0.04}", 0.3, 1e-3);
    rolls_between("{\"type\": \"sphere\", \"radius\": 0.01}", 0.1, 2e-3);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_rolls_freely), cmocka_unit_test(test_rolls_between_pads)};
    int failed = cmocka_run_group_tests_name("rolling", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
