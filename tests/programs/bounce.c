/* Balls of several restitutions fall from 1 m. Prints the height of the first rebound over that of the fall; of the
 * elastic one, the greatest height in the last second, too. */
#include "sim.h"

#include <math.h>
#include <stdint.h>

enum { BALLS = 5 };
static const double RESTITUTION[BALLS] = {0, 0.3, 0.6, 0.9, 1};
static const double RADIUS = 0.1;

static bool choose(sim *s, dContact *contact)
{
    dBodyID body = dGeomGetBody(contact->geom.g1) ? dGeomGetBody(contact->geom.g1) : dGeomGetBody(contact->geom.g2);
    for (int i = 0; i < BALLS; i++)
        if (s->bodies[i] == body) contact->surface.bounce = RESTITUTION[i];
    return true;
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.001, 5000);
    sim_ground(s);
    for (int i = 0; i < BALLS; i++) sim_sphere(s, 1, RADIUS, i, 0, 1 + RADIUS);
    s->surface.mode |= dContactBounce;
    s->surface.bounce_vel = 0.1;
    s->change = choose;
    double rebound[BALLS] = {0}, last = 0;
    bool landed[BALLS] = {false}, fallen[BALLS] = {false};
    while (s->step < s->steps) {
        sim_step(s);
        for (int i = 0; i < BALLS; i++) {
            double height = dBodyGetPosition(s->bodies[i])[2] - RADIUS, speed = dBodyGetLinearVel(s->bodies[i])[2];
            landed[i] = landed[i] || height < 0.001;
            if (landed[i] && rebound[i] > 0.01 && speed < 0) fallen[i] = true;
            if (landed[i] && !fallen[i]) rebound[i] = fmax(rebound[i], height);
            if (i == BALLS - 1 && (double)(s->steps - s->step) * s->h < 1) last = fmax(last, height);
        }
    }
    sim_print(s, "bounce");
    sim_number("rebound_0", rebound[0]);
    sim_number("rebound_3", rebound[1]);
    sim_number("rebound_6", rebound[2]);
    sim_number("rebound_9", rebound[3]);
    sim_number("rebound_10", rebound[4]);
    sim_number("last_10", last);
    return sim_close(s);
}
