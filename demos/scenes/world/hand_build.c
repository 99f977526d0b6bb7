/* From a hand to ODE bodies, joints and geoms. */
#include "world_hand.h"

#include "common/vector.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Of the mass that moves with it, for a body that a file gives none. */
static const double SHARE = 0.01;

/* Positions and frames while a hand is built. */
typedef struct hand_frames {
    const hand *model;
    hand_pose base; /* of the hand in the world */
    double *q, *partial;
    hand_pose *links;
} hand_frames;

static bool frames_start(hand_frames *f, const hand *model, const hand_pose *base)
{
    *f = (hand_frames){.model = model, .base = *base};
    f->q = calloc(2 * model->joint_count + 2, sizeof *f->q);
    f->partial = f->q ? f->q + model->joint_count + 1 : NULL;
    f->links = calloc(model->link_count + 1, sizeof *f->links);
    return f->q && f->links;
}

static void frames_free(hand_frames *f)
{
    free(f->q);
    free(f->links);
}

static bool is_last_of_body(const hand *model, size_t joint)
{
    return joint + 1 == model->joint_count || model->joints[joint + 1].body != model->joints[joint].body;
}

/* The frame of a joint's link in the world with the joints up to this one at their positions. */
static hand_pose frame_after(hand_frames *f, size_t joint)
{
    const hand *model = f->model;
    memcpy(f->partial, f->q, model->joint_count * sizeof *f->q);
    for (size_t j = joint; !is_last_of_body(model, j); j++) f->partial[j + 1] = model->joints[j + 1].reference;
    hand_kinematics(model, f->partial, f->links);
    return pose_product(&f->base, &f->links[model->joints[joint].link]);
}

/* ---- Masses. ---- */

/* The body whose mass counts for `body`: its own, or of the first that hangs from it and has one. */
static int mass_source(const hand *model, int body)
{
    while (!(model->bodies[body].mass.mass > 0)) {
        int next = -1;
        for (size_t b = (size_t)body + 1; b < model->body_count && next < 0; b++)
            if (model->bodies[b].parent == body) next = (int)b;
        if (next < 0) return body;
        body = next;
    }
    return body;
}

static bool is_between(const hand *model, size_t joint)
{
    return !is_last_of_body(model, joint) || !(model->bodies[model->joints[joint].body].mass.mass > 0);
}

/* What part of its source's mass the joint's body has: what the bodies between take, the body itself goes without. */
static double mass_share(const hand *model, size_t joint)
{
    if (is_between(model, joint)) return SHARE;
    double share = 1;
    for (size_t j = 0; j < model->joint_count; j++)
        if (is_between(model, j) && mass_source(model, model->joints[j].body) == model->joints[joint].body)
            share -= SHARE;
    return share;
}

static void set_mass(dBodyID body, const hand_mass *of, double share)
{
    dMass mass;
    dMassSetZero(&mass);
    mass.mass = share * of->mass;
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) mass.I[4 * i + j] = share * of->inertia[3 * i + j];
    dBodySetMass(body, &mass);
}

/* ---- Joints. ---- */

static bool has_stops(const hand_joint *j)
{
    return j->limited && (j->type == HAND_SLIDER || j->upper - j->lower < 2 * M_PI - 1e-3);
}

/* ODE's angles go from -pi to pi, so that the stops of a hinge have to lie on both sides of its zero. */
static double zero_of(const hand_joint *j, double start)
{
    return j->type == HAND_HINGE && has_stops(j) ? 0.5 * (j->lower + j->upper) : start;
}

static void place(const world_joint *j, const hand_pose *frame)
{
    double centre[3];
    pose_point(frame, j->centre, centre);
    dBodySetPosition(j->body, centre[0], centre[1], centre[2]);
    dBodySetQuaternion(j->body, frame->orientation);
}

static void make_joint(world *w, world_joint *j, const hand_pose *frame)
{
    double axis[3], anchor[3];
    bool hinge = j->of->type == HAND_HINGE;
    scene_rotate(frame->orientation, j->of->axis, axis);
    pose_point(frame, j->of->anchor, anchor);
    j->joint = hinge ? dJointCreateHinge(w->ode, NULL) : dJointCreateSlider(w->ode, NULL);
    dJointAttach(j->joint, j->body, j->parent);
    if (hinge) {
        dJointSetHingeAnchor(j->joint, anchor[0], anchor[1], anchor[2]);
        dJointSetHingeAxis(j->joint, axis[0], axis[1], axis[2]);
    } else {
        dJointSetSliderAxis(j->joint, axis[0], axis[1], axis[2]);
    }
    void (*set)(dJointID, int, dReal) = hinge ? dJointSetHingeParam : dJointSetSliderParam;
    if (has_stops(j->of)) {
        set(j->joint, dParamLoStop, j->of->lower - j->zero);
        set(j->joint, dParamHiStop, j->of->upper - j->zero);
    }
    if (w->plugin) world_keep_status(w, pinch_ode_note_joint(w->plugin, j->joint));
    dJointSetFeedback(j->joint, &j->feedback);
}

/* Makes the joints and their bodies where all joints are at their zeros, and then takes them to the start. */
static world_status add_joints(world *w, world_hand *h, hand_frames *f)
{
    const hand *model = h->hand->model;
    for (size_t i = 0; i < model->joint_count; i++) f->q[i] = zero_of(&model->joints[i], h->hand->start[i]);
    for (size_t i = 0; i < model->joint_count; i++) {
        world_joint *j = &h->joints[i];
        const hand_joint *of = &model->joints[i];
        int source = mass_source(model, of->body);
        double centre[3];
        *j = (world_joint){.of = of, .control = &h->hand->controls[i], .zero = f->q[i], .damper = -1};
        h->joint_count++;
        j->name = world_name_of_hand(w, h, of->name);
        if (!j->name) return WORLD_NO_MEMORY;
        hand_pose frame = frame_after(f, i), *of_source = &f->links[model->bodies[source].link], in_world;
        in_world = pose_product(&f->base, of_source);
        pose_point(&in_world, model->bodies[source].mass.centre, centre);
        pose_point_back(&frame, centre, j->centre);
        bool first = i == 0 || model->joints[i - 1].body != of->body;
        j->parent = first ? h->body[model->bodies[of->body].parent] : h->joints[i - 1].body;
        j->body = world_make_body(w, centre, frame.orientation);
        if (!j->body) return WORLD_NO_MEMORY;
        set_mass(j->body, &model->bodies[source].mass, mass_share(model, i));
        place(j, &frame);
        make_joint(w, j, &frame);
        if (!is_last_of_body(model, i)) continue;
        const hand_body *body = &model->bodies[of->body];
        j->relieved = body->relieved.mass;
        if (j->relieved > 0) scene_subtract(body->relieved.centre, body->mass.centre, j->relief);
        h->body[of->body] = j->body;
        h->centre[of->body] = j->centre;
    }
    memcpy(f->q, h->hand->start, model->joint_count * sizeof *f->q);
    for (size_t i = 0; i < model->joint_count; i++) {
        hand_pose frame = frame_after(f, i);
        place(&h->joints[i], &frame);
    }
    return WORLD_OK;
}

static void add_loops(world *w, world_hand *h, hand_frames *f)
{
    const hand *model = h->hand->model;
    hand_kinematics(model, h->hand->start, f->links);
    for (size_t i = 0; i < model->loop_count; i++) {
        const hand_loop *loop = &model->loops[i];
        double end[2][3];
        dBodyID body[2];
        for (int k = 0; k < 2; k++) {
            int link = loop->link[k];
            hand_pose frame = link < 0 ? f->base : pose_product(&f->base, &f->links[link]);
            pose_point(&frame, loop->anchor[k], end[k]);
            body[k] = h->body[link < 0 ? 0 : model->links[link].body];
        }
        if (body[0] == body[1]) continue;
        world_loop *made = &h->loops[h->loop_count++];
        dJointID ball = made->ball = dJointCreateBall(w->ode, NULL);
        dJointAttach(ball, body[0], body[1]);
        dJointSetBallAnchor(ball, end[0][0], end[0][1], end[0][2]);
        dVector3 in_second; /* ODE wants this anchor in the frame of the second body */
        dBodyGetPosRelPoint(body[1], end[1][0], end[1][1], end[1][2], in_second);
        dJointSetBallAnchor2(ball, in_second[0], in_second[1], in_second[2]);
        dJointSetFeedback(ball, &made->feedback);
    }
}

double world_loop_gap(const world_hand *h)
{
    double most = 0;
    for (int i = 0; i < h->loop_count; i++) {
        dVector3 a, b;
        dJointGetBallAnchor(h->loops[i].ball, a);
        dJointGetBallAnchor2(h->loops[i].ball, b);
        most = fmax(most, dCalcPointsDistance3(a, b));
    }
    return most;
}

/* ---- Geoms and links. ---- */

scene_shape world_hand_shape(const hand *model, const hand_geom *g)
{
    scene_shape shape = {.hull = {.vertices = NULL}};
    switch (g->type) {
    case HAND_BOX:
        shape.type = SCENE_BOX;
        for (int i = 0; i < 3; i++) shape.u.box.size[i] = 2 * g->size[i];
        break;
    case HAND_SPHERE:
        shape.type = SCENE_SPHERE;
        shape.u.sphere.radius = g->size[0];
        break;
    case HAND_CAPSULE:
    case HAND_CYLINDER:
        shape.type = g->type == HAND_CAPSULE ? SCENE_CAPSULE : SCENE_CYLINDER;
        shape.u.cylinder.radius = g->size[0];
        shape.u.cylinder.length = 2 * g->size[1];
        break;
    case HAND_ELLIPSOID:
        shape.type = SCENE_ELLIPSOID;
        memcpy(shape.u.ellipsoid.radii, g->size, sizeof g->size);
        break;
    default:
        shape.type = SCENE_CONVEX;
        shape.hull = model->meshes[g->mesh].hull;
    }
    return shape;
}

static void attach_geom(const world_hand *h, const hand_geom *g, dGeomID geom)
{
    double offset[3], none[3] = {0, 0, 0};
    scene_subtract(g->pose.position, h->centre[g->body] ? h->centre[g->body] : none, offset);
    dGeomSetBody(geom, h->body[g->body]);
    dGeomSetOffsetPosition(geom, offset[0], offset[1], offset[2]);
    dGeomSetOffsetQuaternion(geom, g->pose.orientation);
}

/* A link is a finger of the world for each of the objects that it may touch. */
static world_status add_link(world *w, world_hand *h, int index, size_t link)
{
    const hand *model = h->hand->model;
    const scene_finger *f = &h->hand->links[link];
    int of = h->hand->link_of[link], first = w->finger_count;
    dBodyID body = h->body[of < 0 ? 0 : model->links[of].body];
    pinch_material material = world_finger_material(f);
    for (int k = 0; k < w->object_count; k++) {
        world_finger *finger = &w->fingers[w->finger_count++];
        finger->finger = f;
        finger->body = body;
        finger->object = k;
        finger->hand = index + 1;
        finger->state.least_margin = NAN;
        memcpy(finger->state.point, dBodyGetPosition(body), sizeof finger->state.point);
    }
    for (size_t i = 0; i < model->geom_count; i++) {
        const hand_geom *g = &model->geoms[i];
        if (!g->collides || g->link != of) continue;
        scene_shape shape = world_hand_shape(model, g);
        dGeomID geom = world_make_geom(&shape);
        if (!geom) return WORLD_NO_MEMORY;
        attach_geom(h, g, geom);
        world_status status = world_add_geom(w, geom, &material, first);
        if (status != WORLD_OK) return status;
        w->hand_geoms[w->geom_count - 1] = (world_hand_geom){.hand = index + 1, .geom = g};
    }
    return WORLD_OK;
}

world_status world_add_hand(world *w, int index)
{
    world_hand *h = &w->hands[index];
    const scene_hand *from = &w->scene->hands[index];
    const hand *model = from->model;
    hand_frames frames;
    hand_pose base;
    h->hand = from;
    w->hand_count++;
    scene_hand_pose(w->scene, from, 0, base.position, base.orientation);
    h->joints = calloc(model->joint_count + 1, sizeof *h->joints);
    h->body = calloc(model->body_count + 1, sizeof *h->body);
    h->centre = calloc(model->body_count + 1, sizeof *h->centre);
    h->loops = calloc(model->loop_count + 1, sizeof *h->loops);
    bool room = frames_start(&frames, model, &base) && h->joints && h->loops && h->body && h->centre;
    world_status status = WORLD_NO_MEMORY;
    h->base = room ? world_make_body(w, base.position, base.orientation) : NULL;
    if (h->base) {
        dBodySetKinematic(h->base);
        h->body[0] = h->base;
        status = add_joints(w, h, &frames);
        if (status == WORLD_OK) add_loops(w, h, &frames);
    }
    frames_free(&frames);
    h->first_finger = w->finger_count;
    for (size_t l = 0; l < from->link_count && status == WORLD_OK; l++) status = add_link(w, h, index, l);
    return status == WORLD_OK ? world_add_hand_rows(w, h) : status;
}

void world_free_hands(world *w)
{
    for (int i = 0; i < w->hand_count; i++) {
        for (int k = 0; k < w->hands[i].joint_count; k++) free(w->hands[i].joints[k].name);
        free(w->hands[i].joints);
        free(w->hands[i].ties);
        free(w->hands[i].loops);
        free(w->hands[i].body);
        free(w->hands[i].centre);
    }
    free(w->hands);
}
