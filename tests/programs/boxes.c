/* A pile of 60 boxes is dropped into a pit, each turned at random. */
#include "sim.h"

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.01, 5000);
    int count = (int)sim_value(s, "count", 60);
    sim_ground(s);
    sim_pit(s, 0.8);
    for (int i = 0; i < count && i < SIM_MOST_BODIES; i++) {
        double x = 0.15 + 0.2 * dRandReal(), y = 0.15 + 0.2 * dRandReal(), z = 0.15 + 0.2 * dRandReal();
        dBodyID body = sim_box(s, 500 * x * y * z, x, y, z, -0.45 + 0.45 * (i % 3), -0.45 + 0.45 * (i / 3 % 3),
                               0.4 + 0.5 * (i / 9));
        dMatrix3 R;
        double angle = 3 * dRandReal(), axis[3];
        for (int k = 2; k >= 0; k--) axis[k] = dRandReal() - 0.5;
        dRFromAxisAndAngle(R, axis[0], axis[1], axis[2], angle);
        dBodySetRotation(body, R);
    }
    sim_run(s);
    sim_print(s, "boxes");
    return sim_close(s);
}
