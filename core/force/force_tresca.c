/*
 * Where the limits of friction are given (Tresca's friction), the forces of contacts derive from a potential, and a
 * step is its minimum, equation (73) of core/README.md. It is strictly convex, so that Newton's method finds it from
 * any start. The limits follow the normal forces after each step, which converges to the answer of Coulomb's law, but
 * by a constant factor only. So it ends where Newton's method in the forces, which knows that the limits change, is
 * likely to converge.
 */
#include "force/force_rows.h"
#include "force/force_system.h"

#include <math.h>
#include <string.h>

enum { MOST_STEPS = 40 };
/* The part of the scale at which it ends; how exactly systems are solved by iteration; the part of what is left of the
 * budget that it may take. */
static const double END = 1e-3, EXACTNESS = 1e-6, PART_OF_BUDGET = 0.5;

/* What a contact needs besides its element; the change of its velocity stands where that of the force does. */
typedef struct tresca_contact {
    double w[PINCH_FORCE_CONTACT];
    double limit; /* of friction, N */
} tresca_contact;

static bool applies(const pinch_force_system *s)
{
    if (s->multiplier_count > 0) return false;
    for (int k = 0; k < s->element_count; k++) {
        const pinch_force_element *e = &s->elements[k];
        if (e->rows != 1 && !pinch_force_has_disc(e)) return false;
    }
    return true;
}

static double limit_of(const pinch_contact_law *law, double normal)
{
    return normal > 0 ? law->limit[0] + law->friction[0] * normal : law->limit[0]; /* friction may be infinite */
}

/* The force of an element at w, and if wanted its conductance -dr/dw. */
static void force_at(const pinch_force_element *e, double limit, const double *w, double *r, double *conductance)
{
    const double *compliance = pinch_force_values(e, PINCH_FORCE_COMPLIANCE), *b = pinch_force_values(e, PINCH_FORCE_B);
    double trial[PINCH_FORCE_CONTACT] = {0};
    for (int i = 0; i < e->rows; i++) trial[i] = (b[i] - w[i]) / compliance[i];
    bool between = pinch_contact_law_clamp_normal(e->law, trial[0], r);
    if (conductance) {
        memset(conductance, 0, sizeof *conductance * (size_t)(e->rows * e->rows));
        conductance[0] = between ? 1 / compliance[0] : 0;
    }
    if (e->rows == 1) return;
    pinch_friction_rows f = {PINCH_FORCE_CONTACT, trial, r, conductance, 0};
    (void)pinch_friction_disc_project(f, limit, 0, 1 / compliance[1]);
}

/* Sets conductances at w, with the limits that the normal forces have there, and adds the negative gradient of the
 * potential to `rhs`, which is zero. Returns the gradient's length. */
static double linearize(pinch_force_system *s, tresca_contact *contacts, double *rhs)
{
    double sum = 0;
    for (int k = 0; k < s->element_count; k++) {
        pinch_force_element *e = &s->elements[k];
        tresca_contact *c = &contacts[k];
        double r[PINCH_FORCE_CONTACT], *conductance = pinch_force_values(e, PINCH_FORCE_CONDUCTANCE);
        force_at(e, c->limit, c->w, r, NULL);
        c->limit = limit_of(e->law, r[0]);
        force_at(e, c->limit, c->w, r, conductance);
        e->conducts = false;
        for (int i = 0; i < e->rows * e->rows; i++) e->conducts = e->conducts || conductance[i] != 0;
        pinch_force_add_impulse(e, s->step, r, rhs);
    }
    for (int i = 0; i < s->mobility->unknowns; i++) {
        rhs[i] -= s->q[i];
        sum += rhs[i] * rhs[i];
    }
    return sqrt(sum);
}

/* dw = G dq */
static void find_changes(pinch_force_system *s, const double *dq)
{
    for (int k = 0; k < s->element_count; k++) {
        pinch_force_element *e = &s->elements[k];
        double *dw = pinch_force_values(e, PINCH_FORCE_CHANGE);
        memset(dw, 0, sizeof *dw * (size_t)e->rows);
        for (int b = 0; b < 2; b++)
            pinch_force_rows_times(e->rows, e->block[b].size, e->block[b].g, dq + e->block[b].first, dw);
    }
}

/* The slope of the potential along the step, at the part t of it. */
static double slope_at(const pinch_force_system *s, const tresca_contact *contacts, const double *dq, double t)
{
    double slope = 0, work = 0;
    for (int i = 0; i < s->mobility->unknowns; i++) slope += (s->q[i] + t * dq[i]) * dq[i];
    for (int k = 0; k < s->element_count; k++) {
        const pinch_force_element *e = &s->elements[k];
        const double *dw = pinch_force_values(e, PINCH_FORCE_CHANGE);
        double w[PINCH_FORCE_CONTACT], r[PINCH_FORCE_CONTACT];
        for (int i = 0; i < e->rows; i++) w[i] = contacts[k].w[i] + t * dw[i];
        force_at(e, contacts[k].limit, w, r, NULL);
        for (int i = 0; i < e->rows; i++) work += r[i] * dw[i];
    }
    return slope - s->step * work;
}

/*
 * Returns the part of a step at which the potential is least along it, as closely as a tenth of the slope at its start
 * tells. The slope grows along the step. Regula falsi finds its zero, but never less than a tenth of what is left of
 * the interval is cut off.
 */
static double length_of_step(const pinch_force_system *s, const tresca_contact *contacts, const double *dq)
{
    enum { MOST_TRIES = 30 };
    static const double FLAT = 0.1, LEAST_CUT = 0.1;
    double low = 0, high = 1, t = 1;
    double low_slope = slope_at(s, contacts, dq, 0), high_slope = slope_at(s, contacts, dq, 1);
    double flat = FLAT * -low_slope;
    if (high_slope <= flat) return 1;
    for (int try = 0; try < MOST_TRIES; try++) {
        double part = -low_slope / (high_slope - low_slope);
        t = low + (high - low) * fmin(fmax(part, LEAST_CUT), 1 - LEAST_CUT);
        double slope = slope_at(s, contacts, dq, t);
        if (fabs(slope) <= flat) break;
        *(slope < 0 ? &low : &high) = t;
        *(slope < 0 ? &low_slope : &high_slope) = slope;
    }
    return t;
}

static void take_step(pinch_force_system *s, tresca_contact *contacts, const double *dq, double t)
{
    for (int i = 0; i < s->mobility->unknowns; i++) s->q[i] += t * dq[i];
    for (int k = 0; k < s->element_count; k++) {
        const double *dw = pinch_force_values(&s->elements[k], PINCH_FORCE_CHANGE);
        for (int i = 0; i < s->elements[k].rows; i++) contacts[k].w[i] += t * dw[i];
    }
}

static void minimize(pinch_arena *arena, pinch_force_system *s, tresca_contact *contacts, int *steps)
{
    double most_work = s->work + PART_OF_BUDGET * (s->budget - s->work);
    for (int step = 0; step < MOST_STEPS && !(s->work > most_work); step++, ++*steps) {
        double *dq = pinch_force_clear_rhs(arena, s);
        if (linearize(s, contacts, dq) <= END * s->scale || !pinch_force_solve_for_rhs(s, EXACTNESS)) return;
        find_changes(s, dq);
        take_step(s, contacts, dq, length_of_step(s, contacts, dq));
    }
}

bool pinch_force_tresca(pinch_arena *arena, pinch_force_system *s, int *steps)
{
    if (!applies(s)) return true;
    if (!pinch_force_clear_rhs(arena, s)) return false;
    const pinch_arena_mark here = pinch_arena_here(arena);
    tresca_contact *contacts = PINCH_ARENA_ARRAY(arena, tresca_contact, s->element_count + 1);
    if (!contacts) return false;
    pinch_force_move(s);
    for (int k = 0; k < s->element_count; k++) {
        const pinch_force_element *e = &s->elements[k];
        pinch_force_element_velocity(e, s->q, contacts[k].w);
        contacts[k].limit = limit_of(e->law, *pinch_force_values(e, PINCH_FORCE_R));
    }
    minimize(arena, s, contacts, steps);
    for (int k = 0; k < s->element_count; k++)
        force_at(&s->elements[k], contacts[k].limit, contacts[k].w, pinch_force_values(&s->elements[k], PINCH_FORCE_R),
                 NULL);
    pinch_arena_rewind(arena, &here);
    return true;
}
