/* A box whose faces are lattices of --rows by --rows vertices stands on the ground: each vertex below it is a contact,
 * hundreds of one pair. --soft CFM makes each a spring, --limit N gives each that much friction, --push N pushes the
 * box. Prints how far it tilts and moves. */
#include "sim.h"

#include <math.h>

static const double HALF = 0.5;
static int rows;
static double push;

static void each_step(sim *s)
{
    dBodyAddForceAtPos(s->bodies[0], push, 0, 0, 0, 0, 0); /* at the ground: it tilts nothing */
}

/* The lattice points of the box's surface that are below the ground, in the order of the lattice. */
static int collide(sim *s, dGeomID a, dGeomID b, dContact *found, int room)
{
    bool swapped = dGeomGetClass(a) == dPlaneClass;
    dGeomID box = swapped ? b : a, plane = swapped ? a : b;
    int count = 0;
    (void)s;
    if (dGeomGetClass(box) != dBoxClass || dGeomGetClass(plane) != dPlaneClass) return 0;
    for (int i = 0; i < rows * rows * rows && count < room; i++) {
        int at[3] = {i % rows, i / rows % rows, i / (rows * rows)};
        bool inside = true;
        double x[3];
        for (int k = 0; k < 3; k++) {
            inside = inside && at[k] > 0 && at[k] < rows - 1;
            x[k] = HALF * (2.0 * at[k] / (rows - 1) - 1);
        }
        if (inside) continue;
        dVector3 place;
        dBodyGetRelPointPos(dGeomGetBody(box), x[0], x[1], x[2], place);
        if (place[2] >= 0) continue;
        dContactGeom *g = &found[count++].geom;
        for (int k = 0; k < 3; k++) {
            g->pos[k] = place[k];
            g->normal[k] = 0;
        }
        g->normal[2] = swapped ? -1 : 1;
        g->depth = -place[2];
        g->g1 = a;
        g->g2 = b;
    }
    return count;
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 2000);
    rows = (int)sim_value(s, "rows", 18);
    if (sim_value(s, "soft", 0) > 0) {
        s->surface.mode |= dContactSoftERP | dContactSoftCFM;
        s->surface.soft_erp = 0.2;
        s->surface.soft_cfm = sim_value(s, "soft", 0);
    }
    if (sim_value(s, "limit", 0) > 0) {
        s->surface.mode &= ~dContactApprox1;
        s->surface.mu = sim_value(s, "limit", 0);
    }
    push = sim_value(s, "push", 0);
    s->collide = collide;
    s->each_step = each_step;
    sim_ground(s);
    dBodyID box = sim_box(s, 1, 2 * HALF, 2 * HALF, 2 * HALF, 0, 0, HALF - 1e-4);
    sim_run(s);
    const dReal *x = dBodyGetPosition(box), *R = dBodyGetRotation(box);
    sim_print(s, "tessellated");
    sim_number("tilt", atan2(hypot(R[2], R[6]), R[10]));
    sim_number("drift", hypot(x[0], x[1]));
    sim_number("height", x[2]);
    return sim_close(s);
}
