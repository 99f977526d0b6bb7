/*
 * For how many contacts each point stands that stays where a pair has more than its manifold holds.
 *
 * Each contact of ODE's is a spring of its own. What they bear together, where, and how they resist tilting follows
 * from the sums over all of them of
 *
 *     f = 1, x, y, x^2, x y, y^2
 *
 * with the coordinates x, y in the plane of their face. A contact that goes counts for the point nearest to it of those
 * with its face and its surface parameters, which gives shares w. Then w becomes w (1 + c . f), with the c for which
 * the six sums are those of all contacts: c is what the sums lack, divided by the matrix sum w f f^T.
 */
#include "contacts/reduction.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

enum { SUMS = 6, FLAT = 3, NOBODY = -1 };

/* The points of one kind that stay, by the first of them, and the sums over all contacts for which they stand. */
typedef struct kind {
    pinch_detected_point *points;
    int count, first;
    double sum[SUMS];
} kind;

static void find_terms(const pinch_detected_point *p, double f[SUMS])
{
    double x = p->u[0], y = p->u[1];
    const double terms[SUMS] = {1, x, y, x * x, x * y, y * y};
    memcpy(f, terms, sizeof terms);
}

static void add_terms(const pinch_detected_point *p, double share, double sum[SUMS])
{
    double f[SUMS];
    find_terms(p, f);
    for (int a = 0; a < SUMS; a++) sum[a] += share * f[a];
}

static bool stays_in(const kind *k, int i)
{
    const pinch_detected_point *p = &k->points[i], *first = &k->points[k->first];
    return p->point >= 0 && p->group == first->group && p->surface == first->surface;
}

/* Returns how well a point that stays may stand for one that goes: by the surface parameters first, then by the face. A
 * redundant one has not been sorted by its face. */
static int fits(const pinch_detected_point *p, const pinch_detected_point *gone)
{
    if (p->surface != gone->surface) return 0;
    return !gone->redundant && p->group == gone->group ? 2 : 1;
}

/* Returns the nearest of the points that stay and fit best; NOBODY: none stays. */
static int stand_in_for(const pinch_detected_point *gone, const pinch_detected_point *points, int count)
{
    static const double EQUAL = 1 - 1e-6; /* of several at the same distance the first one, whatever rounding says */
    int best = NOBODY, fit = 0;
    double least = INFINITY;
    for (int i = 0; i < count; i++) {
        double away[3];
        int fits_by = fits(&points[i], gone);
        if (points[i].point < 0 || fits_by < fit) continue;
        pinch_v3_sub(points[i].position, gone->position, away);
        double apart = pinch_v3_dot(away, away);
        if (best != NOBODY && fits_by == fit && !(apart < EQUAL * least)) continue;
        best = i;
        fit = fits_by;
        least = apart;
    }
    return best;
}

/*
 * Computes the lower factor of the matrix of the first `terms` sums (Cholesky). Points on a line leave some of these
 * without a say of their own: the matrix gets a little of the unit matrix.
 */
static void factor(const kind *k, int terms, double l[SUMS][SUMS])
{
    static const double LITTLE = 1e-9;
    double trace = 0;
    memset(l, 0, sizeof *l * SUMS);
    for (int i = 0; i < k->count; i++) {
        double f[SUMS];
        if (!stays_in(k, i)) continue;
        find_terms(&k->points[i], f);
        for (int a = 0; a < terms; a++)
            for (int b = 0; b <= a; b++) l[a][b] += k->points[i].share * f[a] * f[b];
    }
    for (int a = 0; a < terms; a++) trace += l[a][a];
    for (int a = 0; a < terms; a++) {
        l[a][a] += LITTLE * trace;
        for (int b = 0; b <= a; b++) {
            for (int c = 0; c < b; c++) l[a][b] -= l[a][c] * l[b][c];
            l[a][b] = a == b ? sqrt(l[a][a]) : l[a][b] / l[b][b];
        }
    }
}

/* Solves with such a factor in place. */
static void solve(int terms, double l[SUMS][SUMS], double *x)
{
    for (int a = 0; a < terms; a++) {
        for (int b = 0; b < a; b++) x[a] -= l[a][b] * x[b];
        x[a] /= l[a][a];
    }
    for (int a = terms - 1; a >= 0; a--) {
        for (int b = a + 1; b < terms; b++) x[a] -= l[b][a] * x[b];
        x[a] /= l[a][a];
    }
}

/*
 * Makes the first `terms` sums right. It is done again, for what little the first time leaves of them. Returns false,
 * with the shares as they were, where one would become less than a part of what it was.
 */
static bool make_right(const kind *k, int terms)
{
    enum { TIMES = 4 };
    static const double LEAST = 0.2;
    double l[SUMS][SUMS], c[SUMS];
    factor(k, terms, l);
    bool fine = true;
    for (int i = 0; i < k->count; i++) k->points[i].aside = k->points[i].share;
    for (int time = 0; time < TIMES; time++) {
        memcpy(c, k->sum, sizeof c);
        for (int i = 0; i < k->count; i++)
            if (stays_in(k, i)) add_terms(&k->points[i], -k->points[i].share, c);
        solve(terms, l, c);
        for (int i = 0; i < k->count; i++) {
            double f[SUMS], by = 1;
            if (!stays_in(k, i)) continue;
            find_terms(&k->points[i], f);
            for (int t = 0; t < terms; t++) by += c[t] * f[t];
            k->points[i].share *= by;
            fine = fine && k->points[i].share > LEAST * k->points[i].aside;
        }
    }
    for (int i = 0; i < k->count && !fine; i++) k->points[i].share = k->points[i].aside;
    return fine;
}

void pinch_share_out(pinch_detected_point *points, int count)
{
    for (int i = 0; i < count; i++) points[i].share = points[i].point >= 0;
    for (int i = 0; i < count; i++) {
        pinch_detected_point *p = &points[i];
        p->stand_in = p->point < 0 && p->bears ? stand_in_for(p, points, count) : NOBODY;
        if (p->stand_in != NOBODY && fits(&points[p->stand_in], p) == 2) points[p->stand_in].share++;
    }
    for (int first = 0; first < count; first++) {
        kind k = {points, count, first, {0}};
        bool known = points[first].point < 0, stands = false;
        for (int i = 0; i < first && !known; i++) known = stays_in(&k, i);
        for (int i = 0; i < count && !known; i++) {
            const pinch_detected_point *p = &points[i];
            bool goes = p->stand_in != NOBODY && fits(&points[p->stand_in], p) == 2 && stays_in(&k, p->stand_in);
            if (goes || stays_in(&k, i)) add_terms(p, 1, k.sum);
            stands = stands || goes;
        }
        if (stands && !make_right(&k, SUMS)) (void)make_right(&k, FLAT);
    }
    for (int i = 0; i < count; i++)
        if (points[i].stand_in != NOBODY && fits(&points[points[i].stand_in], &points[i]) < 2)
            points[points[i].stand_in].share++;
    double most = 0;
    for (int i = 0; i < count; i++) most = fmax(most, points[i].share);
    for (int i = 0; i < count && most > 0; i++) points[i].part = points[i].share / most;
}
