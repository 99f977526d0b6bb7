/* Reads the hands: the file, the base, the positions of the joints at the start. */
#include "reader.h"

#include "common/vector.h"
#include "hands/hand.h"

#include <stdlib.h>
#include <string.h>

/* ---- The file that describes the hand. ---- */

static bool read_packages(const scene_node *node, scene_hand *h)
{
    scene_node packages = scene_member(node, "packages");
    if (!packages.value) return true;
    if (!json_is_object(packages.value)) return scene_refuse(&packages, "an object: directories by package name");
    size_t count = json_object_size(packages.value);
    h->packages = calloc(count + 1, sizeof *h->packages);
    if (!h->packages) return scene_refuse_memory(node->reader);
    const char *key;
    json_t *value;
    json_object_foreach(packages.value, key, value)
    {
        hand_package *package = &h->packages[h->package_count++];
        char *directory = NULL;
        package->name = scene_copy_text(key);
        bool good = package->name ? scene_read_path(&packages, key, &directory) : scene_refuse_memory(node->reader);
        package->directory = directory;
        if (!good) return false;
    }
    return true;
}

static bool read_model(const scene_node *node, scene_hand *h)
{
    scene_node file = scene_member(node, "file");
    hand_error error;
    if (!scene_read_path(node, "file", &h->file) || !read_packages(node, h)) return false;
    switch (hand_load(h->file, h->packages, h->package_count, &h->model, &error)) {
    case HAND_OK:
        break;
    case HAND_NO_MEMORY:
        return scene_refuse_memory(node->reader);
    default:
        return scene_refuse_plainly(&file, "a hand that can be read: %s", error.text);
    }
    for (size_t i = 0; i < h->model->tendon_count; i++)
        if (h->model->tendons[i].count > SCENE_TENDON_JOINTS)
            return scene_refuse_plainly(&file, "tendons of at most %d joints, but %s has %zu", SCENE_TENDON_JOINTS,
                                        h->model->tendons[i].name, h->model->tendons[i].count);
    return true;
}

/* ---- The base. ---- */

static bool read_base(const scene_node *node, scene_hand *h)
{
    scene_node base = scene_member(node, "base"), drive = scene_member(&base, "drive");
    h->orientation[0] = 1.0;
    if (!base.value) return true;
    if (!scene_check_object(&base, "hand_base", NULL) ||
        !scene_read_vector(&base, "position", SCENE_FREE, "m", h->position) ||
        !scene_read_quaternion(&base, "orientation", h->orientation) || !scene_read_drive(&base, &h->drive))
        return false;
    return h->drive.type != SCENE_DRIVE_SLIDER || scene_refuse_plainly(&drive, "a drive fixed or path");
}

/* ---- The joints at the start. ---- */

static const char *name_of_joint(const void *list, size_t index)
{
    const hand *model = list;
    return model->joints[index].name;
}

static bool within_limits(const hand_joint *joint, double position)
{
    static const double ROUNDING = 1e-9;
    return !joint->limited || (position >= joint->lower - ROUNDING && position <= joint->upper + ROUNDING);
}

static bool check_limits(const scene_node *node, const hand_joint *joint, double position)
{
    if (within_limits(joint, position)) return true;
    return scene_refuse(node, "a position of %s from %g to %g", joint->name, joint->lower, joint->upper);
}

static bool read_positions(const scene_node *node, scene_hand *h, bool *given)
{
    const hand *model = h->model;
    scene_node joints = scene_member(node, "joints");
    scene_rules rules = {.things = model, .count = model->joint_count, .name = name_of_joint, .what = "joint"};
    if (!joints.value) return true;
    if (!json_is_object(joints.value)) return scene_refuse(&joints, "an object: positions by names of joints");
    if (!scene_rules_check(&joints, &rules)) return false;
    for (size_t i = 0; i < model->joint_count; i++) {
        for (const char *key = NULL; (key = scene_rule_after(&joints, &rules, i, key));) {
            scene_node position = scene_member(&joints, key);
            if (!scene_read_number(&joints, key, SCENE_ANY_NUMBER, "rad or m", &h->start[i]) ||
                !check_limits(&position, &model->joints[i], h->start[i]))
                return false;
            given[i] = true;
        }
    }
    return true;
}

/* A joint that follows another one may be given, too, but not elsewhere. */
static bool check_couplings(const scene_node *node, const scene_hand *h, const bool *given)
{
    static const double ROUNDING = 1e-9;
    for (size_t k = 0; k < h->model->coupling_count; k++) {
        const hand_coupling *c = &h->model->couplings[k];
        double position = c->offset + (c->of < 0 ? 0 : c->multiplier * h->start[c->of]);
        const hand_joint *joint = &h->model->joints[c->joint];
        scene_node joints = scene_member(node, "joints");
        if (given[c->joint] && fabs(position - h->start[c->joint]) > ROUNDING)
            return scene_refuse_plainly(&joints, "%s at %.10g, where the joint that it follows takes it, got %.10g",
                                        joint->name, position, h->start[c->joint]);
        if (!within_limits(joint, position))
            return scene_refuse_plainly(joints.value ? &joints : node,
                                        "positions that take %s, which follows other joints, to %g at least and %g at "
                                        "most, not to %.6g",
                                        joint->name, joint->lower, joint->upper, position);
    }
    return true;
}

static bool read_start(const scene_node *node, scene_hand *h)
{
    const hand *model = h->model;
    bool *given = calloc(model->joint_count + 1, sizeof *given);
    h->start = calloc(model->joint_count + 1, sizeof *h->start);
    bool good = given && h->start;
    if (!good) scene_refuse_memory(node->reader);
    for (size_t i = 0; good && i < model->joint_count; i++)
        h->start[i] = fmin(fmax(model->joints[i].reference, model->joints[i].lower), model->joints[i].upper);
    good = good && read_positions(node, h, given);
    if (good) hand_follow_couplings(model, given, h->start);
    if (good) {
        scene_node joints = scene_member(node, "joints");
        double gap;
        switch (scene_close_loops(model, given, h->start, &gap)) {
        case SCENE_LOOPS_CLOSED:
            break;
        case SCENE_LOOPS_OPEN:
            good = scene_refuse_plainly(joints.value ? &joints : node,
                                        "positions at which the loops of the hand close, got a gap of %g m", gap);
            break;
        default:
            good = scene_refuse_memory(node->reader);
        }
    }
    good = good && check_couplings(node, h, given);
    free(given);
    return good;
}

/* ---- The hands. ---- */

static bool read_hand(const scene_node *node, scene_hand *h, bool one_of_several)
{
    return scene_check_object(node, "robot_hand", NULL) && scene_read_string(node, "name", false, &h->name) &&
           read_model(node, h) && read_base(node, h) && read_start(node, h) && scene_read_controls(node, h) &&
           scene_read_link_contacts(node, h, one_of_several) &&
           scene_read_boolean(node, "self_collision", &h->self_collision);
}

bool scene_read_hands(const scene_node *root, scene *s)
{
    scene_node one = scene_member(root, "hand"), list = scene_member(root, "hands");
    if (!one.value && !list.value) return true;
    const scene_node *first = one.value ? &one : &list;
    if (s->dimension == 2) return scene_refuse_plainly(first, "dimension 3 with a hand");
    if (list.value && !scene_check_array(&list, "hands")) return false;
    size_t single = one.value ? 1 : 0, count = single + json_array_size(list.value);
    s->hands = calloc(count + 1, sizeof *s->hands);
    if (!s->hands) return scene_refuse_memory(root->reader);
    for (size_t i = 0; i < count; i++) {
        scene_node node = i < single ? one : scene_element(&list, i - single);
        scene_hand *h = &s->hands[s->hand_count++];
        if (i < single ? !(h->name = scene_copy_text("hand")) : !scene_name_by_place(&node, 'H', i, &h->name))
            return scene_refuse_memory(root->reader);
        if (!read_hand(&node, h, count > 1)) return false;
    }
    return scene_check_names(&list, single, "hands", &s->hands->name, sizeof *s->hands, count);
}

static void free_controls(scene_hand *h)
{
    for (size_t i = 0; i < h->control_count; i++) free(h->controls[i].target);
    free(h->controls);
    for (size_t i = 0; i < h->link_count; i++) free(h->links[i].name);
    free(h->links);
    free(h->link_of);
}

void scene_hand_free(scene_hand *h)
{
    free_controls(h);
    for (size_t i = 0; i < h->package_count; i++) {
        free((char *)h->packages[i].name);
        free((char *)h->packages[i].directory);
    }
    free(h->packages);
    if (h->drive.type == SCENE_DRIVE_PATH) free(h->drive.u.path.points);
    hand_free(h->model);
    free(h->start);
    free(h->file);
    free(h->name);
}
