/* How much friction and how much load are in reserve: bisection on the question whether the grasp still holds. */
#include "statics/flow.h"
#include "statics/workspace.h"

#include <math.h>

static const double PRECISION = 1e-6; /* relative, of the factors found */

typedef struct question {
    pinch_static_model model;
    const pinch_statics_settings *settings;
} question;

static bool holds(question *q, double friction, double load)
{
    double u[6] = {0}, fraction, escape[6];
    pinch_solver_result uncounted = {0};
    q->model.friction_factor = friction;
    return pinch_static_search(&q->model, q->settings, load, false, u, &fraction, escape, &uncounted) ==
           PINCH_FLOW_SETTLED;
}

static bool holds_at(question *q, bool is_load, double factor)
{
    return is_load ? holds(q, 1.0, factor) : holds(q, factor, 1.0);
}

/* Between a factor that holds and one that does not, returns the last that was seen to hold. */
static double bisect(question *q, bool is_load, double good, double bad)
{
    for (int i = 0; i < 200 && fabs(good - bad) > PRECISION * fmax(good, bad); i++) {
        double middle = 0.5 * (good + bad);
        if (holds_at(q, is_load, middle))
            good = middle;
        else
            bad = middle;
    }
    return good;
}

static double find_smallest_friction(question *q, bool held)
{
    const double most = 1000.0;
    bool frictional = false;
    for (int c = 0; c < q->model.count; c++)
        if (q->model.contacts[c].axis[0] > 0.0 || q->model.contacts[c].axis[2] > 0.0) frictional = true;
    if (!frictional) return NAN;
    if (held) return holds_at(q, false, 0.0) ? 0.0 : bisect(q, false, 1.0, 0.0);
    for (double factor = 2.0; factor < 2.0 * most; factor *= 2.0)
        if (holds_at(q, false, fmin(factor, most))) return bisect(q, false, fmin(factor, most), 0.5 * factor);
    return NAN;
}

static double find_largest_load(question *q, bool held)
{
    const double most = 1e6;
    if (!held) return holds_at(q, true, 0.0) ? bisect(q, true, 0.0, 1.0) : NAN;
    double good = 1.0;
    while (good < most) {
        double next = fmin(2.0 * good, most);
        if (!holds_at(q, true, next)) return bisect(q, true, good, next);
        good = next;
    }
    return INFINITY;
}

pinch_status pinch_statics_limits(pinch_statics *statics, const pinch_grasp *grasp,
                                  const pinch_statics_settings *settings, double *smallest_friction,
                                  double *largest_load_factor)
{
    *smallest_friction = *largest_load_factor = NAN;
    pinch_status status = pinch_static_check(statics, grasp, settings);
    if (status != PINCH_OK) return status;
    if (!pinch_static_uses_displacements(settings)) return PINCH_UNSUPPORTED;
    question q = {.settings = settings};
    pinch_static_model_build(&q.model, statics->contacts, grasp, settings, false);
    bool held = holds(&q, 1.0, 1.0);
    *smallest_friction = find_smallest_friction(&q, held);
    *largest_load_factor = find_largest_load(&q, held);
    return PINCH_OK;
}
