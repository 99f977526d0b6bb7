/* Steps, closes ODE, and dies of a signal (--signal N, SIGKILL by default). With --inside 1 it dies without closing
 * ODE. With --handler 1 it ends with status 7 in a handler of its own. */
#include "sim.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>

static void handle(int number)
{
    (void)number;
    exit(7);
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.01, 50);
    sim_ground(s);
    sim_box(s, 1, 0.5, 0.5, 0.5, 0, 0, 0.25);
    int number = (int)sim_value(s, "signal", SIGKILL);
    if (sim_value(s, "handler", 0) > 0) (void)signal(number, handle);
    sim_run(s);
    bool inside = sim_value(s, "inside", 0) > 0;
    sim_print(s, "crash");
    if (!inside) (void)sim_close(s);
    (void)fflush(NULL);
    return raise(number);
}
