/* pinch hand: what a URDF or MJCF file of a hand was read as. */

#include "command.h"
#include "common/output.h"
#include "hands/hand.h"
#include "hands/listing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The next part of "name=text,name=text". Both point into `text`, which is cut up. NULL where `=` is missing. */
static char *next_pair(char **text, char **value)
{
    char *name = *text, *end = strchr(name, ',');
    *text = end ? end + 1 : name + strlen(name);
    if (end) *end = '\0';
    *value = strchr(name, '=');
    if (!*value) return NULL;
    *(*value)++ = '\0';
    return name;
}

enum { MOST_PACKAGES = 64 };

/* --package NAME=DIRECTORY,... */
static command_status read_packages(char *text, hand_package *packages, size_t *count)
{
    for (*count = 0; *text; ++*count) {
        char *value, *name = next_pair(&text, &value);
        if (!name || !*name || !*value || *count == MOST_PACKAGES) {
            command_error("hand", "--package: expected NAME=DIRECTORY, with commas between several");
            return COMMAND_BAD_INPUT;
        }
        packages[*count] = (hand_package){.name = name, .directory = value};
    }
    return COMMAND_DONE;
}

/* --at JOINT=POSITION,... */
static command_status read_positions(const hand *h, char *text, bool *given, double *positions)
{
    while (*text) {
        char *value, *end, *name = next_pair(&text, &value);
        int joint = name ? hand_find_joint(h, name) : -1;
        if (!name) {
            command_error("hand", "--at: expected JOINT=POSITION, with commas between several");
            return COMMAND_BAD_INPUT;
        }
        if (joint < 0) {
            fprintf(stderr, "pinch hand: --at: expected the name of a joint, not \"%s\"; there are", name);
            for (size_t i = 0; i < h->joint_count; i++) fprintf(stderr, " %s", h->joints[i].name);
            fputc('\n', stderr);
            return COMMAND_BAD_INPUT;
        }
        positions[joint] = strtod(value, &end);
        if (end == value || *end || !isfinite(positions[joint])) {
            command_error("hand", "--at: expected a position (rad or m) for %s, not \"%s\"", name, value);
            return COMMAND_BAD_INPUT;
        }
        given[joint] = true;
    }
    return COMMAND_DONE;
}

typedef struct configuration {
    bool *given;
    double *positions;
    hand_pose *poses;
    char *text; /* of --at, cut up */
} configuration;

static command_status place(const options *o, const hand *h, configuration *c)
{
    c->given = calloc(h->joint_count + 1, sizeof *c->given);
    c->positions = calloc(h->joint_count + 1, sizeof *c->positions);
    c->poses = calloc(h->link_count + 1, sizeof *c->poses);
    c->text = malloc(strlen(o->at ? o->at : "") + 1);
    if (!c->given || !c->positions || !c->poses || !c->text) return COMMAND_SYSTEM;
    strcpy(c->text, o->at ? o->at : "");
    for (size_t i = 0; i < h->joint_count; i++) c->positions[i] = h->joints[i].reference;
    command_status status = read_positions(h, c->text, c->given, c->positions);
    hand_follow_couplings(h, c->given, c->positions);
    hand_kinematics(h, c->positions, c->poses);
    return status;
}

static command_status show(const options *o, const hand *h, const configuration *c)
{
    if (o->json) {
        json_t *document = hand_document(h), *poses = hand_document_poses(h, c->positions, c->poses);
        if (!document || !poses || json_object_set(document, "kinematics", poses)) {
            json_decref(document);
            document = NULL;
        }
        json_decref(poses);
        return json_print_new(document, stdout) ? COMMAND_DONE : COMMAND_SYSTEM;
    }
    if (o->quiet) return COMMAND_DONE;
    hand_print(h, stdout);
    if (o->at) hand_print_poses(h, c->poses, stdout);
    return COMMAND_DONE;
}

static command_status run_hand(const options *o)
{
    hand *h = NULL;
    hand_error error;
    hand_package packages[MOST_PACKAGES];
    size_t package_count = 0;
    configuration c = {0};
    char *text = malloc(strlen(o->package ? o->package : "") + 1);
    command_status status = text ? COMMAND_DONE : COMMAND_SYSTEM;
    if (text) status = read_packages(strcpy(text, o->package ? o->package : ""), packages, &package_count);
    if (status == COMMAND_DONE) {
        hand_status loaded = hand_load(o->arguments[0], packages, package_count, &h, &error);
        status = loaded == HAND_OK ? COMMAND_DONE : loaded == HAND_BAD_INPUT ? COMMAND_BAD_INPUT : COMMAND_SYSTEM;
        if (loaded == HAND_BAD_INPUT) fprintf(stderr, "%s\n", error.text);
    }
    if (status == COMMAND_DONE) status = place(o, h, &c);
    if (status == COMMAND_DONE) status = show(o, h, &c);
    if (status == COMMAND_SYSTEM) command_error("hand", "out of memory");
    free(c.given);
    free(c.positions);
    free(c.poses);
    free(c.text);
    free(text);
    hand_free(h);
    return status;
}

static const option_id hand_options[] = {OPTION_AT, OPTION_PACKAGE, OPTION_JSON, OPTION_QUIET, OPTION_COUNT};

const command command_hand = {
    .name = "hand",
    .arguments = "FILE",
    .summary = "shows a robot hand as it was read from a URDF or MJCF file",
    .notes = "The first element of the file says which format it has: <robot> is URDF, <mujoco> is MJCF.\n"
             "What is IGNORED does not change the physics; what is NOT MODELLED does.\n"
             "--json also has the pose of every link, with joints that --at does not name at their references.",
    .min_arguments = 1,
    .max_arguments = 1,
    .files = "urdf xml mjcf",
    .options = hand_options,
    .run = run_hand,
};
