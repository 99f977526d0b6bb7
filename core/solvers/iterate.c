/* The point that the methods for non-smooth systems work on. */
#include "solvers/methods.h"

#include "support/dense.h"

#include <math.h>

double pinch_iterate_evaluate_trial(pinch_iterate *it)
{
    it->system->residual(it->system->self, it->x_trial, it->f_trial);
    return pinch_norm(it->f_trial, it->system->size);
}

void pinch_iterate_accept(pinch_iterate *it, double norm)
{
    double *x = it->x, *f = it->f;
    it->x = it->x_trial;
    it->f = it->f_trial;
    it->x_trial = x;
    it->f_trial = f;
    it->norm = norm;
    it->rate = INFINITY;
}

static double row_norm2(const pinch_system *system, int row)
{
    if (system->row_norm2) return system->row_norm2(system->self, row);
    pinch_row v = system->row(system->self, row);
    double sum = 0.0;
    for (int s = 0; s < v.count; s++)
        for (int j = 0; j < v.segments[s].length; j++) sum += v.segments[s].values[j] * v.segments[s].values[j];
    return sum;
}

void pinch_row_norms2(const pinch_system *system, double *norm2)
{
    if (system->row_norms2)
        system->row_norms2(system->self, norm2);
    else
        for (int i = 0; i < system->size; i++) norm2[i] = row_norm2(system, i);
}

void pinch_row_add(const pinch_system *system, int row, double step, double *x)
{
    if (system->add_row) {
        system->add_row(system->self, row, step, x);
        return;
    }
    pinch_row v = system->row(system->self, row);
    for (int s = 0; s < v.count; s++) {
        double *xs = x + v.segments[s].start;
        for (int j = 0; j < v.segments[s].length; j++) xs[j] += step * v.segments[s].values[j];
    }
}
