/*
 * What joints keep and ODE has no getters for.
 *
 * Most of it is the relative pose of the two bodies at the moment when axes or anchors were set, or, for some types,
 * when the joint was attached. A hinge's axis in its second body, for example, is the first body's axis seen in the
 * relative orientation of that moment. Whoever sees those calls can note the pose here. The rest are arguments of
 * setters: in which frame a linear motor's axis is fixed, and the motors of a plane joint.
 */
#ifndef PINCH_JOINTS_JOINT_POSE_H
#define PINCH_JOINTS_JOINT_POSE_H

#include "util/key_map.h"
#include "util/list.h"

#include <ode/ode.h>

/*
 * Finds the bodies that a joint's j1 and j2 act on: body[1] may be NULL, body[0] not. Returns false for a joint without
 * bodies.
 */
bool pinch_joint_bodies(dJointID joint, dBodyID body[2]);

/* What is known of a joint, bits. */
enum {
    PINCH_KNOWS_TURN = 1,   /* the relative orientation when axes were set; a hinge-2's angle between its axes */
    PINCH_KNOWS_OFFSET = 2, /* the relative position when anchors were set */
    PINCH_KNOWS_MOTORS = 4, /* of a plane joint */
    PINCH_KNOWS_MESH = 8,   /* of a transmission: where its wheels' angles are measured from */
    PINCH_KNOWS_FRAME = 16  /* and the next two bits: the frame of a linear motor's axis */
};

/* A plane joint's motor, whose stops ODE does not use. */
typedef struct pinch_plane_motor {
    double velocity, fmax, cfm;
} pinch_plane_motor;

/* The bodies are those of pinch_joint_bodies. */
typedef struct pinch_joint_pose {
    dJointID joint;
    dJointType type;
    dBodyID body[2];
    unsigned known;
    int noted;           /* when: after so many bodies were forgotten, see pinch_joint_poses */
    dVector3 offset;     /* of fixed joints and sliders x1 - x2: in the first body's frame for a fixed joint, in the
                          * second's for a slider; x1 where there is no second body. Of joints with a prismatic axis the
                          * anchor in the first body's frame */
    dQuaternion turn;    /* q1^-1 q2 */
    dMatrix3 rotation;   /* the same as a matrix */
    double axis1[3];     /* a hinge's axis in the first body's frame then: another one was set since where it differs */
    double axis_length;  /* of the vector that a world axis was set with: ODE keeps that one as it is */
    double cosine, sine; /* of the angle between a hinge-2's axes; 0 for others */
    union {
        int frame[3];               /* of a linear motor's axes: 0 the world, 1 or 2 the first or second body */
        pinch_plane_motor motor[3]; /* along x, along y, about z */
        struct {
            long meshed;            /* the step in which ODE measures its wheels anew; -1: the next one */
            double reference[2][3]; /* direction of angle 0 in each body's frame, once that step is done */
        } mesh;
    };
} pinch_joint_pose;

/*
 * What was noted between a forgotten body and others stays until all such is dropped at once: a walk through the notes
 * for each body would take the square of their number. Meanwhile the address of the body may be another one's. A note
 * is of the one that is gone if that was forgotten after it was made.
 */
typedef struct pinch_joint_poses {
    pinch_joint_pose *items;
    int count, room;
    pinch_item_index index;
    pinch_key_map forgotten; /* bodies, and when each was forgotten last: as number 1, 2 ... */
    int forgotten_count;     /* these numbers so far */
} pinch_joint_poses;

/* Reads the pose that the joint's bodies have now, and says in pose->known what a joint of its type keeps of it.
 * Returns false for a joint of another type or without bodies. */
bool pinch_joint_pose_now(dJointID joint, pinch_joint_pose *pose);
/* Keeps what the pose knows in place of what was known of its joint; other things stay known where bodies and type are
 * the same. Returns false when memory runs out, and then the joint stays unknown. */
bool pinch_joint_pose_keep(pinch_joint_poses *poses, const pinch_joint_pose *pose);
/* Takes `things` back, bits as above. */
void pinch_joint_pose_forget(pinch_joint_poses *poses, dJointID joint, unsigned things);

/* Takes back what was noted between a body and others, or of a joint. */
void pinch_joint_poses_forget_body(pinch_joint_poses *poses, dBodyID body);
/* Drops what has been taken back. To be called before poses are read. */
void pinch_joint_poses_drop_forgotten(pinch_joint_poses *poses);
void pinch_joint_poses_forget_joint(pinch_joint_poses *poses, dJointID joint);

/* A plane joint has been made: it has no motors yet, and they have the world's CFM, as it is now. A linear motor has
 * been made: it has no axes yet. Returns false when memory runs out, and then the joint stays unknown. */
bool pinch_joint_is_new(pinch_joint_poses *poses, dJointID joint, dJointType type, double cfm);
/* dJointSetLMotorAxis was called, or dJointSetPlane2D...Param for the motor along x (0), along y (1) or about z (2). A
 * plane joint's motors are known only where the joint was new. Both return false for arguments that ODE has no use
 * for. */
bool pinch_note_motor_frame(pinch_joint_poses *poses, dJointID joint, int axis, int frame);
bool pinch_note_plane_motor(pinch_joint_poses *poses, dJointID joint, int motor, int parameter, double value);

/* What is read of a hinge or slider once in a step, for its rows, its servo and its couplings. */
typedef struct pinch_axis_reading {
    bool known;
    dVector3 axis, own; /* in world axes, and a hinge's in the first body's frame */
    bool slides;        /* along the axis, in place of turning about it */
    bool reversed;      /* it is attached as (0, body): its position grows the other way */
    bool placed;        /* the position has been read, too: */
    double position;    /* as its getter has it, rad or m */
} pinch_axis_reading;

/* Tells whether a joint is attached as (0, body), which ODE turns round. body: those of pinch_joint_bodies. */
bool pinch_joint_reversed(dJointID joint, const dBodyID body[2]);
/* Reads a hinge's axis. body: as above. */
void pinch_read_hinge(dJointID hinge, const dBodyID body[2], pinch_axis_reading *reading);
/* Tells whether a hinge still has the axis that it had when its pose was noted. */
bool pinch_hinge_pose_holds(const pinch_joint_pose *pose, const pinch_axis_reading *reading);
/* Tells whether anything was ever noted of a joint in this place of memory. */
bool pinch_joint_is_noted(const pinch_joint_poses *poses, dJointID joint);
/* Returns NULL where nothing is known for these bodies and a joint of this type; another joint may be where a destroyed
 * one was. *hint: as for pinch_item_index_find. */
pinch_joint_pose *pinch_joint_pose_of(const pinch_joint_poses *poses, dJointID joint, const dBodyID body[2], int *hint);
/* Reads a hinge-2's axes, unit vectors of the world, and axis1 x axis2. Returns its length, the sine of their angle. */
double pinch_hinge2_axes(dJointID joint, double axis1[4], double axis2[4], double normal[3]);
void pinch_joint_poses_free(pinch_joint_poses *poses);

#endif
