/* Reads the fingers: tip, contact, drive, limits, and where the tip is. */

#include "reader.h"

#include "common/vector.h"
#include "scenes/shape/shape.h"

#include <stdlib.h>
#include <string.h>

/* ---- The drive. ---- */

static const char *const drive_names[] = {
    [SCENE_DRIVE_FIXED] = "fixed",
    [SCENE_DRIVE_SLIDER] = "slider",
    [SCENE_DRIVE_PATH] = "path",
};

const char *scene_drive_name(scene_drive_type type)
{
    return drive_names[type];
}

bool scene_read_time(const scene_node *node, double earliest, double *time)
{
    if (!scene_read_number(node, "time", SCENE_NOT_NEGATIVE, "s", time)) return false;
    scene_node member = scene_member(node, "time");
    return *time >= earliest || scene_refuse(&member, "a time not before the entry in front of it (%g s)", earliest);
}

static bool read_path(const scene_node *drive_node, scene_drive *drive)
{
    scene_node list = scene_member(drive_node, "points");
    if (!scene_check_array(&list, "points")) return false;
    size_t count = json_array_size(list.value);
    if (!count) return scene_refuse(&list, "a list of at least one point");
    drive->u.path.points = calloc(count, sizeof *drive->u.path.points);
    if (!drive->u.path.points) return scene_refuse_memory(drive_node->reader);
    drive->u.path.count = count;
    for (size_t i = 0; i < count; i++) {
        scene_path_point *point = &drive->u.path.points[i];
        scene_node node = scene_element(&list, i);
        if (i) *point = point[-1];
        if (!scene_check_object(&node, "path_point", NULL) || !scene_read_time(&node, point->time, &point->time) ||
            !scene_read_vector(&node, "translation", SCENE_POLAR, "m", point->translation) ||
            !scene_read_vector(&node, "rotation", SCENE_AXIAL, "rad", point->rotation))
            return false;
    }
    return true;
}

bool scene_read_drive(const scene_node *finger, scene_drive *drive)
{
    scene_node node = scene_member(finger, "drive");
    if (!node.value) return true;
    int type = SCENE_DRIVE_FIXED;
    if (!json_is_object(node.value)) return scene_refuse(&node, "an object");
    scene_node type_node = scene_member(&node, "type");
    if (!type_node.value) return scene_refuse(&type_node, "a drive's type");
    if (!scene_read_name(&node, "type", drive_names, SCENE_DRIVE_PATH + 1, &type) ||
        !scene_check_object(&node, drive_names[type], NULL))
        return false;
    drive->type = (scene_drive_type)type;
    if (drive->type == SCENE_DRIVE_PATH) return read_path(&node, drive);
    if (drive->type == SCENE_DRIVE_FIXED) return true;
    return scene_read_number(&node, "mass", SCENE_POSITIVE, "kg", &drive->u.slider.mass) &&
           scene_read_number(&node, "force", SCENE_NOT_NEGATIVE, "N", &drive->u.slider.force) &&
           scene_read_number(&node, "damping", SCENE_NOT_NEGATIVE, "N s/m", &drive->u.slider.damping) &&
           scene_read_boolean(&node, "gravity", &drive->u.slider.gravity);
}

/* ---- Is the point on the object's surface, which way are the contact's axes, and where is the tip? ---- */

/* A point may be this far from the surface, over the diameter of the object's bounding sphere. */
static const double SURFACE_TOLERANCE = 1e-6;

/* "snap" takes a point to the surface from no farther than this. */
static const double SNAP_TOLERANCE = 0.01;

/* Puts a point that is off the surface onto it, where it may snap, or refuses it with the nearest one. */
static bool snap_point(const scene_node *node, const scene_object *object, bool snap, double gap, double point[3],
                       scene_finger *finger)
{
    double tolerance = SURFACE_TOLERANCE * 2.0 * object->shape.bounding_radius, nearest[3], world[3];
    bool found = scene_shape_nearest(&object->shape, point, tolerance, nearest);
    scene_rotate(object->orientation, nearest, world);
    for (int i = 0; i < 3; i++) world[i] += object->position[i];
    if (snap && found && fabs(gap) <= SNAP_TOLERANCE * 2.0 * object->shape.bounding_radius) {
        memcpy(finger->point, world, sizeof world);
        memcpy(point, nearest, sizeof nearest);
        return true;
    }
    char advice[160] = "";
    if (found)
        snprintf(advice, sizeof advice, "; the nearest point of the surface is [%.9g, %.9g, %.9g]%s", world[0],
                 world[1], world[2], snap ? ", which is too far for \"snap\" (1 % of the object's size)" : "");
    scene_node member = scene_member(node, "point");
    return scene_refuse_plainly(&member, "a point on the object's surface (within %g m), got a gap of %g m %s%s",
                                tolerance, fabs(gap), gap > 0.0 ? "outside it" : "inside it", advice);
}

static bool check_surface(const scene_node *node, const scene_object *object, scene_finger *finger)
{
    double offset[3], point[3], normal[3];
    bool snap = false;
    if (!scene_read_boolean(node, "snap", &snap)) return false;
    scene_subtract(finger->point, object->position, offset);
    scene_rotate_back(object->orientation, offset, point);
    scene_rotate_back(object->orientation, finger->normal, normal);
    double tolerance = SURFACE_TOLERANCE * 2.0 * object->shape.bounding_radius;
    double gap = scene_shape_distance(&object->shape, point);
    if (!(fabs(gap) <= tolerance) && !snap_point(node, object, snap, gap, point, finger)) return false;
    if (scene_shape_points_in(&object->shape, point, normal, tolerance)) return true;
    scene_node member = scene_member(node, "normal");
    return scene_refuse_plainly(&member, "a normal that points into the object, got one that points out of it or along "
                                         "its surface");
}

static void least_aligned_axis(const double n[3], double axis[3])
{
    int best = 0;
    for (int i = 1; i < 3; i++)
        if (fabs(n[i]) < fabs(n[best]) - 1e-12) best = i;
    for (int i = 0; i < 3; i++) axis[i] = i == best ? 1.0 : 0.0;
}

/* t1 is made from `tangent` by two passes of Gram-Schmidt: one pass leaves |t1.n| of the size of rounding over the sine
 * of the angle between them. A tangent that is perpendicular already keeps its bits, so that a printed scene loads
 * unchanged. */
static bool complete_frame(const scene_node *node, scene_finger *finger)
{
    const double *n = finger->normal;
    double *t1 = finger->t1;
    scene_node member = scene_member(node, "tangent");
    if (!scene_read_vector(node, "tangent", SCENE_FREE, "", t1)) return false;
    if (node->reader->dimension == 2) {
        t1[0] = -n[1];
        t1[1] = n[0];
        t1[2] = 0.0;
    } else {
        if (!member.value) least_aligned_axis(n, t1);
        if (!(scene_norm(t1) > 0.0)) return scene_refuse_plainly(&member, "a vector that is not zero");
        scene_normalise(t1, 3);
        for (int pass = 0; pass < 2; pass++) {
            double along = scene_dot(t1, n);
            if (fabs(along) <= 1e-15) break;
            scene_add_scaled(t1, -along, n);
            if (!(scene_norm(t1) > 1e-9))
                return scene_refuse_plainly(&member, "a vector that is not parallel to the normal");
            scene_normalise(t1, 3);
        }
    }
    scene_cross(n, t1, finger->t2);
    return true;
}

/* The smallest rotation that takes +x to n is q ~ (1 + n_x, x cross n). Near -x, 1 + n_x is written without
 * cancellation. At -x any half turn perpendicular to x would do, and the one about z is taken. */
static void smallest_rotation_from_x(const double n[3], double q[4])
{
    double across = hypot(n[1], n[2]);
    if (n[0] < 0.0 && across < 1e-12) {
        q[0] = q[1] = q[2] = 0.0;
        q[3] = 1.0;
        return;
    }
    q[0] = n[0] < 0.0 ? across * across / (1.0 - n[0]) : 1.0 + n[0];
    q[1] = 0.0;
    q[2] = 0.0 - n[2]; /* not -0 */
    q[3] = n[1];
    scene_normalise(q, 4);
}

static bool place_tip(const scene_node *node, scene_finger *finger)
{
    scene_node tip = scene_member(node, "tip");
    double direction[3], support[3], offset[3];
    smallest_rotation_from_x(finger->normal, finger->tip_orientation);
    if (!scene_read_quaternion(&tip, "orientation", finger->tip_orientation)) return false;
    scene_rotate_back(finger->tip_orientation, finger->normal, direction);
    scene_shape_support(&finger->tip, direction, support);
    scene_rotate(finger->tip_orientation, support, offset);
    scene_subtract(finger->point, offset, finger->tip_position);
    return true;
}

static bool place_finger(const scene_node *node, const scene_object *object, scene_finger *finger)
{
    return check_surface(node, object, finger) && complete_frame(node, finger) && place_tip(node, finger);
}

/* ---- The finger. ---- */

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

/* The keys that the model needs must be there. What the model does not have is zero, whatever the file says. */
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

bool scene_read_link_contact(const scene_node *node, scene_finger *link)
{
    int model = link->model;
    if (!scene_check_object(node, "link_contact", NULL) ||
        !scene_read_name(node, "model", model_names, SCENE_SOFT + 1, &model))
        return false;
    link->model = (scene_model)model;
    return scene_read_given_material(node, "stiffness", "damping", &link->stiffness, &link->damping, &link->friction) &&
           scene_read_number(node, "torsional_friction", SCENE_NOT_NEGATIVE, "m", &link->torsional_friction) &&
           scene_read_number(node, "max_force", SCENE_POSITIVE, "N", &link->max_force);
}

/* A finger has at most one of `closing` and `normal_force`, and neither with a slider. */
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
           read_damage(node, finger) && place_finger(node, object, finger);
}

bool scene_read_fingers(const scene_node *root, scene *s)
{
    scene_node list = scene_member(root, "fingers");
    if (!list.value && s->hand_count > 0) return true;
    if (!list.value) return scene_refuse(&list, "this key, or a hand");
    if (!scene_check_array(&list, "fingers")) return false;
    size_t count = json_array_size(list.value);
    if (!count && s->hand_count > 0) return true;
    if (!count) return scene_refuse(&list, "a list of at least one finger");
    s->fingers = calloc(count, sizeof *s->fingers);
    if (!s->fingers) return scene_refuse_memory(root->reader);
    s->finger_count = count;
    for (size_t i = 0; i < count; i++) {
        scene_node node = scene_element(&list, i);
        if (!scene_name_by_place(&node, 'F', i, &s->fingers[i].name) || !read_finger(&node, s->objects, &s->fingers[i]))
            return false;
    }
    return scene_check_names(&list, 0, "fingers", &s->fingers->name, sizeof *s->fingers, count);
}
