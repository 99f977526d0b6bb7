/* A manifold's points as contacts of a core problem: frame, law, history, and what moves by prescription. */
#include "plugin.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* Adds the velocity of a body that is no unknown, at a point; a driven body's own prescribed motion included. False:
 * there is none. */
static bool add_prescribed(const pinch_ode *p, dBodyID body, int step_body, const double *point, double sign,
                           double *linear, double *angular)
{
    if (!body || (step_body >= 0 && p->bodies.items[step_body].drive < 0)) return false;
    const double *w = dBodyGetAngularVel(body);
    double arm[3], turned[3];
    pinch_v3_sub(point, dBodyGetPosition(body), arm);
    pinch_v3_cross(w, arm, turned);
    pinch_v3_add_scaled(linear, sign, dBodyGetLinearVel(body));
    pinch_v3_add_scaled(linear, sign, turned);
    pinch_v3_add_scaled(angular, sign, w);
    return true;
}

/* The first tangent: a material's facet axis, turned with its geom, where there are facets; a cone is round. */
static void choose_tangent(const pinch_ode *p, const pinch_pair *pair, const double *normal, double *tangent)
{
    for (int side = 0; side < 2 && p->settings.faces; side++) {
        const pinch_geom_record *record = &p->geoms.items[pair->geom[side]];
        const pinch_material *material = pinch_geom_material(p, record);
        if (!material) continue;
        const double *axis = material->facet_axis;
        if (axis[0] == 0 && axis[1] == 0 && axis[2] == 0) continue;
        const double *R = pinch_geom_pose(record->geom).rotation;
        for (int i = 0; i < 3; i++) tangent[i] = pinch_v3_dot(R + 4 * i, axis);
        double length = pinch_v3_norm(tangent);
        pinch_v3_make_perpendicular(tangent, normal);
        double left = pinch_v3_norm(tangent);
        if (left > 1e-6 * length) {
            pinch_v3_scale(tangent, 1 / left);
            return;
        }
    }
    pinch_v3_any_perpendicular(normal, tangent);
}

/* The fingertip's law, shared by the points of its manifold. */
static void apply_material(const pinch_ode *p, const pinch_pair *pair, const pinch_material *material,
                           const pinch_manifold_point *point, pinch_contact *c)
{
    double share = 1.0 / pair->manifold.count; /* of the fingertip's stiffness, for each point of its manifold */
    c->model = material->model;
    choose_tangent(p, pair, c->normal, c->tangent1);
    for (int i = 0; i < 3; i++) {
        c->stiffness[i] = share * material->stiffness[i];
        c->damping[i] = share * material->damping[i];
    }
    c->friction[0] = c->friction[1] = point->slipping ? material->friction_kinetic : material->friction;
    c->torsional_friction = material->torsional_friction;
    c->max_force = share * material->max_force;
}

/* A point with surface parameters of its own; the velocities are those at the start of the step. */
static void apply_surface(const pinch_ode *p, const pinch_pair *pair, double h, const int body[2],
                          const pinch_manifold_point *point, pinch_contact *c)
{
    double mobility = 0, linear[3] = {0, 0, 0};
    for (int side = 0; side < 2; side++) {
        dBodyID b = pair->body[side];
        dVector3 velocity;
        if (!b) continue;
        dBodyGetPointVel(b, point->position[0], point->position[1], point->position[2], velocity);
        pinch_v3_add_scaled(linear, side ? -1 : 1, velocity);
        if (body[side] < 0) continue;
        dMass mass;
        dBodyGetMass(b, &mass);
        mobility += 1 / mass.mass;
    }
    c->max_force = INFINITY;
    double size = fmin(p->geoms.items[pair->geom[0]].size, p->geoms.items[pair->geom[1]].size);
    const pinch_own_law *own = point->own;
    pinch_surface_apply(&p->surfaces.items[own->surface], own->tangent1, p->world, h, p->settings.tangential_ratio,
                        mobility, size, pinch_v3_dot(linear, c->normal), point->normal_force > 0, c);
    pinch_v3_copy(c->compliance, own->compliance);
    c->floor = own->floor;
    c->hold = own->hold;
}

static void fill_history(const pinch_manifold_point *point, pinch_contact *c)
{
    double t2[3];
    pinch_v3_cross(c->normal, c->tangent1, t2);
    c->elastic[0] = pinch_v3_dot(c->tangent1, point->elastic);
    c->elastic[1] = pinch_v3_dot(t2, point->elastic);
    c->elastic[2] = point->twist;
    c->force[0] = point->normal_force;
    c->force[1] = pinch_v3_dot(c->tangent1, point->friction);
    c->force[2] = pinch_v3_dot(t2, point->friction);
    c->force[3] = point->torsion;
    const pinch_rolling *rolling = pinch_rolling_of(point);
    if (!rolling) return;
    c->rolling_elastic[0] = pinch_v3_dot(c->tangent1, rolling->rolled);
    c->rolling_elastic[1] = pinch_v3_dot(t2, rolling->rolled);
    c->rolling_moment[0] = pinch_v3_dot(c->tangent1, rolling->moment);
    c->rolling_moment[1] = pinch_v3_dot(t2, rolling->moment);
}

static void add_surface_velocity(const double *linear, const double *angular, pinch_contact *c)
{
    double t2[3];
    pinch_v3_cross(c->normal, c->tangent1, t2);
    c->surface_velocity[0] += pinch_v3_dot(c->normal, linear);
    c->surface_velocity[1] += pinch_v3_dot(c->tangent1, linear);
    c->surface_velocity[2] += pinch_v3_dot(t2, linear);
    c->surface_velocity[3] += pinch_v3_dot(c->normal, angular);
    if (c->model != PINCH_CONTACT_ROLLING) return;
    c->surface_velocity[4] += pinch_v3_dot(c->tangent1, angular);
    c->surface_velocity[5] += pinch_v3_dot(t2, angular);
}

/* material: NULL where the points have surface parameters. share: how much of the overlap lies between geom[0]'s
 * surface and the contact; the manifold's points lie half way. */
static void fill_contact(const pinch_ode *p, const pinch_pair *pair, const pinch_material *material, double share,
                         double h, const pinch_manifold_point *point, pinch_contact *c)
{
    const int *body = pair->step_body;
    memset(c, 0, sizeof *c);
    c->body1 = body[0] >= 0 ? p->bodies.items[body[0]].local : PINCH_STATIC_BODY;
    c->body2 = body[1] >= 0 ? p->bodies.items[body[1]].local : PINCH_STATIC_BODY;
    pinch_v3_copy(c->position, point->position);
    if (material) pinch_v3_add_scaled(c->position, (share - 0.5) * point->depth, point->normal);
    pinch_v3_copy(c->normal, point->normal);
    c->depth = point->depth;
    if (material)
        apply_material(p, pair, material, point, c);
    else
        apply_surface(p, pair, h, body, point, c);
    fill_history(point, c);

    double linear[3] = {0, 0, 0}, angular[3] = {0, 0, 0};
    bool prescribed = false;
    for (int side = 0; side < 2; side++) {
        prescribed |= add_prescribed(p, pair->body[side], body[side], c->position, side ? -1 : 1, linear, angular);
        /* a driven finger's force is its drive's: a limit below it would leave nothing to balance it */
        if (body[side] >= 0 && p->bodies.items[body[side]].drive >= 0) c->max_force = INFINITY;
    }
    if (prescribed) add_surface_velocity(linear, angular, c);
}

void pinch_fill_contacts(const pinch_ode *p, const pinch_island *island, double h, pinch_contact *contacts)
{
    for (int i = 0; i < island->pair_count; i++) {
        const pinch_pair *pair = &p->pairs.items[p->pair_of.items[island->first_pair + i]];
        pinch_material material;
        double share = 0.5;
        bool has_material = pair->has_material && pinch_pair_material(p, pair, &material, &share);
        for (int k = 0; k < pair->manifold.count; k++)
            fill_contact(p, pair, has_material ? &material : NULL, share, h, &pair->manifold.point[k],
                         &contacts[pair->first_core + k]);
    }
}
