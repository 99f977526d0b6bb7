/* Bodies that are moved along a prescribed path. */
#include "world.h"

#include <math.h>

/* The angular velocity that turns orientation a into b in h seconds. */
void world_turning_velocity(const double a[4], const double b[4], double h, double w[3])
{
    dQuaternion turn; /* b a^-1 */
    dQMultiply2(turn, b, a);
    double sine = sqrt(turn[1] * turn[1] + turn[2] * turn[2] + turn[3] * turn[3]);
    double angle = 2 * atan2(sine, fabs(turn[0])), scale = sine > 0 ? angle / (sine * h) : 0;
    if (turn[0] < 0) scale = -scale;
    for (int i = 0; i < 3; i++) w[i] = scale * turn[1 + i];
}

void world_move_body(dBodyID body, const world_pose *from, const world_pose *to, double h)
{
    double turning[3], way[3];
    world_turning_velocity(from->orientation, to->orientation, h, turning);
    for (int i = 0; i < 3; i++) way[i] = (to->position[i] - from->position[i]) / h;
    dBodySetLinearVel(body, way[0], way[1], way[2]);
    dBodySetAngularVel(body, turning[0], turning[1], turning[2]);
}

static bool stands(dBodyID body)
{
    const double *v = dBodyGetLinearVel(body), *turning = dBodyGetAngularVel(body);
    return v[0] == 0 && v[1] == 0 && v[2] == 0 && turning[0] == 0 && turning[1] == 0 && turning[2] == 0;
}

void world_put_body(dBodyID body, const world_pose *pose)
{
    if (stands(body)) return;
    dBodySetPosition(body, pose->position[0], pose->position[1], pose->position[2]);
    dBodySetQuaternion(body, pose->orientation);
}
