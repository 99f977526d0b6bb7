/*
 * For how many contacts each point stands that stays where a pair has more than its manifold holds.
 *
 * Each contact of ODE's is a spring of its own. What they bear together, where, and how they resist tilting follows
 * from the sums over all of them of
 *
 *     f = 1, x, y, x^2, x y, y^2
 *
 * with the coordinates x, y in the plane of their face. A contact that goes counts for the point of its kind that is
 * nearest to it, which gives shares w. Then w becomes w (1 + c . f), with the c for which the six sums over the kind
 * are those of all its contacts: c is what the sums lack, divided by the matrix sum w f f^T. Where too few points of a
 * kind stay for that, the first three of the sums are made right, or the first.
 */
#include "contacts/reduction.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

enum { SUMS = 6, FLAT = 3, NOBODY = -1 };

/* The points of one kind that stay, and the sums over all contacts for which they stand. */
typedef struct kind {
    pinch_detected_point *point[PINCH_MANIFOLD_POINTS];
    int count;
    bool stands; /* for others */
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

/* Returns how well a point that stays may stand for one that goes: by its kind first, then by the surface parameters.
 * Redundant ones have no kind. */
static int fits(const pinch_detected_point *p, const pinch_detected_point *gone)
{
    if (gone->kind >= 0 && gone->kind == p->kind) return 2;
    return p->surface == gone->surface;
}

/* Returns the nearest of the points that stay and fit best. */
static pinch_detected_point *stand_in_for(const pinch_detected_point *gone, pinch_detected_point *const *kept,
                                          int count)
{
    static const double EQUAL = 1 - 1e-6; /* of several at the same distance the first one, whatever rounding says */
    int best = 0, fit = NOBODY;
    double least = INFINITY;
    for (int i = 0; i < count; i++) {
        double away[3];
        int fits_by = fits(kept[i], gone);
        if (fits_by < fit) continue;
        pinch_v3_sub(kept[i]->position, gone->position, away);
        double apart = pinch_v3_dot(away, away);
        if (fits_by == fit && !(apart < EQUAL * least)) continue;
        best = i;
        fit = fits_by;
        least = apart;
    }
    return kept[best];
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
        find_terms(k->point[i], f);
        for (int a = 0; a < terms; a++)
            for (int b = 0; b <= a; b++) l[a][b] += k->point[i]->share * f[a] * f[b];
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

static void find_lack(const kind *k, double lack[SUMS])
{
    memcpy(lack, k->sum, sizeof k->sum);
    for (int i = 0; i < k->count; i++) add_terms(k->point[i], -k->point[i]->share, lack);
}

/*
 * Makes the first `terms` sums right. It is done again, for what little the first time leaves of them. Returns false,
 * with the shares as they were, where one would become less than a part of what it was, or the total is not right.
 */
static bool make_right(const kind *k, int terms)
{
    enum { TIMES = 4 };
    static const double LEAST = 0.2, EXACT = 1e-9;
    double l[SUMS][SUMS], c[SUMS];
    factor(k, terms, l);
    bool fine = true;
    for (int i = 0; i < k->count; i++) k->point[i]->aside = k->point[i]->share;
    for (int time = 0; time < TIMES; time++) {
        find_lack(k, c);
        solve(terms, l, c);
        for (int i = 0; i < k->count; i++) {
            double f[SUMS], by = 1;
            find_terms(k->point[i], f);
            for (int t = 0; t < terms; t++) by += c[t] * f[t];
            k->point[i]->share *= by;
            fine = fine && k->point[i]->share > LEAST * k->point[i]->aside;
        }
    }
    find_lack(k, c);
    fine = fine && fabs(c[0]) <= EXACT * k->sum[0];
    for (int i = 0; i < k->count && !fine; i++) k->point[i]->share = k->point[i]->aside;
    return fine;
}

void pinch_share_out(pinch_detected_point *points, int count)
{
    pinch_detected_point *kept[PINCH_MANIFOLD_POINTS];
    kind kinds[PINCH_MOST_KINDS];
    int kept_count = 0;
    memset(kinds, 0, sizeof kinds);
    for (int i = 0; i < count; i++) {
        pinch_detected_point *p = &points[i];
        if (p->point < 0) continue;
        p->share = 1;
        kept[kept_count++] = p;
        if (p->kind < 0) continue;
        kinds[p->kind].point[kinds[p->kind].count++] = p;
        add_terms(p, 1, kinds[p->kind].sum);
    }
    for (int pass = 0; pass < 2 && kept_count > 0; pass++) {
        for (int i = 0; i < count; i++) {
            const pinch_detected_point *p = &points[i];
            if (p->point >= 0 || !p->bears) continue;
            pinch_detected_point *by = stand_in_for(p, kept, kept_count);
            bool same = p->kind >= 0 && by->kind == p->kind;
            if (same != (pass == 0)) continue;
            by->share++;
            if (!same) continue;
            kinds[p->kind].stands = true;
            add_terms(p, 1, kinds[p->kind].sum);
        }
        for (int k = 0; k < PINCH_MOST_KINDS && pass == 0; k++)
            if (kinds[k].stands && !make_right(&kinds[k], SUMS) && !make_right(&kinds[k], FLAT))
                (void)make_right(&kinds[k], 1);
    }
    double most = 0;
    for (int i = 0; i < kept_count; i++) most = fmax(most, kept[i]->share);
    for (int i = 0; i < kept_count; i++) kept[i]->part = kept[i]->share / most;
}
