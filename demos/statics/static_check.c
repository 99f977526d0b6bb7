/* Is the answer one? From the data of the contacts, the scene and the joints, without the system's rows or its law. */
#include "static_system.h"

#include "common/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void note(double *worst, double error)
{
    if (!(error <= *worst)) *worst = error;
}

/* ---- Contacts. ---- */

static void check_contact(const static_contact *c, static_errors *e)
{
    const pinch_contact *d = c->data;
    int rows = (int)d->model;
    double w[4], r[4], s[4], mu[4] = {0, d->friction[0], d->friction[1], d->torsional_friction}, k[4], reach2 = 0;
    for (int i = 0; i < 4; i++) {
        k[i] = d->stiffness[i == 0 ? 0 : i < 3 ? 1 : 2];
        w[i] = (double)c->w[i];
        r[i] = (double)c->r[i];
        s[i] = i == 0 ? k[0] * (d->depth - w[0]) : -k[i] * (d->elastic[i - 1] + w[i]);
    }
    note(&e->scale, fabs(r[0]));
    note(&e->normal, fabs(r[0] - fmin(fmax(s[0], 0), d->max_force)));
    for (int i = 1; i < rows; i++) {
        if (mu[i] > 0)
            reach2 += r[i] * r[i] / (mu[i] * mu[i]);
        else
            note(&e->cone, fabs(r[i]));
    }
    double reach = sqrt(reach2), outward = 0, along = 0;
    if (rows > 1) note(&e->cone, fmax(mu[1], mu[2]) * (reach - r[0]));
    for (int i = 1; i < rows; i++) { /* slip against the outward normal of the limit surface, in N */
        if (!(mu[i] > 0)) continue;
        double part = (s[i] - r[i]) / k[i] * mu[i], normal = r[i] / mu[i];
        outward += normal * normal;
        along += part * normal;
    }
    bool on_limit = reach >= r[0] * (1 - 1e-9);
    for (int i = 1; i < rows; i++) {
        if (!(mu[i] > 0)) continue;
        double allowed = on_limit && outward > 0 && along > 0 ? along / outward * r[i] / mu[i] * k[i] / mu[i] : 0;
        if (r[0] > 0) note(&e->slip_direction, fabs(s[i] - r[i] - allowed) / (i == 3 ? mu[3] / fmax(mu[1], 1e-3) : 1));
    }
}

/* ---- Balance. ---- */

/* The contact's force and moment on body 1 about a point. */
static void contact_wrench(const static_contact *c, const double about[3], double force[3], double moment[3])
{
    double arm[3];
    memset(force, 0, 3 * sizeof *force);
    for (int i = 0; i < 3 && i < c->law.rows; i++) scene_add_scaled(force, (double)c->r[i], c->axis[i]);
    scene_subtract(c->data->position, about, arm);
    scene_cross(arm, force, moment);
    if (c->law.rows == 4) scene_add_scaled(moment, (double)c->r[3], c->axis[0]);
}

static void check_object(const static_system *s, int k, static_errors *e)
{
    const double *centre = dBodyGetPosition(s->w->objects[k].body);
    double sum[3], about[3], force[3], moment[3];
    world_external_wrench(s->w, k, sum, about);
    note(&e->scale, scene_norm(sum));
    for (int i = 0; i < s->contact_count; i++)
        for (int side = 0; side < 2; side++) {
            if (s->contacts[i].body[side] != s->w->objects[k].body) continue;
            contact_wrench(&s->contacts[i], centre, force, moment);
            scene_add_scaled(sum, side ? -1 : 1, force);
            scene_add_scaled(about, side ? -1 : 1, moment);
        }
    note(&e->force, scene_norm(sum));
    note(&e->torque, scene_norm(about));
}

static const world_joint *mover(const world_hand *h, dBodyID body)
{
    for (int i = 0; i < h->joint_count; i++)
        if (h->joints[i].body == body) return &h->joints[i];
    return NULL;
}

static bool hangs_from(const world_hand *h, dBodyID body, const world_joint *joint)
{
    const world_joint *j = mover(h, body);
    while (j && j != joint) j = mover(h, j->parent);
    return j != NULL;
}

/* What force and moment on a body beyond the joint do to it. */
static double on_axis(const world_joint *j, const double axis[3], const double force[3], const double moment[3])
{
    return j->of->type == HAND_HINGE ? scene_dot(axis, moment) : scene_dot(axis, force);
}

static void check_joint(const static_system *s, int k, int index, static_errors *e)
{
    const world_hand *h = &s->w->hands[k];
    const world_joint *j = &h->joints[index];
    dVector3 axis, anchor = {0, 0, 0};
    double force[3], moment[3], sum = s->weight[s->first_joint[k] + index];
    if (j->of->type == HAND_HINGE) {
        dJointGetHingeAxis(j->joint, axis);
        dJointGetHingeAnchor(j->joint, anchor);
    } else {
        dJointGetSliderAxis(j->joint, axis);
    }
    for (int i = 0; i < s->contact_count; i++)
        for (int side = 0; side < 2; side++) {
            if (!hangs_from(h, s->contacts[i].body[side], j)) continue;
            contact_wrench(&s->contacts[i], anchor, force, moment);
            sum += (side ? -1 : 1) * on_axis(j, axis, force, moment);
        }
    for (int i = 0; i < s->row_count; i++) sum += s->rows[i].a[s->first_joint[k] + index] * (double)s->rows[i].y;
    note(&e->joint, fabs(sum));
}

/* ---- Motors and ties. ---- */

static void check_row(const static_system *s, const static_row *b, const long double *z, static_errors *e)
{
    long double missing = b->missing;
    for (int i = 0; i < s->coordinates; i++) missing -= b->a[i] * z[i];
    double y = (double)b->y, off = (double)missing;
    note(&e->motor, fmax(b->low - y, y - b->high));
    if (!b->rigid) {
        note(&e->motor, fabs(y - fmin(fmax(b->constant + b->stiffness * off, b->low), b->high)));
        return;
    }
    /* A row that misses what it asks for counts as what a stiff spring would make up for it. */
    static const double STIFF = 1e4; /* N/m */
    note(&e->motor, fmin(fabs(STIFF * off), off > 0 ? b->high - y : y - b->low));
}

bool static_check(const static_system *s, const long double *z, static_errors *e)
{
    memset(e, 0, sizeof *e);
    for (int i = 0; i < s->contact_count; i++) check_contact(&s->contacts[i], e);
    for (int k = 0; k < s->w->object_count; k++) check_object(s, k, e);
    for (int k = 0; k < s->w->hand_count; k++)
        for (int i = 0; i < s->w->hands[k].joint_count; i++) check_joint(s, k, i, e);
    for (int i = 0; i < s->row_count; i++) check_row(s, &s->rows[i], z, e);
    double most = fmax(fmax(e->force, e->torque / s->lever), fmax(e->joint, e->motor) / s->lever);
    most = fmax(most, fmax(e->cone, fmax(e->normal, e->slip_direction)));
    e->passed = most <= 1e-9 * e->scale;
    return e->passed;
}
