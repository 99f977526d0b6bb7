#include "baseline.h"

#include "access.h"
#include "common/input_file.h"
#include "common/output.h"

#include <stdlib.h>

static const char FORMAT[] = "pinch-baseline/1";

const char *baseline_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static json_t *tolerances_document(bool ode)
{
    json_t *document = json_object();
    for (int m = 0; m < METRIC_COUNT; m++) {
        tolerance t = tolerance_default((metric)m, ode);
        if (t.absolute < 0) continue;
        (void)json_object_set_new(document, metric_about((metric)m)->key,
                                  json_pack("{s:f, s:f}", "absolute", t.absolute, "relative", t.relative));
    }
    return document;
}

/* Six digits are finer than any tolerance, and easier to read. */
static json_t *rounded(double value)
{
    char text[32];
    snprintf(text, sizeof text, "%.6g", value);
    return json_number(isnan(value) ? NAN : strtod(text, NULL));
}

/* The baseline has the metrics that have a default tolerance. */
static json_t *run_document(const json_t *run)
{
    bool ode = strcmp(access_text(run, "contact_solver"), "pinch") != 0;
    json_t *document = json_object();
    for (int m = 0; m < METRIC_COUNT; m++) {
        const char *key = metric_about((metric)m)->key;
        double value = access_metric(run, (metric)m);
        if (tolerance_default((metric)m, ode).absolute < 0) continue;
        bool yes_or_no = json_is_boolean(json_object_get(json_object_get(run, "metrics"), key));
        (void)json_object_set_new(document, key, yes_or_no ? json_boolean(value != 0) : rounded(value));
    }
    return document;
}

json_t *baseline_document(const json_t *document, const char *made)
{
    json_t *scenes = json_object();
    const json_t *list = json_object_get(document, "scenes");
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *of_scene = json_array_get(list, i), *runs = json_object_get(of_scene, "runs");
        json_t *metrics = json_object();
        for (size_t k = 0; k < json_array_size(runs); k++) {
            const json_t *run = json_array_get(runs, k);
            (void)json_object_set_new(metrics, access_text(run, "run"), run_document(run));
        }
        json_t *entry = json_pack("{s:O, s:O, s:{}, s:o}", "steps", json_object_get(of_scene, "steps"), "step_s",
                                  json_object_get(of_scene, "step_s"), "tolerances", "runs", metrics);
        (void)json_object_set_new(scenes, baseline_name(access_text(of_scene, "scene")), entry);
    }
    return json_pack("{s:s, s:s, s:O, s:{s:o, s:o}, s:o}", "format", FORMAT, "made", made, "settings",
                     json_object_get(document, "settings"), "tolerances", "pinch", tolerances_document(false), "ode",
                     tolerances_document(true), "scenes", scenes);
}

/* Says what is wrong with the file, and returns false. */
static bool refuse(const char *path, const char *where, const char *expected)
{
    command_error("compare", "%s: %s: expected %s", path, where, expected);
    return false;
}

static bool check_tolerance_list(const char *path, const char *where, const json_t *list)
{
    const char *key;
    json_t *entry;
    char place[256];
    if (!json_is_object(list)) return refuse(path, where, "an object of metrics");
    json_object_foreach((json_t *)list, key, entry)
    {
        snprintf(place, sizeof place, "%.180s.%.60s", where, key);
        if (metric_of_key(key) == METRIC_COUNT) return refuse(path, place, "the name of a metric");
        double absolute = access_number(entry, "absolute"), relative = access_number(entry, "relative");
        if (!(absolute >= 0) || !(relative >= 0) || json_object_size(entry) != 2)
            return refuse(path, place, "\"absolute\" and \"relative\", numbers >= 0");
    }
    return true;
}

static bool check_tolerances(const char *path, const char *where, const json_t *tolerances)
{
    const char *kind;
    json_t *list;
    char place[256];
    if (!json_is_object(tolerances)) return refuse(path, where, "an object with \"pinch\" and \"ode\"");
    json_object_foreach((json_t *)tolerances, kind, list)
    {
        snprintf(place, sizeof place, "%.120s.%.40s", where, kind);
        if (strcmp(kind, "pinch") != 0 && strcmp(kind, "ode") != 0) return refuse(path, place, "\"pinch\" or \"ode\"");
        if (!check_tolerance_list(path, place, list)) return false;
    }
    return true;
}

/* A baseline in which no metric has a tolerance would let everything pass. */
static bool check_common_tolerances(const char *path, const json_t *tolerances)
{
    static const char *const kinds[] = {"pinch", "ode"};
    if (!check_tolerances(path, "tolerances", tolerances)) return false;
    for (int i = 0; i < 2; i++) {
        char place[32];
        snprintf(place, sizeof place, "tolerances.%s", kinds[i]);
        if (json_object_size(json_object_get(tolerances, kinds[i])) == 0)
            return refuse(path, place, "an object with at least one metric");
    }
    return true;
}

static bool check_runs(const char *path, const char *scene_name, const json_t *runs)
{
    const char *name, *key;
    json_t *metrics, *value;
    char place[256];
    snprintf(place, sizeof place, "scenes.%.80s.runs", scene_name);
    if (json_object_size(runs) == 0) return refuse(path, place, "an object with at least one run");
    json_object_foreach((json_t *)runs, name, metrics)
    {
        snprintf(place, sizeof place, "scenes.%.80s.runs.%.40s", scene_name, name);
        if (json_object_size(metrics) == 0) return refuse(path, place, "an object with at least one metric");
        json_object_foreach(metrics, key, value)
        {
            snprintf(place, sizeof place, "scenes.%.80s.runs.%.40s.%.60s", scene_name, name, key);
            if (metric_of_key(key) == METRIC_COUNT) return refuse(path, place, "the name of a metric");
            if (!json_is_number(value) && !json_is_boolean(value) && !json_is_null(value))
                return refuse(path, place, "a number, true, false or null");
        }
    }
    return true;
}

static bool check_file(const char *path, const json_t *baseline)
{
    const char *name;
    json_t *one;
    char place[256];
    if (strcmp(access_text(baseline, "format"), FORMAT) != 0) return refuse(path, "format", "\"pinch-baseline/1\"");
    if (!check_common_tolerances(path, json_object_get(baseline, "tolerances"))) return false;
    const json_t *scenes = json_object_get(baseline, "scenes");
    if (!json_is_object(scenes)) return refuse(path, "scenes", "an object of scenes");
    json_object_foreach((json_t *)scenes, name, one)
    {
        snprintf(place, sizeof place, "scenes.%.80s.tolerances", name);
        if (!check_runs(path, name, json_object_get(one, "runs")) ||
            !check_tolerances(path, place, json_object_get(one, "tolerances")))
            return false;
    }
    return true;
}

command_status baseline_load(const char *path, char *const *scenes, int count, json_t **baseline)
{
    json_error_t error;
    char fault[128];
    FILE *stream = input_open_regular(path, fault);
    if (!stream) {
        command_error("compare", "%s: cannot be read: %s", path, *fault ? fault : "out of memory");
        return *fault ? COMMAND_BAD_INPUT : COMMAND_SYSTEM;
    }
    *baseline = input_load_json(stream, &error);
    fclose(stream);
    if (!*baseline) {
        command_error("compare", "%s: line %d: %s", path, error.line, input_json_fault(&error));
        return COMMAND_BAD_INPUT;
    }
    bool fine = check_file(path, *baseline);
    for (int i = 0; i < count && fine; i++) {
        const char *name = baseline_name(scenes[i]);
        if (json_object_get(json_object_get(*baseline, "scenes"), name)) continue;
        command_error("compare", "%s: has no scene %s", path, name);
        fine = false;
    }
    if (fine) return COMMAND_DONE;
    json_decref(*baseline);
    *baseline = NULL;
    return COMMAND_BAD_INPUT;
}

/* The scene's own tolerance, or else the common one. absolute < 0 means that there is none. */
static tolerance tolerance_of(const json_t *baseline, const json_t *of_scene, bool ode, const char *key)
{
    const json_t *sources[2] = {of_scene, baseline};
    for (int i = 0; i < 2; i++) {
        const json_t *entry =
            json_object_get(json_object_get(json_object_get(sources[i], "tolerances"), ode ? "ode" : "pinch"), key);
        if (entry) return (tolerance){access_number(entry, "absolute"), access_number(entry, "relative")};
    }
    return (tolerance){-1, 0};
}

/* A metric that is not where the baseline has it. */
typedef struct move {
    const char *scene, *run, *metric, *unit;
    double from, to, limit;
} move;

static void add_move(json_t *moves, const move *m)
{
    (void)json_array_append_new(moves, json_pack("{s:s, s:s, s:s, s:o, s:o, s:o, s:o, s:s}", "scene", m->scene, "run",
                                                 m->run, "metric", m->metric, "from", json_number(m->from), "to",
                                                 json_number(m->to), "by", json_number(m->to - m->from), "limit",
                                                 json_number(m->limit), "unit", m->unit));
}

/* A run or a metric that the baseline lacks has moved from nothing: it is never passed over. */
static void check_run(const json_t *baseline, const json_t *of_scene, const char *name, const json_t *run,
                      const json_t *metrics, json_t *moves)
{
    bool ode = strcmp(access_text(run, "contact_solver"), "pinch") != 0;
    if (!metrics) add_move(moves, &(move){name, access_text(run, "run"), "run", "1", NAN, 1, 0});
    for (int m = 0; m < METRIC_COUNT; m++) {
        const metric_info *about = metric_about((metric)m);
        const json_t *known = json_object_get(metrics, about->key);
        tolerance t = tolerance_of(baseline, of_scene, ode, about->key);
        if (!metrics || t.absolute < 0) continue;
        double from = access_value(known), to = access_metric(run, (metric)m);
        if (isnan(from) && isnan(to)) continue;
        double limit = t.absolute + (isnan(from) ? 0 : t.relative * fabs(from));
        if (!(fabs(to - from) <= limit))
            add_move(moves, &(move){name, access_text(run, "run"), about->key, about->unit, from, to, limit});
    }
}

json_t *baseline_check(const json_t *baseline, const json_t *document)
{
    json_t *moves = json_array();
    const json_t *list = json_object_get(document, "scenes");
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *of_scene = json_array_get(list, i), *runs = json_object_get(of_scene, "runs");
        const char *name = baseline_name(access_text(of_scene, "scene"));
        const json_t *known = json_object_get(json_object_get(baseline, "scenes"), name);
        static const char *const keys[] = {"steps", "step_s"}, *const units[] = {"1", "s"};
        for (int m = 0; m < 2; m++) {
            double from = access_number(known, keys[m]), to = access_number(of_scene, keys[m]);
            if (from != to) add_move(moves, &(move){name, "all", keys[m], units[m], from, to, 0});
        }
        for (size_t k = 0; k < json_array_size(runs); k++) {
            const json_t *run = json_array_get(runs, k);
            check_run(baseline, known, name, run,
                      json_object_get(json_object_get(known, "runs"), access_text(run, "run")), moves);
        }
    }
    return moves;
}
