/* Two solvers on the same trials. */
#include "beside.h"
#include "conduct.h"
#include "trial.h"

#include "common/output.h"

#include <stdlib.h>
#include <string.h>

/* ---- Refinement of a trial. ---- */

static json_t *row_of(const crew_order *order, int halvings, const json_t *trial)
{
    const json_t *recorded = json_object_get(trial, "recorded");
    return json_pack("{s:I, s:s, s:f, s:i, s:O, s:O, s:O, s:O?, s:O?, s:O, s:O}", "trial", (json_int_t)order->first,
                     "contact_solver", world_solver_name((world_solver)(order->kind - 1)), "step", order->value,
                     "halvings", halvings, "status", json_object_get(trial, "status"), "success",
                     json_object_get(trial, "success"), "exit", json_object_get(trial, "exit"), "displacement",
                     json_object_get(recorded, "displacement"), "rotation", json_object_get(recorded, "rotation"),
                     "wall_time", json_object_get(trial, "wall_time"), "hash", json_object_get(trial, "hash"));
}

json_t *beside_refine(const study *s, const crew_order *order, long index)
{
    study finer = *s;
    finer.contact_solver = (world_solver)(order->kind - 1);
    finer.step = order->value;
    finer.record_count = 0;
    json_t *rows = json_array(), *trial;
    crew_order this_one = *order;
    this_one.first = index;
    bool before = false;
    double wall_time = 0.0;
    for (int stays = 0; rows && finer.halvings <= BESIDE_MOST_HALVINGS && stays < BESIDE_STAYS; finer.halvings++) {
        trial = trial_run(&finer, index);
        bool success = json_is_true(json_object_get(trial, "success"));
        stays = finer.halvings > 0 && success == before ? stays + 1 : 0;
        before = success;
        wall_time += json_number_value(json_object_get(trial, "wall_time"));
        bool added = trial && json_array_append_new(rows, row_of(&this_one, finer.halvings, trial)) == 0;
        json_decref(trial);
        if (added) continue;
        json_decref(rows);
        return NULL;
    }
    return json_pack("{s:o, s:f}", "rows", rows, "wall_time", wall_time);
}

json_t *beside_crash(const crew_order *order, const char *status)
{
    json_t *trial = json_pack("{s:s, s:b, s:i, s:{}, s:f, s:s}", "status", status, "success", 0, "exit", 3, "recorded",
                              "wall_time", 0.0, "hash", "");
    json_t *rows = json_pack("{s:[o], s:f}", "rows", row_of(order, 0, trial), "wall_time", 0.0);
    json_decref(trial);
    return rows;
}

/* ---- What is to be refined. ---- */

/* How the other results were made. */
typedef struct peer {
    char results[4096], solver[32];
    double step;
    bool found;
} peer;

static bool take_peer(void *context, const json_t *names, json_t *row)
{
    (void)names;
    peer *p = context;
    const char *solver = json_string_value(json_array_get(row, 0)), *file = json_string_value(json_array_get(row, 2));
    snprintf(p->solver, sizeof p->solver, "%s", solver ? solver : "");
    snprintf(p->results, sizeof p->results, "%s", file ? file : "");
    p->step = json_number_value(json_array_get(row, 1));
    p->found = true;
    return false;
}

static bool find_peer(results *r, peer *p, results_error *error)
{
    p->found = false;
    return results_query(r,
                         "SELECT contact_solver, step, (SELECT file FROM pragma_database_list WHERE name = 'beside') "
                         "FROM beside.study",
                         take_peer, p, error) &&
           p->found;
}

static int kind_of(const char *solver)
{
    int kind = WORLD_PINCH;
    while (kind < WORLD_WORLDSTEP && strcmp(world_solver_name((world_solver)kind), solver) != 0) kind++;
    return kind + 1;
}

static const char differing[] =
    "SELECT t.\"index\" FROM trials t JOIN beside.trials o USING (\"index\") WHERE t.success "
    "<> o.success ORDER BY 1";

static bool take_number(void *context, const json_t *names, json_t *row)
{
    (void)names;
    return json_array_append(context, json_array_get(row, 0)) == 0;
}

/* Has the trial been refined by this solver? Those of a killed process are added as a whole or not at all. */
static int is_refined(results *r, const crew_order *order, results_error *error)
{
    char query[256];
    json_t *found = json_array();
    snprintf(query, sizeof query,
             "SELECT 1 FROM refinements WHERE trial = %ld AND contact_solver = '%s' AND step = %.17g LIMIT 1",
             order->first, world_solver_name((world_solver)(order->kind - 1)), order->value);
    bool good = results_query(r, query, take_number, found, error);
    int is = good ? json_array_size(found) > 0 : -1;
    json_decref(found);
    return is;
}

bool beside_orders(results *r, const study *s, int most, crew_order **list, size_t *count, results_error *error)
{
    peer p;
    json_t *trials = json_array();
    *list = NULL;
    *count = 0;
    bool good = find_peer(r, &p, error) && results_query(r, differing, take_number, trials, error);
    size_t wanted = json_array_size(trials) < (size_t)most ? json_array_size(trials) : (size_t)most;
    if (good) *list = malloc((2 * wanted + 1) * sizeof **list);
    for (size_t i = 0; *list && i < 2 * wanted && good; i++) {
        bool here = i % 2 == 0;
        crew_order o = {.first = (long)json_integer_value(json_array_get(trials, i / 2)), .count = 1};
        o.kind = here ? (int)s->contact_solver + 1 : kind_of(p.solver);
        o.value = here ? s->step : p.step;
        int is = is_refined(r, &o, error);
        good = is >= 0;
        if (is == 0) (*list)[(*count)++] = o;
    }
    json_decref(trials);
    return good && *list;
}

/* ---- What came of it. ---- */

typedef struct verdicts {
    json_t *list;
    bool success[BESIDE_MOST_HALVINGS + 1];
    int count;
} verdicts;

static bool take_verdict(void *context, const json_t *names, json_t *row)
{
    (void)names;
    verdicts *v = context;
    bool success = json_integer_value(json_array_get(row, 1)) != 0;
    if (v->count <= BESIDE_MOST_HALVINGS) v->success[v->count++] = success;
    json_array_append_new(v->list, json_pack("{s:O, s:b, s:O, s:O, s:O}", "step_halvings", json_array_get(row, 0),
                                             "success", (int)success, "status", json_array_get(row, 2), "displacement",
                                             json_array_get(row, 3), "rotation", json_array_get(row, 4)));
    return true;
}

static bool find_verdicts(results *r, long trial, const char *solver, double step, verdicts *v, results_error *error)
{
    char query[512];
    *v = (verdicts){.list = json_array()};
    snprintf(query, sizeof query,
             "SELECT halvings, success, status, displacement, rotation FROM refinements WHERE trial = %ld AND "
             "contact_solver = '%s' AND step = %.17g ORDER BY halvings",
             trial, solver, step);
    return results_query(r, query, take_verdict, v, error);
}

static bool has_come_to_rest(const verdicts *v)
{
    if (v->count <= BESIDE_STAYS) return false;
    for (int i = 1; i <= BESIDE_STAYS; i++)
        if (v->success[v->count - 1 - i] != v->success[v->count - 1]) return false;
    return true;
}

static const char *who_is_right(const verdicts *here, const verdicts *beside)
{
    if (!has_come_to_rest(here) || !has_come_to_rest(beside)) return "open";
    bool verdict = here->success[here->count - 1];
    if (verdict != beside->success[beside->count - 1]) return "each of its own law";
    return here->success[0] == verdict ? "here" : "beside";
}

static bool add_refined(results *r, const study *s, const peer *p, long trial, json_t *list, results_error *error)
{
    verdicts here = {.list = NULL}, beside = {.list = NULL};
    bool good = find_verdicts(r, trial, world_solver_name(s->contact_solver), s->step, &here, error) &&
                find_verdicts(r, trial, p->solver, p->step, &beside, error);
    if (good && here.count > 0 && beside.count > 0)
        json_array_append_new(list, json_pack("{s:I, s:O, s:O, s:s}", "trial", (json_int_t)trial, "here", here.list,
                                              "beside", beside.list, "right", who_is_right(&here, &beside)));
    json_decref(here.list);
    json_decref(beside.list);
    return good;
}

static bool take_counts(void *context, const json_t *names, json_t *row)
{
    for (size_t i = 0; i < json_array_size(names); i++)
        json_object_set(context, json_string_value(json_array_get(names, i)), json_array_get(row, i));
    return true;
}

json_t *beside_document(results *r, const study *s, results_error *error)
{
    static const char counting[] =
        "SELECT count(*) AS compared, count(*) FILTER (WHERE t.success AND o.success) AS both_succeed,"
        " count(*) FILTER (WHERE NOT t.success AND NOT o.success) AS both_fail,"
        " count(*) FILTER (WHERE t.success AND NOT o.success) AS only_here,"
        " count(*) FILTER (WHERE NOT t.success AND o.success) AS only_beside"
        " FROM trials t JOIN beside.trials o USING (\"index\")";
    peer p;
    json_t *counts = json_object(), *trials = json_array(), *refined = json_array();
    bool good = find_peer(r, &p, error) && results_query(r, counting, take_counts, counts, error) &&
                results_query(r, differing, take_number, trials, error);
    for (size_t i = 0; i < json_array_size(trials) && good; i++)
        good = add_refined(r, s, &p, (long)json_integer_value(json_array_get(trials, i)), refined, error);
    json_t *document = NULL;
    if (good)
        document = json_pack("{s:s, s:s, s:o, s:O, s:O, s:O}", "results", p.results, "contact_solver", p.solver, "step",
                             p.step > 0.0 ? json_real(p.step) : json_null(), "trials", counts, "differing", trials,
                             "refined", refined);
    json_decref(counts);
    json_decref(trials);
    json_decref(refined);
    return document;
}
