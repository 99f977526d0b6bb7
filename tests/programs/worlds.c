/*
 * A random world of free bodies: boxes, spheres, capsules, cylinders, meshes and pieces put together, some of them
 * kinematic, disabled or tied by a joint, on a ground of several kinds. Every contact has a random surface. Some worlds
 * leave the contacts' geoms unset, or have nonsense there; some have up to --points contacts for a pair; in some,
 * bodies are destroyed and made while they run. With --hold 1 the program takes what they leave in memory, so that
 * those made later lie elsewhere.
 */
#include "sim.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 40, SURFACES = 8 };

typedef enum shape { BOX, SPHERE, CAPSULE, CYLINDER, MESH, PIECES, SHAPES } shape;
typedef enum names { GEOMS, NONE, NONSENSE, SWAPPED, NAMES } names;

typedef struct maker {
    sim *s;
    uint64_t state;
    dSurfaceParameters surface[SURFACES];
    names names;
    int points;       /* contacts of a pair, at most; 0: as they are found */
    double turnover;  /* the share of steps in which a body goes or comes */
    double half_room; /* m */
    bool hold;
    struct held *held;
} maker;

/* Memory that is held until the end. */
typedef struct held {
    struct held *next;
} held;

static maker m;
static dTriMeshDataID tetrahedron;

/* The high bits of a linear congruential generator (Knuth's MMIX). */
static double draw(double low, double high)
{
    m.state = m.state * 6364136223846793005u + 1442695040888963407u;
    return low + (high - low) * (double)(m.state >> 11) * 0x1p-53;
}

static bool chance(double share)
{
    return draw(0, 1) < share;
}

/* ---- surfaces ---- */

static void draw_surface(dSurfaceParameters *p)
{
    memset(p, 0, sizeof *p);
    p->mu = chance(0.1) ? 0 : chance(0.1) ? dInfinity : draw(0.05, 1.5);
    if (chance(0.7)) p->mode |= dContactApprox1;
    if (chance(0.2)) p->mode |= dContactMu2, p->mu2 = draw(0, 1);
    if (chance(0.3)) p->mode |= dContactBounce, p->bounce = draw(0, 0.9), p->bounce_vel = draw(0, 0.5);
    if (chance(0.3)) p->mode |= dContactSoftERP, p->soft_erp = draw(0, 0.9);
    if (chance(0.3)) p->mode |= dContactSoftCFM, p->soft_cfm = pow(10, draw(-10, -2));
    if (chance(0.15)) p->mode |= dContactSlip1, p->slip1 = pow(10, draw(-5, -1));
    if (chance(0.15)) p->mode |= dContactSlip2, p->slip2 = pow(10, draw(-5, -1));
    if (chance(0.1)) p->mode |= dContactMotion1, p->motion1 = draw(-0.5, 0.5);
    if (chance(0.05)) p->mode |= dContactMotionN, p->motionN = draw(-0.05, 0.05);
    if (chance(0.1)) p->mode |= dContactRolling, p->rho = p->rho2 = draw(0, 0.02), p->rhoN = draw(0, 0.01);
}

/* A surface for each pair, the same in every step. */
static const dSurfaceParameters *surface_of(const dContactGeom *g)
{
    double mixed = 0;
    for (int side = 0; side < 2; side++) {
        dBodyID body = dGeomGetBody(side ? g->g2 : g->g1);
        dMass mass;
        if (!body) continue;
        dBodyGetMass(body, &mass);
        mixed += mass.mass;
    }
    return &m.surface[(int)(fmod(mixed, 1) * SURFACES)];
}

static bool change(sim *s, dContact *contact)
{
    (void)s;
    contact->surface = *surface_of(&contact->geom);
    if (contact->surface.mode & dContactMotion1) {
        contact->surface.mode |= dContactFDir1;
        contact->fdir1[0] = 1;
    }
    dGeomID first = contact->geom.g1;
    if (m.names == SWAPPED) contact->geom.g1 = contact->geom.g2, contact->geom.g2 = first;
    if (m.names == NONE) contact->geom.g1 = contact->geom.g2 = NULL;
    if (m.names == NONSENSE) memset(&contact->geom.g1, 0xA7, sizeof first), contact->geom.g2 = first;
    return true;
}

/* Between those that are found, contacts are put on the lines from one to the next. */
static int collide(sim *s, dGeomID a, dGeomID b, dContact *found, int room)
{
    (void)s;
    int count = dCollide(a, b, room < 64 ? room : 64, &found[0].geom, sizeof *found), more = count;
    for (int i = 0; count > 1 && more < m.points && more < room; i++, more++) {
        const dContactGeom *from = &found[i % count].geom, *to = &found[(i + 1) % count].geom;
        double t = fmod(0.618 * (1 + i / count), 1);
        found[more] = found[i % count];
        for (int k = 0; k < 3; k++) found[more].geom.pos[k] += t * (to->pos[k] - from->pos[k]);
        found[more].geom.depth += t * (to->depth - from->depth);
    }
    return more;
}

/* ---- bodies ---- */

static void add_piece(dBodyID body, double size)
{
    dGeomID geom = dCreateBox(m.s->space, size, 0.5 * size, 0.5 * size);
    dGeomSetBody(geom, body);
    dGeomSetOffsetPosition(geom, 0, 0.5 * size, draw(-0.5, 0.5) * size);
}

static dBodyID make_mesh(double mass, double size, const double *at)
{
    dBodyID body = sim_sphere(m.s, mass, 0.3 * size, at[0], at[1], at[2]);
    dGeomDestroy(dBodyGetFirstGeom(body));
    dGeomSetBody(dCreateTriMesh(m.s->space, tetrahedron, NULL, NULL, NULL), body);
    return body;
}

static dBodyID make_cylinder(double mass, double radius, double length, const double *at)
{
    dBodyID body = sim_capsule(m.s, mass, radius, length, at[0], at[1], at[2]);
    dGeomDestroy(dBodyGetFirstGeom(body));
    dGeomSetBody(dCreateCylinder(m.s->space, radius, length), body);
    return body;
}

static dBodyID make_shape(double mass, double size, const double *at)
{
    shape kind = (shape)draw(0, SHAPES);
    dBodyID body;
    double height, depth;
    switch (kind) {
    case SPHERE:
        return sim_sphere(m.s, mass, 0.5 * size, at[0], at[1], at[2]);
    case CAPSULE:
        return sim_capsule(m.s, mass, 0.25 * size, 0.6 * size, at[0], at[1], at[2]);
    case CYLINDER:
        return make_cylinder(mass, 0.35 * size, 0.6 * size, at);
    case MESH:
        return make_mesh(mass, size, at);
    default:
        height = draw(0.4, 1) * size;
        depth = draw(0.4, 1) * size;
        body = sim_box(m.s, mass, size, depth, height, at[0], at[1], at[2]);
        if (kind == PIECES) add_piece(body, size);
        return body;
    }
}

/* The arguments of a call would be drawn in an order that the compiler chooses. Draws z first. */
static void draw_three(double low, double high, double *x)
{
    for (int i = 2; i >= 0; i--) x[i] = draw(low, high);
}

static dBodyID make_body(void)
{
    double at[3], axis[3], v[3], w[3];
    for (int i = 0; i < 2; i++) at[i] = draw(-0.7, 0.7) * m.half_room;
    at[2] = draw(0.1, 1.5);
    double size = draw(0.08, 0.3), mass = pow(10, draw(-1.5, 1));
    dBodyID body = make_shape(mass, size, at);
    dMatrix3 R;
    double angle = draw(0, 3);
    draw_three(-1, 1, axis);
    dRFromAxisAndAngle(R, axis[0], axis[1], axis[2] + 1.1, angle);
    dBodySetRotation(body, R);
    v[2] = draw(-2, 1);
    v[1] = draw(-1, 1);
    v[0] = draw(-1, 1);
    draw_three(-3, 3, w);
    dBodySetLinearVel(body, v[0], v[1], v[2]);
    dBodySetAngularVel(body, w[0], w[1], w[2]);
    if (chance(0.1)) dBodyDisable(body);
    if (chance(0.05)) dBodySetGravityMode(body, 0);
    if (chance(0.2)) dBodySetAutoDisableFlag(body, 1);
    if (chance(0.1)) dBodySetLinearDamping(body, 0.01);
    if (chance(0.1)) dBodySetGyroscopicMode(body, 0);
    return body;
}

/* Takes blocks of all the sizes that bodies and geoms may have. */
static void hold_memory(void)
{
    for (size_t size = 16; size <= 2048 && m.hold; size += 16) {
        held *block = malloc(size);
        if (!block) exit(3);
        block->next = m.held;
        m.held = block;
    }
}

static void free_held(void)
{
    while (m.held) {
        held *next = m.held->next;
        free(m.held);
        m.held = next;
    }
}

/* Its geoms go with it, or stay where they are and belong to the world. */
static void destroy_body(int k)
{
    dBodyID body = m.s->bodies[k];
    bool keeps_geoms = chance(0.2);
    while (!keeps_geoms && dBodyGetFirstGeom(body)) dGeomDestroy(dBodyGetFirstGeom(body));
    dBodyDestroy(body);
    m.s->bodies[k] = m.s->bodies[--m.s->body_count];
    hold_memory();
}

static void join(dBodyID a, dBodyID b)
{
    const dReal *x = dBodyGetPosition(a);
    dWorldID world = m.s->world;
    dJointID joint = chance(0.5) ? dJointCreateBall(world, NULL) : dJointCreateHinge(world, NULL);
    dJointAttach(joint, a, b);
    if (dJointGetType(joint) == dJointTypeBall) {
        dJointSetBallAnchor(joint, x[0], x[1], x[2] + 0.1);
        return;
    }
    dJointSetHingeAnchor(joint, x[0], x[1], x[2] + 0.1);
    double axis_y = draw(-1, 1);
    dJointSetHingeAxis(joint, draw(-1, 1), axis_y, 1.1);
    if (chance(0.5)) dJointSetHingeParam(joint, dParamFMax, draw(0, 1));
    if (chance(0.5)) dJointSetHingeParam(joint, dParamLoStop, -0.5), dJointSetHingeParam(joint, dParamHiStop, 0.5);
}

/* A slab that moves to and fro, and is not measured. */
static dBodyID mover;

static void make_mover(void)
{
    mover = dBodyCreate(m.s->world);
    dBodySetKinematic(mover);
    dGeomSetBody(dCreateBox(m.s->space, 0.6, 0.6, 0.2), mover);
    dBodySetPosition(mover, 0, 0, 0.1);
}

static void each_step(sim *s)
{
    if (mover) dBodySetLinearVel(mover, 0.3 * cos(3 * (double)s->step * s->h), 0, 0);
    if (!chance(m.turnover)) return;
    if (s->body_count > 1 && chance(0.5))
        destroy_body((int)draw(0, s->body_count));
    else if (s->body_count < 2 * MOST)
        (void)make_body();
}

/* ---- the world ---- */

static void make_tetrahedron(void)
{
    static const double corner[4][3] = {{0.1, 0.1, 0.1}, {-0.1, -0.1, 0.1}, {-0.1, 0.1, -0.1}, {0.1, -0.1, -0.1}};
    static const dTriIndex face[12] = {0, 1, 3, 0, 3, 2, 0, 2, 1, 1, 2, 3};
    tetrahedron = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildDouble(tetrahedron, corner, sizeof *corner, 4, face, 12, 3 * sizeof *face);
}

static void make_ground(void)
{
    sim_ground(m.s);
    m.half_room = draw(0.4, 1.5);
    if (chance(0.5)) sim_pit(m.s, m.half_room);
    for (int k = 0; k < 3 && chance(0.3); k++) {
        double y = draw(-0.5, 0.5);
        dGeomSetPosition(dCreateBox(m.s->space, 0.4, 0.4, 0.1), draw(-0.5, 0.5), y, 0.03);
    }
    if (chance(0.2)) make_mover();
}

int main(int argc, char **argv)
{
    sim *s = m.s = sim_open(argc, argv, 0.005, 300);
    m.state = 0x9e3779b97f4a7c15u * (s->seed + 1);
    for (int i = 0; i < 8; i++) (void)draw(0, 1);
    for (int k = 0; k < SURFACES; k++) draw_surface(&m.surface[k]);
    m.names = chance(0.4) ? GEOMS : (names)draw(0, NAMES);
    m.points = (int)sim_value(s, "points", chance(0.2) ? floor(pow(300, draw(0, 1))) : 0);
    m.turnover = sim_value(s, "turnover", chance(0.3) ? 0.1 : 0);
    m.hold = sim_value(s, "hold", 0) > 0;
    s->want_feedback = chance(0.2);
    s->collide = collide;
    s->change = change;
    s->each_step = each_step;
    if (chance(0.2)) dWorldSetAutoDisableFlag(s->world, 1);
    if (chance(0.2)) dWorldSetCFM(s->world, pow(10, draw(-10, -3)));
    if (chance(0.2)) dWorldSetERP(s->world, draw(0.05, 0.8));
    if (chance(0.2)) dWorldSetContactMaxCorrectingVel(s->world, draw(0.05, 2));
    if (chance(0.2)) dWorldSetContactSurfaceLayer(s->world, 0.001);
    make_tetrahedron();
    make_ground();
    int bodies = (int)sim_value(s, "bodies", floor(pow(MOST, draw(0, 1))));
    int few = 1 + 200 / (1 + m.points); /* ODE's direct method takes minutes for thousands of contacts */
    if (!s->quick && bodies > few && m.points > 0) bodies = few;
    for (int k = 0; k < bodies && k < MOST; k++) (void)make_body();
    bool joints = chance(0.3);
    for (int k = 1; k < s->body_count && joints; k++)
        if (chance(0.4)) join(s->bodies[k], chance(0.9) ? s->bodies[k - 1] : NULL);
    sim_run(s);
    sim_print(s, "worlds");
    sim_number("bodies", s->body_count);
    int status = sim_close(s);
    dGeomTriMeshDataDestroy(tetrahedron);
    free_held();
    return status;
}
