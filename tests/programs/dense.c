/* Spheres and boxes start in one another, in a volume as large as that of all of them together would fill if they lay
 * apart: --share of it, 0.3 by default. They burst apart and spread over the ground. --bodies N, 1000 by default. */
#include "sim.h"

#include <math.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <time.h>

/* Of this process, whatever else the machine does. */
static double seconds(void)
{
    return (double)clock() / CLOCKS_PER_SEC;
}

static double megabytes(void)
{
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    return (double)usage.ru_maxrss / 1024;
}

int main(int argc, char **argv)
{
    sim *s = sim_open(argc, argv, 0.01, 8);
    int count = (int)sim_value(s, "bodies", 1000);
    double share = sim_value(s, "share", 0.3), boxes = sim_value(s, "boxes", 0.5), size = 0.2;
    double side = size * cbrt(share * count);
    sim_ground(s);
    for (int i = 0; i < count; i++) {
        double x = side * (dRandReal() - 0.5), y = side * (dRandReal() - 0.5), z = size + side * dRandReal();
        double r = size * (0.5 + dRandReal()) / 2;
        if (dRandReal() < boxes)
            sim_box(s, 1, 1.6 * r, 1.6 * r, 1.6 * r, x, y, z);
        else
            sim_sphere(s, 1, r, x, y, z);
    }
    double begin = seconds();
    if (s->steps > 0) sim_step(s);
    double first = seconds() - begin;
    sim_run(s);
    double all = seconds() - begin;
    sim_print(s, "dense");
    sim_number("contacts", s->contact_count);
    sim_number("first_step_s", first);
    sim_number("time_s", all);
    sim_number("memory_mb", megabytes());
    return sim_close(s);
}
