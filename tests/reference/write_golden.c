/*
 * Writes assets/reference/fields.json and hashes.json: how the scenes named on the command line end now. Run it in the
 * repository, with all scenes, after a change that is meant to change them:
 *
 *     build/release/tests/write_golden assets/reference assets/scenes/[name].json ...
 */
#include "scenes/world/simulation.h"
#include "support/platform.h"
#include "support/program.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void put(FILE *stream, const char *before, const double *v, int count)
{
    fputs(before, stream);
    for (int i = 0; i < count; i++) fprintf(stream, "%s%.17g", i ? ", " : "[", v[i]);
    fputc(']', stream);
}

static int run(const char *path, bool last, FILE *fields, FILE *hashes)
{
    scene *s;
    scene_error error;
    world *w;
    char text[256];
    if (scene_load(path, &s, &error) != SCENE_OK) {
        fprintf(stderr, "%s\n", error.text);
        return 1;
    }
    world_settings settings = world_default_settings(s);
    if (world_create(s, &settings, &w, text) != WORLD_OK) {
        fprintf(stderr, "%s: %s\n", path, text);
        return 1;
    }
    long steps = lround(s->duration / s->step);
    while (w->steps < steps)
        if (world_advance(w) != WORLD_OK) return 1;
    fprintf(fields, "    \"%s\": {", file_name(path));
    put(fields, "\"position\": ", dBodyGetPosition(w->object), 3);
    put(fields, ", \"orientation\": ", dBodyGetQuaternion(w->object), 4);
    for (int i = 0; i < w->finger_count; i++) put(fields, i ? ", " : ", \"forces\": [", w->fingers[i].state.force, 3);
    fprintf(fields, "]}%s\n", last ? "" : ",");
    fprintf(hashes, "    \"%s\": \"%016" PRIx64 "\"%s\n", file_name(path), world_hash(w), last ? "" : ",");
    world_free(w);
    scene_free(s);
    return 0;
}

int main(int argc, char **argv)
{
    char path[2][1024];
    if (argc < 3) {
        fprintf(stderr, "usage: write_golden FOLDER SCENE...\n");
        return 2;
    }
    snprintf(path[0], sizeof path[0], "%s/fields.json", argv[1]);
    snprintf(path[1], sizeof path[1], "%s/hashes.json", argv[1]);
    FILE *fields = fopen(path[0], "w"), *hashes = fopen(path[1], "w");
    if (!fields || !hashes) {
        fprintf(stderr, "cannot write into %s\n", argv[1]);
        return 3;
    }
    fputs(
        "{\n  \"made\": \"by tests/reference/write_golden.c: each scene run for its duration with Pinch's defaults; "
        "position (m) and orientation of the object and forces of the fingers on it (N) in the last step. Compared to "
        "1e-9.\",\n  \"scenes\": {\n",
        fields);
    dInitODE2(0);
    fprintf(
        hashes,
        "{\n  \"made\": \"by tests/reference/write_golden.c: FNV-1a over the bits of each scene's final state, as in "
        "pinch run --json. tests/determinism compares them where versions and fingerprint are the same; elsewhere the "
        "bits may differ.\",\n  \"versions\": \"%s\",\n  \"fingerprint\": \"%016" PRIx64 "\",\n  \"scenes\": {\n",
        platform_versions(), platform_fingerprint());
    int failed = 0;
    for (int i = 2; i < argc && !failed; i++) failed = run(argv[i], i + 1 == argc, fields, hashes);
    dCloseODE();
    fputs("  }\n}\n", fields);
    fputs("  }\n}\n", hashes);
    return fclose(fields) || fclose(hashes) || failed ? 1 : 0;
}
