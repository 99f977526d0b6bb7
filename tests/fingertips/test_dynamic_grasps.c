/*
 * Random grasps in motion: two to five fingers that are held in place, press by force or slide, on an object of any
 * shape that is pulled, turned and shaken until it may slip out. Every step of every one is solved.
 */
#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/scene_run.h"
#include "support/text.h"

/* Size of the object, m. */
typedef struct object {
    enum { BOX = 0, SPHERE, CYLINDER, CAPSULE, CONVEX, SHAPES } shape;
    double size[3];
} object;

static void describe_object(pinch_random *random, text *t, object *o)
{
    double *s = o->size;
    o->shape = (int)draw_index(random, SHAPES);
    for (int i = 0; i < 3; i++) s[i] = draw_uniform(random, 0.015, 0.04);
    add(t, "{\"shape\": ");
    if (o->shape == BOX)
        add(t, "{\"type\": \"box\", \"size\": [%.17g, %.17g, %.17g]}", 2 * s[0], 2 * s[1], 2 * s[2]);
    else if (o->shape == SPHERE)
        add(t, "{\"type\": \"sphere\", \"radius\": %.17g}", s[0]);
    else if (o->shape == CYLINDER || o->shape == CAPSULE)
        add(t, "{\"type\": \"%s\", \"radius\": %.17g, \"length\": %.17g}",
            o->shape == CYLINDER ? "cylinder" : "capsule", s[0], 2 * s[1]);
    else /* an octahedron */
        add(t,
            "{\"type\": \"convex\", \"vertices\": [[%.17g, 0, 0], [%.17g, 0, 0], [0, %.17g, 0], [0, %.17g, 0], "
            "[0, 0, %.17g], [0, 0, %.17g]]}",
            s[0], -s[0], s[1], -s[1], s[2], -s[2]);
    add(t, ", \"mass\": %.17g}", draw_log_uniform(random, 0.02, 1));
}

/* Draws a point of the object's surface with the normal into it; those with an odd number lie about opposite to the one
 * before. */
static void draw_point(pinch_random *random, const object *o, int number, double point[3], double normal[3])
{
    static double last[3];
    const double *s = o->size;
    double n[3];
    do draw_direction(random, n);
    while (number % 2 == 1 && dot(n, last) > -0.9);
    memcpy(last, n, sizeof last);
    if (o->shape == BOX) {
        int axis = fabs(n[0]) > fabs(n[1]) ? (fabs(n[0]) > fabs(n[2]) ? 0 : 2) : (fabs(n[1]) > fabs(n[2]) ? 1 : 2);
        for (int i = 0; i < 3; i++) {
            point[i] = i == axis ? copysign(s[i], n[i]) : s[i] * n[i];
            normal[i] = i == axis ? -copysign(1, n[i]) : 0;
        }
    } else if (o->shape == SPHERE) {
        for (int i = 0; i < 3; i++) {
            point[i] = s[0] * n[i];
            normal[i] = -n[i];
        }
    } else if (o->shape == CONVEX) {
        double share[3] = {0.2 + fabs(n[0]), 0.2 + fabs(n[1]), 0.2 + fabs(n[2])}, sum = share[0] + share[1] + share[2];
        for (int i = 0; i < 3; i++) {
            point[i] = copysign(s[i] * share[i] / sum, n[i]);
            normal[i] = -copysign(1 / s[i], n[i]);
        }
        double unit = length(normal);
        for (int i = 0; i < 3; i++) normal[i] /= unit;
    } else { /* the mantle */
        double round = hypot(n[0], n[1]);
        for (int i = 0; i < 2; i++) {
            point[i] = s[0] * n[i] / round;
            normal[i] = -n[i] / round;
        }
        point[2] = 0.8 * s[1] * n[2];
        normal[2] = 0;
    }
}

static void describe_finger(pinch_random *random, text *t, const object *o, int number, double load)
{
    double point[3], normal[3], k = draw_log_uniform(random, 500, 1e5), friction = draw_uniform(random, 0.1, 1.2);
    bool soft = draw_chance(random, 0.4), damped = draw_chance(random, 0.7);
    draw_point(random, o, number, point, normal);
    double tangential = k * draw_uniform(random, 0.4, 1), radius = draw_uniform(random, 0.004, 0.015);
    add(t,
        "%s{\"point\": [%.17g, %.17g, %.17g], \"normal\": [%.17g, %.17g, %.17g], \"tip\": {\"type\": \"sphere\", "
        "\"radius\": %.17g}, \"model\": \"%s\", \"stiffness\": {\"normal\": %.17g, \"tangential\": %.17g",
        number ? ", " : "", point[0], point[1], point[2], normal[0], normal[1], normal[2], radius,
        soft ? "soft" : "hard", k, tangential);
    if (soft) add(t, ", \"torsional\": %.17g", k * 1e-4);
    add(t, "}");
    if (damped) {
        double c = draw_log_uniform(random, 1e-4, 1e-2) * k;
        add(t, ", \"damping\": {\"normal\": %.17g, \"tangential\": %.17g", c, c);
        if (soft) add(t, ", \"torsional\": %.17g", c * 1e-4);
        add(t, "}");
    }
    if (soft) add(t, ", \"torsional_friction\": %.17g", draw_uniform(random, 0.0005, 0.006));
    add(t, ", \"friction\": {\"static\": %.17g, \"kinetic\": %.17g}", friction,
        friction * draw_uniform(random, 0.7, 1));
    double drive_damping, drive_mass;
    switch (draw_index(random, 3)) {
    case 0:
        add(t, ", \"closing\": %.17g", load / k);
        if (draw_chance(random, 0.2)) add(t, ", \"max_force\": %.17g", draw_uniform(random, 0.5, 2) * load);
        break;
    case 1:
        add(t, ", \"normal_force\": %.17g", load);
        break;
    default:
        drive_damping = draw_uniform(random, 0, 5);
        drive_mass = draw_log_uniform(random, 0.005, 0.3);
        add(t, ", \"drive\": {\"type\": \"slider\", \"mass\": %.17g, \"force\": %.17g, \"damping\": %.17g}", drive_mass,
            load, drive_damping);
    }
    add(t, ", \"ramp\": %.17g}", draw_chance(random, 0.3) ? 0 : draw_uniform(random, 0.01, 0.1));
}

static void describe_schedule(pinch_random *random, text *t, double load)
{
    add(t, ", \"schedule\": [{\"time\": 0, \"gravity\": [0, 0, 0]}");
    for (int i = 0; i < 3; i++) {
        double force[3], torque[3], scale = draw_uniform(random, 0, 2) * load;
        draw_direction(random, force);
        draw_direction(random, torque);
        add(t, ", {\"time\": %.17g, \"gravity\": [0, 0, -9.81], \"force\": [%.17g, %.17g, %.17g]",
            0.1 + 0.1 * i + 0.02 * draw_index(random, 5), scale * force[0], scale * force[1], scale * force[2]);
        add(t, ", \"torque\": [%.17g, %.17g, %.17g]}", 0.005 * scale * torque[0], 0.005 * scale * torque[1],
            0.005 * scale * torque[2]);
    }
    add(t, "]");
}

static scene *dynamic_grasp(uint64_t seed)
{
    static text t;
    pinch_random random;
    object o;
    pinch_random_seed(&random, seed);
    t.used = 0;
    double load = draw_log_uniform(&random, 0.5, 30);
    static const double STEPS[] = {5e-4, 1e-3, 2e-3};
    add(&t, "{\"format\": \"pinch-scene/1\", \"object\": ");
    describe_object(&random, &t, &o);
    add(&t, ", \"fingers\": [");
    int count = 2 + draw_index(&random, 4);
    for (int i = 0; i < count; i++)
        describe_finger(&random, &t, &o, i, load * (i < 2 ? 1 : draw_uniform(&random, 0.1, 1)));
    add(&t, "]");
    describe_schedule(&random, &t, load);
    add(&t, ", \"simulation\": {\"duration\": 0.5, \"step\": %.17g}}", STEPS[draw_index(&random, 3)]);
    return scene_from_text(t.bytes);
}

static void test_every_step_is_solved(void **state)
{
    (void)state;
    enum { SCENES = 2000, FEWEST = 250 }; /* hard steps are rare */
    int count = draw_count(SCENES);
    if (count < FEWEST) count = FEWEST;
    long contacts = 0, at_limit = 0;
    for (int seed = 1; seed <= count; seed++) {
        scene *s = dynamic_grasp((uint64_t)seed);
        world *w = world_of(s);
        world_run_until(w, 0.5);
        pinch_ode_stats stats = pinch_ode_statistics(w->plugin);
        if (stats.unconverged_steps > 0 || stats.fallback_islands > 0)
            fail_msg("grasp %d: %ld of %ld steps unconverged, %ld islands left to ODE", seed, stats.unconverged_steps,
                     stats.steps, stats.fallback_islands);
        contacts += stats.contacts_solved;
        at_limit += stats.drives_at_limit;
        world_free(w);
        scene_free(s);
    }
    assert_true(contacts > 100L * count && at_limit > 0);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_step_is_solved),
    };
    int failed = cmocka_run_group_tests_name("grasps in motion", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
