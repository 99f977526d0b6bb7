#include "system.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void cross(const long double *a, const long double *b, long double *c)
{
    c[0] = a[1] * b[2] - a[2] * b[1];
    c[1] = a[2] * b[0] - a[0] * b[2];
    c[2] = a[0] * b[1] - a[1] * b[0];
}

/* Inverse of the symmetric 3 x 3 matrix by its cofactors. */
static void invert(const double *from, long double *to)
{
    long double row[3][3], cofactor[3][3], determinant = 0;
    for (int i = 0; i < 9; i++) row[i / 3][i % 3] = from[i];
    for (int i = 0; i < 3; i++) cross(row[(i + 1) % 3], row[(i + 2) % 3], cofactor[i]);
    for (int i = 0; i < 3; i++) determinant += row[0][i] * cofactor[0][i];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) to[6 * i + j] = cofactor[j][i] / determinant;
}

static void fill_inverses(exact_system *s)
{
    for (int b = 0; b < s->problem->body_count; b++) {
        const pinch_body *body = &s->problem->bodies[b];
        long double *inverse = s->inverse + 36 * b;
        if (body->mass == 0) continue;
        for (int i = 0; i < 3; i++) inverse[7 * i] = 1 / (long double)body->mass;
        invert(body->inertia, inverse + 21);
    }
}

/* Unit vector `axis` as a row of linear motion at the contact point, or of rotation where `angular`. */
static void direction_row(const pinch_problem *p, const pinch_contact *c, const long double *axis, bool angular,
                          long double *g)
{
    const int body[2] = {c->body1, c->body2};
    for (int side = 0; side < 2; side++) {
        if (body[side] < 0) continue;
        long double sign = side ? -1 : 1, arm[3], moment[3];
        for (int i = 0; i < 3; i++) arm[i] = (long double)c->position[i] - p->bodies[body[side]].position[i];
        cross(arm, axis, moment);
        for (int i = 0; i < 3; i++) {
            g[6 * side + i] = angular ? 0 : sign * axis[i];
            g[6 * side + 3 + i] = sign * (angular ? axis[i] : moment[i]);
        }
    }
}

/* The rounding of the contact's frame must not count, so the second tangent is computed anew in long double. */
static void fill_contact(exact_system *s, int k)
{
    const pinch_contact *c = &s->problem->contacts[k];
    long double axis[3][3];
    for (int i = 0; i < 3; i++) {
        axis[0][i] = c->normal[i];
        axis[1][i] = c->tangent1[i];
    }
    cross(axis[0], axis[1], axis[2]);
    exact_law_of(c, s->problem->step, &s->laws[k]);
    for (int i = 0; i < s->laws[k].rows; i++) {
        int place = s->first[k] + i;
        s->body[place][0] = c->body1;
        s->body[place][1] = c->body2;
        direction_row(s->problem, c, axis[i % 3], i == 3, s->g + 12 * place);
        s->free[place] = c->surface_velocity[i];
    }
}

static void fill_row(exact_system *s, int k)
{
    const pinch_joint_row *row = &s->problem->rows[k];
    int place = s->contact_unknowns + k;
    s->body[place][0] = row->body1;
    s->body[place][1] = row->body2;
    for (int i = 0; i < 6; i++) {
        s->g[12 * place + i] = row->body1 >= 0 ? row->j1[i] : 0;
        s->g[12 * place + 6 + i] = row->body2 >= 0 ? row->j2[i] : 0;
    }
    s->free[place] = -(long double)row->rhs;
}

/* g_i M^-1 g_j, summed over the bodies that both act on. */
static long double coupling(const exact_system *s, int i, int j)
{
    long double sum = 0;
    for (int si = 0; si < 2; si++)
        for (int sj = 0; sj < 2; sj++) {
            int b = s->body[i][si];
            if (b < 0 || b != s->body[j][sj]) continue;
            const long double *gi = s->g + 12 * i + 6 * si, *gj = s->g + 12 * j + 6 * sj,
                              *inverse = s->inverse + 36 * b;
            for (int r = 0; r < 6; r++)
                for (int c = 0; c < 6; c++) sum += gi[r] * inverse[6 * r + c] * gj[c];
        }
    return sum;
}

/* How force unknown i acts along the drive's axis. The drive's speed shows in its motion by the same number. */
static long double along_drive(const exact_system *s, int i, int body)
{
    long double sum = 0;
    for (int side = 0; side < 2; side++)
        for (int k = 0; k < 3 && s->body[i][side] == body; k++)
            sum += s->g[12 * i + 6 * side + k] * s->problem->bodies[body].drive_axis[k];
    return sum;
}

static void fill_matrix(exact_system *s)
{
    const pinch_problem *p = s->problem;
    int n = s->unknowns, forces = s->contact_unknowns + p->row_count;
    for (int i = 0; i < forces; i++) {
        for (int j = 0; j < forces; j++) s->a[i * n + j] = (long double)p->step * coupling(s, i, j);
        for (int side = 0; side < 2; side++) {
            int b = s->body[i][side];
            for (int k = 0; k < 6 && b >= 0 && p->bodies[b].mass > 0; k++)
                s->free[i] += s->g[12 * i + 6 * side + k] * p->bodies[b].velocity[k];
        }
    }
    for (int b = 0; b < p->body_count; b++) {
        int d = s->drive_of[b];
        if (d < 0) continue;
        for (int i = 0; i < forces; i++) s->a[i * n + forces + d] = s->a[(forces + d) * n + i] = along_drive(s, i, b);
        s->free[forces + d] = p->bodies[b].drive_force;
    }
}

/* A moment counts as the force at the largest body's radius. */
static void fill_measures(exact_system *s)
{
    const pinch_problem *p = s->problem;
    double lever = 0;
    for (int b = 0; b < p->body_count; b++) {
        const pinch_body *body = &p->bodies[b];
        lever = fmax(lever, body->radius);
        if (!(body->mass > 0)) continue;
        long double change = 0;
        for (int i = 0; i < 6; i++)
            change += (long double)body->velocity[i] * body->velocity[i] * (i < 3 ? 1 : body->radius * body->radius);
        s->scale = fmaxl(s->scale, body->mass * sqrtl(change) / p->step);
    }
    for (int i = 0; i < s->unknowns; i++) s->measure[i] = 1;
    for (int k = 0; k < p->contact_count; k++)
        if (s->laws[k].rows == 4) s->measure[s->first[k] + 3] = lever;
    for (int k = 0; k < p->row_count; k++) {
        const long double *g = s->g + 12 * (s->contact_unknowns + k);
        bool linear = g[0] != 0 || g[1] != 0 || g[2] != 0 || g[6] != 0 || g[7] != 0 || g[8] != 0;
        if (!linear && lever > 0) s->measure[s->contact_unknowns + k] = lever;
    }
}

static bool allocate(exact_system *s)
{
    size_t n = (size_t)s->unknowns + 1, bodies = (size_t)s->problem->body_count + 1;
    s->body = calloc(n, sizeof *s->body);
    s->g = calloc(12 * n, sizeof *s->g);
    s->a = calloc(n * n, sizeof *s->a);
    s->free = calloc(n, sizeof *s->free);
    s->measure = calloc(n, sizeof *s->measure);
    s->inverse = calloc(36 * bodies, sizeof *s->inverse);
    return s->body && s->g && s->a && s->free && s->measure && s->inverse;
}

bool exact_system_build(exact_system *s, const pinch_problem *p)
{
    memset(s, 0, sizeof *s);
    s->problem = p;
    s->first = calloc((size_t)p->contact_count + 1, sizeof *s->first);
    s->laws = calloc((size_t)p->contact_count + 1, sizeof *s->laws);
    s->drive_of = calloc((size_t)p->body_count + 1, sizeof *s->drive_of);
    if (!s->first || !s->laws || !s->drive_of) return false;
    for (int k = 0; k < p->contact_count; k++) {
        s->first[k] = s->contact_unknowns;
        s->contact_unknowns += (int)p->contacts[k].model;
    }
    for (int b = 0; b < p->body_count; b++) s->drive_of[b] = p->bodies[b].mass == 0 ? s->drive_count++ : -1;
    s->unknowns = s->contact_unknowns + p->row_count + s->drive_count;
    if (!allocate(s)) return false;
    fill_inverses(s);
    for (int k = 0; k < p->contact_count; k++) fill_contact(s, k);
    for (int k = 0; k < p->row_count; k++) fill_row(s, k);
    fill_matrix(s);
    fill_measures(s);
    return true;
}

void exact_system_free(exact_system *s)
{
    free(s->first);
    free(s->laws);
    free(s->drive_of);
    free(s->body);
    free(s->g);
    free(s->a);
    free(s->free);
    free(s->measure);
    free(s->inverse);
}

/* The equation of a contact: its force less the force that its law gives for the motion. */
static void evaluate_contact(const exact_system *s, int k, const long double *z, const long double *motion,
                             long double limit, long double *f, long double *jacobian)
{
    const exact_law *law = &s->laws[k];
    int n = s->unknowns, first = s->first[k];
    long double w[4] = {0}, r[4], slope[16];
    memcpy(w, motion + first, sizeof *w * (size_t)law->rows);
    exact_law_force(law, w, limit, r, slope);
    for (int i = 0; i < law->rows; i++) {
        long double *row = jacobian + (size_t)(first + i) * n;
        f[first + i] = z[first + i] - r[i];
        for (int j = 0; j < n; j++) {
            row[j] = j == first + i ? 1 : 0;
            for (int l = 0; l < law->rows; l++) row[j] -= slope[4 * i + l] * s->a[(first + l) * n + j];
        }
    }
}

/* The equation of a joint row: its force less the force, held in its limits, that would remove the row's own error. */
static void evaluate_row(const exact_system *s, int k, const long double *z, const long double *motion, long double *f,
                         long double *jacobian)
{
    const pinch_joint_row *joint = &s->problem->rows[k];
    int n = s->unknowns, i = s->contact_unknowns + k;
    long double *row = jacobian + (size_t)i * n, gives = s->a[i * n + i] + joint->cfm;
    memset(row, 0, sizeof *row * (size_t)n);
    if (!(gives > 0)) { /* a row that moves nothing has no force */
        f[i] = z[i];
        row[i] = 1;
        return;
    }
    long double wanted = z[i] - (motion[i] + joint->cfm * z[i]) / gives;
    if (wanted <= joint->low || wanted >= joint->high) {
        f[i] = z[i] - (wanted <= joint->low ? joint->low : joint->high);
        row[i] = 1;
        return;
    }
    f[i] = z[i] - wanted;
    for (int j = 0; j < n; j++) row[j] = s->a[i * n + j] / gives;
    row[i] += joint->cfm / gives;
}

void exact_system_evaluate(const exact_system *s, const long double *z, const long double *limit, long double *f,
                           long double *jacobian)
{
    int n = s->unknowns, forces = n - s->drive_count;
    long double *motion = f; /* each part of it is used before it is overwritten */
    for (int i = 0; i < n; i++) {
        motion[i] = s->free[i];
        for (int j = 0; j < n; j++) motion[i] += s->a[i * n + j] * z[j];
    }
    for (int k = 0; k < s->problem->contact_count; k++)
        evaluate_contact(s, k, z, motion, limit ? limit[k] : -1, f, jacobian);
    for (int k = 0; k < s->problem->row_count; k++) evaluate_row(s, k, z, motion, f, jacobian);
    memcpy(jacobian + (size_t)forces * n, s->a + (size_t)forces * n, sizeof *jacobian * (size_t)(n * s->drive_count));
}

long double exact_system_error(const exact_system *s, const long double *f)
{
    long double largest = 0;
    for (int i = 0; i < s->unknowns; i++) {
        long double error = fabsl(f[i]) / s->measure[i];
        if (!(error <= largest)) largest = error; /* a NaN is kept */
    }
    return largest;
}

long double exact_system_force(const exact_system *s, const long double *z)
{
    long double largest = 0;
    for (int i = 0; i < s->unknowns - s->drive_count; i++) largest = fmaxl(largest, fabsl(z[i]) / s->measure[i]);
    for (int b = 0; b < s->problem->body_count; b++)
        if (s->drive_of[b] >= 0) largest = fmaxl(largest, s->problem->bodies[b].drive_force);
    return largest;
}

void exact_system_velocity(const exact_system *s, const long double *z, int body, double velocity[6])
{
    const pinch_problem *p = s->problem;
    const pinch_body *b = &p->bodies[body];
    int forces = s->unknowns - s->drive_count, drive = s->drive_of[body];
    long double push[6] = {0};
    if (drive >= 0) {
        for (int i = 0; i < 6; i++) velocity[i] = i < 3 ? (double)(z[forces + drive] * b->drive_axis[i]) : 0;
        return;
    }
    for (int i = 0; i < forces; i++)
        for (int side = 0; side < 2; side++)
            for (int k = 0; k < 6 && s->body[i][side] == body; k++) push[k] += s->g[12 * i + 6 * side + k] * z[i];
    for (int i = 0; i < 6; i++) {
        long double sum = 0;
        for (int k = 0; k < 6; k++) sum += s->inverse[36 * body + 6 * i + k] * push[k];
        velocity[i] = (double)(b->velocity[i] + p->step * sum);
    }
}
