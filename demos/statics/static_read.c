/* From a world in a step to the equations of its statics. */
#include "static_system.h"

#include "common/vector.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- Motions. ---- */

static int object_of(const world *w, dBodyID body)
{
    for (int k = 0; k < w->object_count; k++)
        if (w->objects[k].body == body) return k;
    return -1;
}

/* The joint that moves the body: its hand's number in *owner. NULL: none. */
static const world_joint *joint_of(const world *w, dBodyID body, int *owner)
{
    for (*owner = 0; *owner < w->hand_count; ++*owner)
        for (int i = 0; i < w->hands[*owner].joint_count; i++)
            if (w->hands[*owner].joints[i].body == body) return &w->hands[*owner].joints[i];
    return NULL;
}

static void joint_axis(const world_joint *j, double axis[3], double anchor[3])
{
    dVector3 a, p = {0, 0, 0};
    if (j->of->type == HAND_HINGE) {
        dJointGetHingeAxis(j->joint, a);
        dJointGetHingeAnchor(j->joint, p);
    } else {
        dJointGetSliderAxis(j->joint, a);
    }
    scene_copy(a, axis);
    scene_copy(p, anchor);
}

/* How a point of what hangs from the joint moves by a unit of its coordinate. */
static void point_motion(const world_joint *j, const double point[3], double velocity[3])
{
    double axis[3], anchor[3], arm[3];
    joint_axis(j, axis, anchor);
    scene_copy(axis, velocity);
    if (j->of->type != HAND_HINGE) return;
    scene_subtract(point, anchor, arm);
    scene_cross(axis, arm, velocity);
}

/* What a unit of the joint's coordinate moves of what hangs from it. */
static double joint_motion(const world_joint *j, const double point[3], const double d[3], bool turns)
{
    double axis[3], anchor[3], velocity[3];
    if (!turns) {
        point_motion(j, point, velocity);
        return scene_dot(velocity, d);
    }
    joint_axis(j, axis, anchor);
    return j->of->type == HAND_HINGE ? scene_dot(axis, d) : 0;
}

static int coordinate_of(const static_system *s, const world_joint *j)
{
    int owner;
    (void)joint_of(s->w, j->body, &owner);
    return s->first_joint[owner] + (int)(j - s->w->hands[owner].joints);
}

void static_add_motion(const static_system *s, dBodyID body, const double point[3], const double d[3], bool turns,
                       double sign, double *g)
{
    int object = body ? object_of(s->w, body) : -1, owner;
    if (object >= 0) {
        double arm[3], turning[3];
        scene_subtract(point, dBodyGetPosition(body), arm);
        scene_cross(arm, d, turning);
        for (int i = 0; i < 3; i++) {
            if (!turns) g[6 * object + i] += sign * d[i];
            g[6 * object + 3 + i] += sign * (turns ? d[i] : turning[i]);
        }
        return;
    }
    for (const world_joint *j = joint_of(s->w, body, &owner); j; j = joint_of(s->w, j->parent, &owner))
        g[coordinate_of(s, j)] += sign * joint_motion(j, point, d, turns);
}

/* ---- Loads. ---- */

/*
 * A force f on a link, at p. What it does to a joint i, f . v_i(p), changes as joints above and below i turn: with j no
 * nearer to the base than i, all that hangs from j turns with hinge i, d(f . v_j)/dx_i = f . (a_i x v_j), and as f has
 * a potential, d(f . v_i)/dx_j is the same. It is all that brings a link back which hangs from a joint without a drive.
 */
static void add_link_force(static_system *s, const world_joint *link, const double p[3], const double f[3])
{
    int m = s->coordinates, owner;
    static_add_motion(s, link->body, p, f, false, 1, s->weight);
    for (const world_joint *j = link; j; j = joint_of(s->w, j->parent, &owner)) {
        double velocity[3];
        point_motion(j, p, velocity);
        for (const world_joint *i = j; i; i = joint_of(s->w, i->parent, &owner)) {
            double axis[3], anchor[3], turned[3];
            if (i->of->type != HAND_HINGE) continue;
            joint_axis(i, axis, anchor);
            scene_cross(axis, velocity, turned);
            int a = coordinate_of(s, i), b = coordinate_of(s, j);
            double change = scene_dot(f, turned);
            s->weight_change[a * m + b] += change;
            if (a != b) s->weight_change[b * m + a] += change;
        }
    }
}

static void read_loads(static_system *s)
{
    const world *w = s->w;
    for (int k = 0; k < w->object_count; k++) {
        world_external_wrench(w, k, s->load + 6 * k, s->load + 6 * k + 3);
        s->lever = fmax(s->lever, w->scene->objects[k].shape.bounding_radius);
    }
    dVector3 gravity;
    dWorldGetGravity(w->ode, gravity);
    for (int k = 0; k < w->hand_count; k++)
        for (int i = 0; i < w->hands[k].joint_count; i++) {
            const world_joint *j = &w->hands[k].joints[i];
            double relief[3], at[3], weight[3];
            dMass mass;
            dBodyGetMass(j->body, &mass);
            for (int n = 0; n < 3; n++) weight[n] = mass.mass * gravity[n];
            add_link_force(s, j, dBodyGetPosition(j->body), weight);
            world_relief(j, w->loads.v[SCENE_GRAVITY], relief, at);
            if (j->relieved > 0) add_link_force(s, j, at, relief);
        }
    for (int i = 0; i < s->coordinates; i++) s->load[i] += s->weight[i];
}

/* ---- Rows. ---- */

static static_row *add_row(static_system *s, static_row_kind kind, int k, int index)
{
    if (s->row_count == s->row_room) {
        int room = 2 * s->row_room + 16;
        static_row *rows = realloc(s->rows, (size_t)room * sizeof *rows);
        if (!rows) return NULL;
        s->rows = rows;
        s->row_room = room;
    }
    static_row *b = &s->rows[s->row_count];
    *b = (static_row){.kind = kind, .hand = k, .index = index, .low = -INFINITY, .high = INFINITY, .unknown = -1};
    b->a = calloc((size_t)s->coordinates + 1, sizeof *b->a);
    if (!b->a) return NULL;
    s->row_count++;
    return b;
}

/* A row on one joint, in which `missing` is the way to where it pulls. */
static static_row *add_joint_row(static_system *s, static_row_kind kind, int k, int joint, double missing)
{
    static_row *b = add_row(s, kind, k, joint);
    if (!b) return NULL;
    b->a[s->first_joint[k] + joint] = 1;
    b->missing = missing;
    return b;
}

static bool set_bounds(static_row *b, double most, bool rigid)
{
    if (!b) return false;
    b->low = -most;
    b->high = most;
    b->rigid = rigid;
    return true;
}

/* What a drive exerts on its coordinate. One by speed has no place where it stands still. */
static bool set_control(static_row *b, const scene_control *c, double target)
{
    if (!set_bounds(b, c->max_force, false)) return false;
    b->low = c->least_force;
    b->high = c->most_force;
    if (c->type == SCENE_TORQUE_CONTROL)
        b->constant = target + c->bias;
    else
        b->stiffness = c->kp;
    return true;
}

static bool read_joint(static_system *s, int k, int index)
{
    static const double AT_STOP = 1e-13; /* rad or m, as where the step leaves dry friction out */
    const world_joint *j = &s->w->hands[k].joints[index];
    const scene_control *c = j->control;
    const hand_joint *of = j->of;
    double q = j->position;
    bool fine = true, stopped = of->limited && (q <= of->lower + AT_STOP || q >= of->upper - AT_STOP);
    if (c->type != SCENE_UNDRIVEN)
        fine = set_control(add_joint_row(s, STATIC_MOTOR, k, index, j->target - q), c, j->target);
    if (fine && of->stiffness > 0) {
        static_row *b = add_joint_row(s, STATIC_PASSIVE, k, index, of->spring_reference - q);
        fine = b != NULL;
        if (fine) b->stiffness = of->stiffness;
    }
    if (fine && of->friction > 0 && !stopped)
        fine = set_bounds(add_joint_row(s, STATIC_PASSIVE, k, index, 0), of->friction, true);
    if (!fine || !of->limited) return fine;
    for (int side = 0; side < 2 && fine; side++) {
        double stop = side ? of->upper : of->lower;
        if (!isfinite(stop)) continue;
        static_row *b = add_joint_row(s, STATIC_PASSIVE, k, index, stop - q);
        fine = set_bounds(b, INFINITY, true);
        if (fine) *(side ? &b->high : &b->low) = 0;
    }
    return fine;
}

static bool read_tie(static_system *s, int k, int index)
{
    const world_hand *h = &s->w->hands[k];
    const world_tie *t = &h->ties[index];
    static_row *b = add_row(s, t->control ? STATIC_TENDON : STATIC_TIE, k, index);
    double x = 0;
    if (!b) return false;
    for (int i = 0; i < t->terms; i++) {
        x += t->factor[i] * h->joints[t->joint[i]].position;
        b->a[s->first_joint[k] + t->joint[i]] += t->factor[i];
    }
    double middle = t->control ? scene_control_middle(t->control) : 0;
    b->missing = t->law.target + t->offset - x;
    if (middle != 0 && t->law.kp > 0) b->missing += middle / t->law.kp; /* which the law's target is without */
    if (t->control) return set_control(b, t->control, scene_target_at(t->control, s->w->time));
    b->stiffness = t->law.kp;
    return set_bounds(b, t->law.max_force, isinf(t->law.kp));
}

static bool read_loop(static_system *s, int k, int index)
{
    dJointID ball = s->w->hands[k].loops[index].ball;
    dVector3 end[2];
    dJointGetBallAnchor(ball, end[0]);
    dJointGetBallAnchor2(ball, end[1]);
    for (int i = 0; i < 3; i++) {
        const double along[3] = {i == 0, i == 1, i == 2};
        static_row *b = add_row(s, STATIC_TIE, k, -1);
        if (!b) return false;
        b->rigid = true;
        b->missing = end[1][i] - end[0][i];
        for (int side = 0; side < 2; side++)
            static_add_motion(s, dJointGetBody(ball, side), end[side], along, false, side ? -1 : 1, b->a);
    }
    return true;
}

static bool read_rows(static_system *s)
{
    for (int k = 0; k < s->w->hand_count; k++) {
        const world_hand *h = &s->w->hands[k];
        for (int i = 0; i < h->joint_count; i++)
            if (!read_joint(s, k, i)) return false;
        for (int i = 0; i < h->tie_count; i++)
            if (!read_tie(s, k, i)) return false;
        for (int i = 0; i < h->loop_count; i++)
            if (!read_loop(s, k, i)) return false;
    }
    s->unknowns = s->coordinates;
    for (int i = 0; i < s->row_count; i++)
        if (s->rows[i].rigid) s->rows[i].unknown = s->unknowns++;
    return true;
}

/* ---- Contacts. ---- */

static bool is_known_law(const pinch_contact *c)
{
    bool limits = false;
    for (int i = 0; i < 5; i++) limits = limits || c->friction_limit[i] != 0;
    return c->model != PINCH_CONTACT_ROLLING && !limits && c->viscous[0] == 0 && c->viscous[1] == 0;
}

static bool read_contact(static_system *s, const pinch_ode_contact *from, const pinch_contact *data)
{
    static_contact *c = &s->contacts[s->contact_count];
    s->data[s->contact_count] = *data;
    c->data = &s->data[s->contact_count];
    c->body[0] = from->body1;
    c->body[1] = from->body2;
    c->finger = world_finger_of_pair(s->w, from->geom1, from->geom2);
    c->sign = c->finger >= 0 && s->w->objects[s->w->fingers[c->finger].object].geom == from->geom2 ? -1 : 1;
    /* The law of the statics is that of a step of one second whose dampers are gone. */
    pinch_contact still = *data;
    memset(still.damping, 0, sizeof still.damping);
    exact_law_of(&still, 1, &c->law);
    scene_copy(data->normal, c->axis[0]);
    scene_copy(data->tangent1, c->axis[1]);
    scene_cross(c->axis[0], c->axis[1], c->axis[2]);
    c->g = calloc((size_t)c->law.rows * (size_t)s->coordinates, sizeof *c->g);
    if (!c->g) return false;
    s->contact_count++;
    for (int i = 0; i < c->law.rows; i++)
        for (int k = 0; k < 2; k++)
            static_add_motion(s, c->body[k], data->position, c->axis[i % 3], i == 3, k ? -1 : 1,
                              c->g + i * s->coordinates);
    return true;
}

static bool read_contacts(static_system *s, char *why)
{
    const pinch_ode_contact *list;
    pinch_problem problem;
    int count, *places;
    if (pinch_ode_contacts(s->w->plugin, &list, &count) != PINCH_OK) return false;
    places = calloc((size_t)count + 1, sizeof *places);
    s->contacts = calloc((size_t)count + 1, sizeof *s->contacts);
    s->data = calloc((size_t)count + 1, sizeof *s->data);
    bool fine = places && s->contacts && s->data;
    for (int i = 0; fine && i < pinch_ode_island_count(s->w->plugin); i++) {
        fine = pinch_ode_read_island(s->w->plugin, i, &problem, places) == PINCH_OK;
        for (int k = 0; fine && k < problem.contact_count; k++) {
            if (!is_known_law(&problem.contacts[k])) {
                snprintf(why, 256, "contacts that roll, or have friction in newtons");
                fine = false;
            }
            fine = fine && read_contact(s, &list[places[k]], &problem.contacts[k]);
        }
    }
    free(places);
    return fine;
}

/* ---- The whole. ---- */

/* A drive by speed that stands beside another one, and that nothing tells to move, only damps. */
static bool has_no_place(const scene_hand *h, size_t index)
{
    const scene_control *c = &h->controls[index];
    bool moves = index < h->model->joint_count + h->model->tendon_count;
    for (size_t i = 0; i < c->target_count && !moves; i++) moves = c->target[i].value != 0;
    return c->type == SCENE_VELOCITY_CONTROL && moves;
}

/* What stands still only in motion, or moves in a way that the statics have no coordinates for. */
static bool is_meant(const world *w, char *why)
{
    why[0] = '\0';
    if (w->plane) snprintf(why, 256, "scenes in a plane");
    for (int i = 0; i < w->finger_count && !why[0]; i++)
        if (!w->fingers[i].hand && (w->fingers[i].slider || w->fingers[i].finger->has_normal_force))
            snprintf(why, 256, "fingers on sliders or under force control beside a hand");
    for (int k = 0; k < w->hand_count && !why[0]; k++) {
        const scene_hand *h = w->hands[k].hand;
        for (size_t i = 0; i < h->control_count && !why[0]; i++)
            if (has_no_place(h, i))
                snprintf(why, 256, "drives by speed (%s), which have no place to stand still", h->controls[i].name);
    }
    return why[0] == '\0';
}

bool static_system_read(static_system *s, const world *w, char *why)
{
    memset(s, 0, sizeof *s);
    s->w = w;
    if (!is_meant(w, why)) return false;
    s->first_joint = calloc((size_t)w->hand_count + 1, sizeof *s->first_joint);
    if (!s->first_joint) return false;
    s->coordinates = 6 * w->object_count;
    for (int k = 0; k < w->hand_count; k++) {
        s->first_joint[k] = s->coordinates;
        s->coordinates += w->hands[k].joint_count;
    }
    s->load = calloc((size_t)s->coordinates + 1, sizeof *s->load);
    s->weight = calloc((size_t)s->coordinates + 1, sizeof *s->weight);
    s->weight_change = calloc((size_t)(s->coordinates * s->coordinates) + 1, sizeof *s->weight_change);
    if (!s->load || !s->weight || !s->weight_change) return false;
    read_loads(s);
    return read_rows(s) && read_contacts(s, why);
}

void static_system_free(static_system *s)
{
    for (int i = 0; i < s->contact_count; i++) free(s->contacts[i].g);
    for (int i = 0; i < s->row_count; i++) free(s->rows[i].a);
    free(s->contacts);
    free(s->data);
    free(s->rows);
    free(s->load);
    free(s->weight);
    free(s->weight_change);
    free(s->first_joint);
}
