/* The wrenches of exact friction cones, and those that stand for them. */
#include "grasp_quality.h"

#include "common/vector.h"

#include <math.h>
#include <string.h>

wrench_space wrench_space_of(const pinch_grasp *grasp)
{
    return (wrench_space){grasp->planar ? 3 : 6, grasp->finger_count, grasp->fingers, grasp->radius};
}

/* The wrench of the force `normal` + t1 along the first tangent + t2 along the second, with a moment about the normal.
 */
static void wrench_of(const wrench_space *s, const pinch_finger *f, const double t[3], double *w)
{
    double tangent2[3], force[3], moment[3];
    scene_cross(f->normal, f->tangent1, tangent2);
    for (int j = 0; j < 3; j++) force[j] = f->normal[j] + t[0] * f->tangent1[j] + t[1] * tangent2[j];
    scene_cross(f->point, force, moment);
    scene_add_scaled(moment, t[2], f->normal);
    if (s->dimension == 3) {
        w[0] = force[0];
        w[1] = force[1];
        w[2] = moment[2] / s->radius;
        return;
    }
    for (int j = 0; j < 3; j++) {
        w[j] = force[j];
        w[3 + j] = moment[j] / s->radius;
    }
}

/* The semi-axes of the friction limit for 1 N of normal force: both tangents (N), and torsion (N m). */
static void limit_axes(const wrench_space *s, const pinch_finger *f, double axes[3])
{
    double mu = f->model == PINCH_CONTACT_FRICTIONLESS ? 0.0 : f->friction;
    axes[0] = mu;
    axes[1] = s->dimension == 3 ? 0.0 : mu;
    axes[2] = s->dimension == 3 || f->model != PINCH_CONTACT_SOFT ? 0.0 : f->torsional_friction;
}

/* d . w is linear in the friction t, so that its gradient g follows from three wrenches. The largest value over the
 * ellipsoid of friction with the semi-axes a is at t = a^2 g / |a g|. */
double wrench_space_support(const wrench_space *s, int i, const double d[WRENCH_MOST], double w[WRENCH_MOST])
{
    const pinch_finger *f = &s->contacts[i];
    double axes[3], t[3] = {0}, bare = 0.0, scaled[3], size = 0.0;
    limit_axes(s, f, axes);
    wrench_of(s, f, t, w);
    for (int j = 0; j < s->dimension; j++) bare += d[j] * w[j];
    for (int k = 0; k < 3; k++) {
        double along[3] = {k == 0, k == 1, k == 2}, sum = 0.0;
        if (axes[k] > 0.0) {
            wrench_of(s, f, along, w);
            for (int j = 0; j < s->dimension; j++) sum += d[j] * w[j];
            sum -= bare;
        }
        scaled[k] = axes[k] * sum;
    }
    size = scene_norm(scaled);
    for (int k = 0; k < 3; k++) t[k] = size > 0.0 ? axes[k] * scaled[k] / size : 0.0;
    wrench_of(s, f, t, w);
    return bare + size;
}

double wrench_space_reach(const wrench_space *s, const double d[WRENCH_MOST], double w[WRENCH_MOST])
{
    double furthest = -INFINITY, own[WRENCH_MOST];
    for (int i = 0; i < s->count; i++) {
        double reach = wrench_space_support(s, i, d, own);
        if (reach <= furthest) continue;
        furthest = reach;
        memcpy(w, own, sizeof own);
    }
    return furthest;
}

/* Gilbert's method: of the segment from the point so far to the furthest wrench the other way, the point nearest to the
 * origin comes next. Where the wrenches of 1 N in all leave the origin out, a plane parts it from them in the end. */
bool wrench_space_lacks(const wrench_space *s, double most, double d[WRENCH_MOST])
{
    enum { STEPS = 2000 };
    double x[WRENCH_MOST] = {0}, w[WRENCH_MOST] = {0};
    wrench_space_reach(s, w, x);
    for (int step = 0; step < STEPS; step++) {
        double size = 0.0, along = 0.0, way = 0.0;
        for (int j = 0; j < s->dimension; j++) size += x[j] * x[j];
        if (!(size > 0.0)) return false;
        for (int j = 0; j < s->dimension; j++) d[j] = -x[j] / sqrt(size);
        if (wrench_space_reach(s, d, w) <= most) return true;
        for (int j = 0; j < s->dimension; j++) {
            along += x[j] * (x[j] - w[j]);
            way += (x[j] - w[j]) * (x[j] - w[j]);
        }
        double part = way > 0.0 ? fmin(fmax(along / way, 0.0), 1.0) : 0.0;
        for (int j = 0; j < s->dimension; j++) x[j] += part * (w[j] - x[j]);
    }
    return false;
}

static int rings_of(int faces)
{
    return faces >= 4 ? faces / 4 : 1;
}

int wrench_space_generators(const wrench_space *s, int i, int faces)
{
    double axes[3];
    limit_axes(s, &s->contacts[i], axes);
    int around = axes[0] > 0.0 ? (s->dimension == 3 ? 2 : faces) : 0;
    if (axes[2] > 0.0) return (2 * (rings_of(faces) - 1) + 1) * around + 2;
    return around > 0 ? around : 1;
}

void wrench_space_generate(const wrench_space *s, int i, int faces, double *wrenches)
{
    const pinch_finger *f = &s->contacts[i];
    double axes[3];
    limit_axes(s, f, axes);
    int around = axes[0] > 0.0 ? (s->dimension == 3 ? 2 : faces) : 0;
    int rings = axes[2] > 0.0 ? rings_of(faces) : 1;
    for (int ring = 1 - rings; ring < rings; ring++) {
        double latitude = 0.5 * SCENE_PI * ring / rings;
        for (int k = 0; k < around; k++, wrenches += s->dimension) {
            double angle = 2.0 * SCENE_PI * k / around;
            wrench_of(s, f,
                      (double[3]){axes[0] * cos(latitude) * cos(angle), axes[1] * cos(latitude) * sin(angle),
                                  axes[2] * sin(latitude)},
                      wrenches);
        }
    }
    for (int pole = -1; pole <= 1; pole += 2) {
        if (axes[2] > 0.0)
            wrench_of(s, f, (double[3]){0, 0, pole * axes[2]}, wrenches);
        else if (around == 0 && pole < 0)
            wrench_of(s, f, (double[3]){0}, wrenches);
        else
            continue;
        wrenches += s->dimension;
    }
}
