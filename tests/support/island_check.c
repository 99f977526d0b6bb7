#include "support/island_check.h"

#include "support/cmocka_all.h"

#include "support/draw.h"

pinch_step_solver *island_solver;

int island_create_solver(void **state)
{
    (void)state;
    return pinch_step_solver_create(&island_solver) == PINCH_OK ? 0 : -1;
}

int island_destroy_solver(void **state)
{
    (void)state;
    pinch_step_solver_destroy(island_solver);
    return 0;
}

pinch_solver_settings island_settings(void)
{
    pinch_solver_settings settings = pinch_default_solver_settings();
    if (!draw_full()) settings.max_iterations = 500;
    return settings;
}

pinch_step_result island_solve(island *made, const pinch_solver_settings *settings)
{
    pinch_step_result result;
    assert_int_equal(pinch_step_solve(island_solver, &made->problem, settings, &result), PINCH_OK);
    return result;
}

/* Everything documented as output, one double at a time. */
static void each_output(island *made, void (*act)(void *context, double value), void *context)
{
    const pinch_problem *p = &made->problem;
    for (int b = 0; b < p->body_count; b++)
        for (int i = 0; i < 6; i++) act(context, p->bodies[b].velocity_end[i]);
    for (int k = 0; k < p->contact_count; k++) {
        const pinch_contact *c = &p->contacts[k];
        for (int i = 0; i < 4; i++) act(context, c->force[i]);
        for (int i = 0; i < 4; i++) act(context, c->relative_velocity[i]);
        for (int i = 0; i < 3; i++) act(context, c->elastic_end[i]);
        for (int i = 0; i < 3; i++) act(context, c->slip[i]);
    }
    for (int k = 0; k < p->row_count; k++) act(context, p->rows[k].force);
}

typedef struct output_count {
    int finite, nan;
} output_count;

static void count_output(void *context, double value)
{
    output_count *count = context;
    count->finite += isfinite(value) != 0;
    count->nan += isnan(value) != 0;
}

void island_assert_nan(island *made)
{
    output_count count = {0, 0};
    each_output(made, count_output, &count);
    assert_int_equal(count.finite, 0);
    assert_true(count.nan > 0);
}

void island_assert_finite(island *made)
{
    output_count count = {0, 0};
    each_output(made, count_output, &count);
    assert_int_equal(count.nan, 0);
    assert_true(count.finite > 0);
}

double island_law_tolerance(const referee_verdict *v)
{
    return 1e-9 * v->scale + 64 * v->rounding;
}

const char *island_fault(const pinch_problem *p, const referee_verdict *v)
{
    double law = island_law_tolerance(v);
    /* a body's balance is verified to a hundred times the solver's tolerance of 1e-10, relative to the sum of the
     * forces on it, of which `scale` is the largest */
    double forces = v->scale * (p->contact_count + 1);
    if (!(v->balance <= 1e-8 * forces + 64 * v->rounding)) return "momentum balance";
    if (!(v->drive <= 1e-8 * v->scale + 64 * v->rounding)) return "balance of a drive";
    if (!(v->normal <= law)) return "normal law";
    if (!(v->friction <= law)) return "friction law";
    if (!(v->cone <= law)) return "cone";
    if (!(v->direction <= law)) return "slip direction";
    if (!(v->compliant <= law)) return "compliant row";
    if (!(v->joint <= 1e-10)) return "hard row"; /* speeds of 1 m/s and some hundred roundings in the elimination */
    if (!(v->limited <= 1e-8 * fmax(v->scale, 1))) return "one-sided row";
    return NULL;
}

double island_force_difference(const pinch_problem *a, const pinch_problem *b)
{
    double most = 0;
    for (int k = 0; k < a->contact_count; k++)
        for (int i = 0; i < 3; i++) most = fmax(most, fabs(a->contacts[k].force[i] - b->contacts[k].force[i]));
    return most;
}
