#include "solvers/methods.h"

#include <math.h>

/* Sufficient decrease and shortest step of the line search. Shorter steps than 2^-6 gain so little on the piecewise
 * smooth systems solved here that a Kaczmarz sweep or a gradient step is the better use of an evaluation. */
static const double ARMIJO = 1e-4;
enum { MAX_HALVINGS = 6 };
static const double NEARLY_RIGHT = 0.1;
/* A step pays that leaves at most this part of ||F||. Without a goal little is enough: where the norm is rounding,
 * small rows may not be. */
static const double PAYS = 0.5, PAYS_WITHOUT_GOAL = 0.99;

/* ||F|| at the length t along -direction. */
static double norm_at(pinch_iterate *it, double t)
{
    for (int i = 0; i < it->system->size; i++) it->x_trial[i] = it->x[i] - t * it->direction[i];
    return pinch_iterate_evaluate_trial(it);
}

/* Backtracks along -direction from the step length `t` on, where the trial point is and has this norm; true when a
 * point was accepted. */
static bool line_search(pinch_iterate *it, double t, double norm)
{
    for (int halvings = 0; halvings <= MAX_HALVINGS; halvings++, t *= 0.5) {
        if (halvings > 0) norm = norm_at(it, t);
        /* a NaN compares false */
        if (norm <= (1.0 - ARMIJO * fmin(t, 1.0)) * it->norm) {
            pinch_iterate_accept(it, norm);
            return true;
        }
    }
    return false;
}

static bool sharpen(const pinch_system *system)
{
    return system->sharpen && system->sharpen(system->self);
}

/* Goes to the trial point of a full step, and writes its norm. Returns false where V is singular. */
static bool try_full_step(pinch_iterate *it, double *norm)
{
    const pinch_system *system = it->system;
    if (!system->solve(system->self, it->f, it->direction)) return false;
    *norm = norm_at(it, 1.0);
    return true;
}

/* Accepts a full step that reduces ||F|| to `factor` times what it was or less. */
static bool accept_full_step(pinch_iterate *it, double norm, double factor)
{
    double before = it->norm;
    if (!(norm <= factor * before)) return false;
    pinch_iterate_accept(it, norm);
    it->rate = norm / before;
    return true;
}

static bool full_step(pinch_iterate *it, double factor)
{
    double norm;
    return try_full_step(it, &norm) && accept_full_step(it, norm, factor);
}

bool pinch_newton_step(pinch_iterate *it)
{
    const pinch_system *system = it->system;
    double norm;
    bool regular = try_full_step(it, &norm);
    /* a V that is only nearly right is good for steps that pay at once; nothing is searched along its direction */
    if (regular && system->sharpen && accept_full_step(it, norm, NEARLY_RIGHT)) return true;
    if (sharpen(system)) regular = try_full_step(it, &norm);
    return regular && line_search(it, 1.0, norm);
}

/*
 * merit = ||F||^2 / 2 has the gradient g = V^T F = sum_i F_i V_i, and along -g the linearized merit is least at
 * t = ||g||^2 / ||V g||^2: the line search starts there.
 */
bool pinch_gradient_step(pinch_iterate *it)
{
    const pinch_system *system = it->system;
    double *g = it->direction;
    for (int j = 0; j < system->size; j++) g[j] = 0.0;
    for (int i = 0; i < system->size; i++) pinch_row_add(system, i, it->f[i], g);

    double g_norm2 = 0.0, vg_norm2 = 0.0;
    for (int j = 0; j < system->size; j++) g_norm2 += g[j] * g[j];
    for (int i = 0; i < system->size; i++) {
        pinch_row row = system->row(system->self, i);
        double dot = 0.0;
        for (int s = 0; s < row.count; s++)
            for (int j = 0; j < row.segments[s].length; j++)
                dot += row.segments[s].values[j] * g[row.segments[s].start + j];
        vg_norm2 += dot * dot;
    }
    if (!(g_norm2 > 0.0) || !(vg_norm2 > 0.0) || !isfinite(g_norm2 / vg_norm2)) return false;
    double t = g_norm2 / vg_norm2;
    return line_search(it, t, norm_at(it, t));
}

/* Takes a step with the V of the last one, which leaves about as small a part of ||F|| again, where that promises to
 * reach the goal (the chord method). */
static bool chord_step(pinch_iterate *it, double goal)
{
    return it->system->sharpen && it->rate * it->norm <= goal && full_step(it, PAYS);
}

int pinch_newton_polish(pinch_iterate *it, double goal, int limit)
{
    const pinch_system *system = it->system;
    double pays = goal > 0 ? PAYS : PAYS_WITHOUT_GOAL;
    int steps = 0;
    while (steps < limit && it->norm > goal) {
        if (!chord_step(it, goal)) {
            system->linearize(system->self, it->x);
            if (!full_step(it, pays) && !(sharpen(system) && full_step(it, pays))) break;
        }
        steps++;
    }
    return steps;
}
