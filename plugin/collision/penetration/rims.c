/*
 * Where two rims meet the normal is free in both directions. Newton's method goes down from the faces' and sides'
 * normals next to that region, and from those parts of it that a bound does not exclude.
 */
#include "rim_search.h"

#include "rim_bounds.h"
#include "rim_certain.h"
#include "support/vec3.h"

#include <float.h>

/* How far `d`, seen from a cylinder's middle, lies beyond what is as far along n (unit) as any of its points: the cap,
 * the line along its side, or a single point of a rim (which nothing lies beyond). In the axes of both vectors. */
static bool beyond_part(const pinch_core *core, const double *axis, const double *n, const double *d, double *e)
{
    static const double FLAT = 1e-9, ON_AXIS = 1e-13; /* sine, 1 less the cosine */
    double up = pinch_v3_dot(axis, n), height = pinch_v3_dot(axis, d);
    if (fabs(up) < FLAT) {
        double over = fabs(height) - core->half[2];
        if (!pinch_core_has_rim(core, height)) return false;
        for (int i = 0; i < 3; i++) e[i] = over > 0 ? copysign(over, height) * axis[i] : 0;
        return over > 0;
    }
    for (int i = 0; i < 3; i++) e[i] = d[i] - height * axis[i];
    double rho = pinch_v3_norm(e);
    if (1 - fabs(up) > ON_AXIS || !(rho > core->radius)) return false;
    pinch_v3_scale(e, 1 - core->radius / rho);
    return true;
}

/* The ends of a side that lies on a cap, nearly, are as far along its normal: the one nearer to the cap's axis decides.
 * `x`: one end, `length` from the other along `along`; `centre`: of the cap, whose axis is `axis`. */
static void take_nearer_end(double *x, const double *along, double length, const double *centre, const double *axis)
{
    double to[3], other[3];
    pinch_v3_sub(x, centre, to);
    pinch_v3_copy(other, to);
    pinch_v3_add_scaled(other, length, along);
    pinch_v3_make_perpendicular(to, axis);
    pinch_v3_make_perpendicular(other, axis);
    if (pinch_v3_dot(other, other) < pinch_v3_dot(to, to)) pinch_v3_add_scaled(x, length, along);
}

bool pinch_rims_from(const pinch_rim_frame *frame, const pinch_contact_normal *start, pinch_contact_normal *best)
{
    static const double FARTHEST = 0.1, LYING = 1e-4, ON_AXIS = 1e-13; /* rad; sine; 1 less the cosine */
    const pinch_core_pair *pair = frame->pair;
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]}, z[3] = {0, 0, 1}, origin[3] = {0, 0, 0};
    const pinch_core *A = pair->a, *B = pair->b;
    double a[3], b[3], d[3], e[3], n[3], up = pinch_v3_dot(w, start->normal), other = up * up, z_up = start->normal[2];
    double radius = B->radius;
    pinch_pair_support_a(pair, start->normal, a);
    pinch_pair_support_b(pair, start->normal, b);
    bool on_b = 1 - fabs(up) < ON_AXIS && fabs(z_up) < LYING && A->kind == PINCH_CORE_CYLINDER;
    bool on_a = 1 - fabs(z_up) < ON_AXIS && fabs(up) < LYING && B->kind == PINCH_CORE_CYLINDER;
    if (on_b) take_nearer_end(a, z, -2 * copysign(A->half[2], a[2]), pair->p, w);
    if (on_a) take_nearer_end(b, w, -2 * copysign(B->half[2], up), origin, z);
    b[2] -= A->middle;
    if (!on_b && beyond_part(A, z, start->normal, b, e)) {
        pinch_v3_scale(e, -1);
    } else {
        pinch_v3_sub(a, pair->p, d);
        pinch_v3_add_scaled(d, -B->middle, w);
        if (on_a || !beyond_part(B, w, start->normal, d, e)) return true;
        other = z_up * z_up;
        radius = A->radius;
    }
    /* the overlap falls by e, and the other rim, turning around, takes back radius/sine per angle */
    double length = pinch_v3_norm(e), into = fmin(FARTHEST, length * sqrt(fmax(1 - other, 1e-12)) / radius);
    pinch_v3_copy(d, start->normal);
    pinch_v3_add_scaled(d, into / length, e);
    for (int i = 0; i < 3; i++) n[i] = pinch_v3_dot(frame->axis[i], d);
    pinch_v3_scale(n, 1 / pinch_v3_norm(n));
    const int side[2] = {n[2] < 0 ? -1 : 1, pinch_v3_dot(w, d) < 0 ? -1 : 1};
    if (!pinch_core_has_rim(pair->a, -side[0]) || !pinch_core_has_rim(pair->b, side[1])) return false;
    return pinch_descend_on_rims(frame, side, NULL, n, best);
}

/* A rim that lies beyond a cap's border by little leaves a way down from the cap's normal too narrow to be met. `left`
 * has a bit for every cap that has been. */
static void leave_caps(const pinch_rim_frame *frame, const pinch_rim_cell *cell, const pinch_contact_normal *from,
                       unsigned *left, pinch_contact_normal *best)
{
    static const double LITTLE = 1, SAME = 1 - 1e-12;
    const double *R = frame->pair->R;
    pinch_rim_cap caps[2];
    if (!pinch_rim_cell_at_cap(cell, 0) && !pinch_rim_cell_at_cap(cell, 1)) return;
    pinch_rim_caps(frame, cell->side, caps);
    for (int which = 0; which < 2; which++) {
        double side = cell->side[which], radius = which ? frame->pair->b->radius : frame->pair->a->radius;
        unsigned bit = 1U << (2 * which + (side > 0));
        if (!pinch_rim_cell_at_cap(cell, which) || (*left & bit) || caps[which].inside > 0) continue;
        if (caps[which].inside < -LITTLE * radius) continue;
        pinch_contact_normal cap = {.normal = {0, 0, side}};
        for (int i = 0; i < 3 && which; i++) cap.normal[i] = side * R[3 * i + 2];
        *left |= bit;
        if (pinch_v3_dot(cap.normal, from->normal) < SAME) (void)pinch_rims_from(frame, &cap, best);
    }
}

void pinch_search_rims(const pinch_rim_frame *frame, const pinch_contact_normal *from, pinch_contact_normal *best)
{
    pinch_rim_cell cells[PINCH_RIM_CELLS];
    int count = pinch_rim_cells(frame, best->overlap, cells);
    unsigned left = 0;
    while (count > 0) {
        int least = 0;
        double known[3];
        for (int k = 1; k < count; k++)
            if (cells[k].bound < cells[least].bound) least = k;
        if (!(cells[least].bound < best->overlap)) return;
        leave_caps(frame, &cells[least], from, &left, best);
        for (int i = 0; i < 3; i++) known[i] = pinch_v3_dot(frame->axis[i], best->normal);
        bool on_rims = best->overlap < from->overlap && pinch_rims_are_level(frame->pair, best);
        (void)pinch_descend_on_rims(frame, cells[least].side, on_rims ? known : NULL, cells[least].n, best);
        cells[least] = cells[--count];
    }
}
