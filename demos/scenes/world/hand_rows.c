/*
 * What acts on the joints of a hand besides stops: springs, dampers, armature, dry friction, mimics, tendons, drives.
 *
 * Pinch gets them as rows. A spring k to s, a damper d and an armature a of a joint are one law without a bound: over a
 * step of h the armature resists with a (q' - q'+) / h, which is a damper a/h about the rate q' of the start. Dry
 * friction is a motor at rest of limited force. ODE's own solvers get motors for all of these.
 */
#include "world_hand.h"

#include "common/vector.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static bool is_passive(const hand_joint *j)
{
    return j->stiffness > 0 || j->damping > 0 || j->armature > 0;
}

static world_status couple(world *w, const pinch_coupling_term *terms, int count, const pinch_servo *law, int *number)
{
    return pinch_ode_couple(w->plugin, terms, count, law, number) == PINCH_OK ? WORLD_OK : WORLD_NO_MEMORY;
}

static world_status add_damper(world *w, world_joint *j)
{
    pinch_servo law = pinch_default_servo();
    pinch_coupling_term term = {j->joint, 0, 1};
    law.kp = j->of->stiffness;
    law.kd = j->of->damping + j->of->armature / w->scene->step;
    law.target = j->of->spring_reference - j->zero;
    return couple(w, &term, 1, &law, &j->damper);
}

/* ODE gets spring and damper as a motor about the joint's axis. */
static void add_ode_damper(world *w, world_joint *j)
{
    bool hinge = j->of->type == HAND_HINGE;
    if (!(j->of->stiffness > 0 || world_ode_damping(j) > 0)) return;
    j->motor = hinge ? dJointCreateAMotor(w->ode, NULL) : dJointCreateLMotor(w->ode, NULL);
    dJointAttach(j->motor, j->body, j->parent);
    dVector3 axis;
    if (hinge) {
        dJointGetHingeAxis(j->joint, axis);
        dJointSetAMotorNumAxes(j->motor, 1);
        dJointSetAMotorAxis(j->motor, 0, 2, axis[0], axis[1], axis[2]);
        dJointSetAMotorParam(j->motor, dParamFMax, dInfinity);
    } else {
        dJointGetSliderAxis(j->joint, axis);
        dJointSetLMotorNumAxes(j->motor, 1);
        dJointSetLMotorAxis(j->motor, 0, 2, axis[0], axis[1], axis[2]);
        dJointSetLMotorParam(j->motor, dParamFMax, dInfinity);
    }
}

/* Where an error of rounding would let a joint creep, ODE's softness of a motor is left out. */
static void add_friction(world_joint *j)
{
    void (*set)(dJointID, int, dReal) = j->of->type == HAND_HINGE ? dJointSetHingeParam : dJointSetSliderParam;
    if (!(j->of->friction > 0)) return;
    set(j->joint, dParamVel, 0);
    set(j->joint, dParamFMax, j->of->friction);
    set(j->joint, dParamCFM, 0);
}

static world_tie *new_tie(world_hand *h)
{
    world_tie *t = &h->ties[h->tie_count++];
    *t = (world_tie){.coupling = -1, .tendon = -1, .law = pinch_default_servo()};
    return t;
}

static void add_term(const world_hand *h, world_tie *t, int joint, double factor)
{
    t->joint[t->terms] = joint;
    t->factor[t->terms++] = factor;
    t->offset += factor * h->joints[joint].zero;
}

static world_status make_tie(world *w, const world_hand *h, world_tie *t)
{
    pinch_coupling_term terms[SCENE_TENDON_JOINTS];
    if (!w->plugin) return WORLD_OK;
    for (int i = 0; i < t->terms; i++) terms[i] = (pinch_coupling_term){h->joints[t->joint[i]].joint, 0, t->factor[i]};
    return couple(w, terms, t->terms, &t->law, &t->coupling);
}

/* position of `joint` - multiplier * position of `of` = offset */
static world_status add_mimic(world *w, world_hand *h, const hand_coupling *c)
{
    world_tie *t = new_tie(h);
    add_term(h, t, c->joint, 1);
    if (c->of >= 0 && c->multiplier != 0) add_term(h, t, c->of, -c->multiplier);
    t->law.kp = INFINITY;
    t->law.target = c->offset - t->offset;
    return make_tie(w, h, t);
}

static world_tie *new_tendon(world_hand *h, size_t index)
{
    const hand_tendon *tendon = &h->hand->model->tendons[index];
    world_tie *t = new_tie(h);
    t->tendon = (int)index;
    for (size_t i = 0; i < tendon->count; i++)
        if (tendon->coefficients[i] != 0) add_term(h, t, tendon->joints[i], tendon->coefficients[i]);
    return t;
}

/* What drives by torque needs no row but for its damping. */
static world_status add_drive(world *w, const world_hand *h, world_tie *t, const scene_control *control)
{
    t->control = control;
    t->law.kp = control->kp;
    t->law.kd = control->kd;
    t->law.max_force = control->most_force - scene_control_middle(control);
    return world_control_is_servo(control) ? make_tie(w, h, t) : WORLD_OK;
}

/* The forces of several drives add up, each within its own bound. */
static world_status add_further_drive(world *w, world_hand *h, const scene_control *control)
{
    world_tie *t = control->joint >= 0 ? new_tie(h) : new_tendon(h, (size_t)control->tendon);
    if (control->joint >= 0) add_term(h, t, control->joint, 1);
    t->is_further = true;
    return add_drive(w, h, t, control);
}

/* A drive, a spring with a damper, and dry friction are a tie each. */
static world_status add_tendon(world *w, world_hand *h, size_t index)
{
    const hand_tendon *tendon = &h->hand->model->tendons[index];
    const scene_control *control = &h->hand->controls[h->hand->model->joint_count + index];
    world_status status = WORLD_OK;
    if (control->type != SCENE_UNDRIVEN) status = add_drive(w, h, new_tendon(h, index), control);
    if (status == WORLD_OK && (tendon->stiffness > 0 || tendon->damping > 0)) {
        world_tie *t = new_tendon(h, index);
        t->dissipates = true;
        t->law.kp = tendon->stiffness;
        t->law.kd = tendon->damping;
        t->law.target = tendon->rest[0] - t->offset;
        status = make_tie(w, h, t);
    }
    if (status == WORLD_OK && tendon->friction > 0) {
        world_tie *t = new_tendon(h, index);
        t->dissipates = t->is_friction = true;
        t->law.kp = INFINITY;
        t->law.max_force = tendon->friction;
        status = make_tie(w, h, t);
    }
    return status;
}

world_status world_add_hand_rows(world *w, world_hand *h)
{
    const hand *model = h->hand->model;
    size_t places = model->joint_count + model->tendon_count, further = h->hand->control_count - places;
    world_status status = WORLD_OK;
    h->ties = calloc(model->coupling_count + 3 * model->tendon_count + further + 1, sizeof *h->ties);
    if (!h->ties) return WORLD_NO_MEMORY;
    for (int i = 0; i < h->joint_count && status == WORLD_OK; i++) {
        world_joint *j = &h->joints[i];
        if (!w->plugin)
            add_ode_damper(w, j);
        else if (is_passive(j->of))
            status = add_damper(w, j);
        add_friction(j);
    }
    for (size_t i = 0; i < model->coupling_count && status == WORLD_OK; i++)
        status = add_mimic(w, h, &model->couplings[i]);
    for (size_t i = 0; i < model->tendon_count && status == WORLD_OK; i++) status = add_tendon(w, h, i);
    for (size_t i = 0; i < further && status == WORLD_OK; i++)
        status = add_further_drive(w, h, &h->hand->controls[places + i]);
    return status;
}

static void report_part(const world *w, const world_hand *h, const char *name, const char *what,
                        void (*report)(void *context, const char *text), void *context)
{
    char text[256], *whole = world_name_of_hand(w, h, name);
    snprintf(text, sizeof text, "%s: %s", whole ? whole : name, what);
    free(whole);
    report(context, text);
}

/* Of a joint's main drive by torque, the joint's damper has the damping. */
static void report_damping_by_torque(const world *w, const world_hand *h,
                                     void (*report)(void *context, const char *text), void *context)
{
    const scene_hand *of = h->hand;
    for (size_t i = 0; i < of->control_count; i++) {
        const scene_control *c = &of->controls[i];
        bool main_of_joint = i < of->model->joint_count;
        if (c->type != SCENE_TORQUE_CONTROL || !(c->kd > 0) || (main_of_joint && isinf(c->max_force))) continue;
        report_part(w, h, c->name,
                    main_of_joint ? "a drive by torque, whose bound does not count its damping"
                                  : "damping of a drive by torque",
                    report, context);
    }
}

/* ODE's motors have the same bound both ways. */
static void report_bounds_of_motors(const world *w, const world_hand *h,
                                    void (*report)(void *context, const char *text), void *context)
{
    const scene_hand *of = h->hand;
    for (size_t i = 0; i < of->control_count; i++) {
        const scene_control *c = &of->controls[i];
        if (c->type != SCENE_TORQUE_CONTROL && c->type != SCENE_UNDRIVEN && c->least_force != -c->most_force)
            report_part(w, h, c->name, "a bound that is not the same both ways (its larger side)", report, context);
    }
}

/* MuJoCo bounds what all drives of a joint or tendon do together; here each has the bound for itself. */
static void report_drives(const world *w, const world_hand *h, void (*report)(void *context, const char *text),
                          void *context)
{
    const scene_hand *of = h->hand;
    size_t places = of->model->joint_count + of->model->tendon_count;
    for (size_t i = 0; i < places; i++) {
        const scene_control *first = &of->controls[i];
        const hand_joint *j = first->joint >= 0 ? &of->model->joints[first->joint] : NULL;
        const hand_tendon *t = j ? NULL : &of->model->tendons[first->tendon];
        double lower = j ? j->least_effort : t->least_effort, upper = j ? j->effort : t->effort;
        double least = first->least_force, most = first->most_force;
        int further = 0;
        for (size_t k = places; k < of->control_count; k++) {
            const scene_control *c = &of->controls[k];
            if (c->joint != first->joint || c->tendon != first->tendon) continue;
            least += c->least_force;
            most += c->most_force;
            further++;
            if (!w->plugin && c->type != SCENE_TORQUE_CONTROL)
                report_part(w, h, c->name, "a further drive of what has a motor", report, context);
        }
        if (further > 0 && (least < lower || most > upper))
            report_part(w, h, first->name, "the bound of all its drives together (each has it for itself)", report,
                        context);
    }
}

void world_hand_not_expressed(const world *w, void (*report)(void *context, const char *text), void *context)
{
    bool ode = !w->plugin;
    for (int k = 0; k < w->hand_count; k++) {
        const hand *model = w->hands[k].hand->model;
        char text[256];
        for (size_t i = 0; i < model->unmodelled_count; i++) {
            snprintf(text, sizeof text, "%s: %s of the file", w->hands[k].hand->name, model->unmodelled[i].what);
            report(context, text);
        }
        report_drives(w, &w->hands[k], report, context);
        if (ode) report_damping_by_torque(w, &w->hands[k], report, context);
        if (ode) report_bounds_of_motors(w, &w->hands[k], report, context);
        int bounded = 0;
        for (size_t i = 0; i < model->joint_count; i++) bounded += isfinite(model->joints[i].velocity);
        if (bounded > 0) {
            snprintf(text, sizeof text, "%s: velocity limits of %d joints", w->hands[k].hand->name, bounded);
            report(context, text);
        }
        for (size_t i = 0; i < model->tendon_count; i++) {
            if (!ode && !model->tendons[i].limited) continue;
            report_part(w, &w->hands[k], model->tendons[i].name,
                        ode ? "a tendon (motors of its joints share out its force)" : "limits of a tendon", report,
                        context);
        }
        for (int i = 0; i < w->hands[k].joint_count; i++) {
            const world_joint *j = &w->hands[k].joints[i];
            if (isfinite(j->of->upper - j->of->lower) && j->of->limited && j->of->type == HAND_HINGE &&
                j->of->upper - j->of->lower >= 2 * M_PI - 1e-3) {
                snprintf(text, sizeof text, "%s: stops a whole turn apart", j->name);
                report(context, text);
            }
            if (ode && j->of->armature > 0) {
                snprintf(text, sizeof text, "%s: armature", j->name);
                report(context, text);
            }
            if (ode && j->control->type == SCENE_POSITION_CONTROL) {
                snprintf(text, sizeof text, "%s: position control (a motor of limited force towards the target)",
                         j->name);
                report(context, text);
            }
            if (ode && j->of->friction > 0 && j->control->type != SCENE_UNDRIVEN) {
                snprintf(text, sizeof text, "%s: dry friction beside a motor", j->name);
                report(context, text);
            }
        }
        for (size_t i = 0; ode && i < model->coupling_count; i++) {
            report_part(w, &w->hands[k], model->joints[model->couplings[i].joint].name,
                        "a rigid tie to another joint (a motor follows it)", report, context);
        }
    }
}
