/*
 * A stack of boxes, a ball in a corner of two walls and a box on a slope, with contacts whose geoms are not set. ODE's
 * solver needs none. --names 0: NULL, 1: whatever was in that place of memory, 2: geoms of other pairs, 3: a geom that
 * has been destroyed. Prints how far the bodies drift in the last half of the run.
 */
#include "sim.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

static dGeomID stale[2], other[2];

static bool change(sim *s, dContact *contact)
{
    int names = (int)sim_value(s, "names", 0);
    dGeomID *g[2] = {&contact->geom.g1, &contact->geom.g2};
    for (int i = 0; i < 2; i++) {
        dGeomID was = *g[i];
        *g[i] = NULL;
        if (names == 1) {
            uint64_t garbage = 0x9e3779b97f4a7c15u * (uint64_t)(s->contact_count + 1000 * s->step + i + 1);
            memcpy(g[i], &garbage, sizeof garbage);
        } else if (names == 2) {
            *g[i] = other[i];
            other[i] = was;
        } else if (names == 3) {
            *g[i] = stale[i];
        }
    }
    return true;
}

int main(int argc, char **argv)
{
    enum { BOXES = 4 };
    sim *s = sim_open(argc, argv, 0.005, 2000);
    s->change = change;
    for (int i = 0; i < 2; i++) stale[i] = dCreateSphere(s->space, 0.1);
    for (int i = 0; i < 2; i++) dGeomDestroy(stale[i]);
    sim_ground(s);
    sim_pit(s, 4);
    dCreatePlane(s->space, -sin(0.3), 0, cos(0.3), 0.3); /* a slope of 17 degrees, from x = -1 up */
    for (int i = 0; i < BOXES; i++) sim_box(s, 1, 0.5, 0.5, 0.5, -2.5, 0, 0.25 + 0.5 * i);
    sim_sphere(s, 1, 0.25, -3.75, -3.75, 0.25);
    dBodyID sliding = sim_box(s, 1, 0.4, 0.4, 0.2, 2, 0, 0);
    dMatrix3 tilted;
    dRFromAxisAndAngle(tilted, 0, 1, 0, -0.3);
    dBodySetRotation(sliding, tilted);
    dBodySetPosition(sliding, 2, 0, (0.3 + 2 * sin(0.3) + 0.1) / cos(0.3));

    double settled[SIM_MOST_BODIES][3] = {{0}}, drift = 0;
    while (s->step < s->steps) {
        sim_step(s);
        for (int i = 0; i < s->body_count; i++) {
            const dReal *x = dBodyGetPosition(s->bodies[i]);
            double distance = 0;
            for (int k = 0; k < 3; k++) {
                if (s->step <= s->steps / 2) settled[i][k] = x[k];
                distance = hypot(distance, x[k] - settled[i][k]);
            }
            drift = fmax(drift, distance);
        }
    }
    sim_print(s, "geomless");
    sim_number("drift", drift);
    sim_number("top", dBodyGetPosition(s->bodies[BOXES - 1])[2]);
    return sim_close(s);
}
