#define _POSIX_C_SOURCE 200809L

#include "sim.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static void refuse(const char *what)
{
    fprintf(stderr, "expected --steps N, --h SECONDS, --stepper world|quick, --seed N or --KEY NUMBER, got %s\n", what);
    exit(2);
}

static double number(const char *text)
{
    char *end;
    double value = strtod(text, &end);
    if (end == text || *end || !isfinite(value)) refuse(text);
    return value;
}

double sim_value(sim *s, const char *key, double otherwise)
{
    for (int i = 1; i + 1 < s->argc; i += 2)
        if (strncmp(s->argv[i], "--", 2) == 0 && strcmp(s->argv[i] + 2, key) == 0) return number(s->argv[i + 1]);
    return otherwise;
}

static void read_options(sim *s)
{
    for (int i = 1; i < s->argc; i += 2) {
        if (strncmp(s->argv[i], "--", 2) != 0 || i + 1 >= s->argc) refuse(s->argv[i]);
        if (strcmp(s->argv[i], "--stepper") != 0) (void)number(s->argv[i + 1]);
        if (strcmp(s->argv[i], "--stepper") != 0) continue;
        s->quick = strcmp(s->argv[i + 1], "quick") == 0;
        if (!s->quick && strcmp(s->argv[i + 1], "world") != 0) refuse(s->argv[i + 1]);
    }
    s->steps = (long)sim_value(s, "steps", (double)s->steps);
    s->h = sim_value(s, "h", s->h);
    s->seed = (unsigned long)sim_value(s, "seed", 1);
    if (s->steps < 0 || !(s->h > 0)) refuse("--steps or --h out of range");
}

static void start_threads(sim *s, unsigned count)
{
    if (count == 0) return;
    s->threading = dThreadingAllocateMultiThreadedImplementation();
    s->pool = dThreadingAllocateThreadPool(count, 0, dAllocateFlagBasicData, NULL);
    dThreadingThreadPoolServeMultiThreadedImplementation(s->pool, s->threading);
    dWorldSetStepThreadingImplementation(s->world, dThreadingImplementationGetFunctions(s->threading), s->threading);
}

static void end_threads(sim *s)
{
    if (!s->threading) return;
    dThreadingImplementationShutdownProcessing(s->threading);
    dThreadingFreeThreadPool(s->pool);
    dWorldSetStepThreadingImplementation(s->world, NULL, NULL);
    dThreadingFreeImplementation(s->threading);
}

sim *sim_open(int argc, char **argv, double h, long steps)
{
    sim *s = calloc(1, sizeof *s);
    if (!s) exit(3);
    s->argc = argc;
    s->argv = argv;
    s->h = h;
    s->steps = steps;
    s->quick = true;
    s->finite = true;
    read_options(s);
    s->timed = sim_value(s, "time", 0) > 0;
    dInitODE();
    dRandSetSeed(s->seed);
    s->world = dWorldCreate();
    dWorldSetGravity(s->world, 0, 0, -9.81);
    start_threads(s, (unsigned)sim_value(s, "threads", 0));
    s->space = dHashSpaceCreate(NULL);
    s->contacts = dJointGroupCreate(0);
    s->surface.mode = dContactApprox1;
    s->surface.mu = sim_value(s, "mu", 0.5);
    if (s->surface.mu < 0) s->surface.mu = dInfinity;
    return s;
}

dGeomID sim_ground(sim *s)
{
    return dCreatePlane(s->space, 0, 0, 1, 0);
}

void sim_pit(sim *s, double half_width)
{
    dCreatePlane(s->space, 1, 0, 0, -half_width);
    dCreatePlane(s->space, -1, 0, 0, -half_width);
    dCreatePlane(s->space, 0, 1, 0, -half_width);
    dCreatePlane(s->space, 0, -1, 0, -half_width);
}

static dBodyID place(sim *s, dGeomID geom, const dMass *mass, double px, double py, double pz)
{
    dBodyID body = dBodyCreate(s->world);
    dBodySetMass(body, mass);
    dGeomSetBody(geom, body);
    dBodySetPosition(body, px, py, pz);
    if (s->body_count < SIM_MOST_BODIES) s->bodies[s->body_count++] = body;
    return body;
}

dBodyID sim_box(sim *s, double mass, double x, double y, double z, double px, double py, double pz)
{
    dMass m;
    dMassSetBoxTotal(&m, mass, x, y, z);
    return place(s, dCreateBox(s->space, x, y, z), &m, px, py, pz);
}

dBodyID sim_sphere(sim *s, double mass, double radius, double px, double py, double pz)
{
    dMass m;
    dMassSetSphereTotal(&m, mass, radius);
    return place(s, dCreateSphere(s->space, radius), &m, px, py, pz);
}

dBodyID sim_capsule(sim *s, double mass, double radius, double length, double px, double py, double pz)
{
    dMass m;
    dMassSetCapsuleTotal(&m, mass, 3, radius, length);
    return place(s, dCreateCapsule(s->space, radius, length), &m, px, py, pz);
}

static void near(void *data, dGeomID a, dGeomID b)
{
    sim *s = data;
    if (dGeomIsSpace(a) || dGeomIsSpace(b)) {
        dSpaceCollide2(a, b, data, near);
        return;
    }
    dBodyID body1 = dGeomGetBody(a), body2 = dGeomGetBody(b);
    if (!body1 && !body2) return;
    if (body1 && body2 && dAreConnectedExcluding(body1, body2, dJointTypeContact)) return;
    static dContact found[SIM_MOST_POINTS];
    memset(found, 0, (s->collide ? SIM_MOST_POINTS : SIM_POINTS) * sizeof *found);
    int count = s->collide ? s->collide(s, a, b, found, SIM_MOST_POINTS)
                           : dCollide(a, b, SIM_POINTS, &found[0].geom, sizeof *found);
    for (int i = 0; i < count; i++) {
        found[i].surface = s->surface;
        if (s->change && !s->change(s, &found[i])) continue;
        dJointID joint = dJointCreateContact(s->world, s->contacts, &found[i]);
        dJointAttach(joint, body1, body2);
        if (s->want_feedback && s->contact_count < SIM_MOST_CONTACTS)
            dJointSetFeedback(joint, &s->feedback[s->contact_count]);
        s->contact_count++;
        s->depth_max = fmax(s->depth_max, found[i].geom.depth);
        if (s->step >= s->steps - SIM_LAST_STEPS) s->depth_last = fmax(s->depth_last, found[i].geom.depth);
    }
}

static double length(const dReal *v)
{
    return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

double sim_kinetic(const sim *s)
{
    double sum = 0;
    for (int i = 0; i < s->body_count; i++) {
        const dReal *v = dBodyGetLinearVel(s->bodies[i]);
        dVector3 w;
        dMass m;
        dBodyGetMass(s->bodies[i], &m);
        dBodyVectorFromWorld(s->bodies[i], dBodyGetAngularVel(s->bodies[i])[0], dBodyGetAngularVel(s->bodies[i])[1],
                             dBodyGetAngularVel(s->bodies[i])[2], w);
        sum += 0.5 * m.mass * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        for (int row = 0; row < 3; row++)
            for (int column = 0; column < 3; column++) sum += 0.5 * w[row] * m.I[4 * row + column] * w[column];
    }
    return sum;
}

double sim_energy(const sim *s)
{
    dVector3 g;
    dWorldGetGravity(s->world, g);
    double sum = sim_kinetic(s);
    for (int i = 0; i < s->body_count; i++) {
        const dReal *x = dBodyGetPosition(s->bodies[i]);
        dMass m;
        if (!dBodyGetGravityMode(s->bodies[i])) continue; /* its height is worth nothing */
        dBodyGetMass(s->bodies[i], &m);
        sum -= m.mass * (g[0] * x[0] + g[1] * x[1] + g[2] * x[2]);
    }
    return sum;
}

static void measure(sim *s)
{
    for (int i = 0; i < s->body_count; i++) {
        const dReal *x = dBodyGetPosition(s->bodies[i]), *q = dBodyGetQuaternion(s->bodies[i]);
        double speed = length(dBodyGetLinearVel(s->bodies[i])), spin = length(dBodyGetAngularVel(s->bodies[i]));
        s->finite = s->finite && isfinite(x[0] + x[1] + x[2]) && isfinite(q[0] + q[1] + q[2] + q[3]) &&
                    isfinite(speed) && isfinite(spin);
        s->speed_max = fmax(s->speed_max, speed);
        if (s->step < s->steps - SIM_LAST_STEPS) continue;
        s->speed_last = fmax(s->speed_last, speed);
        s->spin_last = fmax(s->spin_last, spin);
    }
    s->energy_max = fmax(s->energy_max, sim_energy(s));
}

static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void sim_step(sim *s)
{
    if (s->step == 0) s->energy_start = s->energy_max = sim_energy(s);
    if (s->each_step) s->each_step(s);
    s->contact_count = 0;
    dSpaceCollide(s->space, s, near);
    double begin = seconds();
    if (s->quick)
        dWorldQuickStep(s->world, s->h);
    else
        dWorldStep(s->world, s->h);
    s->step_time += seconds() - begin;
    dJointGroupEmpty(s->contacts);
    measure(s);
    s->step++;
}

void sim_run(sim *s)
{
    while (s->step < s->steps) sim_step(s);
}

/* FNV-1a over the bits of all positions */
static uint64_t hash(const sim *s)
{
    uint64_t h = 0xcbf29ce484222325u;
    for (int i = 0; i < s->body_count; i++) {
        unsigned char bytes[3 * sizeof(dReal)];
        memcpy(bytes, dBodyGetPosition(s->bodies[i]), sizeof bytes);
        for (size_t k = 0; k < sizeof bytes; k++) h = (h ^ bytes[k]) * 0x100000001b3u;
    }
    return h;
}

void sim_number(const char *key, double value)
{
    if (isfinite(value))
        printf(", \"%s\": %.17g", key, value);
    else
        printf(", \"%s\": null", key);
}

void sim_print(const sim *s, const char *name)
{
    printf("{\"program\": \"%s\", \"finite\": %s, \"steps\": %ld, \"hash\": \"%016llx\"", name,
           s->finite ? "true" : "false", s->step, (unsigned long long)hash(s));
    sim_number("speed_last", s->speed_last);
    sim_number("speed_max", s->speed_max);
    sim_number("spin_last", s->spin_last);
    sim_number("kinetic", sim_kinetic(s));
    sim_number("depth_last", s->depth_last);
    sim_number("depth_max", s->depth_max);
    sim_number("energy_start", s->energy_start);
    sim_number("energy_max", s->energy_max);
    sim_number("energy_end", sim_energy(s));
    if (s->timed) sim_number("step_time", s->step_time);
}

int sim_close(sim *s)
{
    puts("}");
    end_threads(s);
    dJointGroupDestroy(s->contacts);
    dSpaceDestroy(s->space);
    dWorldDestroy(s->world);
    dCloseODE();
    bool finite = s->finite;
    free(s);
    return finite ? 0 : 1;
}
