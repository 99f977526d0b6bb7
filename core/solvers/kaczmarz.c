#include "solvers/methods.h"

#include <math.h>
#include <string.h>

/*
 * The greedy threshold both methods share (Ai and Li 2025, Algorithm 1):
 *
 *     eps = 1/2 ( max_i (F_i^2 / ||V_i||^2) / ||F||^2 + 1 / ||V||_F^2 )
 *     U   = { i : F_i^2 >= eps ||F||^2 ||V_i||^2 }
 *
 * The mean of F_i^2 / ||V_i||^2 weighted by ||V_i||^2 is ||F||^2 / ||V||_F^2, so the largest is never below it and U is
 * never empty. Returns eps ||F||^2 and leaves ||V_i||^2 in row_norm2; NaN when every row vanishes.
 */
static double greedy_threshold(pinch_iterate *it)
{
    double largest = 0.0, frobenius2 = 0.0;
    pinch_row_norms2(it->system, it->row_norm2);
    for (int i = 0; i < it->system->size; i++) {
        double norm2 = it->row_norm2[i];
        if (norm2 == 0.0) continue;
        frobenius2 += norm2;
        double f2 = it->f[i] * it->f[i];
        if (f2 > largest * norm2) largest = f2 / norm2;
    }
    return 0.5 * (largest + it->norm * it->norm / frobenius2);
}

/* Rounding must not empty U: at equality the largest row may miss the threshold by its last bit. */
static bool is_candidate(const pinch_iterate *it, double threshold, int i)
{
    double f2 = it->f[i] * it->f[i];
    return it->row_norm2[i] > 0.0 && f2 >= threshold * it->row_norm2[i] * (1.0 - 1e-15);
}

/* x -= F_i(x) / ||V_i||^2 V_i with the frozen V_i. Never inlined: demos/bench/projection counts its instructions. */
__attribute__((noinline)) static void project_on_row(const pinch_iterate *it, int i, double *x)
{
    const pinch_system *system = it->system;
    double f = system->residual_row(system->self, x, i);
    pinch_row_add(system, i, -f / it->row_norm2[i], x);
}

int pinch_nsnmgk_sweep(pinch_iterate *it, double *norm)
{
    const pinch_system *system = it->system;
    double threshold = greedy_threshold(it);
    int projections = 0;
    memcpy(it->x_trial, it->x, (size_t)system->size * sizeof *it->x);
    for (int i = 0; i < system->size; i++) {
        if (!is_candidate(it, threshold, i)) continue;
        if (projections++ == 0) /* where F is known */
            pinch_row_add(system, i, -it->f[i] / it->row_norm2[i], it->x_trial);
        else
            project_on_row(it, i, it->x_trial);
    }
    *norm = projections > 0 ? pinch_iterate_evaluate_trial(it) : it->norm;
    return projections;
}

int pinch_nsngrk_draw(pinch_iterate *it, pinch_random *random, double *norm)
{
    const pinch_system *system = it->system;
    double threshold = greedy_threshold(it);
    double total = 0.0, *weight = it->direction; /* F_i^2 of the candidates, -1 of the others */
    for (int i = 0; i < system->size; i++) {
        weight[i] = is_candidate(it, threshold, i) ? it->f[i] * it->f[i] : -1.0;
        if (weight[i] >= 0.0) total += weight[i];
    }

    double mark = total * pinch_random_uniform(random);
    int drawn = -1;
    for (int i = 0; i < system->size; i++) {
        if (weight[i] < 0.0) continue;
        drawn = i;
        mark -= weight[i];
        if (mark < 0.0) break;
    }
    *norm = it->norm;
    if (drawn < 0) return 0;
    memcpy(it->x_trial, it->x, (size_t)system->size * sizeof *it->x);
    pinch_row_add(system, drawn, -it->f[drawn] / it->row_norm2[drawn], it->x_trial);
    *norm = pinch_iterate_evaluate_trial(it);
    return 1;
}
