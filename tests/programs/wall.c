/* A wall of 60 bricks stands in bond. With --ball 1 a ball of 5 kg hits it at 20 m/s. */
#include "sim.h"

enum { ROWS = 6, BRICKS_A_ROW = 10, LAUNCH_STEP = 200 };

static dBodyID ball;

static void launch(sim *s)
{
    if (ball && s->step == LAUNCH_STEP) dBodySetLinearVel(ball, 0, 20, 2);
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.01, 5000);
    sim_ground(s);
    for (int row = 0; row < ROWS; row++)
        for (int k = 0; k < BRICKS_A_ROW; k++)
            sim_box(s, 1, 0.4, 0.2, 0.2, 0.4 * k + 0.2 * (row % 2), 0, 0.1 + 0.2 * row);
    if (sim_value(s, "ball", 0) > 0) ball = sim_sphere(s, 5, 0.25, 2, -3, 0.25);
    s->each_step = launch;
    sim_run(s);
    double standing = 0;
    for (int i = 0; i < ROWS * BRICKS_A_ROW; i++) standing += dBodyGetPosition(s->bodies[i])[2] > 0.9;
    sim_print(s, "wall");
    sim_number("top_row", standing);
    return sim_close(s);
}
