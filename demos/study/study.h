#ifndef PINCH_STUDY_H
#define PINCH_STUDY_H

#include "scenes/scene.h"
#include "scenes/world/world.h"

#include <jansson.h>
#include <stdint.h>

/* A study ("pinch-study/1"): one scene, in many trials with varied quantities. Read and checked as a whole before any
 * trial runs; plain data after that. */

typedef enum study_distribution {
    STUDY_UNIFORM = 0, /* between low and high */
    STUDY_LOG_UNIFORM, /* its logarithm is uniform; 0 < low */
    STUDY_NORMAL,      /* mean low, standard deviation high, cut off at at_least and at_most */
    STUDY_VALUES,      /* one of a list */
    STUDY_COLUMNS      /* cells of a row of the table */
} study_distribution;

/* A quantity that varies, at one place of the scene or, where its path has `*`, at several. */
typedef struct study_variation {
    const char *path; /* as it was given; the document's */
    study_distribution type;
    double low, high;         /* see the types */
    double at_least, at_most; /* STUDY_NORMAL; default without bounds */
    const json_t *values;     /* STUDY_VALUES: a list that is not empty; the document's */
    size_t column_count;      /* STUDY_COLUMNS: >= 1; several make a list */
    size_t *columns;
    bool common;        /* one draw for all places; otherwise each has its own */
    size_t place_count; /* >= 1 */
    char **places;      /* JSON pointers without `*` */
    size_t first_draw;  /* the number of its first draw among all draws of a trial */
} study_variation;

typedef enum study_design {
    STUDY_RANDOM = 0, /* independent draws */
    STUDY_SOBOL,      /* a Sobol sequence, which fills the space evenly */
    STUDY_GRID,       /* all combinations of the values (and of the table's rows); the last one varies fastest */
    STUDY_TABLE       /* one trial for each row of the table */
} study_design;

/* A CSV file of numbers with a header. */
typedef struct study_table {
    char *file;
    char *text; /* of the whole file */
    size_t column_count, row_count;
    char **names;
    double *cells; /* row by row */
} study_table;

typedef enum study_protocol_type {
    STUDY_NO_PROTOCOL = 0,
    STUDY_LIFT,
    STUDY_SHAKE,
    STUDY_SIX_FORCES
} study_protocol_type;

/* What is done to the hand and the object once the scene's own schedule has ended. */
typedef struct study_protocol {
    study_protocol_type type;
    double settle;         /* s, >= 0, from the end of the schedule until the protocol begins; default 0.5, none: 0 */
    double distance;       /* lift: m, > 0; default 0.2 */
    double speed;          /* lift: m/s, > 0, the greatest; default 0.2 */
    double axis[3];        /* lift: unit, default z, in dimension 2 y */
    double hold;           /* lift, six-forces: s, >= 0; default 1, 2 */
    double amplitude;      /* shake: m, > 0; default 0.02 */
    double frequency;      /* shake: Hz, > 0; default 3 */
    bool axes[3];          /* shake: along which of x, y, z; one after the other; default all that there are */
    double time;           /* shake: s, > 0, for each axis; default 2 */
    double force_per_mass; /* six-forces: m/s^2, > 0; default 10 */
} study_protocol;

/* When a run counts as success. It must also have been solved and verified in every step. */
typedef struct study_success {
    double displacement; /* m, at most, seen from the hand and from the protocol's start to its end; default INFINITY */
    double rotation;     /* rad, likewise */
    unsigned no_events;  /* bit i for the simulation_event_type i; default dropped */
} study_success;

/* A search in each trial for the least value with which it succeeds. Both ends are tried, too. */
typedef struct study_least {
    const char *path; /* NULL: no search */
    double from, to;  /* it is looked for between these, from < to */
    double precision; /* relative, > 0; default 1e-3 */
    size_t place_count;
    char **places;
} study_least;

typedef struct study {
    char *file, *text;
    size_t length; /* of the text */
    json_t *document;
    char *name;
    char *scene_file, *scene_text;
    size_t scene_length;
    json_t *scene;      /* the scene's document, as it is in the file */
    json_t *full_scene; /* the same with every default filled in */
    study_table table;
    uint64_t files; /* a hash over the files that the scene and its values refer to; 0 without any */
    size_t file_count;
    char **file_names;
    study_design design;
    uint64_t seed;
    long samples; /* trials, >= 1 */
    size_t variation_count;
    study_variation *variations;
    size_t draw_count; /* draws of one trial */
    size_t row_draw;   /* the draw that chooses a row of the table, where the design does not */
    study_protocol protocol;
    study_success success;
    study_least least;
    size_t record_count;
    const char **records; /* what is recorded of each trial; the document's */

    /* what the command line says */
    world_solver contact_solver;
    double step;  /* s; 0: the scene's */
    int halvings; /* how often that step is halved, >= 0 */
} study;

enum { STUDY_MOST_SAMPLES = 1000000000 };

/* document.c: reads and checks the study, its scene and its table. On success the caller gives *result to study_free;
 * otherwise *result is NULL and error->text says why in one line. */
scene_status study_load(const char *path, study **result, scene_error *error);
void study_free(study *s); /* NULL is fine */

/* Refuses one of the names of `record`, with its line. Returns SCENE_BAD_INPUT. */
scene_status study_refuse_record(const study *s, size_t index, scene_error *error);

/* vary.c: reads `vary` and `least`, for study_load. Functions that refuse return false, with the reason in the reader's
 * error. */
struct scene_node;
bool study_read_variations(const struct scene_node *root, study *s);
bool study_read_least(const struct scene_node *root, study *s);

/* files.c */

/* Sets `files` and their names: meshes, hands, and what these include, of the scene and of each value that may stand in
 * it. On failure error->text says why. */
scene_status study_read_files(study *s, scene_error *error);
/* A hash over the study's document, its scene, its table and these files, and what the command line changes of them. */
uint64_t study_hash(const study *s);

/* table.c: on failure `error` says why. */
scene_status study_table_read(const char *path, study_table *table, scene_error *error);
void study_table_free(study_table *table);

/* pointer.c: JSON pointers (RFC 6901), in which a part `*` stands for every element. */

/* All places in the document that the path leads to, as pointers. Returns how many there are, and -1 when memory runs
 * out. The caller frees the texts and the list. */
long pointer_expand(const json_t *document, const char *path, char ***places);
/* Sets the value at the place and takes it over. Objects on the way that are missing are made, and so are vectors that
 * are missing, as the document `full` has them, in which every default is filled in; it may be NULL. Returns false
 * where the place is not one of the document. */
bool pointer_set(json_t *document, const char *place, json_t *value, const json_t *full);
json_t *pointer_get(const json_t *document, const char *place);
/* Is the place the other one, or does it lie within it? */
bool pointer_is_within(const char *place, const char *other);

/* draw.c */

/* The inputs of a trial, as an object from place to value. They depend on the study and the index alone. NULL when
 * memory runs out. */
json_t *study_draw(const study *s, long index);
/* The most draws of a trial that a Sobol sequence is known for. */
enum { STUDY_MOST_SOBOL = 21 };
/* The number of one coordinate of a point of the Sobol sequence, in [0, 1), shifted by the seed. */
double study_sobol(uint64_t seed, long index, size_t dimension);

#endif
