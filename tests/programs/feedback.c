/* Boxes are at rest, and their weight is read back from the contact joints. */
#include "sim.h"

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.01, 1000);
    sim_ground(s);
    double weight = 0, total[3] = {0};
    for (int i = 0; i < 5; i++) {
        sim_box(s, 1 + i, 0.3, 0.3, 0.3, i, 0, 0.15);
        weight += 9.81 * (1 + i);
    }
    s->want_feedback = true;
    sim_run(s);
    /* whichever of the two has the body: what acts on the ground does not count, and is not given */
    for (int k = 0; k < s->contact_count && k < SIM_MOST_CONTACTS; k++)
        for (int i = 0; i < 3; i++) total[i] += s->feedback[k].f1[i];
    sim_print(s, "feedback");
    sim_number("weight", weight);
    sim_number("x", total[0]);
    sim_number("y", total[1]);
    sim_number("z", total[2]);
    return sim_close(s);
}
