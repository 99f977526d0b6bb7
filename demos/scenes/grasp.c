#include "grasp.h"

static pinch_contact_model model_of(scene_model model)
{
    switch (model) {
    case SCENE_FRICTIONLESS:
        return PINCH_CONTACT_FRICTIONLESS;
    case SCENE_SOFT:
        return PINCH_CONTACT_SOFT;
    default:
        return PINCH_CONTACT_HARD;
    }
}

static pinch_finger finger_of(const scene *s, const scene_finger *from)
{
    pinch_finger f = {.model = model_of(from->model),
                      .stiffness = {from->stiffness.normal, from->stiffness.tangential, from->stiffness.torsional},
                      .friction = from->friction.static_,
                      .torsional_friction = from->torsional_friction,
                      .closing = from->closing,
                      .max_force = from->max_force};
    for (int j = 0; j < 3; j++) {
        f.point[j] = from->point[j] - s->object.position[j];
        f.normal[j] = from->normal[j];
        f.tangent1[j] = from->t1[j];
    }
    f.force_controlled = scene_finger_force(from, &f.normal_force);
    return f;
}

void scene_static_grasp(const scene *s, pinch_finger *fingers, pinch_grasp *grasp)
{
    scene_loads loads;
    scene_first_loads(s, &loads);
    *grasp = (pinch_grasp){.finger_count = (int)s->finger_count,
                           .fingers = fingers,
                           .radius = s->object.shape.bounding_radius,
                           .planar = s->dimension == 2};
    for (size_t i = 0; i < s->finger_count; i++) fingers[i] = finger_of(s, &s->fingers[i]);
    for (int j = 0; j < 3; j++) {
        double acceleration = loads.v[SCENE_GRAVITY][j] - loads.v[SCENE_BASE_ACCELERATION][j];
        grasp->wrench[j] = s->object.mass * acceleration + loads.v[SCENE_FORCE][j];
        grasp->wrench[3 + j] = loads.v[SCENE_TORQUE][j];
        grasp->origin[j] = -s->object.position[j];
    }
}
