#include "plugin.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool pinch_list_reserve(void **items, int *room, int count, size_t item_size)
{
    enum { FEWEST = 4, LARGE = 1 << 14 /* bytes */ };
    if (count <= *room) return true;
    /* seldom, without holding much in vain: little is soon grown over, and much is held in vain soon */
    int part = (size_t)*room * item_size < LARGE ? 4 : 16, bigger = *room + *room / part;
    if (bigger < count) bigger = count;
    if (bigger < FEWEST) bigger = FEWEST;
    void *moved = realloc(*items, (size_t)bigger * item_size);
    if (!moved) return false;
    *items = moved;
    *room = bigger;
    return true;
}

static double size_of(dGeomID geom)
{
    if (dGeomGetClass(geom) == dPlaneClass) return INFINITY;
    dReal box[6];
    double diagonal = 0;
    dGeomGetAABB(geom, box);
    for (int i = 0; i < 3; i++) diagonal = hypot(diagonal, box[2 * i + 1] - box[2 * i]);
    return diagonal;
}

int pinch_geom_record_of(pinch_ode *p, dGeomID geom)
{
    uint64_t key = pinch_key_of_pointer(geom);
    int index = pinch_item_index_get(&p->geom_index, pinch_geom_keys(p), key);
    if (index >= 0) {
        if (p->geoms.items[index].size < 0) p->geoms.items[index].size = size_of(geom);
        return index;
    }
    if (!PINCH_RESERVE(p->geoms, p->geoms.count + 1) ||
        !pinch_item_index_add(&p->geom_index, pinch_geom_keys(p), key, p->geoms.count))
        return -1;
    pinch_geom_record *record = &p->geoms.items[p->geoms.count];
    memset(record, 0, sizeof *record);
    record->geom = geom;
    record->size = size_of(geom);
    record->material = -1;
    return p->geoms.count++;
}

pinch_pose pinch_geom_pose(dGeomID geom)
{
    static const double ORIGIN[3] = {0, 0, 0}, IDENTITY[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    pinch_pose pose = {ORIGIN, IDENTITY};
    if (dGeomGetClass(geom) != dPlaneClass) {
        pose.position = dGeomGetPosition(geom);
        pose.rotation = dGeomGetRotation(geom);
    }
    return pose;
}

bool pinch_geom_stays(pinch_ode *p, int record)
{
    if (!PINCH_RESERVE(p->poses, p->geoms.count)) return false;
    for (; p->poses.count < p->geoms.count; p->poses.count++) p->poses.items[p->poses.count].step = -1;
    pinch_seen_pose *seen = &p->poses.items[record];
    if (seen->step == p->step) return seen->stays;
    pinch_pose pose = pinch_geom_pose(p->geoms.items[record].geom);
    double now[12];
    memcpy(now, pose.position, 3 * sizeof *now);
    for (int row = 0; row < 3; row++) memcpy(now + 3 + 3 * row, pose.rotation + 4 * row, 3 * sizeof *now);
    seen->stays = seen->step >= 0 && seen->step == p->step - 1 && memcmp(now, seen->pose, sizeof now) == 0;
    memcpy(seen->pose, now, sizeof now);
    seen->step = p->step;
    return seen->stays;
}

/* Two elastic tips one behind the other: compliances add. */
static double in_series(double a, double b)
{
    return a + b > 0 ? a * b / (a + b) : 0;
}

/* The normal stiffness by Hertz' law, where it applies; the tangential one in proportion. */
static void follow_depth(const pinch_ode *p, const pinch_pair *pair, double modulus, pinch_material *material)
{
    double stiffness = modulus > 0 ? pinch_hertz_stiffness(p, pair, modulus) : 0;
    if (!(stiffness > 0)) return;
    material->stiffness[1] *= stiffness / material->stiffness[0];
    material->stiffness[0] = stiffness;
}

bool pinch_pair_material(const pinch_ode *p, const pinch_pair *pair, pinch_material *material, double *share)
{
    const pinch_geom_record *a = &p->geoms.items[pair->geom[0]], *b = &p->geoms.items[pair->geom[1]];
    const pinch_material *first = pinch_geom_material(p, a), *last = pinch_geom_material(p, b);
    if (!first && !last) return false;
    *material = first ? *first : *last;
    bool as_found = pinch_place_as_found(a, b);
    *share = as_found ? 0.5 : first ? 1 : 0;
    if (!first || !last) {
        follow_depth(p, pair, material->hertz_modulus, material);
        return true;
    }
    pinch_material second = *last, *other = &second;
    double both = in_series(material->hertz_modulus, other->hertz_modulus);
    if (!(both > 0)) { /* one, or none: in series with the other's linear stiffness */
        follow_depth(p, pair, material->hertz_modulus, material);
        follow_depth(p, pair, other->hertz_modulus, other);
    }
    if (!as_found)
        *share = both > 0 ? other->hertz_modulus / (material->hertz_modulus + other->hertz_modulus)
                          : other->stiffness[0] / (material->stiffness[0] + other->stiffness[0]);
    for (int i = 0; i < 3; i++) {
        material->stiffness[i] = in_series(material->stiffness[i], other->stiffness[i]);
        material->damping[i] = in_series(material->damping[i], other->damping[i]);
    }
    follow_depth(p, pair, both, material);
    if (other->model < material->model) material->model = other->model;
    material->friction = fmin(material->friction, other->friction);
    material->friction_kinetic = fmin(material->friction_kinetic, other->friction_kinetic);
    material->torsional_friction = fmin(material->torsional_friction, other->torsional_friction);
    material->max_force = fmin(material->max_force, other->max_force);
    return true;
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
    if (!friction && m->model != PINCH_CONTACT_FRICTIONLESS) return false;
    if (!soft && friction && m->model != PINCH_CONTACT_HARD) return false;
    for (int i = 0; i < (soft ? 3 : friction ? 2 : 1); i++)
        if (!(m->stiffness[i] > 0) || !isfinite(m->stiffness[i]) || !(m->damping[i] >= 0) || !isfinite(m->damping[i]))
            return false;
    if (!(m->hertz_modulus >= 0) || !isfinite(m->hertz_modulus)) return false;
    return m->max_force > 0 && (!friction || (m->friction_kinetic >= 0 && m->friction_kinetic <= m->friction)) &&
           (!soft || (m->torsional_friction >= 0 && isfinite(m->torsional_friction)));
}

/* A place for one that no geom has; false: no memory. */
static bool free_place(pinch_ode *p, int *place)
{
    int count = p->materials.count;
    for (int i = 0; i < count && count == p->materials.room; i++) { /* before the list grows */
        *place = p->free_material++ % count;
        p->free_material %= count;
        if (p->materials.items[*place].users == 0) return true;
    }
    if (!PINCH_RESERVE(p->materials, count + 1)) return false;
    *place = p->materials.count++;
    return true;
}

/* The index of a material; those that were new last are looked through. -1: no memory. */
static int index_of(pinch_ode *p, const pinch_material *material)
{
    enum { LOOKED_THROUGH = 32 };
    int count = p->materials.count, place;
    for (int i = count - 1; i >= 0 && i >= count - LOOKED_THROUGH; i--)
        if (memcmp(&p->materials.items[i].material, material, sizeof *material) == 0) return i;
    if (!free_place(p, &place)) return -1;
    memcpy(&p->materials.items[place].material, material, sizeof *material);
    p->materials.items[place].users = 0;
    return place;
}

pinch_status pinch_ode_set_material(pinch_ode *p, dGeomID geom, const pinch_material *material)
{
    if (!p || !geom || (material && !material_legal(material))) return PINCH_INVALID_ARGUMENT;
    int known = pinch_item_index_get(&p->geom_index, pinch_geom_keys(p), pinch_key_of_pointer(geom));
    if (!material && known < 0) return PINCH_OK;
    int index = material ? pinch_geom_record_of(p, geom) : known; /* one that is forgotten may be gone: not looked at */
    if (index < 0) return PINCH_OUT_OF_MEMORY;
    pinch_geom_record *record = &p->geoms.items[index];
    const pinch_material *before = pinch_geom_material(p, record);
    if (before && material && memcmp(before, material, sizeof *material) == 0) return PINCH_OK;
    int now = material ? index_of(p, material) : -1;
    if (material && now < 0) return PINCH_OUT_OF_MEMORY;
    if (!before != !material) pinch_pairs_prune(p, index); /* another law, another history */
    pinch_expect_nothing(p);
    p->poses_count = p->poses_count || (material && material->hertz_modulus > 0); /* curvatures */
    if (record->material >= 0) p->materials.items[record->material].users--;
    if (now >= 0) p->materials.items[now].users++;
    record->material = now;
    return PINCH_OK;
}
