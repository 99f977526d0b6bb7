#include "disc_clip.h"

#include "support/vec3.h"

#include <math.h>

/* A polygon, segment or point seen along the normal: where its corners are in the cap's axes, from its centre. */
typedef struct outline {
    int count;
    const double (*x)[3]; /* the corners, in A's axes */
    double uv[PINCH_TOUCHES][2];
    bool out[PINCH_TOUCHES]; /* beyond the rim */
    double radius;           /* with the slack */
} outline;

typedef struct points {
    int count;
    double x[PINCH_TOUCHES][3];
} points;

/* False: none is beyond the rim. */
static bool find_places(const pinch_flat_face *face, const double *d, outline *o)
{
    const pinch_core *core = face->core;
    double height = core->middle + copysign(core->half[2], face->which ? d[2] : -d[2]);
    double tilt[2] = {d[0] / d[2], d[1] / d[2]}, limit = o->radius * o->radius;
    bool some = false;
    for (int k = 0; k < o->count; k++) {
        double from[3], local[3], *uv = o->uv[k];
        pinch_v3_copy(from, o->x[k]);
        pinch_v3_copy(local, from);
        if (face->which) {
            pinch_v3_sub(from, face->pair->p, from);
            pinch_pair_turn_back(face->pair, from, local);
        }
        uv[0] = local[0] - tilt[0] * (local[2] - height);
        uv[1] = local[1] - tilt[1] * (local[2] - height);
        o->out[k] = uv[0] * uv[0] + uv[1] * uv[1] > limit;
        some = some || o->out[k];
    }
    return some;
}

static void add(points *to, const double *x)
{
    if (to->count < PINCH_TOUCHES) pinch_v3_copy(to->x[to->count++], x);
}

/* At the part t of the way from corner p to q. */
static void add_between(const outline *o, int p, int q, double t, points *to)
{
    double x[3];
    t = t > 0 ? t : 0;
    t = t < 1 ? t : 1;
    for (int i = 0; i < 3; i++) x[i] = o->x[p][i] + t * (o->x[q][i] - o->x[p][i]);
    add(to, x);
}

/* Where the edge crosses the rim. */
static void add_crossings(const outline *o, int p, int q, points *to)
{
    const double *at = o->uv[p], d[2] = {o->uv[q][0] - at[0], o->uv[q][1] - at[1]};
    double a = d[0] * d[0] + d[1] * d[1], b = at[0] * d[0] + at[1] * d[1];
    double c = at[0] * at[0] + at[1] * at[1] - o->radius * o->radius, root2 = b * b - a * c;
    if (!(a > 0) || !(root2 > 0)) return;
    double root = sqrt(root2), enters = (-b - root) / a, leaves = (-b + root) / a;
    if (o->out[p] && o->out[q] && !(enters > 0 && leaves < 1)) return;
    if (o->out[p]) add_between(o, p, q, enters, to);
    if (o->out[q]) add_between(o, p, q, leaves, to);
}

/* How far c is to the left of the way from p to q, times its length. */
static double left_of(const double *p, const double *q, const double *c)
{
    return (q[0] - p[0]) * (c[1] - p[1]) - (q[1] - p[1]) * (c[0] - p[0]);
}

static bool is_inside(const outline *o, double turn, const double *c)
{
    for (int k = 0; k < o->count; k++)
        if (!(turn * left_of(o->uv[k], o->uv[k + 1 < o->count ? k + 1 : 0], c) > 0)) return false;
    return true;
}

/* The rim's own corners, on the polygon's plane. */
static void add_rim(const outline *o, points *to)
{
    static const double S = 0.70710678118654752, EDGE_ON = 1e-6;
    static const double CORNER[8][2] = {{1, 0}, {S, S}, {0, 1}, {-S, S}, {-1, 0}, {-S, -S}, {0, -1}, {S, -S}};
    const int second = o->count / 3, third = 2 * o->count / 3;
    const double *at = o->uv[0], *p = o->uv[second], *q = o->uv[third];
    double turn = left_of(at, p, q);
    if (!(fabs(turn) > EDGE_ON * o->radius * o->radius)) return;
    for (int k = 0; k < 8; k++) {
        double c[2] = {o->radius * CORNER[k][0], o->radius * CORNER[k][1]}, x[3];
        if (!is_inside(o, turn, c)) continue;
        double to_p = -left_of(at, q, c) / turn, to_q = left_of(at, p, c) / turn;
        for (int i = 0; i < 3; i++)
            x[i] = o->x[0][i] + to_p * (o->x[second][i] - o->x[0][i]) + to_q * (o->x[third][i] - o->x[0][i]);
        add(to, x);
    }
}

int pinch_clip_to_disc(const pinch_flat_face *face, const double d[3], double x[PINCH_TOUCHES][3], int count,
                       bool *whole)
{
    outline o = {.count = count, .x = (const double(*)[3])x, .radius = face->core->radius + face->slack};
    points left;
    left.count = 0;
    *whole = !find_places(face, d, &o);
    if (*whole) return count;
    for (int k = 0; k < count; k++) {
        int next = k + 1 < count ? k + 1 : 0;
        if (!o.out[k]) add(&left, x[k]);
        if ((o.out[k] || o.out[next]) && (k == 0 || count > 2)) add_crossings(&o, k, next, &left);
    }
    if (count > 2) add_rim(&o, &left);
    for (int k = 0; k < left.count; k++) pinch_v3_copy(x[k], left.x[k]);
    return left.count;
}
