/* A scene back to JSON, every default filled in. */

#include "common/output.h"
#include "hands/hand.h"
#include "scenes/scene.h"

#include <math.h>

/* Jansson's setters refuse NULL values, so one failed piece makes the whole document fail. */
static void put(json_t *object, bool *good, const char *key, json_t *value)
{
    if (json_object_set_new(object, key, value)) *good = false;
}

static void put_number(json_t *object, bool *good, const char *key, double value)
{
    put(object, good, key, json_number(value));
}

static void put_vector(json_t *object, bool *good, const char *key, const double *values, size_t count)
{
    put(object, good, key, json_numbers(values, count));
}

static json_t *vertices_json(const double *vertices, size_t count, size_t width, bool *good)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++)
        if (json_array_append_new(list, json_numbers(vertices + width * i, width))) *good = false;
    return list;
}

static json_t *shape_json(const scene_shape *shape, const double *orientation, bool *good)
{
    json_t *o = json_object();
    put(o, good, "type", json_string(scene_shape_name(shape->type)));
    switch (shape->type) {
    case SCENE_BOX:
        put_vector(o, good, "size", shape->u.box.size, 3);
        put_number(o, good, "rounding", shape->u.box.rounding);
        break;
    case SCENE_SPHERE:
        put_number(o, good, "radius", shape->u.sphere.radius);
        break;
    case SCENE_CAPSULE: /* the same members as the flat capsule's */
    case SCENE_FLAT_CAPSULE:
        put_number(o, good, "radius", shape->u.capsule.radius);
        put_number(o, good, "length", shape->u.capsule.length);
        break;
    case SCENE_CYLINDER:
        put_number(o, good, "radius", shape->u.cylinder.radius);
        put_number(o, good, "length", shape->u.cylinder.length);
        put_number(o, good, "rounding", shape->u.cylinder.rounding);
        break;
    case SCENE_ELLIPSOID:
        put_vector(o, good, "radii", shape->u.ellipsoid.radii, 3);
        break;
    case SCENE_SUPERELLIPSOID:
        put_vector(o, good, "radii", shape->u.superellipsoid.radii, 3);
        put_vector(o, good, "exponents", shape->u.superellipsoid.exponents, 2);
        break;
    case SCENE_CONVEX:
        put(o, good, "vertices", vertices_json(shape->u.convex.vertices, shape->u.convex.count, 3, good));
        break;
    case SCENE_PRISM:
        put(o, good, "vertices", vertices_json(shape->u.prism.vertices, shape->u.prism.count, 2, good));
        put_number(o, good, "height", shape->u.prism.height);
        break;
    default:
        put(o, good, "file", json_text(shape->u.mesh.file));
    }
    if (orientation) put_vector(o, good, "orientation", orientation, 4);
    return o;
}

static void put_material(json_t *o, bool *good, const scene_stiffness *stiffness, const scene_damping *damping,
                         const scene_friction *friction);

static json_t *object_json(const scene_object *object, bool *good)
{
    json_t *o = json_object();
    put(o, good, "name", json_string(object->name));
    put(o, good, "shape", shape_json(&object->shape, NULL, good));
    put_number(o, good, "mass", object->mass);
    put_vector(o, good, "position", object->position, 3);
    put_vector(o, good, "orientation", object->orientation, 4);
    put_vector(o, good, "force", object->force, 3);
    put_vector(o, good, "torque", object->torque, 3);
    if (object->has_material) put_material(o, good, &object->stiffness, &object->damping, &object->friction);
    return o;
}

static void put_material(json_t *o, bool *good, const scene_stiffness *stiffness, const scene_damping *damping,
                         const scene_friction *friction)
{
    json_t *k = json_object(), *c = json_object();
    bool torsional = stiffness->torsional > 0.0;
    put_number(k, good, "normal", stiffness->normal);
    put_number(k, good, "tangential", stiffness->tangential);
    if (torsional) put_number(k, good, "torsional", stiffness->torsional);
    put_number(c, good, "normal", damping->normal);
    put_number(c, good, "tangential", damping->tangential);
    if (torsional) put_number(c, good, "torsional", damping->torsional);
    if (stiffness->hertz > 0.0) put_number(k, good, "hertz", stiffness->hertz);
    put(o, good, "stiffness", k);
    put(o, good, "damping", c);
    if (friction->kinetic == friction->static_) {
        put_number(o, good, "friction", friction->static_);
        return;
    }
    json_t *pair = json_object();
    put_number(pair, good, "static", friction->static_);
    put_number(pair, good, "kinetic", friction->kinetic);
    put(o, good, "friction", pair);
}

static json_t *drive_json(const scene_drive *drive, bool *good)
{
    json_t *o = json_object();
    put(o, good, "type", json_string(scene_drive_name(drive->type)));
    if (drive->type == SCENE_DRIVE_SLIDER) {
        put_number(o, good, "mass", drive->u.slider.mass);
        put_number(o, good, "force", drive->u.slider.force);
        put_number(o, good, "damping", drive->u.slider.damping);
        put(o, good, "gravity", json_boolean(drive->u.slider.gravity));
    } else if (drive->type == SCENE_DRIVE_PATH) {
        json_t *points = json_array();
        for (size_t i = 0; i < drive->u.path.count; i++) {
            const scene_path_point *point = &drive->u.path.points[i];
            json_t *p = json_object();
            put_number(p, good, "time", point->time);
            put_vector(p, good, "translation", point->translation, 3);
            put_vector(p, good, "rotation", point->rotation, 3);
            if (json_array_append_new(points, p)) *good = false;
        }
        put(o, good, "points", points);
    }
    return o;
}

static void put_limits(json_t *o, bool *good, const scene_finger *finger)
{
    if (isfinite(finger->max_force)) put_number(o, good, "max_force", finger->max_force);
    put(o, good, "drive", drive_json(&finger->drive, good));
    json_t *damage = json_object();
    if (isfinite(finger->damage_max_force)) put_number(damage, good, "max_force", finger->damage_max_force);
    if (isfinite(finger->damage_max_slip)) put_number(damage, good, "max_slip", finger->damage_max_slip);
    put(o, good, "damage", damage);
}

static json_t *finger_json(const scene_finger *finger, bool *good)
{
    json_t *o = json_object();
    put(o, good, "name", json_string(finger->name));
    put_vector(o, good, "point", finger->point, 3);
    put_vector(o, good, "normal", finger->normal, 3);
    put_vector(o, good, "tangent", finger->t1, 3);
    put(o, good, "tip", shape_json(&finger->tip, finger->tip_orientation, good));
    put(o, good, "model", json_string(scene_model_name(finger->model)));
    put_material(o, good, &finger->stiffness, &finger->damping, &finger->friction);
    if (finger->model == SCENE_SOFT) put_number(o, good, "torsional_friction", finger->torsional_friction);
    if (finger->has_normal_force)
        put_number(o, good, "normal_force", finger->normal_force);
    else if (finger->drive.type != SCENE_DRIVE_SLIDER)
        put_number(o, good, "closing", finger->closing);
    put_number(o, good, "ramp", finger->ramp);
    put_limits(o, good, finger);
    return o;
}

static json_t *control_json(const scene_control *c, bool *good)
{
    json_t *o = json_object(), *target = json_array();
    put(o, good, "type", json_string(scene_control_name(c->type)));
    if (c->type == SCENE_POSITION_CONTROL) put_number(o, good, "kp", c->kp);
    if (c->type != SCENE_TORQUE_CONTROL || c->kd > 0) put_number(o, good, "kd", c->kd);
    bool of_file = c->least_force != -c->most_force; /* the file's range, which no max_force is */
    if (isfinite(c->max_force) && !of_file) put_number(o, good, "max_force", c->max_force);
    for (size_t i = 0; i < c->target_count; i++)
        if (json_array_append_new(target, json_numbers((double[]){c->target[i].time, c->target[i].value}, 2)))
            *good = false;
    put(o, good, "target", target);
    return o;
}

static json_t *link_contact_json(const scene_finger *link, bool *good)
{
    json_t *o = json_object();
    put(o, good, "model", json_string(scene_model_name(link->model)));
    put_material(o, good, &link->stiffness, &link->damping, &link->friction);
    if (link->model == SCENE_SOFT) put_number(o, good, "torsional_friction", link->torsional_friction);
    if (isfinite(link->max_force)) put_number(o, good, "max_force", link->max_force);
    return o;
}

static json_t *packages_json(const scene_hand *h, bool *good)
{
    json_t *o = json_object();
    for (size_t i = 0; i < h->package_count; i++)
        put(o, good, h->packages[i].name, json_text(h->packages[i].directory));
    return o;
}

static json_t *hand_json(const scene_hand *h, bool *good)
{
    json_t *o = json_object(), *base = json_object(), *joints = json_object(), *control = json_object(),
           *contacts = json_object();
    put(o, good, "name", json_string(h->name));
    put(o, good, "file", json_text(h->file));
    put(o, good, "packages", packages_json(h, good));
    put_vector(base, good, "position", h->position, 3);
    put_vector(base, good, "orientation", h->orientation, 4);
    put(base, good, "drive", drive_json(&h->drive, good));
    for (size_t i = 0; i < h->model->joint_count; i++) put_number(joints, good, h->model->joints[i].name, h->start[i]);
    for (size_t i = 0; i < h->control_count; i++)
        if (h->controls[i].type != SCENE_UNDRIVEN && !json_object_get(control, h->controls[i].name))
            put(control, good, h->controls[i].name, control_json(&h->controls[i], good));
    for (size_t i = 0; i < h->link_count; i++)
        put(contacts, good, h->link_of[i] < 0 ? "world" : h->model->links[h->link_of[i]].name,
            link_contact_json(&h->links[i], good));
    put(o, good, "base", base);
    put(o, good, "joints", joints);
    put(o, good, "control", control);
    put(o, good, "contacts", contacts);
    put(o, good, "self_collision", json_boolean(h->self_collision));
    return o;
}

static json_t *environment_json(const scene_environment *body, bool *good)
{
    json_t *o = json_object();
    put(o, good, "name", json_string(body->name));
    put(o, good, "shape", shape_json(&body->shape, NULL, good));
    put_vector(o, good, "position", body->position, 3);
    put_vector(o, good, "orientation", body->orientation, 4);
    put_material(o, good, &body->stiffness, &body->damping, &body->friction);
    return o;
}

static json_t *signal_json(const scene_signal *signal, bool *good)
{
    if (signal->type == SCENE_CONSTANT) return json_numbers(signal->value, 3);
    json_t *o = json_object();
    if (signal->type == SCENE_SINE) {
        put_vector(o, good, "amplitude", signal->value, 3);
        put_number(o, good, "frequency", signal->frequency);
        put_number(o, good, "phase", signal->phase);
        put_number(o, good, "fade", signal->fade);
    } else {
        put_vector(o, good, "turn", signal->value, 3);
        put_vector(o, good, "axis", signal->axis, 3);
        put_number(o, good, "frequency", signal->frequency);
    }
    return o;
}

static json_t *entry_json(const scene_entry *entry, bool *good)
{
    json_t *o = json_object(), *moves = json_object();
    put_number(o, good, "time", entry->time);
    for (int c = 0; c < SCENE_CHANNEL_COUNT; c++) {
        const scene_signal *signal = &entry->channels[c];
        /* a sine or turn that goes on from an entry before would start anew if it were printed here */
        if (signal->type != SCENE_CONSTANT && signal->start != entry->time) continue;
        bool of_hand;
        const char *key = scene_channel_key((scene_channel)c, &of_hand);
        put(of_hand ? moves : o, good, key, signal_json(signal, good));
    }
    put(o, good, "hand", moves);
    return o;
}

static json_t *simulation_json(const scene *s, bool *good)
{
    json_t *o = json_object();
    put_number(o, good, "step", s->step);
    put_number(o, good, "duration", s->duration);
    return o;
}

static json_t *solver_json(const scene_solver *solver, bool *good)
{
    json_t *o = json_object();
    put(o, good, "name", json_string(pinch_solver_name(solver->name)));
    put(o, good, "formulation", json_string(scene_formulation_name(solver->formulation)));
    put_number(o, good, "tolerance", solver->tolerance);
    put(o, good, "max_iterations", json_integer(solver->max_iterations));
    put(o, good, "pyramid_faces", json_integer(solver->pyramid_faces));
    return o;
}

static json_t *scene_json(const scene *s, bool *good)
{
    json_t *o = json_object(), *fingers = json_array(), *environment = json_array(), *schedule = json_array();
    json_t *objects = json_array(), *hands = json_array();
    for (size_t i = 0; i < s->object_count; i++)
        if (json_array_append_new(objects, object_json(&s->objects[i], good))) *good = false;
    for (size_t i = 0; i < s->hand_count; i++)
        if (json_array_append_new(hands, hand_json(&s->hands[i], good))) *good = false;
    for (size_t i = 0; i < s->finger_count; i++)
        if (json_array_append_new(fingers, finger_json(&s->fingers[i], good))) *good = false;
    for (size_t i = 0; i < s->environment_count; i++)
        if (json_array_append_new(environment, environment_json(&s->environment[i], good))) *good = false;
    for (size_t i = 0; i < s->entry_count; i++)
        if (json_array_append_new(schedule, entry_json(&s->schedule[i], good))) *good = false;
    put(o, good, "format", json_string("pinch-scene/1"));
    put(o, good, "name", json_string(s->name));
    put(o, good, "source", json_string(s->source));
    put(o, good, "dimension", json_integer(s->dimension));
    put_vector(o, good, "gravity", s->gravity, 3);
    if (s->object_count == 1)
        put(o, good, "object", json_incref(json_array_get(objects, 0)));
    else
        put(o, good, "objects", json_incref(objects));
    json_decref(objects);
    put(o, good, "fingers", fingers);
    if (s->hand_count == 1)
        put(o, good, "hand", json_incref(json_array_get(hands, 0)));
    else if (s->hand_count > 1)
        put(o, good, "hands", json_incref(hands));
    json_decref(hands);
    put(o, good, "environment", environment);
    put(o, good, "schedule", schedule);
    put(o, good, "simulation", simulation_json(s, good));
    put(o, good, "solver", solver_json(&s->solver, good));
    return o;
}

scene_status scene_print(const scene *s, FILE *stream)
{
    bool good = true;
    json_t *document = scene_json(s, &good);
    if (good) json_print(document, stream);
    json_decref(document);
    return good ? SCENE_OK : SCENE_NO_MEMORY;
}
