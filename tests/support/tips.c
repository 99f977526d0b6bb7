#include "support/tips.h"

#include "support/arithmetic.h"
#include "support/cmocka_all.h"

#include <float.h>
#include <string.h>

const double TEST_TIP_UPRIGHT[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

static void set_plane(test_tip *t, unsigned face, const unsigned *polygon)
{
    const double *p = t->points + 3 * polygon[1], *q = t->points + 3 * polygon[2], *r = t->points + 3 * polygon[3];
    double u[3], v[3], *n = t->planes + 4 * face, length = 0;
    for (int i = 0; i < 3; i++) {
        u[i] = q[i] - p[i];
        v[i] = r[i] - p[i];
    }
    for (int i = 0; i < 3; i++) n[i] = u[(i + 1) % 3] * v[(i + 2) % 3] - u[(i + 2) % 3] * v[(i + 1) % 3];
    length = sqrt(dot(n, n));
    for (int i = 0; i < 3; i++) n[i] /= length;
    n[3] = dot(n, p);
}

/* A prism or bipyramid over a regular polygon, stretched and sheared. */
static void make_convex(pinch_random *random, test_tip *t)
{
    unsigned n = 3 + (unsigned)draw_index(random, 6), *out = t->polygons, faces = 0;
    bool prism = draw_chance(random, 0.5);
    double a = draw_uniform(random, 0.5, 1.5), b = draw_uniform(random, 0.5, 1.5), c = draw_uniform(random, 0.5, 1.5);
    double shear = draw_uniform(random, -0.5, 0.5);
    unsigned count = prism ? 2 * n : n + 2;
    for (unsigned k = 0; k < count; k++) {
        double angle = 6.283185307179586 * (k % n) / n, z = prism ? (k < n ? -1 : 1) : 0, r = 1;
        if (!prism && k >= n) {
            r = 0;
            z = k == n ? -1 : 1;
        }
        double *x = t->points + 3 * k;
        x[0] = a * r * cos(angle) + shear * z;
        x[1] = b * r * sin(angle) + 0.3 * shear * z;
        x[2] = c * z;
    }
    if (prism) {
        *out++ = n;
        for (unsigned k = 0; k < n; k++) *out++ = n - 1 - k;
        *out++ = n;
        for (unsigned k = 0; k < n; k++) *out++ = n + k;
        faces = 2;
    }
    for (unsigned k = 0; k < n; k++) {
        unsigned next = (k + 1) % n;
        if (prism) {
            unsigned side[5] = {4, k, next, n + next, n + k};
            memcpy(out, side, sizeof side);
            out += 5;
            faces++;
        } else {
            unsigned low[4] = {3, next, k, n}, high[4] = {3, k, next, n + 1};
            memcpy(out, low, sizeof low);
            memcpy(out + 4, high, sizeof high);
            out += 8;
            faces += 2;
        }
    }
    const unsigned *polygon = t->polygons;
    for (unsigned f = 0; f < faces; f++, polygon += 1 + polygon[0]) set_plane(t, f, polygon);
    t->convex = (pinch_convex){t->planes, faces, t->points, t->polygons, count};
    t->tip.pieces = &t->convex;
    t->tip.piece_count = 1;
    t->tip.skin = draw_chance(random, 0.5) ? draw_uniform(random, 0.02, 0.3) : 0;
}

void test_tip_make_geom(test_tip *t)
{
    assert_int_equal(pinch_create_tip(NULL, &t->tip, &t->geom), PINCH_OK);
    dReal box[6];
    const double origin[3] = {0, 0, 0}, identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    test_tip_place(t, origin, identity);
    dGeomGetAABB(t->geom, box);
    t->size = 0;
    for (int i = 0; i < 6; i++) t->size = fmax(t->size, fabs(box[i]));
}

void test_tip_make(pinch_random *random, pinch_tip_type type, test_tip *t)
{
    memset(t, 0, sizeof *t);
    t->tip = pinch_default_tip(type);
    for (int i = 0; i < 3; i++) t->tip.size[i] = draw_log_uniform(random, 0.4, 2);
    double least = fmin(t->tip.size[0], fmin(t->tip.size[1], t->tip.size[2]));
    if (type == PINCH_TIP_BOX && draw_chance(random, 0.5)) t->tip.skin = draw_uniform(random, 0.02, 0.4) * least;
    if (type == PINCH_TIP_CYLINDER && draw_chance(random, 0.5))
        t->tip.skin = draw_uniform(random, 0.02, 0.8) * fmin(t->tip.size[0], 0.5 * t->tip.size[1]);
    if (type == PINCH_TIP_SUPERELLIPSOID)
        for (int i = 0; i < 2; i++) t->tip.exponent[i] = draw_uniform(random, 0.25, 1.6);
    if (type == PINCH_TIP_CONVEX) make_convex(random, t);
    test_tip_make_geom(t);
}

void test_tip_free(test_tip *t)
{
    if (t->geom) dGeomDestroy(t->geom);
    t->geom = NULL;
}

void test_tip_place(test_tip *t, const double position[3], const double R[9])
{
    dMatrix3 rotation;
    for (int i = 0; i < 12; i++) rotation[i] = i % 4 == 3 ? 0 : R[3 * (i / 4) + i % 4];
    dGeomSetPosition(t->geom, position[0], position[1], position[2]);
    dGeomSetRotation(t->geom, rotation);
    const double *actual = dGeomGetRotation(t->geom);
    for (int i = 0; i < 3; i++) t->position[i] = dGeomGetPosition(t->geom)[i];
    for (int i = 0; i < 9; i++) t->R[i] = actual[4 * (i / 3) + i % 3];
}

static double superellipsoid_reach(const pinch_tip *t, const double *d)
{
    double q1 = 1 / (1 - 0.5 * t->exponent[0]), q2 = 1 / (1 - 0.5 * t->exponent[1]);
    double x = fabs(t->size[0] * d[0]), y = fabs(t->size[1] * d[1]), z = fabs(t->size[2] * d[2]);
    double g = pow(pow(x, q2) + pow(y, q2), q1 / q2);
    return pow(g + pow(z, q1), 1 / q1);
}

static double local_reach(const test_tip *t, const double *d)
{
    const pinch_tip *tip = &t->tip;
    const double *s = tip->size;
    double rho = sqrt(d[0] * d[0] + d[1] * d[1]), skin = tip->skin, most = -DBL_MAX;
    switch (tip->type) {
    case PINCH_TIP_SPHERE:
        return s[0];
    case PINCH_TIP_CAPSULE:
        return s[0] + 0.5 * s[1] * fabs(d[2]);
    case PINCH_TIP_FLAT_CAPSULE: {
        double dome = 2.0 / 3 * s[0], low = -dome * (0.5 * s[1] + 0.375 * s[0]) / (s[1] + dome);
        return low * d[2] + 0.5 * s[1] * fabs(d[2]) + (d[2] > 0 ? s[0] : s[0] * rho);
    }
    case PINCH_TIP_BOX:
        for (int i = 0, first = 1; i < 3; i++, first = 0) most = (first ? 0 : most) + (0.5 * s[i] - skin) * fabs(d[i]);
        return most + skin;
    case PINCH_TIP_CYLINDER:
        return (s[0] - skin) * rho + (0.5 * s[1] - skin) * fabs(d[2]) + skin;
    case PINCH_TIP_ELLIPSOID:
        return sqrt(s[0] * s[0] * d[0] * d[0] + s[1] * s[1] * d[1] * d[1] + s[2] * s[2] * d[2] * d[2]);
    case PINCH_TIP_SUPERELLIPSOID:
        return superellipsoid_reach(tip, d);
    default:
        for (unsigned k = 0; k < t->convex.point_count; k++) most = fmax(most, dot(t->points + 3 * k, d));
        return most + skin;
    }
}

double test_tip_reach(const test_tip *t, const double d[3])
{
    double local[3];
    for (int i = 0; i < 3; i++) local[i] = t->R[i] * d[0] + t->R[3 + i] * d[1] + t->R[6 + i] * d[2];
    return local_reach(t, local) + dot(t->position, d);
}

double test_overlap(const test_tip *a, const test_tip *b, const double n[3])
{
    const double back[3] = {-n[0], -n[1], -n[2]};
    return test_tip_reach(a, back) + test_tip_reach(b, n);
}

/*
 * Compass search on the sphere: steps in eight directions that turn, and shrink where none leads down. It ends where it
 * has come below `target`, or where steps of the length left cannot: the overlap changes by at most `slope` a radian.
 */
static double search(const test_tip *a, const test_tip *b, double n[3], double step, double shrink, double slope,
                     double target)
{
    double best = test_overlap(a, b, n);
    /* a valley followed in steps that shrink by `shrink` ends within this many of the last one */
    double left = 2 / (1 - shrink);
    for (int round = 0; round < 5000; round++) {
        if (best < target || best - left * slope * step > target) break;
        double t1[3] = {0, 0, 0}, t2[3], chosen[3];
        int axis = fabs(n[0]) < 0.6 ? 0 : 1;
        t1[axis] = 1;
        double along = n[axis], length = 0;
        for (int i = 0; i < 3; i++) t1[i] -= along * n[i];
        length = sqrt(dot(t1, t1));
        for (int i = 0; i < 3; i++) t1[i] /= length;
        for (int i = 0; i < 3; i++) t2[i] = n[(i + 1) % 3] * t1[(i + 2) % 3] - n[(i + 2) % 3] * t1[(i + 1) % 3];
        bool lower = false;
        double c = cos(0.3 * round), s = sin(0.3 * round), level = best;
        for (int k = 0; k < 8; k++) {
            static const double S = 0.7071067811865476;
            double turned = S * (c - s), m[3];
            for (int i = 0; i < 3; i++) m[i] = n[i] + step * (c * t1[i] + s * t2[i]);
            length = sqrt(dot(m, m));
            for (int i = 0; i < 3; i++) m[i] /= length;
            double p = test_overlap(a, b, m);
            s = S * (c + s); /* an eighth on */
            c = turned;
            if (p >= best) continue;
            best = p;
            lower = true;
            memcpy(chosen, m, sizeof chosen);
        }
        if (lower) memcpy(n, chosen, sizeof chosen);
        if (!lower || level - best < 0.1 * (best - target)) step *= lower ? sqrt(shrink) : shrink;
    }
    return best;
}

double test_least_overlap(const test_tip *a, const test_tip *b, int samples, int starts, double target, double n[3])
{
    enum { MOST = 4096 };
    static double direction[MOST][3], value[MOST];
    static int made;
    double best = DBL_MAX, slope = a->size + b->size, apart[3];
    assert_true(samples <= MOST);
    for (int i = 0; i < 3; i++) apart[i] = a->position[i] - b->position[i];
    slope = 2 * slope + sqrt(dot(apart, apart));
    for (int k = 0; k < samples && made != samples; k++) { /* a spiral from pole to pole */
        double z = 1 - (2 * k + 1.0) / samples, angle = 2.399963229728653 * k, r = sqrt(1 - z * z);
        double d[3] = {r * cos(angle), r * sin(angle), z};
        memcpy(direction[k], d, sizeof d);
    }
    made = samples;
    for (int k = 0; k < samples; k++) {
        value[k] = test_overlap(a, b, direction[k]);
        if (value[k] >= best) continue;
        best = value[k];
        memcpy(n, direction[k], sizeof direction[k]);
    }
    double near = cos(2.5 * 3.5 / sqrt(samples));
    for (int s = 0; s < starts && best >= target; s++) {
        int at = -1;
        for (int k = 0; k < samples; k++)
            if (value[k] < DBL_MAX && (at < 0 || value[k] < value[at])) at = k;
        if (at < 0) break;
        double m[3], start[3];
        memcpy(m, direction[at], sizeof m);
        memcpy(start, m, sizeof m);
        double p = search(a, b, m, 3.5 / sqrt(samples), samples > 1000 ? 0.95 : 0.5, slope, target);
        if (p < best) {
            best = p;
            memcpy(n, m, sizeof m);
        }
        for (int k = 0; k < samples; k++)
            if (dot(direction[k], start) > near) value[k] = DBL_MAX;
    }
    return best;
}

double test_lower_overlap(const test_tip *a, const test_tip *b, double n[3])
{
    enum { TRIES = 200000 };
    pinch_random random;
    pinch_random_seed(&random, 1);
    double best = test_overlap(a, b, n);
    for (int k = 0; k < TRIES; k++) {
        double d[3], m[3], step = draw_log_uniform(&random, 1e-8, 1);
        draw_direction(&random, d);
        for (int i = 0; i < 3; i++) m[i] = n[i] + step * d[i];
        double length = sqrt(dot(m, m));
        if (!(length > 0)) continue;
        for (int i = 0; i < 3; i++) m[i] /= length;
        double p = test_overlap(a, b, m);
        if (p >= best) continue;
        best = p;
        memcpy(n, m, sizeof m);
    }
    return best;
}

test_tip test_tip_of(pinch_tip_type type, double a, double b, double c, double skin)
{
    test_tip t;
    memset(&t, 0, sizeof t);
    t.tip = pinch_default_tip(type);
    t.tip.size[0] = a;
    t.tip.size[1] = b;
    t.tip.size[2] = c;
    t.tip.skin = skin;
    test_tip_make_geom(&t);
    return t;
}

void test_tips_touch(pinch_random *random, test_tip *a, test_tip *b, double low, double high)
{
    double R[9], x[3], y[3], away[3], back[3];
    draw_frame(random, R);
    for (int i = 0; i < 3; i++) x[i] = draw_uniform(random, -3, 3);
    test_tip_place(a, x, R);
    draw_frame(random, R);
    test_tip_place(b, x, R);
    draw_direction(random, away);
    for (int i = 0; i < 3; i++) back[i] = -away[i];
    double touch = test_overlap(a, b, back), part = draw_uniform(random, low, high);
    for (int i = 0; i < 3; i++) y[i] = x[i] + part * touch * away[i];
    test_tip_place(b, y, R);
}

int test_tips_collide(const test_tip *a, const test_tip *b, dContactGeom c[TEST_TIP_CONTACTS])
{
    return dCollide(a->geom, b->geom, TEST_TIP_CONTACTS, c, sizeof *c);
}
