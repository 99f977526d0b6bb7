/*
 * Closing the loops of a hand: Gauss-Newton on the distances of the anchors, with the shortest step.
 *
 * With the residuals r (3 for each loop) and their derivatives J by the free joints, a step is -J^T (J J^T + e I)^-1 r.
 * A loop of a plane has rows that depend on each other, so e, a small part of the trace, keeps the matrix regular.
 */
#include "reader.h"

#include "common/vector.h"
#include "hands/hand.h"

#include <stdlib.h>
#include <string.h>

typedef struct closing {
    const hand *h;
    const bool *given;
    bool *free_joint;
    hand_pose *links;
    double *trial, *residual, *moved, *jacobian, *matrix, *step;
    size_t rows, joints;
} closing;

static void loop_gap(const closing *c, const hand_loop *loop, double gap[3])
{
    double end[2][3];
    hand_pose frame = pose_identity();
    for (int k = 0; k < 2; k++)
        pose_point(loop->link[k] < 0 ? &frame : &c->links[loop->link[k]], loop->anchor[k], end[k]);
    scene_subtract(end[0], end[1], gap);
}

static double residuals(closing *c, const double *positions, double *out)
{
    double most = 0;
    hand_kinematics(c->h, positions, c->links);
    for (size_t i = 0; i < c->h->loop_count; i++) {
        loop_gap(c, &c->h->loops[i], out + 3 * i);
        most = fmax(most, scene_norm(out + 3 * i));
    }
    return most;
}

/* Central differences; the motions are smooth, so that they are good to ten digits. */
static void differentiate(closing *c, const double *positions)
{
    static const double STEP = 1e-5;
    for (size_t j = 0; j < c->joints; j++) {
        double *column = c->jacobian + j * c->rows;
        memset(column, 0, c->rows * sizeof *column);
        for (int side = -1; side <= 1 && c->free_joint[j]; side += 2) {
            memcpy(c->trial, positions, c->joints * sizeof *positions);
            c->trial[j] += side * STEP;
            hand_follow_couplings(c->h, c->given, c->trial);
            (void)residuals(c, c->trial, c->moved);
            for (size_t i = 0; i < c->rows; i++) column[i] += side * c->moved[i] / (2 * STEP);
        }
    }
}

/* Solves the symmetric, positive definite system in place by elimination. */
static void eliminate(double *a, double *b, size_t n)
{
    for (size_t k = 0; k < n; k++)
        for (size_t i = k + 1; i < n; i++) {
            double factor = a[i * n + k] / a[k * n + k];
            for (size_t j = k; j < n; j++) a[i * n + j] -= factor * a[k * n + j];
            b[i] -= factor * b[k];
        }
    for (size_t k = n; k-- > 0;) {
        for (size_t j = k + 1; j < n; j++) b[k] -= a[k * n + j] * b[j];
        b[k] /= a[k * n + k];
    }
}

static void newton_step(closing *c, double *positions)
{
    static const double REGULAR = 1e-12, FARTHEST = 0.2; /* of the trace; rad or m in a step */
    size_t n = c->rows;
    double trace = 0, most = 0;
    differentiate(c, positions);
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < n; k++) {
            double sum = 0;
            for (size_t j = 0; j < c->joints; j++) sum += c->jacobian[j * n + i] * c->jacobian[j * n + k];
            c->matrix[i * n + k] = sum;
        }
        trace += c->matrix[i * n + i];
    }
    for (size_t i = 0; i < n; i++) c->matrix[i * n + i] += REGULAR * trace + 1e-300;
    eliminate(c->matrix, c->residual, n);
    for (size_t j = 0; j < c->joints; j++) {
        c->step[j] = 0;
        for (size_t i = 0; i < n; i++) c->step[j] -= c->jacobian[j * n + i] * c->residual[i];
        most = fmax(most, fabs(c->step[j]));
    }
    for (size_t j = 0; j < c->joints; j++) {
        const hand_joint *joint = &c->h->joints[j];
        positions[j] += c->step[j] * (most > FARTHEST ? FARTHEST / most : 1);
        if (c->free_joint[j]) positions[j] = fmin(fmax(positions[j], joint->lower), joint->upper);
    }
    hand_follow_couplings(c->h, c->given, positions);
}

scene_loops scene_close_loops(const hand *h, const bool *given, double *positions, double *gap)
{
    enum { ROUNDS = 200 };
    static const double CLOSED = 1e-13, OPEN = 1e-6; /* m */
    size_t rows = 3 * h->loop_count, joints = h->joint_count;
    *gap = 0;
    if (rows == 0) return SCENE_LOOPS_CLOSED;
    closing c = {.h = h, .given = given, .rows = rows, .joints = joints};
    double *numbers = calloc(2 * joints + 2 * rows + joints * rows + rows * rows, sizeof *numbers);
    c.free_joint = calloc(joints, sizeof *c.free_joint);
    c.links = calloc(h->link_count, sizeof *c.links);
    if (numbers && c.free_joint && c.links) {
        c.trial = numbers;
        c.step = c.trial + joints;
        c.residual = c.step + joints;
        c.moved = c.residual + rows;
        c.jacobian = c.moved + rows;
        c.matrix = c.jacobian + joints * rows;
        for (size_t j = 0; j < joints; j++) c.free_joint[j] = !given[j] && h->joints[j].coupling < 0;
        *gap = residuals(&c, positions, c.residual);
        for (int round = 0; round<ROUNDS && * gap> CLOSED; round++) {
            newton_step(&c, positions);
            double now = residuals(&c, positions, c.residual);
            bool settled = now < OPEN && now >= 0.5 * *gap;
            *gap = now;
            if (settled) break;
        }
    }
    bool failed = !numbers || !c.free_joint || !c.links;
    free(numbers);
    free(c.free_joint);
    free(c.links);
    if (failed) return SCENE_LOOPS_NO_MEMORY;
    return *gap <= OPEN ? SCENE_LOOPS_CLOSED : SCENE_LOOPS_OPEN;
}
