#include "clip.h"

#include "support/vec3.h"

#include <math.h>

/* A polygon, segment or point seen along the normal, with its corners in the cap's axes from the cap's centre. */
typedef struct outline {
    int count;
    const double (*x)[3]; /* the corners, in A's axes */
    double uv[PINCH_MAX_CONTACT_POINTS][2];
    bool out[PINCH_MAX_CONTACT_POINTS]; /* beyond the rim */
    double radius;                      /* of the cap, slack included */
} outline;

typedef struct points {
    int count;
    double x[PINCH_MAX_CONTACT_POINTS][3];
} points;

/* Finds where points in A's axes are, seen along the normal, in the cap's axes from its centre. */
static void find_places(const pinch_flat_face *face, const double (*x)[3], int count, double (*uv)[2])
{
    const pinch_shape *shape = face->shape;
    const double *d = face->d;
    double height = shape->middle + copysign(shape->half[2], face->which ? d[2] : -d[2]);
    double tilt[2] = {d[0] / d[2], d[1] / d[2]};
    for (int k = 0; k < count; k++) {
        double local[3];
        pinch_v3_copy(local, x[k]);
        if (face->which) pinch_pair_point_to_b(face->pair, x[k], local);
        uv[k][0] = local[0] - tilt[0] * (local[2] - height);
        uv[k][1] = local[1] - tilt[1] * (local[2] - height);
    }
}

/* Marks the corners beyond the rim. Returns false if there are none. */
static bool find_outside(outline *o)
{
    double limit = o->radius * o->radius;
    bool some = false;
    for (int k = 0; k < o->count; k++) {
        o->out[k] = o->uv[k][0] * o->uv[k][0] + o->uv[k][1] * o->uv[k][1] > limit;
        some = some || o->out[k];
    }
    return some;
}

static void add(points *to, const double *x)
{
    if (to->count < PINCH_MAX_CONTACT_POINTS) pinch_v3_copy(to->x[to->count++], x);
}

/* Adds the point at the part t of the way from corner p to corner q. */
static void add_between(const outline *o, int p, int q, double t, points *to)
{
    double x[3];
    t = t > 0 ? t : 0;
    t = t < 1 ? t : 1;
    for (int i = 0; i < 3; i++) x[i] = o->x[p][i] + t * (o->x[q][i] - o->x[p][i]);
    add(to, x);
}

/* Adds the points where the edge crosses the rim. */
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

/* Returns how far c lies to the left of the way from p to q, times the length of that way. */
static double left_of(const double *p, const double *q, const double *c)
{
    return (q[0] - p[0]) * (c[1] - p[1]) - (q[1] - p[1]) * (c[0] - p[0]);
}

static bool is_inside(const outline *o, double area, const double *c)
{
    for (int k = 0; k < o->count; k++)
        if (!(area * left_of(o->uv[k], o->uv[k + 1 < o->count ? k + 1 : 0], c) > 0)) return false;
    return true;
}

/* The polygon's plane is given by three of its corners, and `area` is twice the area that they span. */
typedef struct plane {
    const double *at, *p, *q; /* seen along the normal */
    const double *x, *y, *z;
    double area;
    int around; /* 1: the polygon's corners come in the order of these three; -1: the other way round */
} plane;

/* Chooses corners that are far apart. Returns false for a polygon that is seen edge on. */
static bool plane_of(const outline *o, plane *of)
{
    static const double EDGE_ON = 1e-6;
    int second = 0, third = 0;
    double far2 = 0, area = 0;
    for (int k = 1; k < o->count; k++) {
        double du = o->uv[k][0] - o->uv[0][0], dv = o->uv[k][1] - o->uv[0][1], apart2 = du * du + dv * dv;
        second = apart2 > far2 ? k : second;
        far2 = apart2 > far2 ? apart2 : far2;
    }
    for (int k = 1; k < o->count; k++) {
        double here = left_of(o->uv[0], o->uv[second], o->uv[k]);
        third = fabs(here) > fabs(area) ? k : third;
        area = fabs(here) > fabs(area) ? here : area;
    }
    *of = (plane){o->uv[0],     o->uv[second], o->uv[third], o->x[0],
                  o->x[second], o->x[third],   area,         second < third ? 1 : -1};
    return fabs(area) > EDGE_ON * far2;
}

/* Adds the point of the plane at that place. */
static void add_at(const plane *on, double u, double v, points *to)
{
    double c[2] = {u, v}, x[3];
    double to_p = -left_of(on->at, on->q, c) / on->area, to_q = left_of(on->at, on->p, c) / on->area;
    for (int i = 0; i < 3; i++) x[i] = on->x[i] + to_p * (on->y[i] - on->x[i]) + to_q * (on->z[i] - on->x[i]);
    add(to, x);
}

/* Adds the rim polygon's corners inside the polygon. */
static void add_rim(const outline *o, points *to)
{
    plane on;
    if (!plane_of(o, &on)) return;
    for (int k = 0; k < PINCH_RIM; k++) {
        double c[2] = {o->radius * PINCH_RIM_CORNER[k][0], o->radius * PINCH_RIM_CORNER[k][1]};
        if (is_inside(o, on.around * on.area, c)) add_at(&on, c[0], c[1], to);
    }
}

/* The points of a lens, with their places, so that none is added twice. */
typedef struct lens {
    const plane *on;
    points *to;
    int count;
    double place[2 * PINCH_RIM + 4][2], near2;
} lens;

static void add_new(lens *l, double u, double v)
{
    for (int k = 0; k < l->count; k++) {
        double du = u - l->place[k][0], dv = v - l->place[k][1];
        if (du * du + dv * dv < l->near2) return;
    }
    l->place[l->count][0] = u;
    l->place[l->count++][1] = v;
    add_at(l->on, u, v, l->to);
}

/* Two discs overlap in a lens. The other disc has the radius r and its centre at less than the sum of both radii. */
static void add_lens(const outline *o, const double *centre, double distance, double r, points *to)
{
    static const double NEAR = 0.1; /* of the smaller radius */
    double R = o->radius, smaller = r < R ? r : R;
    plane on;
    lens l = {.on = &on, .to = to, .near2 = NEAR * NEAR * smaller * smaller};
    if (!plane_of(o, &on)) return;
    bool crossed = distance > fabs(R - r);
    double e[2] = {crossed ? centre[0] / distance : 0, crossed ? centre[1] / distance : 0};
    if (crossed) {
        double along = 0.5 * (distance + (R - r) * (R + r) / distance), h2 = R * R - along * along;
        double h = h2 > 0 ? sqrt(h2) : 0;
        for (int side = -1; side <= 1; side += 2)
            add_new(&l, along * e[0] - side * h * e[1], along * e[1] + side * h * e[0]);
    }
    for (int k = 0; k < PINCH_RIM; k++) {
        double c[2] = {R * PINCH_RIM_CORNER[k][0], R * PINCH_RIM_CORNER[k][1]};
        double du = c[0] - centre[0], dv = c[1] - centre[1];
        if (!o->out[k]) add_new(&l, o->uv[k][0], o->uv[k][1]);
        if (du * du + dv * dv < r * r) add_new(&l, c[0], c[1]);
    }
    if (!crossed) return;
    add_new(&l, R * e[0], R * e[1]);
    add_new(&l, centre[0] - r * e[0], centre[1] - r * e[1]);
}

/* Returns true if the whole disc is left. */
static bool clip_disc(const pinch_flat_face *face, const pinch_feature *disc, outline *o, points *left)
{
    double centre[1][2];
    find_places(face, (const double(*)[3])disc->centre, 1, centre);
    double distance = sqrt(centre[0][0] * centre[0][0] + centre[0][1] * centre[0][1]);
    if (distance + disc->radius <= o->radius) return true;
    find_places(face, o->x, o->count, o->uv);
    (void)find_outside(o);
    if (distance < o->radius + disc->radius) add_lens(o, centre[0], distance, disc->radius, left);
    return false;
}

static bool clip_polygon(const pinch_flat_face *face, outline *o, points *left)
{
    int count = o->count;
    find_places(face, o->x, count, o->uv);
    if (!find_outside(o)) return true;
    for (int k = 0; k < count; k++) {
        int next = k + 1 < count ? k + 1 : 0;
        if (!o->out[k]) add(left, o->x[k]);
        if ((o->out[k] || o->out[next]) && (k == 0 || count > 2)) add_crossings(o, k, next, left);
    }
    if (count > 2) add_rim(o, left);
    return false;
}

int pinch_clip_to_disc(const pinch_flat_face *face, double x[PINCH_MAX_CONTACT_POINTS][3], int count,
                       const pinch_feature *around, bool *whole)
{
    outline o;
    o.count = count;
    o.x = (const double(*)[3])x;
    o.radius = face->shape->radius + face->slack;
    points left;
    left.count = 0;
    *whole = around && around->disc ? clip_disc(face, around, &o, &left) : clip_polygon(face, &o, &left);
    if (*whole) return count;
    for (int k = 0; k < left.count; k++) pinch_v3_copy(x[k], left.x[k]);
    return left.count;
}
