/* What moves a hand in a step: its base, its drives. And what its joints do at the step's end. */
#include "world_hand.h"

#include "common/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ODE multiplies the force of a motor at its stop, so that it must not be infinite. */
static const double ODE_MOST_FORCE = 1e4; /* N or N m */

/* ---- The base. ---- */

void world_move_hand_bases(world *w, double t0, double t1)
{
    for (int k = 0; k < w->hand_count; k++) {
        world_pose from, to;
        scene_hand_pose(w->scene, w->hands[k].hand, t0, from.position, from.orientation);
        scene_hand_pose(w->scene, w->hands[k].hand, t1, to.position, to.orientation);
        world_move_body(w->hands[k].base, &from, &to, t1 - t0);
    }
}

void world_put_hand_bases(world *w, double t1)
{
    for (int k = 0; k < w->hand_count; k++) {
        world_pose pose;
        scene_hand_pose(w->scene, w->hands[k].hand, t1, pose.position, pose.orientation);
        world_put_body(w->hands[k].base, &pose);
    }
}

/* ---- The coordinates. ---- */

/* As Pinch has them: a slider's force acts half way between the centres, so that a parent that turns counts too. */
static void begin_rows(world_joint *j)
{
    dVector3 axis;
    double half[3];
    memset(j->row, 0, sizeof j->row);
    if (j->of->type == HAND_HINGE) {
        dJointGetHingeAxis(j->joint, axis);
        for (int i = 0; i < 3; i++) {
            j->row[0][3 + i] = axis[i];
            j->row[1][3 + i] = -axis[i];
        }
        return;
    }
    dJointGetSliderAxis(j->joint, axis);
    scene_subtract(dBodyGetPosition(j->parent), dBodyGetPosition(j->body), half);
    for (int i = 0; i < 3; i++) {
        half[i] *= 0.5;
        j->row[0][i] = axis[i];
        j->row[1][i] = -axis[i];
    }
    scene_cross(half, axis, j->row[0] + 3);
    memcpy(j->row[1] + 3, j->row[0] + 3, 3 * sizeof(double));
}

double world_joint_rate(const world_joint *j)
{
    const dBodyID body[2] = {j->body, j->parent};
    double rate[2];
    for (int k = 0; k < 2; k++)
        rate[k] =
            scene_dot(j->row[k], dBodyGetLinearVel(body[k])) + scene_dot(j->row[k] + 3, dBodyGetAngularVel(body[k]));
    return rate[0] + rate[1];
}

/* ---- The drives. ---- */

static double ode_position(const world_joint *j)
{
    return j->of->type == HAND_HINGE ? dJointGetHingeAngle(j->joint) : dJointGetSliderPosition(j->joint);
}

static void push(const world_joint *j, double force)
{
    if (j->of->type == HAND_HINGE)
        dJointAddHingeTorque(j->joint, force);
    else
        dJointAddSliderForce(j->joint, force);
}

static void set_motor(const world_joint *j, double speed, double most)
{
    void (*set)(dJointID, int, dReal) = j->of->type == HAND_HINGE ? dJointSetHingeParam : dJointSetSliderParam;
    set(j->joint, dParamVel, speed);
    set(j->joint, dParamFMax, fmin(most, ODE_MOST_FORCE));
}

/* The speed that a motor of ODE's is to have, so that it does what position control would do to a free joint. */
static double motor_speed(const scene_control *c, double error, double h)
{
    return c->type == SCENE_VELOCITY_CONTROL ? c->target->value : c->kp * error / (h * c->kp + c->kd);
}

bool world_control_is_servo(const scene_control *c)
{
    if (!(c->most_force > scene_control_middle(c))) return false; /* one force alone is allowed */
    if (!(c->kp > 0 || c->kd > 0)) return false;
    return c->type == SCENE_POSITION_CONTROL || c->type == SCENE_VELOCITY_CONTROL ||
           (c->type == SCENE_TORQUE_CONTROL && c->kd > 0);
}

/* A bound that is not the same both ways is reached in two parts, whose sum is rounded. */
bool world_control_is_saturated(const scene_control *c, double force)
{
    double rounding = c->least_force == -c->most_force ? 0 : 1e-12 * c->max_force;
    return force >= c->most_force - rounding || force <= c->least_force + rounding;
}

/* The force of a drive that is no servo: a torque but for its damping, or what its bounds leave of a law without gains
 * or of any law where they allow one force alone. */
static double torque_at(const scene_control *c, double target)
{
    double asked = c->type == SCENE_TORQUE_CONTROL ? target + c->bias : 0;
    return fmin(fmax(asked, c->least_force), c->most_force);
}

/* Sets a servo's law for a target, where the coordinate is 0 at `zero`, and returns the force that acts beside it. A
 * torque T with the damping kd is a drive by speed: T - kd q' = kd (T / kd - q'). A servo's bound is the same both
 * ways: where that of the control is not, the middle of it acts beside the servo, whose law has as much less. */
static double set_law(const scene_control *c, double target, double zero, pinch_servo *law)
{
    double middle = scene_control_middle(c), torque = c->bias - middle;
    law->kp = c->kp;
    law->kd = c->kd;
    law->max_force = c->most_force - middle;
    if (c->type == SCENE_POSITION_CONTROL)
        law->target = target - zero - (middle == 0 ? 0 : middle / c->kp);
    else
        law->rate =
            c->type == SCENE_VELOCITY_CONTROL ? target - (middle == 0 ? 0 : middle / c->kd) : (target + torque) / c->kd;
    return middle;
}

static void drive_by_pinch(world *w, world_joint *j)
{
    pinch_servo law = pinch_default_servo();
    j->pushed = set_law(j->control, j->target, j->zero, &law);
    if (j->pushed != 0) push(j, j->pushed);
    world_keep_status(w, pinch_ode_set_servo(w->plugin, j->joint, 0, &law));
}

static void drive_joint(world *w, world_joint *j, double t1)
{
    const scene_control *c = j->control;
    double h = w->scene->step;
    j->start_position = j->position;
    j->own_torque = j->pushed = 0;
    if (c->type == SCENE_UNDRIVEN) return;
    j->target = scene_target_at(c, t1);
    if (w->plugin && world_control_is_servo(c)) {
        drive_by_pinch(w, j);
    } else if (w->plugin || c->type == SCENE_TORQUE_CONTROL) {
        j->own_torque = j->pushed = torque_at(c, j->target);
        push(j, j->pushed);
    } else if (c->type == SCENE_VELOCITY_CONTROL) {
        set_motor(j, j->target, c->max_force);
    } else {
        set_motor(j, motor_speed(c, j->target - (ode_position(j) + j->zero), h), c->max_force);
    }
}

/* Where a joint is at its stop, ODE would apply the force of its motor outright, in the stop's direction. */
static void hold_by_friction(const world *w, const world_joint *j)
{
    bool hinge = j->of->type == HAND_HINGE, motor = !w->plugin && j->control->type != SCENE_UNDRIVEN;
    if (!j->of->limited || motor) return;
    double x = ode_position(j);
    dReal (*get)(dJointID, int) = hinge ? dJointGetHingeParam : dJointGetSliderParam;
    void (*set)(dJointID, int, dReal) = hinge ? dJointSetHingeParam : dJointSetSliderParam;
    static const double ROUNDING = 1e-13; /* rad or m: a joint that leans on its stop is at it */
    bool stopped = x <= get(j->joint, dParamLoStop) + ROUNDING || x >= get(j->joint, dParamHiStop) - ROUNDING;
    set(j->joint, dParamFMax, stopped ? 0 : j->of->friction);
}

/* A drive by torque leaves its damping to the joint's own damper, outside of its bound. */
double world_ode_damping(const world_joint *j)
{
    return j->of->damping + (j->control->type == SCENE_TORQUE_CONTROL ? j->control->kd : 0);
}

/* The armature is a damper about the rate that the joint had at the end of the last step, whose base moved as it did
 * then: a base that is accelerated does not push it. ODE's motors are springs and dampers of this step. */
static void set_passive(world *w, const world_joint *j)
{
    double h = w->scene->step, k = j->of->stiffness, d = j->of->damping, a = j->of->armature / h;
    if (j->damper >= 0 && a > 0) {
        pinch_servo law = pinch_default_servo();
        law.kp = k;
        law.kd = d + a;
        law.target = j->of->spring_reference - j->zero;
        law.rate = a * j->velocity / law.kd;
        world_keep_status(w, pinch_ode_set_coupling(w->plugin, j->damper, &law));
    }
    if (j->of->friction > 0) hold_by_friction(w, j);
    if (!j->motor) return;
    double gain = h * k + world_ode_damping(j),
           speed = k * (j->of->spring_reference - j->zero - ode_position(j)) / gain;
    void (*set)(dJointID, int, dReal) = j->of->type == HAND_HINGE ? dJointSetAMotorParam : dJointSetLMotorParam;
    set(j->motor, dParamVel, speed);
    set(j->motor, dParamCFM, 1 / gain);
}

static double tie_position(const world_hand *h, const world_tie *t)
{
    double x = 0;
    for (int i = 0; i < t->terms; i++) x += t->factor[i] * h->joints[t->joint[i]].position;
    return x;
}

static void push_tie(const world_hand *h, const world_tie *t)
{
    for (int i = 0; i < t->terms; i++) push(&h->joints[t->joint[i]], t->factor[i] * t->pushed);
}

/* Pinch ties by rows. */
static void drive_tie_by_pinch(world *w, const world_hand *h, world_tie *t, double t1)
{
    const scene_control *c = t->control;
    const hand_tendon *tendon = t->tendon >= 0 ? &h->hand->model->tendons[t->tendon] : NULL;
    double x = tie_position(h, t);
    if (c) t->pushed = set_law(c, scene_target_at(c, t1), t->offset, &t->law);
    if (t->pushed != 0) push_tie(h, t);
    if (t->is_friction) t->law.target = x - t->offset;
    if (t->dissipates && !t->is_friction) { /* within its rest the spring does nothing */
        t->law.target = fmin(fmax(x, tendon->rest[0]), tendon->rest[1]) - t->offset;
    }
    if (c || t->dissipates) (void)pinch_ode_set_coupling(w->plugin, t->coupling, &t->law);
}

/* ODE gets motors of the single joints: of a mimic one that follows, of a tendon one for each joint. A joint has no
 * second one. */
static void drive_tie_by_ode(const world *w, const world_hand *h, const world_tie *t, double t1)
{
    double h_step = w->scene->step, squares = 0, x = tie_position(h, t);
    if (t->is_further) return;
    for (int i = 0; i < t->terms; i++) squares += t->factor[i] * t->factor[i];
    if (t->tendon < 0) {
        const world_joint *j = &h->joints[t->joint[0]];
        set_motor(j, 0.2 * (t->law.target + t->offset - x) / h_step, ODE_MOST_FORCE);
        return;
    }
    if (!t->control) return;
    double error = scene_target_at(t->control, t1) - x, speed = motor_speed(t->control, error, h_step);
    for (int i = 0; i < t->terms; i++)
        set_motor(&h->joints[t->joint[i]], t->factor[i] * speed / squares, fabs(t->factor[i]) * t->control->max_force);
}

static void drive_tie(world *w, const world_hand *h, world_tie *t, double t1)
{
    const scene_control *c = t->control;
    bool known = c && (w->plugin ? !world_control_is_servo(c) : c->type == SCENE_TORQUE_CONTROL);
    if (known) {
        t->force = t->pushed = torque_at(c, scene_target_at(c, t1));
        push_tie(h, t);
    } else if (w->plugin) {
        drive_tie_by_pinch(w, h, t, t1);
    } else {
        drive_tie_by_ode(w, h, t, t1);
    }
}

void world_relief(const world_joint *j, const double gravity[3], double force[3], double point[3])
{
    for (int i = 0; i < 3; i++) force[i] = -j->relieved * gravity[i];
    dVector3 at;
    dBodyGetRelPointPos(j->body, j->relief[0], j->relief[1], j->relief[2], at);
    scene_copy(at, point);
}

static void relieve(const world *w, world_joint *j)
{
    double at[3], arm[3], *f = j->relief_force, *t = j->relief_torque;
    if (!(j->relieved > 0)) return;
    world_relief(j, w->loads.v[SCENE_GRAVITY], f, at);
    scene_subtract(at, dBodyGetPosition(j->body), arm);
    scene_cross(arm, f, t);
    dBodyAddForce(j->body, f[0], f[1], f[2]);
    dBodyAddTorque(j->body, t[0], t[1], t[2]);
}

void world_drive_hands(world *w, double t1)
{
    for (int k = 0; k < w->hand_count; k++) {
        world_hand *h = &w->hands[k];
        for (int i = 0; i < h->joint_count; i++) {
            if (w->steps == 0) h->joints[i].position = h->hand->start[i];
            begin_rows(&h->joints[i]);
            drive_joint(w, &h->joints[i], t1);
            set_passive(w, &h->joints[i]);
            relieve(w, &h->joints[i]);
        }
        for (int i = 0; i < h->tie_count; i++) drive_tie(w, h, &h->ties[i], t1);
    }
}

/* ---- The read-out. ---- */

/* An angle is followed over whole turns. ODE's rate of a slider leaves out that the parent turns; the rows of the
 * step's start have it, and give the rate that the armature goes on from. */
static void read_position(world_joint *j)
{
    double now = ode_position(j) + j->zero;
    if (j->of->type == HAND_HINGE) now += 2 * M_PI * round((j->position - now) / (2 * M_PI));
    j->position = now;
    j->velocity = j->of->type == HAND_HINGE ? dJointGetHingeAngleRate(j->joint) : world_joint_rate(j);
}

static bool is_at_limit(const hand_joint *j, double position)
{
    static const double NEAR = 1e-6; /* rad or m */
    return j->limited && (position <= j->lower + NEAR || position >= j->upper - NEAR);
}

/* ODE says of its motors only together with the joint what they do; of Pinch's servos each is known. */
static void read_joint(const world *w, world_joint *j)
{
    const scene_control *c = j->control;
    double position, force;
    read_position(j);
    if (w->plugin && pinch_ode_servo_state(w->plugin, j->joint, 0, &position, &force) == PINCH_OK)
        j->own_torque = j->pushed == 0 ? force : j->pushed + force;
    if (!w->plugin && (c->type == SCENE_POSITION_CONTROL || c->type == SCENE_VELOCITY_CONTROL)) j->own_torque = NAN;
    if (!w->plugin && c->type == SCENE_TORQUE_CONTROL && c->kd > 0) j->own_torque = j->pushed - c->kd * j->velocity;
    j->torque = j->own_torque;
    j->at_limit = is_at_limit(j->of, j->position);
    j->saturated = c->type != SCENE_UNDRIVEN && world_control_is_saturated(c, j->own_torque);
}

void world_read_joints(world *w)
{
    for (int k = 0; k < w->hand_count; k++) {
        world_hand *h = &w->hands[k];
        for (int i = 0; i < h->joint_count; i++) read_joint(w, &h->joints[i]);
        for (int i = 0; i < h->tie_count; i++) {
            world_tie *t = &h->ties[i];
            if (t->coupling >= 0) {
                (void)pinch_ode_coupling_state(w->plugin, t->coupling, &t->position, &t->force);
                if (t->pushed != 0) t->force += t->pushed;
            }
            for (int j = 0; t->control && j < t->terms; j++) {
                world_joint *joint = &h->joints[t->joint[j]];
                joint->torque +=
                    t->factor[j] * (w->plugin || t->control->type == SCENE_TORQUE_CONTROL ? t->force : NAN);
                joint->saturated = joint->saturated || world_control_is_saturated(t->control, t->force);
            }
        }
    }
}
