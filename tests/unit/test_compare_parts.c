/*
 * Tests the parts of `pinch compare` by themselves: what the observer measures, which steps are chosen, files, pages,
 * jobs.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/scene_run.h"

#include "common/jobs.h"
#include "common/whole_file.h"
#include "compare/report/report.h"
#include "compare/sample.h"
#include "compare/solver_run.h"
#include "support/program.h"

#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { STEPS = 400 };

/* A world that is not stepped: its states are written by the test. */
typedef struct fake {
    scene *s;
    world *w;
    observer r;
} fake;

static fake make_fake(const char *name)
{
    fake f = {.s = scene_shipped(name)};
    f.w = world_of(f.s);
    assert_true(observer_start(&f.r, f.w, STEPS));
    return f;
}

static void after_step(fake *f, const observer *peer)
{
    f->w->steps++;
    f->w->time = (double)f->w->steps * f->s->step;
    observer_after_step(&f->r, peer);
}

static void metrics_of(fake *f, double metrics[METRIC_COUNT])
{
    for (int m = 0; m < METRIC_COUNT; m++) metrics[m] = NAN;
    observer_metrics(&f->r, metrics);
}

static void free_fake(fake *f)
{
    observer_free(&f->r);
    world_free(f->w);
    scene_free(f->s);
}

/* A force that grows steadily has no jitter; one that alternates by +-a has second differences of 4 a, as much as noise
 * of 4 a / sqrt 6. */
static void test_jitter(void **state)
{
    (void)state;
    for (int alternates = 0; alternates < 2; alternates++) {
        fake f = make_fake("egg.json");
        double metrics[METRIC_COUNT];
        for (int k = 0; k < STEPS; k++) {
            observer_before_step(&f.r);
            f.w->fingers[1].state.force[2] = alternates ? (k % 2 ? 0.01 : -0.01) : 0.5 * k;
            after_step(&f, NULL);
        }
        metrics_of(&f, metrics);
        assert_close(metrics[METRIC_FORCE_JITTER], alternates ? 0.04 / sqrt(6) : 0, 1e-12);
        free_fake(&f);
    }
}

/* The object 0.5 mm away from step 100 on, then turned as well: hypot of distance and angle times radius. What it is
 * compared with has left for good when it is looked at: a step counts, not a state. */
static void test_divergence(void **state)
{
    (void)state;
    fake f = make_fake("egg.json"), peer = make_fake("egg.json");
    for (int k = 0; k < STEPS; k++) after_step(&peer, NULL);
    dBodySetPosition(peer.w->object, 1, 1, 1);
    double metrics[METRIC_COUNT], radius = f.s->objects[0].shape.bounding_radius;
    const double *x = dBodyGetPosition(f.w->object);
    for (int k = 1; k <= STEPS; k++) {
        observer_before_step(&f.r);
        if (k == 100) dBodySetPosition(f.w->object, x[0], x[1] + 5e-4, x[2]);
        if (k == 300) dBodySetQuaternion(f.w->object, (dQuaternion){cos(0.05), sin(0.05), 0, 0});
        after_step(&f, &peer.r);
    }
    metrics_of(&f, metrics);
    assert_close(metrics[METRIC_DIVERGES_1UM], 100 * f.s->step, 1e-12);
    assert_close(metrics[METRIC_DIVERGES_100UM], 100 * f.s->step, 1e-12);
    assert_close(metrics[METRIC_DIVERGES_1MM], 300 * f.s->step, 1e-12);
    assert_true(isnan(metrics[METRIC_DIVERGES_10MM]));
    assert_close(metrics[METRIC_DIVERGENCE_END], hypot(5e-4, 0.1 * radius), 1e-12);
    assert_close(metrics[METRIC_DISPLACEMENT], 5e-4, 1e-15);
    assert_close(metrics[METRIC_ROTATION], 0.1, 1e-12);
    free_fake(&f);
    free_fake(&peer);
}

/* A velocity that no force explains, m dv/h; and forces that explain it. */
static void test_momentum(void **state)
{
    (void)state;
    fake f = make_fake("egg.json");
    double metrics[METRIC_COUNT], force[3], torque[3], mass = f.s->objects[0].mass, h = f.s->step;
    world_external_wrench(f.w, 0, force, torque);
    observer_before_step(&f.r);
    dBodySetLinearVel(f.w->object, 0, 2e-3, h * force[2] / mass);
    f.w->fingers[0].state.force[1] = mass * 2e-3 / h;
    after_step(&f, NULL);
    metrics_of(&f, metrics);
    assert_close(metrics[METRIC_MOMENTUM_ERROR], 0, 1e-12);

    observer_before_step(&f.r);
    f.w->fingers[0].state.force[1] = 0.25; /* and the object falls no faster: the load is unexplained, too */
    after_step(&f, NULL);
    metrics_of(&f, metrics);
    assert_close(metrics[METRIC_MOMENTUM_ERROR], hypot(0.25, force[2]), 1e-12);
    free_fake(&f);
}

/* A tip off its rail, and turned; along the rail it may go. */
static void test_constraint(void **state)
{
    (void)state;
    fake f = make_fake("pinched-capsule.json");
    double metrics[METRIC_COUNT];
    dBodyID tip = f.w->fingers[0].body;
    const double *x = dBodyGetPosition(tip), *n = f.w->fingers[0].finger->normal;
    assert_non_null(f.w->fingers[0].slider);
    observer_before_step(&f.r);
    dBodySetPosition(tip, x[0] + 0.01 * n[0], x[1] + 0.01 * n[1], x[2] + 0.01 * n[2]);
    after_step(&f, NULL);
    metrics_of(&f, metrics);
    assert_close(metrics[METRIC_CONSTRAINT_ERROR], 0, 1e-15);
    assert_close(metrics[METRIC_CONSTRAINT_ERROR_ANGULAR], 0, 1e-12);
    dBodySetPosition(tip, x[0], x[1], x[2] + 1e-3); /* the rails lie along x */
    dQuaternion turn = {cos(0.01), 0, 0, sin(0.01)}, turned;
    dQMultiply0(turned, turn, dBodyGetQuaternion(tip));
    dBodySetQuaternion(tip, turned);
    after_step(&f, NULL);
    metrics_of(&f, metrics);
    assert_close(metrics[METRIC_CONSTRAINT_ERROR], 1e-3, 1e-12);
    assert_close(metrics[METRIC_CONSTRAINT_ERROR_ANGULAR], 0.02, 1e-9);
    free_fake(&f);
}

/* Curves have few points, the first and the last among them. */
static void test_curves(void **state)
{
    (void)state;
    fake f = make_fake("egg.json");
    for (int k = 0; k < STEPS; k++) after_step(&f, NULL);
    assert_true(f.r.rows > 100 && f.r.rows <= OBSERVER_POINTS + 2);
    assert_close(f.r.curve[OBSERVER_TIME], f.s->step, 1e-15);
    assert_close(f.r.curve[(f.r.rows - 1) * f.r.columns + OBSERVER_TIME], STEPS * f.s->step, 1e-12);
    free_fake(&f);
}

/* Evenly spaced steps with the last, a change of state, the largest change of force; in order, none twice. */
static void test_moments(void **state)
{
    (void)state;
    fake f = make_fake("egg.json");
    step_chooser watch;
    chosen_step chosen[12];
    assert_true(step_chooser_start(&watch, f.w, STEPS));
    for (int k = 1; k <= STEPS; k++) {
        f.w->steps = k;
        f.w->fingers[0].state.force[0] = k >= 150 ? 5 : 0;
        f.w->fingers[1].state.state = k < 61 ? PINCH_CONTACT_STICK : PINCH_CONTACT_SLIP;
        step_chooser_after_step(&watch);
    }
    int count = step_chooser_choose(&watch, 12, chosen), state_change = 0, load_change = 0;
    assert_int_equal(count, 6 + 1 + 1);
    for (int i = 0; i < count; i++) {
        if (i > 0) assert_true(chosen[i].step > chosen[i - 1].step);
        if (chosen[i].reason == SAMPLE_STATE_CHANGE && chosen[i].step == 61) state_change++;
        if (chosen[i].reason == SAMPLE_LOAD_CHANGE && chosen[i].step == 150) load_change++;
    }
    assert_int_equal(chosen[count - 1].step, STEPS);
    assert_int_equal(state_change, 1);
    assert_int_equal(load_change, 1);
    assert_int_equal(step_chooser_choose(&watch, 1, chosen), 1);
    step_chooser_free(&watch);
    free_fake(&f);
}

static char *html_of(void (*write)(FILE *stream))
{
    char *text = NULL;
    size_t size;
    FILE *stream = open_memstream(&text, &size);
    assert_non_null(stream);
    write(stream);
    assert_int_equal(fclose(stream), 0);
    return text;
}

static void write_texts(FILE *stream)
{
    page_text("a<b>&\"'\x01\n\xc3\xa9", stream);
}

static void test_html(void **state)
{
    (void)state;
    char *text = html_of(write_texts);
    assert_string_equal(text, "a&lt;b&gt;&amp;&quot;&#39;\xc3\xa9");
    free(text);
}

/* Every key leads back to its metric; cost is in no baseline. */
static void test_metric_table(void **state)
{
    (void)state;
    for (int m = 0; m < METRIC_COUNT; m++) assert_int_equal(metric_of_key(metric_about((metric)m)->key), m);
    assert_int_equal(metric_of_key("nonsense"), METRIC_COUNT);
    assert_true(tolerance_default(METRIC_COST, false).absolute < 0);
    assert_true(tolerance_default(METRIC_COST, true).absolute < 0);
}

/* A file is there when it is complete, and what was there before until then. */
static void test_whole_file(void **state)
{
    (void)state;
    char *folder = program_make_folder(), *path = program_write_file(folder, "file", "before");
    for (int keep = 0; keep < 2; keep++) {
        whole_file file;
        assert_true(whole_file_open(&file, path));
        fputs("after", file.stream);
        fflush(file.stream);
        char *text = program_read_file(path);
        assert_string_equal(text, "before");
        free(text);
        assert_true(whole_file_close(&file, keep));
        text = program_read_file(path);
        assert_string_equal(text, keep ? "after" : "before");
        free(text);
        assert_int_equal(program_count_entries(folder), 1);
    }
    char *link = program_write_file(folder, "link", "");
    assert_int_equal(unlink(link), 0);
    assert_int_equal(symlink("file", link), 0);
    whole_file file;
    assert_true(whole_file_open(&file, link));
    fputs("through the link", file.stream);
    assert_true(whole_file_close(&file, true));
    char *text = program_read_file(path);
    assert_string_equal(text, "through the link");
    free(text);
    struct stat about;
    assert_int_equal(lstat(link, &about), 0);
    assert_true(S_ISLNK(about.st_mode));
    assert_false(whole_file_open(&file, "/nowhere/at/all"));
    assert_int_equal(errno, ENOENT);
    free(link);
    free(path);
    program_remove_folder(folder);
}

/* Work of all kinds: a result, a message, a status, a crash. */
static command_status work(void *context, int index, job_share *share, json_t **document)
{
    (void)context;
    job_share_start(share, 1, 1);
    job_share_step(share);
    if (index % 4 == 1) raise(SIGKILL);
    if (index % 4 == 2) {
        fprintf(stderr, "message %d\n", index);
        return COMMAND_BAD_INPUT;
    }
    *document = json_pack("{s:i}", "index", index);
    return index % 4 == 3 ? COMMAND_FAILED : COMMAND_DONE;
}

static const char *name(void *context, int index)
{
    (void)context;
    return index == 5 ? "five" : "other";
}

static void test_jobs(void **state)
{
    (void)state;
    enum { COUNT = 12 };
    for (int at_a_time = 1; at_a_time <= 16; at_a_time += 5) {
        job_result results[COUNT];
        job_list list = {.count = COUNT, .at_a_time = at_a_time, .work = work, .name = name};
        assert_true(jobs_run(&list, results));
        for (int i = 0; i < COUNT; i++) {
            static const command_status statuses[] = {COMMAND_DONE, COMMAND_SYSTEM, COMMAND_BAD_INPUT, COMMAND_FAILED};
            char message[32];
            snprintf(message, sizeof message, "message %d\n", i);
            assert_int_equal(results[i].status, statuses[i % 4]);
            if (i % 2 == 0 && i % 4 == 2) assert_string_equal(results[i].messages, message);
            if (i == 5) assert_non_null(strstr(results[i].messages, "five: the process ended by signal 9"));
            if (i % 4 == 0 || i % 4 == 3)
                assert_int_equal(json_integer_value(json_object_get(results[i].document, "index")), i);
            else
                assert_null(results[i].document);
        }
        jobs_free(results, COUNT);
    }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_jitter),     cmocka_unit_test(test_divergence),   cmocka_unit_test(test_momentum),
        cmocka_unit_test(test_constraint), cmocka_unit_test(test_curves),       cmocka_unit_test(test_moments),
        cmocka_unit_test(test_html),       cmocka_unit_test(test_metric_table), cmocka_unit_test(test_whole_file),
        cmocka_unit_test(test_jobs),
    };
    int failed = cmocka_run_group_tests_name("parts of pinch compare", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
