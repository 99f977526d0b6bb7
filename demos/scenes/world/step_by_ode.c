/* The contacts of a step solved by ODE's own solvers. The points are the collider's, those of Pinch's manifolds, or
 * given ones. */
#include "world.h"

#include "common/measure.h"

#include <stdlib.h>
#include <string.h>

bool world_contact_room(world *w, int count)
{
    if (count <= w->contact_room) return true;
    int room = 2 * count + 64;
    world_contact *more = realloc(w->contacts, (size_t)room * sizeof *more);
    if (!more) return false;
    w->contacts = more;
    w->contact_room = room;
    return true;
}

static double friction_of(const pinch_material *m)
{
    return m->model == PINCH_CONTACT_FRICTIONLESS ? 0 : m->friction;
}

/* Two materials are in series, as Pinch has them. */
void world_set_surface(const world *w, world_contact *c)
{
    const pinch_material *m = c->material, *other = c->other;
    double stiffness = other ? scene_in_series(m->stiffness[0], other->stiffness[0]) : m->stiffness[0];
    double damping = other ? scene_in_series(m->damping[0], other->damping[0]) : m->damping[0];
    double h = w->scene->step, g = (h * stiffness + damping) / c->sharing;
    c->contact.surface.mode = dContactSoftERP | dContactSoftCFM | dContactApprox1;
    c->contact.surface.mu = other ? fmin(friction_of(m), friction_of(other)) : friction_of(m);
    c->contact.surface.soft_erp = h * stiffness / (h * stiffness + damping);
    c->contact.surface.soft_cfm = 1 / g;
}

/* Makes an ODE contact joint with the finger's stiffness and damping, which the pair's points share. */
static void make_joint(world *w, world_contact *c)
{
    world_set_surface(w, c);
    dJointID joint = dJointCreateContact(w->ode, w->contact_group, &c->contact);
    dJointAttach(joint, c->body[0], c->body[1]);
    dJointSetFeedback(joint, &c->feedback);
}

bool world_give_contacts(world *w, const world_contact *contacts, int count)
{
    if (!world_contact_room(w, count)) return false;
    if (count > 0) memcpy(w->contacts, contacts, (size_t)count * sizeof *contacts);
    w->contact_count = count;
    w->contacts_given = true;
    return true;
}

/* Reads the manifold points that ODE has solved, as contacts with their feedback. */
static bool take_manifold_points(world *w)
{
    const pinch_ode_contact *list;
    int count;
    pinch_ode_contacts(w->manifolds, &list, &count);
    if (!world_contact_room(w, count)) return false;
    w->contact_count = count;
    for (int k = 0; k < count; k++) {
        const pinch_ode_contact *from = &list[k];
        world_contact *c = &w->contacts[k];
        memset(c, 0, sizeof *c);
        c->body[0] = from->body1;
        c->body[1] = from->body2;
        c->owner = world_finger_of_pair(w, from->geom1, from->geom2);
        c->contact.geom.g1 = from->geom1;
        c->contact.geom.g2 = from->geom2;
        c->contact.geom.depth = from->depth;
        for (int i = 0; i < 3; i++) {
            c->contact.geom.pos[i] = from->position[i];
            c->contact.geom.normal[i] = from->normal[i];
            c->feedback.f1[i] = (from->body1 ? 1 : -1) * from->force[i]; /* as ODE writes it */
        }
    }
    return true;
}

static world_status step_with_manifolds(world *w)
{
    double start = clock_seconds();
    for (int i = 0; i < w->contact_count; i++)
        if (pinch_ode_add_contact(w->manifolds, &w->contacts[i].contact, w->contacts[i].body[0],
                                  w->contacts[i].body[1]) != PINCH_OK)
            return WORLD_NO_MEMORY;
    pinch_status status = pinch_ode_step(w->manifolds, w->scene->step);
    w->step_s += clock_seconds() - start;
    if (status == PINCH_INVALID_ARGUMENT) return WORLD_DIVERGED;
    return status == PINCH_OK && take_manifold_points(w) ? WORLD_OK : WORLD_NO_MEMORY;
}

world_status world_step_with_ode(world *w)
{
    if (w->manifolds) return step_with_manifolds(w);
    double start = clock_seconds();
    for (int i = 0; i < w->contact_count; i++) make_joint(w, &w->contacts[i]);
    double handed_over = clock_seconds();
    bool quick = w->settings.contact_solver == WORLD_QUICKSTEP;
    int stepped = quick ? dWorldQuickStep(w->ode, w->scene->step) : dWorldStep(w->ode, w->scene->step);
    w->solve_s += clock_seconds() - handed_over;
    dJointGroupEmpty(w->contact_group);
    w->step_s += clock_seconds() - start;
    return stepped ? WORLD_OK : WORLD_NO_MEMORY;
}
