#include "reader.h"

#include <string.h>

static const scene_key scene_keys[] = {
    {"format", true},       {"name", false},     {"source", false},     {"dimension", false}, {"gravity", false},
    {"object", false},      {"objects", false},  {"fingers", false},    {"hand", false},      {"hands", false},
    {"environment", false}, {"schedule", false}, {"simulation", false}, {"solver", false},
};
static const scene_key object_keys[] = {
    {"name", false},  {"shape", true},   {"mass", true},       {"position", false}, {"orientation", false},
    {"force", false}, {"torque", false}, {"stiffness", false}, {"damping", false},  {"friction", false},
};
static const scene_key finger_keys[] = {
    {"name", false},     {"point", true},
    {"normal", true},    {"tangent", false},
    {"tip", false},      {"model", true},
    {"stiffness", true}, {"damping", false},
    {"friction", false}, {"torsional_friction", false},
    {"closing", false},  {"normal_force", false},
    {"ramp", false},     {"max_force", false},
    {"snap", false},     {"drive", false},
    {"damage", false},
};
static const scene_key environment_keys[] = {
    {"name", false},     {"shape", true},    {"position", false}, {"orientation", false},
    {"stiffness", true}, {"damping", false}, {"friction", true},
};
static const scene_key box_keys[] = {{"type", true}, {"size", true}, {"rounding", false}};
static const scene_key sphere_keys[] = {{"type", true}, {"radius", true}};
static const scene_key capsule_keys[] = {{"type", true}, {"radius", true}, {"length", true}};
static const scene_key cylinder_keys[] = {{"type", true}, {"radius", true}, {"length", true}, {"rounding", false}};
static const scene_key ellipsoid_keys[] = {{"type", true}, {"radii", true}};
static const scene_key superellipsoid_keys[] = {{"type", true}, {"radii", true}, {"exponents", false}};
static const scene_key flat_capsule_keys[] = {{"type", true}, {"radius", true}, {"length", true}};
static const scene_key convex_keys[] = {{"type", true}, {"vertices", true}};
static const scene_key prism_keys[] = {{"type", true}, {"vertices", true}, {"height", true}};
static const scene_key mesh_keys[] = {{"type", true}, {"file", true}};
static const scene_key stiffness_keys[] = {
    {"normal", true}, {"tangential", false}, {"torsional", false}, {"hertz", false}};
static const scene_key damping_keys[] = {{"normal", false}, {"tangential", false}, {"torsional", false}};
static const scene_key plain_stiffness_keys[] = {{"normal", true}, {"tangential", false}};
static const scene_key plain_damping_keys[] = {{"normal", false}, {"tangential", false}};
static const scene_key friction_keys[] = {{"static", true}, {"kinetic", true}};
static const scene_key fixed_keys[] = {{"type", true}};
static const scene_key slider_keys[] = {
    {"type", true}, {"mass", true}, {"force", false}, {"damping", false}, {"gravity", false},
};
static const scene_key path_keys[] = {{"type", true}, {"points", true}};
static const scene_key path_point_keys[] = {{"time", true}, {"translation", false}, {"rotation", false}};
static const scene_key damage_keys[] = {{"max_force", false}, {"max_slip", false}};
static const scene_key entry_keys[] = {
    {"time", true},  {"force", false}, {"torque", false}, {"gravity", false}, {"base_acceleration", false},
    {"hand", false},
};
static const scene_key hand_keys[] = {{"translation", false}, {"rotation", false}};
static const scene_key robot_hand_keys[] = {
    {"name", false},   {"file", true},     {"packages", false}, {"base", false},
    {"joints", false}, {"control", false}, {"contacts", false}, {"self_collision", false},
};
static const scene_key hand_base_keys[] = {{"position", false}, {"orientation", false}, {"drive", false}};
static const scene_key control_keys[] = {
    {"type", false}, {"kp", false}, {"kd", false}, {"max_force", false}, {"target", false},
};
static const scene_key link_contact_keys[] = {
    {"model", false},    {"stiffness", false},          {"damping", false},
    {"friction", false}, {"torsional_friction", false}, {"max_force", false},
};
static const scene_key sine_keys[] = {{"amplitude", true}, {"frequency", true}, {"phase", false}, {"fade", false}};
static const scene_key turn_keys[] = {{"turn", true}, {"axis", true}, {"frequency", true}};
static const scene_key simulation_keys[] = {{"step", false}, {"duration", false}};
static const scene_key solver_keys[] = {
    {"name", false}, {"formulation", false}, {"tolerance", false}, {"max_iterations", false}, {"pyramid_faces", false},
};

#define SCENE_KIND(name, keys)                                                                                         \
    {                                                                                                                  \
        name, sizeof(keys) / sizeof((keys)[0]), keys                                                                   \
    }
static const scene_kind kinds[] = {
    SCENE_KIND("scene", scene_keys),
    SCENE_KIND("object", object_keys),
    SCENE_KIND("finger", finger_keys),
    SCENE_KIND("environment", environment_keys),
    SCENE_KIND("box", box_keys),
    SCENE_KIND("sphere", sphere_keys),
    SCENE_KIND("capsule", capsule_keys),
    SCENE_KIND("cylinder", cylinder_keys),
    SCENE_KIND("ellipsoid", ellipsoid_keys),
    SCENE_KIND("superellipsoid", superellipsoid_keys),
    SCENE_KIND("flat_capsule", flat_capsule_keys),
    SCENE_KIND("convex", convex_keys),
    SCENE_KIND("prism", prism_keys),
    SCENE_KIND("mesh", mesh_keys),
    SCENE_KIND("stiffness", stiffness_keys),
    SCENE_KIND("damping", damping_keys),
    SCENE_KIND("plain_stiffness", plain_stiffness_keys),
    SCENE_KIND("plain_damping", plain_damping_keys),
    SCENE_KIND("friction_pair", friction_keys),
    SCENE_KIND("fixed", fixed_keys),
    SCENE_KIND("slider", slider_keys),
    SCENE_KIND("path", path_keys),
    SCENE_KIND("path_point", path_point_keys),
    SCENE_KIND("damage", damage_keys),
    SCENE_KIND("entry", entry_keys),
    SCENE_KIND("hand", hand_keys),
    SCENE_KIND("robot_hand", robot_hand_keys),
    SCENE_KIND("hand_base", hand_base_keys),
    SCENE_KIND("control", control_keys),
    SCENE_KIND("link_contact", link_contact_keys),
    SCENE_KIND("sine", sine_keys),
    SCENE_KIND("turn", turn_keys),
    SCENE_KIND("simulation", simulation_keys),
    SCENE_KIND("solver", solver_keys),
};

size_t scene_kind_count(void)
{
    return sizeof kinds / sizeof kinds[0];
}

const scene_kind *scene_kind_at(size_t index)
{
    return &kinds[index];
}

const scene_kind *scene_kind_named(const char *name)
{
    for (size_t i = 0; i < scene_kind_count(); i++)
        if (strcmp(kinds[i].name, name) == 0) return &kinds[i];
    return NULL;
}
