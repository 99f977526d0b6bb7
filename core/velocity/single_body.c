/*
 * The step in velocities of one free body, written out for its six unknowns: most grasps are an object that fingertips
 * hold, whose motion is prescribed, or which are pressed against it by massless drives. The equations are those of
 * velocity_system.c, with two contacts side by side in all that is done to them, and Newton's method takes full steps
 * alone. What it does not solve is left to the system of any island.
 *
 * A drive touches the body alone. Its speed y is eliminated: with the body's coordinates q, Newton's method solves
 *
 *     | A   b | | dq |   | F_q |       A' = A - sum b c^T / e,     dy = (F_y - c^T dq) / e,                      (72)
 *     | c^T e | | dy | = | F_y |
 *
 * b = h sum G^T D d, c^T = h sum d^T D G, e = h sum d^T D d over the drive's contacts, d their rows in its speed.
 */
#include "velocity/velocity_system.h"

#include "support/arena.h"
#include "support/lanes.h"
#include "support/lu.h"

#include <math.h>
#include <string.h>

enum { N = 6, ROWS = 4, LINEAR = 3 }; /* unknowns; rows of a contact; columns that torsion has nothing in */

/* The same as pinch_lanes, where the place in memory is known to suit the processor. */
typedef pinch_lanes lanes __attribute__((aligned(PINCH_ARENA_ALIGNMENT)));

/* Two contacts. Nothing acts along rows that one does not have, nor along any of one that is not there: a contact in
 * its place has no stiffness. */
typedef struct contact_pair {
    lanes g[ROWS][N];                /* G U */
    lanes d[3];                      /* the same for the speeds of the drives, which do not turn */
    int drive[2];                    /* negative: none */
    lanes w0[ROWS];                  /* w at rest of all unknowns */
    lanes trial[ROWS];               /* the trial force at w = 0 */
    lanes conductance[ROWS];         /* h k + c */
    lanes high;                      /* limit of the normal force */
    lanes weight[ROWS - 1];          /* 1 / mu: the reach of friction in newtons of normal force */
    lanes w[ROWS], r[ROWS];          /* at the point evaluated last */
    lanes slope[ROWS];               /* the diagonal of -dr/dw there; zero where a contact slips */
    pinch_lanes_mask sticks, slips;  /* there */
    const pinch_contact *contact[2]; /* NULL: none */
    double slipping[2][ROWS * ROWS]; /* -dr/dw of a contact that slips, by its own rows */
} contact_pair;

/* A massless drive. */
typedef struct drive {
    int body;
    double axis[3];          /* the direction of its scaled speed */
    double load;             /* the impulse that pushes it */
    double b[N], c[N], e, f; /* of the Newton step */
} drive;

/* The step of the body with the coordinates q: v+ = v* + U q, and U is a multiple of the identity beside an upper
 * triangle. */
typedef struct single_body {
    const pinch_problem *problem;
    const pinch_body *body;
    pinch_root_inverse u;
    contact_pair *pairs;
    drive *drives;
    int pair_count, drive_count;
    double *x, *f; /* unknowns: q, and the speeds of the drives. F is not divided by its scale */
    double *trial_x, *trial_f;
    double scale;
    bool any_slips;
} single_body;

static inline lanes both(double a)
{
    return (pinch_lanes){a, a};
}

static inline lanes two(double first, double second)
{
    return (pinch_lanes){first, second};
}

static inline void cross(const lanes *a, const lanes *b, lanes *c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* Adds what a couple about `lever` does: the angular columns of its row, and its part of w at q = 0. */
static inline void put_couple(const single_body *s, const lanes *lever, lanes *g, lanes *w0)
{
    const double *t = s->u.t, *spin = s->body->velocity + 3;
    g[3] = lever[0] * t[0];
    g[4] = lever[0] * t[1] + lever[1] * t[3];
    g[5] = lever[0] * t[2] + lever[1] * t[4] + lever[2] * t[5];
    *w0 += lever[0] * spin[0] + lever[1] * spin[1] + lever[2] * spin[2];
}

static inline void put_axis(const single_body *s, const lanes *arm, const lanes *axis, lanes *g, lanes *w0)
{
    const double *v = s->body->velocity;
    lanes lever[3];
    cross(arm, axis, lever);
    for (int i = 0; i < 3; i++) g[i] = s->u.linear * axis[i];
    *w0 += axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2];
    put_couple(s, lever, g, w0);
}

/* The drive that is a contact's other side, or none. */
static int drive_of(const single_body *s, const pinch_contact *contact)
{
    int body = contact->body1 == s->body - s->problem->bodies ? contact->body2 : contact->body1, k = s->drive_count - 1;
    while (k >= 0 && s->drives[k].body != body) k--;
    return k;
}

/* Takes the rows of the drives. `axis` is the frame as the body sees it, and they are on the other side. */
static void put_drives(const single_body *s, const pinch_contact *a, const pinch_contact *b, lanes axis[3][3],
                       contact_pair *pair)
{
    static const double NONE[3] = {0, 0, 0};
    const double *along[2];
    pair->drive[0] = drive_of(s, a);
    pair->drive[1] = drive_of(s, b);
    for (int lane = 0; lane < 2; lane++) along[lane] = pair->drive[lane] < 0 ? NONE : s->drives[pair->drive[lane]].axis;
    for (int row = 0; row < 3; row++) {
        pair->d[row] = both(0);
        for (int i = 0; i < 3; i++) pair->d[row] -= axis[row][i] * two(along[0][i], along[1][i]);
    }
}

/* Takes the rows of frame and point of both contacts. `sign` is -1 where the body is the contact's second one. */
static void put_rows(const single_body *s, const pinch_contact *a, const pinch_contact *b, contact_pair *pair)
{
    int own = (int)(s->body - s->problem->bodies);
    lanes arm[3], axis[3][3], sign = two(a->body1 == own ? 1 : -1, b->body1 == own ? 1 : -1);
    const double *position = s->body->position;
    for (int i = 0; i < 3; i++) {
        arm[i] = two(a->position[i], b->position[i]) - position[i];
        axis[0][i] = sign * two(a->normal[i], b->normal[i]);
        axis[1][i] = two(a->tangent1[i], b->tangent1[i]);
    }
    cross(axis[0], axis[1], axis[2]);
    for (int i = 0; i < 3; i++) axis[1][i] *= sign;
    for (int row = 0; row < ROWS; row++) pair->w0[row] = two(a->surface_velocity[row], b->surface_velocity[row]);
    for (int row = 0; row < 3; row++) put_axis(s, arm, axis[row], pair->g[row], &pair->w0[row]);
    for (int k = 0; k < LINEAR; k++) pair->g[3][k] = both(0);
    put_couple(s, axis[0], pair->g[3], &pair->w0[3]);
    if (s->drive_count > 0) put_drives(s, a, b, axis, pair);
}

/* Takes the laws of both contacts. */
static void put_laws(const single_body *s, const pinch_contact *a, const pinch_contact *b, contact_pair *pair)
{
    double h = s->problem->step;
    for (int row = 0; row < ROWS; row++) {
        int kind = row == 0 ? 0 : row < 3 ? 1 : 2;
        lanes k = two(a->stiffness[kind], b->stiffness[kind]), c = two(a->damping[kind], b->damping[kind]);
        pair->conductance[row] = h * k + c;
        pair->trial[row] = row == 0 ? two(a->depth, b->depth) : two(-a->elastic[row - 1], -b->elastic[row - 1]);
        pair->trial[row] *= k;
    }
    pair->high = two(a->max_force, b->max_force);
    for (int i = 0; i < 2; i++) pair->weight[i] = 1 / two(a->friction[i], b->friction[i]);
    pair->weight[2] = 1 / two(a->torsional_friction, b->torsional_friction);
}

/* Takes the stiffness from one of both contacts in the rows `from` and on. */
static void leave_out(contact_pair *pair, int lane, int from)
{
    for (int row = from; row < ROWS; row++) {
        pair->trial[row][lane] = pair->conductance[row][lane] = 0;
        if (row > 0) pair->weight[row - 1][lane] = 0;
    }
}

static void put_pair(const single_body *s, int first, contact_pair *pair)
{
    const pinch_problem *problem = s->problem;
    for (int lane = 0; lane < 2; lane++)
        pair->contact[lane] = first + lane < problem->contact_count ? &problem->contacts[first + lane] : NULL;
    const pinch_contact *a = pair->contact[0], *b = pair->contact[1] ? pair->contact[1] : a;
    put_rows(s, a, b, pair);
    put_laws(s, a, b, pair);
    for (int lane = 0; lane < 2; lane++) {
        int rows = pair->contact[lane] ? (int)pair->contact[lane]->model : 0;
        if (rows < ROWS) leave_out(pair, lane, rows);
    }
}

/* sum += G^T a, or with |G|, for both contacts together */
static inline void add_transposed(const contact_pair *pair, const lanes *a, lanes *sum)
{
    for (int k = 0; k < N; k++) {
        lanes part = pair->g[0][k] * a[0] + pair->g[1][k] * a[1] + pair->g[2][k] * a[2];
        if (k >= LINEAR) part += pair->g[3][k] * a[3];
        sum[k] += part;
    }
}

static inline void add_magnitudes(const contact_pair *pair, const lanes *a, lanes *sum)
{
    for (int k = 0; k < N; k++)
        for (int row = 0; row < (k < LINEAR ? 3 : ROWS); row++) sum[k] += pinch_lanes_abs(pair->g[row][k] * a[row]);
}

/* Evaluates the law of a contact that is not known to stick. */
static void project(single_body *s, contact_pair *pair, int lane)
{
    pinch_contact_law law;
    pinch_trial_force trial;
    double w[ROWS], r[ROWS];
    pinch_contact_law_of(pair->contact[lane], 0, &law);
    for (int row = 0; row < ROWS; row++) {
        trial.a[row] = pair->trial[row][lane];
        trial.g[row] = pair->conductance[row][lane];
        w[row] = pair->w[row][lane];
    }
    pinch_contact_state state = pinch_contact_law_evaluate(&law, &trial, w, r, pair->slipping[lane]);
    for (int row = 1; row < law.rows; row++) pair->r[row][lane] = r[row];
    bool slips = state == PINCH_CONTACT_SLIP;
    for (int row = slips ? 0 : 1; row < law.rows; row++)
        pair->slope[row][lane] = slips ? 0 : pair->slipping[lane][row * (law.rows + 1)];
    pair->sticks[lane] = state == PINCH_CONTACT_STICK;
    pair->slips[lane] = slips;
    s->any_slips = s->any_slips || slips;
}

/* The speeds of the drives of both contacts. */
static inline lanes speeds(const contact_pair *pair, const double *x)
{
    return two(pair->drive[0] < 0 ? 0 : x[N + pair->drive[0]], pair->drive[1] < 0 ? 0 : x[N + pair->drive[1]]);
}

/* Evaluates w and r of both contacts, and what r gives way by. */
static inline void evaluate_pair(single_body *s, const lanes *q, const double *x, contact_pair *pair)
{
    const lanes zero = both(0);
    lanes trial[ROWS], speed = s->drive_count > 0 ? speeds(pair, x) : zero;
    for (int row = 0; row < ROWS; row++) {
        const lanes *g = pair->g[row];
        lanes w = pair->w0[row] + (g[3] * q[3] + (g[4] * q[4] + g[5] * q[5]));
        if (row < 3) w += g[0] * q[0] + (g[1] * q[1] + g[2] * q[2]);
        if (row < 3 && s->drive_count > 0) w += pair->d[row] * speed;
        pair->w[row] = w;
        trial[row] = pair->trial[row] - pair->conductance[row] * w;
    }
    lanes normal = pinch_lanes_choose(trial[0] > zero, trial[0], zero);
    lanes below = pinch_lanes_choose(trial[0] < pair->high, pair->conductance[0], zero);
    normal = pinch_lanes_choose(normal > pair->high, pair->high, normal);
    lanes reach = zero;
    for (int i = 0; i < ROWS - 1; i++) {
        lanes part = trial[1 + i] * pair->weight[i];
        reach += part * part;
    }
    pinch_lanes_mask presses = normal > zero, sticks = presses & (reach <= normal * normal);
    pair->r[0] = normal;
    pair->slope[0] = pinch_lanes_choose(presses, below, zero);
    for (int row = 1; row < ROWS; row++) {
        pair->r[row] = pinch_lanes_choose(sticks, trial[row], zero);
        pair->slope[row] = pinch_lanes_choose(sticks, pair->conductance[row], zero);
    }
    pair->sticks = sticks;
    pair->slips = presses & ~sticks;
    for (int lane = 0; (pair->slips[0] | pair->slips[1]) != 0 && lane < 2; lane++)
        if (presses[lane] && !sticks[lane]) project(s, pair, lane);
}

/* f -= h d^T r of both contacts, for their drives */
static inline void take_from_drives(const single_body *s, const contact_pair *pair, double *f)
{
    lanes along = pair->d[0] * pair->r[0] + pair->d[1] * pair->r[1] + pair->d[2] * pair->r[2];
    for (int lane = 0; lane < 2; lane++)
        if (pair->drive[lane] >= 0) f[N + pair->drive[lane]] -= s->problem->step * along[lane];
}

/* F = (q, 0) - h sum (G d)^T r - load, equation (17). Returns its norm, not yet divided by the scale. */
static double evaluate(single_body *s, const double *x, double *f)
{
    lanes q[N], sum[N];
    double norm2 = 0;
    for (int k = 0; k < N; k++) {
        q[k] = both(x[k]);
        sum[k] = both(0);
    }
    for (int k = 0; k < s->drive_count; k++) f[N + k] = -s->drives[k].load;
    s->any_slips = false;
    for (int p = 0; p < s->pair_count; p++) {
        contact_pair *pair = &s->pairs[p];
        evaluate_pair(s, q, x, pair);
        add_transposed(pair, pair->r, sum);
        if (s->drive_count > 0) take_from_drives(s, pair, f);
    }
    for (int k = 0; k < N; k++) {
        f[k] = x[k] - s->problem->step * (sum[k][0] + sum[k][1]);
        norm2 += f[k] * f[k];
    }
    for (int k = 0; k < s->drive_count; k++) norm2 += f[N + k] * f[N + k];
    return sqrt(norm2);
}

/* The square of the sizes of all impulses on a drive */
static double drive_size2(const single_body *s, int k)
{
    double size = fabs(s->drives[k].load);
    for (int p = 0; p < s->pair_count; p++)
        for (int lane = 0; lane < 2; lane++)
            for (int row = 0; row < 3 && s->pairs[p].drive[lane] == k; row++)
                size += s->problem->step * fabs(s->pairs[p].d[row][lane] * s->pairs[p].r[row][lane]);
    return size * size;
}

/* The start is the velocity that the forces of the last step would give now. The scale is the size of the impulses that
 * act there, as magnitudes. */
static double start(single_body *s)
{
    double h = s->problem->step, loads[N], sum2 = 0, *q = s->x;
    const double *t = s->u.t, *external = s->body->external;
    lanes sum[N], size[N];
    for (int k = 0; k < N; k++) sum[k] = size[k] = both(0);
    for (int p = 0; p < s->pair_count; p++) {
        contact_pair *pair = &s->pairs[p];
        lanes force[ROWS];
        for (int row = 0; row < ROWS; row++)
            force[row] = two(pair->contact[0]->force[row], pair->contact[1] ? pair->contact[1]->force[row] : 0);
        add_transposed(pair, force, sum);
    }
    for (int k = 0; k < N; k++) q[k] = h * (sum[k][0] + sum[k][1]);
    double norm = evaluate(s, s->x, s->f);
    for (int p = 0; p < s->pair_count; p++) add_magnitudes(&s->pairs[p], s->pairs[p].r, size);
    for (int k = 0; k < 3; k++) loads[k] = fabs(s->u.linear * external[k]);
    loads[3] = fabs(t[0] * external[3]);
    loads[4] = fabs(t[1] * external[3]) + fabs(t[3] * external[4]);
    loads[5] = fabs(t[2] * external[3]) + fabs(t[4] * external[4]) + fabs(t[5] * external[5]);
    for (int k = 0; k < N; k++) {
        double part = h * (size[k][0] + size[k][1] + loads[k]) + fabs(q[k]);
        sum2 += part * part;
    }
    for (int k = 0; k < s->drive_count; k++) sum2 += drive_size2(s, k);
    s->scale = sum2 > 0 ? sqrt(sum2) : 1;
    return norm;
}

/* jacobian += h G^T D G of a contact that slips */
static void add_slipping(const single_body *s, const contact_pair *pair, int lane, double *jacobian)
{
    int rows = (int)pair->contact[lane]->model;
    double weighted[ROWS][N] = {{0}};
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < rows; j++)
            for (int k = 0; k < N; k++)
                weighted[i][k] += s->problem->step * pair->slipping[lane][i * rows + j] * pair->g[j][k][lane];
    for (int k = 0; k < N; k++)
        for (int i = 0; i < rows; i++)
            for (int l = 0; l < N; l++) jacobian[N * k + l] += pair->g[i][k][lane] * weighted[i][l];
}

/* The generalized Jacobian (19), all of it: 1 + h sum G^T D G */
static void assemble(const single_body *s, double *jacobian)
{
    lanes sum[N * N];
    for (int k = 0; k < N * N; k++) sum[k] = both(0);
    for (int p = 0; p < s->pair_count; p++) {
        const contact_pair *pair = &s->pairs[p];
        for (int k = 0; k < N; k++) {
            lanes weighted[ROWS];
            for (int row = 0; row < ROWS; row++) weighted[row] = pair->slope[row] * pair->g[row][k];
            for (int l = 0; l <= k; l++) {
                lanes part = weighted[0] * pair->g[0][l] + weighted[1] * pair->g[1][l] + weighted[2] * pair->g[2][l];
                if (l >= LINEAR) part += weighted[3] * pair->g[3][l];
                sum[N * k + l] += part;
            }
        }
    }
    for (int k = 0; k < N; k++)
        for (int l = 0; l <= k; l++)
            jacobian[N * k + l] = jacobian[N * l + k] =
                (k == l) + s->problem->step * (sum[N * k + l][0] + sum[N * k + l][1]);
    for (int p = 0; p < s->pair_count && s->any_slips; p++)
        for (int lane = 0; lane < 2; lane++)
            if (s->pairs[p].slips[lane]) add_slipping(s, &s->pairs[p], lane, jacobian);
}

/* Adds what a contact has in its drive's b, c and e. */
static void add_to_drive(const single_body *s, const contact_pair *pair, int lane, drive *to)
{
    int rows = (int)pair->contact[lane]->model;
    double gives[ROWS] = {0}, takes[ROWS] = {0}; /* D d, d^T D */
    for (int i = 0; i < 3; i++) {
        if (!pair->slips[lane]) gives[i] = takes[i] = pair->slope[i][lane] * pair->d[i][lane];
        for (int j = 0; j < rows && pair->slips[lane]; j++) {
            takes[j] += pair->d[i][lane] * pair->slipping[lane][i * rows + j];
            gives[j] += pair->slipping[lane][j * rows + i] * pair->d[i][lane];
        }
    }
    for (int row = 0; row < ROWS; row++) {
        double give = s->problem->step * gives[row], take = s->problem->step * takes[row];
        for (int k = 0; k < N; k++) {
            to->b[k] += pair->g[row][k][lane] * give;
            to->c[k] += take * pair->g[row][k][lane];
        }
        if (row < 3) to->e += pair->d[row][lane] * give;
    }
}

/* Eliminates the speeds of the drives from the Jacobian and from the right hand side. Returns false where nothing
 * resists a drive. */
static bool eliminate_drives(single_body *s, double *jacobian, double *rhs)
{
    for (int k = 0; k < s->drive_count; k++) {
        drive *of = &s->drives[k];
        memset(of->b, 0, sizeof of->b);
        memset(of->c, 0, sizeof of->c);
        of->e = 0;
        for (int p = 0; p < s->pair_count; p++)
            for (int lane = 0; lane < 2; lane++)
                if (s->pairs[p].drive[lane] == k && s->pairs[p].contact[lane]) add_to_drive(s, &s->pairs[p], lane, of);
        if (!(of->e > 0)) return false;
        for (int i = 0; i < N; i++) {
            double part = of->b[i] / of->e;
            rhs[i] -= part * s->f[N + k];
            for (int j = 0; j < N; j++) jacobian[N * i + j] -= part * of->c[j];
        }
    }
    return true;
}

/* x = A^-1 x for a symmetric A, of which the lower triangle is used up: A = L D L^T. A is the identity and more, so
 * that no pivot is less than 1. */
static void solve_symmetric(double *a, double *x)
{
    double over[N];
#pragma GCC unroll 6
    for (int j = 0; j < N; j++) {
        double factor[N];
        over[j] = 1 / a[N * j + j];
#pragma GCC unroll 6
        for (int i = j + 1; i < N; i++) {
            factor[i] = a[N * i + j] * over[j];
#pragma GCC unroll 6
            for (int k = j + 1; k <= i; k++) a[N * i + k] -= factor[i] * a[N * k + j];
            x[i] -= factor[i] * x[j];
        }
    }
#pragma GCC unroll 6
    for (int j = N - 1; j >= 0; j--) {
#pragma GCC unroll 6
        for (int i = j + 1; i < N; i++) x[j] -= a[N * i + j] * x[i];
        x[j] *= over[j];
    }
}

/* step = V^-1 F. Returns false where V is singular. */
static bool newton_step(single_body *s, double *step)
{
    double jacobian[N * N], scratch[N];
    int pivot[N];
    assemble(s, jacobian);
    memcpy(step, s->f, N * sizeof *step);
    if (!eliminate_drives(s, jacobian, step)) return false;
    if (!s->any_slips) {
        solve_symmetric(jacobian, step);
    } else {
        if (!pinch_lu_factor(N, jacobian, pivot, scratch)) return false;
        pinch_lu_solve(N, jacobian, pivot, step, step);
    }
    for (int k = 0; k < s->drive_count; k++) {
        const drive *of = &s->drives[k];
        double left = s->f[N + k];
        for (int i = 0; i < N; i++) left -= of->c[i] * step[i];
        step[N + k] = left / of->e;
    }
    return true;
}

/* Takes full Newton steps, as long as one pays. Returns whether ||F|| came within the tolerance. */
static bool iterate(single_body *s, const pinch_solver_settings *settings, double norm, pinch_solver_result *solve)
{
    enum { MOST_STEPS = 8 };
    static const double PAYS = 0.5;
    int most = settings->max_iterations < MOST_STEPS ? settings->max_iterations : MOST_STEPS;
    norm /= s->scale;
    while (norm > settings->goal && solve->iterations < most) {
        double *x = s->trial_x, *f = s->trial_f;
        if (!newton_step(s, x)) break;
        for (int k = 0; k < N + s->drive_count; k++) x[k] = s->x[k] - x[k];
        double next = evaluate(s, x, f) / s->scale;
        if (!(next <= PAYS * norm)) { /* a NaN compares false */
            (void)evaluate(s, s->x, s->f);
            break;
        }
        s->trial_x = s->x;
        s->trial_f = s->f;
        s->x = x;
        s->f = f;
        norm = next;
        solve->iterations++;
    }
    solve->newton_steps = solve->iterations;
    solve->residual = norm;
    return norm <= settings->tolerance;
}

static void read_back(const single_body *s, pinch_problem *problem)
{
    pinch_body *body = &problem->bodies[s->body - problem->bodies];
    double moved[N];
    pinch_root_apply(&s->u, s->x, moved);
    for (int k = 0; k < s->drive_count; k++) {
        double *end = problem->bodies[s->drives[k].body].velocity_end;
        for (int i = 0; i < 3; i++) {
            end[i] = s->drives[k].axis[i] * s->x[N + k];
            end[3 + i] = 0;
        }
    }
    for (int k = 0; k < N; k++) body->velocity_end[k] = body->velocity[k] + moved[k];
    for (int k = 0; k < problem->contact_count; k++) {
        const contact_pair *pair = &s->pairs[k / 2];
        int lane = k % 2;
        double force[ROWS], velocity[ROWS];
        for (int row = 0; row < ROWS; row++) {
            force[row] = pair->r[row][lane];
            velocity[row] = pair->w[row][lane];
        }
        pinch_contact_state state = pair->slips[lane]    ? PINCH_CONTACT_SLIP
                                    : pair->sticks[lane] ? PINCH_CONTACT_STICK
                                                         : PINCH_CONTACT_OPEN;
        pinch_contact_end end = {.rows = (int)problem->contacts[k].model,
                                 .state = state,
                                 .force = force,
                                 .velocity = velocity,
                                 .sticking = pair->sticks[lane] ? ~0u : 0,
                                 .exact_velocity = true};
        pinch_contact_law_finish(&end, problem->step, &problem->contacts[k]);
    }
}

/* Sets up the drives. Their speeds start as they were. */
static void put_all_drives(single_body *s)
{
    const pinch_problem *problem = s->problem;
    double h = problem->step;
    for (int b = 0; b < problem->body_count; b++) {
        const pinch_body *body = &problem->bodies[b];
        if (body->mass > 0) {
            s->body = body;
            continue;
        }
        double speed = 0, unit2 = 0;
        drive *to = &s->drives[s->drive_count];
        to->body = b;
        to->load = 0;
        pinch_drive_direction(problem, b, to->axis);
        for (int i = 0; i < 3; i++) {
            to->load += h * to->axis[i] * body->drive_axis[i] * body->drive_force;
            speed += to->axis[i] * body->velocity[i];
            unit2 += to->axis[i] * to->axis[i];
        }
        s->x[N + s->drive_count++] = speed / unit2;
    }
}

pinch_status pinch_single_body_solve(pinch_arena *arena, pinch_problem *problem, const pinch_solver_settings *settings,
                                     pinch_solver_result *result)
{
    single_body s = {.problem = problem, .pair_count = (problem->contact_count + 1) / 2};
    int unknowns = N + problem->body_count - 1;
    *result = (pinch_solver_result){.status = PINCH_SOLVE_MAX_ITERATIONS};
    s.pairs = PINCH_ARENA_ARRAY(arena, contact_pair, s.pair_count + 1);
    s.drives = PINCH_ARENA_ARRAY(arena, drive, problem->body_count);
    s.x = PINCH_ARENA_ARRAY(arena, double, 4 * unknowns);
    if (arena->failed) return PINCH_OUT_OF_MEMORY;
    s.f = s.x + unknowns;
    s.trial_x = s.f + unknowns;
    s.trial_f = s.trial_x + unknowns;
    put_all_drives(&s);
    if (!pinch_root_inverse_of(s.body, &s.u)) return PINCH_INVALID_ARGUMENT;
    for (int p = 0; p < s.pair_count; p++) put_pair(&s, 2 * p, &s.pairs[p]);
    double norm = start(&s);
    if (!isfinite(norm) || !iterate(&s, settings, norm, result)) return PINCH_OK;
    result->status = PINCH_SOLVE_CONVERGED;
    read_back(&s, problem);
    return PINCH_OK;
}
