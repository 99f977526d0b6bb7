/*
 * Contacts as they are handed over: which of them Pinch takes, and what of them is as it was in the last step. What
 * comes at one place in the row mostly is what came there in the last step, and needs not be looked up.
 */
#include "plugin.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

static bool well_formed(const dContactGeom *g)
{
    double n2 = pinch_v3_dot(g->normal, g->normal);
    return g->g1 && g->g2 && g->g1 != g->g2 && isfinite(g->depth) && fabs(n2 - 1) < 1e-3 && isfinite(g->pos[0]) &&
           isfinite(g->pos[1]) && isfinite(g->pos[2]);
}

/* Dynamic, or driven by a force. */
static bool moves(const pinch_ode *p, dBodyID body)
{
    return body && (!dBodyIsKinematic(body) || pinch_drive_of(p, body) >= 0);
}

/* ODE's own contact joint, for this step: the program's where there is one. */
static void leave_to_ode(pinch_ode *p, const dContact *contact, dBodyID body1, dBodyID body2, int joint, long *reason)
{
    if (joint < 0) dJointAttach(dJointCreateContact(p->world, p->left, contact), body1, body2);
    p->stats.contacts_left++;
    (*reason)++;
}

/* Are there laws for surface parameters at all? Not with a polygon, not without Newton's steps, and not where bodies
 * under force control, which have no mass, may belong to the island. */
static bool surfaces_solvable(const pinch_ode *p)
{
    const pinch_solver_settings *s = &p->settings.solver;
    bool newton = s->solver == PINCH_SOLVER_NEWTON || (s->solver == PINCH_SOLVER_NSNMGK && s->newton_finish);
    return newton && p->settings.faces == 0 && p->drives.count == 0;
}

static bool in_scope(const pinch_ode *p, const dContact *contact)
{
    if (p->settings.scope == PINCH_ODE_SOFT_CONTACTS) return contact->surface.mode & dContactSoftCFM;
    return p->settings.scope == PINCH_ODE_ALL_CONTACTS;
}

/* Geoms and bodies of a contact, the pair's first ones first if it is not swapped. */
typedef struct taken {
    const dContactGeom *found;
    dBodyID body[2];
    bool moves[2];
    bool swapped, material;
    int record[2];          /* where they had to be looked up */
    int surface, direction; /* see pinch_taken_contact */
    bool same_surface;      /* those the last step had in their place */
} taken;

/* The direction that the program gave, if it did; false: no memory. */
static bool take_direction(pinch_ode *p, const dContact *contact, taken *t)
{
    pinch_direction direction;
    if (!pinch_surface_direction(contact, direction.tangent)) return true;
    int index = p->directions.count;
    if (!PINCH_RESERVE(p->directions, index + 1)) return false;
    pinch_direction *place = &p->directions.items[index];
    t->same_surface =
        t->same_surface && index < p->directions_before && memcmp(&direction, place, sizeof direction) == 0;
    *place = direction;
    t->direction = index;
    return true;
}

/* The surface parameters of the next contact without a material; false: no memory. */
static bool take_surface(pinch_ode *p, const dContact *contact, const pinch_surface *surface, taken *t)
{
    const pinch_taken_contact *before = p->taken.count < p->taken_before ? &p->taken.items[p->taken.count] : NULL;
    t->surface = pinch_surface_index(p, surface, before ? before->surface : -1);
    t->same_surface = before && before->surface == t->surface;
    return t->surface >= 0 && take_direction(p, contact, t);
}

/* The pair that the last step had in the place of this contact, if it is between the same geoms and bodies; NULL: look
 * it up. */
static pinch_pair *expected(const pinch_ode *p, taken *t)
{
    if (p->taken.count >= p->taken_before) return NULL;
    const pinch_taken_contact *before = &p->taken.items[p->taken.count];
    pinch_pair *pair = &p->pairs.items[before->pair];
    bool s = t->swapped = before->swapped;
    t->material = pair->has_material;
    bool same = pair->id[s] == t->found->g1 && pair->id[!s] == t->found->g2 && pair->body[s] == t->body[0] &&
                pair->body[!s] == t->body[1];
    return same ? pair : NULL;
}

static bool look_up(pinch_ode *p, taken *t)
{
    t->record[0] = pinch_geom_record_of(p, t->found->g1);
    t->record[1] = pinch_geom_record_of(p, t->found->g2);
    if (t->record[0] < 0 || t->record[1] < 0) return false;
    t->swapped = t->record[1] < t->record[0];
    t->material = p->geoms.items[t->record[0]].material >= 0 || p->geoms.items[t->record[1]].material >= 0;
    return true;
}

/* The pair of geoms that were looked up, with the bodies that have them now. NULL: no memory. */
static pinch_pair *looked_up(pinch_ode *p, const taken *t)
{
    bool s = t->swapped;
    int index = pinch_pair_between(p, t->record[s], t->record[!s]);
    if (index < 0) return NULL;
    pinch_pair *pair = &p->pairs.items[index];
    if (pair->body[s] != t->body[0] || pair->body[!s] != t->body[1]) p->layout = false;
    pair->body[s] = t->body[0];
    pair->body[!s] = t->body[1];
    if (pair->has_material != t->material) pinch_pair_clear(p, pair); /* by the other geom's material */
    pair->has_material = t->material;
    return pair;
}

/* What moves, but not by itself, is not at rest. */
static bool prescribed(dBodyID body, bool moves)
{
    return body && !moves && !pinch_body_stands(body);
}

static bool geoms_stay(pinch_ode *p, const pinch_pair *pair)
{
    bool first = pinch_geom_stays(p, pair->geom[0]);
    return pinch_geom_stays(p, pair->geom[1]) && first;
}

/* The pair's first contact in this step. */
static void open_pair(pinch_ode *p, pinch_pair *pair, const taken *t)
{
    pair->taken_before = pair->handed_over == p->step - 1 ? pair->taken_count : 0;
    pair->handed_over = p->step;
    pair->first_taken = -1;
    pair->taken_count = 0;
    pair->same = !prescribed(t->body[0], t->moves[0]) && !prescribed(t->body[1], t->moves[1]) &&
                 (!p->poses_count || geoms_stay(p, pair));
    for (int side = 0; side < 2; side++) /* a body that is kinematic now, or is no more */
        if (t->moves[side] != (pair->step_body[side ^ (int)t->swapped] >= 0)) p->layout = false;
}

/* The contact in the next place, which may have what it had there. */
static void record(pinch_ode *p, pinch_pair *pair, const taken *t, int joint)
{
    const dContactGeom *g = t->found;
    int place = p->taken.count++, index = (int)(pair - p->pairs.items);
    pinch_taken_contact *contact = &p->taken.items[place];
    double found[7] = {g->pos[0], g->pos[1], g->pos[2], g->normal[0], g->normal[1], g->normal[2], g->depth};
    bool same = place < p->taken_before && contact->pair == index && contact->swapped == t->swapped &&
                contact->surface == t->surface && t->same_surface && (contact->direction < 0) == (t->direction < 0) &&
                memcmp(found, contact->found, sizeof found) == 0;
    memcpy(contact->found, found, sizeof found);
    contact->pair = index;
    contact->swapped = t->swapped;
    contact->next = -1;
    contact->surface = t->surface;
    contact->direction = t->direction;
    p->directions.count += t->direction >= 0;
    contact->joint = joint;
    if (pair->first_taken < 0)
        pair->first_taken = place;
    else
        p->taken.items[pair->last_taken].next = place;
    pair->last_taken = place;
    pair->taken_count++;
    pair->same = pair->same && same;
    p->unchanged = p->unchanged && pair->same;
}

pinch_status pinch_take_contact(pinch_ode *p, const dContact *contact, dBodyID body1, dBodyID body2, int joint,
                                bool *taken_over)
{
    taken t = {.found = &contact->geom,
               .body = {body1, body2},
               .moves = {moves(p, body1), moves(p, body2)},
               .surface = -1,
               .direction = -1,
               .same_surface = true};
    pinch_surface surface;
    *taken_over = false;
    if (!well_formed(t.found) || (!t.moves[0] && !t.moves[1])) {
        p->stats.contacts_malformed++;
        return PINCH_OK;
    }
    if (!PINCH_RESERVE(p->taken, p->taken.count + 1)) return PINCH_OUT_OF_MEMORY;
    pinch_pair *pair = expected(p, &t);
    if (!pair && !look_up(p, &t)) return PINCH_OUT_OF_MEMORY;
    if (!t.material) {
        if (!in_scope(p, contact)) {
            leave_to_ode(p, contact, body1, body2, joint, &p->stats.contacts_left_by_scope);
            return PINCH_OK;
        }
        if (!surfaces_solvable(p) || !pinch_surface_of(contact, t.swapped, &surface)) {
            leave_to_ode(p, contact, body1, body2, joint, &p->stats.contacts_left_unsupported);
            return PINCH_OK;
        }
        if (!take_surface(p, contact, &surface, &t)) return PINCH_OUT_OF_MEMORY;
    }
    if (!pair) pair = looked_up(p, &t);
    if (!pair) return PINCH_OUT_OF_MEMORY;
    if (pair->handed_over != p->step) open_pair(p, pair, &t);
    record(p, pair, &t, joint);
    *taken_over = true;
    return PINCH_OK;
}
