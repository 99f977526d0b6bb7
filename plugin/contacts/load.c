/* What the contacts of one geom exert together. */
#include "contacts/contact_store.h"
#include "contacts/pairs.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* The sums that states and margins are made of. */
typedef struct load_sums {
    int slipping, yielding;
    double weighted[3];                   /* normal force times position */
    double tangential[3], torsion;        /* of one pair */
    double friction_limit, torsion_limit; /* of one pair */
} load_sums;

/* The unused part of a friction limit; NaN where there is no friction. A moment that has no limit of its own cannot be
 * there. */
static double margin_of(double tangential, double limit, double torsion, double torsion_limit)
{
    if (!(limit > 0)) return NAN;
    return 1 - hypot(tangential / limit, torsion_limit > 0 ? torsion / torsion_limit : 0);
}

/* Friction whose limit is a force of its own acts on points that do not press, too.
 * fmin passes over NaN, which is what a margin that does not exist is. */
static void add_point(const pinch_ode_contact *c, double sign, const double centre[3], load_sums *sums,
                      pinch_ode_load *load)
{
    double arm[3], turned[3];
    pinch_v3_sub(c->position, centre, arm);
    pinch_v3_cross(arm, c->force, turned);
    pinch_v3_add_scaled(load->force, sign, c->force);
    pinch_v3_add_scaled(load->normal, sign * c->normal_force, c->normal);
    pinch_v3_add_scaled(load->tangential, sign, c->tangential);
    pinch_v3_add_scaled(load->moment, sign, turned);
    pinch_v3_add_scaled(load->moment, sign * c->torsion, c->normal);
    pinch_v3_add_scaled(load->moment, sign, c->rolling_moment);
    load->normal_force += c->normal_force;
    load->torsion += c->torsion; /* the same about the normal into either body */
    load->least_margin = fmin(load->least_margin,
                              margin_of(pinch_v3_norm(c->tangential), c->friction_limit, c->torsion, c->torsion_limit));
    pinch_v3_add_scaled(sums->weighted, c->normal_force, c->position);
    pinch_v3_add_scaled(sums->tangential, sign, c->tangential);
    sums->torsion += c->torsion;
    sums->friction_limit += c->friction_limit;
    sums->torsion_limit += c->torsion_limit;
    if (!(c->normal_force > 0)) return;
    load->points++;
    sums->slipping += c->state == PINCH_CONTACT_SLIP;
    sums->yielding += c->state == PINCH_CONTACT_YIELD;
}

static void add_pair(const pinch_contact_store *store, const pinch_pair *pair, double sign, const double centre[3],
                     load_sums *sums, pinch_ode_load *load)
{
    memset(sums->tangential, 0, sizeof sums->tangential);
    sums->torsion = sums->friction_limit = sums->torsion_limit = 0;
    for (int k = 0; k < pair->manifold.count; k++)
        add_point(&store->results.items[pair->first_result + k], sign, centre, sums, load);
    load->slip_margin = fmin(load->slip_margin, margin_of(pinch_v3_norm(sums->tangential), sums->friction_limit,
                                                          sums->torsion, sums->torsion_limit));
    load->slip_total = fmax(load->slip_total, pair->slip_total);
    load->twist_total = fmax(load->twist_total, pair->twist_total);
}

pinch_status pinch_sum_load(const pinch_contact_store *store, dGeomID geom, dGeomID partner, const double *about,
                            pinch_ode_load *load)
{
    static const double origin[3] = {0, 0, 0};
    dBodyID body = dGeomGetBody(geom);
    const double *centre = about ? about : body ? dBodyGetPosition(body) : origin;
    if (!isfinite(centre[0]) || !isfinite(centre[1]) || !isfinite(centre[2])) return PINCH_INVALID_ARGUMENT;
    load_sums sums;
    memset(&sums, 0, sizeof sums);
    *load = (pinch_ode_load){.slip_margin = NAN, .least_margin = NAN};
    for (int i = 0; i < store->pairs.count; i++) {
        const pinch_pair *pair = &store->pairs.items[i];
        int side = pair->id[0] == geom ? 0 : 1;
        bool meant = pair->id[side] == geom && (!partner || pair->id[1 - side] == partner);
        /* a pair that came after the step has no results yet */
        if (!meant || pair->first_result + pair->manifold.count > store->results.count) continue;
        if (pinch_pair_is_forgotten(store, pair)) continue;
        add_pair(store, pair, side ? -1 : 1, centre, &sums, load);
    }
    if (load->points == 0) return PINCH_OK;
    load->state = sums.yielding == load->points   ? PINCH_CONTACT_YIELD
                  : sums.slipping == load->points ? PINCH_CONTACT_SLIP
                                                  : PINCH_CONTACT_STICK;
    for (int i = 0; i < 3; i++) load->position[i] = sums.weighted[i] / load->normal_force;
    return PINCH_OK;
}
