#include "support/grasps.h"

#include "support/draw.h"

#include <math.h>
#include <string.h>

static void add(test_grasp *g, double x, double y, double z, double nx, double ny, double nz, pinch_contact_model model)
{
    pinch_finger *f = &g->fingers[g->grasp.finger_count++];
    *f = (pinch_finger){.point = {x, y, z}, .model = model, .max_force = INFINITY};
    grasp_set_normal(f, nx, ny, nz);
}

void grasp_set_normal(pinch_finger *finger, double x, double y, double z)
{
    double n[3] = {x, y, z}, length = sqrt(x * x + y * y + z * z);
    int axis = 0;
    for (int i = 0; i < 3; i++) {
        finger->normal[i] = n[i] / length;
        if (fabs(n[i]) < fabs(n[axis])) axis = i;
    }
    double t[3] = {0}, t2 = 0.0;
    t[axis] = 1.0;
    for (int i = 0; i < 3; i++) t[i] -= finger->normal[axis] * finger->normal[i];
    for (int i = 0; i < 3; i++) t2 += t[i] * t[i];
    for (int i = 0; i < 3; i++) finger->tangent1[i] = t[i] / sqrt(t2);
}

static void stiffness(test_grasp *g, int from, double kn, double kt, double mu)
{
    for (int i = from; i < g->grasp.finger_count; i++) {
        g->fingers[i].stiffness[0] = kn;
        g->fingers[i].stiffness[1] = kt;
        g->fingers[i].friction = mu;
    }
}

static void planar_tangents(test_grasp *g)
{
    for (int i = 0; i < g->grasp.finger_count; i++) {
        pinch_finger *f = &g->fingers[i];
        f->tangent1[0] = -f->normal[1];
        f->tangent1[1] = f->normal[0];
        f->tangent1[2] = 0.0;
    }
}

static void example_1(test_grasp *g, bool b)
{
    g->grasp.planar = true;
    double shift = b ? 1.25 : 0.0; /* points are relative to the centre of mass, at (-1.25, 0) in 1b */
    const double active[2][3] = {{-0.75, 0.25, 0.5}, {-2.25, -1.25, -1.0}};
    for (int i = 0; i < 3; i++) add(g, active[b][i] + shift, -1.0, 0, 0, 1, 0, PINCH_CONTACT_FRICTIONLESS);
    if (b) {
        add(g, 0.5 + shift, -0.25, 0, -1, 0, 0, PINCH_CONTACT_FRICTIONLESS);
    } else {
        add(g, -2, 0.5, 0, 1, 0, 0, PINCH_CONTACT_FRICTIONLESS);
        add(g, 2, 0.75, 0, -1, 0, 0, PINCH_CONTACT_FRICTIONLESS);
        add(g, 0.25, 1, 0, 0, -1, 0, PINCH_CONTACT_FRICTIONLESS);
    }
    planar_tangents(g);
    stiffness(g, 0, 1.0, 1.0, 0.0);
    g->grasp.wrench[1] = -10.0;
    g->grasp.wrench[5] = b ? 6.0 : 3.5;
    g->grasp.origin[0] = shift;
    g->grasp.radius = b ? sqrt(1.75 * 1.75 + 1.0) : sqrt(5.0);
}

static void example_2(test_grasp *g)
{
    const double cx = 1.0 / 6.0, half = sqrt(0.5);
    add(g, -cx, 0, 0, 1, 0, 0, PINCH_CONTACT_HARD);
    add(g, 0.25 - cx, 0.25, 0, -1, -1, 0, PINCH_CONTACT_HARD);
    add(g, 0.25 - cx, -0.25, 0, -1, 1, 0, PINCH_CONTACT_HARD);
    stiffness(g, 0, 4.0, 2.0, 0.25);
    g->fingers[0].stiffness[1] = 1.0;
    g->fingers[0].force_controlled = true;
    g->fingers[0].normal_force = 10.0;
    const double tangents[3][3] = {{0, 1, 0}, {-half, half, 0}, {-half, -half, 0}};
    for (int i = 0; i < 3; i++) memcpy(g->fingers[i].tangent1, tangents[i], sizeof tangents[i]);
    g->grasp.origin[0] = -cx;
    g->grasp.radius = hypot(0.5, cx);
}

static void example_3(test_grasp *g, bool four)
{
    add(g, 0 - 0.5, 0.5 - 0.5, 0.5 - 0.5, 1, 0, 0, PINCH_CONTACT_HARD);
    add(g, 1 - 0.5, 0.7 - 0.5, 0.6 - 0.5, -1, 0, 0, PINCH_CONTACT_HARD);
    add(g, 0.4 - 0.5, 0 - 0.5, 0.6 - 0.5, 0, 1, 0, PINCH_CONTACT_HARD);
    stiffness(g, 0, 2.0, 2.0, 0.6);
    g->fingers[0].closing = g->fingers[1].closing = 10.0;
    g->fingers[2].closing = 2.0;
    if (four) {
        add(g, 0, -0.5, 0, 0, 1, 0, PINCH_CONTACT_FRICTIONLESS);
        add(g, 0, 0.5, 0, 0, -1, 0, PINCH_CONTACT_FRICTIONLESS);
        stiffness(g, 3, 2.0, 0.0, 0.0);
        g->fingers[3].closing = g->fingers[4].closing = 2.5;
    }
    g->grasp.wrench[2] = -5.0;
    g->grasp.radius = sqrt(0.75);
}

void grasp_paper(int number, test_grasp *g)
{
    memset(g, 0, sizeof *g);
    g->grasp.fingers = g->fingers;
    if (number <= 1) example_1(g, number == 0);
    if (number == 2) example_2(g);
    if (number >= 3) example_3(g, number == 4);
}

static void unit_vector(pinch_random *random, bool planar, double v[3])
{
    double length2;
    do {
        length2 = 0.0;
        for (int i = 0; i < 3; i++) {
            v[i] = planar && i == 2 ? 0.0 : draw_uniform(random, -1.0, 1.0);
            length2 += v[i] * v[i];
        }
    } while (length2 > 1.0 || length2 < 0.01);
    for (int i = 0; i < 3; i++) v[i] /= sqrt(length2);
}

typedef enum random_shape { ROUGH, SPHERE, BOX } random_shape;

/* A point on the object and its inward normal. */
static void touch(pinch_random *random, random_shape shape, const double semi[3], bool planar, double point[3],
                  double n[3])
{
    double e[3], tilt[3];
    unit_vector(random, planar, e);
    unit_vector(random, planar, tilt);
    int axis = (int)((planar ? 2.0 : 3.0) * pinch_random_uniform(random));
    for (int j = 0; j < 3; j++) {
        double s = shape == SPHERE ? semi[0] : semi[j];
        point[j] = e[j] * s;
        n[j] = -e[j] / s;
        if (shape == ROUGH) n[j] += 0.1 * tilt[j] / s; /* tilted by a few degrees */
        if (shape != BOX) continue;
        double side = tilt[axis] < 0.0 ? -1.0 : 1.0;
        point[j] = j == axis ? side * semi[j] : planar && j == 2 ? 0.0 : e[j] * semi[j];
        n[j] = j == axis ? -side : 0.0;
    }
}

void grasp_random(pinch_random *random, test_grasp *g)
{
    memset(g, 0, sizeof *g);
    g->grasp.fingers = g->fingers;
    bool planar = g->grasp.planar = pinch_random_uniform(random) < 0.125;
    int count = 3 + (int)(10.0 * pinch_random_uniform(random));
    double size = draw_log_uniform(random, 0.01, 1.0), load = draw_log_uniform(random, 0.01, 100.0);
    double kn0 = draw_log_uniform(random, 1e2, 1e6), spread = pinch_random_uniform(random) < 0.5 ? 1.0 : 1e4;
    double semi[3], squeeze = draw_log_uniform(random, 0.1, 30.0);
    for (int i = 0; i < 3; i++) semi[i] = draw_uniform(random, 0.5, 1.0) * 0.5 * size;
    g->grasp.radius = fmax(semi[0], fmax(semi[1], semi[2]));
    random_shape shape = (random_shape)(3.0 * pinch_random_uniform(random));
    for (int i = 0; i < count; i++) {
        double p[3], n[3];
        touch(random, shape, semi, planar, p, n);
        double pick = pinch_random_uniform(random);
        pinch_contact_model model = pick < 0.2   ? PINCH_CONTACT_FRICTIONLESS
                                    : pick < 0.7 ? PINCH_CONTACT_HARD
                                                 : PINCH_CONTACT_SOFT;
        add(g, p[0], p[1], p[2], n[0], n[1], n[2], model);
        pinch_finger *f = &g->fingers[i];
        double kn = kn0 * draw_log_uniform(random, 1.0 / sqrt(spread), sqrt(spread));
        f->stiffness[0] = fmin(fmax(kn, 1e2), 1e6);
        f->stiffness[1] = f->stiffness[0] * draw_uniform(random, 0.1, 1.0);
        f->friction = draw_uniform(random, 0.1, 1.2);
        f->torsional_friction = draw_uniform(random, 0.01, 0.2) * size;
        f->stiffness[2] =
            f->stiffness[1] * f->torsional_friction * f->torsional_friction * draw_log_uniform(random, 0.1, 10.0);
        double role = pinch_random_uniform(random);
        double push = load * squeeze * draw_uniform(random, 0.0, 2.0);
        if (role < 0.15) {
            f->force_controlled = true;
            f->normal_force = push;
        } else if (role < 0.8) {
            f->closing = push / f->stiffness[0];
        }
        if (!f->force_controlled && pinch_random_uniform(random) < 0.1)
            f->max_force = load * draw_log_uniform(random, 0.1, 10.0);
    }
    if (planar) planar_tangents(g);
    double force[3], torque[3];
    unit_vector(random, planar, force);
    unit_vector(random, false, torque);
    /* a pure weight as often as any wrench */
    double twist = pinch_random_uniform(random) < 0.5 ? 0.0 : draw_uniform(random, 0.0, 1.0) * load * 0.5 * size;
    for (int j = 0; j < 3; j++) {
        g->grasp.wrench[j] = load * force[j];
        g->grasp.wrench[3 + j] = planar && j < 2 ? 0.0 : twist * torque[j];
    }
}
