#include "joints/joint_motors.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

pinch_joint_row *pinch_new_row(pinch_row_builder *b, double rhs)
{
    pinch_joint_row *row = &b->rows->row[b->rows->count++];
    memset(row, 0, sizeof *row);
    row->rhs = rhs;
    row->cfm = b->cfm;
    row->low = -INFINITY;
    row->high = INFINITY;
    return row;
}

void pinch_angular_row(pinch_row_builder *b, const double *axis, double rhs)
{
    pinch_joint_row *row = pinch_new_row(b, rhs);
    pinch_v3_copy(row->j1 + 3, axis);
    for (int i = 0; i < 3; i++) row->j2[3 + i] = b->body[1] ? -axis[i] : 0;
}

void pinch_linear_row(pinch_row_builder *b, const double *axis, const double *point1, const double *point2, double rhs)
{
    pinch_joint_row *row = pinch_new_row(b, rhs);
    double arm[3];
    pinch_v3_copy(row->j1, axis);
    pinch_v3_sub(point1, dBodyGetPosition(b->body[0]), arm);
    pinch_v3_cross(arm, axis, row->j1 + 3);
    if (!b->body[1]) return;
    for (int i = 0; i < 3; i++) row->j2[i] = -axis[i];
    pinch_v3_sub(point2, dBodyGetPosition(b->body[1]), arm);
    pinch_v3_cross(arm, row->j2, row->j2 + 3);
}

void pinch_plane_of(const double *axis, double *p, double *q)
{
    pinch_v3_any_perpendicular(axis, p);
    pinch_v3_cross(axis, p, q);
}

pinch_limit_motor pinch_read_motor(dJointID joint, pinch_parameter_getter get, int group)
{
    pinch_limit_motor m = {
        .velocity = get(joint, dParamVel + group),
        .fmax = get(joint, dParamFMax + group),
        .low_stop = get(joint, dParamLoStop + group),
        .high_stop = get(joint, dParamHiStop + group),
        .fudge = get(joint, dParamFudgeFactor + group),
        .normal_cfm = get(joint, dParamCFM + group),
        .stop_erp = get(joint, dParamStopERP + group),
        .stop_cfm = get(joint, dParamStopCFM + group),
        .bounce = get(joint, dParamBounce + group),
    };
    return m;
}

static double velocity_along(const pinch_row_builder *b, const pinch_joint_row *row)
{
    double v = 0;
    for (int side = 0; side < 2 && b->body[side]; side++) {
        const double *j = side ? row->j2 : row->j1;
        v += pinch_v3_dot(j, dBodyGetLinearVel(b->body[side])) + pinch_v3_dot(j + 3, dBodyGetAngularVel(b->body[side]));
    }
    return v;
}

/* A motor that runs into its stop: ODE drops its row and applies the force itself. */
static void apply_motor(pinch_row_builder *b, const pinch_joint_row *row, const pinch_limit_motor *m, bool at_low)
{
    double force = m->velocity > 0 || (m->velocity == 0 && !at_low) ? m->fmax : -m->fmax;
    bool away = at_low ? m->velocity > 0 : m->velocity < 0;
    if (away) force *= m->fudge;
    for (int i = 0; i < 6; i++) {
        b->rows->applied[0][i] += force * row->j1[i];
        b->rows->applied[1][i] += force * row->j2[i];
    }
}

void pinch_limit_motor_row(pinch_row_builder *b, const pinch_limit_motor *m, const double *axis, bool rotational,
                           bool limited, double position)
{
    bool stops = limited && m->low_stop <= m->high_stop;
    bool at_low = stops && position <= m->low_stop, at_high = stops && !at_low && position >= m->high_stop;
    bool powered = m->fmax > 0;
    if (!powered && !at_low && !at_high) return;

    pinch_joint_row *row = pinch_new_row(b, m->velocity);
    pinch_v3_copy(row->j1 + (rotational ? 3 : 0), axis);
    if (b->body[1]) {
        for (int i = 0; i < 3; i++) row->j2[(rotational ? 3 : 0) + i] = -axis[i];
        if (!rotational) {
            double half[3];
            pinch_v3_sub(dBodyGetPosition(b->body[1]), dBodyGetPosition(b->body[0]), half);
            pinch_v3_scale(half, 0.5);
            pinch_v3_cross(half, axis, row->j1 + 3);
            pinch_v3_copy(row->j2 + 3, row->j1 + 3);
        }
    }
    row->cfm = m->normal_cfm;
    row->low = -m->fmax;
    row->high = m->fmax;
    if (!at_low && !at_high) return;

    bool fixed = m->low_stop == m->high_stop;
    if (powered && !fixed) apply_motor(b, row, m, at_low);
    row->rhs = -m->stop_erp / b->h * (position - (at_low ? m->low_stop : m->high_stop));
    row->cfm = m->stop_cfm;
    row->low = fixed || at_high ? -INFINITY : 0;
    row->high = fixed || at_low ? INFINITY : 0;
    if (fixed || !(m->bounce > 0)) return;
    double rebound = -m->bounce * velocity_along(b, row);
    if (at_low ? rebound > fmax(row->rhs, 0) : rebound < fmin(row->rhs, 0)) row->rhs = rebound;
}
