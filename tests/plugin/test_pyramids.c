/*
 * Pyramids of boxes with ODE's own contacts. Neighbours in a course touch and bear nothing: edges lie along edges,
 * where rounding decides which points ODE's collider returns, and from step to step other contacts hardly bear
 * anything. A pyramid that was built in balance must stay as it was built, and come to rest.
 */
#include "support/cmocka_all.h"

#include <math.h>
#include <pinch/ode.h>
#include <string.h>

enum { COURSES = 10, TALL = 100, MOST_BOXES = TALL * (TALL + 1) / 2, POINTS = 8, STEPS = 600 };
static const double STEP = 0.01, SIZE = 0.25, MASS = 1, CFM = 1e-5, GRAVITY = 9.81;

typedef struct pyramid {
    dWorldID world;
    dSpaceID space;
    pinch_ode *plugin;
    int count;
    dBodyID body[MOST_BOXES];
    double built[MOST_BOXES][3];
} pyramid;

static void add_box(pyramid *p, double depth, double x, double z)
{
    dMass mass;
    dBodyID body = dBodyCreate(p->world);
    dGeomID geom = dCreateBox(p->space, SIZE, depth, SIZE);
    dMassSetBoxTotal(&mass, MASS, SIZE, depth, SIZE);
    dBodySetMass(body, &mass);
    dGeomSetBody(geom, body);
    dBodySetPosition(body, x, 0, z);
    memcpy(p->built[p->count], dBodyGetPosition(body), sizeof p->built[0]);
    p->body[p->count++] = body;
}

/* Lays boxes over the joints of the course below, pressed in by what will lie on them. Odd courses are set back. */
static void pyramid_make(pyramid *p, int courses, double gap)
{
    memset(p, 0, sizeof *p);
    p->world = dWorldCreate();
    p->space = dSimpleSpaceCreate(NULL);
    dWorldSetGravity(p->world, 0, 0, -GRAVITY);
    dWorldSetCFM(p->world, CFM);
    dCreatePlane(p->space, 0, 0, 1, 0);
    pinch_ode_settings settings = pinch_ode_default_settings();
    assert_int_equal(pinch_ode_create(p->world, &settings, &p->plugin), PINCH_OK);
    double stiffness = dWorldGetERP(p->world) / (STEP * CFM), top = 0;
    for (int course = 0; course < courses; course++) {
        int boxes = courses - course;
        double pressed = GRAVITY * MASS * 0.5 * (boxes + 1) / ((course > 0 ? 8 : 4) * stiffness);
        double z = top - pressed + 0.5 * SIZE;
        for (int k = 0; k < boxes; k++)
            add_box(p, course % 2 ? 0.98 * SIZE : SIZE, (k - 0.5 * (boxes - 1)) * (SIZE + gap), z);
        top = z + 0.5 * SIZE;
    }
}

static void near_callback(void *data, dGeomID a, dGeomID b)
{
    pyramid *p = data;
    dContactGeom found[POINTS];
    int count = dCollide(a, b, POINTS, found, sizeof found[0]);
    for (int i = 0; i < count; i++) {
        dContact contact;
        memset(&contact, 0, sizeof contact);
        contact.geom = found[i];
        contact.surface.mode = dContactApprox1;
        contact.surface.mu = 0.5;
        assert_int_equal(pinch_ode_add_contact(p->plugin, &contact, dGeomGetBody(a), dGeomGetBody(b)), PINCH_OK);
    }
}

static void pyramid_free(pyramid *p)
{
    pinch_ode_destroy(p->plugin);
    dSpaceDestroy(p->space);
    dWorldDestroy(p->world);
}

static void stands_and_rests(int courses, double gap)
{
    static pyramid p;
    pyramid_make(&p, courses, gap);
    for (int step = 0; step < STEPS; step++) {
        dSpaceCollide(p.space, &p, near_callback);
        assert_int_equal(pinch_ode_step(p.plugin, STEP), PINCH_OK);
    }
    pinch_ode_stats stats = pinch_ode_statistics(p.plugin);
    double moved = 0, fastest = 0;
    for (int k = 0; k < p.count; k++) {
        const double *x = dBodyGetPosition(p.body[k]);
        for (int i = 0; i < 3; i++) moved = fmax(moved, fabs(x[i] - p.built[k][i]));
        fastest = fmax(fastest, dCalcVectorLength3(dBodyGetLinearVel(p.body[k])));
    }
    print_message("%d boxes, gap %g m: %ld steps at rest, moved %.1e m, %ld softened, %ld Newton steps\n", p.count, gap,
                  stats.islands_at_rest, moved, stats.softened_islands, stats.newton_steps);
    assert_int_equal(stats.unconverged_steps, 0);
    assert_int_equal(stats.contacts_left, 0);
    assert_true(moved < 1e-4);
    assert_true(fastest == 0);
    assert_true(stats.islands_at_rest > STEPS / 4);
    assert_true(2 * stats.newton_steps <= 3 * (STEPS - stats.islands_at_rest)); /* contacts that creep slip on */
    pyramid_free(&p);
}

static void neighbours_that_touch(void **state)
{
    (void)state;
    for (int courses = 3; courses <= COURSES; courses++) stands_and_rests(courses, 0);
}

static void neighbours_apart(void **state)
{
    (void)state;
    stands_and_rests(COURSES, 0.004);
}

/* In the first step there are no forces of the last one, and factors in single precision do not serve. ODE's own method
 * would take hours for a step. */
static void tall_one_begins_to_stand(void **state)
{
    (void)state;
    static pyramid p;
    pyramid_make(&p, TALL, 0.004);
    for (int step = 0; step < 2; step++) {
        assert_int_equal(pinch_ode_each_pair(p.plugin, p.space, &p, near_callback), PINCH_OK);
        assert_int_equal(pinch_ode_step(p.plugin, STEP), PINCH_OK);
    }
    double fastest = 0;
    for (int k = 0; k < p.count; k++) fastest = fmax(fastest, dCalcVectorLength3(dBodyGetLinearVel(p.body[k])));
    print_message("%d boxes: up to %.1e m/s, residual %.1e N\n", p.count, fastest,
                  pinch_ode_statistics(p.plugin).residual_max);
    assert_true(fastest < 0.1 * STEP * GRAVITY);
    pyramid_free(&p);
}

/* Where sweeps have done for an island, one that has become too small for them is solved, and not left to ODE. */
static void what_was_swept_is_tried_again(void **state)
{
    enum { LARGE = 16, ABOVE = 3, CONTACTS = 4 * LARGE * LARGE, MANY = 1000 };
    (void)state;
    static pyramid p;
    pyramid_make(&p, LARGE, 0.004);
    pinch_ode_destroy(p.plugin);
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.solver.budget = 1;
    assert_int_equal(pinch_ode_create(p.world, &settings, &p.plugin), PINCH_OK);
    assert_int_equal(pinch_ode_each_pair(p.plugin, p.space, &p, near_callback), PINCH_OK);
    assert_int_equal(pinch_ode_step(p.plugin, STEP), PINCH_OK);
    pinch_ode_stats stats = pinch_ode_statistics(p.plugin);
    assert_int_equal(stats.contacts_solved, CONTACTS);
    assert_int_equal(stats.swept_islands, 1);

    for (int k = 1; k <= ABOVE; k++) dGeomDisable(dBodyGetFirstGeom(p.body[p.count - k]));
    assert_int_equal(pinch_ode_each_pair(p.plugin, p.space, &p, near_callback), PINCH_OK);
    assert_int_equal(pinch_ode_solve(p.plugin, STEP), PINCH_OK);
    pinch_ode_outcome outcome;
    assert_int_equal(pinch_ode_read_outcome(p.plugin, 0, &outcome), PINCH_OK);
    assert_true(CONTACTS - 8 * ABOVE <= MANY && outcome.tried && !outcome.result.swept);
    pyramid_free(&p);
}

static void count_recording(void *context, const pinch_ode_recording *recording)
{
    (void)recording;
    ++*(int *)context;
}

/* Builds a pyramid of hard boxes, which is swept where solves go over their budgets, and says where its boxes are after
 * some steps. `recordings` is NULL where nobody looks. */
static void fall_into_place(double place[][3], int *recordings)
{
    enum { TOUCHING = 26, FEW = 20 };
    static pyramid p;
    pyramid_make(&p, 0, 0);
    pinch_ode_destroy(p.plugin);
    dWorldSetCFM(p.world, 1e-10);
    for (int course = 0; course < TOUCHING; course++)
        for (int k = 0; k < TOUCHING - course; k++)
            add_box(&p, SIZE, (k - 0.5 * (TOUCHING - course)) * SIZE, (course + 0.5) * SIZE);
    pinch_ode_settings settings = pinch_ode_default_settings();
    if (recordings) settings.recorder = count_recording;
    settings.recorder_context = recordings;
    assert_int_equal(pinch_ode_create(p.world, &settings, &p.plugin), PINCH_OK);
    for (int step = 0; step < FEW; step++) {
        dSpaceCollide(p.space, &p, near_callback);
        assert_int_equal(pinch_ode_step(p.plugin, STEP), PINCH_OK);
    }
    for (int k = 0; k < p.count; k++) memcpy(place[k], dBodyGetPosition(p.body[k]), sizeof place[k]);
    pyramid_free(&p);
}

/* A recorder is shown what failed solves ended with. What is tried after them must not begin there. */
static void a_recorder_changes_nothing(void **state)
{
    (void)state;
    static double place[MOST_BOXES][3], recorded[MOST_BOXES][3];
    int recordings = 0;
    fall_into_place(place, NULL);
    fall_into_place(recorded, &recordings);
    print_message("%d solves recorded\n", recordings);
    assert_true(recordings > 0);
    assert_memory_equal(place, recorded, sizeof place);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {cmocka_unit_test(neighbours_that_touch), cmocka_unit_test(neighbours_apart),
                                       cmocka_unit_test(tall_one_begins_to_stand),

                                       cmocka_unit_test(what_was_swept_is_tried_again),
                                       cmocka_unit_test(a_recorder_changes_nothing)};
    int failed = cmocka_run_group_tests_name("pyramids", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
