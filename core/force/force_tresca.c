/*
 * Where the limits of friction are given (Tresca's friction), the forces of contacts derive from a potential, and a
 * step is its minimum, equation (73) of core/README.md. It is strictly convex, so that descent finds it from any start.
 * The limits follow the normal forces every few steps, which converges to the answer of Coulomb's law, but by a
 * constant factor only. So it ends where Newton's method in the forces, which knows that the limits change, is likely
 * to converge.
 */
#include "force/force_rows.h"
#include "force/force_system.h"

#include <math.h>
#include <string.h>

enum { MOST_STEPS = 40, MOST_WITH_SAME_LIMITS = 4 };
/* Limits follow before that many steps where the gradient has fallen to this part; it is done where it is this part of
 * the scale with new limits; it has served where it is this part at its end. */
static const double FALLEN = 0.3, DONE = 1e-3, SERVED = 5e-2;
/* How exactly systems are solved by iteration; the part of what is left of the budget that it may take. */
static const double EXACTNESS = 1e-6, PART_OF_BUDGET = 0.5;

/* Until its end, an element's velocity w stands in the place of its force, and the change of that in a step in the
 * place of the force's change. */
static const pinch_force_value VELOCITY = PINCH_FORCE_R, VELOCITY_CHANGE = PINCH_FORCE_CHANGE;

bool pinch_force_may_give_limits(const pinch_force_system *s, const pinch_solver_settings *settings, int steps)
{
    double each = s->work / (steps > 0 ? steps : 1);
    bool affords = MOST_STEPS * each <= PART_OF_BUDGET * (s->budget - s->work);
    return s->multiplier_count == 0 && (affords || settings->sweeps > 0);
}

/* The semi-axis i of the limit surface at the normal force that limits follow; friction may be infinite. */
static double limit_of(const pinch_force_element *e, int i)
{
    return e->law->limit[i] + (e->given_normal > 0 ? e->law->friction[i] * e->given_normal : 0);
}

/* Projects the trial force onto the limit surface as it is given, for contacts of any law. */
static void project(const pinch_force_element *e, const double *trial, const double *compliance, double *r)
{
    pinch_contact_law given = *e->law;
    double stiffness[PINCH_CONTACT_ROWS_MAX];
    for (int i = 0; i < e->rows; i++) stiffness[i] = 1 / compliance[i];
    for (int i = 0; i + 1 < e->rows; i++) {
        given.limit[i] = limit_of(e, i);
        given.friction[i] = 0;
    }
    (void)pinch_contact_law_project(&given, stiffness, trial, r, NULL);
}

/*
 * The force of an element at w, and if wanted a conductance. Along the normal this is -dr/dw. Along the others it is
 * the secant r_i / (s_i C_i) of what slips, s being the trial force: the paraboloid of this curvature touches the
 * potential at w and lies above it everywhere else, as (8) minimizes it over l,
 *
 *     phi = min over l >= 0 of 1/2 sum C_i s_i^2 / (1 + l c_i) + l/2.
 *
 * With the derivative, which is zero along the slip, steps end where the next contact begins to stick, after a
 * hundredth of their length.
 */
static void force_at(const pinch_force_element *e, const double *w, double *r, double *conductance)
{
    const double *compliance = pinch_force_values(e, PINCH_FORCE_COMPLIANCE), *b = pinch_force_values(e, PINCH_FORCE_B);
    double trial[PINCH_CONTACT_ROWS_MAX] = {0};
    int rows = e->rows;
    for (int i = 0; i < rows; i++) trial[i] = (b[i] - w[i]) / compliance[i];
    bool between = pinch_contact_law_clamp_normal(e->law, trial[0], r);
    if (rows == PINCH_FORCE_CONTACT && pinch_force_has_disc(e)) {
        pinch_friction_rows f = {rows, trial, r, NULL, 0};
        (void)pinch_friction_disc_project(f, limit_of(e, 0), 0, 0);
    } else if (rows > 1)
        project(e, trial, compliance, r);
    if (!conductance) return;
    memset(conductance, 0, sizeof *conductance * (size_t)(rows * rows));
    conductance[0] = between ? 1 / compliance[0] : 0;
    for (int i = 1; i < rows; i++) conductance[i * rows + i] = (trial[i] == r[i] ? 1 : r[i] / trial[i]) / compliance[i];
}

/* Sets conductances, and adds the negative gradient of the potential to `rhs`, which is zero. Returns its length. */
static double linearize(pinch_force_system *s, double *rhs)
{
    double sum = 0;
    for (int k = 0; k < s->element_count; k++) {
        pinch_force_element *e = &s->elements[k];
        double r[PINCH_CONTACT_ROWS_MAX], *conductance = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
        force_at(e, pinch_force_values(e, VELOCITY), r, conductance);
        e->conducts = false;
        for (int i = 0; i < e->rows; i++) e->conducts = e->conducts || conductance[i * e->rows + i] != 0;
        pinch_force_add_impulse(e, s->step, r, rhs);
    }
    for (int i = 0; i < s->mobility->unknowns; i++) {
        rhs[i] -= s->q[i];
        sum += rhs[i] * rhs[i];
    }
    return sqrt(sum);
}

static void follow_limits(pinch_force_system *s)
{
    for (int k = 0; k < s->element_count; k++) {
        pinch_force_element *e = &s->elements[k];
        double r[PINCH_CONTACT_ROWS_MAX];
        force_at(e, pinch_force_values(e, VELOCITY), r, NULL);
        e->given_normal = r[0];
    }
}

/* dw = G dq */
static void find_changes(pinch_force_system *s, const double *dq)
{
    for (int k = 0; k < s->element_count; k++) {
        pinch_force_element *e = &s->elements[k];
        double *dw = pinch_force_values(e, VELOCITY_CHANGE);
        memset(dw, 0, sizeof *dw * (size_t)e->rows);
        for (int b = 0; b < 2; b++)
            pinch_force_rows_times(e->rows, e->block[b].size, e->block[b].g, dq + e->block[b].first, dw);
    }
}

/* The slope of the potential along the step, at the part t of it. */
static double slope_at(const pinch_force_system *s, const double *dq, double t)
{
    double slope = 0, work = 0;
    for (int i = 0; i < s->mobility->unknowns; i++) slope += (s->q[i] + t * dq[i]) * dq[i];
    for (int k = 0; k < s->element_count; k++) {
        const pinch_force_element *e = &s->elements[k];
        const double *w0 = pinch_force_values(e, VELOCITY), *dw = pinch_force_values(e, VELOCITY_CHANGE);
        double w[PINCH_CONTACT_ROWS_MAX], r[PINCH_CONTACT_ROWS_MAX];
        for (int i = 0; i < e->rows; i++) w[i] = w0[i] + t * dw[i];
        force_at(e, w, r, NULL);
        for (int i = 0; i < e->rows; i++) work += r[i] * dw[i];
    }
    return slope - s->step * work;
}

/*
 * Returns the part of a step at which the potential is least along it, as closely as a tenth of the slope at its start
 * tells. The slope grows along the step. Regula falsi finds its zero, but cuts off a tenth of what is left of the
 * interval at least.
 */
static double length_of_step(const pinch_force_system *s, const double *dq)
{
    enum { MOST_TRIES = 30 };
    static const double FLAT = 0.1, LEAST_CUT = 0.1;
    double low = 0, high = 1, t = 1;
    double low_slope = slope_at(s, dq, 0), high_slope = slope_at(s, dq, 1), flat = FLAT * -low_slope;
    if (high_slope <= flat) return 1;
    for (int try = 0; try < MOST_TRIES; try++) {
        double part = -low_slope / (high_slope - low_slope);
        t = low + (high - low) * fmin(fmax(part, LEAST_CUT), 1 - LEAST_CUT);
        double slope = slope_at(s, dq, t);
        if (fabs(slope) <= flat) break;
        *(slope < 0 ? &low : &high) = t;
        *(slope < 0 ? &low_slope : &high_slope) = slope;
    }
    return t;
}

static void take_step(pinch_force_system *s, const double *dq, double t)
{
    for (int i = 0; i < s->mobility->unknowns; i++) s->q[i] += t * dq[i];
    for (int k = 0; k < s->element_count; k++) {
        double *w = pinch_force_values(&s->elements[k], VELOCITY);
        const double *dw = pinch_force_values(&s->elements[k], VELOCITY_CHANGE);
        for (int i = 0; i < s->elements[k].rows; i++) w[i] += t * dw[i];
    }
}

/* Returns the length of the gradient at the end, as a part of the scale; INFINITY where steps could not be found. */
static double minimize(pinch_arena *arena, pinch_force_system *s, int limit, int *steps)
{
    double most_work = s->work + PART_OF_BUDGET * (s->budget - s->work), gradient = INFINITY, followed = INFINITY;
    for (int step = 0, since = 0; step < limit && !(s->work > most_work); step++, ++*steps) {
        double *dq = pinch_force_clear_rhs(arena, s);
        if (!dq) return INFINITY;
        gradient = linearize(s, dq) / s->scale;
        if (gradient <= FALLEN * followed || since == MOST_WITH_SAME_LIMITS) {
            follow_limits(s);
            followed = gradient = linearize(s, pinch_force_clear_rhs(arena, s)) / s->scale;
            since = 0;
            if (gradient <= DONE) return gradient;
        }
        if (!isfinite(gradient)) return INFINITY;
        if (pinch_force_solve_for_rhs(arena, s, EXACTNESS)) {
            find_changes(s, dq);
            take_step(s, dq, length_of_step(s, dq));
            since++;
        } else if (!pinch_force_stop_iterating(arena, s))
            return INFINITY;
    }
    return gradient;
}

bool pinch_force_tresca(pinch_arena *arena, pinch_force_system *s, int limit, int *steps)
{
    pinch_force_move(s);
    for (int k = 0; k < s->element_count; k++) {
        pinch_force_element *e = &s->elements[k];
        double *r = pinch_force_values(e, PINCH_FORCE_R);
        e->given_normal = r[0];
        pinch_force_element_velocity(e, s->q, r);
    }
    bool served = minimize(arena, s, limit < MOST_STEPS ? limit : MOST_STEPS, steps) <= SERVED;
    for (int k = 0; k < s->element_count; k++) {
        double r[PINCH_CONTACT_ROWS_MAX], *w = pinch_force_values(&s->elements[k], VELOCITY);
        force_at(&s->elements[k], w, r, NULL);
        memcpy(w, r, sizeof *r * (size_t)s->elements[k].rows);
    }
    return served;
}
