/*
 * Pads of 20 mm are pressed half a millimetre into cubes of 100 mm, --pads of them, each pair turned another way. A pad
 * tilts about one of its edges, which is parallel to one of the cube's, by 1e-3 rad in each step of --h. Prints how
 * many steps of pads had no contact, and how many one contact alone.
 */
#include "sim.h"

#include <math.h>
#include <stdlib.h>

enum { MOST_PADS = 100 };
static const double CUBE = 0.1, PAD = 0.02, THICK = 0.01, DEPTH = 0.0005, APART = 1, TILT = 1e-3;

static int pads;
static long lost, single;

static double uniform(void)
{
    return 2.0 * rand() / RAND_MAX - 1;
}

static int collide(sim *s, dGeomID a, dGeomID b, dContact *found, int room)
{
    (void)s;
    int count = dCollide(a, b, room, &found[0].geom, sizeof found[0]);
    lost += count == 0;
    single += count == 1;
    return count;
}

/* The cube of a pair lies at its place, and can move; the pad is moved by its owner. */
static void add_pair(sim *s, int pair)
{
    dQuaternion turn;
    dVector3 beside;
    do
        for (int i = 0; i < 4; i++) turn[i] = uniform();
    while (turn[0] * turn[0] + turn[1] * turn[1] + turn[2] * turn[2] + turn[3] * turn[3] < 0.1);
    dNormalize4(turn);
    dBodyID cube = sim_box(s, 1e12, CUBE, CUBE, CUBE, APART * pair, 0, 0), pad = dBodyCreate(s->world);
    dBodySetQuaternion(cube, turn);
    dBodySetKinematic(pad);
    dGeomSetBody(dCreateBox(s->space, THICK, PAD, PAD), pad);
    dBodyGetRelPointPos(cube, -0.5 * CUBE - 0.5 * THICK + DEPTH, 0, 0, beside);
    dBodySetPosition(pad, beside[0], beside[1], beside[2]);
    dBodySetQuaternion(pad, turn);
    dVector3 axis;
    dBodyVectorToWorld(cube, 0, TILT / s->h, 0, axis);
    dBodySetAngularVel(pad, axis[0], axis[1], axis[2]);
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.001, 100);
    srand((unsigned)s->seed);
    pads = (int)sim_value(s, "pads", 100);
    if (pads > MOST_PADS) pads = MOST_PADS;
    dWorldSetGravity(s->world, 0, 0, 0);
    s->collide = collide;
    s->surface.mode |= dContactSoftERP | dContactSoftCFM; /* a spring of 1e4 N/m, which moves no cube */
    s->surface.soft_erp = 0.5;
    s->surface.soft_cfm = 0.5 / (s->h * 1e4);
    for (int i = 0; i < pads; i++) add_pair(s, i);
    sim_run(s);
    sim_print(s, "tilted");
    sim_number("lost", (double)lost);
    sim_number("single", (double)single);
    return sim_close(s);
}
