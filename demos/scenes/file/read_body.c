/* Reads the object, the bodies of the environment, and the material of a contact. */

#include "reader.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double OBJECT_FRICTION = 0.5;

static bool check_turned_in_plane(const scene_node *parent, const double q[4])
{
    if (parent->reader->dimension != 2 || hypot(q[1], q[2]) <= 1e-9) return true;
    scene_node node = scene_member(parent, "orientation");
    return scene_refuse_plainly(&node, "a turn about z (dimension 2: x = y = 0), got x = %g, y = %g", q[1], q[2]);
}

/* What an object is made of, where it meets the environment, another object or another hard thing. */
static bool read_object_material(const scene_node *node, scene_object *object)
{
    object->has_material = scene_has(node, "stiffness");
    scene_node stiffness = scene_member(node, "stiffness");
    bool other = scene_has(node, "damping") || scene_has(node, "friction");
    if (!object->has_material) return !other || scene_refuse(&stiffness, "this key with damping or friction");
    object->friction = (scene_friction){OBJECT_FRICTION, OBJECT_FRICTION};
    return scene_read_given_material(node, "plain_stiffness", "plain_damping", &object->stiffness, &object->damping,
                                     &object->friction);
}

static bool read_object(const scene_node *parent, scene_object *object)
{
    scene_node node = *parent, shape = scene_member(&node, "shape");
    object->orientation[0] = 1.0;
    if (!scene_check_object(&node, "object", NULL) || !scene_read_string(&node, "name", false, &object->name) ||
        !scene_read_shape(&shape, NULL, &object->shape) ||
        !scene_read_number(&node, "mass", SCENE_POSITIVE, "kg", &object->mass) ||
        !scene_read_vector(&node, "position", SCENE_POLAR, "m", object->position) ||
        !scene_read_quaternion(&node, "orientation", object->orientation) ||
        !check_turned_in_plane(&node, object->orientation) ||
        !scene_read_vector(&node, "force", SCENE_POLAR, "N", object->force) ||
        !scene_read_vector(&node, "torque", SCENE_AXIAL, "N m", object->torque) || !read_object_material(&node, object))
        return false;
    for (int i = 0; i < 9; i++) object->inertia[i] = object->mass * object->shape.unit_inertia[i];
    for (int i = 0; i < 9; i += 4)
        if (!(object->inertia[i] > 0.0 && isfinite(object->inertia[i]))) {
            scene_node mass = scene_member(&node, "mass");
            return scene_refuse(&mass, "a mass whose inertia is a finite number > 0");
        }
    return true;
}

bool scene_read_objects(const scene_node *root, scene *s)
{
    scene_node one = scene_member(root, "object"), list = scene_member(root, "objects");
    if (!one.value && !list.value) return scene_refuse(&one, "this key");
    if (list.value && !scene_check_array(&list, "objects")) return false;
    size_t single = one.value ? 1 : 0, count = single + json_array_size(list.value);
    if (!count) return scene_refuse(&list, "a list of at least one object");
    if (count > 1 && s->dimension == 2) return scene_refuse_plainly(&list, "dimension 3 with several objects");
    s->objects = calloc(count, sizeof *s->objects);
    if (!s->objects) return scene_refuse_memory(root->reader);
    for (size_t i = 0; i < count; i++) {
        scene_node node = i < single ? one : scene_element(&list, i - single);
        scene_object *object = &s->objects[s->object_count++];
        if (i < single ? !(object->name = scene_copy_text("object"))
                       : !scene_name_by_place(&node, 'O', i, &object->name))
            return scene_refuse_memory(root->reader);
        if (!read_object(&node, object)) return false;
    }
    return scene_check_names(&list, single, "objects", &s->objects->name, sizeof *s->objects, count);
}

bool scene_name_by_place(const scene_node *node, char letter, size_t index, char **name)
{
    char text[32];
    snprintf(text, sizeof text, "%c%zu", letter, index + 1);
    *name = scene_copy_text(text);
    return *name || scene_refuse_memory(node->reader);
}

static bool refuse_name(const scene_node *node, const char *kind, json_int_t index)
{
    scene_node name = scene_member(node, "name");
    return scene_refuse_plainly(name.value ? &name : node, "a name of its own, but %s[%lld] has the same", kind,
                                (long long)index);
}

/* The names are looked up in a table, because a scene may have a hundred thousand fingers. */
bool scene_check_names(const scene_node *list, size_t skipped, const char *kind, char *const *first, size_t stride,
                       size_t count)
{
    json_t *taken = json_object();
    bool good = taken || scene_refuse_memory(list->reader);
    for (size_t i = 0; i < count && good; i++) {
        const char *name = *(char *const *)((const char *)first + i * stride);
        const json_t *before = json_object_get(taken, name);
        scene_node node = scene_element(list, i < skipped ? 0 : i - skipped);
        if (before)
            good = refuse_name(&node, kind, json_integer_value(before));
        else if (json_object_set_new(taken, name, json_integer((json_int_t)i)) != 0)
            good = scene_refuse_memory(list->reader);
    }
    json_decref(taken);
    return good;
}

static bool read_body(const scene_node *node, scene_environment *body)
{
    scene_node shape = scene_member(node, "shape");
    body->orientation[0] = 1.0;
    return scene_check_object(node, "environment", NULL) && scene_read_string(node, "name", false, &body->name) &&
           scene_read_shape(&shape, NULL, &body->shape) &&
           scene_read_vector(node, "position", SCENE_FREE, "m", body->position) &&
           scene_read_quaternion(node, "orientation", body->orientation) &&
           scene_read_material(node, "plain_stiffness", "plain_damping", &body->stiffness, &body->damping,
                               &body->friction);
}

bool scene_read_environment(const scene_node *root, scene *s)
{
    scene_node list = scene_member(root, "environment");
    if (!list.value) return true;
    if (!scene_check_array(&list, "bodies")) return false;
    size_t count = json_array_size(list.value);
    if (!count) return true;
    s->environment = calloc(count, sizeof *s->environment);
    if (!s->environment) return scene_refuse_memory(root->reader);
    s->environment_count = count;
    for (size_t i = 0; i < count; i++) {
        scene_node node = scene_element(&list, i);
        if (!scene_name_by_place(&node, 'E', i, &s->environment[i].name) || !read_body(&node, &s->environment[i]))
            return false;
    }
    return scene_check_names(&list, 0, "environment", &s->environment->name, sizeof *s->environment, count);
}

/* ---- Stiffness, damping and friction. ---- */

static bool read_stiffness(const scene_node *parent, const char *kind, scene_stiffness *stiffness)
{
    scene_node node = scene_member(parent, "stiffness");
    if (!scene_check_object(&node, kind, NULL)) return false;
    if (!scene_read_number(&node, "normal", SCENE_POSITIVE, "N/m", &stiffness->normal)) return false;
    stiffness->tangential = 2.0 / 3.0 * stiffness->normal;
    stiffness->torsional = 0.0;
    return scene_read_number(&node, "tangential", SCENE_POSITIVE, "N/m", &stiffness->tangential) &&
           scene_read_number(&node, "torsional", SCENE_POSITIVE, "N m/rad", &stiffness->torsional) &&
           scene_read_number(&node, "hertz", SCENE_POSITIVE, "Pa", &stiffness->hertz);
}

static bool read_damping(const scene_node *parent, const char *kind, scene_damping *damping)
{
    scene_node node = scene_member(parent, "damping");
    if (!node.value) return true;
    return scene_check_object(&node, kind, NULL) &&
           scene_read_number(&node, "normal", SCENE_NOT_NEGATIVE, "N s/m", &damping->normal) &&
           scene_read_number(&node, "tangential", SCENE_NOT_NEGATIVE, "N s/m", &damping->tangential) &&
           scene_read_number(&node, "torsional", SCENE_NOT_NEGATIVE, "N m s/rad", &damping->torsional);
}

static bool read_friction(const scene_node *parent, scene_friction *friction)
{
    scene_node node = scene_member(parent, "friction");
    if (!node.value) return true;
    if (!json_is_object(node.value)) {
        if (!json_is_number(node.value))
            return scene_refuse(&node, "a number >= 0 or {\"static\": ..., \"kinetic\": ...}");
        if (!scene_read_number(parent, "friction", SCENE_NOT_NEGATIVE, "", &friction->static_)) return false;
        friction->kinetic = friction->static_;
        return true;
    }
    if (!scene_check_object(&node, "friction_pair", NULL) ||
        !scene_read_number(&node, "static", SCENE_NOT_NEGATIVE, "", &friction->static_) ||
        !scene_read_number(&node, "kinetic", SCENE_NOT_NEGATIVE, "", &friction->kinetic))
        return false;
    if (friction->kinetic <= friction->static_) return true;
    scene_node kinetic = scene_member(&node, "kinetic");
    return scene_refuse(&kinetic, "a number from 0 to the static friction %g", friction->static_);
}

bool scene_read_material(const scene_node *node, const char *stiffness_kind, const char *damping_kind,
                         scene_stiffness *stiffness, scene_damping *damping, scene_friction *friction)
{
    return read_stiffness(node, stiffness_kind, stiffness) && read_damping(node, damping_kind, damping) &&
           read_friction(node, friction);
}

bool scene_read_given_material(const scene_node *node, const char *stiffness_kind, const char *damping_kind,
                               scene_stiffness *stiffness, scene_damping *damping, scene_friction *friction)
{
    return (!scene_has(node, "stiffness") || read_stiffness(node, stiffness_kind, stiffness)) &&
           read_damping(node, damping_kind, damping) && read_friction(node, friction);
}
