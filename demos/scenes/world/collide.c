/* Which geoms of a world touch in this step. */
#include "world_hand.h"

#include <pinch/fingertip.h>

#include <math.h>
#include <string.h>

enum { MAX_POINTS = 16 }; /* contact points of one pair */

static bool boxes_apart(const dReal *a, const dReal *b)
{
    return a[0] > b[1] || b[0] > a[1] || a[2] > b[3] || b[2] > a[3] || a[4] > b[5] || b[4] > a[5];
}

/* Can what it meets stop this tip? It can where the tip is on a slider or under force control. */
static bool can_be_stopped(const world *w, int geom)
{
    int finger = w->categories[geom];
    return finger >= 0 && (w->fingers[finger].slider || w->fingers[finger].finger->has_normal_force);
}

/* Spheres, boxes and capsules are left to ODE's own colliders, but for boxes that rounding has it lose. */
static bool exact_in_ode(int class)
{
    return class == dSphereClass || class == dBoxClass || class == dCapsuleClass;
}

static int find_contacts(dGeomID a, dGeomID b, dContactGeom *contacts)
{
    if (exact_in_ode(dGeomGetClass(a)) && exact_in_ode(dGeomGetClass(b)))
        return pinch_tip_mend_boxes(a, b, MAX_POINTS, contacts, sizeof contacts[0],
                                    dCollide(a, b, MAX_POINTS, contacts, sizeof contacts[0]));
    return pinch_tip_collide(a, b, MAX_POINTS, contacts, sizeof contacts[0]);
}

/* An object is touched by something that is no finger. */
static void touch(world *w, dGeomID a, dGeomID b)
{
    int of_a = world_object_of(w, a), of_b = world_object_of(w, b);
    if (of_a >= 0) w->objects[of_a].touched = true;
    if (of_b >= 0) w->objects[of_b].touched = true;
}

/* Either material may be NULL, not both. */
static world_status collide_two(world *w, dGeomID a, dGeomID b, int owner, const pinch_material *of_a,
                                const pinch_material *of_b)
{
    dReal box_a[6], box_b[6];
    dGeomGetAABB(a, box_a);
    dGeomGetAABB(b, box_b);
    if (boxes_apart(box_a, box_b)) return WORLD_OK;
    if (!world_contact_room(w, w->contact_count + MAX_POINTS)) return WORLD_NO_MEMORY;
    dContactGeom geoms[MAX_POINTS];
    int count = find_contacts(a, b, geoms);
    for (int i = 0; i < count; i++) {
        world_contact *c = &w->contacts[w->contact_count++];
        memset(c, 0, sizeof *c);
        c->contact.geom = geoms[i];
        c->body[0] = dGeomGetBody(geoms[i].g1);
        c->body[1] = dGeomGetBody(geoms[i].g2);
        c->owner = owner;
        c->sharing = count;
        c->material = of_a ? of_a : of_b;
        c->other = of_a ? of_b : NULL;
        w->depth_max = fmax(w->depth_max, geoms[i].depth);
        if (world_object_of(w, a) >= 0 && world_object_of(w, b) >= 0) world_set_surface(w, c);
    }
    if (count > 0 && owner < 0) touch(w, a, b);
    return WORLD_OK;
}

/* The first object is tested against everything. Tips that can be stopped are tested against the other tips and the
 * environment, too. */
static world_status collide_fingers(world *w)
{
    world_status status = WORLD_OK;
    for (int i = 0; i < w->geom_count && status == WORLD_OK; i++)
        status = collide_two(w, w->objects[0].geom, w->geoms[i], w->categories[i], world_object_material(w, 0),
                             &w->materials[i]);
    for (int i = 0; i < w->geom_count; i++) {
        if (w->categories[i] < 0 || w->hand_geoms[i].hand) continue;
        for (int k = 0; k < w->geom_count && status == WORLD_OK; k++) {
            bool both_tips = w->categories[k] >= 0;
            if (k == i || (both_tips && k < i) || w->hand_geoms[k].hand) continue;
            if (!can_be_stopped(w, i) && !(both_tips && can_be_stopped(w, k))) continue;
            status = collide_two(w, w->geoms[i], w->geoms[k], -1, &w->materials[i], &w->materials[k]);
        }
    }
    return status;
}

/* Where neither has a material, Pinch takes the contact's own parameters, which are those of ODE's solvers. */
static world_status collide_objects(world *w)
{
    world_status status = WORLD_OK;
    for (int k = 1; k < w->object_count; k++) {
        for (int i = 0; i < w->geom_count && status == WORLD_OK; i++) {
            int first = w->categories[i];
            status = collide_two(w, w->objects[k].geom, w->geoms[i], w->hand_geoms[i].hand ? first + k : -1,
                                 world_object_material(w, k), &w->materials[i]);
        }
        for (int i = 0; i < k && status == WORLD_OK; i++) {
            const pinch_material *one = world_object_material(w, i), *other = world_object_material(w, k);
            if (!one && !other) other = &w->objects[k].material;
            status = collide_two(w, w->objects[i].geom, w->objects[k].geom, -1, one, other);
        }
    }
    return status;
}

static bool excluded(const hand *model, int a, int b)
{
    for (size_t i = 0; i < model->exclude_count; i++) {
        const int *link = model->excludes[i].link;
        if ((link[0] == a && link[1] == b) || (link[0] == b && link[1] == a)) return true;
    }
    return false;
}

/* Links of one hand: not of one body, nor of neighbours; and only where the file lets them. */
static bool may_touch_each_other(const scene_hand *h, const hand_geom *a, const hand_geom *b)
{
    const hand_body *bodies = h->model->bodies;
    if (!h->self_collision || a->body == b->body) return false;
    if (bodies[a->body].parent == b->body || bodies[b->body].parent == a->body) return false;
    return ((a->contype & b->conaffinity) || (b->contype & a->conaffinity)) && !excluded(h->model, a->link, b->link);
}

static bool may_collide(const world *w, int i, int k)
{
    const world_hand_geom *a = &w->hand_geoms[i], *b = &w->hand_geoms[k];
    dBodyID body_a = dGeomGetBody(w->geoms[i]), body_b = dGeomGetBody(w->geoms[k]);
    bool moves_a = body_a && !dBodyIsKinematic(body_a), moves_b = body_b && !dBodyIsKinematic(body_b);
    if (!moves_a && !moves_b) return false;
    return a->hand != b->hand || may_touch_each_other(&w->scene->hands[a->hand - 1], a->geom, b->geom);
}

/* Links of hands against the environment, tips, and each other. */
static world_status collide_hands(world *w)
{
    world_status status = WORLD_OK;
    for (int i = 0; i < w->geom_count && w->hand_count > 0; i++) {
        if (!w->hand_geoms[i].hand) continue;
        for (int k = 0; k < w->geom_count && status == WORLD_OK; k++) {
            if (k == i || (w->hand_geoms[k].hand && k > i) || !may_collide(w, i, k)) continue;
            status = collide_two(w, w->geoms[i], w->geoms[k], -1, &w->materials[i], &w->materials[k]);
        }
    }
    return status;
}

world_status world_collide(world *w)
{
    w->contact_count = 0;
    for (int k = 0; k < w->object_count; k++) w->objects[k].touched = false;
    world_status status = collide_fingers(w);
    if (status == WORLD_OK) status = collide_objects(w);
    return status == WORLD_OK ? collide_hands(w) : status;
}

/* Is a geom the tip of one of the scene's fingers? */
static bool is_tip(const world *w, dGeomID geom)
{
    for (size_t i = 0; i < w->scene->finger_count; i++)
        if (w->geoms[i] == geom) return true;
    return false;
}

static const char *name_of(const world *w, dGeomID geom)
{
    const scene *s = w->scene;
    int object = world_object_of(w, geom);
    if (object >= 0) return s->objects[object].name;
    for (int i = 0; i < w->geom_count; i++) {
        if (w->geoms[i] != geom) continue;
        if (w->hand_geoms[i].hand || i < (int)s->finger_count) return w->fingers[w->categories[i]].finger->name;
        return s->environment[i - (int)s->finger_count].name;
    }
    return NULL;
}

bool world_deepest_overlap(const world *w, world_overlap *deepest)
{
    *deepest = (world_overlap){.depth = 0};
    for (int i = 0; i < w->contact_count; i++) {
        const dContactGeom *g = &w->contacts[i].contact.geom;
        if (is_tip(w, g->g1) != is_tip(w, g->g2) || !(g->depth > deepest->depth)) continue;
        *deepest = (world_overlap){name_of(w, g->g1), name_of(w, g->g2), g->depth, is_tip(w, g->g1)};
    }
    return deepest->depth > 0;
}
