#include "joints/hinge_reference.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

static const double SAME = 1e-9; /* rad: two readings of one hinge */
static const double NEAR = 2e-3; /* rad, see hinge_reference.h */
enum { KEPT_STEPS = 1000 };      /* a reference that nobody asks for is dropped after this many to twice as many */

/* What ODE's getters tell of a hinge now. */
typedef struct hinge_state {
    dJointID joint;
    dBodyID body[2];
    bool reversed;
    double angle;    /* as its getter has it, rad */
    dVector3 axis1;  /* in the frame of body[0] */
    dQuaternion now; /* q1^-1 q2 */
} hinge_state;

static void relative_turn(const dBodyID body[2], dQuaternion turn)
{
    static const dQuaternion world = {1, 0, 0, 0};
    dQMultiply1(turn, dBodyGetQuaternion(body[0]), body[1] ? dBodyGetQuaternion(body[1]) : world);
}

static hinge_state read_state(dJointID joint)
{
    hinge_state s = {.joint = joint, .body = {dJointGetBody(joint, 0), dJointGetBody(joint, 1)}};
    dVector3 axis;
    if (!s.body[0]) {
        s.body[0] = s.body[1];
        s.body[1] = NULL;
        s.reversed = true;
    }
    s.angle = dJointGetHingeAngle(joint);
    dJointGetHingeAxis(joint, axis);
    dBodyVectorFromWorld(s.body[0], axis[0], axis[1], axis[2], s.axis1);
    relative_turn(s.body, s.now);
    return s;
}

/* Computes q <- q times the rotation by `angle` about the unit axis. */
static void turn_about(dQuaternion q, const double *axis, double angle)
{
    dQuaternion by, was;
    memcpy(was, q, sizeof was);
    dQFromAxisAndAngle(by, axis[0], axis[1], axis[2], angle);
    dQMultiply0(q, was, by);
}

/* Returns |<q, r>|. */
static double along(const hinge_state *s, const dQuaternion q)
{
    memcpy((dReal *)dBodyGetQuaternion(s->body[0]), q, sizeof(dQuaternion));
    return fabs(cos(0.5 * dJointGetHingeAngle(s->joint)));
}

/* Finds q0. Returns false where the angle does not tell it, because the two axes are far apart. */
static bool read_turn(const hinge_state *s, dQuaternion turn)
{
    dQuaternion was, guess, r, other;
    memcpy(was, dBodyGetQuaternion(s->body[0]), sizeof was);
    memcpy(guess, was, sizeof guess);
    turn_about(guess, s->axis1, s->reversed ? s->angle : -s->angle); /* r where the axes are one */
    r[0] = along(s, guess);
    for (int i = 1; i < 4; i++) { /* half way to the i-th unit quaternion, where r's part along it shows its sign */
        dQuaternion unit = {0, 0, 0, 0};
        unit[i] = 1;
        dQMultiply0(other, guess, unit);
        for (int k = 0; k < 4; k++) other[k] = sqrt(0.5) * (guess[k] + other[k]);
        r[i] = sqrt(2) * along(s, other) - r[0];
    }
    memcpy((dReal *)dBodyGetQuaternion(s->body[0]), was, sizeof was);
    double length = sqrt(r[0] * r[0] + pinch_v3_dot(r + 1, r + 1));
    if (!(fabs(length - 1) < SAME)) return false;
    for (int k = 0; k < 4; k++) r[k] /= length;
    dQMultiply0(other, guess, r);
    /* q0 = r^-1 q2 = r^-1 q1 (q1^-1 q2) */
    dQMultiply1(guess, other, was);
    dQMultiply0(turn, guess, s->now);
    return true;
}

/* Computes the axis in the second body's frame. */
static void second_axis(const pinch_hinge_reference *r, double axis2[3])
{
    dMatrix3 R;
    dQtoR(r->turn, R);
    for (int i = 0; i < 3; i++) axis2[i] = R[i] * r->axis1[0] + R[4 + i] * r->axis1[1] + R[8 + i] * r->axis1[2];
}

/* Returns the sine of the angle between the second body's axis, as the first one sees it, and the first's own. */
static double misaligned(const pinch_hinge_reference *r, const hinge_state *s)
{
    dMatrix3 R;
    dVector3 seen, across;
    double axis2[3];
    second_axis(r, axis2);
    dQtoR(s->now, R);
    for (int i = 0; i < 3; i++) seen[i] = pinch_v3_dot(R + 4 * i, axis2);
    pinch_v3_cross(seen, s->axis1, across);
    return pinch_v3_dot(seen, s->axis1) > 0 ? pinch_v3_norm(across) : 1;
}

/* Tells whether the reference is still that of the hinge. */
static bool is_of(const pinch_hinge_reference *r, const hinge_state *s)
{
    double change[3];
    dQuaternion since;
    if (r->body[0] != s->body[0] || r->body[1] != s->body[1]) return false;
    pinch_v3_sub(r->axis1, s->axis1, change);
    dQMultiply2(since, s->now, r->turn);
    return pinch_v3_norm(change) < SAME && fabs(fabs(since[0]) - fabs(cos(0.5 * s->angle))) < SAME &&
           fabs(pinch_v3_norm(since + 1) - fabs(sin(0.5 * s->angle))) < SAME;
}

static void begin(pinch_hinge_reference *r, const hinge_state *s)
{
    memset(r, 0, sizeof *r);
    r->joint = s->joint;
    r->body[0] = s->body[0];
    r->body[1] = s->body[1];
    if (read_turn(s, r->turn)) memcpy(r->axis1, s->axis1, sizeof r->axis1); /* otherwise the next step tries again */
}

static void update(pinch_hinge_reference *r, long step)
{
    hinge_state s = read_state(r->joint);
    if (!is_of(r, &s)) begin(r, &s);
    r->seen = (uint32_t)step;
    r->reliable = r->reliable || (pinch_v3_norm(r->axis1) > 0 && misaligned(r, &s) < NEAR);
}

static pinch_item_keys keys_of(const pinch_hinge_references *references)
{
    return PINCH_ITEM_KEYS(*references, pinch_hinge_reference, joint);
}

bool pinch_add_hinge_reference(pinch_hinge_references *references, dJointID joint, dBodyID body, long step,
                               int *reference)
{
    *reference = -1;
    if (dJointGetType(joint) != dJointTypeHinge) return true;
    pinch_item_keys keys = keys_of(references);
    int index = pinch_item_index_get(&references->index, keys, &joint);
    if (index < 0) {
        index = references->count;
        if (!PINCH_RESERVE(*references, index + 1)) return false;
        keys = keys_of(references); /* the list may have moved */
        if (!pinch_item_index_add(&references->index, keys, &joint, index)) return false;
        memset(&references->items[references->count++], 0, sizeof *references->items);
        references->items[index].joint = joint;
    }
    if (dBodyIsKinematic(body)) update(&references->items[index], step);
    *reference = index;
    return true;
}

void pinch_update_hinge(pinch_hinge_references *references, int reference, long step)
{
    update(&references->items[reference], step);
}

void pinch_keep_hinge_reference(pinch_hinge_references *references, int reference, long step)
{
    if (reference >= 0) references->items[reference].seen = (uint32_t)step;
}

const double *pinch_hinge_reference_axis(pinch_hinge_references *references, int reference, dBodyID body, long step,
                                         double axis2[3])
{
    if (reference < 0) return NULL;
    pinch_hinge_reference *r = &references->items[reference];
    if (!dBodyIsKinematic(body)) update(r, step);
    if (!r->reliable) return NULL;
    second_axis(r, axis2);
    return axis2;
}

/* It begins anew when it is asked for, as no hinge is of no body. */
static void forget(pinch_hinge_reference *r)
{
    *r = (pinch_hinge_reference){.joint = r->joint, .seen = r->seen};
}

static bool is_among(const pinch_key_map *bodies, dBodyID body)
{
    return body && pinch_key_map_get(bodies, (uintptr_t)body) >= 0;
}

void pinch_hinge_references_forget_bodies(pinch_hinge_references *references, const pinch_key_map *bodies)
{
    for (int k = 0; k < references->count && bodies->entries.count > 0; k++) {
        pinch_hinge_reference *r = &references->items[k];
        if (is_among(bodies, r->body[0]) || is_among(bodies, r->body[1])) forget(r);
    }
}

void pinch_hinge_references_forget_joint(pinch_hinge_references *references, dJointID joint)
{
    int index = pinch_item_index_get(&references->index, keys_of(references), &joint);
    if (index >= 0) forget(&references->items[index]);
}

bool pinch_sweep_hinge_references(pinch_hinge_references *references, long step)
{
    if (step % KEPT_STEPS != 0 || references->count == 0) return true;
    int kept = 0;
    pinch_item_keys keys = keys_of(references);
    for (int k = 0; k < references->count; k++)
        if ((uint32_t)step - references->items[k].seen <= KEPT_STEPS) references->items[kept++] = references->items[k];
    references->count = kept;
    return pinch_item_index_rebuild(&references->index, keys, kept);
}
