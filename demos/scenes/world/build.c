/* From a scene to ODE bodies, geoms and joints. */
#include "world_hand.h"

#include "common/vector.h"
#include "scenes/grasp.h"
#include "scenes/shape/shape.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ODE has no massless force control. A slider with this part of the object's mass stands in. */
static const double STAND_IN_MASS = 0.01;
/* A force-controlled tip starts this far inside the object (over its size), so that collision detection sees the touch.
 */
static const double FORCE_CONTROL_OVERLAP = 1e-5;

world_settings world_default_settings(const scene *s)
{
    world_settings settings = {.contact_solver = WORLD_PINCH, .quickstep_iterations = 20};
    settings.points = pinch_ode_default_settings().manifold_points;
    settings.solver = pinch_default_solver_settings();
    settings.solver.solver = s->solver.name;
    settings.solver.tolerance = s->solver.tolerance;
    settings.solver.goal = fmin(settings.solver.goal, s->solver.tolerance);
    settings.solver.max_iterations = s->solver.max_iterations;
    if (s->solver.formulation == SCENE_LCP) settings.faces = s->dimension == 2 ? 2 : s->solver.pyramid_faces;
    return settings;
}

/* ---- Bodies, joints and materials. ---- */

static bool is_kinematic(const scene_finger *finger)
{
    return finger->drive.type != SCENE_DRIVE_SLIDER;
}

static void set_mass(dBodyID body, double total, const double inertia[9], double scale)
{
    dMass mass;
    dMassSetZero(&mass);
    mass.mass = total;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) mass.I[4 * i + j] = scale * inertia[3 * i + j];
    dBodySetMass(body, &mass);
}

static pinch_material environment_material(const scene_environment *e)
{
    pinch_material m = {
        .model = e->friction.static_ > 0 ? PINCH_CONTACT_HARD : PINCH_CONTACT_FRICTIONLESS,
        .stiffness = {e->stiffness.normal, e->stiffness.tangential, 0},
        .damping = {e->damping.normal, e->damping.tangential, 0},
        .friction = e->friction.static_,
        .friction_kinetic = e->friction.kinetic,
        .max_force = INFINITY,
    };
    return m;
}

static bool hand_moves(const scene *s)
{
    for (size_t i = 0; i < s->entry_count; i++) {
        for (int c = SCENE_HAND_TRANSLATION; c <= SCENE_HAND_ROTATION; c++) {
            const double *v = s->schedule[i].channels[c].value;
            if (v[0] != 0 || v[1] != 0 || v[2] != 0) return true;
        }
    }
    return false;
}

/* The slider's damping is a motor that wants to stand still with the compliance 1/damping. It pulls back with damping
 * times speed, implicitly. */
static dJointID make_slider(world *w, dBodyID body, dBodyID rail, const double axis[3], double damping)
{
    dJointID slider = dJointCreateSlider(w->ode, NULL);
    dJointAttach(slider, body, rail);
    dJointSetSliderAxis(slider, axis[0], axis[1], axis[2]);
    if (damping > 0) {
        dJointSetSliderParam(slider, dParamVel, 0);
        dJointSetSliderParam(slider, dParamCFM, 1 / damping);
        dJointSetSliderParam(slider, dParamFMax, dInfinity);
    }
    if (w->plugin) world_keep_status(w, pinch_ode_note_joint(w->plugin, slider));
    return slider;
}

static world_status add_finger(world *w, const scene_finger *f)
{
    world_finger *finger = &w->fingers[w->finger_count];
    double position[3], orientation[4];
    scene_base_pose(w->scene, f, 0, position, orientation);
    bool stand_in = f->has_normal_force && w->settings.contact_solver != WORLD_PINCH;
    if (f->has_normal_force)
        for (int i = 0; i < 3; i++)
            position[i] += FORCE_CONTROL_OVERLAP * w->scene->objects[0].shape.bounding_radius * f->normal[i];
    finger->finger = f;
    finger->state.least_margin = NAN;
    finger->tip = world_make_geom(&f->tip);
    if (!finger->tip) return WORLD_NO_MEMORY;
    w->finger_count++;
    finger->body = world_make_body(w, position, orientation);
    dGeomSetBody(finger->tip, finger->body);
    memcpy(finger->state.point, f->point, sizeof finger->state.point);

    if (is_kinematic(f) && !stand_in) {
        dBodySetKinematic(finger->body);
    } else {
        double mass = stand_in ? STAND_IN_MASS * w->scene->objects[0].mass : f->drive.u.slider.mass;
        set_mass(finger->body, mass, f->tip.unit_inertia, mass);
        dBodySetGravityMode(finger->body, !stand_in && f->drive.u.slider.gravity);
        if (hand_moves(w->scene)) {
            finger->rail = world_make_body(w, position, orientation);
            dBodySetKinematic(finger->rail);
        }
        finger->slider =
            make_slider(w, finger->body, finger->rail, f->normal, stand_in ? 0 : f->drive.u.slider.damping);
        if (finger->rail) dJointSetFeedback(finger->slider, &finger->slider_feedback);
    }
    pinch_material material = world_finger_material(f);
    return world_add_geom(w, finger->tip, &material, w->finger_count - 1);
}

static world_status add_environment(world *w, const scene_environment *e)
{
    dGeomID geom = world_make_geom(&e->shape);
    if (!geom) return WORLD_NO_MEMORY;
    dGeomSetPosition(geom, e->position[0], e->position[1], e->position[2]);
    dGeomSetQuaternion(geom, e->orientation);
    pinch_material material = environment_material(e);
    world_status status = world_add_geom(w, geom, &material, -1);
    if (status != WORLD_OK) dGeomDestroy(geom);
    return status;
}

/* Where two objects meet that are not said to be of anything, they are of this. */
static pinch_material object_material(const scene_object *o)
{
    static const double STIFFNESS = 1e5, FRICTION = 0.5; /* N/m */
    scene_environment as = {.stiffness = {.normal = STIFFNESS, .tangential = 2.0 / 3.0 * STIFFNESS},
                            .friction = {FRICTION, FRICTION}};
    if (o->has_material)
        as = (scene_environment){.stiffness = o->stiffness, .damping = o->damping, .friction = o->friction};
    return environment_material(&as);
}

static world_status add_object(world *w, const scene_object *o)
{
    world_object *object = &w->objects[w->object_count];
    object->geom = world_make_geom(&o->shape);
    if (!object->geom) return WORLD_NO_MEMORY;
    w->object_count++;
    object->body = world_make_body(w, o->position, o->orientation);
    if (!object->body) return WORLD_NO_MEMORY;
    set_mass(object->body, o->mass, o->inertia, 1);
    dGeomSetBody(object->geom, object->body);
    object->material = object_material(o);
    if (w->plugin && o->has_material && pinch_ode_set_material(w->plugin, object->geom, &object->material) != PINCH_OK)
        return WORLD_NO_MEMORY;
    if (w->object_count > 1) return WORLD_OK;
    w->object = object->body;
    w->object_geom = object->geom;
    if (w->scene->dimension == 2) {
        w->plane = dJointCreatePlane2D(w->ode, NULL);
        dJointAttach(w->plane, w->object, NULL);
        if (w->plugin) world_keep_status(w, pinch_ode_note_joint(w->plugin, w->plane));
    }
    return WORLD_OK;
}

static bool create_plugin(world *w)
{
    pinch_ode_settings settings = pinch_ode_default_settings();
    bool pinch = w->settings.contact_solver == WORLD_PINCH;
    if (!pinch && !w->settings.manifolds) return true;
    settings.solver = w->settings.solver;
    settings.faces = w->settings.faces;
    settings.manifold_points = w->settings.points;
    settings.cold_start = w->settings.cold_start;
    settings.recorder = pinch ? w->settings.recorder : NULL;
    settings.recorder_context = w->settings.recorder_context;
    settings.record_all = w->settings.record_all;
    settings.ode_solves = !pinch;
    settings.keep_islands = pinch; /* for the energy ledger, and for the exact answer */
    /* under quickstep Pinch solves the joints of fingers that touch nothing, too, so that the ledger has their works */
    bool quickstep = w->settings.contact_solver == WORLD_QUICKSTEP || (pinch && w->scene->hand_count > 0);
    if (quickstep) settings.stepper = PINCH_ODE_QUICKSTEP;
    return pinch_ode_create(w->ode, &settings, pinch ? &w->plugin : &w->manifolds) == PINCH_OK;
}

static world_status build(world *w)
{
    const scene *s = w->scene;
    size_t geoms = s->finger_count + s->environment_count, fingers = s->finger_count;
    for (size_t i = 0; i < s->hand_count; i++) {
        geoms += s->hands[i].model->geom_count;
        fingers += s->hands[i].link_count * s->object_count;
    }
    w->ode = dWorldCreate();
    w->contact_group = dJointGroupCreate(0);
    dWorldSetQuickStepNumIterations(w->ode, w->settings.quickstep_iterations);
    w->objects = calloc(s->object_count, sizeof *w->objects);
    w->fingers = calloc(fingers, sizeof *w->fingers);
    w->hands = calloc(s->hand_count + 1, sizeof *w->hands);
    w->hand_geoms = calloc(geoms, sizeof *w->hand_geoms);
    w->geoms = calloc(geoms, sizeof *w->geoms);
    w->materials = calloc(geoms, sizeof *w->materials);
    w->categories = calloc(geoms, sizeof *w->categories);
    if (!w->objects || !w->fingers || !w->hands || !w->hand_geoms || !w->geoms || !w->materials || !w->categories)
        return WORLD_NO_MEMORY;
    if (!create_plugin(w)) return WORLD_NO_MEMORY;
    world_status status = WORLD_OK;
    for (size_t i = 0; i < s->object_count && status == WORLD_OK; i++) status = add_object(w, &s->objects[i]);
    for (size_t i = 0; i < s->finger_count && status == WORLD_OK; i++) status = add_finger(w, &s->fingers[i]);
    for (size_t i = 0; i < s->environment_count && status == WORLD_OK; i++)
        status = add_environment(w, &s->environment[i]);
    for (size_t i = 0; i < s->hand_count && status == WORLD_OK; i++) status = world_add_hand(w, (int)i);
    if (w->plugin) (void)pinch_ode_set_body_count(w->plugin, w->body_count);
    return status;
}

world_status world_create(const scene *s, const world_settings *settings, world **result, char *error)
{
    *result = NULL;
    snprintf(error, 256, "out of memory");
    world *w = calloc(1, sizeof *w);
    if (!w) return WORLD_NO_MEMORY;
    w->scene = s;
    w->settings = *settings;
    world_status status = build(w);
    if (status == WORLD_OK && w->no_memory) status = WORLD_NO_MEMORY;
    if (status != WORLD_OK) {
        world_free(w);
        return status;
    }
    scene_schedule_at(s, 0, &w->loads);
    *result = w;
    return WORLD_OK;
}

void world_free(world *w)
{
    if (!w || world_is_abandoned(w)) return;
    pinch_ode_destroy(w->plugin);
    pinch_ode_destroy(w->manifolds);
    for (int i = 0; i < w->geom_count; i++) dGeomDestroy(w->geoms[i]);
    for (int i = 0; i < w->object_count; i++) dGeomDestroy(w->objects[i].geom);
    if (w->contact_group) dJointGroupDestroy(w->contact_group);
    if (w->ode) dWorldDestroy(w->ode);
    world_free_hands(w);
    free(w->bodies);
    free(w->objects);
    free(w->hand_geoms);
    free(w->fingers);
    free(w->sums);
    free(w->geoms);
    free(w->materials);
    free(w->categories);
    free(w->contacts);
    free(w);
}

void world_not_expressed(const world *w, void (*report)(void *context, const char *text), void *context)
{
    world_hand_not_expressed(w, report, context);
    scene_report_normals(w->scene, "", ": its contact's direction", report, context);
    if (w->settings.contact_solver == WORLD_PINCH) return;
    char text[256];
    report(context, "friction cone: ODE's is a box, up to 41 % too strong between its axes");
    for (int i = 0; i < w->finger_count; i++) {
        const scene_finger *f = w->fingers[i].finger;
        if (w->fingers[i].object > 0) continue; /* said with the first */
        if (f->model != SCENE_FRICTIONLESS) {
            snprintf(text, sizeof text, "%s: tangential stiffness and damping (ODE's contacts do not give sideways)",
                     f->name);
            report(context, text);
        }
        if (f->model == SCENE_SOFT) {
            snprintf(text, sizeof text, "%s: torsional stiffness and friction", f->name);
            report(context, text);
        }
        if (f->friction.kinetic != f->friction.static_) {
            snprintf(text, sizeof text, "%s: kinetic friction", f->name);
            report(context, text);
        }
        if (isfinite(f->max_force)) {
            snprintf(text, sizeof text, "%s: max_force", f->name);
            report(context, text);
        }
        if (f->stiffness.hertz > 0) {
            snprintf(text, sizeof text, "%s: Hertz' stiffness (its linear one stands in)", f->name);
            report(context, text);
        }
        if (f->has_normal_force) {
            snprintf(text, sizeof text, "%s: massless force control (a slider of %g kg stands in)", f->name,
                     STAND_IN_MASS * w->scene->objects[0].mass);
            report(context, text);
        }
    }
}
