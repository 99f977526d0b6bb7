/*
 * A ball of 0.1 m lies on a mesh, which gets other data in each of 20 steps then, higher by 1 mm each. --kind 0 to 3:
 * in a simple, hash, sweep and prune or quadtree space; --carrier 1: the mesh is on a kinematic body, 5 cm above its
 * centre. At last the mesh is set down by 1 m. Prints how high the ball was above the mesh before that, and is now.
 */
#include "sim.h"

enum { LIFTS = 20 };

static double vertices[LIFTS + 1][12]; /* ODE reads them where they are */
static dTriMeshDataID data[LIFTS + 1];

static void make_data(int k)
{
    static const double corners[4][2] = {{-3, -3}, {3, -3}, {3, 3}, {-3, 3}};
    static const dTriIndex indices[6] = {0, 1, 2, 0, 2, 3};
    for (int i = 0; i < 12; i++) vertices[k][i] = i % 3 < 2 ? corners[i / 3][i % 3] : 0.001 * k;
    data[k] = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildDouble(data[k], vertices[k], 3 * sizeof(double), 4, indices, 6, 3 * sizeof *indices);
}

static dSpaceID make_space(int kind)
{
    const dVector3 centre = {0, 0, 0, 0}, extents = {10, 10, 10, 0};
    return kind == 0   ? dSimpleSpaceCreate(NULL)
           : kind == 1 ? dHashSpaceCreate(NULL)
           : kind == 2 ? dSweepAndPruneSpaceCreate(NULL, dSAP_AXES_XYZ)
                       : dQuadTreeSpaceCreate(NULL, centre, extents, 4);
}

static void run(sim *s, long steps)
{
    for (long i = 0; i < steps; i++) sim_step(s);
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.01, 0);
    dSpaceDestroy(s->space);
    s->space = make_space((int)sim_value(s, "kind", 1));
    for (int k = 0; k <= LIFTS; k++) make_data(k);
    dGeomID mesh = dCreateTriMesh(s->space, data[0], NULL, NULL, NULL);
    dBodyID carrier = sim_value(s, "carrier", 0) > 0 ? dBodyCreate(s->world) : NULL;
    if (carrier) {
        dBodySetKinematic(carrier);
        dBodySetPosition(carrier, 0, 0, -0.05);
        dGeomSetBody(mesh, carrier);
        dGeomSetOffsetPosition(mesh, 0, 0, 0.05);
    }
    dBodyID ball = sim_sphere(s, 1, 0.1, 0, 0, 0.1);
    run(s, 200);
    for (int k = 1; k <= LIFTS; k++) {
        dGeomTriMeshSetData(mesh, data[k]);
        run(s, 1);
    }
    run(s, 200);
    double height = vertices[LIFTS][2], lifted = dBodyGetPosition(ball)[2] - height;
    if (carrier)
        dBodySetPosition(carrier, 0, 0, -1.05);
    else
        dGeomSetPosition(mesh, 0, 0, -1);
    run(s, 300);
    sim_print(s, "remeshed");
    sim_number("lifted", lifted);
    sim_number("landed", dBodyGetPosition(ball)[2] - height + 1);
    int status = sim_close(s);
    for (int k = 0; k <= LIFTS; k++) dGeomTriMeshDataDestroy(data[k]);
    return status;
}
