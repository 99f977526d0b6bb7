/*
 * Which contacts Pinch takes, and what of them is as it was in the last step.
 *
 * What comes at one place in the buffer mostly is what came there in the last step, and then needs not be looked up. As
 * long as that goes on, each contact replaces the one of the last step. Where one comes elsewhere, as ODE's spaces put
 * the geoms of bodies that move first, the rest of the last step is put aside, and each pair finds its contacts there.
 */
#include "contacts/contact_buffer.h"

#include "contacts/contact_joints.h"
#include "contacts/pairs.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* A contact that is being handed over; its pair's first geom comes first unless it is swapped. */
typedef struct incoming_contact {
    const dContact *contact;
    dGeomID geom[2]; /* NULL: not known */
    dBodyID body[2];
    bool moves[2]; /* dynamic, or driven by a force */
    int joint;     /* index of the contact joint it comes with, -1 for none */
    bool swapped;  /* see pinch_buffered_contact */
    bool material; /* a geom has a material */
    int record[2]; /* of its sides, where they had to be looked up */
    int surface;   /* see pinch_buffered_contact */
    bool directed; /* the program gave a first friction direction: */
    pinch_direction direction;
    const pinch_buffered_contact *expected; /* what the last step had in this place, of the same pair; otherwise NULL */
} incoming_contact;

static bool well_formed(const dContactGeom *g)
{
    double n2 = pinch_v3_dot(g->normal, g->normal);
    double zero = 0 * g->depth + 0 * g->pos[0] + 0 * g->pos[1] + 0 * g->pos[2]; /* unless one of them is not finite */
    return zero == 0 && fabs(n2 - 1) < 1e-3;
}

static bool moves(const pinch_drives *drives, dBodyID body)
{
    return body && (!dBodyIsKinematic(body) || (drives->count > 0 && pinch_drive_of(drives, body) >= 0));
}

/* Makes the contact a contact joint of ODE's for this step, where the program has not done so itself. */
static pinch_status leave_to_ode(const pinch_step_context *context, const incoming_contact *c, long *all, long *reason)
{
    if (c->joint < 0)
        dJointAttach(dJointCreateContact(context->world, context->joint_group, c->contact), c->body[0], c->body[1]);
    (*all)++;
    (*reason)++;
    return PINCH_OK;
}

/* Tells whether Pinch can solve contacts by surface parameters at all: not with a polygon, not without Newton's steps,
 * and not where bodies under force control, which have no mass, may belong to the island. */
static bool surfaces_solvable(const pinch_ode_settings *settings, const pinch_drives *drives)
{
    return pinch_solver_takes_newton_steps(&settings->solver) && settings->faces == 0 && drives->count == 0;
}

static bool in_scope(const pinch_ode_settings *settings, const dContact *contact)
{
    if (settings->scope == PINCH_ODE_SOFT_CONTACTS) return contact->surface.mode & dContactSoftCFM;
    return settings->scope == PINCH_ODE_ALL_CONTACTS;
}

/* ---- the last step ---- */

/* Returns the contact that the last step had in this place, as far as it has not been replaced; otherwise NULL. */
static const pinch_buffered_contact *contact_before(const pinch_contact_store *store, int place)
{
    if (place < 0 || place >= store->buffered_before) return NULL;
    if (store->behind) return &store->buffer.items[place];
    if (!store->put_aside.any) return place < store->buffer.count ? NULL : &store->buffer.items[place];
    int aside = place - store->put_aside.first;
    return aside < 0 ? NULL : &store->put_aside.contacts.items[aside];
}

/* The same for friction directions. */
static const pinch_direction *direction_before(const pinch_contact_store *store, int place)
{
    bool any_aside = store->put_aside.any || store->behind;
    int aside = place - store->put_aside.first_direction;
    if (place < store->directions.count && !any_aside) return NULL;
    if (place < 0 || place >= store->directions_before || (any_aside && aside < 0)) return NULL;
    return any_aside ? &store->put_aside.directions.items[aside] : &store->directions.items[place];
}

/* Puts aside the last step's directions in places that are not filled yet. Returns false when memory runs out. */
static bool put_directions_aside(pinch_contact_store *store)
{
    int count = store->directions_before - store->directions.count;
    store->put_aside.first_direction = store->directions.count;
    if (count <= 0) return true;
    if (!PINCH_RESERVE(store->put_aside.directions, count)) return false;
    memcpy(store->put_aside.directions.items, store->directions.items + store->directions.count,
           (size_t)count * sizeof *store->directions.items);
    return true;
}

/* Puts aside what the last step has in places that are not filled yet. Returns false when memory runs out. */
static bool put_rest_aside(pinch_contact_store *store)
{
    int contacts = store->buffered_before - store->buffer.count;
    if (store->put_aside.any || contacts <= 0) return true;
    if (!PINCH_RESERVE(store->put_aside.contacts, contacts) || !put_directions_aside(store)) return false;
    memcpy(store->put_aside.contacts.items, store->buffer.items + store->buffer.count,
           (size_t)contacts * sizeof *store->buffer.items);
    store->put_aside.contacts.count = contacts;
    store->put_aside.first = store->buffer.count;
    store->put_aside.any = true;
    return true;
}

/* Asks ahead for the pair of a contact some places after `place` in the last step, and for what a nearer one will read
 * of its pair's bodies: the pair says which bodies these are, and has to be there by then. */
static void prefetch_later(const pinch_contact_store *store, int place)
{
    enum { AHEAD = 8, PAIR_AHEAD = 16, MANY = 300 };
    if (store->buffered_before < MANY) return;
    const pinch_buffered_contact *later = contact_before(store, place + PAIR_AHEAD);
    if (later) pinch_prefetch(&store->pairs.items[later->pair], sizeof *store->pairs.items);
    later = contact_before(store, place + AHEAD);
    if (!later) return;
    const pinch_pair *pair = &store->pairs.items[later->pair];
    for (int side = 0; side < 2; side++) { /* of bodies that move by themselves, whether they do is all */
        if (!pair->body[side]) continue;
        if (pair->step_body[side] < 0)
            pinch_prefetch_body(pair->body[side]);
        else
            pinch_prefetch(pair->body[side], 2 * PINCH_CACHE_LINE);
    }
}

/* Is the contact between the pair's geoms and bodies? */
static bool is_between(const pinch_pair *pair, const incoming_contact *c)
{
    bool s = c->swapped;
    return pair->id[s] == c->geom[0] && pair->id[!s] == c->geom[1] && pair->body[s] == c->body[0] &&
           pair->body[!s] == c->body[1];
}

/* Returns the pair whose contact followed the one before in the last step, if it is between the same geoms and bodies;
 * NULL where it has to be looked up. */
static pinch_pair *expected_pair(const pinch_contact_store *store, incoming_contact *c)
{
    const pinch_buffered_contact *before = contact_before(store, store->expected);
    if (!before) return NULL;
    pinch_pair *pair = &store->pairs.items[before->pair];
    c->swapped = before->swapped;
    c->material = pair->has_material;
    if (!is_between(pair, c)) return NULL;
    c->expected = before;
    return pair;
}

/* ---- contacts ---- */

/* Finds a place for surface parameters. A program mostly gives a contact those of the one before it. Otherwise, where
 * the pair is known, it has mostly those of the contact that is expected. Sets c->surface, to -1 where Pinch has no law
 * for them. Returns false when memory runs out. */
static bool find_surface(pinch_contact_store *store, incoming_contact *c)
{
    const dSurfaceParameters *given = &c->contact->surface;
    pinch_surface surface;
    c->surface = store->last_given.surface;
    if (c->surface >= 0 && c->swapped == store->last_given.swapped &&
        pinch_surface_is_given_again(given, &store->last_given.parameters))
        return true;
    c->surface = -1;
    if (!pinch_surface_of(c->contact, c->swapped, &surface)) return true;
    c->surface = pinch_keep_surface(store, &surface, c->expected ? c->expected->surface : -1);
    memcpy(&store->last_given.parameters, given, sizeof *given);
    store->last_given.swapped = c->swapped;
    store->last_given.surface = c->surface;
    return c->surface >= 0;
}

/* Reads the first friction direction where the program gave one. Returns false when memory runs out. */
static bool find_direction(pinch_contact_store *store, incoming_contact *c)
{
    c->directed = pinch_surface_direction(c->contact, c->direction.tangent);
    return !c->directed || PINCH_RESERVE(store->directions, store->directions.count + 1);
}

/* Looks the sides up. Returns false when memory runs out. */
static bool look_up_sides(pinch_contact_store *store, incoming_contact *c)
{
    c->record[0] = pinch_add_side(store, c->geom[0], c->body[0]);
    c->record[1] = pinch_add_side(store, c->geom[1], c->body[1]);
    if (c->record[0] < 0 || c->record[1] < 0) return false;
    c->swapped = store->geoms.items[c->record[1]].number < store->geoms.items[c->record[0]].number;
    c->material = store->geoms.items[c->record[0]].material >= 0 || store->geoms.items[c->record[1]].material >= 0;
    return true;
}

/* Looks up the pair of the sides, and gives it the bodies that they have now. Returns NULL when memory runs out. */
static pinch_pair *look_up_pair(pinch_contact_store *store, const incoming_contact *c)
{
    bool s = c->swapped;
    int index = pinch_pair_between(store, c->record[s], c->record[!s]);
    if (index < 0) return NULL;
    pinch_pair *pair = &store->pairs.items[index];
    if (pair->body[s] != c->body[0] || pair->body[!s] != c->body[1]) store->same_bodies = false;
    pair->body[s] = c->body[0];
    pair->body[!s] = c->body[1];
    if (pair->has_material != c->material) pinch_clear_pair(store, pair); /* by the other geom's material */
    pair->has_material = c->material;
    return pair;
}

/* Tells whether a body moves, but not by itself: then its contacts are not at rest. */
static bool is_prescribed(dBodyID body, bool moves)
{
    return body && !moves && !pinch_body_stands(body);
}

static bool geoms_stay(pinch_contact_store *store, const pinch_pair *pair, long now)
{
    bool first = pinch_geom_stays(store, pair->geom[0], now);
    return pinch_geom_stays(store, pair->geom[1], now) && first;
}

/* Begins with the pair's first contact in this step. */
static void begin_pair(pinch_contact_store *store, pinch_pair *pair, const incoming_contact *c, long now)
{
    bool before = pair->last_step == now - 1;
    pair->buffered_before = before ? pair->buffered_count : 0;
    pair->expected = before && store->buffered_before >= 0 ? pair->first_buffered : -1;
    pair->last_step = now;
    pair->first_buffered = -1;
    pair->buffered_count = 0;
    /* what slid along beside a body at rest, and has stopped, slips no more */
    bool was_prescribed = pair->is_prescribed;
    pair->is_prescribed = is_prescribed(c->body[0], c->moves[0]) || is_prescribed(c->body[1], c->moves[1]);
    pair->unchanged =
        !pair->is_prescribed && !was_prescribed && (!store->laws_follow_poses || geoms_stay(store, pair, now));
    for (int side = 0; side < 2; side++) /* a body that has become kinematic, or dynamic */
        if (c->moves[side] != (pair->step_body[side ^ (int)c->swapped] >= 0)) store->same_bodies = false;
}

/* Tells whether the contact is the same, to the bit, as one of the pair's in the last step. */
static bool is_same(const pinch_contact_store *store, const incoming_contact *c, const double *found,
                    const pinch_buffered_contact *before)
{
    if (before->swapped != c->swapped || before->surface != c->surface || (before->direction >= 0) != c->directed ||
        memcmp(found, before->found, sizeof before->found) != 0)
        return false;
    if (!c->directed) return true;
    const pinch_direction *direction = direction_before(store, before->direction);
    return direction && memcmp(direction, &c->direction, sizeof c->direction) == 0;
}

/* Writes a contact of the pair into a place of the buffer, with its direction behind the others, for which there is
 * room, and finds out whether it is `before`, the one that the pair had in the last step. NULL: it had no more. The
 * place has to say already whose it is: where it has stayed, other threads may read that meanwhile. */
static void put(pinch_contact_store *store, pinch_pair *pair, const incoming_contact *c, int place,
                const pinch_buffered_contact *before)
{
    const dContactGeom *g = &c->contact->geom;
    pinch_buffered_contact *buffered = &store->buffer.items[place];
    double found[7] = {g->pos[0], g->pos[1], g->pos[2], g->normal[0], g->normal[1], g->normal[2], g->depth};
    pair->unchanged = pair->unchanged && before && is_same(store, c, found, before);
    if (before) {
        pair->expected = before->next;
        buffered->point = before->point;
    }
    memcpy(buffered->found, found, sizeof found);
    buffered->swapped = c->swapped;
    buffered->next = -1;
    buffered->surface = c->surface;
    buffered->direction = c->directed ? store->directions.count : -1;
    if (c->directed) store->directions.items[store->directions.count++] = c->direction;
    buffered->joint = c->joint;
    if (pair->first_buffered < 0)
        pair->first_buffered = place;
    else
        store->buffer.items[pair->last_buffered].next = place;
    pair->last_buffered = place;
    pair->buffered_count++;
}

/* Puts the contact into the next place. */
static void append(pinch_contact_store *store, pinch_pair *pair, const incoming_contact *c)
{
    int was = pair->expected;
    const pinch_buffered_contact *before =
        c->expected && was == store->expected ? c->expected : contact_before(store, was);
    store->buffer.items[store->buffer.count].pair = (int)(pair - store->pairs.items);
    put(store, pair, c, store->buffer.count++, before);
    if (before) store->expected = was + 1;
    store->unchanged = store->unchanged && pair->unchanged && !pair->watched;
}

/* Reads what a contact is between. Returns false where it is malformed. */
static bool read_sides(incoming_contact *c, const pinch_drives *drives)
{
    const dContactGeom *g = &c->contact->geom;
    bool two = g->g1 != g->g2; /* a geom does not touch itself: neither name means anything */
    c->geom[0] = two ? g->g1 : NULL;
    c->geom[1] = two ? g->g2 : NULL;
    c->moves[0] = moves(drives, c->body[0]);
    c->moves[1] = moves(drives, c->body[1]);
    c->surface = -1;
    c->directed = false;
    return well_formed(g) && c->body[0] != c->body[1] && (c->moves[0] || c->moves[1]);
}

static pinch_status buffer_contact(const pinch_contact_sink *sink, incoming_contact *c)
{
    pinch_contact_store *store = sink->store;
    const pinch_step_context *context = sink->context;
    pinch_ode_stats *stats = sink->stats;
    if (!read_sides(c, sink->drives)) {
        stats->contacts_malformed++;
        return PINCH_OK;
    }
    if (!PINCH_RESERVE(store->buffer, store->buffer.count + 1)) return PINCH_OUT_OF_MEMORY;
    prefetch_later(store, store->expected);
    pinch_pair *pair = expected_pair(store, c);
    if (!pair && (!put_rest_aside(store) || !look_up_sides(store, c))) return PINCH_OUT_OF_MEMORY;
    if (!c->material) {
        if (!in_scope(&context->settings, c->contact))
            return leave_to_ode(context, c, &stats->contacts_left, &stats->contacts_left_by_scope);
        bool solvable = surfaces_solvable(&context->settings, sink->drives);
        if (solvable && !find_surface(store, c)) return PINCH_OUT_OF_MEMORY;
        if (c->surface < 0) return leave_to_ode(context, c, &stats->contacts_left, &stats->contacts_left_unsupported);
        if (!find_direction(store, c)) return PINCH_OUT_OF_MEMORY;
    }
    if (!pair) pair = look_up_pair(store, c);
    if (!pair) return PINCH_OUT_OF_MEMORY;
    if (pair->last_step != context->number) begin_pair(store, pair, c, context->number);
    append(store, pair, c);
    return PINCH_OK;
}

pinch_status pinch_buffer_contact(const pinch_contact_sink *sink, const dContact *contact, dBodyID body1, dBodyID body2)
{
    incoming_contact c = {.contact = contact, .body = {body1, body2}, .joint = -1};
    return buffer_contact(sink, &c);
}

pinch_status pinch_buffer_contact_joint(const pinch_contact_sink *sink, const pinch_contact_joint *joint,
                                        const dContact *contact)
{
    pinch_contact_store *store = sink->store;
    int index = store->contact_joints.count, buffered = store->buffer.count;
    if (!PINCH_RESERVE(store->contact_joints, index + 1)) return PINCH_OUT_OF_MEMORY;
    store->contact_joints.items[index] = *joint;
    incoming_contact c = {.contact = contact, .body = {joint->body[0], joint->body[1]}, .joint = index};
    pinch_status status = buffer_contact(sink, &c);
    if (store->buffer.count > buffered) store->contact_joints.count++;
    return status;
}

/* ---- contacts that several threads take over ---- */

bool pinch_may_take_again(const pinch_contact_store *store)
{
    return store->buffer.count == 0 && store->buffered_before > 0 && store->contact_joints.count == 0 &&
           !store->laws_follow_poses;
}

/* Returns the pair between the geoms if its contacts are the next of these places of the last step, or are behind those
 * of a few pairs that have parted since. *places then begins with its contacts. */
static pinch_pair *find_pair(const pinch_contact_store *store, long now, const dContactGeom *geom, pinch_range *places)
{
    enum { PARTED = 8 };
    pinch_range left = *places;
    for (int k = 0; k <= PARTED && left.count > 0; k++) {
        pinch_pair *pair = &store->pairs.items[store->buffer.items[left.first].pair];
        int count = pair->buffered_count;
        if (pair->last_step != now - 1 || pair->first_buffered != left.first || count > left.count) return NULL;
        bool swapped = pair->id[1] == geom->g1;
        if (pair->id[swapped] == geom->g1 && pair->id[!swapped] == geom->g2) {
            *places = left;
            return pair;
        }
        left = (pinch_range){left.first + count, left.count - count};
    }
    return NULL;
}

/* Tells whether the pair's contacts in the last step followed each other. */
static bool follow_each_other(const pinch_pair *pair)
{
    return pair->last_buffered - pair->first_buffered == pair->buffered_count - 1;
}

/* Tells whether a contact has the surface of the one before, which its pair had. */
static bool has_surface(const pinch_contact_store *store, const incoming_contact *c, int surface)
{
    const dSurfaceParameters *given = &c->contact->surface;
    pinch_surface own;
    if (surface < 0 || (given->mode & dContactFDir1)) return false;
    if (surface == store->last_given.surface && c->swapped == store->last_given.swapped &&
        pinch_surface_is_given_again(given, &store->last_given.parameters))
        return true;
    return pinch_surface_of(c->contact, c->swapped, &own) && pinch_is_kept_surface(store, surface, &own);
}

/* A contact of a pair in the place of `before`, which the pair had in the last step. */
static incoming_contact come_again(const dContact *contact, const dBodyID body[2], const pinch_buffered_contact *before)
{
    return (incoming_contact){.contact = contact, .body = {body[0], body[1]}, .joint = -1, .swapped = before->swapped};
}

/* Tells whether it may be taken as it comes. Reads what it is between. */
static bool comes_again(const pinch_contact_sink *sink, const pinch_pair *pair, incoming_contact *c, int surface)
{
    if (!read_sides(c, sink->drives) || !is_between(pair, c)) return false;
    for (int side = 0; side < 2; side++)
        if (c->moves[side] != (pair->step_body[side ^ (int)c->swapped] >= 0)) return false;
    return pair->has_material ||
           (in_scope(&sink->context->settings, c->contact) && has_surface(sink->store, c, surface));
}

/* Takes so many contacts into the places that the pair's had in the last step, if they may be taken as they come. */
static pinch_taken take_again(const pinch_contact_sink *sink, pinch_pair *pair, const dGeomID geom[2],
                              const dContact *contacts, int count)
{
    pinch_contact_store *store = sink->store;
    int first = pair->first_buffered;
    const pinch_buffered_contact *before = &store->buffer.items[first];
    const dBodyID body[2] = {dGeomGetBody(geom[0]), dGeomGetBody(geom[1])};
    for (int i = count - 1; i > 0; i--) {
        incoming_contact c = come_again(&contacts[i], body, &before[i]);
        if (!comes_again(sink, pair, &c, before[i].surface)) return PINCH_NOT_TAKEN;
    }
    incoming_contact c = come_again(contacts, body, before);
    if (!comes_again(sink, pair, &c, before->surface)) return PINCH_NOT_TAKEN;
    begin_pair(store, pair, &c, sink->context->number);
    for (int i = 0; i < count; i++) {
        c.contact = &contacts[i];
        c.swapped = before[i].swapped;
        c.surface = before[i].surface;
        put(store, pair, &c, first + i, &before[i]);
    }
    return pair->unchanged && !pair->watched ? PINCH_TAKEN_UNCHANGED : PINCH_TAKEN;
}

pinch_taken pinch_take_again(const pinch_contact_sink *sink, const dGeomID geom[2], const dContact *contacts, int count,
                             pinch_range *places)
{
    pinch_contact_store *store = sink->store;
    if (places->count == 0 || places->first + places->count > store->buffered_before) return PINCH_NOT_TAKEN;
    prefetch_later(store, places->first);
    pinch_pair *pair = find_pair(store, sink->context->number, &contacts->geom, places);
    if (!pair) return PINCH_NOT_TAKEN;
    int had = pair->buffered_count;
    bool solvable = pair->has_material || surfaces_solvable(&sink->context->settings, sink->drives);
    pinch_taken taken = had == count && follow_each_other(pair) && solvable
                            ? take_again(sink, pair, geom, contacts, count)
                            : PINCH_NOT_TAKEN;
    *places = (pinch_range){places->first + had, places->count - had};
    return taken;
}

void pinch_taken_again(pinch_contact_store *store, int count, bool unchanged)
{
    store->buffer.count = store->expected = count;
    store->all_pairs_came = count == store->buffered_before;
    store->unchanged = store->unchanged && unchanged;
}

bool pinch_begin_behind(pinch_contact_store *store)
{
    if (!put_directions_aside(store)) return false;
    store->behind = true;
    store->buffer.count = store->buffered_before;
    store->expected = -1; /* what comes there belongs to pairs that were taken, or have to be looked up anyway */
    return true;
}

bool pinch_begin_moving(pinch_contact_store *store, int count)
{
    store->chains_cross = false;
    return PINCH_RESERVE(store->put_aside.contacts, count);
}

void pinch_move_contacts(pinch_contact_store *store, pinch_range places, int to)
{
    const pinch_buffered_contact *from = &store->buffer.items[places.first];
    pinch_buffered_contact *moved = &store->put_aside.contacts.items[to];
    pinch_pair *pair = &store->pairs.items[from->pair];
    memcpy(moved, from, (size_t)places.count * sizeof *from);
    if (pair->first_buffered != places.first || pair->buffered_count != places.count || !follow_each_other(pair)) {
        atomic_store(&store->chains_cross, true);
        return;
    }
    for (int i = 0; i < places.count - 1; i++) moved[i].next = to + i + 1;
    pair->first_buffered = to;
    pair->last_buffered = to + places.count - 1;
}

void pinch_chain_contacts(pinch_contact_store *store, int count)
{
    for (int i = 0; i < count; i++) {
        store->pairs.items[store->buffer.items[i].pair].first_buffered = -1;
        store->buffer.items[i].next = -1;
    }
    for (int i = 0; i < count; i++) {
        pinch_pair *pair = &store->pairs.items[store->buffer.items[i].pair];
        if (pair->first_buffered < 0)
            pair->first_buffered = i;
        else
            store->buffer.items[pair->last_buffered].next = i;
        pair->last_buffered = i;
    }
}

void pinch_end_moving(pinch_contact_store *store, int count, bool unchanged)
{
    const pinch_buffered_list before = store->buffer;
    store->buffer = store->put_aside.contacts;
    store->put_aside.contacts = before;
    store->put_aside.contacts.count = store->buffered_before;
    store->put_aside.first = 0;
    store->put_aside.any = true;
    store->behind = false;
    pinch_taken_again(store, count, unchanged);
    store->all_pairs_came = false;
    if (atomic_load(&store->chains_cross)) pinch_chain_contacts(store, count);
}

void pinch_abandon_taken(pinch_contact_store *store)
{
    store->behind = false;
    store->buffer.count = store->directions.count = 0;
    for (int i = 0; i < store->pairs.count; i++) store->pairs.items[i].last_step = -1;
    pinch_invalidate_step_cache(store);
}

/* ---- the end of a step ---- */

static void clear_buffer(pinch_contact_store *store)
{
    pinch_enable_contact_joints(store);
    store->contact_joints.count = store->buffer.count = store->directions.count = 0;
    store->put_aside.any = false;
    store->put_aside.contacts.count = store->expected = 0;
    store->all_pairs_came = false;
}

void pinch_finish_contacts(pinch_contact_store *store)
{
    clear_buffer(store);
    store->same_places = store->same_bodies = store->unchanged = true;
}

void pinch_abandon_contacts(pinch_contact_store *store)
{
    clear_buffer(store);
    for (int i = 0; i < store->pairs.count; i++) store->pairs.items[i].last_step = -1;
    pinch_invalidate_step_cache(store);
}
