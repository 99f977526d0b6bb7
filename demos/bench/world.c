/* The ODE program that the benchmarks run: building, detecting collisions, stepping with one solver or another. */
#include "world.h"

#include "bench.h"

#include "common/measure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS = 8 }; /* contact points of one pair */
enum { BODY = 1, TIP = 2, GROUND = 4 };

void bench_world_make(bench_world *w, const bench_settings *settings, double step)
{
    memset(w, 0, sizeof *w);
    w->settings = *settings;
    w->step = step;
    w->material = pinch_default_material();
    w->ode = dWorldCreate();
    w->space = dHashSpaceCreate(NULL);
    w->group = dJointGroupCreate(0);
    dWorldSetGravity(w->ode, 0, 0, -9.81);
    dWorldSetQuickStepNumIterations(w->ode, settings->iterations > 0 ? settings->iterations : 20);
    if (settings->solver != BENCH_PINCH) return;
    pinch_ode_settings s = pinch_ode_default_settings();
    s.stepper = PINCH_ODE_QUICKSTEP;
    s.cold_start = settings->cold;
    s.threads = settings->threads;
    s.keep_islands = settings->watched;
    w->failed = pinch_ode_create(w->ode, &s, &w->pinch) != PINCH_OK;
}

void bench_world_free(bench_world *w)
{
    pinch_ode_destroy(w->pinch);
    dJointGroupDestroy(w->group);
    dSpaceDestroy(w->space);
    dWorldDestroy(w->ode);
    free(w->contacts);
    free(w->bodies);
    free(w->driven);
    free(w->geoms);
    free(w->hinges);
    free(w->torques);
    memset(w, 0, sizeof *w);
}

/* Makes room for one more item. Room is doubled when the count is a power of two, so that few calls suffice. */
static bool grow(bench_world *w, void **items, int count, size_t size)
{
    if (count & (count - 1)) return true;
    void *more = realloc(*items, (size_t)(count > 0 ? 2 * count : 1) * size);
    if (more) *items = more;
    w->failed = w->failed || !more;
    return more != NULL;
}

static dBodyID new_body(bench_world *w, dBodyID **list, int *count, double x, double y, double z)
{
    dBodyID body = dBodyCreate(w->ode);
    dBodySetPosition(body, x, y, z);
    if (grow(w, (void **)list, *count, sizeof **list)) (*list)[(*count)++] = body;
    return body;
}

static void note_geom(bench_world *w, dGeomID geom)
{
    if (grow(w, (void **)&w->geoms, w->geom_count, sizeof *w->geoms)) w->geoms[w->geom_count++] = geom;
}

static void set_mass(dBodyID body, dGeomID geom, double kilograms)
{
    dMass mass;
    dVector3 size;
    dReal radius, length;
    switch (dGeomGetClass(geom)) {
    case dSphereClass:
        dMassSetSphereTotal(&mass, kilograms, dGeomSphereGetRadius(geom));
        break;
    case dCapsuleClass:
        dGeomCapsuleGetParams(geom, &radius, &length);
        dMassSetCapsuleTotal(&mass, kilograms, 3, radius, length);
        break;
    default:
        dGeomBoxGetLengths(geom, size);
        dMassSetBoxTotal(&mass, kilograms, size[0], size[1], size[2]);
    }
    dBodySetMass(body, &mass);
}

dBodyID bench_add_body(bench_world *w, dGeomID geom, double mass, double x, double y, double z)
{
    dBodyID body = new_body(w, &w->bodies, &w->body_count, x, y, z);
    set_mass(body, geom, mass);
    note_geom(w, geom);
    dSpaceAdd(w->space, geom);
    dGeomSetBody(geom, body);
    dGeomSetCategoryBits(geom, BODY);
    dGeomSetCollideBits(geom, BODY | TIP | GROUND);
    return body;
}

void bench_add_tip(bench_world *w, dGeomID geom, dBodyID body, double x, double y, double z)
{
    note_geom(w, geom);
    if (dGeomGetSpace(geom) != w->space) dSpaceAdd(w->space, geom);
    if (body)
        dGeomSetBody(geom, body);
    else
        dGeomSetPosition(geom, x, y, z);
    dGeomSetCategoryBits(geom, TIP);
    dGeomSetCollideBits(geom, BODY);
    dGeomSetData(geom, w);
    w->finger_count++;
    if (w->pinch) w->failed = pinch_ode_set_material(w->pinch, geom, &w->material) != PINCH_OK || w->failed;
}

void bench_add_ground(bench_world *w, dGeomID geom)
{
    note_geom(w, geom);
    dSpaceAdd(w->space, geom);
    dGeomSetCategoryBits(geom, GROUND);
    dGeomSetCollideBits(geom, BODY);
}

dBodyID bench_add_driven(bench_world *w, double x, double y, double z)
{
    dBodyID body = new_body(w, &w->driven, &w->driven_count, x, y, z);
    dBodySetKinematic(body);
    return body;
}

dJointID bench_add_hinge(bench_world *w, dBodyID body1, dBodyID body2, const double anchor[3], const double axis[3],
                         double torque)
{
    dJointID hinge = dJointCreateHinge(w->ode, NULL);
    dJointAttach(hinge, body1, body2);
    dJointSetHingeAnchor(hinge, anchor[0], anchor[1], anchor[2]);
    dJointSetHingeAxis(hinge, axis[0], axis[1], axis[2]);
    int count = w->hinge_count;
    if (grow(w, (void **)&w->hinges, count, sizeof *w->hinges) &&
        grow(w, (void **)&w->torques, count, sizeof *w->torques)) {
        w->hinges[count] = hinge;
        w->torques[count] = torque;
        w->hinge_count++;
    }
    return hinge;
}

/* Fingertips get their stiffness and damping as ERP and CFM, shared by the pair's points. Other contacts get what ODE's
 * own examples use. */
static void set_surface(const bench_world *w, bool tip, int sharing, dSurfaceParameters *surface)
{
    const pinch_material *m = &w->material;
    surface->mode = dContactApprox1;
    surface->mu = m->friction;
    if (!tip) return;
    double g = w->step * m->stiffness[0] + m->damping[0];
    surface->mode |= dContactSoftERP | dContactSoftCFM;
    surface->soft_erp = w->step * m->stiffness[0] / g;
    surface->soft_cfm = sharing / g;
}

/* Finds at most `room` <= POINTS contacts. */
static int find_contacts(void *context, dGeomID a, dGeomID b, int room, dContact *contacts)
{
    const bench_world *w = context;
    dContactGeom found[POINTS];
    int count = dCollide(a, b, room, found, sizeof found[0]);
    bool tip = dGeomGetData(a) || dGeomGetData(b);
    for (int i = 0; i < count; i++) {
        memset(&contacts[i], 0, sizeof contacts[i]);
        contacts[i].geom = found[i];
        set_surface(w, tip, count, &contacts[i].surface);
    }
    return count;
}

static void near_callback(void *data, dGeomID a, dGeomID b)
{
    bench_world *w = data;
    dContact found[POINTS];
    int count = find_contacts(w, a, b, POINTS, found);
    if (w->contact_count + count > w->contact_room) {
        int room = 2 * w->contact_room + 64;
        bench_contact *more = realloc(w->contacts, (size_t)room * sizeof *more);
        w->failed = w->failed || !more;
        if (!more) return;
        w->contacts = more;
        w->contact_room = room;
    }
    for (int i = 0; i < count; i++) {
        bench_contact *c = &w->contacts[w->contact_count++];
        memset(c, 0, sizeof *c);
        c->contact = found[i];
        c->body[0] = dGeomGetBody(a);
        c->body[1] = dGeomGetBody(b);
    }
}

double bench_prepare(bench_world *w)
{
    if (w->drive) w->drive(w);
    w->contact_count = 0;
    double start = clock_seconds();
    if (w->pinch)
        w->failed = w->failed || pinch_ode_each_pair(w->pinch, w->space, w, near_callback) != PINCH_OK;
    else
        dSpaceCollide(w->space, w, near_callback);
    return clock_seconds() - start;
}

/* This function must not be inlined: bench/profile tells callgrind to collect by its name. */
__attribute__((noinline)) static bool step_with_pinch(bench_world *w)
{
    for (int i = 0; i < w->contact_count; i++) {
        const bench_contact *c = &w->contacts[i];
        if (pinch_ode_add_contact(w->pinch, &c->contact, c->body[0], c->body[1]) != PINCH_OK) return false;
    }
    if (pinch_ode_set_body_count(w->pinch, w->body_count + w->driven_count) != PINCH_OK) return false;
    if (!w->settings.watched) return pinch_ode_step(w->pinch, w->step) == PINCH_OK;
    if (pinch_ode_solve(w->pinch, w->step) != PINCH_OK) return false;
    if (w->watch) w->watch(w->watch_context, w);
    return pinch_ode_advance(w->pinch, w->step) == PINCH_OK;
}

__attribute__((noinline)) static bool step_with_ode(bench_world *w)
{
    for (int i = 0; i < w->contact_count; i++) {
        bench_contact *c = &w->contacts[i];
        dJointID joint = dJointCreateContact(w->ode, w->group, &c->contact);
        dJointAttach(joint, c->body[0], c->body[1]);
        dJointSetFeedback(joint, &c->feedback);
    }
    int done = w->settings.solver == BENCH_QUICKSTEP ? dWorldQuickStep(w->ode, w->step) : dWorldStep(w->ode, w->step);
    dJointGroupEmpty(w->group);
    return done != 0;
}

double bench_step(bench_world *w)
{
    double start = clock_seconds();
    bool done = w->pinch ? step_with_pinch(w) : step_with_ode(w);
    double spent = clock_seconds() - start;
    w->steps++;
    w->time = w->steps * w->step;
    return done ? spent : -1;
}

double bench_whole_step(bench_world *w)
{
    if (w->drive) w->drive(w);
    double start = clock_seconds();
    bool done = pinch_ode_collide(w->pinch, w->space, POINTS, find_contacts, w) == PINCH_OK &&
                pinch_ode_set_body_count(w->pinch, w->body_count + w->driven_count) == PINCH_OK &&
                pinch_ode_step(w->pinch, w->step) == PINCH_OK;
    double spent = clock_seconds() - start;
    w->steps++;
    w->time = w->steps * w->step;
    return done ? spent : -1;
}

/* ODE's generator has 32 bits of state, into which both halves of the seed go. */
void bench_seed_ode(uint64_t seed)
{
    dRandSetSeed((unsigned long)((seed ^ seed >> 32) & 0xffffffff));
}
