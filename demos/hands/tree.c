/* From links to bodies: what no joint moves becomes one, its masses are added, and what moves must
 * have a mass. */

#include "formats.h"
#include "inertia.h"

#include <stdlib.h>

static void make_bodies(hand_reader *r)
{
    hand *h = r->h;
    size_t next = 0;
    hand_body *base = reader_append(r, &h->bodies, &h->body_count, sizeof *base);
    if (base) *base = (hand_body){.name = NULL, .parent = -1, .link = -1};
    for (size_t i = 0; i < h->link_count && r->status == HAND_OK; i++) {
        hand_link *link = &h->links[i];
        const hand_link *parent = link->parent < 0 ? NULL : &h->links[link->parent];
        bool moves = next < h->joint_count && h->joints[next].link == (int)i;
        if (moves) {
            hand_body *body = reader_append(r, &h->bodies, &h->body_count, sizeof *body);
            if (!body) return;
            link->body = (int)h->body_count - 1;
            link->in_body = pose_identity();
            *body = (hand_body){.name = link->name, .parent = parent ? parent->body : 0, .link = (int)i};
        } else {
            link->body = parent ? parent->body : 0;
            link->in_body = parent ? pose_product(&parent->in_body, &link->pose) : link->pose;
            if (link->body == 0 && h->bodies[0].link < 0) {
                h->bodies[0].link = (int)i;
                h->bodies[0].name = link->name;
            }
        }
        for (; next < h->joint_count && h->joints[next].link == (int)i; next++) h->joints[next].body = link->body;
    }
    if (r->status == HAND_OK && !h->bodies[0].name) h->bodies[0].name = reader_text(r, "base");
}

static void add_masses(hand_reader *r)
{
    hand *h = r->h;
    for (size_t i = 0; i < h->link_count && r->status == HAND_OK; i++) {
        const hand_link *link = &h->links[i];
        hand_mass moved;
        if (!(link->mass.mass > 0)) continue;
        mass_in_outer(&link->in_body, &link->mass, &moved);
        mass_add(&h->bodies[link->body].mass, &moved);
        moved.mass *= link->gravity_compensation;
        mass_add(&h->bodies[link->body].relieved, &moved);
    }
}

/* A body that moves has mass, or others with mass move with it: then it is a link of a joint with several axes, and the
 * hand has a motion for any forces. */
static void check_masses(hand_reader *r)
{
    hand *h = r->h;
    double *carried = calloc(h->body_count, sizeof *carried);
    if (!carried) reader_no_memory(r);
    for (size_t b = h->body_count; b-- > 1 && r->status == HAND_OK;) {
        const hand_mass *mass = &h->bodies[b].mass;
        const hand_link *link = &h->links[h->bodies[b].link];
        double values[3], axes[9];
        inertia_principal(mass->inertia, values, axes);
        carried[b] += mass->mass;
        carried[h->bodies[b].parent] += carried[b];
        if (!(carried[b] > 0))
            reader_refuse_link(r, link, "expected a mass: a joint moves it, and nothing that moves with it has one");
        else if (!(mass->mass > 0))
            reader_unmodelled_link(r, link, "link without mass between joints");
        else if (!(values[2] > 0))
            reader_refuse_link(r, link, "expected positive moments of inertia: a joint moves it");
    }
    free(carried);
}

static void place_geoms(hand *h)
{
    for (size_t i = 0; i < h->geom_count; i++) {
        hand_geom *geom = &h->geoms[i];
        geom->body = geom->link < 0 ? 0 : h->links[geom->link].body;
        if (geom->link >= 0) geom->pose = pose_product(&h->links[geom->link].in_body, &geom->pose);
    }
}

static bool can_turn(const hand_coupling *c)
{
    return c->of >= 0 && isfinite(1 / c->multiplier) && isfinite(c->offset / c->multiplier);
}

/* Turns the couplings on the way from the joint upwards round, so that the joint follows none. False where one of them
 * cannot be turned, because the joint above has no influence. */
static bool make_root(hand *h, int joint)
{
    for (int at = h->joints[joint].coupling; at >= 0;) {
        const hand_coupling *c = &h->couplings[at];
        if (!can_turn(c)) return false;
        at = h->joints[c->of].coupling;
    }
    int at = h->joints[joint].coupling;
    h->joints[joint].coupling = -1;
    while (at >= 0) {
        hand_coupling *c = &h->couplings[at];
        int joint_of = c->of, next = h->joints[c->of].coupling;
        h->joints[joint_of].coupling = at;
        c->of = c->joint;
        c->joint = joint_of;
        c->offset = -c->offset / c->multiplier;
        c->multiplier = 1 / c->multiplier;
        at = next;
    }
    return true;
}

static int root_of(const hand *h, int joint)
{
    while (joint >= 0 && h->joints[joint].coupling >= 0) {
        int of = h->couplings[h->joints[joint].coupling].of;
        if (of < 0) break;
        joint = of;
    }
    return joint;
}

/* Couplings between joints are a forest: each joint follows at most one. Where it would follow two, the couplings of
 * one tree are turned round, which changes nothing but their form. */
void tree_couple(hand_reader *r, const xmlNode *at, const hand_coupling *coupling)
{
    hand *h = r->h;
    if (r->status != HAND_OK) return;
    hand_coupling own = *coupling;
    if (own.of >= 0 && root_of(h, own.joint) == root_of(h, own.of)) {
        reader_refuse(r, at, "expected a coupling to another joint, but joint \"%.100s\" would follow itself",
                      h->joints[own.joint].name);
        return;
    }
    bool free_to_follow = make_root(h, own.joint);
    if (!free_to_follow && can_turn(&own) && make_root(h, own.of)) {
        own = (hand_coupling){.joint = coupling->of,
                              .of = coupling->joint,
                              .multiplier = 1 / coupling->multiplier,
                              .offset = -coupling->offset / coupling->multiplier,
                              .line = coupling->line};
        free_to_follow = true;
    }
    if (!free_to_follow) {
        reader_refuse(r, at, "expected couplings that leave joint \"%.100s\" one position, but line %d has another",
                      h->joints[own.joint].name, h->couplings[h->joints[own.joint].coupling].line);
        return;
    }
    hand_coupling *item = reader_append(r, &h->couplings, &h->coupling_count, sizeof *item);
    if (!item) return;
    *item = own;
    h->joints[own.joint].coupling = (int)h->coupling_count - 1;
}

void tree_complete(hand_reader *r)
{
    if (r->status == HAND_OK && r->h->link_count == 0) reader_refuse(r, NULL, "expected at least one link or body");
    if (r->status == HAND_OK) make_bodies(r);
    if (r->status == HAND_OK) add_masses(r);
    if (r->status == HAND_OK) check_masses(r);
    if (r->status == HAND_OK) place_geoms(r->h);
}
