/* Actuators: what they act on, and force = gain * control + bias. */

#include "mjcf.h"

static const char tags[] = "general motor position velocity";
static const char attributes[] =
    "name class group ctrlrange user lengthrange gear joint jointinparent tendon ctrllimited forcelimited actlimited "
    "forcerange actrange actdim dyntype gaintype biastype dynprm gainprm biasprm actearly inheritrange kp kv dampratio "
    "timeconst";

/* What the levels of an actuator add up to. */
typedef struct actuator {
    double gain, bias[3];
    int gain_type, bias_type, dynamics; /* 0: fixed, none and none; bias 1: affine; others are not supported */
    double inherit;
} actuator;

static void apply_general(const mjcf_element *level, actuator *a)
{
    double gain[10] = {a->gain}, bias[10] = {a->bias[0], a->bias[1], a->bias[2]};
    mjcf_numbers(level, "gainprm", gain, 1, 10);
    mjcf_numbers(level, "biasprm", bias, 1, 10);
    a->gain = gain[0];
    scene_copy(bias, a->bias);
    a->gain_type = mjcf_word(level, "gaintype", "fixed affine muscle user dcmotor so3 pid", a->gain_type);
    a->bias_type = mjcf_word(level, "biastype", "none affine muscle user dcmotor so3 pid", a->bias_type);
    a->dynamics =
        mjcf_word(level, "dyntype", "none integrator filter filterexact muscle user dcmotor pid", a->dynamics);
}

/* As MuJoCo has it: kp replaces gain and bias[1], and a damping ratio is kept as a positive bias[2]. */
static void apply_position(const mjcf_element *level, actuator *a)
{
    hand_reader *r = level->m->r;
    double kv = 0, ratio = 0, time = 0;
    reader_number(r, level->node, "kp", &a->gain);
    bool has_kv = reader_number(r, level->node, "kv", &kv);
    bool has_ratio = reader_number(r, level->node, "dampratio", &ratio);
    if (has_kv && has_ratio) reader_refuse(r, level->node, "expected either kv or dampratio");
    if (kv < 0 || ratio < 0) reader_refuse(r, level->node, "expected kv and dampratio that are not negative");
    if (has_kv) a->bias[2] = -kv;
    if (has_ratio) a->bias[2] = ratio;
    if (reader_number(r, level->node, "timeconst", &time) && time != 0) a->dynamics = 3;
    reader_number(r, level->node, "inheritrange", &a->inherit);
    a->bias[1] = -a->gain;
    a->gain_type = 0;
    a->bias_type = 1;
}

static void apply(mjcf *m, const xmlNode *node, actuator *a)
{
    mjcf_element level = mjcf_alone(m, node);
    apply_general(&level, a);
    if (xml_is(node, "motor")) {
        *a = (actuator){.gain = 1, .inherit = a->inherit};
    } else if (xml_is(node, "position")) {
        apply_position(&level, a);
    } else if (xml_is(node, "velocity")) {
        reader_number(m->r, node, "kv", &a->gain);
        a->bias[0] = a->bias[1] = 0;
        a->bias[2] = -a->gain;
        a->gain_type = a->dynamics = 0;
        a->bias_type = 1;
    }
}

/* Which of the simple drives it is. */
static void classify(const actuator *a, hand_drive *drive)
{
    const double *b = a->bias;
    drive->gain = a->gain;
    if (a->bias_type == 0) {
        drive->type = HAND_MOTOR;
        return;
    }
    scene_copy(b, drive->bias);
    drive->type = HAND_AFFINE;
    drive->kp = fmax(0, -b[1]);
    drive->kd = fmax(0, -b[2]);
    if (b[1] == -a->gain && a->gain > 0) {
        if (b[0] == 0) drive->type = HAND_POSITION;
        drive->damping_ratio = fmax(0, b[2]);
        if (b[2] > 0) drive->bias[2] = 0;
    } else if (b[0] == 0 && b[1] == 0 && b[2] == -a->gain) {
        drive->type = HAND_VELOCITY;
    }
}

/* A drive here pulls to a place and resists motion, or does neither. */
static void list_unstable_terms(hand_reader *r, const xmlNode *node, const hand_drive *drive)
{
    if (drive->bias[1] > 0) reader_unmodelled(r, node, "length term of an actuator that pushes away from a place");
    if (drive->bias[2] > 0) reader_unmodelled(r, node, "speed term of an actuator that drives motion on");
}

/* False where the actuator acts on something that is not modelled, or after an error. */
static bool read_target(mjcf *m, const xmlNode *node, hand_drive *drive)
{
    hand_reader *r = m->r;
    const char *joint = xml_text(node, "joint") ? "joint" : "jointinparent", *tendon = xml_text(node, "tendon");
    drive->joint = drive->tendon = -1;
    if (xml_text(node, joint)) {
        drive->joint = reader_refer(r, node, joint, "joint");
    } else if (tendon && reader_find(r, "spatial", tendon) >= 0) {
        reader_unmodelled(r, node, "actuator of a spatial tendon");
        return false;
    } else if (tendon) {
        drive->tendon = reader_refer(r, node, "tendon", "tendon");
    } else {
        reader_refuse(r, node, "expected a joint or a tendon that it acts on");
    }
    return r->status == HAND_OK;
}

static void read_ranges(const mjcf_element *e, double inherit, hand_drive *drive)
{
    double control[2] = {0}, force[2] = {0};
    bool has_control = mjcf_numbers(e, "ctrlrange", control, 2, 2) > 0;
    bool has_force = mjcf_numbers(e, "forcerange", force, 2, 2) > 0;
    const hand_joint *joint = drive->joint < 0 ? NULL : &e->m->r->h->joints[drive->joint];
    if (inherit > 0) { /* the range of the joint, scaled about its middle */
        if (!joint || !joint->limited || (has_control && control[0] != control[1])) {
            reader_refuse(e->m->r, e->node, "expected a joint with a range, and no ctrlrange, beside inheritrange");
            return;
        }
        double middle = 0.5 * (joint->lower + joint->upper), half = 0.5 * inherit * (joint->upper - joint->lower);
        control[0] = middle - half;
        control[1] = middle + half;
        has_control = true;
    }
    bool limited = mjcf_is_limited(e, "ctrllimited", has_control, control);
    drive->least_control = limited ? control[0] : -INFINITY;
    drive->most_control = limited ? control[1] : INFINITY;
    limited = mjcf_is_limited(e, "forcelimited", has_force, force);
    drive->least_force = limited ? force[0] : -INFINITY;
    drive->most_force = limited ? force[1] : INFINITY;
}

static void add_drive(mjcf *m, const mjcf_element *e, const actuator *a)
{
    hand_reader *r = m->r;
    hand *h = r->h;
    hand_drive own = {.line = (int)xmlGetLineNo(e->node)};
    double gear[6] = {1, 0, 0, 0, 0, 0};
    if (a->gain_type != 0 || a->bias_type > 1 || a->dynamics != 0) {
        reader_refuse(r, e->node, "expected an actuator with gaintype fixed, biastype none or affine and no dynamics");
        return;
    }
    if (!read_target(m, e->node, &own)) return;
    mjcf_numbers(e, "gear", gear, 1, 6);
    own.gear = gear[0];
    classify(a, &own);
    list_unstable_terms(r, e->node, &own);
    read_ranges(e, a->inherit, &own);
    own.name = reader_name(r, e->node, "actuator", h->drive_count);
    hand_drive *drive = reader_append(r, &h->drives, &h->drive_count, sizeof *drive);
    if (drive) *drive = own;
}

/* The number of a configuration of a plugin's instance; 0 where it is not there. */
static double plugin_number(mjcf *m, const char *instance, const char *key)
{
    double value = 0;
    for (const xmlNode *s = xml_child(m->root, "extension"); s; s = xml_next(s, "extension"))
        for (const xmlNode *p = xml_child(s, "plugin"); p; p = xml_next(p, "plugin"))
            for (const xmlNode *i = xml_child(p, "instance"); i; i = xml_next(i, "instance"))
                for (const xmlNode *c = xml_child(i, "config"); c; c = xml_next(c, "config"))
                    if (xml_text(i, "name") && strcmp(xml_text(i, "name"), instance) == 0 && xml_text(c, "key") &&
                        strcmp(xml_text(c, "key"), key) == 0)
                        reader_number(m->r, c, "value", &value);
    return value;
}

/* MuJoCo's PID plugin: its proportional and differential parts are a position drive. */
static void read_plugin(mjcf *m, const xmlNode *node)
{
    const char *plugin = xml_text(node, "plugin"), *instance = xml_text(node, "instance");
    mjcf_element e;
    if (!plugin || strcmp(plugin, "mujoco.pid") != 0 || !instance) {
        reader_unmodelled(m->r, node, "actuator by a plugin");
        return;
    }
    if (!mjcf_open(m, node, NULL, "general", &e)) return;
    double kp = plugin_number(m, instance, "kp"), kd = plugin_number(m, instance, "kd");
    if (plugin_number(m, instance, "ki") != 0) reader_unmodelled(m->r, node, "integral part of mujoco.pid");
    if (plugin_number(m, instance, "slewmax") != 0) reader_unmodelled(m->r, node, "slewmax of mujoco.pid");
    add_drive(m, &e, &(actuator){.gain = kp, .bias = {0, -kp, -kd}, .bias_type = 1});
}

void mjcf_read_actuators(mjcf *m, const xmlNode *section)
{
    hand_reader *r = m->r;
    for (const xmlNode *n = xml_child(section, NULL); n && r->status == HAND_OK; n = xml_next(n, NULL)) {
        mjcf_element e;
        actuator a = {.gain = 1};
        if (xml_is(n, "plugin")) {
            read_plugin(m, n);
            continue;
        }
        if (!xml_listed(tags, (const char *)n->name)) {
            reader_refuse(r, n, "not supported in <actuator>; there are %s", tags);
            return;
        }
        if (!mjcf_open(m, n, NULL, tags, &e) || !mjcf_only(&e, attributes)) return;
        for (int i = 0; i < e.count; i++) apply(m, e.levels[i], &a);
        if (r->status == HAND_OK) add_drive(m, &e, &a);
    }
}
