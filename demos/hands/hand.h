#ifndef PINCH_HANDS_HAND_H
#define PINCH_HANDS_HAND_H

#include "meshes/hull.h"
#include "pose.h"

#include <stdbool.h>
#include <stddef.h>

/*
 * A robot hand as its file describes it: a tree of links, the joints between them, what couples and drives the joints,
 * and the geometry that touches things. Plain data, read from URDF or MJCF and checked.
 *
 * SI units, angles in radians. Quaternions are (w, x, y, z) with unit norm. Inertias are 3 x 3, row-major, about the
 * centre of mass. What a file leaves open is INFINITY where it is a limit, and 0 elsewhere. Names are unique in their
 * list; what has no name in the file gets one that says what it is ("body_3").
 */

/* Mass, centre of mass and inertia in the axes of a frame. */
typedef struct hand_mass {
    double mass;       /* kg; 0: none */
    double centre[3];  /* m */
    double inertia[9]; /* kg m^2 */
} hand_mass;

/* A link (URDF) or body (MJCF) of the file. A parent comes before its children. */
typedef struct hand_link {
    char *name;
    int parent;     /* -1: the frame of the hand */
    hand_pose pose; /* in the parent's frame, with its own joints at their references */
    hand_mass mass; /* its own */
    int body;       /* that it is part of */
    hand_pose in_body;
    double gravity_compensation; /* MJCF: the part of its weight that is taken off, >= 0 */
    char *file;                  /* and line: where it is written */
    int line;
} hand_link;

/* Links that no joint moves against each other. Body 0 is the base; its frame is that of the hand, and it may be empty.
 * A body without mass is the middle of a joint with several axes; those below it have mass. The frame of a body is that
 * of its first link. A parent comes before its children. */
typedef struct hand_body {
    char *name;
    int parent; /* -1: none */
    int link;   /* the first; -1: the base has none */
    hand_mass mass;
    hand_mass relieved; /* the part of it whose weight is taken off; its inertia says nothing */
} hand_body;

typedef enum hand_joint_type { HAND_HINGE = 0, HAND_SLIDER } hand_joint_type;

/* A joint moves its link, and all that is fixed to it, against the link's parent. A link may have several (MJCF): they
 * act in the order of the list, the first nearest to the parent. */
typedef struct hand_joint {
    char *name;
    hand_joint_type type;
    int link, body;
    double axis[3], anchor[3]; /* in the frame of the link, which is that of the body; the axis has unit length */
    double reference;          /* the position (rad or m) at which the link is at its `pose` */
    bool limited;
    double lower, upper;         /* rad or m; -INFINITY and INFINITY where not limited */
    double least_effort, effort; /* N m or N: bounds of what all drives together do */
    double velocity;             /* rad/s or m/s: URDF's bound; INFINITY: none */
    double damping, friction, armature;
    double stiffness, spring_reference; /* a spring in the joint (MJCF) */
    int coupling;                       /* by which it follows another one; -1: none */
    int line;
} hand_joint;

/* position of `joint` = offset + multiplier * position of `of`. of = -1: it stays at `offset`. */
typedef struct hand_coupling {
    int joint, of;
    double multiplier, offset;
    int line;
} hand_coupling;

/* A linear combination of joints: the sum of coefficient * position. */
typedef struct hand_tendon {
    char *name;
    size_t count;
    int *joints;
    double *coefficients;
    bool limited;
    double lower, upper;
    double least_effort, effort; /* N: bounds of what all drives together do */
    double stiffness, damping, friction;
    double rest[2]; /* within these the spring does nothing */
    int line;
} hand_tendon;

typedef enum hand_drive_type { HAND_POSITION = 0, HAND_VELOCITY, HAND_MOTOR, HAND_AFFINE } hand_drive_type;

/* An actuator: force = gain * control + bias[0] + bias[1] * length + bias[2] * speed, where length and speed are `gear`
 * times those of the joint or tendon, and the force acts on it times `gear`. */
typedef struct hand_drive {
    char *name;
    hand_drive_type type; /* position: kp (control - length) - kd speed; velocity: kd (control - speed); motor: gain
                             alone; affine: none of these */
    int joint, tendon;    /* one of them is -1 */
    double gear, gain, bias[3];
    double kp, kd;        /* -bias[1] and -bias[2] where these are negative, else 0 */
    double damping_ratio; /* only where bias[1] = -gain; > 0: kd = 2 * damping_ratio * sqrt(kp * mass that it moves) */
    double least_control, most_control, least_force, most_force;
    int line;
} hand_drive;

/* Two points that stay together: where a loop of links closes. */
typedef struct hand_loop {
    char *name;
    int link[2];         /* the second may be -1: the frame of the hand */
    double anchor[2][3]; /* in the links' frames */
    int line;
} hand_loop;

typedef enum hand_geom_type {
    HAND_BOX = 0,   /* size: half lengths of the sides */
    HAND_SPHERE,    /* size: radius */
    HAND_CAPSULE,   /* size: radius, half length of the cylinder, along z */
    HAND_CYLINDER,  /* size: radius, half length, along z */
    HAND_ELLIPSOID, /* size: half axes */
    HAND_MESH
} hand_geom_type;

typedef struct hand_geom {
    char *name;
    int link; /* -1: fixed to the frame of the hand */
    int body;
    hand_geom_type type;
    hand_pose pose; /* in the frame of the body */
    double size[3];
    bool collides;                 /* false: for pictures only */
    unsigned contype, conaffinity; /* MJCF: geoms a and b touch where a's contype and b's conaffinity, or the other way
                                      round, have a bit in common; URDF: 1 and 1 */
    int mesh;                      /* HAND_MESH only; -1 elsewhere */
    double friction[3];            /* sliding (1), torsional (m), rolling (m), as the file says; -1: it says nothing */
    double colour[4];              /* red, green, blue, alpha; alpha -1: none given */
    int line;
} hand_geom;

/* A mesh file at one scale. */
typedef struct hand_mesh {
    char *name, *file;
    double scale[3];
    mesh_hull hull; /* scaled; only where a geom collides with it, empty otherwise */
} hand_mesh;

/* Links that do not touch each other. */
typedef struct hand_exclude {
    int link[2];
} hand_exclude;

/* A part of the file that was not taken, by name; once for all of the same name. */
typedef struct hand_remark {
    char *what;
    size_t count;
    int line; /* of the first */
} hand_remark;

typedef struct hand {
    char *file, *name;
    bool is_mjcf; /* false: URDF */
    size_t link_count, body_count, joint_count, coupling_count, tendon_count, drive_count, loop_count;
    size_t geom_count, mesh_count, exclude_count, ignored_count, unmodelled_count;
    size_t file_count;
    hand_link *links;
    hand_body *bodies;
    hand_joint *joints;
    hand_coupling *couplings;
    hand_tendon *tendons;
    hand_drive *drives;
    hand_loop *loops;
    hand_geom *geoms;
    hand_mesh *meshes;
    hand_exclude *excludes;
    hand_remark *ignored;    /* does not change the physics */
    hand_remark *unmodelled; /* does, and is missing here: a simulation of this hand is not that of the file */
    char **files;            /* that were read: the file itself and those it includes; meshes name their own */
    size_t text_count;
    char **texts; /* owns all names */
} hand;

typedef enum hand_status { HAND_OK = 0, HAND_BAD_INPUT, HAND_NO_MEMORY } hand_status;

typedef struct hand_error {
    char text[1024]; /* one line: "hand.urdf:12: <joint name="j">: expected ..." */
} hand_error;

/* Where "package://NAME/" leads. */
typedef struct hand_package {
    const char *name, *directory;
} hand_package;

/* Reads a URDF or MJCF file, by its root element. On failure *h is NULL and the reason is in *error. A package that is
 * not among `packages` is looked for in the folders above the file. */
hand_status hand_load(const char *file, const hand_package *packages, size_t package_count, hand **h,
                      hand_error *error);
void hand_free(hand *h);

/* The places in the lists; -1 where there is none of that name. */
int hand_find_joint(const hand *h, const char *name);
int hand_find_link(const hand *h, const char *name);

double hand_total_mass(const hand *h);

/* Returns the outermost link of a body from which no other hangs: the last one that can touch something. -1: there is
 * none, or others hang from the body. */
int hand_tip_of(const hand *h, size_t body);

/* kinematics.c: `positions` has one entry for each joint (rad or m). Sets the pose of every link in the frame of the
 * hand. */
void hand_kinematics(const hand *h, const double *positions, hand_pose *links);
/* What a joint moves when all joints are at their references: the inertia (kg m^2) about a hinge's axis, or the mass
 * (kg) on a slider, with the armature. */
double hand_moved_inertia(const hand *h, int joint);
/* Sets the positions of coupled joints for which `given` is false from the joints that they follow; the others stay. */
void hand_follow_couplings(const hand *h, const bool *given, double *positions);

#endif
