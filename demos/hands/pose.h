#ifndef PINCH_HANDS_POSE_H
#define PINCH_HANDS_POSE_H

#include "common/vector.h"

#include <string.h>

/* A position (m) and an orientation: where a frame is in another one. */
typedef struct hand_pose {
    double position[3];
    double orientation[4]; /* (w, x, y, z), unit norm */
} hand_pose;

static inline hand_pose pose_identity(void)
{
    return (hand_pose){.orientation = {1, 0, 0, 0}};
}

/* The point x of the frame, in the outer frame. */
static inline void pose_point(const hand_pose *p, const double x[3], double out[3])
{
    scene_rotate(p->orientation, x, out);
    scene_add_scaled(out, 1, p->position);
}

/* False, and q = 1, for a quaternion without a direction. */
static inline bool pose_normalize(double q[4])
{
    double length = hypot(hypot(q[0], q[1]), hypot(q[2], q[3]));
    bool good = length > 1e-14 && isfinite(length);
    for (int i = 0; i < 4; i++) q[i] = good ? q[i] / length : (i == 0);
    return good;
}

/* The inner frame, given in the middle one, in the outer one. */
static inline hand_pose pose_product(const hand_pose *middle, const hand_pose *inner)
{
    hand_pose p;
    pose_point(middle, inner->position, p.position);
    scene_quaternion_product(middle->orientation, inner->orientation, p.orientation);
    pose_normalize(p.orientation);
    return p;
}

/* The point x of the outer frame, in the frame. */
static inline void pose_point_back(const hand_pose *p, const double x[3], double out[3])
{
    double d[3];
    scene_subtract(x, p->position, d);
    scene_rotate_back(p->orientation, d, out);
}

static inline void pose_matrix(const double q[4], double r[9])
{
    for (int j = 0; j < 3; j++) {
        double e[3] = {0}, column[3];
        e[j] = 1;
        scene_rotate(q, e, column);
        for (int i = 0; i < 3; i++) r[3 * i + j] = column[i];
    }
}

#endif
