/* The fallback to ODE: an island that Pinch has no answer for is solved by ODE's own contact joints for this step. */
#include "islands/island_life.h"

#include "support/vec3.h"

#include <string.h>

/* Makes a contact an ODE joint of the same stiffness. result: its index among the results. */
static void make_contact_joint(const pinch_step_context *context, const pinch_contact *c, int result,
                               pinch_ode_contact *out, pinch_fallback_contact *fallback)
{
    dContact contact;
    memset(&contact, 0, sizeof contact);
    double g = context->h * c->stiffness[0] + c->damping[0];
    contact.surface.mode = dContactSoftERP | dContactSoftCFM;
    bool limited = c->friction_limit[0] > 0;
    if (!limited) contact.surface.mode |= dContactApprox1;
    contact.surface.mu = c->model == PINCH_CONTACT_FRICTIONLESS ? 0 : limited ? c->friction_limit[0] : c->friction[0];
    contact.surface.soft_erp = context->h * c->stiffness[0] / g;
    contact.surface.soft_cfm = 1 / g;
    contact.geom.depth = c->depth;
    pinch_v3_copy(contact.geom.pos, c->position);
    pinch_v3_copy(contact.geom.normal, c->normal);
    dJointID joint = dJointCreateContact(context->world, context->joint_group, &contact);
    dJointAttach(joint, out->body1, out->body2);
    fallback->result = result;
    fallback->sign = out->body1 ? 1 : -1; /* attached as (0, body), ODE writes the force on the body first */
    dJointSetFeedback(joint, &fallback->feedback);
    pinch_v3_copy(out->position, c->position);
    pinch_v3_copy(out->normal, c->normal);
    out->depth = c->depth;
}

/* Tells whether the program made contact joints for the pair itself. Those stay enabled. */
static bool came_as_joints(const pinch_contact_store *contacts, const pinch_pair *pair)
{
    for (int b = pair->first_buffered; b >= 0; b = contacts->buffer.items[b].next)
        if (contacts->buffer.items[b].joint >= 0) return true;
    return false;
}

bool pinch_solve_island_by_ode(const pinch_step_context *context, pinch_contact_store *contacts,
                               pinch_island_graph *graph, pinch_solver_pool *pool, pinch_ode_stats *stats,
                               const pinch_island *island)
{
    pinch_problem_buffers *buffers = &pool->thread[0].buffers;
    /* there must be room for all at once: ODE keeps pointers into the list */
    if (!PINCH_RESERVE(graph->fallback_contacts, contacts->results.count) ||
        !pinch_reserve_problem(buffers, 0, island->contacts.count, 0))
        return false;
    pinch_problem problem = {.contacts = buffers->contacts.items};
    pinch_fill_contacts(context, contacts, &graph->bodies, island, &problem);
    for (int i = 0; i < island->pairs.count; i++) {
        const pinch_pair *pair = pinch_island_pair(contacts, island->pairs, i);
        bool by_program = came_as_joints(contacts, pair);
        for (int k = 0; k < pair->manifold.count && !by_program; k++) {
            int result = pair->first_result + k;
            make_contact_joint(context, &buffers->contacts.items[pair->first_in_island + k], result,
                               &contacts->results.items[result],
                               &graph->fallback_contacts.items[graph->fallback_contacts.count++]);
        }
    }
    stats->fallback_islands++;
    stats->contacts_left += island->contacts.count;
    stats->contacts_left_unsolved += island->contacts.count;
    return true;
}

/* ODE's contacts do not give sideways, so that there is no elastic state. */
void pinch_read_fallback_contacts(pinch_contact_store *contacts, const pinch_island_graph *graph)
{
    for (int k = 0; k < graph->fallback_contacts.count; k++) {
        const pinch_fallback_contact *fallback = &graph->fallback_contacts.items[k];
        pinch_ode_contact *out = &contacts->results.items[fallback->result];
        for (int i = 0; i < 3; i++) out->force[i] = fallback->sign * fallback->feedback.f1[i];
        out->normal_force = pinch_v3_dot(out->force, out->normal);
        pinch_v3_copy(out->tangential, out->force);
        pinch_v3_add_scaled(out->tangential, -out->normal_force, out->normal);
        out->state = out->normal_force > 0 ? PINCH_CONTACT_STICK : PINCH_CONTACT_OPEN;
    }
}
