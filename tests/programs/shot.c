/* A small object, 1 cm by default, is shot at the ground. Prints for how many steps it was in the ground, and how fast
 * and how high it came out. --size X, --speed X, --box 1, --angle DEGREES from the vertical, --count N in a row. */
#include "sim.h"

#include <math.h>

enum { MOST = 16 };

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.01, 400);
    double size = sim_value(s, "size", 0.01), speed = sim_value(s, "speed", 6),
           angle = sim_value(s, "angle", 0) * M_PI / 180;
    int count = (int)fmin(sim_value(s, "count", 1), MOST), boxes = (int)sim_value(s, "box", 0);
    double mass = 1000 * size * size * size;
    dBodyID body[MOST];
    int steps_inside[MOST] = {0}, last = 0;
    double fastest_out = 0, highest = 0;
    sim_ground(s);
    for (int i = 0; i < count; i++) {
        double height = 0.5 + 0.003 * i;
        body[i] =
            boxes ? sim_box(s, mass, size, size, size, i, 0, height) : sim_sphere(s, mass, size / 2, i, 0, height);
        dBodySetLinearVel(body[i], speed * sin(angle), 0, -speed * cos(angle));
    }
    while (s->step < s->steps) {
        sim_step(s);
        for (int i = 0; i < count; i++) {
            double depth = size / 2 - dBodyGetPosition(body[i])[2];
            if (depth > 0.1 * size) { /* it lies less deep */
                steps_inside[i]++;
                last = (int)s->step;
            }
            if (steps_inside[i] > 0 && depth <= 0) fastest_out = fmax(fastest_out, dBodyGetLinearVel(body[i])[2]);
            if (steps_inside[i] > 0) highest = fmax(highest, -depth);
        }
    }
    int most = 0;
    for (int i = 0; i < count; i++)
        if (steps_inside[i] > most) most = steps_inside[i];
    sim_print(s, "shot");
    sim_number("steps_inside", most);
    sim_number("last_inside", last);
    sim_number("speed_out", fastest_out);
    sim_number("height_out", highest);
    return sim_close(s);
}
