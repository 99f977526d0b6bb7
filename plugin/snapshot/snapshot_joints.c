#include "snapshot/archive.h"
#include "snapshot/snapshot.h"

/* Bytes that an archive has at least for one of each. */
enum { REFERENCE_BYTES = 60, JOINT_POSE_BYTES = 100, SERVO_BYTES = 6, COUPLING_BYTES = 1 };

static void archive_reference(pinch_archive *a, pinch_hinge_reference *r)
{
    pinch_archive_old_joint(a, &r->joint);
    for (int side = 0; side < 2; side++) pinch_archive_old_body(a, &r->body[side]);
    PINCH_ARCHIVE(a, r->axis1);
    PINCH_ARCHIVE(a, r->turn);
    PINCH_ARCHIVE(a, r->seen);
    pinch_archive_flag(a, &r->reliable);
}

/* `known` tells which of what follows a type keeps. */
static void archive_notes(pinch_archive *a, pinch_joint_pose *pose)
{
    if (pose->type == dJointTypePlane2D) {
        PINCH_ARCHIVE(a, pose->motor);
    } else if (pose->type == dJointTypeTransmission) {
        PINCH_ARCHIVE(a, pose->mesh.meshed);
        PINCH_ARCHIVE(a, pose->mesh.reference);
    } else {
        PINCH_ARCHIVE(a, pose->frame);
    }
}

static void archive_joint_pose(pinch_archive *a, pinch_joint_pose *pose)
{
    pinch_archive_old_joint(a, &pose->joint);
    PINCH_ARCHIVE(a, pose->type);
    for (int side = 0; side < 2; side++) pinch_archive_old_body(a, &pose->body[side]);
    PINCH_ARCHIVE(a, pose->known);
    for (int i = 0; i < 3; i++) PINCH_ARCHIVE(a, pose->offset[i]);
    PINCH_ARCHIVE(a, pose->turn);
    if (a->reading) dQtoR(pose->turn, pose->rotation);
    PINCH_ARCHIVE(a, pose->axis1);
    PINCH_ARCHIVE(a, pose->axis_length);
    PINCH_ARCHIVE(a, pose->cosine);
    PINCH_ARCHIVE(a, pose->sine);
    archive_notes(a, pose);
}

static void archive_law(pinch_archive *a, pinch_servo *law)
{
    PINCH_ARCHIVE(a, law->target);
    PINCH_ARCHIVE(a, law->kp);
    PINCH_ARCHIVE(a, law->kd);
    PINCH_ARCHIVE(a, law->rate);
    PINCH_ARCHIVE(a, law->max_force);
}

static void archive_followed(pinch_archive *a, pinch_followed *coordinate)
{
    pinch_archive_flag(a, &coordinate->placed);
    PINCH_ARCHIVE(a, coordinate->position);
}

static void archive_servos(pinch_archive *a, pinch_joint_servos *servos)
{
    pinch_archive_joint(a, &servos->joint);
    for (int i = 0; i < PINCH_JOINT_AXES; i++) {
        pinch_servo_axis *axis = &servos->axis[i];
        pinch_archive_flag(a, &axis->used);
        if (!axis->used) continue;
        archive_law(a, &axis->law);
        archive_followed(a, &axis->coordinate);
        PINCH_ARCHIVE(a, axis->force);
    }
}

static void archive_coupling(pinch_archive *a, pinch_coupling *c)
{
    pinch_archive_flag(a, &c->used);
    if (!c->used) return;
    archive_law(a, &c->law);
    pinch_archive_count(a, &c->count, 1, PINCH_COUPLING_TERMS);
    for (int i = 0; i < c->count; i++) {
        pinch_archive_joint(a, &c->coupled[i].term.joint);
        pinch_archive_place(a, &c->coupled[i].term.axis, PINCH_JOINT_AXES, false);
        PINCH_ARCHIVE(a, c->coupled[i].term.factor);
        archive_followed(a, &c->coupled[i].coordinate);
    }
    pinch_archive_flag(a, &c->placed);
    PINCH_ARCHIVE(a, c->position);
    PINCH_ARCHIVE(a, c->force);
}

static void archive_couplings(pinch_archive *a, pinch_couplings *couplings)
{
    PINCH_ARCHIVE_LIST(a, *couplings, COUPLING_BYTES);
    if (a->reading && !PINCH_RESERVE(couplings->by_island, couplings->count))
        pinch_archive_fail(a, PINCH_OUT_OF_MEMORY);
    for (int k = 0; k < couplings->count; k++) archive_coupling(a, &couplings->items[k]);
    if (a->reading) couplings->changed = true;
}

void pinch_archive_joints(pinch_archive *a, pinch_joint_store *store, pinch_joint_poses *poses)
{
    pinch_hinge_references *references = &store->references;
    PINCH_ARCHIVE_LIST(a, *references, REFERENCE_BYTES);
    for (int i = 0; i < references->count; i++) archive_reference(a, &references->items[i]);
    pinch_archive_index(a, &references->index, PINCH_ITEM_KEYS(*references, pinch_hinge_reference, joint),
                        references->count);
    PINCH_ARCHIVE_LIST(a, *poses, JOINT_POSE_BYTES);
    for (int i = 0; i < poses->count; i++) archive_joint_pose(a, &poses->items[i]);
    pinch_archive_index(a, &poses->index, PINCH_ITEM_KEYS(*poses, pinch_joint_pose, joint), poses->count);
    PINCH_ARCHIVE_LIST(a, store->servos, SERVO_BYTES);
    for (int i = 0; i < store->servos.count; i++) archive_servos(a, &store->servos.items[i]);
    pinch_archive_index(a, &store->servos.index, PINCH_ITEM_KEYS(store->servos, pinch_joint_servos, joint),
                        store->servos.count);
    archive_couplings(a, &store->couplings);
}
