#include "joints/row_builder.h"

#include "support/extremes.h"
#include "support/vec3.h"

#include <math.h>
#include <string.h>

const double pinch_unit_axis[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

pinch_joint_row *pinch_new_row(pinch_row_builder *b, double rhs)
{
    pinch_joint_row *row = &b->rows->row[b->rows->count++];
    *row = pinch_free_row;
    row->rhs = rhs;
    row->cfm = b->cfm;
    return row;
}

pinch_joint_row *pinch_angular_row(pinch_row_builder *b, const double *axis, double rhs)
{
    pinch_joint_row *row = pinch_new_row(b, rhs);
    pinch_v3_copy(row->j1 + 3, axis);
    if (!b->body[1]) return row;
    for (int i = 0; i < 3; i++) row->j2[3 + i] = -axis[i];
    return row;
}

pinch_joint_row *pinch_linear_row(pinch_row_builder *b, const double *axis, const double *point1, const double *point2,
                                  double rhs)
{
    pinch_joint_row *row = pinch_new_row(b, rhs);
    double arm[3];
    pinch_v3_copy(row->j1, axis);
    pinch_v3_sub(point1, dBodyGetPosition(b->body[0]), arm);
    pinch_v3_cross(arm, axis, row->j1 + 3);
    if (!b->body[1]) return row;
    for (int i = 0; i < 3; i++) row->j2[i] = -axis[i];
    pinch_v3_sub(point2, dBodyGetPosition(b->body[1]), arm);
    pinch_v3_cross(arm, row->j2, row->j2 + 3);
    return row;
}

void pinch_anchor_rows(pinch_row_builder *b, double erp, const double *anchor_a, const double *anchor_b)
{
    const double *anchor1 = b->reversed ? anchor_b : anchor_a, *anchor2 = b->reversed ? anchor_a : anchor_b;
    double arm1[3], arm2[3] = {0, 0, 0};
    pinch_v3_sub(anchor1, dBodyGetPosition(b->body[0]), arm1);
    if (b->body[1]) pinch_v3_sub(anchor2, dBodyGetPosition(b->body[1]), arm2);
    for (int i = 0; i < 3; i++) { /* arm x e_i = arm_k e_j - arm_j e_k */
        int j = (i + 1) % 3, k = (i + 2) % 3;
        pinch_joint_row *row = pinch_new_row(b, pinch_closing_speed(b, erp, anchor2[i] - anchor1[i]));
        row->j1[i] = 1;
        row->j1[3 + j] = arm1[k];
        row->j1[3 + k] = -arm1[j];
        if (!b->body[1]) continue;
        row->j2[i] = -1;
        row->j2[3 + j] = -arm2[k];
        row->j2[3 + k] = arm2[j];
    }
}

void pinch_plane_of(const double *axis, double *p, double *q)
{
    pinch_v3_any_perpendicular(axis, p);
    pinch_v3_cross(axis, p, q);
}

void pinch_turn_with(dBodyID body, const double *local, double *world)
{
    double turned[3];
    const double *R = body ? dBodyGetRotation(body) : NULL;
    for (int i = 0; i < 3; i++) turned[i] = R ? pinch_v3_dot(R + 4 * i, local) : local[i];
    pinch_v3_copy(world, turned);
}

void pinch_turn_back(dBodyID body, const double *world, double *local)
{
    double turned[3];
    const double *R = body ? dBodyGetRotation(body) : NULL;
    for (int i = 0; i < 3; i++) turned[i] = R ? R[i] * world[0] + R[4 + i] * world[1] + R[8 + i] * world[2] : world[i];
    pinch_v3_copy(local, turned);
}

void pinch_place_of(dBodyID body, const double *local, double *place)
{
    pinch_turn_with(body, local, place);
    if (body) pinch_v3_add_scaled(place, 1, dBodyGetPosition(body));
}

/* Where there is no second body, ODE keeps the vector that was given, with its length. */
bool pinch_second_axis(const pinch_row_builder *b, const double *axis, double axis2[3])
{
    if (pinch_builder_knows(b, PINCH_KNOWS_TURN)) {
        const double *R = b->pose->rotation, *own = b->own_axis;
        double turned[3];
        if (!own) {
            pinch_turn_back(b->body[0], axis, turned);
            own = turned;
        }
        for (int i = 0; i < 3; i++)
            axis2[i] = b->pose->axis_length * (R[i] * own[0] + R[4 + i] * own[1] + R[8 + i] * own[2]);
    } else if (b->axis2) {
        pinch_v3_copy(axis2, b->axis2);
    } else {
        pinch_v3_copy(axis2, axis);
        return false;
    }
    pinch_turn_with(b->body[1], axis2, axis2);
    return true;
}

/* The rotation that takes the first body's axis to the second's is about their common normal. */
bool pinch_axis_rows(pinch_row_builder *b, double erp, const double *axis, const double *p, const double *q)
{
    double other[3], error[3] = {0, 0, 0};
    bool known = pinch_second_axis(b, axis, other);
    if (known) pinch_v3_cross(axis, other, error);
    (void)pinch_angular_row(b, p, pinch_closing_spin(b, erp, pinch_v3_dot(error, p)));
    (void)pinch_angular_row(b, q, pinch_closing_spin(b, erp, pinch_v3_dot(error, q)));
    return known;
}

/* ---- motors and stops ---- */

bool pinch_stops_angle(const pinch_limit_motor *m)
{
    return m->low_stop >= -M_PI || m->high_stop <= M_PI;
}

pinch_limit_motor pinch_read_motor(dJointID joint, pinch_parameter_getter get, int group)
{
    pinch_limit_motor m = {
        .velocity = get(joint, dParamVel + group),
        .fmax = get(joint, dParamFMax + group),
        .low_stop = get(joint, dParamLoStop + group),
        .high_stop = get(joint, dParamHiStop + group),
        .normal_cfm = get(joint, dParamCFM + group),
        .joint = joint,
        .get = get,
        .group = group,
    };
    return m;
}

pinch_stop pinch_read_stop(const pinch_limit_motor *m)
{
    if (!m->get) return m->stop;
    return (pinch_stop){.fudge = m->get(m->joint, dParamFudgeFactor + m->group),
                        .erp = m->get(m->joint, dParamStopERP + m->group),
                        .cfm = m->get(m->joint, dParamStopCFM + m->group),
                        .bounce = m->get(m->joint, dParamBounce + m->group)};
}

/* The velocity that bounces back from a stop. Half way between the centres ODE leaves the bodies' turning out. */
static double velocity_along(const pinch_row_builder *b, const pinch_joint_row *row, bool turning)
{
    double v = 0;
    for (int side = 0; side < 2 && b->body[side]; side++) {
        const double *j = side ? row->j2 : row->j1;
        v += pinch_v3_dot(j, dBodyGetLinearVel(b->body[side]));
        if (turning) v += pinch_v3_dot(j + 3, dBodyGetAngularVel(b->body[side]));
    }
    return v;
}

/* Where a motor runs into its stop, ODE drops the motor's row and applies its force itself. */
static void apply_motor(pinch_row_builder *b, const pinch_joint_row *row, const pinch_limit_motor *m, double fudge,
                        bool at_low)
{
    double force = m->velocity > 0 || (m->velocity == 0 && !at_low) ? m->fmax : -m->fmax;
    bool away = at_low ? m->velocity > 0 : m->velocity < 0;
    if (away) force *= fudge;
    if (!b->rows->applies) memset(b->rows->applied, 0, sizeof b->rows->applied);
    b->rows->applies = true;
    for (int i = 0; i < 6; i++) {
        b->rows->applied[0][i] += force * row->j1[i];
        b->rows->applied[1][i] += force * row->j2[i];
    }
}

static pinch_joint_row *motor_row(pinch_row_builder *b, const pinch_limit_motor *m, const double *axis)
{
    if (!m->linear) return pinch_angular_row(b, axis, m->velocity);
    if (m->point[0]) return pinch_linear_row(b, axis, m->point[0], m->point[1], m->velocity);
    pinch_joint_row *row = pinch_new_row(b, m->velocity);
    pinch_v3_copy(row->j1, axis);
    if (b->body[1]) {
        double half[3];
        for (int i = 0; i < 3; i++) row->j2[i] = -axis[i];
        pinch_v3_sub(dBodyGetPosition(b->body[1]), dBodyGetPosition(b->body[0]), half);
        pinch_v3_scale(half, 0.5);
        pinch_v3_cross(half, axis, row->j1 + 3);
        pinch_v3_copy(row->j2 + 3, row->j1 + 3);
    }
    return row;
}

/* How far a step's rounding may leave a joint from a stop that it leans on, rad or m: light links turn by 1e-10 rad/s
 * and more for it, and by as much as ODE's steps have missed what was solved. A stop that acted in some steps only, as
 * these digits fall, would be run into again and again, and a step without it carries a finger that leans on it far
 * beyond. Within this the row leaves the joint free to go away, and lets it come as far as the stop.
 */
static double stop_rounding(const pinch_row_builder *b, const pinch_limit_motor *m, double stop)
{
    static const double STEPS = 10, MOST = 1e-6; /* as many take most of an error back; m/s, rad/s */
    double noise = pinch_smaller(b->noise[!m->linear], MOST);
    return pinch_larger(1e-10 * pinch_larger(fabs(stop), 1), STEPS * b->h * noise);
}

void pinch_limit_motor_row(pinch_row_builder *b, const pinch_limit_motor *m, const double *axis)
{
    bool stops = m->limited && (m->crossed || m->low_stop <= m->high_stop);
    bool at_low = stops && m->position <= m->low_stop + stop_rounding(b, m, m->low_stop);
    bool at_high = stops && !at_low && m->position >= m->high_stop - stop_rounding(b, m, m->high_stop);
    bool powered = m->fmax > 0;
    if (!powered && !at_low && !at_high) return;

    pinch_joint_row *row = motor_row(b, m, axis);
    row->cfm = m->normal_cfm;
    row->low = -m->fmax;
    row->high = m->fmax;
    if (!at_low && !at_high) {
        b->rows->driven |= 1u << (row - b->rows->row);
        return;
    }

    bool fixed = m->low_stop == m->high_stop;
    const pinch_stop stop = pinch_read_stop(m);
    if (powered && !fixed) apply_motor(b, row, m, stop.fudge, at_low);
    row->rhs = -stop.erp / b->h * (m->position - (at_low ? m->low_stop : m->high_stop));
    row->cfm = stop.cfm;
    row->low = fixed || at_high ? -INFINITY : 0;
    row->high = fixed || at_low ? INFINITY : 0;
    if (fixed || !(stop.bounce > 0)) return;
    double rebound = -stop.bounce * velocity_along(b, row, !m->linear || m->point[0]);
    if (at_low ? rebound > fmax(row->rhs, 0) : rebound < fmin(row->rhs, 0)) row->rhs = rebound;
}
