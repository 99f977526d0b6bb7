/*
 * Rows along the rate of one joint, where that rate is an unknown: servos, dampers, dry friction and stops. Each acts
 * on its own unknown alone, so that it is a number where other elements have vectors.
 */
#include "velocity/velocity_system.h"

#include "support/extremes.h"

#include <math.h>

/*
 * Is a row inside its bounds, as far as factors depend on it? Where a joint has come to rest at the limit of its
 * friction, rounding alone says on which side of it the trial is. There the multiplier counts as being at its bound, of
 * which F tells no difference: factors then fit from step to step, and friction does not hold once more what other rows
 * hold already.
 */
static inline bool is_inside(const pinch_velocity_system *vs, const pinch_rate_row *row)
{
    static const double ROUNDING = 3e-15; /* in units of F */
    double margin = row->multiplier >= 0 ? ROUNDING * vs->scale : 0;
    return row->trial - row->low > margin && row->high - row->trial > margin;
}

/* How much the rate changes by forces, times the sign of the row. */
static inline double change_of(const pinch_rate_row *row, const double *x)
{
    return row->g * x[row->unknown];
}

void pinch_rate_row_make(const pinch_joint_row *from, double step, double w0, int unknown, int multiplier,
                         pinch_rate_row *row)
{
    row->unknown = unknown;
    row->multiplier = -1;
    row->low = from->low;
    row->high = from->high;
    row->trial = from->force;
    double asked = from->rhs - w0; /* may be so much smaller than either that a force of w alone is rounding */
    if (from->cfm > 0) {
        row->a = asked / from->cfm;
        row->gain = 1 / from->cfm;
        return;
    }
    /* its row has the length |g| */
    double sigma = fabs(row->g);
    row->multiplier = multiplier;
    row->a = asked / sigma;
    row->gain = sigma;
    row->low *= step * sigma;
    row->high *= step * sigma;
    row->g /= sigma;
}

/* Evaluates a row at x, and returns its impulse there. */
static inline double evaluate(pinch_rate_row *row, double step, const double *x)
{
    double change = change_of(row, x);
    if (row->multiplier >= 0) {
        row->trial = x[row->multiplier] - (change - row->a);
        return x[row->multiplier];
    }
    row->trial = row->a - row->gain * change;
    return step * pinch_clamp(row->trial, row->low, row->high);
}

void pinch_rates_evaluate(pinch_velocity_system *vs, const double *x)
{
    for (int k = 0; k < vs->rate_count; k++) (void)evaluate(&vs->rates[k], vs->step, x);
}

void pinch_rates_residual(pinch_velocity_system *vs, const double *x, double *f)
{
    for (int k = 0; k < vs->rate_count; k++) {
        pinch_rate_row *row = &vs->rates[k];
        double impulse = evaluate(row, vs->step, x);
        f[row->unknown] -= row->g * impulse;
        if (row->multiplier >= 0) f[row->multiplier] = impulse - pinch_clamp(row->trial, row->low, row->high);
    }
}

double pinch_rates_residual_row(pinch_velocity_system *vs, const double *x, int unknown)
{
    double f = 0;
    for (int k = 0; k < vs->rate_count; k++) {
        pinch_rate_row *row = &vs->rates[k];
        if (row->unknown != unknown && row->multiplier != unknown) continue;
        double impulse = evaluate(row, vs->step, x);
        if (row->unknown == unknown)
            f -= row->g * impulse;
        else
            f += impulse - pinch_clamp(row->trial, row->low, row->high);
    }
    return f;
}

/* The impulse at the point last evaluated, and at first that of the force that the row had. */
static inline double impulse_of(const pinch_velocity_system *vs, const pinch_rate_row *row, const double *x)
{
    return row->multiplier >= 0 ? x[row->multiplier] : vs->step * pinch_clamp(row->trial, row->low, row->high);
}

void pinch_rates_add_impulses(const pinch_velocity_system *vs, const double *x, double *f)
{
    for (int k = 0; k < vs->rate_count; k++)
        f[vs->rates[k].unknown] += vs->rates[k].g * impulse_of(vs, &vs->rates[k], x);
}

void pinch_rates_add_size(const pinch_velocity_system *vs, const double *x, double *size)
{
    for (int k = 0; k < vs->rate_count; k++)
        size[vs->rates[k].unknown] += fabs(vs->rates[k].g * impulse_of(vs, &vs->rates[k], x));
}

void pinch_rates_add_jacobian(const pinch_velocity_system *vs, bool sticking, double *jacobian)
{
    size_t n = (size_t)vs->unknowns;
    for (int k = 0; k < vs->rate_count; k++) {
        const pinch_rate_row *row = &vs->rates[k];
        size_t q = (size_t)row->unknown, y = (size_t)row->multiplier;
        bool inside = is_inside(vs, row);
        if (row->multiplier < 0) {
            if (inside || sticking) jacobian[q * (n + 1)] += vs->step * row->gain * row->g * row->g;
            continue;
        }
        if (sticking || !inside) jacobian[y * (n + 1)] = 1;
        if (sticking) continue;
        jacobian[q * n + y] -= row->g;
        if (inside) jacobian[y * n + q] += row->g;
    }
}

unsigned char pinch_rate_row_state(const pinch_velocity_system *vs, const pinch_rate_row *row)
{
    return is_inside(vs, row) ? PINCH_VELOCITY_INSIDE : PINCH_VELOCITY_AT_BOUND;
}

/* A stop that is not reached has no force, not that of rounding: nothing else says how small that is. */
double pinch_rate_row_force(const pinch_velocity_system *vs, const pinch_rate_row *row)
{
    double force = pinch_clamp(row->trial, row->low, row->high);
    if (row->multiplier < 0) return force;
    return is_inside(vs, row) || force != 0 ? vs->x[row->multiplier] / (vs->step * row->gain) : 0;
}
