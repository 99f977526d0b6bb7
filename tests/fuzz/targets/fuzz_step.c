/* Contact problems of up to four bodies: numbers that are not finite, coincident points, opposed normals, ratios of
 * 1e12. What is called converged has to keep the laws, as the tests' referee has them, and everything else has to be
 * NaN. */
#include "support/referee.h"
#include "target.h"

#include <math.h>
#include <string.h>

enum { BODIES = 4, CONTACTS = 6, ROWS = 4 };

static double positive(target_bytes *b)
{
    double value = target_number(b);
    return value < 0 ? -value : value;
}

static void unit(target_bytes *b, double n[3], double t[3])
{
    double angle = 6.283185307179586 * target_byte(b) / 256, z = target_byte(b) / 127.5 - 1,
           s = sqrt(fmax(0, 1 - z * z));
    double u[3] = {s * cos(angle), s * sin(angle), z}, size = 0;
    memcpy(n, u, sizeof u);
    int least = fabs(u[0]) < 0.6 ? 0 : 1;
    for (int i = 0; i < 3; i++) t[i] = (i == least) - u[least] * u[i];
    for (int i = 0; i < 3; i++) size += t[i] * t[i];
    for (int i = 0; i < 3; i++) t[i] /= sqrt(size);
    if (target_byte(b) >= 250) n[0] = target_number(b);
}

static int body_index(target_bytes *b, int count)
{
    return (int)(target_byte(b) % (unsigned)(count + 1)) - 1;
}

static void make_body(target_bytes *b, pinch_body *body)
{
    double inertia = positive(b);
    *body = (pinch_body){.mass = positive(b), .radius = positive(b)};
    for (int i = 0; i < 3; i++) body->inertia[4 * i] = inertia * (1 + target_byte(b) / 256.0);
    for (int i = 0; i < 3; i++) body->position[i] = target_byte(b) / 128.0 - 1;
    for (int i = 0; i < 6; i++) body->velocity[i] = target_number(b);
    for (int i = 0; i < 6; i++) body->external[i] = target_number(b);
}

static void make_contact(target_bytes *b, int bodies, pinch_contact *c)
{
    static const pinch_contact_model models[] = {PINCH_CONTACT_FRICTIONLESS, PINCH_CONTACT_HARD, PINCH_CONTACT_SOFT,
                                                 PINCH_CONTACT_ROLLING};
    *c = (pinch_contact){.body1 = (int)(target_byte(b) % (unsigned)bodies),
                         .body2 = body_index(b, bodies),
                         .model = models[target_byte(b) % 4],
                         .max_force = INFINITY};
    unit(b, c->normal, c->tangent1);
    for (int i = 0; i < 3; i++) c->position[i] = target_byte(b) / 128.0 - 1;
    c->depth = target_number(b);
    for (int i = 0; i < 3; i++) {
        c->stiffness[i] = positive(b);
        c->damping[i] = target_byte(b) & 1 ? positive(b) : 0;
        c->elastic[i] = target_byte(b) & 1 ? target_number(b) : 0;
    }
    for (int i = 0; i < 2; i++) c->friction[i] = positive(b);
    c->torsional_friction = positive(b);
    for (int i = 0; i < 2; i++) c->rolling_friction[i] = positive(b);
    c->may_soften = target_byte(b) >= 200;
    if (target_byte(b) >= 200) c->max_force = positive(b);
}

static void make_row(target_bytes *b, int bodies, pinch_joint_row *row)
{
    *row = (pinch_joint_row){.body1 = (int)(target_byte(b) % (unsigned)bodies),
                             .body2 = body_index(b, bodies),
                             .low = -INFINITY,
                             .high = INFINITY};
    for (int i = 0; i < 6; i++) row->j1[i] = target_number(b);
    for (int i = 0; i < 6; i++) row->j2[i] = row->body2 < 0 ? 0 : target_number(b);
    row->rhs = target_number(b);
    row->cfm = target_byte(b) & 1 ? positive(b) : 0;
    if (target_byte(b) & 1) row->low = -positive(b);
    if (target_byte(b) & 1) row->high = positive(b);
}

static void check_answer(const pinch_problem *p, const pinch_step_result *result)
{
    if (result->solve.status != PINCH_SOLVE_CONVERGED) {
        for (int i = 0; i < p->body_count; i++)
            if (!isnan(p->bodies[i].velocity_end[0])) target_found("a failed step left a velocity");
        return;
    }
    for (int i = 0; i < p->body_count; i++)
        for (int k = 0; k < 6; k++)
            if (!isfinite(p->bodies[i].velocity_end[k])) target_found("converged with a velocity that is not finite");
    /* The referee knows neither what dependent rows share, nor polygons, nor rolling, nor friction without a limit. */
    if (p->row_count > 0 || p->faces > 0) return;
    for (int k = 0; k < p->contact_count; k++) {
        const pinch_contact *c = &p->contacts[k];
        if (c->model == PINCH_CONTACT_ROLLING || isinf(c->friction[0]) || isinf(c->friction[1])) return;
    }
    referee_verdict v;
    referee_judge(p, &v);
    /* Ratios of 1e12 leave some digits less than the random islands of other tests; beyond 1e8 N the referee's own
     * search for the closest point has none left. Less than 1e-12 N is no force to pinch_step_verify, either. */
    static const double SMALLEST_FORCE = 1e-12;
    double tolerance = 1e-6 * v.scale + 1000 * v.rounding + SMALLEST_FORCE;
    if (!(v.scale < 1e8) || v.friction > 1e100 ||
        (v.normal <= tolerance && v.friction <= tolerance && v.cone <= tolerance))
        return;
    target_found("converged, but of %g N with %g N of rounding the normal law misses %g, friction %g, the cone %g",
                 v.scale, v.rounding, v.normal, v.friction, v.cone);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static pinch_step_solver *solver;
    if (!solver && pinch_step_solver_create(&solver) != PINCH_OK) return 0;
    target_bytes b = {data, size};
    pinch_body bodies[BODIES];
    pinch_contact contacts[CONTACTS];
    pinch_joint_row rows[ROWS];
    static const int faces[8] = {0, 0, 0, 0, 2, 4, 8, 1};
    pinch_problem p = {.step = positive(&b),
                       .faces = faces[target_byte(&b) % 8],
                       .body_count = 1 + (int)(target_byte(&b) % BODIES),
                       .contact_count = (int)(target_byte(&b) % (CONTACTS + 1)),
                       .row_count = target_byte(&b) >= 128 ? (int)(target_byte(&b) % (ROWS + 1)) : 0,
                       .bodies = bodies,
                       .contacts = contacts,
                       .rows = rows};
    for (int i = 0; i < p.body_count; i++) make_body(&b, &bodies[i]);
    for (int i = 0; i < p.contact_count; i++) make_contact(&b, p.body_count, &contacts[i]);
    if (p.contact_count > 1 && target_byte(&b) >= 200) contacts[1] = contacts[0]; /* twice the same */
    for (int i = 0; i < p.row_count; i++) make_row(&b, p.body_count, &rows[i]);
    pinch_solver_settings settings = pinch_default_solver_settings();
    settings.max_iterations = target_iterations(&b);
    pinch_step_result result;
    pinch_status status = pinch_step_solve(solver, &p, &settings, &result);
    if (status == PINCH_OK) check_answer(&p, &result);
    return 0;
}
