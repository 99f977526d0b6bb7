/*
 * The step in velocities of one free body, written out for its six unknowns u = v+ - v* in world axes: most grasps are
 * an object that fingertips hold, whose motion is prescribed, or which are pressed against it by massless drives. The
 * equations are those of velocity_system.c, with two contacts side by side in all that is done to them, and Newton's
 * method takes full steps alone. What it does not solve is left to the system of any island.
 *
 * A contact's rows G are never written out, but where it slips: the velocity of its point is that of the body there,
 * and its force acts there. With the slopes K = sum of d n n^T over its axes n, and the arm a, its part of A is
 *
 *     h | K      -K [a]     |        [a] x = a x x.
 *       | [a] K  -[a] K [a] |
 *
 * A drive touches the body alone. Its speed y is eliminated: Newton's method solves
 *
 *     | A   b | | du |   | F_u |       A' = A - sum b c^T / e,     dy = (F_y - c^T du) / e,                      (72)
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

/* unknowns; entries of a symmetric matrix of three; rows of a contact, of which torsion is the last */
enum { N = 6, SYMMETRIC = 6, ROWS = 4, TORSION = 3 };

/* The same as pinch_lanes, where the place in memory is known to suit the processor. */
typedef pinch_lanes lanes __attribute__((aligned(PINCH_ARENA_ALIGNMENT)));

/* Two contacts. Nothing acts along rows that one does not have, nor along any of one that is not there: a contact in
 * its place has no stiffness. */
typedef struct contact_pair {
    lanes arm[3];                    /* from the body's centre of mass */
    lanes axis[3][3];                /* the frame as the body sees it */
    lanes d[3];                      /* the rows in the speeds of the drives, which do not turn */
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

typedef struct single_body {
    const pinch_problem *problem;
    const pinch_body *body;
    double light, inverse[SYMMETRIC]; /* of mass and inertia */
    contact_pair *pairs;
    drive *drives;
    int pair_count, drive_count;
    int rows;      /* that a contact has at most: ROWS, or one less where none has torsion */
    double *x, *f; /* unknowns: u, and the speeds of the drives. F is not divided by its scale */
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

static inline lanes dot(const lanes *a, const lanes *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline void cross(const lanes *a, const lanes *b, lanes *c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* The velocity of both contact points, with the body's (linear, angular). */
static inline void point_velocity(const contact_pair *pair, const lanes *v, lanes *at)
{
    cross(v + 3, pair->arm, at);
    for (int i = 0; i < 3; i++) at[i] += v[i];
}

/* Inverts mass and inertia. Returns false where the inertia is singular, or nearly so. */
static bool invert_inertia(single_body *s)
{
    static const double NEARLY = 1e-9; /* its determinant as a part of the product of its diagonal */
    const double *I = s->body->inertia;
    double a = I[4] * I[8] - I[5] * I[7], b = I[2] * I[7] - I[1] * I[8], c = I[1] * I[5] - I[2] * I[4];
    double determinant = I[0] * a + I[3] * b + I[6] * c, over = 1 / determinant;
    s->light = 1 / s->body->mass;
    s->inverse[0] = over * a;
    s->inverse[1] = over * b;
    s->inverse[2] = over * c;
    s->inverse[3] = over * (I[0] * I[8] - I[2] * I[6]);
    s->inverse[4] = over * (I[2] * I[3] - I[0] * I[5]);
    s->inverse[5] = over * (I[0] * I[4] - I[1] * I[3]);
    bool positive = I[0] > 0 && s->inverse[3] > 0 && s->inverse[5] > 0;
    return positive && determinant > NEARLY * (I[0] * I[4] * I[8]) && isfinite(over) && isfinite(s->light);
}

/* v = M^-1 p */
static inline void velocity_of(const single_body *s, const double *p, double *v)
{
    const double *a = s->inverse;
    for (int i = 0; i < 3; i++) v[i] = s->light * p[i];
    v[3] = a[0] * p[3] + a[1] * p[4] + a[2] * p[5];
    v[4] = a[1] * p[3] + a[3] * p[4] + a[4] * p[5];
    v[5] = a[2] * p[3] + a[4] * p[4] + a[5] * p[5];
}

/* p = M v */
static inline void momentum_of(const single_body *s, const double *v, double *p)
{
    const double *I = s->body->inertia;
    for (int i = 0; i < 3; i++) {
        p[i] = s->body->mass * v[i];
        p[3 + i] = I[3 * i] * v[3] + I[3 * i + 1] * v[4] + I[3 * i + 2] * v[5];
    }
}

/* p . M^-1 p, the square of the length of a momentum */
static inline double length2(const single_body *s, const double *p)
{
    double v[N];
    velocity_of(s, p, v);
    return p[0] * v[0] + p[1] * v[1] + p[2] * v[2] + (p[3] * v[3] + p[4] * v[4] + p[5] * v[5]);
}

/* The drive that is a contact's other side, or none. */
static int drive_of(const single_body *s, const pinch_contact *contact)
{
    int body = contact->body1 == s->body - s->problem->bodies ? contact->body2 : contact->body1, k = s->drive_count - 1;
    while (k >= 0 && s->drives[k].body != body) k--;
    return k;
}

/* Takes the rows of the drives, which are on the other side. */
static void put_drives(const single_body *s, const pinch_contact *a, const pinch_contact *b, contact_pair *pair)
{
    static const double NONE[3] = {0, 0, 0};
    const double *along[2];
    pair->drive[0] = drive_of(s, a);
    pair->drive[1] = drive_of(s, b);
    for (int lane = 0; lane < 2; lane++) along[lane] = pair->drive[lane] < 0 ? NONE : s->drives[pair->drive[lane]].axis;
    for (int row = 0; row < 3; row++) {
        pair->d[row] = both(0);
        for (int i = 0; i < 3; i++) pair->d[row] -= pair->axis[row][i] * two(along[0][i], along[1][i]);
    }
}

/* Takes frame and point of both contacts. The body sees them from its side, whichever of the two bodies it is. */
static void put_frames(const single_body *s, const pinch_contact *a, const pinch_contact *b, contact_pair *pair)
{
    int own = (int)(s->body - s->problem->bodies);
    lanes sign = two(a->body1 == own ? 1 : -1, b->body1 == own ? 1 : -1), v[N], at[3];
    const double *position = s->body->position;
    for (int i = 0; i < 3; i++) {
        pair->arm[i] = two(a->position[i], b->position[i]) - position[i];
        pair->axis[0][i] = sign * two(a->normal[i], b->normal[i]);
        pair->axis[1][i] = two(a->tangent1[i], b->tangent1[i]);
    }
    cross(pair->axis[0], pair->axis[1], pair->axis[2]);
    for (int i = 0; i < 3; i++) pair->axis[1][i] *= sign;
    for (int k = 0; k < N; k++) v[k] = both(s->body->velocity[k]);
    point_velocity(pair, v, at);
    for (int row = 0; row < s->rows; row++)
        pair->w0[row] = two(a->surface_velocity[row], b->surface_velocity[row]) +
                        (row < TORSION ? dot(pair->axis[row], at) : dot(pair->axis[0], v + 3));
    if (s->drive_count > 0) put_drives(s, a, b, pair);
}

/* Takes the laws of both contacts. */
static void put_laws(const single_body *s, const pinch_contact *a, const pinch_contact *b, contact_pair *pair)
{
    double h = s->problem->step;
    for (int row = 0; row < s->rows; row++) {
        int kind = row == 0 ? 0 : row < TORSION ? 1 : 2;
        lanes k = two(a->stiffness[kind], b->stiffness[kind]), c = two(a->damping[kind], b->damping[kind]);
        pair->conductance[row] = h * k + c;
        pair->trial[row] = row == 0 ? two(a->depth, b->depth) : two(-a->elastic[row - 1], -b->elastic[row - 1]);
        pair->trial[row] *= k;
    }
    pair->high = two(a->max_force, b->max_force);
    for (int i = 0; i < 2; i++) pair->weight[i] = 1 / two(a->friction[i], b->friction[i]);
    if (s->rows > TORSION) pair->weight[2] = 1 / two(a->torsional_friction, b->torsional_friction);
}

/* Takes the stiffness from one of both contacts in the rows `from` and on. */
static void leave_out(const single_body *s, contact_pair *pair, int lane, int from)
{
    for (int row = from; row < s->rows; row++) {
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
    put_frames(s, a, b, pair);
    put_laws(s, a, b, pair);
    for (int lane = 0; lane < 2; lane++) {
        int rows = pair->contact[lane] ? (int)pair->contact[lane]->model : 0;
        if (rows < s->rows) leave_out(s, pair, lane, rows);
    }
}

/* The force and torque on the body of the forces r of both contacts */
static inline void wrench_of(int rows, const contact_pair *pair, const lanes *r, lanes *wrench)
{
    for (int i = 0; i < 3; i++) wrench[i] = pair->axis[0][i] * r[0] + pair->axis[1][i] * r[1] + pair->axis[2][i] * r[2];
    cross(pair->arm, wrench, wrench + 3);
    for (int i = 0; i < 3 && rows > TORSION; i++) wrench[3 + i] += pair->axis[0][i] * r[TORSION];
}

/* Evaluates the law of a contact that is not known to stick. */
static void project(single_body *s, contact_pair *pair, int lane)
{
    pinch_contact_law law;
    pinch_trial_force trial;
    double w[ROWS], r[ROWS];
    pinch_contact_law_of(pair->contact[lane], 0, &law);
    for (int row = 0; row < s->rows; row++) {
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
static inline void evaluate_pair(single_body *s, int rows, const lanes *v, const double *x, contact_pair *pair)
{
    const lanes zero = both(0);
    lanes trial[ROWS], at[3];
    point_velocity(pair, v, at);
    for (int row = 0; row < 3; row++) pair->w[row] = pair->w0[row] + dot(pair->axis[row], at);
    if (rows > TORSION) pair->w[TORSION] = pair->w0[TORSION] + dot(pair->axis[0], v + 3);
    if (s->drive_count > 0) {
        lanes speed = speeds(pair, x);
        for (int row = 0; row < 3; row++) pair->w[row] += pair->d[row] * speed;
    }
    for (int row = 0; row < rows; row++) trial[row] = pair->trial[row] - pair->conductance[row] * pair->w[row];
    lanes normal = pinch_lanes_choose(trial[0] > zero, trial[0], zero);
    lanes below = pinch_lanes_choose(trial[0] < pair->high, pair->conductance[0], zero);
    normal = pinch_lanes_choose(normal > pair->high, pair->high, normal);
    lanes reach = zero;
    for (int i = 0; i < rows - 1; i++) {
        lanes part = trial[1 + i] * pair->weight[i];
        reach += part * part;
    }
    pinch_lanes_mask presses = normal > zero, sticks = presses & (reach <= normal * normal);
    pair->r[0] = normal;
    pair->slope[0] = pinch_lanes_choose(presses, below, zero);
    for (int row = 1; row < rows; row++) {
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

/* F = (M u, 0) - h sum (G d)^T r - load, equation (17). Returns its length, not yet divided by the scale. */
static inline double evaluate_rows(single_body *s, int rows, const double *x, double *f)
{
    double h = s->problem->step;
    lanes v[N], sum[N], wrench[N];
    for (int k = 0; k < N; k++) {
        v[k] = both(x[k]);
        sum[k] = both(0);
    }
    for (int k = 0; k < s->drive_count; k++) f[N + k] = -s->drives[k].load;
    s->any_slips = false;
    for (int p = 0; p < s->pair_count; p++) {
        contact_pair *pair = &s->pairs[p];
        evaluate_pair(s, rows, v, x, pair);
        wrench_of(rows, pair, pair->r, wrench);
        for (int k = 0; k < N; k++) sum[k] += wrench[k];
        if (s->drive_count > 0) take_from_drives(s, pair, f);
    }
    momentum_of(s, x, f);
    for (int k = 0; k < N; k++) f[k] -= h * (sum[k][0] + sum[k][1]);
    double norm2 = length2(s, f);
    for (int k = 0; k < s->drive_count; k++) norm2 += f[N + k] * f[N + k];
    return sqrt(norm2);
}

/* The same, for as many rows as the contacts have. */
static double evaluate(single_body *s, const double *x, double *f)
{
    return s->rows > TORSION ? evaluate_rows(s, ROWS, x, f) : evaluate_rows(s, TORSION, x, f);
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

/* Adds up the forces and torques of the last step. */
static void add_last_wrenches(const single_body *s, double *total)
{
    lanes sum[N], wrench[N], r[ROWS];
    for (int k = 0; k < N; k++) sum[k] = both(0);
    for (int p = 0; p < s->pair_count; p++) {
        const contact_pair *pair = &s->pairs[p];
        const pinch_contact *const *c = pair->contact;
        for (int row = 0; row < s->rows; row++) r[row] = two(c[0]->force[row], c[1] ? c[1]->force[row] : 0);
        wrench_of(s->rows, pair, r, wrench);
        for (int k = 0; k < N; k++) sum[k] += wrench[k];
    }
    for (int k = 0; k < N; k++) total[k] = sum[k][0] + sum[k][1];
}

/* The length of the impulses that act at the point evaluated last, as magnitudes. */
static double size_of_impulses(const single_body *s)
{
    double h = s->problem->step, size[N], turned[3];
    const double *external = s->body->external, *a = s->inverse;
    lanes sum[N], wrench[N];
    for (int k = 0; k < N; k++) sum[k] = both(0);
    for (int p = 0; p < s->pair_count; p++) {
        wrench_of(s->rows, &s->pairs[p], s->pairs[p].r, wrench);
        for (int k = 0; k < N; k++) sum[k] += pinch_lanes_abs(wrench[k]);
    }
    momentum_of(s, s->x, size);
    for (int k = 0; k < N; k++) size[k] = fabs(size[k]) + h * (sum[k][0] + sum[k][1] + fabs(external[k]));
    turned[0] = fabs(a[0]) * size[3] + fabs(a[1]) * size[4] + fabs(a[2]) * size[5];
    turned[1] = fabs(a[1]) * size[3] + fabs(a[3]) * size[4] + fabs(a[4]) * size[5];
    turned[2] = fabs(a[2]) * size[3] + fabs(a[4]) * size[4] + fabs(a[5]) * size[5];
    double sum2 = s->light * (size[0] * size[0] + size[1] * size[1] + size[2] * size[2]) +
                  (size[3] * turned[0] + size[4] * turned[1] + size[5] * turned[2]);
    for (int k = 0; k < s->drive_count; k++) sum2 += drive_size2(s, k);
    return sqrt(sum2);
}

/* The start is the velocity that the forces of the last step would give now. The scale is the size of the impulses that
 * act there. */
static double start(single_body *s)
{
    double impulse[N];
    add_last_wrenches(s, impulse);
    for (int k = 0; k < N; k++) impulse[k] *= s->problem->step;
    velocity_of(s, impulse, s->x);
    double norm = evaluate(s, s->x, s->f), size = size_of_impulses(s);
    s->scale = size > 0 ? size : 1;
    return norm;
}

/* One contact's rows of G. */
static void rows_of(const contact_pair *pair, int lane, double g[ROWS][N])
{
    lanes lever[3];
    for (int row = 0; row < 3; row++) {
        cross(pair->arm, pair->axis[row], lever);
        for (int i = 0; i < 3; i++) {
            g[row][i] = pair->axis[row][i][lane];
            g[row][3 + i] = lever[i][lane];
        }
    }
    for (int i = 0; i < 3; i++) {
        g[TORSION][i] = 0;
        g[TORSION][3 + i] = pair->axis[0][i][lane];
    }
}

/* jacobian += h G^T D G of a contact that slips */
static void add_slipping(const single_body *s, const contact_pair *pair, int lane, double *jacobian)
{
    int rows = (int)pair->contact[lane]->model;
    double g[ROWS][N], weighted[ROWS][N] = {{0}};
    rows_of(pair, lane, g);
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < rows; j++)
            for (int k = 0; k < N; k++)
                weighted[i][k] += s->problem->step * pair->slipping[lane][i * rows + j] * g[j][k];
    for (int k = 0; k < N; k++)
        for (int i = 0; i < rows; i++)
            for (int l = 0; l < N; l++) jacobian[N * k + l] += g[i][k] * weighted[i][l];
}

/* Lower triangle of a symmetric matrix of three, by rows. */
static inline int entry(int i, int j)
{
    return i * (i + 1) / 2 + j;
}

/* What the contacts have in A, but for h: what the force and the torque of a motion straight on give way by, and the
 * torque of one that turns. */
typedef struct blocks {
    lanes straight[SYMMETRIC]; /* K */
    lanes mixed[3][3];         /* [a] K */
    lanes turning[SYMMETRIC];  /* -[a] K [a], and torsion */
} blocks;

static inline void add_to_blocks(const single_body *s, const contact_pair *pair, blocks *to)
{
    lanes K[3][3], mixed[3][3];
    for (int i = 0; i < 3; i++) {
        lanes weighted[3];
        for (int row = 0; row < 3; row++) weighted[row] = pair->slope[row] * pair->axis[row][i];
        for (int j = 0; j <= i; j++) {
            K[i][j] = K[j][i] =
                weighted[0] * pair->axis[0][j] + weighted[1] * pair->axis[1][j] + weighted[2] * pair->axis[2][j];
            to->straight[entry(i, j)] += K[i][j];
        }
    }
    for (int j = 0; j < 3; j++) {
        lanes moment[3];
        cross(pair->arm, K[j], moment);
        for (int i = 0; i < 3; i++) {
            mixed[i][j] = moment[i];
            to->mixed[i][j] += moment[i];
        }
    }
    for (int i = 0; i < 3; i++) {
        lanes turning[3];
        cross(pair->arm, mixed[i], turning);
        for (int j = 0; j <= i; j++) to->turning[entry(i, j)] += turning[j];
    }
    if (s->rows <= TORSION) return;
    for (int i = 0; i < 3; i++) {
        lanes weighted = pair->slope[TORSION] * pair->axis[0][i];
        for (int j = 0; j <= i; j++) to->turning[entry(i, j)] += weighted * pair->axis[0][j];
    }
}

/* The generalized Jacobian (19): M + h sum G^T D G. What is above its diagonal is needed where it is not symmetric, or
 * is about to change. */
static void assemble(const single_body *s, double *jacobian)
{
    double h = s->problem->step;
    blocks sum;
    for (int k = 0; k < SYMMETRIC; k++) sum.straight[k] = sum.turning[k] = both(0);
    for (int k = 0; k < 9; k++) sum.mixed[k / 3][k % 3] = both(0);
    for (int p = 0; p < s->pair_count; p++) add_to_blocks(s, &s->pairs[p], &sum);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            lanes straight = sum.straight[entry(i, j <= i ? j : i)], turning = sum.turning[entry(i, j <= i ? j : i)];
            lanes mixed = sum.mixed[i][j];
            jacobian[N * (3 + i) + j] = h * (mixed[0] + mixed[1]);
            if (j > i) continue;
            jacobian[N * i + j] = (i == j ? s->body->mass : 0) + h * (straight[0] + straight[1]);
            jacobian[N * (3 + i) + 3 + j] = s->body->inertia[3 * i + j] + h * (turning[0] + turning[1]);
        }
    if (!s->any_slips && s->drive_count == 0) return;
    for (int k = 0; k < N; k++)
        for (int l = 0; l < k; l++) jacobian[N * l + k] = jacobian[N * k + l];
    for (int p = 0; p < s->pair_count && s->any_slips; p++)
        for (int lane = 0; lane < 2; lane++)
            if (s->pairs[p].slips[lane]) add_slipping(s, &s->pairs[p], lane, jacobian);
}

/* Adds what a contact has in its drive's b, c and e. */
static void add_to_drive(const single_body *s, const contact_pair *pair, int lane, drive *to)
{
    int rows = (int)pair->contact[lane]->model;
    double g[ROWS][N], gives[ROWS] = {0}, takes[ROWS] = {0}; /* rows of G, D d, d^T D */
    rows_of(pair, lane, g);
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
            to->b[k] += g[row][k] * give;
            to->c[k] += take * g[row][k];
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

/* x = A^-1 x for a symmetric A, of which the lower triangle is used up: A = L D L^T. A is the body's inertia
 * and more, so that no pivot is less than the inertia's. */
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
    for (int k = 0; k < s->drive_count; k++) {
        double *end = problem->bodies[s->drives[k].body].velocity_end;
        for (int i = 0; i < 3; i++) {
            end[i] = s->drives[k].axis[i] * s->x[N + k];
            end[3 + i] = 0;
        }
    }
    for (int k = 0; k < N; k++) body->velocity_end[k] = body->velocity[k] + s->x[k];
    for (int k = 0; k < problem->contact_count; k++) {
        const contact_pair *pair = &s->pairs[k / 2];
        int lane = k % 2;
        double force[ROWS], velocity[ROWS];
        for (int row = 0; row < s->rows; row++) {
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
    single_body s = {.problem = problem, .pair_count = (problem->contact_count + 1) / 2, .rows = TORSION};
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
    for (int k = 0; k < problem->contact_count; k++)
        if ((int)problem->contacts[k].model > s.rows) s.rows = ROWS;
    if (!invert_inertia(&s)) return PINCH_OK;
    for (int p = 0; p < s.pair_count; p++) put_pair(&s, 2 * p, &s.pairs[p]);
    double norm = start(&s);
    if (!isfinite(norm) || !iterate(&s, settings, norm, result)) return PINCH_OK;
    result->status = PINCH_SOLVE_CONVERGED;
    read_back(&s, problem);
    return PINCH_OK;
}
