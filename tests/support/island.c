#include "support/island.h"

#include "support/arithmetic.h"
#include "support/draw.h"

#include <string.h>

const char *island_kind_name(island_kind kind)
{
    static const char *const names[ISLAND_KIND_COUNT] = {"frictionless", "hard",   "soft",   "mixed", "slipping",
                                                         "rough",        "joints", "drives", "grasp"};
    return names[kind];
}

/* A homogeneous ellipsoid-like body: principal inertias of semi-axes of its own, turned at random. */
static void make_body(pinch_random *random, pinch_body *b)
{
    double R[9], axes[3], size = draw_log_uniform(random, 0.01, 0.1);
    memset(b, 0, sizeof *b);
    b->mass = draw_log_uniform(random, 0.01, 5);
    b->radius = size;
    draw_frame(random, R);
    for (int i = 0; i < 3; i++) axes[i] = size * draw_uniform(random, 0.3, 1);
    double principal[3];
    for (int i = 0; i < 3; i++) {
        double p = axes[(i + 1) % 3], q = axes[(i + 2) % 3];
        principal[i] = b->mass * (p * p + q * q) / 5;
    }
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            for (int k = 0; k < 3; k++) b->inertia[3 * i + j] += R[3 * k + i] * principal[k] * R[3 * k + j];
    b->inertia[3] = b->inertia[1];
    b->inertia[6] = b->inertia[2];
    b->inertia[7] = b->inertia[5];
    for (int i = 0; i < 3; i++) {
        b->position[i] = draw_uniform(random, -0.1, 0.1);
        b->velocity[i] = draw_uniform(random, -0.5, 0.5);
        b->velocity[3 + i] = draw_uniform(random, -0.5, 0.5) / size * 0.2;
    }
    b->external[2] = -9.81 * b->mass;
}

static void make_contact(pinch_random *random, const pinch_problem *p, int body1, int body2, pinch_contact_model model,
                         double mu_low, double mu_high, pinch_contact *c)
{
    const pinch_body *b = &p->bodies[body1];
    double outward[3], load = draw_log_uniform(random, 0.01, 50), kn = draw_log_uniform(random, 1e2, 1e6);
    memset(c, 0, sizeof *c);
    c->body1 = body1;
    c->body2 = body2;
    c->model = model;
    draw_direction(random, outward);
    for (int i = 0; i < 3; i++) c->position[i] = b->position[i] + b->radius * outward[i];
    /* the normal points inwards, up to half a right angle off the centre */
    double length = 0;
    for (int i = 0; i < 3; i++) c->normal[i] = -outward[i] + draw_uniform(random, -0.5, 0.5);
    for (int i = 0; i < 3; i++) length += c->normal[i] * c->normal[i];
    for (int i = 0; i < 3; i++) c->normal[i] /= sqrt(length);
    draw_tangent(random, c->normal, c->tangent1);
    c->stiffness[0] = kn;
    c->stiffness[1] = kn * draw_uniform(random, 0.2, 1);
    c->stiffness[2] = kn * b->radius * b->radius * draw_log_uniform(random, 1e-3, 1e-1);
    double time = draw_chance(random, 0.2) ? 0 : draw_log_uniform(random, 1e-4, 1e-2);
    for (int i = 0; i < 3; i++) c->damping[i] = c->stiffness[i] * time;
    c->depth = load / kn * (draw_chance(random, 0.2) ? -1 : 1);
    c->friction[0] = c->friction[1] = draw_chance(random, 0.05) ? 0 : draw_uniform(random, mu_low, mu_high);
    c->torsional_friction = b->radius * draw_log_uniform(random, 1e-3, 0.3);
    double reach = c->friction[0] * load / c->stiffness[1];
    for (int i = 0; i < 2; i++) c->elastic[i] = draw_uniform(random, -1.2, 1.2) * reach;
    c->elastic[2] = draw_uniform(random, -1.2, 1.2) * c->torsional_friction * load / c->stiffness[2];
    c->max_force = draw_chance(random, 0.1) ? load * draw_uniform(random, 0.5, 2) : INFINITY;
    for (int i = 0; i < 4; i++) c->surface_velocity[i] = draw_chance(random, 0.2) ? draw_uniform(random, -0.1, 0.1) : 0;
}

static pinch_contact_model draw_model(pinch_random *random, island_kind kind)
{
    static const pinch_contact_model models[3] = {PINCH_CONTACT_FRICTIONLESS, PINCH_CONTACT_HARD, PINCH_CONTACT_SOFT};
    switch (kind) {
    case ISLAND_FRICTIONLESS:
        return PINCH_CONTACT_FRICTIONLESS;
    case ISLAND_HARD:
    case ISLAND_ROUGH:
        return PINCH_CONTACT_HARD;
    case ISLAND_SOFT:
        return PINCH_CONTACT_SOFT;
    case ISLAND_SLIPPING:
        return models[1 + draw_index(random, 2)];
    default:
        return models[draw_index(random, 3)];
    }
}

static void make_contacts(pinch_random *random, pinch_problem *p, island_kind kind)
{
    int count = kind == ISLAND_ROUGH ? 2 * p->body_count + draw_index(random, 2 * p->body_count + 1)
                                     : p->body_count + draw_index(random, 2 * p->body_count + 2);
    double low = kind == ISLAND_ROUGH ? 0.8 : 0, high = kind == ISLAND_SLIPPING ? 0.4 : 1.2;
    for (int k = 0; k < count && k < ISLAND_CONTACTS; k++) {
        int body1 = k < p->body_count ? k : draw_index(random, p->body_count);
        int body2 = draw_chance(random, 0.6) ? draw_index(random, p->body_count) : PINCH_STATIC_BODY;
        if (body2 == body1) body2 = PINCH_STATIC_BODY;
        pinch_contact *c = &p->contacts[p->contact_count++];
        make_contact(random, p, body1, body2, draw_model(random, kind), low, high, c);
        if (kind == ISLAND_MIXED && draw_chance(random, 0.2)) c->friction[1] *= draw_uniform(random, 0.2, 1);
        if (kind != ISLAND_SLIPPING) continue;
        c->depth = fabs(c->depth);
        c->surface_velocity[1] = draw_uniform(random, 0.5, 2);
        c->surface_velocity[2] = draw_uniform(random, -1, 1);
    }
}

/* One body held by contacts that press towards its centre, as in a hand. */
static void make_grasp(pinch_random *random, pinch_problem *p)
{
    int count = 2 + draw_index(random, 7);
    double mu = draw_uniform(random, 0.3, 1.2), kn = draw_log_uniform(random, 1e3, 1e5);
    pinch_body *b = &p->bodies[0];
    for (int i = 0; i < 6; i++) b->velocity[i] *= 0.02;
    for (int k = 0; k < count; k++) {
        pinch_contact *c = &p->contacts[p->contact_count++];
        pinch_contact_model model = draw_chance(random, 0.3) ? PINCH_CONTACT_SOFT : PINCH_CONTACT_HARD;
        make_contact(random, p, 0, PINCH_STATIC_BODY, model, 0, 1, c);
        double scale = kn / c->stiffness[0], load = draw_log_uniform(random, 0.5, 50);
        for (int i = 0; i < 3; i++) {
            c->stiffness[i] *= scale;
            c->damping[i] *= scale;
        }
        c->depth = load / kn;
        c->friction[0] = c->friction[1] = mu;
        for (int i = 0; i < 2; i++) c->elastic[i] = draw_uniform(random, -0.6, 0.6) * mu * load / c->stiffness[1];
    }
}

static pinch_joint_row *add_row(pinch_problem *p, int body1, int body2)
{
    pinch_joint_row *row = &p->rows[p->row_count++];
    memset(row, 0, sizeof *row);
    row->body1 = body1;
    row->body2 = body2;
    row->low = -INFINITY;
    row->high = INFINITY;
    return row;
}

/* No relative velocity along `axis` at `point`. */
static void linear_row(pinch_problem *p, int body1, int body2, const double *axis, const double *point, double rhs)
{
    pinch_joint_row *row = add_row(p, body1, body2);
    const int body[2] = {body1, body2};
    double *j[2] = {row->j1, row->j2};
    row->rhs = rhs;
    for (int side = 0; side < 2; side++) {
        if (body[side] < 0) continue;
        double arm[3], direction[3];
        for (int i = 0; i < 3; i++) {
            direction[i] = (side ? -1 : 1) * axis[i];
            arm[i] = point[i] - p->bodies[body[side]].position[i];
        }
        memcpy(j[side], direction, sizeof direction);
        cross(arm, direction, j[side] + 3);
    }
}

static void angular_row(pinch_problem *p, int body1, int body2, const double *axis, double rhs)
{
    pinch_joint_row *row = add_row(p, body1, body2);
    row->rhs = rhs;
    for (int i = 0; i < 3; i++) {
        row->j1[3 + i] = axis[i];
        if (body2 >= 0) row->j2[3 + i] = -axis[i];
    }
}

/* A joint of `body` with the one before it or the world: ball, hinge or slider, then perhaps a stop, motor or spring
 * along what it leaves free. Joints only ever go to the body before: a tree, whose rows do not contradict. */
static void make_joint(pinch_random *random, pinch_problem *p, int body)
{
    int other = body > 0 && draw_chance(random, 0.5) ? body - 1 : PINCH_STATIC_BODY, type = draw_index(random, 3);
    double frame[9], point[3];
    draw_frame(random, frame);
    for (int i = 0; i < 3; i++)
        point[i] = p->bodies[body].position[i] + p->bodies[body].radius * draw_uniform(random, -1, 1);
    for (int i = type == 2 ? 1 : 0; i < 3; i++)
        linear_row(p, body, other, frame + 3 * i, point, draw_uniform(random, -0.01, 0.01));
    for (int i = type == 2 ? 0 : 1; i < 3 && type > 0; i++)
        angular_row(p, body, other, frame + 3 * i, draw_uniform(random, -0.1, 0.1));

    int extra = draw_index(random, 4);
    if (extra == 0) return;
    if (type == 2)
        linear_row(p, body, other, frame, point, draw_uniform(random, -0.2, 0.2));
    else
        angular_row(p, body, other, frame, draw_uniform(random, -2, 2));
    pinch_joint_row *row = &p->rows[p->row_count - 1];
    double strength = draw_log_uniform(random, 0.01, 10) * (type == 2 ? 1 : p->bodies[body].radius);
    if (extra == 1) { /* a stop */
        row->low = 0;
    } else if (extra == 2) { /* a motor */
        row->low = -strength;
        row->high = strength;
    } else { /* a spring and damper, now and then of limited force */
        row->cfm = draw_log_uniform(random, 1e-3, 1) * (type == 2 ? 1 : 1 / pow(p->bodies[body].radius, 2));
        if (draw_chance(random, 0.3)) row->high = strength;
    }
}

/* Two massless drives that push a body from both sides, as force-controlled fingers do. */
static void make_drives(pinch_random *random, pinch_problem *p)
{
    double normal[3], force = draw_log_uniform(random, 0.5, 50);
    draw_direction(random, normal);
    for (int side = 0; side < 2; side++) {
        pinch_body *drive = &p->bodies[p->body_count];
        memset(drive, 0, sizeof *drive);
        drive->radius = 1;
        drive->drive_force = force * (side ? draw_uniform(random, 0.8, 1.2) : 1);
        for (int i = 0; i < 3; i++) drive->drive_axis[i] = (side ? -1 : 1) * normal[i];
        int points = 1 + draw_index(random, 3);
        for (int k = 0; k < points; k++) {
            pinch_contact *c = &p->contacts[p->contact_count++];
            make_contact(random, p, 0, p->body_count, draw_model(random, ISLAND_MIXED), 0.2, 1.2, c);
            for (int i = 0; i < 3; i++) {
                c->normal[i] = drive->drive_axis[i];
                c->position[i] = p->bodies[0].position[i] - p->bodies[0].radius * drive->drive_axis[i] +
                                 0.2 * p->bodies[0].radius * draw_uniform(random, -1, 1);
            }
            draw_tangent(random, c->normal, c->tangent1);
            c->depth = fabs(c->depth);
            c->max_force = INFINITY; /* below the drive's force there would be no balance */
        }
        p->body_count++;
    }
}

double island_row_velocity(const pinch_joint_row *row, const double *v)
{
    double sum = 0;
    for (int i = 0; i < 6; i++) {
        if (row->body1 >= 0) sum += row->j1[i] * v[6 * row->body1 + i];
        if (row->body2 >= 0) sum += row->j2[i] * v[6 * row->body2 + i];
    }
    return sum;
}

void island_make(island *made, island_kind kind, uint64_t seed)
{
    pinch_random random;
    pinch_random_seed(&random, seed * ISLAND_KIND_COUNT + (uint64_t)kind);
    memset(made, 0, sizeof *made);
    pinch_problem *p = &made->problem;
    p->bodies = made->bodies;
    p->contacts = made->contacts;
    p->rows = made->rows;
    p->step = draw_log_uniform(&random, 2e-4, 5e-3);
    int bodies = kind == ISLAND_GRASP ? 1 : 1 + draw_index(&random, kind == ISLAND_DRIVES ? 3 : 6);
    for (int b = 0; b < bodies; b++) make_body(&random, &p->bodies[p->body_count++]);
    if (kind == ISLAND_GRASP) {
        make_grasp(&random, p);
        return;
    }
    make_contacts(&random, p, kind);
    if (kind == ISLAND_JOINTS)
        for (int b = 0; b < bodies; b++)
            if (b == 0 || draw_chance(&random, 0.6)) make_joint(&random, p, b);
    if (kind == ISLAND_DRIVES) make_drives(&random, p);
}
