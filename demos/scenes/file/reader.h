#ifndef PINCH_SCENE_READER_H
#define PINCH_SCENE_READER_H

#include "scenes/scene.h"

#include <jansson.h>

/* Typed, checked access to the scene's JSON. A function that refuses puts one line of explanation into the reader's
 * error and returns false, which callers pass on. A key that is left out leaves *out alone, so defaults are set
 * beforehand. */

typedef struct scene_reader {
    const char *file;
    bool is_standard_input; /* the text comes from there; `file` is what messages say */
    const char *what;       /* kind of file, for messages */
    const char *text;
    size_t length;
    int dimension; /* 0 until it is known */
    scene_status status;
    scene_error *error;
} scene_reader;

/* A place in the document: a value, or a key that was left out, where value is NULL. It lives on the stack of the
 * function that reads it. */
typedef struct scene_node {
    scene_reader *reader;
    const struct scene_node *parent; /* NULL at the top */
    const char *key;                 /* NULL for an array's element */
    size_t index;
    json_t *value;
} scene_node;

typedef enum scene_range { SCENE_ANY_NUMBER = 0, SCENE_POSITIVE, SCENE_NOT_NEGATIVE } scene_range;

/* How a vector relates to the plane of dimension 2. A vector that does not fit is refused there, and rounding is set to
 * zero. */
typedef enum scene_vector_kind {
    SCENE_FREE = 0, /* any direction */
    SCENE_POLAR,    /* lies in the plane: points, forces, displacements */
    SCENE_AXIAL     /* stands on the plane: torques, rotations */
} scene_vector_kind;

/* document.c: reads the file and parses it. What *text and *document have become is to be released, also where they
 * were refused; the reader needs the text for its messages. */
bool scene_read_document(scene_reader *reader, char **text, json_t **document);

scene_node scene_member(const scene_node *parent, const char *key);
scene_node scene_element(const scene_node *parent, size_t index);
bool scene_has(const scene_node *parent, const char *key);

/* Refuses with "file:line: path: expected <format>, got <value>". Returns false. */
bool scene_refuse(const scene_node *node, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* The same without the "got", where the format says it already. */
bool scene_refuse_plainly(const scene_node *node, const char *format, ...) __attribute__((format(printf, 2, 3)));
/* Refuses the file as a whole, without line and path. */
bool scene_refuse_file(scene_reader *reader, const char *format, ...) __attribute__((format(printf, 2, 3)));
bool scene_refuse_memory(scene_reader *reader);

/* Checks that the node is an object with all the required keys and no unknown ones, by the list of `kind` in keys.c.
 * `extra` is one more key that it may have, or NULL. */
bool scene_check_object(const scene_node *node, const char *kind, const char *extra);
/* The same by a list that is given. */
typedef struct scene_kind scene_kind;
bool scene_check_kind(const scene_node *node, const scene_kind *kind, const char *extra);
/* Checks that the node is an array. `what` says of what. */
bool scene_check_array(const scene_node *node, const char *what);

/* `unit` is written as it is printed, for example "N/m"; "" for a pure number. */
bool scene_read_number(const scene_node *parent, const char *key, scene_range range, const char *unit, double *out);
bool scene_read_integer(const scene_node *parent, const char *key, int minimum, int maximum, int *out);
bool scene_read_boolean(const scene_node *parent, const char *key, bool *out);
/* *out becomes a copy that the caller frees; what it held before is freed. An empty string is refused unless it is
 * allowed. */
bool scene_read_string(const scene_node *parent, const char *key, bool may_be_empty, char **out);
bool scene_read_vector(const scene_node *parent, const char *key, scene_vector_kind kind, const char *unit,
                       double out[3]);
/* Reads `count` numbers from the node itself. */
bool scene_read_numbers(const scene_node *node, size_t count, scene_range range, const char *unit, double *out);
bool scene_read_unit_vector(const scene_node *parent, const char *key, scene_vector_kind kind, double out[3]);
bool scene_read_quaternion(const scene_node *parent, const char *key, double out[4]);
/* Reads one of `count` names; *out is its index. */
bool scene_read_name(const scene_node *parent, const char *key, const char *const *names, int count, int *out);

/* Scales to unit length. A vector that has unit length to rounding keeps its bits. */
void scene_normalise(double *v, int count);

char *scene_copy_text(const char *text); /* NULL: no memory */

/* keys.c: which keys the objects of a scene file may and must have. The reader checks them, and a test compares the
 * schema with them. */

typedef struct scene_key {
    const char *name;
    bool required;
} scene_key;

struct scene_kind {
    const char *name; /* the definition's name in assets/schema/pinch-scene-1.json */
    size_t count;
    const scene_key *keys;
};

size_t scene_kind_count(void);
const scene_kind *scene_kind_at(size_t index);
const scene_kind *scene_kind_named(const char *name); /* NULL when there is none */

/* The parts of scene_load, one per kind of object. All fill in defaults, and all return false after refusing. */

/* read_shape.c: reads the name of a file or folder, relative to that of the scene. *path stays as it is where the key
 * is left out; the caller frees it. */
bool scene_read_path(const scene_node *node, const char *key, char **path);

/* read_shape.c. `extra`: one more key the shape's object may have, or NULL. */
bool scene_read_shape(const scene_node *node, const char *extra, scene_shape *shape);

/* read_body.c */
bool scene_read_objects(const scene_node *root, scene *s);
bool scene_read_environment(const scene_node *root, scene *s);
/* Makes the default name: a letter and the place, counted from 1. */
bool scene_name_by_place(const scene_node *node, char letter, size_t index, char **name);
/* Refuses the first name of `count` that came before. The names stand `stride` bytes apart, from `first` on. The first
 * `skipped` of them are not of the list. */
bool scene_check_names(const scene_node *list, size_t skipped, const char *kind, char *const *first, size_t stride,
                       size_t count);

/* read_body.c */
bool scene_read_material(const scene_node *node, const char *stiffness_kind, const char *damping_kind,
                         scene_stiffness *stiffness, scene_damping *damping, scene_friction *friction);

/* The same where each of the three may be left out, and then stays as it is. */
bool scene_read_given_material(const scene_node *node, const char *stiffness_kind, const char *damping_kind,
                               scene_stiffness *stiffness, scene_damping *damping, scene_friction *friction);

/* read_finger.c: after objects, hands and dimension. */
bool scene_read_fingers(const scene_node *root, scene *s);
/* Reads the key `drive`, which may be left out. */
bool scene_read_drive(const scene_node *parent, scene_drive *drive);
/* Reads one rule for the contact of a link of a hand. */
bool scene_read_link_contact(const scene_node *node, scene_finger *link);

/* read_hand.c: after dimension. */
bool scene_read_hands(const scene_node *root, scene *s);
void scene_hand_free(scene_hand *hand);
/* read_control.c: after the hand's model and start. full_names: links are called "HAND/LINK". */
bool scene_read_controls(const scene_node *node, scene_hand *hand);
bool scene_read_link_contacts(const scene_node *node, scene_hand *hand, bool full_names);

/* close_loops.c */
typedef enum scene_loops { SCENE_LOOPS_CLOSED = 0, SCENE_LOOPS_OPEN, SCENE_LOOPS_NO_MEMORY } scene_loops;

/* Moves the joints that are neither given nor coupled, as little as need be, so that the loops close; coupled joints
 * follow. *gap becomes the largest distance (m) between two anchors that should be one. */
scene_loops scene_close_loops(const struct hand *h, const bool *given, double *positions, double *gap);

/* rules.c: an object of the file whose keys are names of things, or globs that match them. */
typedef struct scene_rules {
    const void *things;
    size_t count;
    const char *(*name)(const void *things, size_t index);
    const char *(*other_name)(const void *things, size_t index); /* that the thing goes by, too; may be NULL */
    bool (*by_name_only)(const void *things, size_t index);      /* globs do not match it; may be NULL */
    const char *what;                                            /* a thing is, for messages */
} scene_rules;

/* Refuses a key that matches nothing, with the names there are. */
bool scene_rules_check(const scene_node *node, const scene_rules *rules);
/* The key that matches thing `index` and comes next after the key `after` (NULL: first), from the least specific to the
 * most specific, and of equals in the order of the file. NULL: none. */
const char *scene_rule_after(const scene_node *node, const scene_rules *rules, size_t index, const char *after);

/* read_finger.c */
/* Reads a `time` key, which must be >= 0 and not before `earliest`. */
bool scene_read_time(const scene_node *node, double earliest, double *time);

/* read_schedule.c: after gravity and object. */
bool scene_read_schedule(const scene_node *root, scene *s);

#endif
