#include "load.h"
#include "scenes/shape/shape.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const model_names[] = {
    [SCENE_FRICTIONLESS] = "frictionless",
    [SCENE_HARD] = "hard",
    [SCENE_SOFT] = "soft",
};

const char *scene_model_name(scene_model model)
{
    return model_names[model];
}

static bool read_tip(const scene_node *finger_node, const scene_object *object, scene_shape *tip)
{
    scene_node node = scene_member(finger_node, "tip");
    if (node.value) return scene_read_shape(&node, "orientation", tip);
    tip->type = SCENE_SPHERE;
    tip->u.sphere.radius = 0.1 * object->shape.bounding_radius;
    return scene_shape_complete(tip) == SCENE_SHAPE_FINE ||
           scene_refuse_plainly(&node, "a tip: the default, a tenth of the object's bounding radius, is too small");
}

/* What the model needs must be there; what it does not have is zero, whatever the file says. */
static bool read_contact(const scene_node *node, scene_finger *finger)
{
    int model = SCENE_HARD;
    scene_node friction = scene_member(node, "friction");
    scene_node torsional_friction = scene_member(node, "torsional_friction");
    if (!scene_read_name(node, "model", model_names, SCENE_SOFT + 1, &model) ||
        !scene_read_material(node, "stiffness", "damping", &finger->stiffness, &finger->damping, &finger->friction) ||
        !scene_read_number(node, "torsional_friction", SCENE_NOT_NEGATIVE, "m", &finger->torsional_friction))
        return false;
    finger->model = (scene_model)model;
    if (finger->model == SCENE_SOFT && node->reader->dimension == 2) finger->model = SCENE_HARD;

    if (finger->model != SCENE_FRICTIONLESS && !friction.value)
        return scene_refuse(&friction, "a friction coefficient (%s finger)", model_names[model]);
    if (finger->model == SCENE_SOFT) {
        scene_node stiffness = scene_member(node, "stiffness");
        scene_node torsional = scene_member(&stiffness, "torsional");
        if (!torsional.value) return scene_refuse(&torsional, "a number > 0 (N m/rad) (soft finger)");
        if (!torsional_friction.value) return scene_refuse(&torsional_friction, "a number >= 0 (m) (soft finger)");
        return true;
    }
    finger->stiffness.torsional = finger->damping.torsional = finger->torsional_friction = 0.0;
    if (finger->model == SCENE_FRICTIONLESS) finger->friction = (scene_friction){0.0, 0.0};
    return true;
}

/* "at most one of closing and normal_force, and neither with a slider" */
static bool check_control(const scene_node *node, const scene_finger *finger)
{
    scene_node closing = scene_member(node, "closing"), force = scene_member(node, "normal_force");
    if (closing.value && force.value)
        return scene_refuse_plainly(&force, "at most one of closing and normal_force, got both");
    if (finger->drive.type != SCENE_DRIVE_SLIDER || (!closing.value && !force.value)) return true;
    return scene_refuse_plainly(closing.value ? &closing : &force,
                                "no closing and no normal_force with a slider: its force pushes the tip");
}

static bool read_control(const scene_node *node, scene_finger *finger)
{
    finger->has_normal_force = scene_has(node, "normal_force");
    finger->max_force = INFINITY;
    return scene_read_number(node, "closing", SCENE_ANY_NUMBER, "m", &finger->closing) &&
           scene_read_number(node, "normal_force", SCENE_NOT_NEGATIVE, "N", &finger->normal_force) &&
           scene_read_number(node, "ramp", SCENE_NOT_NEGATIVE, "s", &finger->ramp) &&
           scene_read_number(node, "max_force", SCENE_POSITIVE, "N", &finger->max_force) &&
           scene_read_drive(node, &finger->drive) && check_control(node, finger);
}

static bool read_damage(const scene_node *finger_node, scene_finger *finger)
{
    scene_node node = scene_member(finger_node, "damage");
    finger->damage_max_force = finger->damage_max_slip = INFINITY;
    if (!node.value) return true;
    return scene_check_object(&node, "damage", NULL) &&
           scene_read_number(&node, "max_force", SCENE_NOT_NEGATIVE, "N", &finger->damage_max_force) &&
           scene_read_number(&node, "max_slip", SCENE_NOT_NEGATIVE, "m", &finger->damage_max_slip);
}

static bool read_finger(const scene_node *node, const scene_object *object, scene_finger *finger)
{
    return scene_check_object(node, "finger", NULL) && scene_read_string(node, "name", false, &finger->name) &&
           scene_read_vector(node, "point", SCENE_POLAR, "m", finger->point) &&
           scene_read_unit_vector(node, "normal", SCENE_POLAR, finger->normal) &&
           read_tip(node, object, &finger->tip) && read_contact(node, finger) && read_control(node, finger) &&
           read_damage(node, finger) && scene_place_finger(node, object, finger);
}

bool scene_read_fingers(const scene_node *root, scene *s)
{
    scene_node list = scene_member(root, "fingers");
    if (!scene_check_array(&list, "fingers")) return false;
    size_t count = json_array_size(list.value);
    if (!count) return scene_refuse(&list, "a list of at least one finger");
    s->fingers = calloc(count, sizeof *s->fingers);
    if (!s->fingers) return scene_refuse_memory(root->reader);
    s->finger_count = count;
    for (size_t i = 0; i < count; i++) {
        scene_node node = scene_element(&list, i);
        if (!scene_name_by_place(&node, 'F', i, &s->fingers[i].name) || !read_finger(&node, &s->object, &s->fingers[i]))
            return false;
        for (size_t k = 0; k < i; k++)
            if (strcmp(s->fingers[k].name, s->fingers[i].name) == 0) return scene_refuse_name(&node, "fingers", k);
    }
    return true;
}
