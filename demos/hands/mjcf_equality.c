/* Contact exclusions, couplings of joints, loops, and tendons. */

#include "formats.h"
#include "mjcf.h"

#include <stdlib.h>
#include <string.h>

/* A body by its name; -1 is the world. */
static bool refer_body(hand_reader *r, const xmlNode *node, const char *attribute, int *link)
{
    const char *name = reader_required(r, node, attribute);
    *link = -1;
    if (!name) return false;
    if (strcmp(name, "world") != 0) *link = reader_refer(r, node, attribute, "body");
    return r->status == HAND_OK;
}

void mjcf_read_contacts(mjcf *m, const xmlNode *section)
{
    hand_reader *r = m->r;
    hand *h = r->h;
    for (const xmlNode *n = xml_child(section, NULL); n && r->status == HAND_OK; n = xml_next(n, NULL)) {
        hand_exclude own;
        if (xml_is(n, "pair")) { /* links touch as their masks and the scene say */
            reader_unmodelled(r, n, "contact of a pair of geoms");
            continue;
        }
        if (!xml_is(n, "exclude")) {
            reader_refuse(r, n, "not supported in <contact>; there are <exclude> and <pair>");
            return;
        }
        reader_only(r, n, "name body1 body2");
        if (!refer_body(r, n, "body1", &own.link[0]) || !refer_body(r, n, "body2", &own.link[1])) return;
        hand_exclude *item = reader_append(r, &h->excludes, &h->exclude_count, sizeof *item);
        if (item) *item = own;
    }
}

/* y - y0 = a0 + a1 (x - x0), where x0 and y0 are the references of the joints */
static void read_coupling(mjcf *m, const xmlNode *node)
{
    hand_reader *r = m->r;
    double a[5] = {0, 1, 0, 0, 0};
    reader_only(r, node, "name class active solref solimp joint1 joint2 polycoef");
    hand_coupling own = {.joint = reader_refer(r, node, "joint1", "joint"), .of = -1, .line = (int)xmlGetLineNo(node)};
    if (xml_text(node, "joint2")) own.of = reader_refer(r, node, "joint2", "joint");
    reader_numbers(r, node, "polycoef", a, 1, 5);
    if (a[2] != 0 || a[3] != 0 || a[4] != 0)
        reader_refuse(r, node, "a polycoef of a degree above one is not supported");
    if (r->status != HAND_OK) return;
    own.multiplier = own.of < 0 ? 0 : a[1];
    own.offset = r->h->joints[own.joint].reference + a[0];
    if (own.of >= 0) own.offset -= a[1] * r->h->joints[own.of].reference;
    tree_couple(r, node, &own);
}

/* Where the links are with all joints at their references. */
static hand_pose *reference_poses(hand_reader *r)
{
    const hand *h = r->h;
    double *positions = malloc((h->joint_count + 1) * sizeof *positions);
    hand_pose *poses = malloc((h->link_count + 1) * sizeof *poses);
    if (positions && poses) {
        for (size_t i = 0; i < h->joint_count; i++) positions[i] = h->joints[i].reference;
        hand_kinematics(h, positions, poses);
    } else {
        reader_no_memory(r);
        free(poses);
        poses = NULL;
    }
    free(positions);
    return poses;
}

static void read_loop_sites(mjcf *m, const xmlNode *node, hand_loop *loop)
{
    const char *const names[2] = {"site1", "site2"};
    for (int i = 0; i < 2; i++) {
        int site = reader_refer(m->r, node, names[i], "site");
        if (site < 0) return;
        loop->link[i] = m->sites[site].link;
        scene_copy(m->sites[site].position, loop->anchor[i]);
    }
}

/* The anchor is given in the first body. The point of the second is the one that is there in the reference pose. */
static void read_loop_bodies(mjcf *m, const xmlNode *node, hand_loop *loop)
{
    hand_reader *r = m->r;
    double point[3];
    if (!refer_body(r, node, "body1", &loop->link[0])) return;
    loop->link[1] = -1;
    if (xml_text(node, "body2") && !refer_body(r, node, "body2", &loop->link[1])) return;
    if (!reader_numbers(r, node, "anchor", loop->anchor[0], 3, 3)) reader_required(r, node, "anchor");
    hand_pose *poses = r->status == HAND_OK ? reference_poses(r) : NULL, identity = pose_identity();
    if (!poses) return;
    pose_point(loop->link[0] < 0 ? &identity : &poses[loop->link[0]], loop->anchor[0], point);
    pose_point_back(loop->link[1] < 0 ? &identity : &poses[loop->link[1]], point, loop->anchor[1]);
    free(poses);
}

static void read_loop(mjcf *m, const xmlNode *node)
{
    hand_reader *r = m->r;
    hand *h = r->h;
    hand_loop own = {.line = (int)xmlGetLineNo(node)};
    reader_only(r, node, "name class active solref solimp body1 body2 anchor site1 site2");
    (xml_text(node, "site1") ? read_loop_sites : read_loop_bodies)(m, node, &own);
    if (r->status == HAND_OK && own.link[0] < 0) { /* the world comes second */
        if (own.link[1] < 0) {
            reader_refuse(r, node, "expected a body that is not the world");
            return;
        }
        hand_loop turned = own;
        turned.link[0] = own.link[1];
        turned.link[1] = -1;
        scene_copy(own.anchor[1], turned.anchor[0]);
        scene_copy(own.anchor[0], turned.anchor[1]);
        own = turned;
    }
    own.name = reader_name(r, node, "connect", h->loop_count);
    hand_loop *loop = reader_append(r, &h->loops, &h->loop_count, sizeof *loop);
    if (loop) *loop = own;
}

static bool is_mocap(hand_reader *r, const xmlNode *weld, const char *body)
{
    const char *name = xml_text(weld, body);
    return name && reader_find(r, "mocap", name) >= 0;
}

/* A program moves a mocap body, and drags what is welded to it. Here the scene's base moves a hand. Without any other
 * weld the links would come apart. */
static void read_weld(mjcf *m, const xmlNode *node)
{
    if (is_mocap(m->r, node, "body1") || is_mocap(m->r, node, "body2"))
        reader_unmodelled(m->r, node, "weld to a mocap body");
    else
        reader_refuse(m->r, node, "not supported in <equality> but to a mocap body; there are <joint> and <connect>");
}

void mjcf_read_equalities(mjcf *m, const xmlNode *section)
{
    hand_reader *r = m->r;
    for (const xmlNode *n = xml_child(section, NULL); n && r->status == HAND_OK; n = xml_next(n, NULL)) {
        mjcf_element e;
        if (!mjcf_open(m, n, NULL, "equality", &e)) return;
        bool active = mjcf_word(&e, "active", "false true", 1) == 1;
        if (!active)
            reader_ignore(r, n, "equality that is not active");
        else if (xml_is(n, "joint"))
            read_coupling(m, n);
        else if (xml_is(n, "connect"))
            read_loop(m, n);
        else if (xml_is(n, "weld"))
            read_weld(m, n);
        else
            reader_refuse(r, n, "not supported in <equality>; there are <joint> and <connect>");
    }
}

static bool read_wraps(hand_reader *r, const xmlNode *node, hand_tendon *tendon)
{
    for (const xmlNode *n = xml_child(node, NULL); n; n = xml_next(n, NULL)) tendon->count++;
    if (tendon->count == 0) return reader_refuse(r, node, "expected at least one <joint> in it");
    tendon->joints = calloc(tendon->count, sizeof *tendon->joints);
    tendon->coefficients = calloc(tendon->count, sizeof *tendon->coefficients);
    if (!tendon->joints || !tendon->coefficients) return reader_no_memory(r);
    size_t k = 0;
    for (const xmlNode *n = xml_child(node, NULL); n; n = xml_next(n, NULL), k++) {
        if (!xml_is(n, "joint")) return reader_refuse(r, n, "expected <joint> in a fixed tendon");
        reader_only(r, n, "joint coef");
        tendon->joints[k] = reader_refer(r, n, "joint", "joint");
        if (!reader_number(r, n, "coef", &tendon->coefficients[k])) reader_required(r, n, "coef");
        if (r->status != HAND_OK) return false;
        for (size_t i = 0; i < k; i++)
            if (tendon->joints[i] == tendon->joints[k]) return reader_refuse(r, n, "expected each joint once");
        double spring = r->h->joints[tendon->joints[k]].spring_reference;
        for (int i = 0; i < 2; i++) tendon->rest[i] += tendon->coefficients[k] * spring;
    }
    return true;
}

/* Twice -1, the default: the length with all joints where their springs rest. Other lengths may be negative, too. */
static void read_rest(const mjcf_element *e, hand_tendon *tendon)
{
    double rest[2] = {-1, -1};
    if (mjcf_numbers(e, "springlength", rest, 1, 2) == 1) rest[1] = rest[0];
    if (rest[0] == -1 && rest[1] == -1) return;
    if (rest[0] > rest[1]) reader_refuse(e->m->r, e->node, "expected a springlength whose first number is not larger");
    memcpy(tendon->rest, rest, sizeof rest);
}

static void read_tendon_limits(const mjcf_element *e, hand_tendon *tendon)
{
    double range[2] = {0}, effort[2] = {0};
    bool has_range = mjcf_numbers(e, "range", range, 2, 2) > 0;
    tendon->limited = mjcf_is_limited(e, "limited", has_range, range);
    tendon->lower = tendon->limited ? range[0] : -INFINITY;
    tendon->upper = tendon->limited ? range[1] : INFINITY;
    bool has_effort = mjcf_numbers(e, "actuatorfrcrange", effort, 2, 2) > 0;
    bool bounded = mjcf_is_limited(e, "actuatorfrclimited", has_effort, effort);
    tendon->least_effort = bounded ? effort[0] : -INFINITY;
    tendon->effort = bounded ? effort[1] : INFINITY;
}

static void read_tendon(mjcf *m, const xmlNode *node)
{
    hand_reader *r = m->r;
    hand *h = r->h;
    mjcf_element e;
    double armature = 0;
    if (!mjcf_open(m, node, NULL, "tendon", &e) ||
        !mjcf_only(&e,
                   "name class group limited actuatorfrclimited range actuatorfrcrange solreflimit solimplimit "
                   "solreffriction solimpfriction frictionloss springlength width material margin stiffness damping "
                   "armature rgba user"))
        return;
    char *name = reader_name(r, node, "tendon", h->tendon_count);
    hand_tendon *tendon = reader_append(r, &h->tendons, &h->tendon_count, sizeof *tendon);
    if (!tendon) return;
    tendon->name = name;
    tendon->line = (int)xmlGetLineNo(node);
    if (!read_wraps(r, node, tendon)) return;
    read_tendon_limits(&e, tendon);
    mjcf_numbers(&e, "stiffness", &tendon->stiffness, 1, 1);
    mjcf_numbers(&e, "damping", &tendon->damping, 1, 1);
    mjcf_numbers(&e, "frictionloss", &tendon->friction, 1, 1);
    mjcf_numbers(&e, "armature", &armature, 1, 1);
    if (armature != 0) reader_unmodelled(r, node, "armature of a tendon");
    read_rest(&e, tendon);
}

void mjcf_read_tendons(mjcf *m, const xmlNode *section)
{
    hand_reader *r = m->r;
    for (const xmlNode *n = xml_child(section, NULL); n && r->status == HAND_OK; n = xml_next(n, NULL)) {
        if (xml_is(n, "fixed")) {
            read_tendon(m, n);
        } else if (xml_is(n, "spatial")) {
            reader_unmodelled(r, n, "spatial tendon");
            reader_name(r, n, "spatial", m->spatial_count++);
        } else {
            reader_refuse(r, n, "not supported in <tendon>; there is <fixed>");
        }
    }
}
