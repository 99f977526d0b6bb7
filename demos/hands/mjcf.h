#ifndef PINCH_HANDS_MJCF_H
#define PINCH_HANDS_MJCF_H

#include "geometry.h"
#include "reader.h"

/* The parts of the MJCF reader. MuJoCo's rules are those of its XML reference; a comment says so where one is not plain
 * from the name of an attribute. */

typedef struct mjcf_compiler {
    bool degrees, autolimits, balance, strip;
    char sequence[4];
    const char *meshes; /* directory */
    double bound_mass, bound_inertia, total_mass;
    int from_geoms; /* 0: never, 1: always, 2: where there is no <inertial> */
    double groups[2];
} mjcf_compiler;

/* A default class. The list of nodes has the <default> elements that make it up. */
typedef struct mjcf_class {
    const char *name;
    int parent; /* -1: none */
} mjcf_class;

typedef struct mjcf_default {
    int class;
    xmlNode *node;
} mjcf_default;

typedef struct mjcf_mesh {
    const char *name;
    xmlNode *node;
    int place;       /* in the hand's list; -1: not there yet */
    bool is_weighed; /* `mass` is set: at density 1 */
    hand_mass mass;
} mjcf_mesh;

typedef struct mjcf_site {
    int link;
    double position[3];
} mjcf_site;

typedef struct mjcf {
    hand_reader *r;
    xmlNode *root;
    mjcf_compiler compiler;
    mjcf_class *classes; /* the first is "main" */
    mjcf_default *defaults;
    mjcf_mesh *meshes;
    mjcf_site *sites;
    size_t class_count, default_count, mesh_count, site_count;
    size_t standing_count, floating_count; /* outermost bodies: those of the hand, and those that only float */
    size_t spatial_count;                  /* tendons over the surface of links, which are not modelled */
} mjcf;

/* An element together with the defaults that apply to it, the most general one first and itself last. */
enum { MJCF_MOST_LEVELS = 64 };
typedef struct mjcf_element {
    mjcf *m;
    const xmlNode *node;
    const xmlNode *levels[MJCF_MOST_LEVELS];
    int count;
} mjcf_element;

/* mjcf_defaults.c. `tags` lists the elements in <default> that apply. `childclass` may be NULL. */
void mjcf_read_defaults(mjcf *m);
bool mjcf_open(mjcf *m, const xmlNode *node, const char *childclass, const char *tags, mjcf_element *e);
/* An element without defaults. */
mjcf_element mjcf_alone(mjcf *m, const xmlNode *node);
/* Refuses attributes that are not in the list, on any level. */
bool mjcf_only(const mjcf_element *e, const char *list);
/* The attribute of the last level that has it. NULL where none has. */
const char *mjcf_text(const mjcf_element *e, const char *name);
/* Numbers of all levels, one over the other: a level with fewer numbers replaces only the first ones. Returns how many
 * numbers the level with the most has. */
size_t mjcf_numbers(const mjcf_element *e, const char *name, double *values, size_t least, size_t most);
/* One of the words of the list, by its place in it; `otherwise` where no level has the attribute. */
int mjcf_word(const mjcf_element *e, const char *name, const char *list, int otherwise);
/* Do limits apply? `limited` is its attribute, and `range` the two numbers that were read or not. */
bool mjcf_is_limited(const mjcf_element *e, const char *limited, bool has_range, const double range[2]);

/* mjcf_frame.c: the orientation by any of the attributes that give one; pos and orientation. */
void mjcf_orientation(const mjcf_element *e, double q[4]);
hand_pose mjcf_pose(const mjcf_element *e);
/* The shortest turn that takes z to the axis, which has unit length. */
void mjcf_orientation_of_z(const double axis[3], double q[4]);

/* mjcf_replicate.c: puts frames with copies in the place of every <replicate>. After the compiler's settings are read.
 */
void mjcf_replicate(mjcf *m);

/* mjcf_asset.c */
void mjcf_read_assets(mjcf *m);
mjcf_mesh *mjcf_find_mesh(mjcf *m, const char *name);
/* Sets the mesh's mass at density 1; and its hull where `collides`. */
bool mjcf_weigh_mesh(mjcf *m, mjcf_mesh *mesh, bool weighed, bool collides);

/* Where an element is written: in a frame of a link. */
typedef struct mjcf_place {
    int link;
    hand_pose frame;
    const char *childclass;
} mjcf_place;

/* mjcf_geom.c: adds the geom's mass to `sum`, in the frame of the link, unless that is NULL. */
void mjcf_read_geom(mjcf *m, const xmlNode *node, const mjcf_place *place, hand_mass *sum);

/* mjcf_body.c: all of a <worldbody>. */
/* Counts the outermost bodies; before the first worldbody is read. */
void mjcf_count_outermost(mjcf *m);
void mjcf_read_world(mjcf *m, const xmlNode *world);

/* mjcf_equality.c, mjcf_actuator.c */
void mjcf_read_contacts(mjcf *m, const xmlNode *section);
void mjcf_read_equalities(mjcf *m, const xmlNode *section);
void mjcf_read_tendons(mjcf *m, const xmlNode *section);
void mjcf_read_actuators(mjcf *m, const xmlNode *section);

#endif
