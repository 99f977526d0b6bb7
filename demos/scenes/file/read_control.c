/* Reads what drives a hand's joints and tendons, from the hand's file and from the rules of the scene. */
#include "reader.h"

#include "common/vector.h"
#include "hands/hand.h"

#include <stdlib.h>
#include <string.h>

static const char *const control_names[] = {"position", "torque", "velocity"};

const char *scene_control_name(scene_control_type type)
{
    return type == SCENE_UNDRIVEN ? "none" : control_names[type - SCENE_POSITION_CONTROL];
}

/* ---- What a rule may be for: the joints, then the tendons, then the further drives of either. ---- */

static size_t places(const hand *model)
{
    return model->joint_count + model->tendon_count;
}

/* The joint or tendon that a drive moves. */
static size_t place_of(const hand *model, const hand_drive *drive)
{
    return drive->joint >= 0 ? (size_t)drive->joint : model->joint_count + (size_t)drive->tendon;
}

static bool has_place(const hand_drive *drive)
{
    return drive->type == HAND_POSITION || (drive->type == HAND_AFFINE && drive->bias[1] < 0);
}

/* The drive of a joint or tendon that goes by its name: the first one to a position, else the first. */
static const hand_drive *main_drive(const hand *model, size_t place)
{
    const hand_drive *first = NULL;
    for (size_t i = 0; i < model->drive_count; i++) {
        const hand_drive *drive = &model->drives[i];
        if (place_of(model, drive) != place) continue;
        if (has_place(drive)) return drive;
        if (!first) first = drive;
    }
    return first;
}

static bool is_further(const hand *model, const hand_drive *drive)
{
    return main_drive(model, place_of(model, drive)) != drive;
}

static size_t further_drives(const hand *model)
{
    size_t count = 0;
    for (size_t i = 0; i < model->drive_count; i++) count += is_further(model, &model->drives[i]);
    return count;
}

static const hand_drive *drive_of(const hand *model, size_t index)
{
    if (index < places(model)) return main_drive(model, index);
    index -= places(model);
    for (size_t i = 0; i < model->drive_count; i++)
        if (is_further(model, &model->drives[i]) && index-- == 0) return &model->drives[i];
    return NULL;
}

static const char *name_of(const void *things, size_t index)
{
    const hand *model = things;
    if (index >= places(model)) return drive_of(model, index)->name;
    return index < model->joint_count ? model->joints[index].name : model->tendons[index - model->joint_count].name;
}

static const char *name_of_drive(const void *things, size_t index)
{
    const hand_drive *drive = drive_of(things, index);
    return drive ? drive->name : NULL;
}

/* A further drive whose name is that of a joint or tendon, too, is left as the file has it: the name is the other's. */
static bool has_own_name(const hand *model, size_t index)
{
    for (size_t i = 0; index >= places(model) && i < places(model); i++)
        if (strcmp(name_of(model, i), name_of(model, index)) == 0) return false;
    return true;
}

/* A file that names its drives says what is driven. Of one without drives all joints are that follow no other. What a
 * glob says is meant for one drive of each joint. */
static bool by_name_only(const void *things, size_t index)
{
    const hand *model = things;
    if (drive_of(model, index)) return index >= places(model);
    return model->drive_count > 0 || index >= model->joint_count || model->joints[index].coupling >= 0;
}

/* ---- What the file says. ---- */

static double larger_bound(double least, double most)
{
    return fmax(fabs(least), fabs(most));
}

/* The largest force that the file allows the drive on its joint or tendon; NULL: a drive of the scene's own. */
static double file_max_force(const hand *model, const hand_drive *drive, const scene_control *c)
{
    double most = INFINITY;
    if (c->joint >= 0)
        most = larger_bound(model->joints[c->joint].least_effort, model->joints[c->joint].effort);
    else
        most = larger_bound(model->tendons[c->tendon].least_effort, model->tendons[c->tendon].effort);
    if (drive) most = fmin(most, fabs(drive->gear) * larger_bound(drive->least_force, drive->most_force));
    if (drive && drive->type == HAND_MOTOR)
        most = fmin(most, fabs(drive->gear * drive->gain) * larger_bound(drive->least_control, drive->most_control));
    return most > 0 ? most : INFINITY;
}

static double within(double value, double least, double most)
{
    return fmin(fmax(value, least), most);
}

/* Turns a range of what goes through a gear into that behind it. A gear of 0 leaves it open. */
static void range_behind(double gear, double least, double most, double range[2])
{
    range[0] = gear == 0 ? -INFINITY : fmin(gear * least, gear * most) + 0.0; /* not -0 */
    range[1] = gear == 0 ? INFINITY : fmax(gear * least, gear * most) + 0.0;
}

/* Sets the bounds of the force to what the file allows: the actuator's range first, then that of its joint or tendon.
 */
static void bound_by_file(const hand *model, const hand_drive *drive, scene_control *c)
{
    double range[2] = {-INFINITY, INFINITY};
    const hand_joint *joint = c->joint >= 0 ? &model->joints[c->joint] : NULL;
    const hand_tendon *tendon = joint ? NULL : &model->tendons[c->tendon];
    double least = joint ? joint->least_effort : tendon->least_effort;
    double most = joint ? joint->effort : tendon->effort;
    if (drive) range_behind(drive->gear, drive->least_force, drive->most_force, range);
    c->max_force = file_max_force(model, drive, c);
    c->least_force = within(within(range[0], least, most), -c->max_force, c->max_force);
    c->most_force = within(within(range[1], least, most), -c->max_force, c->max_force);
}

double scene_control_middle(const scene_control *c)
{
    return c->least_force == -c->most_force ? 0 : 0.5 * (c->least_force + c->most_force);
}

/* What a drive moves when it moves its joint or tendon by one unit: MuJoCo's rule for a damping ratio. */
static double moved_mass(const hand *model, const scene_control *c)
{
    if (c->joint >= 0) return hand_moved_inertia(model, c->joint);
    double mass = 0;
    const hand_tendon *tendon = &model->tendons[c->tendon];
    for (size_t i = 0; i < tendon->count; i++)
        mass += hand_moved_inertia(model, tendon->joints[i]) / (tendon->coefficients[i] * tendon->coefficients[i]);
    return mass;
}

/* Finds the torques that the ends of the range of control give, or the positions or velocities at which the drive's
 * force is 0 there. Where the gain is 0, no control moves the drive, and these are one. */
static void bound_targets(const hand_drive *drive, scene_control *c)
{
    double range[2];
    if (c->type == SCENE_TORQUE_CONTROL) {
        bool fixed = drive->gear * drive->gain == 0;
        range_behind(drive->gear * drive->gain, drive->least_control, drive->most_control, range);
        c->least_target = fixed ? 0 : range[0];
        c->most_target = fixed ? 0 : range[1];
        return;
    }
    double slope = -drive->bias[c->type == SCENE_POSITION_CONTROL ? 1 : 2] * drive->gear;
    if (slope == 0) return;
    bool fixed = drive->gain == 0;
    double a = ((fixed ? 0 : drive->gain * drive->least_control) + drive->bias[0]) / slope;
    double b = ((fixed ? 0 : drive->gain * drive->most_control) + drive->bias[0]) / slope;
    c->least_target = fmin(a, b);
    c->most_target = fmax(a, b);
}

/* Of an actuator that pulls to no place, gain * control is the target, the torque; its constant and its damping act
 * beside that. */
static scene_control_type type_of(const hand_drive *drive)
{
    if (has_place(drive)) return SCENE_POSITION_CONTROL;
    return drive->type == HAND_VELOCITY ? SCENE_VELOCITY_CONTROL : SCENE_TORQUE_CONTROL;
}

static void control_from_file(const hand *model, const hand_drive *drive, scene_control *c)
{
    double square = drive->gear * drive->gear;
    c->type = type_of(drive);
    bound_by_file(model, drive, c);
    c->kp = c->type == SCENE_POSITION_CONTROL ? square * drive->kp : 0;
    c->kd = square * drive->kd;
    if (c->type == SCENE_POSITION_CONTROL && drive->damping_ratio > 0)
        c->kd = 2 * drive->damping_ratio * sqrt(c->kp * moved_mass(model, c));
    c->bias = c->type == SCENE_TORQUE_CONTROL ? drive->gear * drive->bias[0] : 0;
    bound_targets(drive, c);
}

/* ---- The rules. ---- */

static bool read_target_point(const scene_node *node, double earliest, scene_target *point)
{
    double numbers[2];
    if (!scene_read_numbers(node, 2, SCENE_ANY_NUMBER, "", numbers)) return false;
    scene_node time = scene_element(node, 0);
    if (!(numbers[0] >= earliest)) return scene_refuse(&time, "a time not before %g s", earliest);
    *point = (scene_target){numbers[0], numbers[1]};
    return true;
}

static bool read_target(const scene_node *rule, scene_control *c)
{
    scene_node node = scene_member(rule, "target");
    if (!node.value) return true;
    bool list = json_is_array(node.value);
    if (!list && !json_is_number(node.value)) return scene_refuse(&node, "a number or a list of [time, value]");
    size_t count = list ? json_array_size(node.value) : 1;
    if (!count) return scene_refuse(&node, "a list of at least one [time, value]");
    scene_target *target = calloc(count, sizeof *target);
    if (!target) return scene_refuse_memory(rule->reader);
    free(c->target);
    c->target = target;
    c->target_count = count;
    if (!list) return scene_read_number(rule, "target", SCENE_ANY_NUMBER, "", &target->value);
    for (size_t i = 0; i < count; i++) {
        scene_node point = scene_element(&node, i);
        if (!read_target_point(&point, i ? target[i - 1].time : 0, &target[i])) return false;
    }
    return true;
}

/* What the scene says counts in place of the file's range. */
static bool read_max_force(const scene_node *rule, scene_control *c)
{
    if (!scene_member(rule, "max_force").value) return true;
    if (!scene_read_number(rule, "max_force", SCENE_POSITIVE, "N m or N", &c->max_force)) return false;
    c->least_force = -c->max_force;
    c->most_force = c->max_force;
    return true;
}

/* Another type than before has none of its gains. The file's range of control and its constant come back with the type
 * that the file has. */
static void begin_anew(const hand *model, const hand_drive *drive, scene_control_type type, scene_control *c)
{
    scene_control of_file = {.joint = c->joint, .tendon = c->tendon};
    if (drive) control_from_file(model, drive, &of_file);
    bool known = of_file.type == type;
    c->type = type;
    c->kp = c->kd = 0;
    c->bias = known ? of_file.bias : 0;
    c->least_target = known ? of_file.least_target : -INFINITY;
    c->most_target = known ? of_file.most_target : INFINITY;
    bound_by_file(model, drive, c);
    free(c->target);
    c->target = NULL;
    c->target_count = 0;
}

/* A rule of the same type goes on with what less specific ones have said; one of another type begins anew. */
static bool read_rule(const scene_node *rule, const hand *model, const hand_drive *drive, scene_control *c)
{
    scene_node type = scene_member(rule, "type");
    int number = c->type - SCENE_POSITION_CONTROL;
    if (!scene_check_object(rule, "control", NULL) || !scene_read_name(rule, "type", control_names, 3, &number))
        return false;
    if (!type.value && c->type == SCENE_UNDRIVEN) return scene_refuse(&type, "position, torque or velocity");
    if (number + SCENE_POSITION_CONTROL != (int)c->type)
        begin_anew(model, drive, (scene_control_type)(number + SCENE_POSITION_CONTROL), c);
    return scene_read_number(rule, "kp", SCENE_NOT_NEGATIVE, "N m/rad or N/m", &c->kp) &&
           scene_read_number(rule, "kd", SCENE_NOT_NEGATIVE, "N m s/rad or N s/m", &c->kd) && read_max_force(rule, c) &&
           read_target(rule, c);
}

static bool check_gains(const scene_node *rules, const char *key, const scene_control *c)
{
    scene_node rule = scene_member(rules, key), kp = scene_member(&rule, "kp"), kd = scene_member(&rule, "kd");
    if (c->type == SCENE_POSITION_CONTROL && !(c->kp > 0))
        return scene_refuse(&kp, "a number > 0 (position control of %s)", c->name);
    if (c->type == SCENE_VELOCITY_CONTROL && !(c->kd > 0))
        return scene_refuse(&kd, "a number > 0 (velocity control of %s)", c->name);
    return true;
}

/* Without a target a position stays where it starts, unless no control moves it, and the control of other drives is 0,
 * or what is nearest to it in their range. */
static bool complete_target(const scene_node *node, const scene_hand *h, scene_control *c)
{
    if (c->type == SCENE_UNDRIVEN || c->target_count > 0) return true;
    if (c->type == SCENE_POSITION_CONTROL && c->least_target < c->most_target) {
        c->least_target = -INFINITY;
        c->most_target = INFINITY;
    }
    c->target = calloc(1, sizeof *c->target);
    if (!c->target) return scene_refuse_memory(node->reader);
    c->target_count = 1;
    if (c->type != SCENE_POSITION_CONTROL) return true;
    if (c->joint >= 0) c->target->value = h->start[c->joint];
    const hand_tendon *tendon = c->tendon >= 0 ? &h->model->tendons[c->tendon] : NULL;
    for (size_t i = 0; tendon && i < tendon->count; i++)
        c->target->value += tendon->coefficients[i] * h->start[tendon->joints[i]];
    return true;
}

bool scene_read_controls(const scene_node *node, scene_hand *h)
{
    const hand *model = h->model;
    scene_node list = scene_member(node, "control");
    size_t count = places(model) + further_drives(model);
    scene_rules rules = {model, count, name_of, name_of_drive, by_name_only, "joint, tendon or actuator"};
    h->controls = calloc(count + 1, sizeof *h->controls);
    if (!h->controls) return scene_refuse_memory(node->reader);
    h->control_count = count;
    if (list.value && !json_is_object(list.value)) return scene_refuse(&list, "an object: drives by names of joints");
    if (list.value && !scene_rules_check(&list, &rules)) return false;
    for (size_t i = 0; i < count; i++) {
        scene_control *c = &h->controls[i];
        const hand_drive *drive = drive_of(model, i);
        size_t place = i < places(model) ? i : place_of(model, drive);
        bool is_joint = place < model->joint_count;
        *c = (scene_control){.joint = is_joint ? (int)place : -1,
                             .tendon = is_joint ? -1 : (int)(place - model->joint_count),
                             .name = name_of(model, i),
                             .max_force = INFINITY,
                             .least_force = -INFINITY,
                             .most_force = INFINITY,
                             .least_target = -INFINITY,
                             .most_target = INFINITY};
        if (drive) control_from_file(model, drive, c);
        const char *last = NULL;
        bool ruled = list.value && has_own_name(model, i);
        for (const char *key = NULL; ruled && (key = scene_rule_after(&list, &rules, i, key)); last = key) {
            scene_node rule = scene_member(&list, key);
            if (!read_rule(&rule, model, drive, c)) return false;
        }
        if ((last && !check_gains(&list, last, c)) || !complete_target(node, h, c)) return false;
    }
    return true;
}

double scene_target_at(const scene_control *c, double t)
{
    if (c->target_count == 0) return 0;
    size_t i = scene_latest(&c->target->time, sizeof *c->target, c->target_count, t);
    const scene_target *now = &c->target[i];
    double value = now->value;
    if (i + 1 < c->target_count && t > now->time)
        value += (t - now->time) / (now[1].time - now->time) * (now[1].value - now->value);
    return within(value, c->least_target, c->most_target);
}

/* ---- The contacts of the links. ---- */

static const double LINK_STIFFNESS = 1e5; /* N/m */
static const double LINK_FRICTION = 0.5;

/* Has a link something that can touch? -1: what is fixed to the frame of the hand. */
static const hand_geom *geom_of(const hand *model, int link)
{
    for (size_t i = 0; i < model->geom_count; i++)
        if (model->geoms[i].collides && model->geoms[i].link == link) return &model->geoms[i];
    return NULL;
}

static const char *name_of_link(const void *things, size_t index)
{
    const scene_hand *h = things;
    return h->link_of[index] < 0 ? "world" : h->model->links[h->link_of[index]].name;
}

static bool add_link(const scene_node *node, scene_hand *h, int link, bool full_name)
{
    const hand_geom *geom = geom_of(h->model, link);
    if (!geom) return true;
    double friction = geom->friction[0] >= 0 ? geom->friction[0] : LINK_FRICTION;
    scene_finger *f = &h->links[h->link_count];
    h->link_of[h->link_count++] = link;
    const char *name = name_of_link(h, h->link_count - 1);
    *f = (scene_finger){.model = SCENE_HARD,
                        .stiffness = {.normal = LINK_STIFFNESS, .tangential = 2.0 / 3.0 * LINK_STIFFNESS},
                        .friction = {friction, friction},
                        .torsional_friction = fmax(geom->friction[1], 0),
                        .max_force = INFINITY,
                        .damage_max_force = INFINITY,
                        .damage_max_slip = INFINITY};
    size_t size = strlen(h->name) + strlen(name) + 2;
    f->name = malloc(size);
    if (!f->name) return scene_refuse_memory(node->reader);
    snprintf(f->name, size, "%s%s%s", full_name ? h->name : "", full_name ? "/" : "", name);
    return true;
}

static bool complete_contact(const scene_node *list, const char *key, scene_finger *f)
{
    scene_node rule = scene_member(list, key);
    if (f->model == SCENE_SOFT) {
        scene_node stiffness = scene_member(&rule, "stiffness"), torsional = scene_member(&stiffness, "torsional");
        return f->stiffness.torsional > 0 || scene_refuse(&torsional, "a number > 0 (N m/rad) (soft link)");
    }
    f->stiffness.torsional = f->damping.torsional = f->torsional_friction = 0;
    if (f->model == SCENE_FRICTIONLESS) f->friction = (scene_friction){0, 0};
    return true;
}

bool scene_read_link_contacts(const scene_node *node, scene_hand *h, bool full_names)
{
    const hand *model = h->model;
    scene_node list = scene_member(node, "contacts");
    h->links = calloc(model->link_count + 1, sizeof *h->links);
    h->link_of = calloc(model->link_count + 1, sizeof *h->link_of);
    if (!h->links || !h->link_of) return scene_refuse_memory(node->reader);
    for (int i = 0; i <= (int)model->link_count; i++)
        if (!add_link(node, h, i < (int)model->link_count ? i : -1, full_names)) return false;
    scene_rules rules = {h, h->link_count, name_of_link, NULL, NULL, "link that can touch something"};
    if (list.value && !json_is_object(list.value)) return scene_refuse(&list, "an object: contacts by names of links");
    if (list.value && !scene_rules_check(&list, &rules)) return false;
    for (size_t i = 0; i < h->link_count; i++) {
        const char *last = NULL;
        for (const char *key = NULL; list.value && (key = scene_rule_after(&list, &rules, i, key)); last = key) {
            scene_node rule = scene_member(&list, key);
            if (!scene_read_link_contact(&rule, &h->links[i])) return false;
        }
        if (last ? !complete_contact(&list, last, &h->links[i]) : false) return false;
        if (!last) h->links[i].torsional_friction = 0;
    }
    return true;
}
