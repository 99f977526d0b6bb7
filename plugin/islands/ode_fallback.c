/* What no solver of Pinch's solved goes to ODE's own for a step. */
#include "plugin.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* The contact as an ODE joint of the same stiffness; place: in the read-out. */
static void leave_contact(pinch_ode *p, const pinch_contact *c, int place, double h)
{
    pinch_ode_contact *out = &p->contacts.items[place];
    dContact contact;
    memset(&contact, 0, sizeof contact);
    double g = h * c->stiffness[0] + c->damping[0];
    contact.surface.mode = dContactSoftERP | dContactSoftCFM;
    bool limited = c->friction_limit[0] > 0;
    if (!limited) contact.surface.mode |= dContactApprox1;
    contact.surface.mu = c->model == PINCH_CONTACT_FRICTIONLESS ? 0 : limited ? c->friction_limit[0] : c->friction[0];
    contact.surface.soft_erp = h * c->stiffness[0] / g;
    contact.surface.soft_cfm = 1 / g;
    contact.geom.depth = c->depth;
    pinch_v3_copy(contact.geom.pos, c->position);
    pinch_v3_copy(contact.geom.normal, c->normal);
    dJointID joint = dJointCreateContact(p->world, p->left, &contact);
    dJointAttach(joint, out->body1, out->body2);
    pinch_left_contact *left = &p->left_contacts.items[p->left_contacts.count++];
    left->contact = place;
    left->sign = out->body1 ? 1 : -1; /* attached as (0, body), ODE writes the force on the body first */
    dJointSetFeedback(joint, &left->feedback);
    pinch_v3_copy(out->position, c->position);
    pinch_v3_copy(out->normal, c->normal);
    out->depth = c->depth;
}

/* The program's own joints stay enabled: it handed these points over as such. */
static bool came_as_joints(const pinch_ode *p, const pinch_pair *pair)
{
    for (int t = pair->first_taken; t >= 0; t = p->taken.items[t].next)
        if (p->taken.items[t].joint >= 0) return true;
    return false;
}

bool pinch_leave_island(pinch_ode *p, const pinch_island *island, double h)
{
    /* room for all at once: ODE keeps pointers into the list */
    pinch_desk *desk = &p->desk[0];
    if (!PINCH_RESERVE(p->left_contacts, p->contacts.count) || !pinch_desk_reserve(desk, 0, island->contact_count, 0))
        return false;
    pinch_fill_contacts(p, island, h, desk->contacts.items);
    p->stats.fallback_islands++;
    for (int i = 0; i < island->pair_count; i++) {
        const pinch_pair *pair = &p->pairs.items[p->pair_of.items[island->first_pair + i]];
        for (int k = 0; k < pair->manifold.count && !came_as_joints(p, pair); k++)
            leave_contact(p, &desk->contacts.items[pair->first_core + k], pair->first_contact + k, h);
    }
    p->stats.contacts_left += island->contact_count;
    p->stats.contacts_left_unsolved += island->contact_count;
    return true;
}

/* The forces that ODE found for contacts that were left to it. Its contacts do not give sideways: no elastic state. */
void pinch_read_left_contacts(pinch_ode *p)
{
    for (int k = 0; k < p->left_contacts.count; k++) {
        const pinch_left_contact *left = &p->left_contacts.items[k];
        pinch_ode_contact *out = &p->contacts.items[left->contact];
        for (int i = 0; i < 3; i++) out->force[i] = left->sign * left->feedback.f1[i];
        out->normal_force = pinch_v3_dot(out->force, out->normal);
        pinch_v3_copy(out->tangential, out->force);
        pinch_v3_add_scaled(out->tangential, -out->normal_force, out->normal);
        out->state = out->normal_force > 0 ? PINCH_CONTACT_STICK : PINCH_CONTACT_OPEN;
    }
}
