/* A stack of --count boxes is at rest. Prints how far it drifts. */
#include "sim.h"

#include <math.h>

enum { SETTLING_STEPS = 1000 };

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.01, 5000);
    int count = (int)sim_value(s, "count", 10);
    sim_ground(s);
    for (int i = 0; i < count; i++) sim_box(s, 1, 0.5, 0.5, 0.5, 0, 0, 0.25 + 0.5 * i);
    double settled[SIM_MOST_BODIES][3] = {{0}}, drift = 0;
    while (s->step < s->steps) {
        sim_step(s);
        for (int i = 0; i < s->body_count; i++) {
            const dReal *x = dBodyGetPosition(s->bodies[i]);
            double distance = 0;
            for (int k = 0; k < 3; k++) {
                if (s->step <= SETTLING_STEPS) settled[i][k] = x[k];
                distance = hypot(distance, x[k] - settled[i][k]);
            }
            drift = fmax(drift, distance);
        }
    }
    sim_print(s, "stack");
    sim_number("drift", drift);
    sim_number("top", dBodyGetPosition(s->bodies[count - 1])[2]);
    return sim_close(s);
}
