#include "load.h"

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
