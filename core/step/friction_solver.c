/* Solves rigid frictional problems with the system of forces, whose compliance is made to vanish. */
#include <pinch/friction.h>

#include "force/force_system.h"
#include "verify/step_check.h"

#include <math.h>
#include <string.h>

enum { ROWS = 3, SWEEPS = 30, NEWTON_STEPS = 60, PATH_UNKNOWNS = 120, PATH_STEPS = 2000 };
/* The compliance begins as soft as what the inertia gives a contact. Stiffer than its end, Newton's steps lose their
 * digits: the rest is done by passes. */
static const double SOFTEST = 1, STIFFEST = 1e-6, STIFFER = 1e-2;
/* Where Newton's method does not follow, the next compliance is tried nearer to the last, until they are this near. */
static const double NEAREST = 0.5;
enum { PASSES = 30 };

typedef struct rigid {
    pinch_friction_problem *problem;
    const pinch_solver_settings *settings;
    pinch_solver_settings newton; /* of the solve at one compliance */
    pinch_mobility mobility;
    pinch_force_system system;
    pinch_contact_law *laws;
    int *first;
    double *diagonal; /* per contact: of G G^T, the normal's and the larger of the tangents' */
    double *x;        /* scratch of the check */
    double *kept;     /* the forces of the last compliance that was solved, 3 per contact */
    double *anchor;   /* those that a pass counts the compliance from */
    double *best;     /* those of the least error */
} rigid;

static bool finite_numbers(const double *x, int count)
{
    for (int i = 0; i < count; i++)
        if (!isfinite(x[i])) return false;
    return true;
}

static bool valid_contact(const pinch_friction_problem *p, const pinch_friction_contact *k)
{
    if (!(k->friction >= 0) || !isfinite(k->friction)) return false;
    if (!finite_numbers(k->free, ROWS) || !finite_numbers(k->impulse, ROWS)) return false;
    if (k->body[0] >= 0 && k->body[0] == k->body[1]) return false;
    for (int s = 0; s < 2; s++) {
        if (k->body[s] < 0) continue;
        if (k->body[s] >= p->body_count || !k->g[s]) return false;
        if (!finite_numbers(k->g[s], ROWS * p->freedoms[k->body[s]])) return false;
    }
    return true;
}

static bool valid(const pinch_friction_problem *p, const pinch_solver_settings *settings)
{
    if (p->body_count < 0 || p->contact_count < 0 || !(settings->tolerance > 0) || settings->max_iterations < 1)
        return false;
    for (int b = 0; b < p->body_count; b++)
        if (p->freedoms[b] < 1) return false;
    for (int c = 0; c < p->contact_count; c++)
        if (!valid_contact(p, &p->contacts[c])) return false;
    return true;
}

/* The bodies are clusters of the force system; their directions are those of the problem's rows. */
static bool lay_out(pinch_arena *arena, rigid *s)
{
    const pinch_friction_problem *p = s->problem;
    size_t bodies = (size_t)p->body_count, contacts = (size_t)p->contact_count;
    s->mobility.clusters = PINCH_ARENA_ARRAY(arena, pinch_cluster, bodies + 1);
    s->first = PINCH_ARENA_ARRAY(arena, int, bodies + 1);
    s->laws = PINCH_ARENA_ARRAY(arena, pinch_contact_law, contacts + 1);
    s->diagonal = PINCH_ARENA_ARRAY(arena, double, 2 * contacts + 1);
    s->kept = PINCH_ARENA_ARRAY(arena, double, ROWS *contacts + 1);
    s->anchor = PINCH_ARENA_ARRAY(arena, double, ROWS *contacts + 1);
    s->best = PINCH_ARENA_ARRAY(arena, double, ROWS *contacts + 1);
    if (arena->failed) return false;
    memset(s->mobility.clusters, 0, bodies * sizeof(pinch_cluster));
    s->mobility.cluster_count = p->body_count;
    s->first[0] = 0;
    for (int b = 0; b < p->body_count; b++) {
        s->mobility.clusters[b].first = s->first[b];
        s->mobility.clusters[b].freedoms = p->freedoms[b];
        s->mobility.clusters[b].inertia = 1;
        s->first[b + 1] = s->first[b] + p->freedoms[b];
    }
    s->mobility.unknowns = s->first[p->body_count];
    s->x = PINCH_ARENA_ARRAY(arena, double, s->mobility.unknowns + 1);
    return s->x != NULL;
}

static bool add_element(pinch_arena *arena, rigid *s, int c)
{
    const pinch_friction_contact *k = &s->problem->contacts[c];
    pinch_contact_law *law = &s->laws[c];
    pinch_force_element *e = &s->system.elements[c];
    memset(law, 0, sizeof *law);
    memset(e, 0, sizeof *e);
    law->rows = e->rows = ROWS;
    law->high = INFINITY;
    law->friction[0] = law->friction[1] = k->friction;
    e->law = law;
    size_t count = (size_t)pinch_force_value_count(ROWS);
    e->values = PINCH_ARENA_ARRAY(arena, double, count);
    if (!e->values) return false;
    memset(e->values, 0, count * sizeof *e->values);
    e->cluster[0] = e->cluster[1] = -1;
    for (int side = 0, blocks = 0; side < 2; side++) {
        int body = k->body[side];
        if (body < 0) continue;
        e->cluster[blocks] = body;
        e->block[blocks++] = (pinch_row_block){s->first[body], s->problem->freedoms[body], k->g[side]};
    }
    memcpy(pinch_force_values(e, PINCH_FORCE_W0), k->free, sizeof k->free);
    memcpy(pinch_force_values(e, PINCH_FORCE_R), k->impulse, sizeof k->impulse);
    s->diagonal[2 * c] = pinch_blocks_norm2(e->block, 0);
    s->diagonal[2 * c + 1] = fmax(pinch_blocks_norm2(e->block, 1), pinch_blocks_norm2(e->block, 2));
    return true;
}

/* A contact that cannot move has no diagonal of its own: then that of the others says what is stiff. */
static void fill_diagonal(rigid *s)
{
    int count = 2 * s->problem->contact_count;
    double largest = 0;
    for (int i = 0; i < count; i++) largest = fmax(largest, s->diagonal[i]);
    for (int i = 0; i < count; i++)
        if (!(s->diagonal[i] > 1e-12 * largest)) s->diagonal[i] = largest > 0 ? largest : 1;
}

static bool build(pinch_arena *arena, rigid *s)
{
    pinch_force_system *system = &s->system;
    int contacts = s->problem->contact_count;
    if (!lay_out(arena, s)) return false;
    system->step = 1;
    system->mobility = &s->mobility;
    system->contact_count = system->element_count = contacts;
    system->budget = INFINITY;
    system->elements = PINCH_ARENA_ARRAY(arena, pinch_force_element, contacts + 1);
    system->partials = PINCH_ARENA_ARRAY(arena, pinch_force_partial, pinch_chunk_count(contacts) + 1);
    system->q = PINCH_ARENA_ARRAY(arena, double, s->mobility.unknowns + 1);
    if (arena->failed) return false;
    for (int c = 0; c < contacts; c++)
        if (!add_element(arena, s, c)) return false;
    fill_diagonal(s);
    system->built = pinch_arena_here(arena);
    return true;
}

/* The law is that of w + C (r - a) in the place of w; a: `anchor`, the forces of the pass before, NULL: 0. */
static void set_compliance(rigid *s, double part, const double *anchor)
{
    for (int c = 0; c < s->problem->contact_count; c++) {
        double *compliance = pinch_force_values(&s->system.elements[c], PINCH_FORCE_COMPLIANCE);
        double *b = pinch_force_values(&s->system.elements[c], PINCH_FORCE_B);
        for (int i = 0; i < ROWS; i++) {
            compliance[i] = part * s->diagonal[2 * c + (i > 0)];
            b[i] = anchor ? compliance[i] * anchor[ROWS * c + i] : 0;
        }
    }
    pinch_force_set_floor(&s->system, 0);
}

static void keep_forces(rigid *s, double *to)
{
    for (int c = 0; c < s->problem->contact_count; c++)
        memcpy(to + ROWS * c, pinch_force_values(&s->system.elements[c], PINCH_FORCE_R), ROWS * sizeof *to);
}

static void bring_back(rigid *s, const double *from)
{
    for (int c = 0; c < s->problem->contact_count; c++)
        memcpy(pinch_force_values(&s->system.elements[c], PINCH_FORCE_R), from + ROWS * c, ROWS * sizeof *from);
}

/* Returns the error of these forces by the rigid laws. */
static double error_of(rigid *s, const double *forces)
{
    for (int c = 0; c < s->problem->contact_count; c++)
        memcpy(s->problem->contacts[c].impulse, forces + ROWS * c, ROWS * sizeof *forces);
    return pinch_friction_error(s->problem, s->first, s->x);
}

/* Solves at one compliance: by Newton's method from the forces of the last, then from sweeps, then along a path.
 * Returns false when memory ran out. */
static bool solve_at(pinch_arena *arena, rigid *s, double part, const double *anchor, pinch_solver_result *total)
{
    pinch_solver_result result = {.status = PINCH_SOLVE_MAX_ITERATIONS};
    for (int try = 0; try < 3 && result.status != PINCH_SOLVE_CONVERGED; try++) {
        int left = s->settings->max_iterations - total->iterations;
        if (left <= 0) break;
        bring_back(s, s->kept);
        set_compliance(s, part, anchor);
        if (try == 1) pinch_force_sweeps(&s->system, SWEEPS);
        if (try == 2) {
            int steps = left < PATH_STEPS ? left : PATH_STEPS;
            bool arrived;
            if (s->mobility.unknowns > PATH_UNKNOWNS) break;
            if (!pinch_force_follow_path(arena, &s->system, &steps, &arrived)) return false;
            total->iterations += steps;
            if (!arrived) break;
            total->by_flow = true;
        }
        if (!pinch_force_newton(arena, &s->system, &s->newton, left < NEWTON_STEPS ? left : NEWTON_STEPS, &result))
            return false;
        total->iterations += result.iterations;
        total->newton_steps += result.newton_steps;
    }
    total->status = result.status;
    total->residual = result.residual;
    return true;
}

/* Keeps the forces that were found, and remembers them where they are the best so far. */
static void note(rigid *s, double part, pinch_friction_result *result)
{
    keep_forces(s, s->kept);
    double error = error_of(s, s->kept);
    if (!(error < result->error)) return;
    memcpy(s->best, s->kept, sizeof *s->best * ROWS * (size_t)s->problem->contact_count);
    result->error = error;
    result->compliance = part;
}

/* Is there something left to do, and may it be done? */
static bool goes_on(const rigid *s, const pinch_friction_result *result)
{
    return result->error > s->settings->tolerance && result->solve.iterations < s->settings->max_iterations;
}

/* Stiffens from compliance to compliance. Returns false when memory ran out; *part is the last that was solved, and
 * infinite where none was. */
static bool stiffen(pinch_arena *arena, rigid *s, double *last, pinch_friction_result *result)
{
    double factor = STIFFER, part = SOFTEST;
    *last = INFINITY;
    while (*last > STIFFEST && goes_on(s, result)) {
        if (!solve_at(arena, s, part, NULL, &result->solve)) return false;
        if (result->solve.status == PINCH_SOLVE_CONVERGED) {
            note(s, part, result);
            *last = part;
        } else if (isinf(*last) || (factor = sqrt(factor)) > NEAREST) {
            return true;
        }
        part = fmax(STIFFEST, *last * factor);
    }
    return true;
}

/*
 * Solves with the compliance counted from the forces of the pass before, until these stay, and it falsifies nothing any
 * more: the proximal point method (Rockafellar, "Monotone operators and the proximal point algorithm", 1976). Each pass
 * divides the error by about what the compliance is smaller than the inertia. Returns false when memory ran out.
 */
static bool make_exact(pinch_arena *arena, rigid *s, double part, pinch_friction_result *result)
{
    for (int pass = 0; pass < PASSES && goes_on(s, result); pass++) {
        memcpy(s->anchor, s->kept, sizeof *s->anchor * ROWS * (size_t)s->problem->contact_count);
        if (!solve_at(arena, s, part, s->anchor, &result->solve)) return false;
        if (result->solve.status != PINCH_SOLVE_CONVERGED) return true;
        note(s, part, result);
    }
    return true;
}

static bool solve(pinch_arena *arena, rigid *s, pinch_friction_result *result)
{
    double last;
    if (!build(arena, s)) return false;
    keep_forces(s, s->kept);
    keep_forces(s, s->best);
    result->error = error_of(s, s->best);
    if (!stiffen(arena, s, &last, result)) return false;
    return isinf(last) || make_exact(arena, s, last, result);
}

pinch_status pinch_friction_solve(pinch_friction_problem *problem, const pinch_solver_settings *settings,
                                  pinch_friction_result *result)
{
    if (!problem || !settings || !result || !valid(problem, settings)) return PINCH_INVALID_ARGUMENT;
    pinch_arena arena;
    rigid s = {.problem = problem, .settings = settings, .newton = pinch_default_solver_settings()};
    pinch_arena_init(&arena);
    memset(result, 0, sizeof *result);
    bool done = solve(&arena, &s, result);
    if (done) {
        result->error = error_of(&s, s.best); /* it writes the impulses and velocities of the best */
        if (result->error <= settings->tolerance)
            result->solve.status = PINCH_SOLVE_CONVERGED;
        else if (result->solve.status == PINCH_SOLVE_CONVERGED)
            result->solve.status = PINCH_SOLVE_UNVERIFIED;
    }
    pinch_arena_free(&arena);
    return done ? PINCH_OK : PINCH_OUT_OF_MEMORY;
}
