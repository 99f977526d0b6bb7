/* pinch hand: what a URDF or MJCF file of a hand was read as. */

#include "command.h"
#include "common/output.h"
#include "common/terminal.h"
#include "common/utf8.h"
#include "common/whole_file.h"
#include "hands/hand.h"
#include "hands/listing.h"
#include "scenes/world/world.h"
#include "view/gltf.h"

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

/* ---- The positions of --at: what a scene's `joints` may have, and nothing else. ---- */

static const double ROUNDING = 1e-9; /* rad or m, as in scenes */

static command_status read_position(const hand *h, const char *name, const char *value, bool *given, double *positions)
{
    int joint = hand_find_joint(h, name);
    char *end;
    if (joint < 0) {
        terminal_print(stderr, "pinch hand: --at: expected the name of a joint, not \"%s\"; there are", name);
        for (size_t i = 0; i < h->joint_count; i++) terminal_print(stderr, " %s", h->joints[i].name);
        fputc('\n', stderr);
        return COMMAND_BAD_INPUT;
    }
    if (given[joint]) {
        command_error("hand", "--at: expected each joint once, got %s twice", name);
        return COMMAND_BAD_INPUT;
    }
    positions[joint] = strtod(value, &end);
    if (end == value || *end || !isfinite(positions[joint])) {
        command_error("hand", "--at: expected a position (rad or m) for %s, not \"%s\"", name, value);
        return COMMAND_BAD_INPUT;
    }
    given[joint] = true;
    return COMMAND_DONE;
}

/* --at JOINT=POSITION,... */
static command_status read_positions(const hand *h, char *text, bool *given, double *positions)
{
    command_status status = COMMAND_DONE;
    while (*text && status == COMMAND_DONE) {
        char *value, *name = next_pair(&text, &value);
        if (!name) {
            command_error("hand", "--at: expected JOINT=POSITION, with commas between several");
            return COMMAND_BAD_INPUT;
        }
        status = read_position(h, name, value, given, positions);
    }
    return status;
}

/* Is the joint where --at has it, by itself or by those that it follows? */
static bool is_placed(const hand *h, const bool *given, int joint)
{
    while (joint >= 0 && !given[joint]) {
        int coupling = h->joints[joint].coupling;
        joint = coupling < 0 ? -1 : h->couplings[coupling].of;
    }
    return joint >= 0;
}

/* The positions, with those that follow, within the limits of the joints. */
static command_status check_limits(const hand *h, const bool *given, const double *positions)
{
    for (size_t i = 0; i < h->joint_count; i++) {
        const hand_joint *j = &h->joints[i];
        bool fits = positions[i] >= j->lower - ROUNDING && positions[i] <= j->upper + ROUNDING;
        if (!j->limited || fits || !is_placed(h, given, (int)i)) continue;
        command_error("hand", "--at: expected a position of %s from %g to %g, got %.10g", j->name, j->lower, j->upper,
                      positions[i]);
        return COMMAND_BAD_INPUT;
    }
    return COMMAND_DONE;
}

/* A joint that follows another one may be given, too, but not elsewhere. */
static command_status check_couplings(const hand *h, const bool *given, const double *positions)
{
    for (size_t k = 0; k < h->coupling_count; k++) {
        const hand_coupling *c = &h->couplings[k];
        double position = c->offset + (c->of < 0 ? 0 : c->multiplier * positions[c->of]);
        if (!given[c->joint] || fabs(position - positions[c->joint]) <= ROUNDING) continue;
        command_error("hand", "--at: expected %s at %.10g, where %s takes it, got %.10g", h->joints[c->joint].name,
                      position, c->of < 0 ? "its coupling" : h->joints[c->of].name, positions[c->joint]);
        return COMMAND_BAD_INPUT;
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
    if (status == COMMAND_DONE) status = check_limits(h, c->given, c->positions);
    if (status == COMMAND_DONE) status = check_couplings(h, c->given, c->positions);
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

/* ---- The picture. ---- */

/* A scene with the hand alone, but for the object that a scene must have. NULL when memory runs out. */
static json_t *picture_scene(const char *file, const hand *h, const configuration *c, const hand_package *packages,
                             size_t package_count)
{
    json_t *joints = json_object(), *directories = json_object();
    bool fine = joints && directories;
    for (size_t i = 0; i < h->joint_count && fine; i++)
        if (c->given[i]) fine = json_object_set_new(joints, h->joints[i].name, json_number(c->positions[i])) == 0;
    for (size_t i = 0; i < package_count && fine; i++)
        fine = json_object_set_new(directories, packages[i].name, json_string(packages[i].directory)) == 0;
    json_t *document = fine ? json_pack("{s:s, s:{s:{s:s, s:f}, s:f}, s:{s:s, s:O, s:O}}", "format", "pinch-scene/1",
                                        "object", "shape", "type", "sphere", "radius", 0.001, "mass", 0.001, "hand",
                                        "file", file, "joints", joints, "packages", directories)
                            : NULL;
    json_decref(joints);
    json_decref(directories);
    return document;
}

static command_status write_picture(const char *path, const scene *s)
{
    char error[256];
    world *w;
    world_settings settings = world_default_settings(s);
    if (world_create(s, &settings, &w, error) != WORLD_OK) {
        command_error("hand", "%s", error);
        return COMMAND_SYSTEM;
    }
    film *picture = film_of_hands(w);
    whole_file file;
    command_status status = COMMAND_SYSTEM;
    if (!picture) {
        command_error("hand", "out of memory");
    } else if (!whole_file_open(&file, path)) {
        (void)command_cannot_write("hand", path);
    } else {
        bool drawn = gltf_write(picture, file.stream), written = whole_file_close(&file, drawn);
        if (!drawn)
            command_error("hand", "out of memory");
        else if (!written)
            (void)command_cannot_write("hand", path);
        status = drawn && written ? COMMAND_DONE : COMMAND_SYSTEM;
    }
    film_free(picture);
    world_free(w);
    return status;
}

/* The scene of the picture is of this command's making: its file, lines and keys say nothing to anybody. */
static void tell_why(const options *o, const scene_error *error)
{
    const char *expected = strstr(error->text, "expected "), *joints = strstr(error->text, "hand.joints");
    bool at = o->at && joints && expected && joints < expected;
    if (expected)
        command_error("hand", "%s: %s", at ? "--at" : o->arguments[0], expected);
    else
        command_error("hand", "%s", error->text);
}

/* The hand as it is listed, joints at --at, as a glTF file. */
static command_status draw(const options *o, const hand *h, const configuration *c, const hand_package *packages,
                           size_t package_count)
{
    scene *s = NULL;
    scene_error error = {"out of memory"};
    for (size_t i = 0; i <= package_count; i++) {
        const char *path = i < package_count ? packages[i].directory : o->arguments[0];
        if (utf8_is(path) && (i == package_count || utf8_is(packages[i].name))) continue;
        command_error("hand", "%s: --gltf makes a scene of it: expected a name in UTF-8", path);
        return COMMAND_BAD_INPUT;
    }
    json_t *document = picture_scene(o->arguments[0], h, c, packages, package_count);
    scene_status loaded = document ? scene_load_document("--at", "", 0, document, &s, &error) : SCENE_NO_MEMORY;
    json_decref(document);
    if (loaded == SCENE_OK && command_check_scene_files(o, s) != COMMAND_DONE) {
        scene_free(s);
        return COMMAND_BAD_INPUT;
    }
    if (loaded != SCENE_OK) {
        tell_why(o, &error);
        return loaded == SCENE_NO_MEMORY ? COMMAND_SYSTEM : COMMAND_BAD_INPUT;
    }
    dInitODE2(0);
    command_status status = write_picture(o->gltf, s);
    dCloseODE();
    scene_free(s);
    return status;
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
        if (loaded == HAND_BAD_INPUT) terminal_print(stderr, "%s\n", error.text);
    }
    if (status == COMMAND_DONE) status = place(o, h, &c);
    if (status == COMMAND_SYSTEM) command_error("hand", "out of memory");
    if (status == COMMAND_DONE && o->gltf) status = draw(o, h, &c, packages, package_count);
    if (status == COMMAND_DONE && show(o, h, &c) != COMMAND_DONE) {
        command_error("hand", "out of memory");
        status = COMMAND_SYSTEM;
    }
    free(c.given);
    free(c.positions);
    free(c.poses);
    free(c.text);
    free(text);
    hand_free(h);
    return status;
}

static const option_id hand_options[] = {OPTION_AT,   OPTION_PACKAGE, OPTION_GLTF,
                                         OPTION_JSON, OPTION_QUIET,   OPTION_COUNT};

const command command_hand = {
    .name = "hand",
    .arguments = "FILE",
    .summary = "shows a robot hand as it was read from a URDF or MJCF file",
    .notes = "The first element of the file says which format it has: <robot> is URDF, <mujoco> is MJCF.\n"
             "What is IGNORED does not change the physics; what is NOT MODELLED does.\n"
             "--gltf draws the hand with its joints where --at has them.\n"
             "--json also has the pose of every link, with joints that --at does not name at their references.",
    .min_arguments = 1,
    .max_arguments = 1,
    .files = "urdf xml mjcf",
    .options = hand_options,
    .run = run_hand,
};
