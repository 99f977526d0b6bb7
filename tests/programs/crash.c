/* Steps, closes ODE, and dies of a signal. With --inside 1 it dies without closing ODE. */
#include "sim.h"

#include <signal.h>
#include <stdio.h>

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.01, 50);
    sim_ground(s);
    sim_box(s, 1, 0.5, 0.5, 0.5, 0, 0, 0.25);
    sim_run(s);
    bool inside = sim_value(s, "inside", 0) > 0;
    sim_print(s, "crash");
    if (!inside) (void)sim_close(s);
    (void)fflush(NULL);
    return raise(SIGKILL);
}
