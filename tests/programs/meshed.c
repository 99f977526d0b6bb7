/* A box is held by two fingertips that are meshes of --quads by --quads quads per face, under 5 N each. --tilt RAD
 * turns the box, --stiffness N_PER_M is that of each contact, --room N how many contacts the program asks for. Prints
 * how far it sinks from a fifth of the time on. */
#include "sim.h"

#include <stdlib.h>

enum { TIPS = 2, TIP_CATEGORY = 2 };
static const double TIP = 0.02, FORCE = 5; /* m, N */
static dBodyID finger[TIPS];
static int room_wanted;

static int collide(sim *s, dGeomID a, dGeomID b, dContact *found, int room)
{
    (void)s;
    if (dGeomGetCategoryBits(a) == TIP_CATEGORY && dGeomGetCategoryBits(b) == TIP_CATEGORY) return 0;
    return dCollide(a, b, room_wanted < room ? room_wanted : room, &found->geom, sizeof *found);
}

static void each_step(sim *s)
{
    (void)s;
    for (int i = 0; i < TIPS; i++)
        dBodyAddForce(finger[i], (i ? -FORCE : FORCE) - 2 * dBodyGetLinearVel(finger[i])[0], 0, 0);
}

/* Makes a cube of lattices, whose faces have corners of their own. What is allocated lasts as long as the program. */
static dGeomID make_tip(sim *s, int quads)
{
    int row = quads + 1, corners = 0, indices = 0;
    float *corner = malloc(sizeof(float) * 3 * 6 * (size_t)(row * row));
    dTriIndex *index = malloc(sizeof(dTriIndex) * 6 * 6 * (size_t)(quads * quads));
    for (int face = 0; face < 6; face++) {
        int axis = face / 2, first = corners;
        for (int k = 0; k < row * row; k++) {
            float *at = corner + 3 * corners++;
            at[axis] = (float)(face % 2 ? 0.5 * TIP : -0.5 * TIP);
            at[(axis + 1) % 3] = (float)(TIP * ((double)(k / row) / quads - 0.5));
            at[(axis + 2) % 3] = (float)(TIP * ((double)(k % row) / quads - 0.5));
        }
        for (int k = 0; k < quads * quads; k++) {
            int p = first + k / quads * row + k % quads, q = p + row;
            const int outward[6] = {p, q, q + 1, p, q + 1, p + 1};
            for (int t = 0; t < 6; t++) index[indices++] = (dTriIndex)outward[face % 2 ? t : t / 3 * 3 + 2 - t % 3];
        }
    }
    dTriMeshDataID data = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildSingle(data, corner, 3 * sizeof *corner, corners, index, indices, 3 * sizeof *index);
    return dCreateTriMesh(s->space, data, NULL, NULL, NULL);
}

static void make_finger(sim *s, int i, int quads)
{
    dMass mass;
    dGeomID tip = make_tip(s, quads);
    finger[i] = dBodyCreate(s->world);
    dMassSetBoxTotal(&mass, 0.05, TIP, TIP, TIP);
    dBodySetMass(finger[i], &mass);
    dBodySetPosition(finger[i], i ? 0.031 : -0.031, 0.003, 0.002);
    dBodySetGravityMode(finger[i], 0);
    dGeomSetCategoryBits(tip, TIP_CATEGORY);
    dGeomSetBody(tip, finger[i]);
    dJointID slider = dJointCreateSlider(s->world, NULL);
    dJointAttach(slider, finger[i], NULL);
    dJointSetSliderAxis(slider, 1, 0, 0);
}

int main(int argc, char **argv)
{
    static const double DAMPING = 5; /* N s/m: of each contact */
    dMatrix3 turned;
    sim *s = sim_open(argc, argv, 0.005, 2000);
    double stiffness = sim_value(s, "stiffness", 320), sum = s->h * stiffness + DAMPING;
    int quads = (int)sim_value(s, "quads", 3);
    room_wanted = (int)sim_value(s, "room", 64);
    s->surface.mode |= dContactSoftERP | dContactSoftCFM;
    s->surface.soft_erp = s->h * stiffness / sum;
    s->surface.soft_cfm = 1 / sum;
    s->surface.mu = 1;
    s->collide = collide;
    s->each_step = each_step;
    dBodyID box = sim_box(s, 0.1, 0.04, 0.04, 0.08, 0, 0, 0);
    dRFromAxisAndAngle(turned, 1, 0, 0, sim_value(s, "tilt", 0));
    dBodySetRotation(box, turned);
    for (int i = 0; i < TIPS; i++) make_finger(s, i, quads);
    double height = 0;
    for (long k = 0; k < s->steps; k++) {
        if (k == s->steps / 5) height = dBodyGetPosition(box)[2];
        sim_step(s);
    }
    sim_print(s, "meshed");
    sim_number("sinks", height - dBodyGetPosition(box)[2]);
    sim_number("height", dBodyGetPosition(box)[2]);
    return sim_close(s);
}
