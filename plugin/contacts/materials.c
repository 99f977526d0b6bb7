#include "contacts/materials.h"

#include "contacts/collider_points.h"
#include "contacts/pairs.h"

#include "support/vec3.h"

#include <pinch/fingertip.h>

#include <math.h>
#include <string.h>

/*
 * Hertz' law for a fingertip: two smooth bodies of effective modulus E* and relative radius of curvature R press on
 * each other with F = 4/3 E* sqrt(R) delta^(3/2) (Johnson, Contact Mechanics, 1985, eq. 4.23 and 4.26; for unequal
 * principal radii R = sqrt(R' R''), whose error is below 3 % up to R'/R'' = 5).
 *
 * The law of a step is linear, r_n = kn (delta - h w_n) - cn w_n. kn is the secant F/delta at the depth the step starts
 * from: the law holds unchanged within the step, a body at rest carries exactly Hertz' force, and the secant never
 * pulls. (With the tangent 2 E* sqrt(R delta) delta itself would have to be replaced by 2/3 delta for that.)
 */
/* Below this part of R the depth counts as this much: a stiffness must be positive. */
static const double LEAST_DEPTH = 1e-6;

/* Adds a surface's curvature, where its outward normal is `normal`, in the tangent frame; false: an edge or corner, or
 * a shape whose curvature is not known. */
static bool add_curvature(dGeomID geom, const double *normal, const double *t1, const double *t2, double K[3])
{
    double k[2], u[3];
    if (!geom || pinch_tip_curvature(geom, normal, k, u) != PINCH_OK || !isfinite(k[0]) || !isfinite(k[1]))
        return false;
    double c = pinch_v3_dot(u, t1), s = pinch_v3_dot(u, t2);
    K[0] += k[0] * c * c + k[1] * s * s;
    K[1] += (k[0] - k[1]) * c * s;
    K[2] += k[0] * s * s + k[1] * c * c;
    return true;
}

/*
 * Returns the depth of a Hertzian tip with F = hardness depth^(3/2) that is in series with a spring: of s = sqrt(depth)
 * the root of hardness s^3 + spring s^2 = spring all, where both bear the same force. Newton's steps come down to it
 * from above, as the left side is convex.
 */
static double depth_in_series(double hardness, double spring, double all)
{
    double s = sqrt(all);
    for (int i = 0; i < 60; i++) {
        double step = (hardness * s * s * s + spring * (s * s - all)) / (s * (3 * hardness * s + 2 * spring));
        if (!(step > 0) || s - step == s) break;
        s -= step;
    }
    return s * s;
}

/* Returns the secant stiffness of a pair's Hertzian part at its depth, N/m, which is in series with a spring (N/m; 0:
 * it is alone); 0 where Hertz' law does not apply. */
static double hertz_stiffness(const pinch_pair *pair, double modulus, double spring)
{
    const pinch_manifold_point *deepest = pair->manifold.point;
    double K[3] = {0, 0, 0}, t1[3], t2[3], back[3];
    if (pair->manifold.count == 0) return 0;
    for (int k = 1; k < pair->manifold.count; k++)
        if (pair->manifold.point[k].depth > deepest->depth) deepest = &pair->manifold.point[k];
    const double *n = deepest->normal; /* into geom[0] */
    for (int i = 0; i < 3; i++) back[i] = -n[i];
    pinch_v3_any_perpendicular(n, t1);
    pinch_v3_cross(n, t1, t2);
    if (!add_curvature(pair->id[0], back, t1, t2, K) || !add_curvature(pair->id[1], n, t1, t2, K)) return 0;
    double det = K[0] * K[2] - K[1] * K[1], trace = K[0] + K[2];
    if (!(det > 1e-9 * trace * trace)) return 0;                      /* along a line, or flat: no point contact */
    double R = 1 / sqrt(det), hardness = 4.0 / 3 * modulus * sqrt(R); /* det K = 1/(R' R'') = 1/R^2 */
    double depth = fmax(deepest->depth, LEAST_DEPTH * R);
    return hardness * sqrt(spring > 0 ? depth_in_series(hardness, spring, depth) : depth);
}

/* Returns the stiffness of two elastic tips one behind the other, whose compliances add. */
static double in_series(double a, double b)
{
    return a + b > 0 ? a * b / (a + b) : 0;
}

/* Replaces the normal stiffness by that of Hertz' law, where it applies; the tangential one keeps its ratio to it. */
static void follow_depth(const pinch_pair *pair, double modulus, double spring, pinch_material *material)
{
    double stiffness = modulus > 0 ? hertz_stiffness(pair, modulus, spring) : 0;
    if (!(stiffness > 0)) return;
    material->stiffness[1] *= stiffness / material->stiffness[0];
    material->stiffness[0] = stiffness;
}

/* A patch resists turning about the normal if either side is soft; a side that is not says nothing about turning. */
static void combine_torsion(pinch_material *material, const pinch_material *other)
{
    bool soft = material->model == PINCH_CONTACT_SOFT, other_soft = other->model == PINCH_CONTACT_SOFT;
    if (soft && other_soft) {
        material->stiffness[2] = in_series(material->stiffness[2], other->stiffness[2]);
        material->damping[2] = in_series(material->damping[2], other->damping[2]);
        material->torsional_friction = fmin(material->torsional_friction, other->torsional_friction);
    } else if (other_soft) {
        material->stiffness[2] = other->stiffness[2];
        material->damping[2] = other->damping[2];
        material->torsional_friction = other->torsional_friction;
    }
    bool frictionless = material->model == PINCH_CONTACT_FRICTIONLESS || other->model == PINCH_CONTACT_FRICTIONLESS;
    if (frictionless)
        material->model = PINCH_CONTACT_FRICTIONLESS;
    else if (other_soft)
        material->model = PINCH_CONTACT_SOFT;
}

const pinch_material *pinch_pair_material(const pinch_contact_store *store, const pinch_pair *pair, pinch_material *own,
                                          double *share)
{
    const pinch_material *first = pinch_geom_material(store, pair->geom[0]);
    const pinch_material *last = pinch_geom_material(store, pair->geom[1]);
    if (!first && !last) return NULL;
    bool half_way = pinch_both_faceted(pair->id[0], pair->id[1]);
    *share = half_way ? 0.5 : first ? 1 : 0;
    if (!first || !last) {
        const pinch_material *only = first ? first : last;
        if (only->hertz_modulus == 0) return only;
        *own = *only;
        follow_depth(pair, own->hertz_modulus, 0, own);
        return own;
    }
    *own = *first;
    pinch_material second = *last, *material = own, *other = &second;
    double both = in_series(material->hertz_modulus, other->hertz_modulus);
    if (!(both > 0)) { /* one, or none: in series with the other's linear stiffness */
        double spring = other->stiffness[0];
        follow_depth(pair, other->hertz_modulus, material->stiffness[0], other);
        follow_depth(pair, material->hertz_modulus, spring, material);
    }
    if (!half_way)
        *share = both > 0 ? other->hertz_modulus / (material->hertz_modulus + other->hertz_modulus)
                          : other->stiffness[0] / (material->stiffness[0] + other->stiffness[0]);
    for (int i = 0; i < 2; i++) {
        material->stiffness[i] = in_series(material->stiffness[i], other->stiffness[i]);
        material->damping[i] = in_series(material->damping[i], other->damping[i]);
    }
    follow_depth(pair, both, 0, material);
    combine_torsion(material, other);
    material->friction = fmin(material->friction, other->friction);
    material->friction_kinetic = fmin(material->friction_kinetic, other->friction_kinetic);
    material->max_force = fmin(material->max_force, other->max_force);
    return material;
}

double pinch_pair_hertz_part(const pinch_contact_store *store, const pinch_pair *pair)
{
    const pinch_material *first = pinch_geom_material(store, pair->geom[0]);
    const pinch_material *last = pinch_geom_material(store, pair->geom[1]);
    double modulus[2] = {first ? first->hertz_modulus : 0, last ? last->hertz_modulus : 0};
    if (!(modulus[0] > 0) && !(modulus[1] > 0)) return 0;
    bool both = modulus[0] > 0 && modulus[1] > 0;
    double spring = both || !first || !last ? 0 : modulus[0] > 0 ? last->stiffness[0] : first->stiffness[0];
    double hertz =
        hertz_stiffness(pair, both ? in_series(modulus[0], modulus[1]) : fmax(modulus[0], modulus[1]), spring);
    if (!(hertz > 0)) return 0;
    return spring > 0 ? spring / (hertz + spring) : 1;
}

pinch_material pinch_default_material(void)
{
    pinch_material material = {
        .model = PINCH_CONTACT_HARD,
        .stiffness = {2e4, 1.33e4, 1},
        .damping = {20, 13.3, 1e-3},
        .friction = 0.5,
        .friction_kinetic = 0.5,
        .torsional_friction = 1e-3,
        .max_force = INFINITY,
    };
    return material;
}

static bool material_legal(const pinch_material *m)
{
    bool friction = m->model != PINCH_CONTACT_FRICTIONLESS, soft = m->model == PINCH_CONTACT_SOFT;
    if (!soft && friction && m->model != PINCH_CONTACT_HARD) return false;
    for (int i = 0; i < (soft ? 3 : friction ? 2 : 1); i++)
        if (!(m->stiffness[i] > 0) || !isfinite(m->stiffness[i]) || !(m->damping[i] >= 0) || !isfinite(m->damping[i]))
            return false;
    if (!(m->hertz_modulus >= 0) || !isfinite(m->hertz_modulus)) return false;
    for (int i = 0; i < 3; i++)
        if (!isfinite(m->facet_axis[i])) return false;
    return m->max_force > 0 && (!friction || (m->friction_kinetic >= 0 && m->friction_kinetic <= m->friction)) &&
           (!soft || (m->torsional_friction >= 0 && isfinite(m->torsional_friction)));
}

/* Finds a place for a material that no geom has. Returns false when memory runs out. */
static bool free_place(pinch_contact_store *store, int *place)
{
    int count = store->materials.count;
    for (int i = 0; i < count && count == store->materials.room; i++) { /* before the list grows */
        *place = store->free_material++ % count;
        store->free_material %= count;
        if (store->materials.items[*place].users == 0) return true;
    }
    if (!PINCH_RESERVE(store->materials, count + 1)) return false;
    *place = store->materials.count++;
    return true;
}

/* What lies between the model and the numbers behind it has no meaning. */
static bool is_same(const pinch_material *a, const pinch_material *b)
{
    size_t first = offsetof(pinch_material, stiffness);
    return a->model == b->model && memcmp((const char *)a + first, (const char *)b + first, sizeof *a - first) == 0;
}

/* Returns the index of a material, where the newest ones are looked through for it; -1 when memory runs out. */
static int index_of(pinch_contact_store *store, const pinch_material *material)
{
    enum { LOOKED_THROUGH = 32 };
    int count = store->materials.count, place;
    for (int i = count - 1; i >= 0 && i >= count - LOOKED_THROUGH; i--)
        if (is_same(&store->materials.items[i].material, material)) return i;
    if (!free_place(store, &place)) return -1;
    memcpy(&store->materials.items[place].material, material, sizeof *material);
    store->materials.items[place].users = 0;
    return place;
}

pinch_status pinch_set_material(pinch_contact_store *store, dGeomID geom, const pinch_material *material)
{
    if (material && !material_legal(material)) return PINCH_INVALID_ARGUMENT;
    int known = pinch_find_geom(store, geom);
    if (!material && known < 0) return PINCH_OK;
    int index =
        material ? pinch_add_side(store, geom, NULL) : known; /* a geom that loses its material may be destroyed */
    if (index < 0) return PINCH_OUT_OF_MEMORY;
    const pinch_material *before = pinch_geom_material(store, index);
    if (before && material && is_same(before, material)) return PINCH_OK;
    int now = material ? index_of(store, material) : -1;
    if (material && now < 0) return PINCH_OUT_OF_MEMORY;
    if (!before != !material) pinch_forget_pairs_of(store, index); /* another law has another history */
    pinch_invalidate_step_cache(store);
    if (material && material->hertz_modulus > 0) store->laws_follow_poses = true; /* curvatures depend on the pose */
    int *place = &store->geoms.items[index].material;
    if (*place >= 0) store->materials.items[*place].users--;
    if (now >= 0) store->materials.items[now].users++;
    *place = now;
    return PINCH_OK;
}
