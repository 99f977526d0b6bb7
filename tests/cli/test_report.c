/*
 * The page of `pinch compare --report` must be self-contained and escaped. In a real browser it must raise no console
 * errors, show the numbers of the JSON document in its tables, one scene at a time, be no wider than the window, and
 * have pictures in light and dark.
 *
 * Without a browser or the libraries the page is not tested, unless PINCH_REQUIRE_BROWSER is set; tests/run sets it
 * where the system has the packages.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/browser.h"
#include "support/command.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char *folder;      /* with page.html */
static json_t *document_; /* what it was made from */
static json_t *once;      /* what CELLS, ERRORS and WORDS see in one opening of the page */

static const char EVIL[] = "</title><script>alert('x')</script>&\"<b>";

/* The egg under a name that would like to be more than a name. */
static char *evil_scene(void)
{
    json_t *egg = json_load_file(COMPARE_SCENE("egg.json"), 0, NULL);
    assert_non_null(egg);
    json_object_set_new(egg, "name", json_string(EVIL));
    json_object_set_new(json_array_get(json_object_get(egg, "fingers"), 0), "name", json_string(EVIL));
    char *text = json_dumps(egg, 0), *path = program_write_file(folder, "evil.json", text);
    free(text);
    json_decref(egg);
    return path;
}

/* Every cell of every scene's tables, as [scene, run, metric, value, text]. */
static const char CELLS[] =
    "seen.cells=[];for(let i=0;i<report.scenes.length;i++){await choose(i,false);"
    "const box=q('#scene input[type=checkbox]:not(.switches *)');box.checked=true;"
    "box.dispatchEvent(new Event('change'));"
    "for(const c of all('#scene .numbers td'))seen.cells.push([i,c.dataset.run,c.dataset.metric,c.dataset.value,"
    "c.textContent]);}";

/* The errors of every scene's runs: own error, difference of the models, largest error of a force. */
static const char ERRORS[] = "seen.scenes=report.scenes.map(s=>Object.fromEntries(s.runs.map(r=>[r.run,"
                             "[r.own_error,r.model_difference,r.metrics.force_error_max]])));";

/* Judgements and numbers, as people read them. */
static const char WORDS[] =
    "const v=(e,d,s='quickstep')=>verdict({contact_solver:s,own_error:e,metrics:{dropped:d}})[0];"
    "seen.words=[v(1e-12,false),v(1e-5,false),v(0.02,false),v(1e-12,true),v(null,false,"
    "'pinch'),v(null,false,'worldstep'),number(-0.00123456),number(-1.2345e-17,3),number("
    "NaN),number(12.34567),inUnit(1.234e-7),inUnit(0.00234),inUnit(2)].join(' | ');";

static bool nothing_to_open(void)
{
    return !document_ || browser_is_missing();
}

static int make_page(void **state)
{
    (void)state;
    folder = program_make_folder();
    if (browser_libraries_are_missing()) return 0;
    char *evil = evil_scene();
    document_ = compare_document(COMPARE(folder, evil, COMPARE_SCENE("example-2.json"), COMPARE_SCENE("twist.json"),
                                         COMPARE_SCENE("mug.json"), "--json", "--report", "page.html", "--duration",
                                         "1.2", "--samples", "8"),
                                 0);
    free(evil);
    if (!nothing_to_open())
        once = browser_seen_by(folder, "page.html", (const char *const[]){CELLS, ERRORS, WORDS, NULL}, browser_laptop);
    return 0;
}

static char *path_of(const char *name)
{
    static char paths[4][512];
    static int next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static int remove_page(void **state)
{
    (void)state;
    browser_remove_folder(folder);
    json_decref(document_);
    json_decref(once);
    return 0;
}

static void test_self_contained(void **state)
{
    (void)state;
    if (!document_) return;
    char *page = program_read_file(path_of("page.html"));
    browser_page_is_self_contained(page);
    /* 16 scenes have 3 MB, of which the libraries take 1.1 MB; this page has four */
    assert_true(strlen(page) < 1150000 + 4 * 115000);
    free(page);
    /* what the page alone needs is not in the document */
    assert_null(json_object_get(json_array_get(json_object_get(document_, "scenes"), 0), "films"));
}

static void test_names_are_escaped(void **state)
{
    (void)state;
    if (!document_) return;
    char *page = program_read_file(path_of("page.html"));
    assert_null(strstr(page, "<script>alert"));
    assert_non_null(strstr(page, "\\u003cscript>alert('x')"));
    free(page);
}

static void test_no_console_errors(void **state)
{
    (void)state;
    if (nothing_to_open()) return;
    browser_dark_viewer_has_no_errors(folder, "page.html");
}

static void test_tables_hold_the_numbers(void **state)
{
    (void)state;
    if (nothing_to_open()) return;
    const json_t *scenes = json_object_get(document_, "scenes"), *cells = json_object_get(once, "cells"), *cell;
    size_t i, metrics = json_object_size(json_object_get(compare_find(json_array_get(scenes, 0), "pinch"), "metrics"));
    /* two errors and four metrics in front, and all of them below */
    assert_int_equal(json_array_size(cells), json_array_size(scenes) * 5 * (2 + 4 + metrics));
    json_array_foreach(cells, i, cell)
    {
        const json_t *of_scene = json_array_get(scenes, (size_t)json_integer_value(json_array_get(cell, 0)));
        const json_t *run = compare_find(of_scene, json_string_value(json_array_get(cell, 1)));
        const char *key = json_string_value(json_array_get(cell, 2)),
                   *text = json_string_value(json_array_get(cell, 3));
        const char *shown = json_string_value(json_array_get(cell, 4));
        bool error = strcmp(key, "own_error") == 0 || strcmp(key, "model_difference") == 0;
        const json_t *entry = json_object_get(json_object_get(run, "metrics"), key);
        if (error) continue;
        double value = compare_metric(run, key);
        if (isnan(value)) {
            assert_string_equal(text, "");
            assert_string_equal(shown, "\xe2\x80\x93");
        } else if (json_is_boolean(entry)) {
            assert_string_equal(shown, value != 0 ? "yes" : "no");
        } else {
            assert_true(strtod(text, NULL) == value);
            assert_true(*shown && strlen(shown) < 40); /* no more digits than people read */
        }
    }
}

/* What a solver misses of its own law is kept apart from what its law lacks. More iterations bring quickstep nearer to
 * its own law, and change nothing of the law. */
static void test_errors_are_kept_apart(void **state)
{
    (void)state;
    if (nothing_to_open()) return;
    size_t i;
    const json_t *of_scene;
    json_array_foreach(json_object_get(once, "scenes"), i, of_scene)
    {
        double own[3];
        static const char *const runs[] = {"pinch", "quickstep-20", "quickstep-200"};
        for (int k = 0; k < 3; k++) {
            const json_t *errors = json_object_get(of_scene, runs[k]);
            own[k] = json_number_value(json_array_get(errors, 0));
            if (k == 0) assert_true(own[0] == json_number_value(json_array_get(errors, 2)) && own[0] < 1e-9);
        }
        assert_true(own[2] <= own[1]);
        const json_t *world = json_object_get(of_scene, "worldstep"),
                     *quick = json_object_get(of_scene, "quickstep-20");
        assert_true(json_is_null(json_array_get(world, 0)));
        assert_true(json_equal(json_array_get(world, 1), json_array_get(quick, 1)));
    }
}

static void test_words(void **state)
{
    (void)state;
    if (nothing_to_open()) return;
    assert_string_equal(json_string_value(json_object_get(once, "words")),
                        "exact | close | off | dropped | unknown | law | \xe2\x88\x92"
                        "0.0012346 | "
                        "\xe2\x88\x92"
                        "1.23\xc2\xa0\xc3\x97\xc2\xa0"
                        "10\xe2\x81\xbb\xc2\xb9\xe2\x81\xb7 | \xe2\x80\x93 | "
                        "12.346 | 0.123 \xc2\xb5m | 2.34 mm | 2.00 m");
}

/* Worldstep's run may be watched in place of quickstep's, at the same time. On paper, charts keep what they show. */
static void test_beside(void **state)
{
    (void)state;
    if (nothing_to_open()) return;
    json_t *seen = browser_seen(folder, "page.html",
                                "viewer.seek(0.1);const first=viewer,at=viewer.time,box=q('#beside');"
                                "seen.offered=[...box.options].map(o=>o.textContent).join();"
                                "seen.before=first.ghost.solver;box.value='2';box.dispatchEvent(new Event('change'));"
                                "while(!window.viewer||viewer===first)await new Promise(r=>setTimeout(r,20));"
                                "seen.after=viewer.ghost.solver;seen.kept=viewer.time===at;"
                                "seen.pictures=all('.stage canvas').length;"
                                "const width=()=>all('.plot').every(p=>p.style.width.endsWith('px'));"
                                "dispatchEvent(new Event('beforeprint'));seen.paper=width();"
                                "dispatchEvent(new Event('afterprint'));seen.screen=!width();",
                                browser_laptop);
    assert_string_equal(json_string_value(json_object_get(seen, "offered")), "quickstep,worldstep");
    assert_string_equal(json_string_value(json_object_get(seen, "before")), "quickstep");
    assert_string_equal(json_string_value(json_object_get(seen, "after")), "worldstep");
    assert_int_equal(json_integer_value(json_object_get(seen, "pictures")), 1);
    assert_true(json_is_true(json_object_get(seen, "kept")));
    assert_true(json_is_true(json_object_get(seen, "paper")) && json_is_true(json_object_get(seen, "screen")));
    json_decref(seen);
}

/* The five answers of all scenes: do they stand in the first window, and name who, where and how much? */
static const char ANSWERS[] =
    "const cards=all('.all .answer');seen.answers=cards.length;"
    "seen.below=cards.filter(c=>c.getBoundingClientRect().bottom>(innerWidth<600?844:1000)).length;"
    "const "
    "fingers=report.scenes.flatMap(s=>s.films[0].fingers.map(f=>({s,f}))),slips=fingers.filter(x=>x.f.first_"
    "slip!==null);"
    "const least=Math.min(...slips.map(x=>x.f.first_slip)),peak=Math.max(...fingers.map(x=>x.f.peak_force));"
    "const "
    "short=k=>cards[k].querySelector('.short').textContent,long=k=>cards[k].querySelector('.long').textContent;"
    "seen.slips=slips.length;seen.earliest=slips.some(x=>x.f.first_slip===least&&short(1).includes(`\u2018${x."
    "f.name}\u2019`)"
    "&&long(1).includes(x.s.name));"
    "seen.slippers=slips.every(x=>long(1).includes(x.s.name));"
    "seen.peak=short(2)===`${number(peak,4)} "
    "N`&&fingers.some(x=>x.f.peak_force===peak&&long(2).includes(x.s.name));"
    "seen.wrong=report.scenes.every(s=>{const r=s.runs.find(r=>r.run==='quickstep-20');"
    "return long(3).includes(s.name)===(r.metrics.dropped||r.own_error>0.01);});"
    "const link=cards[1].querySelector('a');link.click();await new Promise(r=>setTimeout(r,300));"
    "seen.opened=q('#scene h2').textContent===link.textContent;";

/* What people with screen readers, narrow windows and keyboards need. */
static const char LAYOUT[] =
    "const faults=[];for(let i=0;i<report.scenes.length;i++){await choose(i,false);"
    "if(document.documentElement.scrollWidth>innerWidth)faults.push('wider than the window');"
    "all('table').forEach(t=>{if(!t.caption||!t.querySelector('th[scope=col]'))faults.push('table');});"
    "all('figure').forEach(f=>{if(!f.querySelector('figcaption'))faults.push('figure');});"
    "if(all('.scene .answer').length!==5)faults.push('answers');}"
    "seen.faults=faults.join('; ');seen.cards=all('.list button').length;seen.map=all('.map a').length;"
    "seen.lead=q('.lead').textContent;seen.thumbs=all('.thumb path').length;"
    "q('.list button:nth-child(3)').click();await new Promise(r=>setTimeout(r,300));"
    "seen.chosen=q('#scene h2').textContent;";

static void test_window(char *size)
{
    if (nothing_to_open()) return;
    json_t *seen = browser_seen_by(folder, "page.html", (const char *const[]){ANSWERS, LAYOUT, NULL}, size);
    assert_int_equal(json_integer_value(json_object_get(seen, "answers")), 5);
    assert_int_equal(json_integer_value(json_object_get(seen, "below")), 0);
    assert_true(json_integer_value(json_object_get(seen, "slips")) > 0);
    static const char *const so[] = {"earliest", "slippers", "peak", "wrong", "opened"};
    for (int k = 0; k < 5; k++)
        if (!json_is_true(json_object_get(seen, so[k]))) fail_msg("%s: %s does not hold", size, so[k]);

    assert_string_equal(json_string_value(json_object_get(seen, "faults")), "");
    assert_int_equal(json_integer_value(json_object_get(seen, "cards")), 4);
    assert_int_equal(json_integer_value(json_object_get(seen, "map")), 12);
    assert_true(json_integer_value(json_object_get(seen, "thumbs")) >= 12);
    assert_non_null(strstr(json_string_value(json_object_get(seen, "lead")), "Pinch holds the object in 4 of 4"));
    assert_string_equal(json_string_value(json_object_get(seen, "chosen")), "twist");
    json_decref(seen);
}

static void test_laptop(void **state)
{
    (void)state;
    test_window(browser_laptop);
}

static void test_narrow(void **state)
{
    (void)state;
    test_window(browser_narrow);
}

/* What the map's legend shows, and the cards of all scenes and of the first one. */
static const char SAID[] =
    "const signs=s=>all(s).map(e=>e.className).join();await choose(0,false);seen.cells=signs('.map a');"
    "seen.key=signs('.key b');seen.thumbs=all('.thumb').map(t=>t.querySelectorAll('.object').length>0&&"
    "t.querySelectorAll('.arrow').length>0).join();"
    "seen.all=all('.all .answer').map(c=>c.textContent);seen.one=all('.scene .answer').map(c=>c.textContent);"
    "seen.list=all('.list small').map(e=>e.textContent).join();";

static const char *said(const json_t *seen, const char *key, size_t card)
{
    const json_t *value = json_object_get(seen, key);
    const char *text = json_string_value(json_is_array(value) ? json_array_get(value, card) : value);
    assert_non_null(text);
    return text;
}

static json_t *said_of(const char *name, program_result r)
{
    assert_int_equal(r.status, 0);
    program_free(&r);
    return browser_seen(folder, name, SAID, browser_laptop);
}

/* The exact solution knows no joints, so that no step of a scene with a hand is compared: the page says so, and neither
 * that quickstep is right there nor that Pinch is. */
#define HAND SCENE("hands/three-finger-lift.json")

static void test_nothing_compared(void **state)
{
    (void)state;
    if (nothing_to_open()) return;
    json_t *seen =
        said_of("hand.html", PINCH(folder, "compare", HAND, "--duration", "0.6", "--quiet", "--report", "hand.html"));
    assert_string_equal(said(seen, "cells", 0), "unknown,unknown,law");
    assert_string_equal(said(seen, "key", 0), "unknown,law,shown");
    assert_string_equal(said(seen, "thumbs", 0), "true");
    assert_string_equal(said(seen, "list", 0), "Pinch: held,quickstep: held, not compared");
    assert_non_null(strstr(said(seen, "all", 0), "No force was compared with the exact solution."));
    assert_non_null(strstr(said(seen, "all", 3), "Not compared"));
    assert_non_null(strstr(said(seen, "all", 3), "not compared with ODE\u2019s friction law, in three-finger-lift."));
    assert_null(strstr(said(seen, "all", 3), "1 %"));
    assert_non_null(strstr(said(seen, "one", 0), "No step\u2019s forces were compared with the exact solution."));
    assert_non_null(strstr(said(seen, "one", 3), "Its forces were not compared with ODE\u2019s friction law."));
    assert_null(strstr(said(seen, "one", 3), "\u2013"));
    json_decref(seen);
}

/* What is said of all scenes is said of those that were compared, and the others are named. */
static void test_partly_compared(void **state)
{
    (void)state;
    if (nothing_to_open()) return;
    json_t *seen = said_of("part.html", PINCH(folder, "compare", HAND, COMPARE_SCENE("egg.json"), "--duration", "0.6",
                                              "--samples", "4", "--quiet", "--report", "part.html"));
    assert_non_null(strstr(said(seen, "all", 0), "Forces were compared in 1 of 2 scenes. There, Pinch\u2019s forces "
                                                 "equal the exact solution\u2019s to rounding. No step was compared in "
                                                 "three-finger-lift."));
    assert_non_null(strstr(said(seen, "all", 3), "In none of 1 compared"));
    assert_non_null(strstr(said(seen, "all", 3), "Where it holds and was compared"));
    assert_non_null(strstr(said(seen, "all", 3), "not compared with ODE\u2019s friction law, in three-finger-lift."));
    assert_string_equal(said(seen, "thumbs", 0), "true,true");
    json_decref(seen);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_self_contained),
        cmocka_unit_test(test_names_are_escaped),
        cmocka_unit_test(test_no_console_errors),
        cmocka_unit_test(test_tables_hold_the_numbers),
        cmocka_unit_test(test_errors_are_kept_apart),
        cmocka_unit_test(test_words),
        cmocka_unit_test(test_beside),
        cmocka_unit_test(test_laptop),
        cmocka_unit_test(test_narrow),
        cmocka_unit_test(test_nothing_compared),
        cmocka_unit_test(test_partly_compared),
    };
    return cmocka_run_group_tests_name("the report", tests, make_page, remove_page);
}
