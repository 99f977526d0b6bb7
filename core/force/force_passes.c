/*
 * The passes that joint rows need which may depend on each other, equation (54) of core/README.md.
 *
 * In the first pass, whose anchors are zero, rows have the compliance kappa, each in its own units. What they cannot
 * satisfy together is shared out as by springs and dampers of the same stiffness wherever the bodies go. So a mechanism
 * that is forced through a contradiction gets no energy from it; from a metric that turns with the bodies it would.
 *
 * Where all rows are clearly to be had, further passes take the compliance out again (the proximal method of
 * multipliers): each leaves the part kappa/(kappa + W) of the error, W being what inertia and the other rows leave a
 * row. Where the error does not shrink by much, rows contradict each other, or they hardly move what they ask for, and
 * the answer is that of the first pass.
 *
 * The first pass is but approached where a second one follows: what contacts' forces lack there changes the anchors,
 * and by kappa times as much the rows (Rockafellar, "Monotone operators and the proximal point algorithm", 1976, allows
 * for errors that can be summed up).
 *
 * Rows that contradict each other have multipliers millions of times larger than the impulses that do anything, and the
 * rounding of those would be all that the other equations miss. So the large part is put aside, with what it adds to q
 * summed up in twice the precision, and the system goes on for the rest, measured by that.
 */
#include "force/force_system.h"

#include "support/extremes.h"
#include "support/vec3.h"

#include <float.h>
#include <math.h>
#include <string.h>

/* Notes what each row misses of what it asks for after a pass. Returns the most. */
static double note_missed(pinch_force_system *s)
{
    double most = 0;
    for (int i = 0; i < s->multiplier_count; i++) {
        pinch_force_multiplier *m = &s->multipliers[i];
        m->missed = pinch_force_given_way(m);
        most = pinch_larger(fabs(m->missed), most);
    }
    return most;
}

double pinch_force_rounding(const pinch_force_system *s)
{
    static const double ROUNDING = 1e-15; /* of the largest multiplier */
    double most = 0;
    for (int i = 0; i < s->multiplier_count && s->dependent_rows; i++)
        most = pinch_larger(fabs(s->multipliers[i].y), most);
    return ROUNDING * most / s->scale;
}

double pinch_force_rounding_of_motion(const pinch_force_system *s)
{
    static const double ROUNDINGS = 4 * DBL_EPSILON; /* of a velocity */
    double most = 0;
    for (int k = 0; k < s->contact_count && s->bodies; k++) {
        const pinch_force_element *e = &s->elements[k];
        const pinch_contact *c = e->contact;
        double speed = pinch_v3_norm(c->surface_velocity), arm[3];
        for (int side = 0; side < 2; side++) {
            int number = side ? c->body2 : c->body1;
            if (number < 0) continue;
            const pinch_body *b = &s->bodies[number];
            pinch_v3_sub(c->position, b->position, arm);
            speed += pinch_v3_norm(b->velocity) + pinch_v3_norm(b->velocity + 3) * pinch_v3_norm(arm);
        }
        double rho = *pinch_force_values(e, PINCH_FORCE_RHO);
        most = pinch_larger(sqrt(s->step * rho) * speed, most); /* in the merit, a force has the weight sqrt(h / rho) */
    }
    return ROUNDINGS * most / s->scale;
}

/* Is the multiplier of a row that is not at a bound? Those between two bounds are not large. */
static bool may_be_large(const pinch_force_multiplier *m)
{
    bool between = m->unit.low > -INFINITY && m->unit.high < INFINITY;
    return m->bound == 0 && !between && m->unit.compliance == 0;
}

/*
 * Would the check of an answer see the rounding of multipliers? What the largest is rounded by moves a row of length
 * sigma by sigma times as much, and a contact with inertia W by sqrt(W) times as much, whose force follows with rho.
 * The scale of the whole does not tell: it is as large as the multipliers that the solve began with.
 */
static bool rounding_shows(const pinch_force_system *s)
{
    static const double ROUNDING = 1e-15, MOST_ROW = 1e-9, MOST_FORCE = 1e-10; /* m/s or rad/s; of the largest force */
    double largest = 0, row = 0, contact = 0, force = 0;
    for (int i = 0; i < s->multiplier_count; i++) {
        const pinch_force_multiplier *m = &s->multipliers[i];
        if (may_be_large(m) || m->base != 0) largest = pinch_larger(fabs(m->y), largest);
        row = pinch_larger(m->unit.sigma, row);
    }
    for (int k = 0; k < s->contact_count; k++) {
        const pinch_force_element *e = &s->elements[k];
        double rho = *pinch_force_values(e, PINCH_FORCE_RHO), c = *pinch_force_values(e, PINCH_FORCE_COMPLIANCE);
        contact = pinch_larger(rho * (1 - rho * c) / s->step, contact); /* rho^2 W, by equation (24) */
        force = pinch_larger(*pinch_force_values(e, PINCH_FORCE_R), force);
    }
    return ROUNDING * largest * row > MOST_ROW ||
           (force > 0 && ROUNDING * largest * sqrt(contact) > MOST_FORCE * force);
}

/* Puts the multipliers aside that may be large, brings those back that have come to a bound since, and measures errors
 * by the forces and motions that are left. */
static void put_aside(pinch_force_system *s)
{
    for (int i = 0; i < s->multiplier_count; i++) {
        pinch_force_multiplier *m = &s->multipliers[i];
        bool aside = may_be_large(m);
        if (!aside && m->base == 0) continue;
        double y = m->base + m->y;
        pinch_force_shift_base(m, aside ? m->y : -m->base);
        m->y = aside ? 0 : fmin(fmax(y, m->unit.low), m->unit.high);
        m->anchor = 0;
    }
    for (int k = 0; k < s->mobility->unknowns; k++) s->exact_q[k] = (pinch_double_double){0, 0};
    for (int i = 0; i < s->multiplier_count; i++) {
        const pinch_force_multiplier *m = &s->multipliers[i];
        for (int b = 0; b < m->blocks; b++)
            for (int k = 0; k < m->block[b].size; k++) {
                pinch_double_double *sum = &s->exact_q[m->block[b].first + k];
                *sum = pinch_dd_add(*sum, pinch_dd_product(m->base, m->block[b].g[k]));
            }
    }
    for (int k = 0; k < s->mobility->unknowns; k++) s->base_q[k] = s->exact_q[k].high;
    pinch_force_set_scale(s);
}

/* Goes back to the solution of the first pass. */
static void return_to_first(pinch_force_system *s)
{
    for (int i = 0; i < s->multiplier_count; i++) {
        s->multipliers[i].y = s->multipliers[i].first;
        s->multipliers[i].anchor = 0;
    }
}

static void begin_pass(pinch_force_system *s, bool first)
{
    for (int i = 0; i < s->multiplier_count; i++) {
        pinch_force_multiplier *m = &s->multipliers[i];
        if (first) m->first = m->y;
        m->anchor = m->y;
    }
}

pinch_force_pass_kind pinch_force_next_pass(pinch_force_system *s, double merit, double tolerance,
                                            pinch_force_passes *passes)
{
    enum { MOST_PASSES = 8, MOST_ASIDE = 3 };
    /* of the tolerance; of what was missed before; of the tolerance */
    static const double EXACT = 1e-3, MOST_LEFT = 1e-2, COARSE = 0.1;
    bool approach = passes->approach;
    double enough = approach ? PINCH_FORCE_APPROACHED * tolerance : tolerance;
    passes->approach = false;
    if (!(merit <= fmax(enough, pinch_force_rounding(s)))) {
        if (!passes->begun || passes->ended) return PINCH_FORCE_NO_PASS;
        passes->ended = true;
        return_to_first(s);
        return PINCH_FORCE_FIRST_PASS;
    }
    double missed = note_missed(s);
    if (passes->count++ >= MOST_PASSES) return PINCH_FORCE_NO_PASS;
    bool shows = rounding_shows(s) && passes->put_aside < MOST_ASIDE;
    if (shows || pinch_force_rounding(s) > COARSE * tolerance) {
        if (approach) return PINCH_FORCE_SAME_PASS; /* beside what is left, its error would be large */
        passes->put_aside++;
        if (passes->begun && !passes->ended) return_to_first(s);
        passes->ended = true;
        put_aside(s);
        return PINCH_FORCE_FIRST_PASS;
    }
    if (passes->ended || missed <= EXACT * tolerance * s->scale)
        return approach ? PINCH_FORCE_SAME_PASS : PINCH_FORCE_NO_PASS;
    if (passes->begun && !passes->rough && missed > MOST_LEFT * passes->missed) {
        passes->ended = true;
        return_to_first(s);
        return PINCH_FORCE_FIRST_PASS;
    }
    begin_pass(s, !passes->begun);
    passes->begun = true;
    passes->rough = merit > tolerance;
    passes->missed = missed;
    return PINCH_FORCE_FURTHER_PASS;
}
