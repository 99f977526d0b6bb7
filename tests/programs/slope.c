/*
 * A box lies on a plane. Gravity turns by --angle degrees over 5 s (1000 steps at least), towards --direction degrees
 * in the plane. Prints how fast the box moves at the end, how far it moved in the last 2 s, and its acceleration in the
 * last second.
 */
#include "sim.h"

#include <math.h>

static double angle, direction;

static double along(const dReal *v)
{
    return v[0] * cos(direction) + v[1] * sin(direction);
}

static void turn(sim *s)
{
    double now = angle * fmin(1, (double)s->step * s->h / 5);
    dWorldSetGravity(s->world, 9.81 * sin(now) * cos(direction), 9.81 * sin(now) * sin(direction), -9.81 * cos(now));
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.005, 3000);
    angle = sim_value(s, "angle", 20) * M_PI / 180;
    direction = sim_value(s, "direction", 0) * M_PI / 180;
    sim_ground(s);
    dBodyID box = sim_box(s, 1, 0.4, 0.4, 0.1, 0, 0, 0.05);
    s->each_step = turn;
    double before[2] = {0}, speed = 0;
    while (s->step < s->steps) {
        if (s->step == s->steps - lround(2 / s->h)) before[0] = along(dBodyGetPosition(box));
        if (s->step == s->steps - lround(1 / s->h)) before[1] = along(dBodyGetLinearVel(box));
        sim_step(s);
    }
    speed = along(dBodyGetLinearVel(box));
    sim_print(s, "slope");
    sim_number("speed_along", speed);
    sim_number("slid", along(dBodyGetPosition(box)) - before[0]);
    sim_number("acceleration", speed - before[1]);
    return sim_close(s);
}
