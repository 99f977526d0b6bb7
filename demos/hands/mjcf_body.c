/* Bodies, frames and joints. */

#include "inertia.h"
#include "mjcf.h"

static const char joint_attributes[] =
    "name class type group pos axis springdamper limited actuatorfrclimited solreflimit "
    "solimplimit solreffriction solimpfriction stiffness range actuatorfrcrange "
    "actuatorgravcomp margin ref springref armature damping frictionloss user";

/* A number of which MJCF takes more: a polynomial in the speed or the way. Only its first coefficient is done here. */
static double first_coefficient(const mjcf_element *e, const char *name)
{
    double v[3] = {0};
    mjcf_numbers(e, name, v, 1, 3);
    if (v[1] != 0 || v[2] != 0) reader_refuse(e->m->r, e->node, "%s with more than one number is not supported", name);
    if (v[0] < 0) reader_refuse(e->m->r, e->node, "expected a %s that is not negative", name);
    return v[0];
}

static void read_joint_limits(const mjcf_element *e, hand_joint *joint)
{
    double range[2] = {0}, effort[2] = {0};
    double part = e->m->compiler.degrees && joint->type == HAND_HINGE ? SCENE_PI / 180 : 1;
    bool has_range = mjcf_numbers(e, "range", range, 2, 2) > 0, has_effort;
    joint->limited = mjcf_is_limited(e, "limited", has_range, range);
    joint->lower = joint->limited ? part * range[0] : -INFINITY;
    joint->upper = joint->limited ? part * range[1] : INFINITY;
    has_effort = mjcf_numbers(e, "actuatorfrcrange", effort, 2, 2) > 0;
    bool bounded = mjcf_is_limited(e, "actuatorfrclimited", has_effort, effort);
    joint->least_effort = bounded ? effort[0] : -INFINITY;
    joint->effort = bounded ? effort[1] : INFINITY;
    mjcf_numbers(e, "ref", &joint->reference, 1, 1);
    mjcf_numbers(e, "springref", &joint->spring_reference, 1, 1);
    joint->reference *= part;
    joint->spring_reference *= part;
}

static bool is_free(mjcf *m, const xmlNode *joint, const char *childclass)
{
    mjcf_element e;
    if (!xml_is(joint, "joint")) return xml_is(joint, "freejoint");
    const char *type = mjcf_open(m, joint, childclass, "joint", &e) ? mjcf_text(&e, "type") : NULL;
    return type && strcmp(type, "free") == 0;
}

/* A body that only floats, with nothing that moves in it: in the scenes of a collection the things beside a hand. */
static bool floats_alone(mjcf *m, const xmlNode *body, const char *childclass)
{
    bool floats = false;
    if (xml_text(body, "childclass")) childclass = xml_text(body, "childclass");
    for (const xmlNode *n = xml_child(body, NULL); n; n = xml_next(n, NULL)) {
        bool frees = is_free(m, n, childclass);
        floats = floats || frees;
        if (xml_is(n, "body") || xml_is(n, "frame") || (xml_is(n, "joint") && !frees)) return false;
    }
    return floats;
}

void mjcf_count_outermost(mjcf *m)
{
    for (const xmlNode *w = xml_child(m->root, "worldbody"); w; w = xml_next(w, "worldbody"))
        for (const xmlNode *b = xml_child(w, "body"); b; b = xml_next(b, "body"))
            ++*(floats_alone(m, b, NULL) ? &m->floating_count : &m->standing_count);
}

/* A hand that floats freely is a hand whose base the scene moves. Things beside it are not counted: they are left out
 * (see read_bodies). */
static void read_free_joint(mjcf *m, const xmlNode *node, int link)
{
    size_t count = m->standing_count ? m->standing_count : m->floating_count;
    if (count == 1 && m->r->h->links[link].parent < 0)
        reader_ignore(m->r, node, "freejoint");
    else
        reader_refuse(m->r, node, "expected a free joint only in the one outermost body of the hand");
}

static void read_joint(mjcf *m, const xmlNode *node, const mjcf_place *place)
{
    hand_reader *r = m->r;
    hand *h = r->h;
    mjcf_element e;
    double damper[2] = {0}, axis[3] = {0, 0, 1};
    hand_joint own = {.link = place->link, .coupling = -1, .velocity = INFINITY, .line = (int)xmlGetLineNo(node)};
    if (!mjcf_open(m, node, place->childclass, "joint", &e) || !mjcf_only(&e, joint_attributes)) return;
    int type = mjcf_word(&e, "type", "hinge slide ball free", 0);
    if (type == 3) {
        read_free_joint(m, node, place->link);
        return;
    }
    if (type > 1) {
        reader_refuse(r, node, "the type %s is not supported; there are hinge and slide", mjcf_text(&e, "type"));
        return;
    }
    own.type = type == 0 ? HAND_HINGE : HAND_SLIDER;
    mjcf_numbers(&e, "axis", axis, 3, 3);
    mjcf_numbers(&e, "pos", own.anchor, 3, 3);
    mjcf_numbers(&e, "springdamper", damper, 2, 2);
    if (damper[0] != 0 || damper[1] != 0)
        reader_refuse(r, node,
                      "springdamper is not supported; there are stiffness and "
                      "damping");
    double length = scene_norm(axis), anchor[3];
    if (r->status == HAND_OK && !(length > 1e-14)) reader_refuse(r, node, "expected an axis with a direction");
    for (int i = 0; i < 3; i++) axis[i] /= length;
    scene_rotate(place->frame.orientation, axis, own.axis);
    pose_point(&place->frame, own.anchor, anchor);
    scene_copy(anchor, own.anchor);
    read_joint_limits(&e, &own);
    own.stiffness = first_coefficient(&e, "stiffness");
    own.damping = first_coefficient(&e, "damping");
    own.friction = first_coefficient(&e, "frictionloss");
    own.armature = first_coefficient(&e, "armature");
    own.name = reader_name(r, node, "joint", h->joint_count);
    hand_joint *joint = reader_append(r, &h->joints, &h->joint_count, sizeof *joint);
    if (joint) *joint = own;
}

static void read_site(mjcf *m, const xmlNode *node, const mjcf_place *place)
{
    hand_reader *r = m->r;
    mjcf_element e;
    double own[3] = {0}, ends[6];
    if (!mjcf_open(m, node, place->childclass, "site", &e)) return;
    mjcf_numbers(&e, "pos", own, 3, 3);
    if (mjcf_numbers(&e, "fromto", ends, 6, 6))
        for (int i = 0; i < 3; i++) own[i] = 0.5 * (ends[i] + ends[i + 3]);
    reader_name(r, node, "site", m->site_count);
    mjcf_site *site = reader_append(r, &m->sites, &m->site_count, sizeof *site);
    if (!site) return;
    site->link = place->link;
    pose_point(&place->frame, own, site->position);
}

static void read_inertial(mjcf *m, const xmlNode *node, hand_mass *mass)
{
    hand_reader *r = m->r;
    mjcf_element e = mjcf_alone(m, node);
    hand_mass own = {0};
    double diagonal[3] = {0}, full[6];
    reader_only(r, node, "pos quat mass diaginertia axisangle xyaxes zaxis euler fullinertia");
    if (!reader_number(r, node, "mass", &own.mass)) reader_required(r, node, "mass");
    reader_required(r, node, "pos");
    bool has_diagonal = reader_numbers(r, node, "diaginertia", diagonal, 3, 3) > 0;
    bool has_full = reader_numbers(r, node, "fullinertia", full, 6, 6) > 0;
    for (int i = 0; i < 3; i++) own.inertia[4 * i] = has_full ? full[i] : diagonal[i];
    if (has_full) {
        own.inertia[1] = own.inertia[3] = full[3];
        own.inertia[2] = own.inertia[6] = full[4];
        own.inertia[5] = own.inertia[7] = full[5];
    }
    hand_pose frame = mjcf_pose(&e);
    bool turned = false;
    for (const xmlAttr *a = node->properties; a; a = a->next)
        turned = turned || xml_listed("quat axisangle xyaxes zaxis euler", (const char *)a->name);
    if (has_full && (has_diagonal || turned))
        reader_refuse(r, node, "expected fullinertia alone, without diaginertia and orientation");
    if (!m->compiler.balance) geometry_check_mass(r, node, &own, INERTIA_DIGITS);
    if (r->status == HAND_OK) mass_in_outer(&frame, &own, mass);
}

/* The compiler's bounds, and its way to mend an inertia that nothing can have. */
static void bound_mass(const mjcf_compiler *c, hand_mass *mass)
{
    double values[3], axes[9];
    if (!(c->bound_mass > 0) && !(c->bound_inertia > 0) && !c->balance) return;
    mass->mass = fmax(mass->mass, c->bound_mass);
    inertia_principal(mass->inertia, values, axes);
    for (int i = 0; i < 3; i++) values[i] = fmax(values[i], c->bound_inertia);
    double mean = (values[0] + values[1] + values[2]) / 3;
    bool broken = values[0] > values[1] + values[2];
    for (int i = 0; i < 3 && c->balance && broken; i++) values[i] = mean;
    inertia_from_principal(values, axes, mass->inertia);
}

/* What belongs to the body itself, through all frames in it. */
static void read_items(mjcf *m, const xmlNode *node, const mjcf_place *place, hand_mass *inferred)
{
    hand_reader *r = m->r;
    for (const xmlNode *n = xml_child(node, NULL); n && r->status == HAND_OK; n = xml_next(n, NULL)) {
        const char *name = (const char *)n->name;
        if (place->link < 0 && xml_listed("joint freejoint inertial", name)) {
            reader_refuse(r, n, "expected it in a body: the world does not move");
        } else if (xml_is(n, "geom")) {
            mjcf_read_geom(m, n, place, inferred);
        } else if (xml_is(n, "joint")) {
            read_joint(m, n, place);
        } else if (xml_is(n, "freejoint")) {
            read_free_joint(m, n, place->link);
        } else if (xml_is(n, "site")) {
            read_site(m, n, place);
        } else if (xml_is(n, "frame")) {
            mjcf_element e = mjcf_alone(m, n);
            hand_pose own = mjcf_pose(&e);
            mjcf_place inner = {place->link, pose_product(&place->frame, &own), xml_text(n, "childclass")};
            if (!inner.childclass) inner.childclass = place->childclass;
            reader_only(r, n, "name childclass pos quat axisangle xyaxes zaxis euler");
            read_items(m, n, &inner, inferred);
        } else if (xml_listed("camera light", name)) {
            reader_ignore(r, n, name);
        } else if (xml_is(n, "plugin")) {
            reader_unmodelled(r, n, "plugin of a body");
        } else if (!xml_listed("body inertial", name)) {
            reader_refuse(r, n, "not supported in a body");
        }
    }
}

static void read_bodies(mjcf *m, const xmlNode *node, const mjcf_place *place);

static void read_body(mjcf *m, const xmlNode *node, const mjcf_place *place)
{
    hand_reader *r = m->r;
    hand *h = r->h;
    mjcf_element e = mjcf_alone(m, node);
    hand_link own = {.parent = place->link, .line = (int)xmlGetLineNo(node)};
    reader_only(r, node, "name childclass pos quat axisangle xyaxes zaxis euler mocap gravcomp sleep simple user");
    own.pose = mjcf_pose(&e);
    own.pose = pose_product(&place->frame, &own.pose);
    reader_number(r, node, "gravcomp", &own.gravity_compensation);
    if (own.gravity_compensation < 0) reader_refuse(r, node, "expected a gravcomp that is not negative");
    int index = (int)h->link_count;
    own.name = reader_name(r, node, "body", h->link_count);
    if (xml_text(node, "mocap") && strcmp(xml_text(node, "mocap"), "true") == 0) {
        reader_ignore(r, node, "mocap");
        reader_name(r, node, "mocap", h->link_count); /* by which welds find it */
    }
    own.file = reader_text(r, "%s", xml_file(node));
    hand_link *link = reader_append(r, &h->links, &h->link_count, sizeof *link);
    if (!link) return;
    *link = own;

    mjcf_place inside = {index, pose_identity(), xml_text(node, "childclass")};
    if (!inside.childclass) inside.childclass = place->childclass;
    const xmlNode *inertial = xml_child(node, "inertial");
    bool infer = m->compiler.from_geoms == 1 || (m->compiler.from_geoms == 2 && !inertial);
    hand_mass mass = {0};
    read_items(m, node, &inside, infer ? &mass : NULL);
    if (inertial && !infer) read_inertial(m, inertial, &mass);
    if (inertial && xml_next(inertial, "inertial"))
        reader_refuse(r, xml_next(inertial, "inertial"), "expected one of it in a body");
    bound_mass(&m->compiler, &mass);
    if (r->status != HAND_OK) return;
    h->links[index].mass = mass;
    read_bodies(m, node, &inside);
}

/* The bodies below, through all frames. */
static void read_bodies(mjcf *m, const xmlNode *node, const mjcf_place *place)
{
    for (const xmlNode *n = xml_child(node, NULL); n && m->r->status == HAND_OK; n = xml_next(n, NULL)) {
        if (xml_is(n, "body") && place->link < 0 && m->standing_count > 0 && floats_alone(m, n, place->childclass)) {
            reader_ignore(m->r, n, "floating body beside the hand");
        } else if (xml_is(n, "body")) {
            read_body(m, n, place);
        } else if (xml_is(n, "frame")) {
            mjcf_element e = mjcf_alone(m, n);
            hand_pose own = mjcf_pose(&e);
            mjcf_place inner = {place->link, pose_product(&place->frame, &own), xml_text(n, "childclass")};
            if (!inner.childclass) inner.childclass = place->childclass;
            read_bodies(m, n, &inner);
        }
    }
}

void mjcf_read_world(mjcf *m, const xmlNode *world)
{
    mjcf_place place = {-1, pose_identity(), NULL};
    read_items(m, world, &place, NULL);
    read_bodies(m, world, &place);
}
