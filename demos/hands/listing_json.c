/* A hand as a JSON document. */

#include "listing.h"

#include "common/output.h"

#include <math.h>

/* Appends to a list; either may be NULL for want of memory, and then the list ends up as NULL. */
static void append(json_t **list, json_t *item)
{
    if (*list && item && json_array_append_new(*list, item) == 0) return;
    if (!*list) json_decref(item);
    json_decref(*list);
    *list = NULL;
}

static json_t *name_of_link(const hand *h, int link)
{
    return link < 0 ? json_null() : json_string(h->links[link].name);
}

static json_t *name_of_body(const hand *h, int body)
{
    return body < 0 ? json_null() : json_string(h->bodies[body].name);
}

static json_t *name_of_joint(const hand *h, int joint)
{
    return joint < 0 ? json_null() : json_string(h->joints[joint].name);
}

static json_t *pair(double lower, double upper)
{
    return json_numbers((double[2]){lower, upper}, 2);
}

static json_t *links(const hand *h)
{
    json_t *list = json_array();
    for (size_t i = 0; i < h->link_count; i++) {
        const hand_link *l = &h->links[i];
        append(&list, json_pack("{s:s, s:o, s:o, s:o, s:o, s:f, s:o, s:o, s:f, s:i}", "name", l->name, "parent",
                                name_of_link(h, l->parent), "body", name_of_body(h, l->body), "position",
                                json_numbers(l->pose.position, 3), "orientation", json_numbers(l->pose.orientation, 4),
                                "mass", l->mass.mass, "com", json_numbers(l->mass.centre, 3), "inertia",
                                json_numbers(l->mass.inertia, 9), "gravity_compensation", l->gravity_compensation,
                                "line", l->line));
    }
    return list;
}

static json_t *bodies(const hand *h)
{
    json_t *list = json_array();
    for (size_t i = 0; i < h->body_count; i++) {
        const hand_body *b = &h->bodies[i];
        json_t *parts = json_array();
        for (size_t k = 0; k < h->link_count; k++)
            if (h->links[k].body == (int)i) append(&parts, json_string(h->links[k].name));
        append(&list, json_pack("{s:s, s:o, s:o, s:f, s:o, s:o}", "name", b->name, "parent", name_of_body(h, b->parent),
                                "links", parts, "mass", b->mass.mass, "com", json_numbers(b->mass.centre, 3), "inertia",
                                json_numbers(b->mass.inertia, 9)));
    }
    return list;
}

static json_t *bounds(double least, double most)
{
    return isfinite(least) || isfinite(most) ? pair(least, most) : json_null();
}

static json_t *joints(const hand *h)
{
    json_t *list = json_array();
    for (size_t i = 0; i < h->joint_count; i++) {
        const hand_joint *j = &h->joints[i];
        append(&list, json_pack("{s:s, s:s, s:o, s:o, s:o, s:o, s:o, s:f, s:o, s:o, s:o, s:f, s:f, s:f, s:f, s:f, s:i}",
                                "name", j->name, "type", j->type == HAND_HINGE ? "hinge" : "slider", "parent",
                                name_of_link(h, h->links[j->link].parent), "link", name_of_link(h, j->link), "body",
                                name_of_body(h, j->body), "axis", json_numbers(j->axis, 3), "anchor",
                                json_numbers(j->anchor, 3), "reference", j->reference, "limits",
                                j->limited ? pair(j->lower, j->upper) : json_null(), "effort",
                                bounds(j->least_effort, j->effort), "velocity", json_number(j->velocity), "damping",
                                j->damping, "friction", j->friction, "armature", j->armature, "stiffness", j->stiffness,
                                "spring_reference", j->spring_reference, "line", j->line));
    }
    return list;
}

static json_t *couplings(const hand *h)
{
    json_t *list = json_array();
    for (size_t i = 0; i < h->coupling_count; i++) {
        const hand_coupling *c = &h->couplings[i];
        append(&list,
               json_pack("{s:o, s:o, s:f, s:f, s:i}", "joint", name_of_joint(h, c->joint), "of",
                         name_of_joint(h, c->of), "multiplier", c->multiplier, "offset", c->offset, "line", c->line));
    }
    return list;
}

static json_t *tendons(const hand *h)
{
    json_t *list = json_array();
    for (size_t i = 0; i < h->tendon_count; i++) {
        const hand_tendon *t = &h->tendons[i];
        json_t *parts = json_array();
        for (size_t k = 0; k < t->count; k++)
            append(&parts,
                   json_pack("{s:o, s:f}", "joint", name_of_joint(h, t->joints[k]), "coefficient", t->coefficients[k]));
        append(&list, json_pack("{s:s, s:o, s:o, s:o, s:f, s:f, s:f, s:o, s:i}", "name", t->name, "joints", parts,
                                "limits", t->limited ? pair(t->lower, t->upper) : json_null(), "effort",
                                bounds(t->least_effort, t->effort), "stiffness", t->stiffness, "damping", t->damping,
                                "friction", t->friction, "rest", json_numbers(t->rest, 2), "line", t->line));
    }
    return list;
}

static json_t *drives(const hand *h)
{
    static const char *const types[] = {"position", "velocity", "motor", "affine"};
    json_t *list = json_array();
    for (size_t i = 0; i < h->drive_count; i++) {
        const hand_drive *d = &h->drives[i];
        append(&list,
               json_pack("{s:s, s:s, s:o, s:o, s:f, s:f, s:o, s:f, s:f, s:f, s:o, s:o, s:i}", "name", d->name, "type",
                         types[d->type], "joint", name_of_joint(h, d->joint), "tendon",
                         d->tendon < 0 ? json_null() : json_string(h->tendons[d->tendon].name), "gear", d->gear, "gain",
                         d->gain, "bias", json_numbers(d->bias, 3), "kp", d->kp, "kd", d->kd, "damping_ratio",
                         d->damping_ratio, "control_range", pair(d->least_control, d->most_control), "force_range",
                         pair(d->least_force, d->most_force), "line", d->line));
    }
    return list;
}

static json_t *loops(const hand *h)
{
    json_t *list = json_array();
    for (size_t i = 0; i < h->loop_count; i++) {
        const hand_loop *l = &h->loops[i];
        append(&list, json_pack("{s:s, s:[o, o], s:[o, o], s:i}", "name", l->name, "links", name_of_link(h, l->link[0]),
                                name_of_link(h, l->link[1]), "anchors", json_numbers(l->anchor[0], 3),
                                json_numbers(l->anchor[1], 3), "line", l->line));
    }
    return list;
}

static json_t *geoms(const hand *h)
{
    static const char *const types[] = {"box", "sphere", "capsule", "cylinder", "ellipsoid", "mesh"};
    static const size_t sizes[] = {3, 1, 2, 2, 3, 0};
    json_t *list = json_array();
    for (size_t i = 0; i < h->geom_count; i++) {
        const hand_geom *g = &h->geoms[i];
        json_t *mesh = g->mesh < 0 ? json_null()
                                   : json_pack("{s:s, s:o, s:o, s:I}", "name", h->meshes[g->mesh].name, "file",
                                               json_text(h->meshes[g->mesh].file), "scale",
                                               json_numbers(h->meshes[g->mesh].scale, 3), "hull_corners",
                                               (json_int_t)h->meshes[g->mesh].hull.vertex_count);
        append(&list,
               json_pack("{s:s, s:o, s:o, s:s, s:b, s:o, s:o, s:o, s:o, s:o, s:o, s:i, s:i, s:i}", "name", g->name,
                         "link", name_of_link(h, g->link), "body", name_of_body(h, g->body), "type", types[g->type],
                         "collides", g->collides, "position", json_numbers(g->pose.position, 3), "orientation",
                         json_numbers(g->pose.orientation, 4), "size", json_numbers(g->size, sizes[g->type]), "mesh",
                         mesh, "friction", g->friction[0] < 0 ? json_null() : json_numbers(g->friction, 3), "colour",
                         g->colour[3] < 0 ? json_null() : json_numbers(g->colour, 4), "contype", (int)g->contype,
                         "conaffinity", (int)g->conaffinity, "line", g->line));
    }
    return list;
}

static json_t *remarks(const hand_remark *items, size_t count)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++)
        append(&list, json_pack("{s:s, s:I, s:i}", "what", items[i].what, "count", (json_int_t)items[i].count, "line",
                                items[i].line));
    return list;
}

static json_t *tips(const hand *h)
{
    json_t *list = json_array();
    for (size_t b = 0; b < h->body_count; b++) {
        int tip = hand_tip_of(h, b);
        if (tip >= 0) append(&list, json_string(h->links[tip].name));
    }
    return list;
}

static json_t *excludes(const hand *h)
{
    json_t *list = json_array();
    for (size_t i = 0; i < h->exclude_count; i++)
        append(&list,
               json_pack("[o, o]", name_of_link(h, h->excludes[i].link[0]), name_of_link(h, h->excludes[i].link[1])));
    return list;
}

json_t *hand_document(const hand *h)
{
    return json_pack("{s:s, s:o, s:s, s:s, s:f, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "command",
                     "hand", "file", json_text(h->file), "format", h->is_mjcf ? "mjcf" : "urdf", "name", h->name,
                     "total_mass", hand_total_mass(h), "links", links(h), "bodies", bodies(h), "joints", joints(h),
                     "couplings", couplings(h), "tendons", tendons(h), "drives", drives(h), "loops", loops(h), "geoms",
                     geoms(h), "excludes", excludes(h), "tips", tips(h), "ignored",
                     remarks(h->ignored, h->ignored_count), "unmodelled", remarks(h->unmodelled, h->unmodelled_count));
}

json_t *hand_document_poses(const hand *h, const double *positions, const hand_pose *poses)
{
    json_t *joint_list = json_object(), *list = json_array();
    for (size_t i = 0; i < h->joint_count; i++)
        if (json_object_set_new(joint_list, h->joints[i].name, json_number(positions[i]))) append(&list, NULL);
    for (size_t i = 0; i < h->link_count; i++)
        append(&list,
               json_pack("{s:s, s:o, s:o}", "link", h->links[i].name, "position", json_numbers(poses[i].position, 3),
                         "orientation", json_numbers(poses[i].orientation, 4)));
    return json_pack("{s:o, s:o}", "joints", joint_list, "links", list);
}
