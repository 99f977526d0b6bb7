#include "grasp.h"

#include "common/vector.h"
#include "scenes/shape/shape.h"

#include <math.h>
#include <stdio.h>

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

/* What the object is of gives way, too, and the smaller friction counts. */
static void add_object(const scene_object *object, pinch_finger *f)
{
    if (!object->has_material) return;
    f->stiffness[0] = scene_in_series(f->stiffness[0], object->stiffness.normal);
    f->friction = fmin(f->friction, object->friction.static_);
    if (f->friction > 0)
        f->stiffness[1] = scene_in_series(f->stiffness[1], object->stiffness.tangential);
    else
        f->model = PINCH_CONTACT_FRICTIONLESS;
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
        f.point[j] = from->point[j] - s->objects[0].position[j];
        f.normal[j] = from->normal[j];
        f.tangent1[j] = from->t1[j];
    }
    f.force_controlled = scene_finger_force(from, &f.normal_force);
    add_object(&s->objects[0], &f);
    return f;
}

static void grasp_under(const scene *s, const scene_loads *loads, pinch_finger *fingers, pinch_grasp *grasp)
{
    *grasp = (pinch_grasp){.finger_count = (int)s->finger_count,
                           .fingers = fingers,
                           .radius = s->objects[0].shape.bounding_radius,
                           .planar = s->dimension == 2};
    for (size_t i = 0; i < s->finger_count; i++) fingers[i] = finger_of(s, &s->fingers[i]);
    for (int j = 0; j < 3; j++) {
        double acceleration = loads->v[SCENE_GRAVITY][j] - loads->v[SCENE_BASE_ACCELERATION][j];
        grasp->wrench[j] = s->objects[0].mass * acceleration + loads->v[SCENE_FORCE][j];
        grasp->wrench[3 + j] = loads->v[SCENE_TORQUE][j];
        grasp->origin[j] = -s->objects[0].position[j];
    }
}

/* Gravity and base acceleration on a tip that slides press it against the object, or take from its force; where they
 * take more, the tip goes away and presses with nothing. */
static void add_tip_weights(const scene *s, const scene_loads *loads, pinch_finger *fingers)
{
    for (size_t i = 0; i < s->finger_count; i++) {
        const scene_drive *drive = &s->fingers[i].drive;
        if (drive->type != SCENE_DRIVE_SLIDER || !drive->u.slider.gravity) continue;
        double along = 0;
        for (int j = 0; j < 3; j++)
            along += fingers[i].normal[j] * (loads->v[SCENE_GRAVITY][j] - loads->v[SCENE_BASE_ACCELERATION][j]);
        fingers[i].normal_force = fmax(fingers[i].normal_force + drive->u.slider.mass * along, 0);
    }
}

void scene_static_grasp(const scene *s, pinch_finger *fingers, pinch_grasp *grasp)
{
    scene_loads loads;
    scene_first_loads(s, &loads);
    grasp_under(s, &loads, fingers, grasp);
    add_tip_weights(s, &loads, fingers);
}

static void rotate_in_place(const double turn[4], double v[3])
{
    double rotated[3];
    scene_rotate(turn, v, rotated);
    scene_copy(rotated, v);
}

/* The hand has carried fingers and object along as one body; what acts on the object has not turned with it. */
void scene_static_grasp_at(const scene *s, double time, pinch_finger *fingers, pinch_grasp *grasp)
{
    scene_loads loads;
    double turn[4], centre[3];
    scene_schedule_at(s, time, &loads);
    grasp_under(s, &loads, fingers, grasp);
    scene_quaternion_from_rotation(loads.v[SCENE_HAND_ROTATION], turn);
    scene_rotate(turn, s->objects[0].position, centre);
    scene_add_scaled(centre, 1.0, loads.v[SCENE_HAND_TRANSLATION]);
    for (int j = 0; j < 3; j++) grasp->origin[j] = -centre[j];
    for (size_t i = 0; i < s->finger_count; i++) {
        double ramp = scene_ramp(time, s->fingers[i].ramp);
        fingers[i].closing *= ramp;
        fingers[i].normal_force *= ramp;
        rotate_in_place(turn, fingers[i].point);
        rotate_in_place(turn, fingers[i].normal);
        rotate_in_place(turn, fingers[i].tangent1);
    }
    add_tip_weights(s, &loads, fingers);
}

const scene_finger *scene_finger_on_path(const scene *s, double time)
{
    for (size_t i = 0; i < s->finger_count; i++) {
        double translation[3], rotation[3];
        scene_path_at(&s->fingers[i].drive, time, translation, rotation);
        if (scene_norm(translation) > 0 || scene_norm(rotation) > 0) return &s->fingers[i];
    }
    return NULL;
}

/* Flat faces touch in several points, and so do the sides of capsules and cylinders. */
static bool is_pad(const scene_finger *f)
{
    return f->tip.type != SCENE_SPHERE && f->tip.type != SCENE_ELLIPSOID && f->tip.type != SCENE_SUPERELLIPSOID;
}

/* Returns the angle (rad) between a finger's normal and that of the surface beneath a place just off its point. At an
 * edge or corner that is the finger's own, where it may be. */
static double angle_off_surface(const scene_object *object, const scene_finger *f)
{
    double offset[3], place[3], normal[3], slope[3], across[3];
    double off = 1e-3 * object->shape.bounding_radius, step = 1e-3 * off;
    scene_subtract(f->point, object->position, offset);
    scene_rotate_back(object->orientation, offset, place);
    scene_rotate_back(object->orientation, f->normal, normal);
    for (int i = 0; i < 3; i++) place[i] -= off * normal[i];
    for (int i = 0; i < 3; i++) {
        double ahead[3], behind[3];
        scene_copy(place, ahead);
        scene_copy(place, behind);
        ahead[i] += step;
        behind[i] -= step;
        slope[i] = scene_shape_distance(&object->shape, behind) - scene_shape_distance(&object->shape, ahead);
    }
    scene_cross(normal, slope, across);
    return atan2(scene_norm(across), scene_dot(normal, slope));
}

void scene_report_normals(const scene *s, const char *before, const char *after,
                          void (*report)(void *context, const char *text), void *context)
{
    static const double SEEN = 0.02; /* rad; normals of a few digits are no mistake */
    for (size_t i = 0; i < s->finger_count; i++) {
        const scene_finger *f = &s->fingers[i];
        double angle = angle_off_surface(&s->objects[0], f);
        char text[256];
        if (!(angle > SEEN)) continue;
        snprintf(text, sizeof text, "%s%s%s, as the finger's normal is %.3g degrees off the surface's", before, f->name,
                 after, angle * 180 / M_PI);
        report(context, text);
    }
}

/* A tip that bears no more than its drive presses with stands still nowhere; the statics take the less of both. */
static void report_yielding(const scene_finger *f, void (*report)(void *context, const char *text), void *context)
{
    double force;
    char text[256];
    if (!scene_finger_force(f, &force) || !(force > f->max_force)) return;
    snprintf(text, sizeof text, "how %s goes on, pressed with %g N where its tip yields at %g N", f->name, force,
             f->max_force);
    report(context, text);
}

/* Fingers that can be stopped push those that they begin in. Tips are mostly spheres, the default; of others nobody
 * asks how deep they are. */
static void report_overlap(const scene *s, const scene_finger *a, const scene_finger *b,
                           void (*report)(void *context, const char *text), void *context)
{
    static const double LITTLE = 1e-3; /* of the object's bounding radius */
    double apart[3], force;
    char text[256];
    if (a->tip.type != SCENE_SPHERE || b->tip.type != SCENE_SPHERE) return;
    if (!scene_finger_force(a, &force) && !scene_finger_force(b, &force)) return;
    scene_subtract(b->tip_position, a->tip_position, apart);
    double depth = a->tip.bounding_radius + b->tip.bounding_radius - scene_norm(apart);
    if (depth < LITTLE * s->objects[0].shape.bounding_radius) return;
    snprintf(text, sizeof text, "what %s and %s push each other with, which begin %.3g m in each other", a->name,
             b->name, depth);
    report(context, text);
}

void scene_statics_leave_out(const scene *s, void (*report)(void *context, const char *text), void *context)
{
    bool hertz = false, pads = false;
    for (size_t i = 0; i < s->finger_count; i++) {
        hertz = hertz || s->fingers[i].stiffness.hertz > 0;
        pads = pads || is_pad(&s->fingers[i]);
    }
    if (hertz) report(context, "Hertz' law: fingers have their linear stiffness");
    if (pads)
        report(context, "the size of pads: a finger touches in one point, and resists turning only if it is soft");
    if (s->object_count > 1) report(context, "other objects, and what they exert on the first");
    if (s->environment_count > 0) report(context, "the environment");
    scene_report_normals(s, "the object's surface at ", "", report, context);
    for (size_t i = 0; i < s->finger_count; i++) {
        report_yielding(&s->fingers[i], report, context);
        for (size_t j = i + 1; j < s->finger_count; j++)
            report_overlap(s, &s->fingers[i], &s->fingers[j], report, context);
    }
}
