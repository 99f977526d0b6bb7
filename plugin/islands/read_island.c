/* The islands of a solved step, for those who want to check or record them. */
#include "plugin.h"

int pinch_ode_island_count(const pinch_ode *p)
{
    return p && p->solved ? p->islands.count : 0;
}

pinch_status pinch_ode_read_island(const pinch_ode *p, int index, pinch_problem *problem, int *places)
{
    if (!problem || !places || index < 0 || index >= pinch_ode_island_count(p) || !p->settings.keep_islands)
        return PINCH_INVALID_ARGUMENT;
    const pinch_island *island = &p->islands.items[index];
    *problem = (pinch_problem){
        .step = p->solved_h,
        .faces = p->settings.faces,
        .body_count = island->body_count,
        .contact_count = island->contact_count,
        .row_count = island->row_count,
        .bodies = p->kept.bodies.items + island->first_body,
        .contacts = p->kept.contacts.items + island->first_contact,
        .rows = p->kept.rows.items + PINCH_JOINT_MAX_ROWS * island->first_joint,
    };
    for (int i = 0; i < island->pair_count; i++) {
        const pinch_pair *pair = &p->pairs.items[p->pair_of.items[island->first_pair + i]];
        for (int k = 0; k < pair->manifold.count; k++) places[pair->first_core + k] = pair->first_contact + k;
    }
    return PINCH_OK;
}
