/*
 * The step with the linearized friction cone as a linear complementarity problem, equation (21) of core/README.md, for
 * the methods that need a matrix. With z = (r_n; lambda; s) per contact and
 *
 *     S = 1 + h sum G_t^T g_t G_t + h sum G_c^T g_c G_c        (c: compliant joint rows),
 *
 * the motion q = S^-1 (h G_n^T r_n - h G_t^T g_t N lambda + p) is linear in z.
 */
#include "velocity/velocity_system.h"

#include "support/lu.h"

#include <pinch/lcp.h>

#include <math.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

/* The unknowns of one contact are r_n, then the facets' slips, then torsion's two, then s of a force limit. */
typedef struct places {
    int normal, facets, torsion, limit; /* first index, -1: none */
} places;

typedef struct step_lcp {
    const pinch_velocity_system *vs;
    int size;
    places *of;             /* per element */
    double *s_lu, *scratch; /* S factored; freedoms */
    int *pivot;
    double *p;      /* what moves the bodies at z = 0, solved with S: q at z = 0 */
    double *column; /* q per unit of one z, freedoms */
    double *m, *q;  /* the LCP */
} step_lcp;

static int count_unknowns(const pinch_velocity_system *vs, places *of)
{
    int next = 0;
    for (int e = 0; e < vs->element_count; e++) {
        const pinch_contact_law *law = &vs->elements[e].law;
        of[e] = (places){-1, -1, -1, -1};
        if (law->low == -INFINITY) continue; /* a compliant joint row: linear, no complementarity */
        of[e].normal = next++;
        if (law->rows >= 3) {
            of[e].facets = next;
            next += law->faces;
        }
        if (law->rows == 4) {
            of[e].torsion = next;
            next += 2;
        }
        if (law->high < INFINITY) of[e].limit = next++;
    }
    return next;
}

/* f += factor * row `row` of the element's G */
static void add_row(const pinch_element *element, int row, double factor, double *f)
{
    for (int b = 0; b < element->blocks; b++) {
        const pinch_row_block *block = &element->block[b];
        for (int k = 0; k < block->size; k++) f[block->first + k] += factor * block->g[row * block->size + k];
    }
}

static double row_dot(const pinch_element *element, int row, const double *q)
{
    double sum = 0;
    for (int b = 0; b < element->blocks; b++) {
        const pinch_row_block *block = &element->block[b];
        for (int k = 0; k < block->size; k++) sum += block->g[row * block->size + k] * q[block->first + k];
    }
    return sum;
}

/* Linear are the tangential springs of contacts and all of a compliant joint row. */
static bool is_linear_row(const places *of, int row)
{
    return row > 0 || of->normal < 0;
}

static bool factor_inertia(step_lcp *l)
{
    const pinch_velocity_system *vs = l->vs;
    size_t n = (size_t)vs->freedoms;
    memset(l->s_lu, 0, n * n * sizeof(double));
    memset(l->p, 0, n * sizeof(double));
    for (size_t i = 0; i < n; i++) l->s_lu[i * (n + 1)] = 1;
    for (int e = 0; e < vs->element_count; e++) {
        const pinch_element *element = &vs->elements[e];
        for (int row = 0; row < element->law.rows; row++) {
            if (!is_linear_row(&l->of[e], row)) continue;
            double hg = vs->step * element->trial.g[row];
            add_row(element, row, vs->step * (element->trial.a[row] - element->trial.g[row] * element->w0[row]), l->p);
            for (int b = 0; b < element->blocks; b++) {
                const pinch_row_block *block = &element->block[b];
                for (int k = 0; k < block->size; k++)
                    add_row(element, row, hg * block->g[row * block->size + k],
                            l->s_lu + (size_t)(block->first + k) * n);
            }
        }
    }
    if (!pinch_lu_factor((int)n, l->s_lu, l->pivot, l->scratch)) return false;
    pinch_lu_solve((int)n, l->s_lu, l->pivot, l->p, l->p);
    return true;
}

/* Writes facet k's direction in the tangent plane. */
static void facet(int faces, int k, double n[2])
{
    n[0] = cos(2 * PI * k / faces);
    n[1] = sin(2 * PI * k / faces);
}

/* N^T r_t of the trial force for a motion q: facet k feels n . (a_t - g_t w_t) */
static double facet_force(const pinch_element *element, const double n[2], const double *q, bool constant)
{
    double sum = 0;
    for (int i = 0; i < 2; i++) {
        double w = row_dot(element, 1 + i, q), offset = 0;
        if (constant) offset = element->trial.a[1 + i] - element->trial.g[1 + i] * element->w0[1 + i];
        sum += n[i] * (offset - element->trial.g[1 + i] * w);
    }
    return sum;
}

static double torsion_force(const pinch_element *element, const double *q, bool constant)
{
    double offset = constant ? element->trial.a[3] - element->trial.g[3] * element->w0[3] : 0;
    return offset - element->trial.g[3] * row_dot(element, 3, q);
}

/* Adds what all rows of the LCP feel of the motion q to column `to` of M, or to q itself (constant). */
static void rows_of_motion(const step_lcp *l, const double *q, bool constant, double *to, size_t stride)
{
    const pinch_velocity_system *vs = l->vs;
    for (int e = 0; e < vs->element_count; e++) {
        const pinch_element *element = &vs->elements[e];
        const places *of = &l->of[e];
        if (of->normal < 0) continue;
        double w = row_dot(element, 0, q);
        if (constant) w += element->w0[0] - element->trial.a[0] / element->trial.g[0];
        to[(size_t)of->normal * stride] += w;
        for (int k = 0; k < element->law.faces && of->facets >= 0; k++) {
            double n[2];
            facet(element->law.faces, k, n);
            to[(size_t)(of->facets + k) * stride] -= facet_force(element, n, q, constant);
        }
        if (of->torsion >= 0) {
            double torque = torsion_force(element, q, constant);
            to[(size_t)of->torsion * stride] -= torque;
            to[(size_t)(of->torsion + 1) * stride] += torque;
        }
        if (of->limit >= 0 && constant) to[(size_t)of->limit * stride] += element->law.high;
    }
}

/* Fills column j of M: one unit of z_j causes a motion, which all rows feel. */
static void motion_column(step_lcp *l, int j)
{
    int n = l->vs->freedoms;
    pinch_lu_solve(n, l->s_lu, l->pivot, l->column, l->column);
    rows_of_motion(l, l->column, false, l->m + j, (size_t)l->size);
    memset(l->column, 0, sizeof(double) * (size_t)n);
}

/* Fills the columns of one contact, and the entries that do not go through the bodies' motion. */
static void contact_columns(step_lcp *l, int e)
{
    const pinch_velocity_system *vs = l->vs;
    const pinch_element *element = &vs->elements[e];
    const pinch_contact_law *law = &element->law;
    const places *of = &l->of[e];
    size_t n = (size_t)l->size;
    double h = vs->step;
    add_row(element, 0, h, l->column);
    motion_column(l, of->normal);
    l->m[(size_t)of->normal * n + of->normal] += 1 / element->trial.g[0];
    for (int k = 0; k < law->faces && of->facets >= 0; k++) {
        double nk[2];
        facet(law->faces, k, nk);
        for (int i = 0; i < 2; i++) add_row(element, 1 + i, -h * element->trial.g[1 + i] * nk[i], l->column);
        motion_column(l, of->facets + k);
        l->m[(size_t)(of->facets + k) * n + of->normal] += law->friction[0];
        for (int j = 0; j < law->faces; j++) { /* r_t = ... - g_t N lambda itself */
            double nj[2];
            facet(law->faces, j, nj);
            l->m[(size_t)(of->facets + j) * n + of->facets + k] +=
                element->trial.g[1] * (nj[0] * nk[0] + nj[1] * nk[1]);
        }
    }
    for (int side = 0; side < 2 && of->torsion >= 0; side++) {
        double sign = side ? -1 : 1;
        add_row(element, 3, -h * element->trial.g[3] * sign, l->column);
        motion_column(l, of->torsion + side);
        l->m[(size_t)(of->torsion + side) * n + of->normal] += law->friction[2];
        for (int other = 0; other < 2; other++)
            l->m[(size_t)(of->torsion + other) * n + of->torsion + side] +=
                element->trial.g[3] * sign * (other ? -1 : 1);
    }
    if (of->limit >= 0) {
        l->m[(size_t)of->normal * n + of->limit] += 1;
        l->m[(size_t)of->limit * n + of->normal] -= 1;
    }
}

/* q = p + the motion of all z */
static void recover(step_lcp *l, const double *z, double *x)
{
    const pinch_velocity_system *vs = l->vs;
    double h = vs->step;
    memset(l->column, 0, sizeof(double) * (size_t)vs->freedoms);
    for (int e = 0; e < vs->element_count; e++) {
        const pinch_element *element = &vs->elements[e];
        const places *of = &l->of[e];
        if (of->normal < 0) continue;
        add_row(element, 0, h * z[of->normal], l->column);
        for (int k = 0; k < element->law.faces && of->facets >= 0; k++) {
            double n[2];
            facet(element->law.faces, k, n);
            for (int i = 0; i < 2; i++)
                add_row(element, 1 + i, -h * element->trial.g[1 + i] * n[i] * z[of->facets + k], l->column);
        }
        if (of->torsion >= 0)
            add_row(element, 3, -h * element->trial.g[3] * (z[of->torsion] - z[of->torsion + 1]), l->column);
    }
    pinch_lu_solve(vs->freedoms, l->s_lu, l->pivot, l->column, x);
    for (int i = 0; i < vs->freedoms; i++) x[i] += l->p[i];
}

static bool allocate(pinch_arena *arena, step_lcp *l)
{
    size_t n = (size_t)l->vs->freedoms, size = (size_t)l->size;
    l->s_lu = PINCH_ARENA_ARRAY(arena, double, n *n);
    l->scratch = PINCH_ARENA_ARRAY(arena, double, n);
    l->pivot = PINCH_ARENA_ARRAY(arena, int, n);
    l->p = PINCH_ARENA_ARRAY(arena, double, n);
    l->column = PINCH_ARENA_ARRAY(arena, double, n);
    l->m = PINCH_ARENA_ARRAY(arena, double, size *size + 1);
    l->q = PINCH_ARENA_ARRAY(arena, double, 3 * size + 1);
    if (arena->failed) return false;
    memset(l->column, 0, n * sizeof(double));
    memset(l->m, 0, size * size * sizeof(double));
    memset(l->q, 0, size * sizeof(double));
    return true;
}

/* Scales rows and columns by the root of each diagonal entry, so that M's diagonal is of order one, and forces by the
 * largest trial force. */
static void scale(step_lcp *l, double *unit)
{
    size_t n = (size_t)l->size;
    for (size_t i = 0; i < n; i++) {
        double d = fabs(l->m[i * n + i]);
        unit[i] = d > 0 ? 1 / sqrt(d) : 1;
    }
    for (size_t i = 0; i < n; i++) {
        l->q[i] *= unit[i];
        for (size_t j = 0; j < n; j++) l->m[i * n + j] *= unit[i] * unit[j];
    }
    double largest = 0;
    for (size_t i = 0; i < n; i++) largest = fmax(largest, fabs(l->q[i]));
    if (!(largest > 0)) return;
    for (size_t i = 0; i < n; i++) {
        l->q[i] /= largest;
        unit[i] *= largest;
    }
}

pinch_status pinch_velocity_lcp_solve(pinch_arena *arena, pinch_velocity_system *vs,
                                      const pinch_solver_settings *settings, pinch_solver_result *result)
{
    if (vs->unknowns != vs->freedoms || vs->has_drive) return PINCH_UNSUPPORTED;
    step_lcp l = {.vs = vs};
    l.of = PINCH_ARENA_ARRAY(arena, places, vs->element_count + 1);
    if (arena->failed) return PINCH_OUT_OF_MEMORY;
    l.size = count_unknowns(vs, l.of);
    if (!allocate(arena, &l)) return PINCH_OUT_OF_MEMORY;
    memset(result, 0, sizeof *result);
    result->status = PINCH_SOLVE_DIVERGED;
    if (!factor_inertia(&l)) return PINCH_OK;

    double *z = l.q + l.size, *unit = z + l.size;
    if (l.size > 0) {
        rows_of_motion(&l, l.p, true, l.q, 1);
        for (int e = 0; e < vs->element_count; e++)
            if (l.of[e].normal >= 0) contact_columns(&l, e);
        scale(&l, unit);
        pinch_lcp_workspace *workspace;
        pinch_status status = pinch_lcp_workspace_create(l.size, &workspace);
        if (status != PINCH_OK) return status;
        pinch_lcp lcp = {.size = l.size, .m = l.m, .q = l.q};
        double *w = PINCH_ARENA_ARRAY(arena, double, l.size);
        memset(z, 0, sizeof(double) * (size_t)l.size);
        if (!arena->failed) status = pinch_lcp_solve(&lcp, settings, workspace, z, w, result);
        pinch_lcp_workspace_destroy(workspace);
        if (arena->failed) return PINCH_OUT_OF_MEMORY;
        if (status != PINCH_OK) return status;
        for (int i = 0; i < l.size; i++) z[i] *= unit[i];
    } else {
        result->status = PINCH_SOLVE_CONVERGED;
    }
    if (result->status == PINCH_SOLVE_CONVERGED) recover(&l, z, vs->x);
    return PINCH_OK;
}
