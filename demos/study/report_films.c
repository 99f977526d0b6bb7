/* Chosen trials, run again for their pictures and films. */
#include "report_parts.h"
#include "trial.h"

#include "view/thumbnail.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { FAILURES = 6, UNSOLVED = 2, DIFFERING = 3, RATE = 25 };

/* A trial that is shown, in one of its runs. */
typedef struct chosen {
    long trial;
    int run;
    world_solver other; /* whose run is shown beside it; the study's own solver: nobody's */
    double other_step;
    const char *why;
} chosen;

/* ---- A run as a film. ---- */

typedef struct camera_crew {
    film *film;
    bool meshes, failed; /* memory ran out */
    size_t moment;       /* of the picture */
    double time;         /* s, of the moment */
    FILE *picture;       /* NULL: none is drawn */
    json_t *data;        /* what the page plays */
} camera_crew;

static void take_step(void *context, const world *w)
{
    camera_crew *c = context;
    if (c->failed) return;
    if (!c->film) c->film = film_start(w, RATE);
    c->failed = !c->film || !film_step(c->film, w);
}

static void take_end(void *context, const world *w, const simulation_result *result)
{
    (void)result;
    camera_crew *c = context;
    if (!c->film || c->failed || !film_finish(c->film, w)) return;
    c->moment = thumbnail_last_touch(c->film);
    c->time = c->film->frames[c->moment].time;
    if (c->picture) thumbnail_write(c->film, c->moment, c->picture);
    c->data = page_film(c->film, c->meshes);
}

static json_t *film_of(const study *s, const chosen *which, bool meshes, FILE *picture, double *moment)
{
    camera_crew c = {.meshes = meshes, .picture = picture};
    trial_watch watch = {.step = take_step, .finish = take_end, .context = &c};
    json_t *inputs = study_draw(s, which->trial);
    study plain = *s;
    plain.record_count = 0;
    if (!inputs) return NULL;
    trial_outcome o = trial_run_once(&plain, inputs, which->run, &watch);
    json_decref(o.recorded);
    json_decref(inputs);
    film_free(c.film);
    *moment = c.time;
    return c.data;
}

/* ---- Which ones. ---- */

typedef struct choice {
    chosen *list;
    int count, room;
} choice;

static int run_called(const study *s, const char *direction)
{
    for (int run = 0; direction && run < protocol_runs(&s->protocol, 3); run++)
        if (strcmp(protocol_direction(&s->protocol, run), direction) == 0) return run;
    return 0;
}

typedef struct choosing {
    const study *s;
    choice *c;
    const char *why;
    world_solver other;
    double other_step;
} choosing;

static bool take_choice(void *context, const json_t *names, json_t *row)
{
    (void)names;
    choosing *k = context;
    if (k->c->count == k->c->room) return false;
    chosen *new = &k->c->list[k->c->count++];
    *new = (chosen){(long)json_integer_value(json_array_get(row, 0)),
                    run_called(k->s, json_string_value(json_array_get(row, 1))), k->other, k->other_step, k->why};
    return true;
}

/* The failures are taken from all over the study: the middle one of each of so many equal parts. */
static bool choose_failures(results *r, const study *s, choice *c, results_error *error)
{
    char query[1024];
    choosing failed = {s, c, "failed", s->contact_solver, 0}, unsolved = {s, c, "not solved", s->contact_solver, 0};
    snprintf(query, sizeof query,
             "SELECT \"index\", (SELECT direction FROM directions WHERE trial = \"index\" AND exit IN (1, 3) LIMIT 1) "
             "FROM trials WHERE exit IN (1, 3) ORDER BY \"index\" LIMIT %d",
             UNSOLVED);
    if (!results_query(r, query, take_choice, &unsolved, error)) return false;
    snprintf(query, sizeof query,
             "SELECT i, (SELECT direction FROM directions WHERE trial = i AND NOT success LIMIT 1) FROM (SELECT "
             "\"index\" AS i, ntile(%d) OVER (ORDER BY \"index\") AS part, row_number() OVER (ORDER BY \"index\") AS "
             "place FROM trials WHERE exit = 0 AND NOT success) GROUP BY part HAVING place = min(place) ORDER BY 1",
             FAILURES);
    return results_query(r, query, take_choice, &failed, error);
}

static bool take_peer(void *context, const json_t *names, json_t *row)
{
    (void)names;
    choosing *k = context;
    const char *name = json_string_value(json_array_get(row, 0));
    for (int w = WORLD_PINCH; name && w <= WORLD_WORLDSTEP; w++)
        if (strcmp(world_solver_name((world_solver)w), name) == 0) k->other = (world_solver)w;
    k->other_step = json_number_value(json_array_get(row, 1));
    return false;
}

static bool choose_differing(results *r, const study *s, choice *c, results_error *error)
{
    char query[512];
    choosing k = {s, c, "verdicts differ", s->contact_solver, 0};
    snprintf(query, sizeof query,
             "SELECT \"index\", (SELECT d.direction FROM directions d JOIN beside.directions e USING (trial, direction)"
             " WHERE trial = \"index\" AND d.success <> e.success LIMIT 1) FROM trials t JOIN beside.trials o USING "
             "(\"index\") WHERE t.success <> o.success ORDER BY 1 LIMIT %d",
             DIFFERING);
    return results_query(r, "SELECT contact_solver, step FROM beside.study", take_peer, &k, error) &&
           results_query(r, query, take_choice, &k, error);
}

/* ---- On the page. ---- */

static void write_title(const study *s, const chosen *which, char *title, size_t room)
{
    const char *direction = protocol_direction(&s->protocol, which->run);
    snprintf(title, room, "Trial %ld%s%s: %s", which->trial, *direction ? ", force along " : "", direction, which->why);
}

static bool write_chosen(const study *s, const chosen *which, const char *command, json_t *films, FILE *stream)
{
    char title[128];
    double moment = NAN, other_moment;
    json_t *ghost = json_null();
    write_title(s, which, title, sizeof title);
    fprintf(stream, "<figure><button type=\"button\" data-film=\"%zu\" aria-label=\"%s: play\">",
            json_array_size(films), title);
    json_t *played = film_of(s, which, true, stream, &moment);
    fprintf(stream, "</button><figcaption>%s<br><code>", title);
    page_text(command, stream);
    fprintf(stream, " --trial %ld --view trial-%ld.html</code></figcaption></figure>\n", which->trial, which->trial);
    if (played && which->other != s->contact_solver) {
        study other = *s;
        other.contact_solver = which->other;
        other.step = which->other_step;
        ghost = film_of(&other, which, false, NULL, &other_moment);
    }
    return played && ghost &&
           json_array_append_new(films, json_pack("{s:s, s:o, s:o, s:f}", "title", title, "film", played, "ghost",
                                                  ghost, "moment", moment)) == 0;
}

json_t *report_films(results *r, const study *s, const char *command, bool beside, FILE *stream, results_error *error)
{
    chosen list[FAILURES + UNSOLVED + DIFFERING];
    choice c = {list, 0, FAILURES + UNSOLVED + DIFFERING};
    json_t *films = json_array();
    /* of a search each picture would take the whole search once more */
    bool good = s->least.path || ((!beside || choose_differing(r, s, &c, error)) && choose_failures(r, s, &c, error));
    if (good && c.count > 0)
        fputs("<h2 id=\"pictures\">Pictures</h2><p>Failures from all over the study, and trials on which other results "
              "differ, at the moment of the last touch. Press one to play it.</p>\n<div class=\"gallery\">\n",
              stream);
    for (int i = 0; i < c.count && good; i++) {
        good = write_chosen(s, &list[i], command, films, stream);
        if (!good) *error = (results_error){.status = COMMAND_SYSTEM, .text = "out of memory"};
    }
    if (good && c.count > 0) fputs("</div>\n<h3 id=\"view-title\"></h3>\n<section id=\"view\"></section>\n", stream);
    if (good) return json_pack("{s:o}", "films", films);
    json_decref(films);
    return NULL;
}
