/*
 * Follows the path of solutions from a problem that is solved to the one that is not, equations (56) and (57) of
 * core/README.md: (1 - t) (x - a) / size + t F(x) = 0 from (a, 0) to t = 1, by its arc length, so that t may go back on
 * the way. Newton's method, a line search and an implicit flow all stop where ||F|| has a local minimum; a path has
 * none.
 *
 * Points are z = (u, t) with x = a + size u, so that u and t are alike in size.
 */
#include "solvers/methods.h"
#include "support/dense.h"
#include "support/lu.h"

#include <math.h>
#include <string.h>

enum { CORRECTIONS = 6, FAST = 3 };
static const double ON_PATH = 1e-10;           /* ||H|| of a point of the path, beside 1 + ||u|| */
static const double FIRST = 1e-3, LONGEST = 1; /* steps along the path */
static const double SHORTEST = 1e-9;           /* a step that is as short and fails has met a kink, */
static const double AFTER_TURN = 1e-4;         /* which is known so well that the next step may be this long */
static const double WANDERED = 2;              /* a correction goes no farther than this many steps */

typedef struct path {
    const pinch_system *system;
    const double *anchor;
    double size;
    int n;         /* of u; a point has n + 1 numbers */
    double *x, *f; /* n each: x of the point last evaluated, F there */
    double *point; /* z */
    double *trial, *tangent, *turned, *right;
    double *matrix; /* (n + 1)^2: the derivatives of H, and one more row */
    double *lu_scratch;
    int *pivot;
    int factorizations, most;
} path;

size_t pinch_path_scratch(int size)
{
    size_t n = (size_t)size + 1;
    return n * n + 8 * n + (n + 1) / 2; /* the last for the pivots */
}

static void lay_out(path *p, double *scratch)
{
    size_t n = (size_t)p->n + 1;
    p->matrix = scratch;
    double **array[] = {&p->x, &p->f, &p->point, &p->trial, &p->tangent, &p->turned, &p->right, &p->lu_scratch};
    for (int k = 0; k < 8; k++) *array[k] = scratch + n * n + (size_t)k * n;
    p->pivot = (int *)(void *)(scratch + n * n + 8 * n);
}

/* Writes H at z into h[n], and returns its norm. */
static double evaluate(path *p, const double *z, double *h)
{
    double t = z[p->n];
    for (int i = 0; i < p->n; i++) p->x[i] = p->anchor[i] + p->size * z[i];
    p->system->residual(p->system->self, p->x, p->f);
    for (int i = 0; i < p->n; i++) h[i] = (1 - t) * z[i] + t * p->f[i];
    return pinch_norm(h, p->n);
}

/* Factors the derivatives of H at z, the point last evaluated, with `last` as the row below them. Returns the sign of
 * the determinant, 0 where there is none. */
static int factor(path *p, const double *z, const double *last)
{
    int n = p->n, stride = n + 1, sign = 1;
    double t = z[n];
    memset(p->matrix, 0, sizeof(double) * (size_t)stride * (size_t)stride);
    p->system->linearize(p->system->self, p->x);
    for (int i = 0; i < n; i++) {
        double *to = p->matrix + (size_t)i * (size_t)stride;
        pinch_row row = p->system->row(p->system->self, i);
        for (int s = 0; s < row.count; s++)
            for (int j = 0; j < row.segments[s].length; j++)
                to[row.segments[s].start + j] = t * p->size * row.segments[s].values[j];
        to[i] += 1 - t;
        to[n] = p->f[i] - z[i];
    }
    memcpy(p->matrix + (size_t)n * (size_t)stride, last, sizeof(double) * (size_t)stride);
    p->factorizations++;
    if (!pinch_lu_factor(stride, p->matrix, p->pivot, p->lu_scratch)) return 0;
    for (int i = 0; i < stride; i++) {
        if (p->matrix[(size_t)i * (size_t)(stride + 1)] < 0) sign = -sign;
        if (p->pivot[i] != i) sign = -sign;
    }
    return sign;
}

/*
 * Finds the direction in which the path goes on from z: the kernel of the derivatives, on the side where the
 * determinant with it as the last row is positive, as it is where the path begins. `near` is any direction that is not
 * perpendicular to it. direction and near may be the same array. Returns false where there is none.
 */
static bool find_direction(path *p, const double *z, const double *near, double *direction)
{
    (void)evaluate(p, z, p->right);
    int sign = factor(p, z, near);
    if (sign == 0) return false;
    memset(p->right, 0, sizeof(double) * (size_t)p->n);
    p->right[p->n] = 1;
    pinch_lu_solve(p->n + 1, p->matrix, p->pivot, p->right, direction);
    double length = pinch_norm(direction, p->n + 1);
    if (!(length > 0) || !isfinite(length)) return false;
    for (int i = 0; i <= p->n; i++) direction[i] *= sign / length;
    return true;
}

/* Corrects `trial` until it lies on the path, in the plane through it that is perpendicular to `across`. Returns the
 * number of corrections, or a negative number where there is no point within reach. */
static int correct(path *p, const double *across, double reach)
{
    int n = p->n;
    double moved = 0;
    for (int k = 0; k <= CORRECTIONS; k++) {
        double norm = evaluate(p, p->trial, p->right);
        if (norm <= ON_PATH * (1 + pinch_norm(p->trial, n))) return k;
        if (k == CORRECTIONS || !isfinite(norm) || factor(p, p->trial, across) == 0) return -1;
        p->right[n] = 0;
        pinch_lu_solve(n + 1, p->matrix, p->pivot, p->right, p->right);
        for (int i = 0; i <= n; i++) p->trial[i] -= p->right[i];
        moved += pinch_norm(p->right, n + 1);
        if (!(moved <= reach)) return -1;
    }
    return -1;
}

/* Finds the end of the path between its last point, before t = 1, and `trial` behind it. */
static bool finish(path *p)
{
    int n = p->n;
    double *up = p->turned, share = (1 - p->point[n]) / (p->trial[n] - p->point[n]), apart = 0;
    for (int i = 0; i <= n; i++) {
        double change = p->trial[i] - p->point[i];
        p->trial[i] = p->point[i] + share * change;
        apart += change * change;
    }
    p->trial[n] = 1;
    memset(up, 0, sizeof(double) * (size_t)n);
    up[n] = 1;
    return correct(p, up, WANDERED * sqrt(apart)) >= 0;
}

/*
 * Turns into the piece of F that begins just ahead, at a kink that is too sharp for a correction: there the derivatives
 * are those of the next piece, and the sign of the determinant says which of its two directions leads on.
 */
static bool turn(path *p)
{
    for (double ahead = 2 * SHORTEST; ahead < 1e3 * SHORTEST; ahead *= 4) {
        for (int i = 0; i <= p->n; i++) p->trial[i] = p->point[i] + ahead * p->tangent[i];
        if (!find_direction(p, p->trial, p->tangent, p->turned)) continue;
        double along = pinch_dot(p->turned, p->tangent, p->n + 1);
        if (along > 0.99) continue;
        memcpy(p->tangent, p->turned, sizeof(double) * (size_t)(p->n + 1));
        return true;
    }
    return false;
}

static bool follow(path *p)
{
    int n = p->n, turns = 0;
    double step = FIRST;
    memset(p->point, 0, sizeof(double) * (size_t)(n + 1));
    memset(p->tangent, 0, sizeof(double) * (size_t)n);
    p->tangent[n] = 1;
    if (!find_direction(p, p->point, p->tangent, p->tangent)) return false;
    while (p->factorizations < p->most) {
        for (int i = 0; i <= n; i++) p->trial[i] = p->point[i] + step * p->tangent[i];
        int corrections = correct(p, p->tangent, WANDERED * step);
        bool there = corrections >= 0;
        if (there && p->trial[n] >= 1) {
            if (finish(p)) return true;
            there = false;
        }
        if (there && find_direction(p, p->trial, p->tangent, p->turned) &&
            pinch_dot(p->turned, p->tangent, n + 1) > 0) {
            double *was = p->point, *before = p->tangent;
            p->point = p->trial;
            p->trial = was;
            p->tangent = p->turned;
            p->turned = before;
            if (corrections <= FAST) step = fmin(2 * step, LONGEST);
            turns = 0;
            continue;
        }
        step *= 0.25;
        if (step >= SHORTEST) continue;
        if (++turns > 3 || !turn(p)) return false;
        step = AFTER_TURN;
    }
    return false;
}

bool pinch_path(const pinch_system *system, const pinch_path_start *start, double *scratch, double *x, int *steps)
{
    path p = {.system = system, .anchor = start->anchor, .size = start->size, .n = system->size, .most = *steps};
    lay_out(&p, scratch);
    bool arrived = follow(&p);
    *steps = p.factorizations;
    if (arrived) memcpy(x, p.x, sizeof(double) * (size_t)p.n);
    return arrived;
}
