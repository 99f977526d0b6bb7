#include "support/box_grasp.h"

#include "support/cmocka_all.h"
#include "support/draw.h"
#include "support/scene_run.h"
#include "support/text.h"

static const double SIZE = BOX_GRASP_SIZE, LOAD = 5; /* m; N: what closing builds up */

/* One tip on each of 3 to 6 spots of the box's faces, the first two against each other. */
static void describe_fingers(pinch_random *random, text *t, double kn, double mass, double ramp)
{
    int count = 3 + draw_index(random, 4);
    for (int i = 0; i < count; i++) {
        int axis = i < 2 ? 0 : draw_index(random, 3), sign = i == 0                     ? 1
                                                             : i == 1                   ? -1
                                                             : draw_chance(random, 0.5) ? 1
                                                                                        : -1;
        double point[3], normal[3] = {0, 0, 0};
        for (int j = 0; j < 3; j++) point[j] = draw_uniform(random, -0.35, 0.35) * SIZE;
        if (i < 2) point[1] *= 0.3, point[2] *= 0.3;
        point[axis] = -0.5 * sign * SIZE;
        normal[axis] = sign;
        double k = kn, kt = k * draw_uniform(random, 0.5, 1);
        bool soft = draw_chance(random, 0.3);
        double closing = i < 2 ? 2 * LOAD / k : LOAD * draw_uniform(random, 0, 1) / k;
        add(t,
            "%s{\"point\": [%.17g, %.17g, %.17g], \"normal\": [%g, %g, %g], \"tip\": {\"type\": \"sphere\", "
            "\"radius\": %.17g}, \"model\": \"%s\", \"stiffness\": {\"normal\": %.17g, \"tangential\": %.17g",
            i ? ", " : "", point[0], point[1], point[2], normal[0], normal[1], normal[2],
            draw_uniform(random, 0.005, 0.02), soft ? "soft" : "hard", k, kt);
        if (soft) add(t, ", \"torsional\": %.17g", k * 1e-4);
        double c = 0.3 * sqrt(1e4 * mass); /* its lag on a slow load goes with 1/kn, too */
        add(t, "}, \"damping\": {\"normal\": %.17g, \"tangential\": %.17g", c, c);
        if (soft) add(t, ", \"torsional\": %.17g", c * 1e-4);
        add(t, "}, \"friction\": %.17g, ", draw_uniform(random, 0.2, 0.8));
        if (soft) add(t, "\"torsional_friction\": %.17g, ", draw_uniform(random, 0.001, 0.006));
        add(t, "\"closing\": %.17g, \"ramp\": %.17g}", closing, ramp);
    }
}

scene *box_grasp(uint64_t seed, double kn, double slow)
{
    static text t;
    pinch_random random;
    t.used = 0;
    pinch_random_seed(&random, seed);
    double wrench[6], mass = 0.2;
    add(&t,
        "{\"format\": \"pinch-scene/1\", \"gravity\": [0, 0, 0], \"object\": {\"shape\": {\"type\": \"box\", "
        "\"size\": [%g, %g, %g]}, \"mass\": %g}, \"fingers\": [",
        SIZE, SIZE, SIZE, mass);
    describe_fingers(&random, &t, kn, mass, slow);
    double scale = draw_uniform(&random, 0.2, 1.2) * LOAD;
    draw_direction(&random, wrench);
    draw_direction(&random, wrench + 3);
    for (int i = 0; i < 3; i++) {
        wrench[i] *= scale;
        wrench[3 + i] *= scale * 0.2 * SIZE;
    }
    add(&t,
        "], \"schedule\": [{\"time\": %.17g, \"force\": [0, 0, 0], \"torque\": [0, 0, 0]}, {\"time\": %.17g, "
        "\"force\": [%.17g, %.17g, %.17g], \"torque\": [%.17g, %.17g, %.17g]}], \"simulation\": {\"duration\": "
        "%.17g}}",
        1.2 * slow, 3 * slow, wrench[0], wrench[1], wrench[2], wrench[3], wrench[4], wrench[5], 3 * slow + 1.5);
    return scene_from_text(t.bytes);
}
