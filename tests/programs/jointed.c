/*
 * A random world of joints, one for each --seed: trees with loops, of 2 to 40 bodies and all kinds of joints, with
 * motors, stops, joints said twice, and joints that contradict each other.
 *
 * --loops X and --doubled X are the shares of bodies that close a loop and of joints that are said twice (default 0.2
 * each); --contradict X the share of these whose second joint wants another pose (default 0); --motors X and --stops X
 * the shares of joints that have them (default 0.3); --ground 0 takes the ground away; --bodies N is their number.
 * --rare X is the share of joints of the kinds that are rare in programs (default 0). --jam 1 has bodies begin in each
 * other and in the ground; --gravity 0 takes gravity away; --velocity X and --force X multiply what motors want and may
 * use (default 1; motors that want 0 are brakes). --wheel I > 0 ties a flywheel of this inertia (kg m^2) to the first
 * body, which turns at --spin rad/s (default 0) and has a motor that turns it back at 1 rad/s by at most --torque N m
 * (default 1). kinetic_max is the most kinetic energy (J) without the wheel.
 */
#include "sim.h"

#include <math.h>
#include <stdint.h>

enum { MOST_BODIES = 40 };

/* A generator of its own: quickstep draws from ODE's. */
typedef struct world_maker {
    sim *s;
    uint64_t state;
    dBodyID body[MOST_BODIES];
    int count;
    double loops, doubled, contradict, motors, stops, rare, velocity, force;
    bool jam;
} world_maker;

static double kinetic_max; /* J */

static void look(sim *s)
{
    kinetic_max = fmax(kinetic_max, sim_kinetic(s));
}

static double draw(world_maker *m, double low, double high)
{
    m->state ^= m->state << 13;
    m->state ^= m->state >> 7;
    m->state ^= m->state << 17;
    return low + (high - low) * (double)(m->state >> 11) / 9007199254740992.0;
}

static void draw_axis(world_maker *m, double axis[3])
{
    double size2;
    do {
        for (int i = 0; i < 3; i++) axis[i] = draw(m, -1, 1);
        size2 = axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2];
    } while (size2 > 1 || size2 < 0.01);
    for (int i = 0; i < 3; i++) axis[i] /= sqrt(size2);
}

static void draw_perpendicular(world_maker *m, const double *axis, double *to)
{
    double other[3], size = 0;
    while (size < 0.1) {
        draw_axis(m, other);
        for (int i = 0; i < 3; i++)
            to[i] = axis[(i + 1) % 3] * other[(i + 2) % 3] - axis[(i + 2) % 3] * other[(i + 1) % 3];
        size = sqrt(to[0] * to[0] + to[1] * to[1] + to[2] * to[2]);
    }
    for (int i = 0; i < 3; i++) to[i] /= size;
}

typedef void parameter_setter(dJointID joint, int parameter, dReal value);

/* Motors and stops of one of a joint's axes; turns: an angle, else a length. */
static void drive(world_maker *m, dJointID joint, parameter_setter *set, int group, bool turns)
{
    if (draw(m, 0, 1) < m->stops) {
        double range = turns ? 1 : 0.1;
        set(joint, dParamLoStop + group, draw(m, -range, -0.05 * range));
        set(joint, dParamHiStop + group, draw(m, 0.05 * range, range));
        if (draw(m, 0, 1) < 0.3) set(joint, dParamBounce + group, draw(m, 0, 1));
    }
    if (draw(m, 0, 1) < m->motors) {
        set(joint, dParamVel + group, m->velocity * draw(m, -2, 2) * (turns ? 1 : 0.1));
        set(joint, dParamFMax + group, m->force * pow(10, draw(m, -2, turns ? 0.5 : 1.5)));
    }
}

/* A joint with two kinds of motion: a slider that turns, or a rod between two places. */
static void join_two_ways(world_maker *m, dBodyID a, dBodyID b, const double *place, int kind)
{
    dWorldID world = m->s->world;
    double axis[3], second[3];
    dJointID joint;
    draw_axis(m, axis);
    draw_perpendicular(m, axis, second);
    if (kind == 0) {
        joint = dJointCreatePR(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetPRAnchor(joint, place[0], place[1], place[2]);
        dJointSetPRAxis1(joint, axis[0], axis[1], axis[2]);
        dJointSetPRAxis2(joint, second[0], second[1], second[2]);
        drive(m, joint, dJointSetPRParam, 0, false);
    } else if (kind == 1) {
        joint = dJointCreatePU(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetPUAxis1(joint, axis[0], axis[1], axis[2]);
        dJointSetPUAxis2(joint, second[0], second[1], second[2]);
        dJointSetPUAxis3(joint, axis[0], axis[1], axis[2]);
        dJointSetPUAnchor(joint, place[0], place[1], place[2]);
        drive(m, joint, dJointSetPUParam, 0, true);
    } else if (kind == 2) {
        joint = dJointCreatePiston(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetPistonAnchor(joint, place[0], place[1], place[2]);
        dJointSetPistonAxis(joint, axis[0], axis[1], axis[2]);
        drive(m, joint, dJointSetPistonParam, 0, false);
    } else if (kind == 3) {
        joint = dJointCreateDBall(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetDBallAnchor1(joint, place[0], place[1], place[2]);
        dJointSetDBallAnchor2(joint, place[0] + 0.1 * axis[0], place[1] + 0.1 * axis[1], place[2] + 0.1 * axis[2]);
    } else {
        joint = dJointCreateDHinge(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetDHingeAxis(joint, axis[0], axis[1], axis[2]);
        dJointSetDHingeAnchor1(joint, place[0], place[1], place[2]);
        dJointSetDHingeAnchor2(joint, place[0] + 0.1 * second[0], place[1] + 0.1 * second[1],
                               place[2] + 0.1 * second[2]);
    }
}

/* A joint of a kind that is rare in programs: two motions, or motors, alone or beside a ball. */
static void join_rare(world_maker *m, dBodyID a, dBodyID b, const double *place)
{
    dWorldID world = m->s->world;
    int kind = (int)draw(m, 0, 8);
    double axis[3], second[3];
    dJointID joint;
    if (kind < 5) {
        join_two_ways(m, a, b, place, kind);
        return;
    }
    draw_axis(m, axis);
    draw_perpendicular(m, axis, second);
    if (kind == 7) {
        joint = dJointCreateLMotor(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetLMotorNumAxes(joint, 2);
        dJointSetLMotorAxis(joint, 0, b ? 1 : 0, axis[0], axis[1], axis[2]);
        dJointSetLMotorAxis(joint, 1, 0, second[0], second[1], second[2]);
        for (int i = 0; i < 2; i++) {
            dJointSetLMotorParam(joint, dParamVel + i * dParamGroup, m->velocity * draw(m, -0.2, 0.2));
            dJointSetLMotorParam(joint, dParamFMax + i * dParamGroup, pow(10, draw(m, -2, 1.5)));
        }
        return;
    }
    joint = dJointCreateBall(world, NULL);
    dJointAttach(joint, a, b);
    dJointSetBallAnchor(joint, place[0], place[1], place[2]);
    joint = dJointCreateAMotor(world, NULL);
    dJointAttach(joint, a, b);
    dJointSetAMotorMode(joint, kind == 5 && b ? dAMotorEuler : dAMotorUser);
    if (kind != 5 || !b) dJointSetAMotorNumAxes(joint, 2);
    dJointSetAMotorAxis(joint, 0, b ? 1 : 0, axis[0], axis[1], axis[2]);
    dJointSetAMotorAxis(joint, kind == 5 && b ? 2 : 1, kind == 5 && b ? 2 : 0, second[0], second[1], second[2]);
    for (int i = 0; i < 2; i++) {
        dJointSetAMotorParam(joint, dParamVel + i * dParamGroup, m->velocity * draw(m, -2, 2));
        dJointSetAMotorParam(joint, dParamFMax + i * dParamGroup, pow(10, draw(m, -2, 0.5)));
    }
}

/* A joint of some kind between two bodies (b NULL: the world) at a place, in the pose they have. */
static void join(world_maker *m, dBodyID a, dBodyID b, const double *place)
{
    dWorldID world = m->s->world;
    double axis[3], second[3];
    if (m->rare > 0 && draw(m, 0, 1) < m->rare) {
        join_rare(m, a, b, place);
        return;
    }
    draw_axis(m, axis);
    draw_perpendicular(m, axis, second);
    int kind = (int)draw(m, 0, 7);
    dJointID joint;
    switch (kind) {
    case 0:
        joint = dJointCreateBall(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetBallAnchor(joint, place[0], place[1], place[2]);
        break;
    case 1:
    case 2:
        joint = dJointCreateHinge(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetHingeAnchor(joint, place[0], place[1], place[2]);
        dJointSetHingeAxis(joint, axis[0], axis[1], axis[2]);
        drive(m, joint, dJointSetHingeParam, 0, true);
        break;
    case 3:
        joint = dJointCreateSlider(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetSliderAxis(joint, axis[0], axis[1], axis[2]);
        dJointSetSliderParam(joint, dParamLoStop, -0.2);
        dJointSetSliderParam(joint, dParamHiStop, 0.2);
        drive(m, joint, dJointSetSliderParam, 0, false);
        break;
    case 4:
        joint = dJointCreateUniversal(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetUniversalAnchor(joint, place[0], place[1], place[2]);
        dJointSetUniversalAxis1(joint, axis[0], axis[1], axis[2]);
        dJointSetUniversalAxis2(joint, second[0], second[1], second[2]);
        drive(m, joint, dJointSetUniversalParam, 0, true);
        drive(m, joint, dJointSetUniversalParam, dParamGroup2, true);
        break;
    case 5:
        if (!b) return; /* ODE's hinge-2 needs two bodies */
        joint = dJointCreateHinge2(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetHinge2Anchor(joint, place[0], place[1], place[2]);
        dJointSetHinge2Axes(joint, axis, second);
        drive(m, joint, dJointSetHinge2Param, 0, true);
        break;
    default:
        joint = dJointCreateFixed(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetFixed(joint);
        break;
    }
    if (draw(m, 0, 1) >= m->doubled) return;
    double again[3] = {place[0], place[1], place[2]};
    bool other = draw(m, 0, 1) < m->contradict;
    for (int i = 0; i < 3 && other; i++) again[i] += draw(m, -0.02, 0.02);
    const dReal *x = dBodyGetPosition(a);
    dVector3 kept = {x[0], x[1], x[2]};
    if (other) dBodySetPosition(a, x[0] + again[0] - place[0], x[1] + again[1] - place[1], x[2] + again[2] - place[2]);
    if (kind == 0 || kind == 4 || kind == 5) {
        joint = dJointCreateBall(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetBallAnchor(joint, again[0], again[1], again[2]);
    } else if (kind < 3) {
        joint = dJointCreateHinge(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetHingeAnchor(joint, again[0], again[1], again[2]);
        dJointSetHingeAxis(joint, axis[0], axis[1], axis[2]);
    } else if (kind > 5) {
        joint = dJointCreateFixed(world, NULL);
        dJointAttach(joint, a, b);
        dJointSetFixed(joint);
    }
    if (other) dBodySetPosition(a, kept[0], kept[1], kept[2]);
}

static dBodyID make_body(world_maker *m, const double *at)
{
    double mass = pow(10, draw(m, -1.3, 0.3)), kind = draw(m, 0, 3);
    if (kind < 1) {
        double z = draw(m, 0.03, 0.1), y = draw(m, 0.03, 0.1), x = draw(m, 0.03, 0.1);
        return sim_box(m->s, mass, x, y, z, at[0], at[1], at[2]);
    }
    if (kind < 2) return sim_sphere(m->s, mass, draw(m, 0.02, 0.06), at[0], at[1], at[2]);
    double length = draw(m, 0.03, 0.08), radius = draw(m, 0.015, 0.03);
    return sim_capsule(m->s, mass, radius, length, at[0], at[1], at[2]);
}

static void middle_of(dBodyID a, dBodyID b, double *place)
{
    for (int i = 0; i < 3; i++) place[i] = 0.5 * (dBodyGetPosition(a)[i] + dBodyGetPosition(b)[i]);
}

/* A place beside a body, apart from all others and from the ground, but in a jam. */
static void find_room(world_maker *m, dBodyID parent, double *at)
{
    const double apart = m->jam ? 0.05 : 0.15, far = m->jam ? 0.1 : 0.2, low = m->jam ? -0.1 : 0.3;
    bool free = false;
    for (int try = 0; try < 100 && !free; try++) {
        double way[3];
        draw_axis(m, way);
        for (int i = 0; i < 3; i++) at[i] = dBodyGetPosition(parent)[i] + far * way[i];
        free = at[2] > low;
        for (int k = 0; k < m->count && free; k++) {
            const dReal *x = dBodyGetPosition(m->body[k]);
            free = hypot(hypot(x[0] - at[0], x[1] - at[1]), x[2] - at[2]) > apart;
        }
    }
}

static void make_world(world_maker *m, int bodies, bool hung)
{
    for (int k = 0; k < bodies; k++) {
        double at[3] = {0, 0, m->jam ? 0 : 1.5}, place[3];
        int parent = k ? (int)draw(m, k > 4 ? k - 4 : 0, k) : -1;
        if (parent >= 0) find_room(m, m->body[parent], at);
        dBodyID body = m->body[m->count++] = make_body(m, at);
        if (parent >= 0) {
            middle_of(body, m->body[parent], place);
            join(m, body, m->body[parent], place);
        } else if (hung) {
            join(m, body, NULL, at);
        }
        if (k < 2 || draw(m, 0, 1) >= m->loops) continue;
        int other = (int)draw(m, -1, k);
        if (other == parent) continue;
        if (other < 0) {
            join(m, body, NULL, at);
        } else {
            middle_of(body, m->body[other], place);
            join(m, body, m->body[other], place);
        }
    }
}

static void tie_flywheel(sim *s, dBodyID to, double inertia)
{
    const dReal *at = dBodyGetPosition(to);
    dBodyID wheel = dBodyCreate(s->world);
    dMass mass;
    dMassSetSphereTotal(&mass, 1, 0.05);
    for (int i = 0; i < 3; i++) mass.I[5 * i] = inertia;
    dBodySetMass(wheel, &mass);
    dBodySetPosition(wheel, at[0], at[1], at[2]);
    dBodySetGyroscopicMode(wheel, 0);
    dJointID hinge = dJointCreateHinge(s->world, NULL);
    dJointAttach(hinge, wheel, NULL);
    dJointSetHingeAnchor(hinge, at[0], at[1], at[2]);
    dJointSetHingeAxis(hinge, 0, 1, 0);
    dJointSetHingeParam(hinge, dParamFMax, sim_value(s, "torque", 1));
    dJointSetHingeParam(hinge, dParamVel, -1);
    dJointID ball = dJointCreateBall(s->world, NULL);
    dJointAttach(ball, wheel, to);
    dJointSetBallAnchor(ball, at[0], at[1], at[2]);
    dBodySetAngularVel(wheel, 0, sim_value(s, "spin", 0), 0);
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 400);
    world_maker m = {.s = s, .state = 0x9e3779b97f4a7c15u * (s->seed + 1)};
    for (int i = 0; i < 8; i++) (void)draw(&m, 0, 1);
    m.loops = sim_value(s, "loops", 0.2);
    m.doubled = sim_value(s, "doubled", 0.2);
    m.contradict = sim_value(s, "contradict", 0);
    m.motors = sim_value(s, "motors", 0.3);
    m.stops = sim_value(s, "stops", 0.3);
    m.rare = sim_value(s, "rare", 0);
    m.velocity = sim_value(s, "velocity", 1);
    m.force = sim_value(s, "force", 1);
    m.jam = sim_value(s, "jam", 0) > 0;
    if (sim_value(s, "gravity", 1) == 0) dWorldSetGravity(s->world, 0, 0, 0);
    int bodies = (int)sim_value(s, "bodies", floor(draw(&m, 2, 1 + MOST_BODIES)));
    if (sim_value(s, "ground", 1) > 0) sim_ground(s);
    make_world(&m, bodies < MOST_BODIES ? bodies : MOST_BODIES, draw(&m, 0, 1) < 0.5);
    double inertia = sim_value(s, "wheel", 0);
    if (inertia > 0) tie_flywheel(s, m.body[0], inertia);
    s->each_step = look;
    sim_run(s);
    sim_print(s, "jointed");
    sim_number("kinetic_max", kinetic_max);
    sim_number("bodies", m.count);
    return sim_close(s);
}
