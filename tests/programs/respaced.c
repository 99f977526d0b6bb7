/*
 * A box rests on the ground. A geom is then taken from an inner space, which other geoms are in, and added to the outer
 * one. --kind 0 to 3: both are simple, hash, sweep and prune or quadtree spaces; --what 0 to 4: the geom is that of a
 * second box on the first, or, far below the ground, a static box, a plane, a height field without a place, or a space.
 * Prints how high the upper box was above the ground then, and how high a ball that fell beside them afterwards.
 */
#include "sim.h"

static dSpaceID make_space(int kind, dSpaceID in)
{
    const dVector3 centre = {0, 0, 0, 0}, extents = {10, 10, 10, 0};
    return kind == 0   ? dSimpleSpaceCreate(in)
           : kind == 1 ? dHashSpaceCreate(in)
           : kind == 2 ? dSweepAndPruneSpaceCreate(in, dSAP_AXES_XYZ)
                       : dQuadTreeSpaceCreate(in, centre, extents, 4);
}

static dReal height(void *user, int x, int z)
{
    (void)user, (void)x, (void)z;
    return -9;
}

static dGeomID make_geom(dSpaceID in, int what, dBodyID box, dHeightfieldDataID heights)
{
    dGeomID geom = what == 0   ? dBodyGetFirstGeom(box)
                   : what == 1 ? dCreateBox(NULL, 1, 1, 1)
                   : what == 2 ? dCreatePlane(NULL, 0.6, 0, 0.8, -9)
                   : what == 3 ? dCreateHeightfield(NULL, heights, 0)
                               : (dGeomID)dHashSpaceCreate(NULL);
    if (what == 0) dSpaceRemove(dGeomGetSpace(geom), geom);
    if (what == 1) dGeomSetPosition(geom, 0, 0, -9);
    dSpaceAdd(in, geom);
    return geom;
}

static void run(sim *s, long steps)
{
    for (long i = 0; i < steps; i++) sim_step(s);
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.01, 0);
    int kind = (int)sim_value(s, "kind", 1), what = (int)sim_value(s, "what", 0);
    dSpaceDestroy(s->space);
    s->space = make_space(kind, NULL);
    dSpaceID inner = make_space(kind, s->space);
    dHeightfieldDataID heights = dGeomHeightfieldDataCreate();
    dGeomHeightfieldDataBuildCallback(heights, NULL, height, 1, 1, 2, 2, 1, 0, 1, 0);
    sim_ground(s);
    dGeomID other = dCreateSphere(inner, 0.1);
    dGeomSetPosition(other, 5, 0, -9);
    sim_box(s, 1, 0.2, 0.2, 0.2, 0, 0, 0.1);
    dBodyID upper = sim_box(s, 1, 0.2, 0.2, 0.2, 0, 0, 0.3);
    dGeomID geom = make_geom(inner, what, upper, heights);
    run(s, 200);
    dSpaceRemove(inner, geom);
    dSpaceAdd(s->space, geom);
    run(s, 100);
    double rests = dBodyGetPosition(upper)[2];
    dBodyID ball = sim_sphere(s, 1, 0.1, 1, 0, 0.2);
    run(s, 300);
    sim_print(s, "respaced");
    sim_number("rests", rests);
    sim_number("landed", dBodyGetPosition(ball)[2]);
    int status = sim_close(s);
    dGeomHeightfieldDataDestroy(heights);
    return status;
}
