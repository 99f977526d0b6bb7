#include "joints/coupling.h"

#include "joints/joint_pose.h"
#include "joints/servo.h"

#include "support/vec3.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static bool law_is_legal(const pinch_servo *law)
{
    pinch_servo finite = *law;
    if (law->kp == INFINITY) finite.kp = 0;
    return pinch_servo_law_is_legal(&finite);
}

static bool terms_are_legal(const pinch_coupling_term *terms, int count)
{
    if (count < 1 || count > PINCH_COUPLING_TERMS) return false;
    for (int i = 0; i < count; i++) {
        const pinch_coupling_term *t = &terms[i];
        if (!t->joint || !isfinite(t->factor) || t->factor == 0 || !pinch_coordinate_of(t->joint, t->axis))
            return false;
    }
    return true;
}

pinch_status pinch_coupling_make(pinch_couplings *couplings, const pinch_coupling_term *terms, int count,
                                 const pinch_servo *law, int *number)
{
    int place = 0;
    if (!law_is_legal(law) || !terms_are_legal(terms, count)) return PINCH_INVALID_ARGUMENT;
    while (place < couplings->count && couplings->items[place].used) place++;
    if (place == couplings->count) {
        if (!PINCH_RESERVE(*couplings, place + 1) || !PINCH_RESERVE(couplings->by_island, place + 1))
            return PINCH_OUT_OF_MEMORY;
        couplings->count++;
    }
    pinch_coupling *c = &couplings->items[place];
    memset(c, 0, sizeof *c);
    c->used = true;
    c->law = *law;
    c->count = count;
    for (int i = 0; i < count; i++) c->coupled[i].term = terms[i];
    couplings->changed = true;
    *number = place;
    return PINCH_OK;
}

const pinch_coupling *pinch_coupling_of(const pinch_couplings *couplings, int number)
{
    bool known = number >= 0 && number < couplings->count && couplings->items[number].used;
    return known ? &couplings->items[number] : NULL;
}

pinch_status pinch_coupling_set(pinch_couplings *couplings, int number, const pinch_servo *law)
{
    if (!pinch_coupling_of(couplings, number) || (law && !law_is_legal(law))) return PINCH_INVALID_ARGUMENT;
    pinch_coupling *c = &couplings->items[number];
    if (law) {
        c->law = *law;
        return PINCH_OK;
    }
    c->used = c->acts = false;
    couplings->changed = true;
    return PINCH_OK;
}

/* ---- the bodies ---- */

/* Tells whether forces move the body. */
static bool moves(dBodyID body)
{
    return body && !dBodyIsKinematic(body);
}

bool pinch_moves_a_body(dJointID joint)
{
    return moves(dJointGetBody(joint, 0)) || moves(dJointGetBody(joint, 1));
}

bool pinch_coupling_has_law(const pinch_coupling *c)
{
    return c->used && (c->law.kp > 0 || c->law.kd > 0);
}

bool pinch_coupling_can_act(const pinch_coupling *c)
{
    bool any = false;
    if (!pinch_coupling_has_law(c)) return false;
    for (int i = 0; i < c->count; i++) {
        dBodyID body[2];
        dJointID joint = c->coupled[i].term.joint;
        if (!dJointIsEnabled(joint) || !pinch_joint_bodies(joint, body)) return false;
        any = any || moves(body[0]) || moves(body[1]);
    }
    return any;
}

bool pinch_collect_couplings(pinch_couplings *couplings, pinch_step_bodies *bodies)
{
    couplings->changed = false;
    for (int k = 0; k < couplings->count; k++) {
        pinch_coupling *c = &couplings->items[k];
        c->acts = pinch_coupling_can_act(c);
        c->body = PINCH_NOT_A_STEP_BODY;
        for (int i = 0; i < c->count && c->acts; i++) {
            dBodyID body[2];
            (void)pinch_joint_bodies(c->coupled[i].term.joint, body);
            for (int side = 0; side < 2; side++) {
                if (!moves(body[side])) continue;
                int index = pinch_step_bodies_add(bodies, body[side]);
                if (index == PINCH_NO_ROOM_FOR_BODY) return false;
                if (c->body < 0) c->body = index;
                pinch_step_bodies_join(bodies, c->body, index);
            }
        }
    }
    return true;
}

/* ---- the row ---- */

/* What the law gives a coupling's rows. */
typedef struct row_law {
    double cfm, rhs, low, high;
} row_law;

/* Reads x. */
static row_law read_law(pinch_coupling *c, const pinch_term_reading *readings, double h)
{
    double gain = h * c->law.kp + c->law.kd;
    c->position = 0;
    c->placed = true;
    for (int i = 0; i < c->count; i++) {
        pinch_coupled *of = &c->coupled[i];
        pinch_coordinate_follow(of->term.joint, of->term.axis, readings ? readings[i].axis : NULL, &of->coordinate);
        c->position += of->term.factor * of->coordinate.position;
    }
    bool rigid = isinf(gain);
    return (row_law){.cfm = rigid ? 0 : 1 / gain,
                     .rhs = rigid ? (c->law.target - c->position) / h
                                  : (c->law.kp * (c->law.target - c->position) + c->law.kd * c->law.rate) / gain,
                     .low = -c->law.max_force,
                     .high = c->law.max_force};
}

/* Writes the part of a hinge that has been read, whose first body is a step body, and whose second one is, too, or does
 * not move by itself. Returns what the motion of such a one adds to x'. */
static double fill_hinge(const pinch_coupling_term *term, const pinch_term_reading *reading, pinch_joint_row *row)
{
    dBodyID body[2];
    double direction[3];
    pinch_coordinate_direction(term->joint, term->axis, reading->axis, direction);
    for (int i = 0; i < 3; i++) row->j1[3 + i] = direction[i] * term->factor;
    row->body1 = reading->body[0];
    row->body2 = reading->body[1];
    if (row->body2 < 0) (void)pinch_joint_bodies(term->joint, body);
    if (row->body2 < 0 && !body[1]) return 0;
    for (int i = 0; i < 3; i++) row->j2[3 + i] = -row->j1[3 + i];
    if (row->body2 >= 0) return 0;
    row->body2 = PINCH_STATIC_BODY;
    return pinch_v3_dot(row->j2 + 3, dBodyGetAngularVel(body[1]));
}

/* Writes the part of any term; reading: what has been read of it, or NULL. Returns what a kinematic body, whose motion
 * is given, adds to x'. */
static double fill_part(const pinch_coupling_term *term, const pinch_term_reading *reading,
                        const pinch_step_bodies *bodies, pinch_joint_row *row)
{
    dBodyID body[2];
    double direction[3], given = 0;
    double *const j[2] = {row->j1, row->j2};
    int *const index[2] = {&row->body1, &row->body2};
    bool linear = reading ? reading->axis->slides : pinch_coordinate_of(term->joint, term->axis)->linear;
    (void)pinch_joint_bodies(term->joint, body);
    pinch_coordinate_direction(term->joint, term->axis, reading ? reading->axis : NULL, direction);
    pinch_coordinate_row(linear, direction, body, row);
    for (int side = 0; side < 2; side++) {
        for (int i = 0; i < 6 && term->factor != 1; i++) j[side][i] *= term->factor;
        *index[side] = PINCH_STATIC_BODY;
        if (reading && reading->body[side] >= 0)
            *index[side] = reading->body[side];
        else if (!reading && moves(body[side]))
            *index[side] = pinch_step_body_of(bodies, body[side]);
        if (!body[side] || *index[side] >= 0) continue;
        given += pinch_v3_dot(j[side], dBodyGetLinearVel(body[side])) +
                 pinch_v3_dot(j[side] + 3, dBodyGetAngularVel(body[side]));
    }
    return given;
}

/* The indices are those of step bodies. readings: as for pinch_coupling_rows, or NULL. */
static int write_rows(pinch_coupling *c, const pinch_term_reading *readings, const pinch_step_bodies *bodies, double h,
                      pinch_joint_row *rows)
{
    row_law law = read_law(c, readings, h);
    int count = 0;
    for (int i = 0; i < c->count; i++) {
        const pinch_term_reading *reading = readings && readings[i].axis ? &readings[i] : NULL;
        pinch_joint_row *row = &rows[count];
        *row = pinch_free_row;
        if (reading && !reading->axis->slides && reading->body[0] >= 0)
            law.rhs -= fill_hinge(&c->coupled[i].term, reading, row);
        else
            law.rhs -= fill_part(&c->coupled[i].term, reading, bodies, row);
        row->continues = count > 0;
        row->cfm = law.cfm;
        row->low = law.low;
        row->high = law.high;
        if (row->body1 >= 0 || row->body2 >= 0) count++;
    }
    rows[0].rhs = law.rhs;
    rows[0].force = c->force;
    return count;
}

int pinch_coupling_rows(pinch_coupling *c, const pinch_term_reading *readings, const pinch_step_bodies *bodies,
                        double h, pinch_joint_row *rows)
{
    int count = write_rows(c, readings, bodies, h, rows);
    c->by_pinch = false;
    for (int k = 0; k < count; k++) {
        int *const index[2] = {&rows[k].body1, &rows[k].body2};
        for (int side = 0; side < 2; side++)
            if (*index[side] >= 0) *index[side] = bodies->items[*index[side]].local;
    }
    return count;
}

/* ---- forces ---- */

static void give_row_force(double force, const double j[6], dBodyID body)
{
    dBodyAddForce(body, force * j[0], force * j[1], force * j[2]);
    dBodyAddTorque(body, force * j[3], force * j[4], force * j[5]);
}

static void give(double force, const pinch_joint_row *rows, int count, const pinch_step_bodies *bodies)
{
    for (int k = 0; k < 2 * count; k++) {
        const pinch_joint_row *row = &rows[k / 2];
        const double *j = k % 2 ? row->j2 : row->j1;
        int index = k % 2 ? row->body2 : row->body1;
        if (index >= 0) give_row_force(force, j, bodies->items[index].body);
    }
}

void pinch_give_coupling_force(pinch_coupling *c, const pinch_step_bodies *bodies)
{
    pinch_joint_row rows[PINCH_COUPLING_TERMS];
    double position = c->position;
    int count = write_rows(c, NULL, bodies, 1, rows);
    c->position = position;
    give(c->force, rows, count, bodies);
}

/* What one body adds to the row if it is free: the velocity along it, and how far a unit force moves it. */
static void add_free_body(const pinch_step_context *context, const pinch_step_bodies *bodies, int index,
                          const double j[6], double *velocity, double *gives)
{
    pinch_body b;
    const pinch_step_body *from = &bodies->items[index];
    pinch_fill_step_body(context, &bodies->drives, from, &b);
    pinch_apply_external(&b, context->h);
    double turned[3], cofactor[3];
    const double *turn = j + 3, *I = b.inertia; /* symmetric; turned = I^-1 turn by Cramer's rule */
    pinch_v3_cross(I + 3, I + 6, cofactor);
    double determinant = pinch_v3_dot(I, cofactor);
    turned[0] = pinch_v3_dot(turn, cofactor) / determinant;
    pinch_v3_cross(I + 6, I, cofactor);
    turned[1] = pinch_v3_dot(turn, cofactor) / determinant;
    pinch_v3_cross(I, I + 3, cofactor);
    turned[2] = pinch_v3_dot(turn, cofactor) / determinant;
    for (int i = 0; i < 6; i++) *velocity += j[i] * b.velocity[i];
    *gives += pinch_v3_dot(j, j) / b.mass + pinch_v3_dot(turn, turned);
}

/* Returns the force of the row if its bodies were free, within its bounds: it takes the row no farther than it asks
 * for. */
static double explicit_force(const pinch_step_context *context, const pinch_step_bodies *bodies,
                             const pinch_joint_row *rows, int count)
{
    double velocity = 0, gives = 0;
    for (int k = 0; k < 2 * count; k++) {
        int index = k % 2 ? rows[k / 2].body2 : rows[k / 2].body1;
        double j[6] = {0};
        bool seen = index < 0;
        for (int i = 0; i < 2 * count && !seen; i++) { /* a body may be in several parts */
            int other = i % 2 ? rows[i / 2].body2 : rows[i / 2].body1;
            if (other != index) continue;
            seen = i < k;
            for (int l = 0; l < 6; l++) j[l] += i % 2 ? rows[i / 2].j2[l] : rows[i / 2].j1[l];
        }
        if (!seen) add_free_body(context, bodies, index, j, &velocity, &gives);
    }
    double resists = rows[0].cfm + context->h * gives;
    double force = resists > 0 ? (rows[0].rhs - velocity) / resists : 0;
    return isfinite(force) ? fmin(fmax(force, rows[0].low), rows[0].high) : 0;
}

static bool all_enabled(const pinch_step_bodies *bodies, const pinch_joint_row *rows, int count)
{
    for (int k = 0; k < 2 * count; k++) {
        int index = k % 2 ? rows[k / 2].body2 : rows[k / 2].body1;
        if (index >= 0 && !dBodyIsEnabled(bodies->items[index].body)) return false;
    }
    return true;
}

void pinch_leave_couplings_to_ode(pinch_couplings *couplings, const pinch_step_context *context,
                                  const pinch_step_bodies *bodies)
{
    for (int k = 0; k < couplings->count; k++) {
        pinch_coupling *c = &couplings->items[k];
        pinch_joint_row rows[PINCH_COUPLING_TERMS];
        if (c->by_pinch) continue;
        c->force = 0;
        if (!c->acts || !pinch_coupling_can_act(c)) continue;
        int count = write_rows(c, NULL, bodies, context->h, rows);
        if (!all_enabled(bodies, rows, count)) continue; /* ODE keeps the forces of what sleeps */
        c->force = explicit_force(context, bodies, rows, count);
        give(c->force, rows, count, bodies);
    }
}

void pinch_couplings_stepped(pinch_couplings *couplings)
{
    for (int k = 0; k < couplings->count; k++) couplings->items[k].by_pinch = false;
}

void pinch_couplings_free(pinch_couplings *couplings)
{
    free(couplings->items);
    free(couplings->by_island.items);
    memset(couplings, 0, sizeof *couplings);
}
