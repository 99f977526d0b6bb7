/* Semi-smooth Newton on the forces, from several starts. */
#include "exact.h"

#include "system.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* ---- Linear algebra. ---- */

static void swap_rows(int n, long double *a, long double *b, int i, int k)
{
    for (int j = 0; j < n; j++) {
        long double t = a[i * n + j];
        a[i * n + j] = a[k * n + j];
        a[k * n + j] = t;
    }
    long double t = b[i];
    b[i] = b[k];
    b[k] = t;
}

/* Rows of forces and of velocities have different units, so each row is divided by its largest entry. */
static bool scale_rows(int n, long double *a, long double *b)
{
    for (int i = 0; i < n; i++) {
        long double largest = 0;
        for (int j = 0; j < n; j++) largest = fmaxl(largest, fabsl(a[i * n + j]));
        if (!(largest > 0) || !isfinite(largest)) return false;
        for (int j = 0; j < n; j++) a[i * n + j] /= largest;
        b[i] /= largest;
    }
    return true;
}

/* Solves the n x n system a x = b (row major) in place: b becomes x, a is used up. Gaussian elimination in long double,
 * with row pivoting and scaling. Returns false where the matrix is singular. */
static bool solve_dense(int n, long double *a, long double *b)
{
    if (!scale_rows(n, a, b)) return false;
    for (int k = 0; k < n; k++) {
        int pivot = k;
        for (int i = k + 1; i < n; i++)
            if (fabsl(a[i * n + k]) > fabsl(a[pivot * n + k])) pivot = i;
        if (!(fabsl(a[pivot * n + k]) > 0)) return false;
        if (pivot != k) swap_rows(n, a, b, k, pivot);
        for (int i = k + 1; i < n; i++) {
            long double factor = a[i * n + k] / a[k * n + k];
            if (factor == 0) continue;
            for (int j = k + 1; j < n; j++) a[i * n + j] -= factor * a[k * n + j];
            b[i] -= factor * b[k];
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        for (int j = k + 1; j < n; j++) b[k] -= a[k * n + j] * b[j];
        b[k] /= a[k * n + k];
    }
    return true;
}

/* ---- The search. ---- */

enum {
    NEWTON_STEPS = 80,
    HALVINGS = 12,
    FROZEN_ROUNDS = 80,
    FRICTION_STEPS = 20,
    STIFFNESS_STEPS = 40,
    RANDOM_STARTS = 30
};

/* What the search works with. The vectors have one entry per unknown. */
typedef struct search {
    exact_system *system;
    long double *z, *f, *trial, *step, *jacobian, *limit;
    int iterations; /* iterations of the last start */
} search;

static long double merit(const exact_system *s, const long double *f)
{
    long double sum = 0;
    for (int i = 0; i < s->unknowns; i++) sum += f[i] / s->measure[i] * (f[i] / s->measure[i]);
    return sum;
}

/* Are the equations solved as far as rounding lets them be? It is in the forces, and in the bodies' momentum. */
static bool settled(const exact_system *s, const long double *z, const long double *f, double roundings)
{
    long double size = exact_system_force(s, z) + s->scale;
    return exact_system_error(s, f) <= roundings * LDBL_EPSILON * size;
}

/* Newton's method with halved steps. Where no length helps, a step is taken whole, a few times, to get over the kinks.
 */
static bool newton(search *s, const long double *limit)
{
    const double ROUNDING = 1e4; /* times LDBL_EPSILON: 1e-15 */
    exact_system *system = s->system;
    size_t n = (size_t)system->unknowns;
    int leaps = 6;
    exact_system_evaluate(system, s->z, limit, s->f, s->jacobian);
    for (int iteration = 0; iteration < NEWTON_STEPS; iteration++) {
        long double before = merit(system, s->f);
        if (!(before < LDBL_MAX)) return false;
        if (before == 0) return true;
        memcpy(s->step, s->f, n * sizeof *s->step);
        bool good = settled(system, s->z, s->f, ROUNDING);
        if (!solve_dense(system->unknowns, s->jacobian, s->step)) return good;
        s->iterations++;
        bool better = false;
        for (int halving = 0; halving < HALVINGS && !better; halving++) {
            for (size_t i = 0; i < n; i++) s->trial[i] = s->z[i] - ldexpl(s->step[i], -halving);
            exact_system_evaluate(system, s->trial, limit, s->f, s->jacobian);
            better = merit(system, s->f) < before * (1 - ldexpl(1e-4L, -halving));
            if (good && halving == 0) break;
        }
        if (good && !better) { /* rounding lets it come no nearer */
            exact_system_evaluate(system, s->z, limit, s->f, s->jacobian);
            return true;
        }
        if (!better) {
            if (leaps-- == 0) return false;
            for (size_t i = 0; i < n; i++) s->trial[i] = s->z[i] - s->step[i];
            exact_system_evaluate(system, s->trial, limit, s->f, s->jacobian);
        }
        memcpy(s->z, s->trial, n * sizeof *s->z);
    }
    return settled(system, s->z, s->f, ROUNDING);
}

/* With frozen limits of friction the problem is convex. The limits are brought up to date round by round (the fixed
 * point of Tresca's law), and Newton's method finishes. */
static bool freeze_friction(search *s)
{
    exact_system *system = s->system;
    memset(s->limit, 0, sizeof *s->limit * (size_t)system->problem->contact_count);
    for (int round = 0; round < FROZEN_ROUNDS; round++) {
        if (!newton(s, s->limit)) return false;
        long double change = 0;
        for (int k = 0; k < system->problem->contact_count; k++) {
            long double now = s->z[system->first[k]];
            change = fmaxl(change, fabsl(now - s->limit[k]));
            s->limit[k] = fmaxl(now, 0);
        }
        if (change <= 1e-6L * exact_system_force(system, s->z)) break;
    }
    return newton(s, NULL);
}

static void set_laws(search *s, long double friction, long double stiffness)
{
    exact_system *system = s->system;
    for (int k = 0; k < system->problem->contact_count; k++) {
        exact_law *law = &system->laws[k];
        exact_law_of(&system->problem->contacts[k], system->problem->step, law);
        for (int i = 0; i < 3; i++)
            if (isfinite(law->friction[i])) law->friction[i] *= friction;
        for (int i = 0; i < 4; i++) {
            law->start[i] *= stiffness;
            law->rate[i] *= stiffness;
        }
    }
}

/* Raises friction from nothing to its full value. */
static bool raise_friction(search *s)
{
    bool fine = true;
    for (int part = 0; part <= FRICTION_STEPS && fine; part++) {
        set_laws(s, (long double)part / FRICTION_STEPS, 1);
        fine = newton(s, NULL);
    }
    set_laws(s, 1, 1);
    return fine;
}

/* Raises the stiffness from contacts so soft that they hardly couple. */
static bool raise_stiffness(search *s)
{
    bool fine = true;
    for (int part = 0; part <= STIFFNESS_STEPS; part++) { /* the next stiffness may succeed where one fails */
        set_laws(s, 1, expl((part - STIFFNESS_STEPS) * 0.25L));
        fine = newton(s, NULL);
    }
    set_laws(s, 1, 1);
    return fine;
}

/* xorshift64*, Vigna 2016: in [0, 1) */
static long double random_number(uint64_t *state)
{
    *state ^= *state >> 12;
    *state ^= *state << 25;
    *state ^= *state >> 27;
    return (long double)((*state * 2685821657736338717u) >> 11) / 9007199254740992.0L;
}

static bool start_at_random(search *s, int number)
{
    exact_system *system = s->system;
    uint64_t state = 88172645463325252u + (uint64_t)number;
    for (int k = 0; k < system->problem->contact_count; k++)
        for (int i = 0; i < system->laws[k].rows && i < 3; i++)
            s->z[system->first[k] + i] = system->scale * (random_number(&state) - (i ? 0.5L : 0));
    return newton(s, NULL);
}

/* The force that drive d lacks at a speed, while the other bodies move as without contacts. The normal forces of its
 * contacts at that speed go into z. */
static long double missing_drive_force(search *s, int d, long double speed)
{
    const exact_system *system = s->system;
    int n = system->unknowns, column = n - system->drive_count + d;
    long double lacks = system->free[column];
    for (int k = 0; k < system->problem->contact_count; k++) {
        int i = system->first[k];
        long double w[4] = {0}, r[4], slope[16], along = system->a[i * n + column];
        if (along == 0) continue;
        w[0] = system->free[i] + along * speed;
        exact_law_force(&system->laws[k], w, -1, r, slope);
        s->z[i] = r[0];
        lacks += along * r[0];
    }
    return lacks;
}

/* A massless drive whose contacts are all open has no equation for its speed. It starts at the speed at which they
 * press with its force. The force that it lacks grows or falls with the speed, according to the direction of the
 * contacts (along < 0 or > 0). */
static void start_drives(search *s)
{
    const exact_system *system = s->system;
    for (int d = 0; d < system->drive_count; d++) {
        long double low = -1000, high = 1000; /* m/s */
        bool falls = missing_drive_force(s, d, low) > missing_drive_force(s, d, high);
        for (int k = 0; k < 100; k++) {
            long double middle = 0.5L * (low + high);
            if ((missing_drive_force(s, d, middle) > 0) == falls)
                low = middle;
            else
                high = middle;
        }
        s->z[system->unknowns - system->drive_count + d] = 0.5L * (low + high);
    }
}

static bool search_from(search *s, int start)
{
    memset(s->z, 0, sizeof *s->z * (size_t)s->system->unknowns);
    s->iterations = 0;
    start_drives(s);
    switch (start) {
    case 0:
        return newton(s, NULL);
    case 1:
        return freeze_friction(s);
    case 2:
        return raise_friction(s);
    case 3:
        return raise_stiffness(s);
    default:
        return start_at_random(s, start);
    }
}

static bool supported(const pinch_contact *c)
{
    bool plain =
        c->model == PINCH_CONTACT_FRICTIONLESS || c->model == PINCH_CONTACT_HARD || c->model == PINCH_CONTACT_SOFT;
    for (int i = 0; i < 5; i++) plain = plain && c->friction_limit[i] == 0;
    return plain && c->viscous[0] == 0 && c->viscous[1] == 0;
}

static exact_status keep(const search *s, int start, exact_answer *answer)
{
    const exact_system *system = s->system;
    const pinch_problem *p = system->problem;
    memset(answer, 0, sizeof *answer);
    answer->force = calloc(4 * (size_t)p->contact_count + 1, sizeof *answer->force);
    answer->velocity = calloc(6 * (size_t)p->body_count + 1, sizeof *answer->velocity);
    answer->row = calloc((size_t)p->row_count + 1, sizeof *answer->row);
    if (!answer->force || !answer->velocity || !answer->row) {
        exact_free(answer);
        return EXACT_NO_MEMORY;
    }
    for (int k = 0; k < p->contact_count; k++)
        for (int i = 0; i < system->laws[k].rows; i++) answer->force[4 * k + i] = (double)s->z[system->first[k] + i];
    for (int b = 0; b < p->body_count; b++) exact_system_velocity(system, s->z, b, answer->velocity + 6 * b);
    for (int k = 0; k < p->row_count; k++) answer->row[k] = (double)s->z[system->contact_unknowns + k];
    long double scale = exact_system_force(system, s->z);
    answer->scale = (double)scale;
    answer->residual = scale > 0 ? (double)(exact_system_error(system, s->f) / scale) : 0;
    answer->iterations = s->iterations;
    answer->start = start;
    return EXACT_OK;
}

static bool allocate(search *s, const exact_system *system)
{
    size_t n = (size_t)system->unknowns + 1;
    s->z = calloc(n, sizeof *s->z);
    s->f = calloc(n, sizeof *s->f);
    s->trial = calloc(n, sizeof *s->trial);
    s->step = calloc(n, sizeof *s->step);
    s->jacobian = calloc(n * n, sizeof *s->jacobian);
    s->limit = calloc((size_t)system->problem->contact_count + 1, sizeof *s->limit);
    return s->z && s->f && s->trial && s->step && s->jacobian && s->limit;
}

static void release(search *s)
{
    free(s->z);
    free(s->f);
    free(s->trial);
    free(s->step);
    free(s->jacobian);
    free(s->limit);
}

exact_status exact_solve(const pinch_problem *problem, exact_answer *answer)
{
    for (int k = 0; k < problem->contact_count; k++)
        if (!supported(&problem->contacts[k])) return EXACT_UNSUPPORTED;
    for (int k = 0; k < problem->row_count; k++)
        if (problem->rows[k].continues) return EXACT_UNSUPPORTED;
    exact_system system;
    search s = {.system = &system};
    exact_status status = EXACT_NO_MEMORY;
    if (exact_system_build(&system, problem) && allocate(&s, &system)) {
        status = EXACT_NOT_FOUND;
        for (int start = 0; start < 4 + RANDOM_STARTS && status == EXACT_NOT_FOUND; start++)
            if (search_from(&s, start)) status = keep(&s, start, answer);
    }
    release(&s);
    exact_system_free(&system);
    return status;
}

void exact_free(exact_answer *answer)
{
    free(answer->force);
    free(answer->velocity);
    free(answer->row);
    answer->force = answer->velocity = answer->row = NULL;
}
