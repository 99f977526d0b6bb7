#ifndef PINCH_SCENE_H
#define PINCH_SCENE_H

#include "meshes/hull.h"

#include <jansson.h>
#include <pinch/solver.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/*
 * A parsed scene file ("pinch-scene/1"): every default filled in, everything checked, plain data.
 *
 * SI units; world frame unless a field says otherwise. Quaternions are (w, x, y, z) with unit norm and turn body
 * coordinates into world coordinates. Matrices are row-major. A limit that was not given is INFINITY.
 */

typedef enum scene_shape_type {
    SCENE_BOX = 0,
    SCENE_SPHERE,
    SCENE_CAPSULE,
    SCENE_CYLINDER,
    SCENE_ELLIPSOID,
    SCENE_SUPERELLIPSOID,
    SCENE_FLAT_CAPSULE,
    SCENE_CONVEX,
    SCENE_PRISM,
    SCENE_MESH,
    SCENE_SHAPE_COUNT
} scene_shape_type;

/* A convex polyhedron in body coordinates. */
typedef mesh_hull scene_hull;

/*
 * A shape about its own centre of mass, in its own axes. `type` says which member of the union holds.
 * convex and prism carry the hull as well, so that whoever can use a convex polyhedron needs no case of its own for
 * the prism.
 */
typedef struct scene_shape {
    scene_shape_type type;
    union {
        struct {
            double size[3]; /* full edge lengths (m), > 0 */
            /* radius (m) of the rounded edges and corners, >= 0 and below half the least size; default 0 */
            double rounding;
        } box;
        struct {
            double radius; /* m, > 0 */
        } sphere;
        struct {
            double radius; /* m, > 0 */
            double length; /* m, > 0, along local z; a capsule's caps come on top of it */
        } capsule;
        struct {
            double radius;   /* m, > 0 */
            double length;   /* m, > 0, along local z */
            double rounding; /* radius (m) of the rounded rims, >= 0, below radius and half the length; default 0 */
        } cylinder;
        struct {
            double radius; /* m, > 0 */
            double length; /* m, > 0, of the cylinder along local z; a half ball at +z, a flat end at -z */
        } flat_capsule;
        struct {
            double radii[3]; /* semi-axes (m), > 0 */
        } ellipsoid;
        struct {
            double radii[3];     /* semi-axes (m), > 0 */
            double exponents[2]; /* e in [0.25, 1.6], along z and around it: <pinch/fingertip.h>; default 1, 1 */
        } superellipsoid;
        struct {
            size_t count;     /* >= 4 */
            double *vertices; /* 3 per vertex (m): the file's, recentred, in the file's order */
        } convex;
        struct {
            size_t count;     /* >= 3 */
            double *vertices; /* 2 per corner (m): local x, y, counter-clockwise, recentred */
            double height;    /* m, > 0, along local z, centred */
        } prism;
        struct {
            char *file; /* absolute where it exists: a printed scene loads from any folder */
        } mesh;
    } u;
    scene_hull hull;    /* convex and prism only; empty otherwise */
    size_t piece_count; /* mesh only: >= 1; 0 otherwise */
    scene_hull *pieces; /* mesh: convex, not overlapping; together the body */
    /* m, local axes: what was subtracted from the file's vertices to bring the centre of mass to the origin; exactly
     * zero where nothing was */
    double shift[3];
    double bounding_radius; /* m: distance from the centre of mass to the farthest point */
    double volume;          /* m^3 */
    double unit_inertia[9]; /* m^2: inertia about the centre of mass per unit of mass, uniform density, local axes */
} scene_shape;

typedef struct scene_stiffness {
    double normal;     /* N/m, > 0 */
    double tangential; /* N/m, > 0; default 2/3 of normal */
    double torsional;  /* N m/rad; > 0 for soft; default 0 */
    double hertz;      /* Pa, > 0, E/(1 - nu^2); 0: linear. See pinch_material.hertz_modulus; runs only */
} scene_stiffness;

typedef struct scene_damping {
    double normal;     /* N s/m, >= 0; default 0 */
    double tangential; /* N s/m, >= 0; default 0 */
    double torsional;  /* N m s/rad, >= 0; default 0 */
} scene_damping;

/* Of two springs or dampers one behind the other, whose compliances add. */
static inline double scene_in_series(double a, double b)
{
    return a + b > 0 ? a * b / (a + b) : 0;
}

typedef struct scene_friction {
    double static_; /* coefficient, >= 0; 0 for frictionless */
    double kinetic; /* 0 <= kinetic <= static_; default: static_ */
} scene_friction;

typedef struct scene_object {
    char *name; /* unique among the objects; default "object", in a list O1, O2, ... */
    scene_shape shape;
    double mass;           /* kg, > 0 */
    double inertia[9];     /* kg m^2 about the centre of mass, body axes: mass * shape.unit_inertia */
    double position[3];    /* m, of the centre of mass; default 0 */
    double orientation[4]; /* default identity */
    double force[3];       /* N at the centre of mass; default 0. Of the first: scene_schedule_at */
    double torque[3];      /* N m; default 0 */
    bool has_material;     /* were the three below given? Without them it is rigid where it meets others */
    scene_stiffness stiffness;
    scene_damping damping;
    scene_friction friction;
} scene_object;

typedef enum scene_model {
    SCENE_FRICTIONLESS = 0, /* normal force only */
    SCENE_HARD,             /* point contact with friction */
    SCENE_SOFT /* hard + torsional friction about the normal; in dimension 2 the loader turns it into hard */
} scene_model;

typedef enum scene_drive_type {
    SCENE_DRIVE_FIXED = 0, /* kinematic base: closing, and the schedule's hand */
    SCENE_DRIVE_SLIDER,    /* the tip's body slides along the finger's normal, pushed by a force */
    SCENE_DRIVE_PATH       /* kinematic base on a prescribed path, relative to the start */
} scene_drive_type;

typedef struct scene_path_point {
    double time;           /* s, >= 0, not decreasing */
    double translation[3]; /* m; default: the point's before, 0 for the first */
    double rotation[3];    /* rotation vector (rad), about the tip's centre; default likewise */
} scene_path_point;

typedef struct scene_drive {
    scene_drive_type type; /* default SCENE_DRIVE_FIXED */
    union {
        struct {
            double mass;    /* kg, > 0, of the tip's body */
            double force;   /* N, >= 0, along the normal, grows with the finger's ramp; default 0 */
            double damping; /* N s/m, >= 0, of the slider; default 0 */
            bool gravity;   /* do gravity and base acceleration act on the tip's body? default false */
        } slider;
        struct {
            size_t count; /* >= 1 */
            scene_path_point *points;
        } path;
    } u;
} scene_drive;

typedef struct scene_finger {
    char *name;       /* unique; default F1, F2, ... by place */
    double point[3];  /* m: where the tip touches the object at the start */
    double normal[3]; /* unit, into the object */
    double t1[3]; /* unit, perpendicular to normal; from the key `tangent`, or the axis least aligned with the normal */
    double t2[3]; /* normal x t1 */

    scene_shape tip;        /* default: a sphere of a tenth of the object's bounding radius */
    double tip_position[3]; /* m: the tip's centre at the start, where its support feature's middle lies on `point` */
    double
        tip_orientation[4]; /* default: the smallest rotation that takes +x to the normal; a half turn about z for -x */

    scene_model model;
    scene_stiffness stiffness;
    scene_damping damping;
    scene_friction friction;
    double torsional_friction; /* m: torque limit per newton of normal force, >= 0; 0 unless soft */

    bool has_normal_force; /* force control; then closing is 0 */
    double closing;        /* m: how far the base moves along the normal (negative: away); default 0 */
    double normal_force;   /* N, >= 0; 0 unless has_normal_force */
    double ramp;           /* s, >= 0: closing, normal_force and the slider's force grow as scene_ramp; default 0 */
    double max_force;      /* N, > 0: the finger yields there; default INFINITY */

    scene_drive drive;
    double damage_max_force; /* N, >= 0; default INFINITY */
    double damage_max_slip;  /* m, >= 0; default INFINITY */
} scene_finger;

typedef struct scene_environment {
    char *name; /* unique among the environment; default E1, E2, ... */
    scene_shape shape;
    double position[3];        /* m, of the shape's centre of mass; default 0 */
    double orientation[4];     /* default identity */
    scene_stiffness stiffness; /* torsional is 0 */
    scene_damping damping;     /* torsional is 0 */
    scene_friction friction;
} scene_environment;

/* What drives a joint or a tendon of a hand, in units of that joint (N m, N) or tendon. */
typedef enum scene_control_type {
    SCENE_UNDRIVEN = 0,
    SCENE_POSITION_CONTROL, /* force = kp (target - q) - kd q', bounded */
    SCENE_TORQUE_CONTROL,   /* force = target + bias - kd q', bounded */
    SCENE_VELOCITY_CONTROL  /* force = kd (target - q'), bounded */
} scene_control_type;

typedef struct scene_target {
    double time, value; /* s, not decreasing; rad or m, N m or N, rad/s or m/s */
} scene_target;

typedef struct scene_control {
    int joint, tendon; /* of the hand's model; one of them is -1 */
    const char *name;  /* of that joint or tendon, of a further drive its own; the model's */
    scene_control_type type;
    double kp, kd;                    /* >= 0; kp > 0 where a position and kd > 0 where a velocity is controlled */
    double bias;                      /* N m or N: the constant of the file's actuator; 0 unless by torque */
    double max_force;                 /* > 0; default the larger side of what the file allows, else INFINITY */
    double least_force, most_force;   /* what the file allows; -max_force and max_force where the scene says that */
    double least_target, most_target; /* the file's range of control, for targets that the scene gives */
    size_t target_count;
    scene_target *target; /* piecewise linear; default, at time 0: the joint's start, or 0 where no position */
} scene_control;

enum { SCENE_TENDON_JOINTS = 16 }; /* most joints of a tendon */

/* A robot hand in the scene. Its links take part in contacts as fingers do. */
typedef struct scene_hand {
    char *name; /* unique among the hands; default "hand", in a list H1, H2, ... */
    char *file; /* that was read */
    size_t package_count;
    struct hand_package *packages; /* own their texts; see hands/hand.h */
    struct hand *model;            /* what the file says */
    double position[3];            /* m, of the frame of the hand at the start; default 0 */
    double orientation[4];         /* default identity */
    scene_drive drive;             /* fixed or path */
    double *start;        /* positions of the joints (rad or m): given, following couplings, closing loops; else the
                           * reference, or the nearest limit */
    size_t control_count; /* the joints, then the tendons, then what drives one of these besides */
    scene_control *controls;
    /* The links that can touch something, in the model's order. Of a finger they have name, model, stiffness, damping,
     * friction, torsional_friction and max_force. Where there are several hands the name is "HAND/LINK". */
    size_t link_count;
    scene_finger *links;
    int *link_of;        /* which of the model's links each one is; -1: what is fixed to the frame of the hand */
    bool self_collision; /* may its links touch each other? Neighbours and excluded pairs never do. Default false */
} scene_hand;

/* How one vector of a schedule entry goes from the entry's time on. */
typedef enum scene_signal_type {
    SCENE_CONSTANT = 0, /* value; towards the next entry's start value it goes linearly */
    SCENE_SINE,         /* value * sin(2 pi frequency s + phase) * scene_ramp(s, fade), s = t - start */
    SCENE_TURN          /* value turned about axis by 2 pi frequency s */
} scene_signal_type;

typedef struct scene_signal {
    scene_signal_type type;
    double value[3];  /* the constant, the sine's amplitude, or the vector that turns */
    double axis[3];   /* unit, SCENE_TURN only */
    double frequency; /* Hz, >= 0 for a sine; either sign for a turn */
    double phase;     /* rad, SCENE_SINE only; default 0 */
    double fade;      /* s, >= 0, SCENE_SINE only; default 0 */
    double start;     /* s: time of the entry that gave it. A later entry that leaves the key out goes on with it */
} scene_signal;

/* The vectors of a schedule entry, in the file's names. */
typedef enum scene_channel {
    SCENE_FORCE = 0,         /* N, on the object at its centre of mass */
    SCENE_TORQUE,            /* N m */
    SCENE_GRAVITY,           /* m/s^2 */
    SCENE_BASE_ACCELERATION, /* m/s^2, of the hand: minus it acts on the object like gravity */
    SCENE_HAND_TRANSLATION,  /* m, all fingers' bases */
    SCENE_HAND_ROTATION,     /* rotation vector (rad), all fingers' bases, about the world's origin */
    SCENE_CHANNEL_COUNT
} scene_channel;

typedef struct scene_entry {
    double time; /* s, >= 0, not decreasing */
    scene_signal channels[SCENE_CHANNEL_COUNT];
} scene_entry;

/* What acts at one moment: the schedule's channels evaluated. */
typedef struct scene_loads {
    double v[SCENE_CHANNEL_COUNT][3];
} scene_loads;

typedef enum scene_formulation {
    SCENE_COULOMB = 0, /* the exact cone */
    SCENE_LCP,         /* the linearized cone */
    SCENE_FORMULATION_COUNT
} scene_formulation;

/* Faces of a friction pyramid: fewer than three close no cone; the upper end keeps the problem's size in hand. */
enum { SCENE_MIN_FACES = 3, SCENE_MAX_FACES = 4096 };

typedef struct scene_solver {
    pinch_solver name;             /* default PINCH_SOLVER_NSNMGK */
    scene_formulation formulation; /* default SCENE_COULOMB */
    double tolerance;              /* > 0, default 1e-10 */
    int max_iterations;            /* >= 1, default 20000 */
    int pyramid_faces;             /* SCENE_MIN_FACES to SCENE_MAX_FACES, default 8 */
} scene_solver;

typedef struct scene {
    char *file;          /* as given to scene_load */
    char *name;          /* default: the file's name without folder and .json */
    char *source;        /* where the numbers come from; default "" */
    int dimension;       /* 2 or 3; default 3 */
    double gravity[3];   /* m/s^2; default (0, 0, -9.81), in dimension 2 (0, -9.81, 0). Over time: scene_schedule_at */
    size_t object_count; /* >= 1 */
    scene_object *objects; /* the fingers' points and the schedule's force and torque are the first one's */
    size_t finger_count;   /* >= 1 where there is no hand */
    scene_finger *fingers;
    size_t hand_count;
    scene_hand *hands;
    size_t environment_count;
    scene_environment *environment;
    size_t entry_count; /* >= 1: without a schedule one entry at time 0 with the scene's own gravity, force, torque */
    scene_entry *schedule;
    double step;     /* s, > 0; default 0.001 */
    double duration; /* s, >= 0; default 2 */
    scene_solver solver;
} scene;

typedef enum scene_status {
    SCENE_OK = 0,
    SCENE_BAD_INPUT, /* exit status 2 */
    SCENE_NO_MEMORY  /* exit status 3 */
} scene_status;

/* One line without a line break: file, line, JSON path, what was expected. There is room for the longest path that a
 * system has. */
typedef struct scene_error {
    char text[6144];
} scene_error;

/* Reads and checks a scene file; "-" is standard input, and names of files in it go by the working directory. On
 * success the caller gives *result to scene_free; otherwise *result is NULL and error->text says why. */
scene_status scene_load(const char *path, scene **result, scene_error *error);
/* The same of a JSON document that was read from the file `path` and may have been changed since.
 * `text` is the file's, for the lines in messages. */
scene_status scene_load_document(const char *path, const char *text, size_t length, json_t *document, scene **result,
                                 scene_error *error);
void scene_free(scene *s); /* NULL is fine */

/* Calls `take` for each file that the scene refers to: meshes, and the files of hands with all that these include. A
 * file may come several times. Returns false where `take` did, which ends it. */
bool scene_each_file(const scene *s, bool (*take)(void *context, const char *path), void *context);

/* Writes the scene as JSON with every default filled in. The text loads again and prints to the same text.
 * SCENE_NO_MEMORY when memory runs out; write errors stay in the stream's error flag. */
scene_status scene_print(const scene *s, FILE *stream);

/* Names as the scene file has them. */
const char *scene_shape_name(scene_shape_type type);
const char *scene_model_name(scene_model model);
const char *scene_drive_name(scene_drive_type type);
const char *scene_formulation_name(scene_formulation formulation);
/* A run has at least half a step, or a duration of 0, and at most SCENE_MOST_STEPS steps. More would take longer than
 * anybody waits, and would soon not fit a number. */
#define SCENE_MOST_STEPS 1e10
bool scene_steps_fit(double duration, double step);
/* The channel's key, in the entry or (*of_hand) in the entry's hand. */
const char *scene_channel_key(scene_channel channel, bool *of_hand);
/* false when `name` names none. */
bool scene_formulation_from_name(const char *name, scene_formulation *formulation);

/* solver_pairs.c: which solvers do what. */
typedef enum scene_use {
    SCENE_FOR_STATICS = 0, /* solve, lcp, bench paper */
    SCENE_FOR_RUN          /* run, compare, study */
} scene_use;

/* Does `solver` do `formulation` in this use? */
bool scene_pair_exists(scene_use use, pinch_solver solver, scene_formulation formulation);
/* The same; where it does not, `text` says so and lists the pairs that exist. */
enum { SCENE_SOLVER_TEXT = 512 };
bool scene_check_pair(scene_use use, const scene_solver *solver, char text[SCENE_SOLVER_TEXT]);
/* Can Pinch run the scene with its own solver? The solvers for complementarity problems alone (Lemke's method, PGS) do
 * not do force control, because its base is an unknown. Otherwise `text` says why. */
bool scene_check_solver(const scene *s, char text[SCENE_SOLVER_TEXT]);

/* s^2 (3 - 2 s) with s = t/ramp limited to 0..1: it is 0 up to t = 0 and 1 from t = ramp on. A ramp of 0 s is a jump at
 * t = 0, after which t = 0 counts. */
double scene_ramp(double t, double ramp);

/* The last of `count` >= 1 records whose time is at or before t, or else the first. `times` points to the time of the
 * first record, those of the others follow `stride` bytes apart, and none is earlier than the one before it. */
size_t scene_latest(const double *times, size_t stride, size_t count, double t);

/* What acts at time t. It is piecewise linear between entries and held before the first and after the last one. Equal
 * times jump; at that very time the last of them counts. A sine or turn runs from its entry's time until the next entry
 * that gives the key anew, and jumps there; a constant before it goes linearly to its start value. */
void scene_schedule_at(const scene *s, double t, scene_loads *loads);
/* What acts in the schedule's first entry, which is the load of the statics. */
void scene_first_loads(const scene *s, scene_loads *loads);

/* Is the finger force-controlled? True for normal_force, and for a slider, whose force is the normal force of the
 * statics where no gravity acts on it. *force (N) becomes the force at full ramp, or 0. */
bool scene_finger_force(const scene_finger *finger, double *force);

/* The path drive's translation (m) and rotation vector (rad) at time t; zero for other drives. */
void scene_path_at(const scene_drive *drive, double t, double translation[3], double rotation[3]);

/* The target of a control at time t; the first value before, and the last one after its times. */
double scene_target_at(const scene_control *control, double t);
/* The file's name of a control: "position", "torque", "velocity". */
const char *scene_control_name(scene_control_type type);
/* Half way between the bounds of its force: 0 where these are the same both ways. */
double scene_control_middle(const scene_control *control);

/* Where the frame of a hand is at time t: the start, moved by the path drive (turned about its own origin) and then by
 * the schedule's hand. */
void scene_hand_pose(const scene *s, const scene_hand *hand, double t, double position[3], double orientation[4]);

/* Where the tip of a kinematic base is at time t: the start, moved by closing (ramped, along the start's normal) and by
 * the path drive (turned about the tip's centre), then all of it moved by the schedule's hand (turned about the world's
 * origin). The travel of force control is not included. For a slider this is its rail at zero travel. */
void scene_base_pose(const scene *s, const scene_finger *finger, double t, double position[3], double orientation[4]);

#endif
