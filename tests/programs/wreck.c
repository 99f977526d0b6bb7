/*
 * A heavy ball falls on a chain of five light links, which its jerk tears apart where the step is too long for it.
 * Prints the sum of the gaps in its joints, the largest that there was and that at the end, and the largest gap that
 * one joint had, m.
 */
#include "sim.h"

#include <math.h>

enum { LINKS = 5 };

static dJointID hinge[LINKS];
static double gaps, gaps_max, gap_max;

static void look(sim *s)
{
    (void)s;
    gaps = 0;
    for (int i = 0; i < LINKS; i++) {
        dVector3 a, b;
        dJointGetHingeAnchor(hinge[i], a);
        dJointGetHingeAnchor2(hinge[i], b);
        double gap = sqrt(pow(a[0] - b[0], 2) + pow(a[1] - b[1], 2) + pow(a[2] - b[2], 2));
        gaps += gap;
        gap_max = fmax(gap_max, gap);
    }
    gaps_max = fmax(gaps_max, gaps);
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.01, 2000);
    const double length = 1.0 / LINKS;
    dBodyID before = NULL;
    for (int i = 0; i < LINKS; i++) {
        dBodyID link = sim_box(s, i == LINKS - 1 ? 100 : 1, length, 0.02, 0.02, (i + 0.5) * length, 0, 0);
        hinge[i] = dJointCreateHinge(s->world, NULL);
        dJointAttach(hinge[i], link, before);
        dJointSetHingeAnchor(hinge[i], i * length, 0, 0);
        dJointSetHingeAxis(hinge[i], 0, 1, 0);
        before = link;
    }
    s->each_step = look;
    sim_run(s);
    sim_print(s, "wreck");
    sim_number("gaps_max", gaps_max);
    sim_number("gaps", gaps);
    sim_number("gap_max", gap_max);
    return sim_close(s);
}
