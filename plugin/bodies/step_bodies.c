#include "bodies/step_bodies.h"

#include "bodies/matrix3.h"

#include "support/vec3.h"

#include <math.h>
#include <stdlib.h>

static pinch_item_keys drive_keys(const pinch_drives *drives)
{
    return PINCH_ITEM_KEYS(*drives, pinch_drive, body);
}

int pinch_drive_of(const pinch_drives *drives, dBodyID body)
{
    pinch_item_keys keys = drive_keys(drives);
    return pinch_item_index_get(&drives->index, keys, &body);
}

/* The last drive takes the place of the one that goes. */
static void remove_drive(pinch_drives *drives, int index)
{
    pinch_item_index_remove(&drives->index, drive_keys(drives), index, drives->count - 1);
    drives->items[index] = drives->items[--drives->count];
}

static pinch_drive *add_drive(pinch_drives *drives, dBodyID body)
{
    int index = drives->count;
    if (!PINCH_RESERVE(*drives, index + 1) || !pinch_item_index_add(&drives->index, drive_keys(drives), &body, index))
        return NULL;
    pinch_drive *drive = &drives->items[drives->count++];
    memset(drive, 0, sizeof *drive);
    drive->body = body;
    return drive;
}

pinch_status pinch_drives_set(pinch_drives *drives, dBodyID body, const double axis[3], double force, bool *changed)
{
    int index = pinch_drive_of(drives, body);
    *changed = false;
    if (force == 0) {
        *changed = index >= 0;
        if (index >= 0) remove_drive(drives, index);
        return PINCH_OK;
    }
    if (!axis || !dBodyIsKinematic(body) || !(fabs(pinch_v3_norm(axis) - 1) < 1e-6)) return PINCH_INVALID_ARGUMENT;
    pinch_drive *drive = index < 0 ? add_drive(drives, body) : &drives->items[index];
    if (!drive) return PINCH_OUT_OF_MEMORY;
    drive->force = force;
    *changed = index < 0 || memcmp(drive->axis, axis, sizeof drive->axis) != 0;
    pinch_v3_copy(drive->axis, axis);
    return PINCH_OK;
}

void pinch_drive_stop(const pinch_drive *drive)
{
    const double *v = dBodyGetLinearVel(drive->body), s = drive->speed;
    dBodySetLinearVel(drive->body, v[0] - s * drive->axis[0], v[1] - s * drive->axis[1], v[2] - s * drive->axis[2]);
}

static pinch_item_keys body_keys(const pinch_step_bodies *bodies)
{
    return PINCH_ITEM_KEYS(*bodies, pinch_step_body, body);
}

int pinch_step_body_of(const pinch_step_bodies *bodies, dBodyID body)
{
    pinch_item_keys keys = body_keys(bodies);
    return pinch_item_index_get(&bodies->index, keys, &body);
}

void pinch_step_bodies_clear(pinch_step_bodies *bodies)
{
    bodies->count = 0;
    pinch_item_index_clear(&bodies->index);
}

void pinch_step_bodies_free(pinch_step_bodies *bodies)
{
    free(bodies->items);
    free(bodies->by_island.items);
    free(bodies->inverses.items);
    free(bodies->drives.items);
    pinch_item_index_free(&bodies->index);
    pinch_item_index_free(&bodies->drives.index);
}

size_t pinch_step_bodies_bytes(const pinch_step_bodies *bodies)
{
    return PINCH_LIST_BYTES(*bodies) + PINCH_LIST_BYTES(bodies->by_island) + PINCH_LIST_BYTES(bodies->inverses) +
           PINCH_LIST_BYTES(bodies->drives) + pinch_item_index_bytes(&bodies->index) +
           pinch_item_index_bytes(&bodies->drives.index);
}

int pinch_step_bodies_add(pinch_step_bodies *bodies, dBodyID body)
{
    if (!body) return PINCH_NOT_A_STEP_BODY;
    int drive = dBodyIsKinematic(body) ? pinch_drive_of(&bodies->drives, body) : -1;
    if (dBodyIsKinematic(body) && drive < 0) return PINCH_NOT_A_STEP_BODY;
    int index = pinch_step_body_of(bodies, body);
    if (index >= 0) return index;
    index = bodies->count;
    if (!PINCH_RESERVE(*bodies, index + 1)) return PINCH_NO_ROOM_FOR_BODY;
    pinch_item_keys keys = body_keys(bodies);
    if (!pinch_item_index_add(&bodies->index, keys, &body, index)) return PINCH_NO_ROOM_FOR_BODY;
    pinch_step_body *b = &bodies->items[bodies->count++];
    memset(b, 0, sizeof *b);
    b->body = body;
    b->drive = drive;
    b->parent = index;
    return index;
}

int pinch_step_bodies_root(pinch_step_bodies *bodies, int body)
{
    pinch_step_body *b = bodies->items;
    while (b[body].parent != body) body = b[body].parent = b[b[body].parent].parent;
    return body;
}

void pinch_step_bodies_join(pinch_step_bodies *bodies, int a, int b)
{
    if (a < 0 || b < 0) return;
    a = pinch_step_bodies_root(bodies, a);
    b = pinch_step_bodies_root(bodies, b);
    if (a < b)
        bodies->items[b].parent = a;
    else
        bodies->items[a].parent = b;
}

/* inertia = R I R^T, the left product first. What is above the diagonal is taken from below. */
static void world_inertia(const dMass *mass, const double *R, double *inertia)
{
    double turned[PINCH_MATRIX3], left[PINCH_MATRIX3], all[PINCH_MATRIX3];
    pinch_matrix3_transpose(R, turned);
    pinch_matrix3_product(R, mass->I, left);
    pinch_matrix3_product(left, turned, all);
    for (int i = 0; i < 3; i++)
        for (int j = 0; j <= i; j++) inertia[3 * i + j] = inertia[3 * j + i] = all[4 * i + j];
}

/* Solves a 3 x 3 system by Cramer's rule. The systems here are well conditioned: an inertia plus a small skew part. */
static void solve3(const double *a, const double *b, double *x)
{
    double c0[3] = {a[0], a[3], a[6]}, c1[3] = {a[1], a[4], a[7]}, c2[3] = {a[2], a[5], a[8]}, t[3];
    pinch_v3_cross(c1, c2, t);
    double over = 1 / pinch_v3_dot(c0, t);
    x[0] = pinch_v3_dot(b, t) * over;
    pinch_v3_cross(c2, c0, t);
    x[1] = pinch_v3_dot(b, t) * over;
    pinch_v3_cross(c0, c1, t);
    x[2] = pinch_v3_dot(b, t) * over;
}

/*
 * Adds ODE's gyroscopic torque, which is implicit in the angular momentum L = I w:
 *
 *     tau = (I y - L)/h   with   (I - h [L]x) y = L
 *
 * (Lacoursiere, "Stabilizing gyroscopic forces in rigid multibody simulations", 2006).
 */
static void gyroscopic_torque(const double *inertia, const double *w, double h, double *torque)
{
    double L[3], matrix[9], y[3];
    for (int i = 0; i < 3; i++) L[i] = pinch_v3_dot(inertia + 3 * i, w);
    if (L[0] == 0 && L[1] == 0 && L[2] == 0) return;
    memcpy(matrix, inertia, sizeof matrix);
    matrix[1] += h * L[2];
    matrix[2] -= h * L[1];
    matrix[3] -= h * L[2];
    matrix[5] += h * L[0];
    matrix[6] += h * L[1];
    matrix[7] -= h * L[0];
    solve3(matrix, L, y);
    for (int i = 0; i < 3; i++) torque[i] += (pinch_v3_dot(inertia + 3 * i, y) - L[i]) / h;
}

void pinch_fill_step_body(const pinch_step_context *context, const pinch_drives *drives, const pinch_step_body *from,
                          pinch_body *b)
{
    if (from->drive >= 0) {
        const pinch_drive *drive = &drives->items[from->drive];
        memset(b, 0, sizeof *b);
        pinch_v3_copy(b->position, dBodyGetPosition(from->body));
        b->radius = 1;
        pinch_v3_copy(b->drive_axis, drive->axis);
        b->drive_force = drive->force;
        pinch_v3_add_scaled(b->velocity, drive->speed, drive->axis);
        return;
    }
    dMass mass;
    dBodyGetMass(from->body, &mass);
    pinch_v3_copy(b->position, dBodyGetPosition(from->body));
    pinch_v3_set(b->drive_axis, 0, 0, 0);
    b->drive_force = 0;
    for (int i = 0; i < 6; i++) b->velocity_end[i] = 0;
    b->mass = mass.mass;
    world_inertia(&mass, dBodyGetRotation(from->body), b->inertia);
    /* the radius of the homogeneous ball with the same trace of inertia */
    b->radius = sqrt(2.5 * (b->inertia[0] + b->inertia[4] + b->inertia[8]) / (3 * mass.mass));

    pinch_v3_copy(b->velocity, dBodyGetLinearVel(from->body));
    pinch_v3_copy(b->velocity + 3, dBodyGetAngularVel(from->body));
    pinch_v3_copy(b->external, dBodyGetForce(from->body));
    pinch_v3_copy(b->external + 3, dBodyGetTorque(from->body));
    if (dBodyGetGravityMode(from->body)) pinch_v3_add_scaled(b->external, mass.mass, context->gravity);
    if (dBodyGetGyroscopicMode(from->body)) gyroscopic_torque(b->inertia, b->velocity + 3, context->h, b->external + 3);
}

void pinch_apply_external(pinch_body *b, double h)
{
    double spin[3];
    if (b->mass == 0) return;
    pinch_v3_add_scaled(b->velocity, h / b->mass, b->external);
    solve3(b->inertia, b->external + 3, spin);
    pinch_v3_add_scaled(b->velocity + 3, h, spin);
}

void pinch_give_contact_forces(pinch_drives *drives, pinch_step_body *b)
{
    if (b->drive < 0) {
        double f[6];
        memcpy(f, b->wrench, sizeof f);
        pinch_v3_copy(b->wrench, dBodyGetForce(b->body));
        pinch_v3_copy(b->wrench + 3, dBodyGetTorque(b->body));
        dBodyAddForce(b->body, f[0], f[1], f[2]);
        dBodyAddTorque(b->body, f[3], f[4], f[5]);
        return;
    }
    pinch_drive *drive = &drives->items[b->drive];
    drive->speed = pinch_v3_dot(b->velocity, drive->axis);
    b->wrench[0] = drive->force;
    const double *v = dBodyGetLinearVel(b->body);
    dBodySetLinearVel(b->body, v[0] + drive->speed * drive->axis[0], v[1] + drive->speed * drive->axis[1],
                      v[2] + drive->speed * drive->axis[2]);
}

void pinch_take_back_contact_forces(const pinch_drives *drives, const pinch_step_body *b)
{
    if (b->drive >= 0) {
        pinch_drive_stop(&drives->items[b->drive]);
        return;
    }
    dBodySetForce(b->body, b->wrench[0], b->wrench[1], b->wrench[2]);
    dBodySetTorque(b->body, b->wrench[3], b->wrench[4], b->wrench[5]);
}
