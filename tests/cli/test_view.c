/*
 * `pinch run --view`: the page must need no network, escape names, and raise no errors in a real browser. It must show
 * the numbers of the run at the time that it is set to, by slider, keyboard and chart, on narrow and wide windows, in
 * light and dark, and on paper.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/browser.h"
#include "support/command.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char *folder;   /* with page.html and run.csv */
static json_t *run_of; /* the run that it shows */
static json_t *laptop; /* what FORCES, LOOKS and KEYBOARD see in one opening of the page */

static const char EVIL[] = "</title></script><script>alert('x')</script>&\"<b>";

/* What the table shows at the end and in the middle of the run. */
static const char FORCES[] = "const row=()=>all('.readout tbody tr').map(r=>[...r.cells].slice(2,4).map(c=>"
                             "Number(c.textContent)));slide(1e9);seen.last=row();slide(0.75);seen.middle=row();"
                             "seen.clock=q('.clock').textContent;seen.state=q('.readout td').textContent;";

/* The picture, the charts and the answers. */
static const char LOOKS[] =
    "slide(2.5);viewer.stage.draw();const c=document.createElement('canvas');c.width=c.height=64;"
    "const g=c.getContext('2d');g.drawImage(q('.stage canvas'),0,0,64,64);"
    "const d=g.getImageData(0,0,64,64).data,colours=new Set();"
    "for(let i=0;i<d.length;i+=4)colours.add(d[i]*65536+d[i+1]*256+d[i+2]);seen.colours=colours.size;"
    "seen.wide=document.documentElement.scrollWidth-innerWidth;seen.charts=all('.chart').length;"
    "seen.cursors=Math.max(...viewer.charts.list.map(e=>Math.abs(new DOMMatrix(getComputedStyle(e.cursor)"
    ".transform).e-e.graph.toDomXCoord(2.5))));"
    "seen.answers=all('.answer').length;seen.hold=q('.answer .short').textContent;"
    "const "
    "p=q('.plot'),b=p.getBoundingClientRect(),a=viewer.charts.list[0].graph.getArea();p.setPointerCapture="
    "()=>{};p.dispatchEvent(new PointerEvent('pointerdown',{clientX:b.left+a.x+a.w/2,button:0,pointerId:1}));"
    "seen.pressed=viewer.time;";

/* What keys do, and a screen that shows few pictures a second; animations stand still after it. */
static const char KEYBOARD[] =
    "key('End');seen.end=viewer.time;key('Home');seen.home=viewer.time;key('ArrowRight');"
    "seen.one=viewer.time;key('ArrowRight',{shiftKey:true});seen.eleven=viewer.time;key('f');"
    "seen.forces=+q('.switches input').checked;key('f');seen.again=+q('.switches input').checked;"
    "key('>');seen.speed=viewer.speed;key(' ');seen.playing=+viewer.playing;key(' ');"
    "seen.paused=+!viewer.playing;q('canvas').focus();const x=viewer.stage.camera.position.x;"
    "key('ArrowLeft');seen.turned=viewer.stage.camera.position.x-x;seen.stayed=viewer.time;"
    "const d=()=>viewer.stage.camera.position.distanceTo(viewer.stage.controls.target),far=d();"
    "key('+');seen.nearer=d()/far;"
    /* what the tab key reaches has a name */
    "seen.unnamed=all('button,input,select,canvas[tabindex],summary').filter(e=>e.offsetParent&&!(e."
    "textContent.trim()||"
    "e.getAttribute('aria-label')||e.closest('label'))).length;"
    /* a screen that shows ten pictures a second */
    "const queue=[];window.requestAnimationFrame=f=>queue.push(f);viewer.seek(0);viewer.speed=1;"
    "let now=performance.now();viewer.toggle(true);"
    "for(let i=0;i<20;i++){now+=100;queue.splice(0).forEach(f=>f(now));}"
    "seen.slow=viewer.time;seen.coarse=viewer.stage.quality;viewer.toggle(false);"
    "seen.fine=viewer.stage.quality;";

static bool nothing_to_open(void)
{
    return !run_of || browser_is_missing();
}

/* The mug under a name that would like to be more than a name. */
static int make_page(void **state)
{
    (void)state;
    folder = program_make_folder();
    if (browser_libraries_are_missing()) return 0;
    json_t *mug = json_load_file(SCENE("mug.json"), 0, NULL);
    assert_non_null(mug);
    json_object_set_new(mug, "name", json_string(EVIL));
    json_object_set_new(json_array_get(json_object_get(mug, "fingers"), 0), "name", json_string(EVIL));
    json_object_set_new(json_object_get(json_object_get(mug, "object"), "shape"), "file",
                        json_string(PINCH_SOURCE_DIR "/assets/scenes/meshes/mug.obj"));
    char *text = json_dumps(mug, 0);
    free(program_write_file(folder, "mug.json", text));
    free(text);
    json_decref(mug);
    program_result r = PINCH(folder, "run", "mug.json", "--json", "--view", "page.html", "--csv", "run.csv");
    assert_int_equal(r.status, 0);
    run_of = cli_document(&r);
    program_free(&r);
    if (!nothing_to_open())
        laptop =
            browser_seen_by(folder, "page.html", (const char *const[]){FORCES, LOOKS, KEYBOARD, NULL}, browser_laptop);
    return 0;
}

static int remove_page(void **state)
{
    (void)state;
    browser_remove_folder(folder);
    json_decref(run_of);
    json_decref(laptop);
    return 0;
}

static const char *path_of(const char *name)
{
    static char paths[2][512];
    static int next;
    char *path = paths[next++ % 2];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static void test_self_contained(void **state)
{
    (void)state;
    if (!run_of) return;
    char *page = program_read_file(path_of("page.html"));
    browser_page_is_self_contained(page);
    assert_true(strlen(page) < 2000000);
    /* names stand escaped in texts and in data */
    assert_null(strstr(page, "<script>alert"));
    assert_non_null(strstr(page, "&lt;script&gt;alert(&#39;x&#39;)&lt;/script&gt;&amp;&quot;&lt;b&gt;"));
    assert_non_null(strstr(page, "\\u003cscript>alert('x')"));
    free(page);
}

/* A missing library is named with its package before anything runs, and nothing is left behind. */
static void test_missing_library(void **state)
{
    (void)state;
    setenv("PINCH_JAVASCRIPT", "/nowhere", 1);
    cli_refused(PINCH(folder, "run", SCENE("egg.json"), "--view", "none.html"), 3, "install the package libjs-three");
    unsetenv("PINCH_JAVASCRIPT");
    FILE *stream = fopen(path_of("none.html"), "r");
    assert_null(stream);
}

static void test_no_console_errors(void **state)
{
    (void)state;
    if (nothing_to_open()) return;
    browser_dark_viewer_has_no_errors(folder, "page.html");
}

static double seen_number(const json_t *seen, const char *key)
{
    const json_t *value = json_object_get(seen, key);
    if (!json_is_number(value)) fail_msg("%s is not a number", key);
    return json_number_value(value);
}

/* At the end the page shows the document's forces, and in the middle those of the CSV file's row. */
static void test_forces(void **state)
{
    (void)state;
    if (nothing_to_open()) return;
    const json_t *fingers = json_object_get(run_of, "fingers"), *finger;
    size_t i;
    json_array_foreach(fingers, i, finger)
    {
        const json_t *end = json_array_get(json_object_get(laptop, "last"), i);
        double shown = json_number_value(json_array_get(end, 0));
        double force = json_number_value(json_object_get(finger, "normal_force"));
        assert_true(force > 1 && fabs(shown - force) <= 1e-4 * force);
    }
    assert_string_equal(json_string_value(json_object_get(laptop, "clock")), "0.750 s");
    assert_string_equal(json_string_value(json_object_get(laptop, "state")), "stick");
    /* the CSV file's row at 0.75 s: the second finger's force stands behind the first one's seven columns */
    char *text = program_read_file(path_of("run.csv")), *line = strstr(text, "\n0.75,");
    assert_non_null(line);
    char *c = line;
    double force = 0;
    for (int column = 0; column < 24; column++) {
        c = strpbrk(c, ",") + 1;
        if (column >= 13 + 7 && column < 13 + 10) force = hypot(force, strtod(c, NULL));
    }
    const json_t *second = json_array_get(json_object_get(laptop, "middle"), 1);
    double normal = json_number_value(json_array_get(second, 0)), side = json_number_value(json_array_get(second, 1));
    assert_true(force > 1 && fabs(hypot(normal, side) - force) <= 2e-4 * force);
    free(text);
}

static void test_keyboard(void **state)
{
    (void)state;
    if (nothing_to_open()) return;
    double duration = json_number_value(json_object_get(run_of, "time_s"));
    assert_true(fabs(seen_number(laptop, "end") - duration) < 1e-6);
    assert_true(seen_number(laptop, "home") == 0);
    assert_true(fabs(seen_number(laptop, "one") - 1 / 60.0) < 6e-4);
    assert_true(fabs(seen_number(laptop, "eleven") - 11 / 60.0) < 6e-4);
    assert_true(seen_number(laptop, "forces") == 0 && seen_number(laptop, "again") == 1);
    assert_true(seen_number(laptop, "speed") == 2);
    assert_true(seen_number(laptop, "playing") == 1 && seen_number(laptop, "paused") == 1);
    assert_true(fabs(seen_number(laptop, "turned")) > 1e-4);
    assert_true(fabs(seen_number(laptop, "nearer") - 0.9) < 1e-3);
    assert_true(seen_number(laptop, "unnamed") == 0);
    assert_true(fabs(seen_number(laptop, "slow") - 2) < 0.05); /* pictures are left out, and time is not */
    assert_true(seen_number(laptop, "coarse") < 1 && seen_number(laptop, "fine") == 1);
}

/* The picture has as many colours as a picture has, the cursor of every chart is at the time, nothing is wider than
 * the window, and the answers are those of the document. */
static void window_looks_right(const json_t *seen)
{
    assert_true(seen_number(seen, "colours") > 100);
    assert_true(seen_number(seen, "wide") <= 0);
    assert_int_equal(seen_number(seen, "charts"), 6);
    assert_true(seen_number(seen, "cursors") < 1);
    assert_int_equal(seen_number(seen, "answers"), 5);
    assert_string_equal(json_string_value(json_object_get(seen, "hold")), "Yes");
    assert_true(fabs(seen_number(seen, "pressed") - 2.5) < 0.05);
}

static void test_laptop(void **state)
{
    (void)state;
    if (nothing_to_open()) return;
    window_looks_right(laptop);
}

static void test_narrow(void **state)
{
    (void)state;
    if (nothing_to_open()) return;
    json_t *seen = browser_seen(folder, "page.html", LOOKS, browser_narrow);
    window_looks_right(seen);
    json_decref(seen);
}

static void test_print(void **state)
{
    (void)state;
    if (nothing_to_open()) return;
    char option[600], wait[] = "--virtual-time-budget=3000";
    snprintf(option, sizeof option, "--print-to-pdf=%s", path_of("page.pdf"));
    program_result r = browser_open(folder, "page.html", (char *const[]){wait, browser_dark, option, NULL});
    if (strstr(r.err, "CONSOLE")) fail_msg("%.2000s", strstr(r.err, "CONSOLE"));
    program_free(&r);
    FILE *stream = fopen(path_of("page.pdf"), "rb");
    assert_non_null(stream);
    assert_int_equal(fseek(stream, 0, SEEK_END), 0);
    assert_true(ftell(stream) > 20000); /* more than empty pages */
    fclose(stream);
}

/* A hand that goes up without its box does not hold it. */
static void test_left_behind(void **state)
{
    (void)state;
    if (nothing_to_open()) return;
    free(program_write_file(
        folder, "left.json",
        "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.04, 0.04, 0.04]}, "
        "\"mass\": 0.2}, \"fingers\": [{\"point\": [-0.02, 0, 0], \"normal\": [1, 0, 0], \"model\": \"hard\", "
        "\"stiffness\": {\"normal\": 1e4}, \"friction\": 0.5}], \"environment\": [{\"shape\": {\"type\": \"box\", "
        "\"size\": [1, 1, 0.1]}, \"position\": [0, 0, -0.07], \"stiffness\": {\"normal\": 1e5}, \"friction\": 0.5}], "
        "\"schedule\": [{\"time\": 0, \"hand\": {\"translation\": [0, 0, 0]}}, {\"time\": 0.2, \"hand\": "
        "{\"translation\": [0, 0, 0.1]}}], \"simulation\": {\"duration\": 0.3}}"));
    program_result r = PINCH(folder, "run", "left.json", "--quiet", "--view", "left.html");
    assert_int_equal(r.status, 0);
    program_free(&r);
    json_t *seen = browser_seen(folder, "left.html", "seen.hold=q('.answer .short').textContent;", browser_laptop);
    assert_string_equal(json_string_value(json_object_get(seen, "hold")), "No");
    json_decref(seen);
}

/* A cube between two point fingers is lifted by `height`. */
static json_t *lifted(const char *height)
{
    char text[1024];
    snprintf(
        text, sizeof text,
        "{\"format\": \"pinch-scene/1\", \"object\": {\"shape\": {\"type\": \"box\", \"size\": [0.04, 0.04, 0.04]}, "
        "\"mass\": 0.1}, \"fingers\": [{\"point\": [-0.02, 0, 0], \"normal\": [1, 0, 0], \"model\": \"hard\", "
        "\"stiffness\": {\"normal\": 5000}, \"friction\": 0.8, \"closing\": 0.001}, {\"point\": [0.02, 0, 0], "
        "\"normal\": [-1, 0, 0], \"model\": \"hard\", \"stiffness\": {\"normal\": 5000}, \"friction\": 0.8, "
        "\"closing\": "
        "0.001}], \"schedule\": [{\"time\": 0.1, \"hand\": {\"translation\": [0, 0, 0]}}, {\"time\": 0.4, \"hand\": "
        "{\"translation\": [0, 0, %s]}}], \"simulation\": {\"duration\": 0.5}}",
        height);
    free(program_write_file(folder, "lifted.json", text));
    program_result r = PINCH(folder, "run", "lifted.json", "--quiet", "--view", "lifted.html");
    assert_int_equal(r.status, 0);
    program_free(&r);
    /* how far the object's corners and the forces come out from the middle, of the way to the picture's edge */
    return browser_seen(
        folder, "lifted.html",
        "const s=viewer.stage,out=v=>{const p=v.project(s.camera);return Math.max(Math.abs(p.x),Math.abs("
        "p.y));};seen.out=seen.forces=0;seen.follows=+q('.switches label:last-of-type input').checked;"
        "for(const t of [0,0.25,0.35,0.5]){slide(t);s.draw();const o=s.bodies[s.film.bodyCalled('object')];"
        "for(const x of [-0.02,0.02])for(const y of [-0.02,0.02])for(const z of [-0.02,0.02])"
        "seen.out=Math.max(seen.out,out(o.localToWorld(new THREE.Vector3(x,y,z))));"
        "for(const a of s.arrows.list)if(a.visible)"
        "seen.forces=Math.max(seen.forces,out(a.position.clone()));}",
        browser_laptop);
}

/* A cube that is lifted by one and a half of its radii would be above the picture, which is no larger than the cube. */
static void test_lifted(void **state)
{
    (void)state;
    if (nothing_to_open()) return;
    json_t *seen = lifted("0.05");
    assert_true(seen_number(seen, "follows") == 1);
    assert_true(seen_number(seen, "out") > 0.5 && seen_number(seen, "out") < 1);
    assert_true(seen_number(seen, "forces") > 0 && seen_number(seen, "forces") < 1);
    json_decref(seen);
    /* where there is room enough the picture stands still */
    seen = lifted("0.002");
    assert_true(seen_number(seen, "follows") == 0);
    assert_true(seen_number(seen, "out") > 0.5 && seen_number(seen, "out") < 1);
    json_decref(seen);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_self_contained),
        cmocka_unit_test(test_missing_library),
        cmocka_unit_test(test_no_console_errors),
        cmocka_unit_test(test_forces),
        cmocka_unit_test(test_keyboard),
        cmocka_unit_test(test_laptop),
        cmocka_unit_test(test_narrow),
        cmocka_unit_test(test_print),
        cmocka_unit_test(test_left_behind),
        cmocka_unit_test(test_lifted),
    };
    return cmocka_run_group_tests(tests, make_page, remove_page);
}
