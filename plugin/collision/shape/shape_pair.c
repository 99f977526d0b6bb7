#include "shape_pair.h"

#include "support/vec3.h"

double pinch_pair_inner_ball(const pinch_shape_pair *pair, double centre[3])
{
    double a[3], b[3], x[3], radius_a = pinch_inner_ball(pair->a, a), radius_b = pinch_inner_ball(pair->b, b);
    pinch_pair_point_to_a(pair, b, x);
    pinch_slide_inner_ball(pair->a, x, radius_a, a);
    for (int i = 0; i < 3; i++) centre[i] = a[i] - pair->p[i];
    pinch_pair_rotate_back(pair, centre, x);
    pinch_slide_inner_ball(pair->b, x, radius_b, b);
    pinch_pair_rotate(pair, b, centre);
    for (int i = 0; i < 3; i++) centre[i] += pair->p[i] - a[i];
    return radius_a + radius_b;
}

bool pinch_is_deeper_beyond(const pinch_shape_pair *pair, const double n[3], double overlap, double cosine, double sine)
{
    double P[3], rho = pinch_pair_inner_ball(pair, P), back = -pinch_v3_dot(n, P), P2 = pinch_v3_dot(P, P);
    double over = rho - overlap, aside = sqrt(P2 > back * back ? P2 - back * back : 0);
    if (over >= 0 && over * over >= P2) return true;
    return sine * back >= cosine * aside && over >= cosine * back + sine * aside;
}

void pinch_pair_support_a(const pinch_shape_pair *pair, const double n[3], double a[3])
{
    const double d[3] = {-n[0], -n[1], -n[2]};
    pinch_support_point(pair->a, d, a);
}

void pinch_pair_support_b(const pinch_shape_pair *pair, const double n[3], double b[3])
{
    double d[3], local[3];
    pinch_pair_rotate_back(pair, n, d);
    pinch_support_point(pair->b, d, local);
    pinch_pair_point_to_a(pair, local, b);
}

double pinch_pair_overlap(const pinch_shape_pair *pair, const double n[3])
{
    double d[3];
    const double back[3] = {-n[0], -n[1], -n[2]};
    pinch_pair_rotate_back(pair, n, d);
    return pinch_support_value(pair->a, back) + pinch_support_value(pair->b, d) + pinch_v3_dot(n, pair->p);
}

/* A sum of rounded numbers never falls where one of them grows, so a vertex that is no farther than the farthest one
 * makes the overlap no larger, as it is computed. */
bool pinch_pair_may_overlap_less(const pinch_shape_pair *pair, const double n[3], double limit)
{
    const double back[3] = {-n[0], -n[1], -n[2]};
    double d[3];
    pinch_pair_rotate_back(pair, n, d);
    double least =
        pinch_support_at_least(pair->a, back) + pinch_support_at_least(pair->b, d) + pinch_v3_dot(n, pair->p);
    return !(least >= limit);
}

void pinch_pair_hessian(const pinch_shape_pair *pair, const double n[3], double H[9])
{
    const double back[3] = {-n[0], -n[1], -n[2]};
    double d[3], HB[9];
    pinch_support_hessian(pair->a, back, H);
    if (pinch_is_polytope(pair->b)) return;
    pinch_pair_rotate_back(pair, n, d);
    pinch_support_hessian(pair->b, d, HB);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 9; k++) H[3 * i + j] += pair->R[3 * i + k / 3] * HB[k] * pair->R[3 * j + k % 3];
}

void pinch_pair_of(const pinch_posed_body *a, const pinch_shape *shape_a, const pinch_posed_body *b,
                   const pinch_shape *shape_b, pinch_shape_pair *pair)
{
    double from[3];
    pair->a = shape_a;
    pair->b = shape_b;
    pinch_v3_sub(b->position, a->position, from);
    for (int i = 0; i < 3; i++) {
        pair->p[i] = a->R[i] * from[0] + a->R[3 + i] * from[1] + a->R[6 + i] * from[2];
        for (int j = 0; j < 3; j++)
            pair->R[3 * i + j] = a->R[i] * b->R[j] + a->R[3 + i] * b->R[3 + j] + a->R[6 + i] * b->R[6 + j];
    }
}
