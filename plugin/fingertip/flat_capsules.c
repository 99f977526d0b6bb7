#include "flat_capsules.h"

#include "side_and_rim.h"
#include "support/vec3.h"

/* The ends with a rim, seen along the axis: both of a cylinder, a flat capsule's low one. */
static bool has_rim(const pinch_core *core, int end)
{
    return core->kind == PINCH_CORE_CYLINDER || end < 0;
}

void pinch_offer_flat_capsules(const pinch_core_pair *pair, pinch_contact_normal *best)
{
    const double w[3] = {pair->R[2], pair->R[5], pair->R[8]}, z[3] = {0, 0, 1}, back[3] = {-w[0], -w[1], -w[2]};
    const pinch_core *A = pair->a, *B = pair->b;
    double of_b[3], of_a[3], n[3], overlap;
    pinch_v3_copy(of_b, pair->p); /* from A's axis to B's middle */
    pinch_v3_add_scaled(of_b, B->middle, w);
    pinch_v3_copy(of_a, pair->p); /* from A's middle to B's axis */
    pinch_v3_add_scaled(of_a, -A->middle, z);
    for (int end = -1; end <= 1; end += 2) {
        const double cap[3] = {0, 0, -end};
        if (has_rim(A, end)) pinch_offer_normal(pair, cap, best);
        if (has_rim(B, end)) pinch_offer_normal(pair, end > 0 ? w : back, best);
        if (has_rim(B, end) && pinch_side_and_rim(of_b, z, B, w, end, n, &overlap)) pinch_offer_normal(pair, n, best);
        /* A's part is the one along -n */
        if (has_rim(A, end) && pinch_side_and_rim(of_a, w, A, z, -end, n, &overlap)) pinch_offer_normal(pair, n, best);
        pinch_v3_cross(z, w, n);
        double length = end * pinch_v3_norm(n);
        if (!(length * end > 1e-8)) continue;
        pinch_v3_scale(n, 1 / length);
        pinch_offer_normal(pair, n, best);
    }
}
