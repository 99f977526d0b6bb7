/*
 * Soft fingertips hold a block by friction, and a load pulls along their faces. What the springs of friction give way
 * to is known. After that the block stays where it is, whatever rounding makes of the collider's points from step to
 * step.
 */
#include "support/cmocka_all.h"

#include <pinch/ode.h>

#include <math.h>
#include <string.h>

enum { TIPS = 2, MOST_FOUND = 64 };
static const double DAMPING = 0.05; /* s: of a point, over its stiffness */

typedef struct grip {
    dWorldID world;
    pinch_ode *plugin;
    dBodyID block, finger[TIPS];
    dGeomID tip[TIPS], held;
    dSurfaceParameters surface;
    bool filtered; /* the program leaves out a corner */
    int most;      /* contacts that it asks the collider for */
    double step, load[3];
} grip;

/* stiffness: of a point (N/m); it is damped, as ERP and CFM make it. */
static void make_soft(grip *g, double stiffness)
{
    double damping = DAMPING * stiffness, sum = g->step * stiffness + damping;
    g->surface.mode = dContactApprox1 | dContactSoftERP | dContactSoftCFM;
    g->surface.soft_erp = g->step * stiffness / sum;
    g->surface.soft_cfm = 1 / sum;
}

/* Puts a tip beside the block, on a slider that presses it on with a force (N). */
static void add_finger(grip *g, int i, dGeomID tip, double thickness, double half, double force)
{
    double side = i ? 1 : -1;
    dMass mass;
    g->tip[i] = tip;
    g->finger[i] = dBodyCreate(g->world);
    dMassSetBoxTotal(&mass, 0.5, thickness, thickness, thickness);
    dBodySetMass(g->finger[i], &mass);
    dBodySetPosition(g->finger[i], side * (half + 0.5 * thickness + 2e-4), 0, 0);
    dGeomSetBody(tip, g->finger[i]);
    dJointID slider = dJointCreateSlider(g->world, NULL);
    dJointAttach(slider, g->finger[i], NULL);
    dJointSetSliderAxis(slider, 1, 0, 0);
    dJointSetSliderParam(slider, dParamVel, side * -0.2);
    dJointSetSliderParam(slider, dParamFMax, force);
}

/* Makes a cube (m, kg) between two tips, which is turned by next to nothing against them. */
static void make(grip *g, double step, double edge, double mass, dGeomID tips[TIPS], double thickness, double force)
{
    dMatrix3 turned;
    dMass of_block;
    memset(g, 0, sizeof *g);
    g->step = step;
    g->most = MOST_FOUND;
    g->world = dWorldCreate();
    pinch_ode_settings settings = pinch_ode_default_settings();
    settings.scope = PINCH_ODE_ALL_CONTACTS;
    assert_int_equal(pinch_ode_create(g->world, &settings, &g->plugin), PINCH_OK);
    g->block = dBodyCreate(g->world);
    dMassSetBoxTotal(&of_block, mass, edge, edge, edge);
    dBodySetMass(g->block, &of_block);
    dRFromAxisAndAngle(turned, 0, 1, 0.3, 1e-9);
    dBodySetRotation(g->block, turned);
    g->held = dCreateBox(NULL, edge, edge, edge);
    dGeomSetBody(g->held, g->block);
    for (int i = 0; i < TIPS; i++) add_finger(g, i, tips[i], thickness, 0.5 * edge, force);
}

static void end(grip *g)
{
    pinch_ode_stats stats = pinch_ode_statistics(g->plugin);
    assert_int_equal(stats.contacts_left, 0);
    assert_int_equal(stats.fallback_islands, 0);
    for (int i = 0; i < TIPS; i++) dGeomDestroy(g->tip[i]);
    dGeomDestroy(g->held);
    pinch_ode_destroy(g->plugin);
    dWorldDestroy(g->world);
}

/* Steps on for a time (s). The order of a pair's geoms changes from step to step, as ODE's spaces change it. */
static void run(grip *g, double time)
{
    dContact found[MOST_FOUND];
    for (long n = 0, steps = lround(time / g->step); n < steps; n++) {
        for (int i = 0; i < TIPS; i++) {
            bool swapped = (n + i) % 3 == 0;
            memset(found, 0, sizeof found);
            dGeomID first = swapped ? g->held : g->tip[i], second = swapped ? g->tip[i] : g->held;
            int count = dCollide(first, second, g->most, &found->geom, sizeof *found);
            for (int k = 0; k < count; k++) {
                if (g->filtered && found[k].geom.pos[1] > 0 && found[k].geom.pos[2] > 0) continue;
                found[k].surface = g->surface;
                assert_int_equal(pinch_ode_add_contact(g->plugin, &found[k], dGeomGetBody(first), dGeomGetBody(second)),
                                 PINCH_OK);
            }
        }
        dBodyAddForce(g->block, g->load[0], g->load[1], g->load[2]);
        assert_int_equal(pinch_ode_step(g->plugin, g->step), PINCH_OK);
    }
}

/* Presses for half a second, pulls with a load, and returns how far (m) the block has gone a second later. It must
 * not go on then, in half a second by more than `creep`. */
static double way_under_load(grip *g, double load, double creep)
{
    run(g, 0.5);
    double before = dBodyGetPosition(g->block)[2];
    g->load[2] = load;
    run(g, 1);
    double way = dBodyGetPosition(g->block)[2] - before;
    run(g, 0.5);
    assert_close(dBodyGetPosition(g->block)[2] - before, way, creep);
    return way;
}

/* Shakes the block for three seconds, and returns how far (m) it is then from where it was. */
static double way_of_shaking(grip *g, double load)
{
    double before[3], way[3];
    memcpy(before, dBodyGetPosition(g->block), sizeof before);
    for (double t = 0; t < 3; t += g->step) {
        g->load[1] = -load * sin(9 * t);
        g->load[2] = load * cos(7 * t);
        run(g, g->step);
    }
    g->load[1] = 0;
    g->load[2] = load;
    run(g, 1);
    for (int i = 0; i < 3; i++) way[i] = dBodyGetPosition(g->block)[i] - before[i];
    return sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
}

/*
 * Faces as large as the block's, pressed in by 10 mm, which is more than the merge distance: it is rounding that
 * decides whose points the collider returns, and they lie by that much apart.
 */
static void test_faces_that_lie_on_each_other(void **state)
{
    (void)state;
    const double stiffness = 1000, edge = 0.1, force = 40, load = 8, ratio = 2.0 / 3;
    for (int plates = 0; plates < 2; plates++) {
        double thickness = plates ? 0.02 : edge;
        for (int fine = 0; fine < 2; fine++) {
            grip g;
            dGeomID tips[TIPS] = {dCreateBox(NULL, thickness, edge, edge), dCreateBox(NULL, thickness, edge, edge)};
            make(&g, fine ? 0.001 : 0.005, edge, 1, tips, thickness, force);
            make_soft(&g, stiffness);
            g.surface.mu = 1;
            double way = way_under_load(&g, load, 1e-6);
            /* eight points, each as stiff along the face as the tangential ratio says; large ways bend the geometry */
            assert_close(way, load / (8 * ratio * stiffness), 0.02 * way);
            end(&g);
        }
    }
}

/* A box (m) of twelve triangles that face outwards. */
static dGeomID make_mesh_box(dTriMeshDataID *data, double x, double y, double z, double (*corner)[3])
{
    static const dTriIndex triangles[36] = {0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1,
                                            2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
    for (int i = 0; i < 8; i++) {
        corner[i][0] = i & 4 ? 0.5 * x : -0.5 * x;
        corner[i][1] = i & 2 ? 0.5 * y : -0.5 * y;
        corner[i][2] = i & 1 ? 0.5 * z : -0.5 * z;
    }
    *data = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildDouble(*data, corner, sizeof *corner, 8, triangles, 36, 3 * sizeof *triangles);
    return dCreateTriMesh(NULL, *data, NULL, NULL, NULL);
}

/*
 * Tips that are meshes: beside each of their corners the collider returns points where edges go through the block's
 * surface, twelve in all, and in some steps, where block and tips have turned by rounding only, the same corners three
 * and four times over. A hand that swings has it do so again and again. Each corner is one spring.
 */
static void hold_by_meshes(double step, int most)
{
    const double stiffness = 4000, edge = 0.05, thickness = 0.02, width = 0.03, load = 2, ratio = 2.0 / 3;
    grip g;
    dTriMeshDataID data[TIPS];
    double corner[TIPS][8][3];
    dGeomID tips[TIPS];
    for (int i = 0; i < TIPS; i++) tips[i] = make_mesh_box(&data[i], thickness, width, width, corner[i]);
    make(&g, step, edge, 0.2, tips, thickness, 20);
    make_soft(&g, stiffness);
    g.surface.mu = 0.6;
    g.most = most;
    double way = way_under_load(&g, load, 1e-9);
    assert_close(way, load / (8 * ratio * stiffness), 1e-3 * way);
    double between = dBodyGetPosition(g.finger[1])[0] - dBodyGetPosition(g.finger[0])[0];
    assert_close(edge + thickness - between, 2 * 20 / (4 * stiffness), 1e-6);
    if (most == MOST_FOUND) /* of 34 points a collider that is asked for 8 leaves whole corners out */
        assert_close(way_of_shaking(&g, load), 0, 1e-8);
    end(&g);
    for (int i = 0; i < TIPS; i++) dGeomTriMeshDataDestroy(data[i]);
}

static void test_tips_that_are_meshes(void **state)
{
    (void)state;
    static const double STEPS[] = {0.005, 0.001, 0.0002};
    for (int k = 0; k < 3; k++) {
        hold_by_meshes(STEPS[k], MOST_FOUND);
        hold_by_meshes(STEPS[k], 8);
    }
}

/* Points that the program leaves out go, on whichever surface they have been. */
static void test_corners_that_are_left_out(void **state)
{
    (void)state;
    const double edge = 0.1;
    for (int steps = 1; steps <= 6; steps++) { /* in each of them the points may be elsewhere */
        grip g;
        const pinch_ode_contact *list;
        int count;
        dGeomID tips[TIPS] = {dCreateBox(NULL, edge, edge, edge), dCreateBox(NULL, edge, edge, edge)};
        make(&g, 0.005, edge, 1, tips, edge, 40);
        make_soft(&g, 1000);
        g.surface.mu = 1;
        run(&g, 0.5 + steps * g.step);
        assert_int_equal(pinch_ode_contacts(g.plugin, &list, &count), PINCH_OK);
        assert_int_equal(count, 8);
        g.filtered = true;
        run(&g, g.step);
        assert_int_equal(pinch_ode_contacts(g.plugin, &list, &count), PINCH_OK);
        assert_int_equal(count, 6);
        end(&g);
    }
}

/* Lets the contacts be hard, or soft again. */
static void set_hard(grip *g, bool hard)
{
    g->surface.mode = hard ? dContactApprox1 : dContactApprox1 | dContactSoftERP | dContactSoftCFM;
}

static void make_heavy_grip(grip *g, double step, double stiffness)
{
    const double edge = 0.1, thickness = 0.02, force = 40;
    dGeomID tips[TIPS] = {dCreateBox(NULL, thickness, edge, edge), dCreateBox(NULL, thickness, edge, edge)};
    make(g, step, edge, 1, tips, thickness, force);
    make_soft(g, stiffness);
    g->surface.mu = 0.8;
}

/* Contacts that are soft and hard in turns hold what they hold as either: the shear that each of them loses as it
 * becomes harder comes back, and nothing sags a little further each time. */
static void test_contacts_that_are_soft_and_hard_in_turns(void **state)
{
    (void)state;
    enum { SETTLE = 120 };
    static const double steps[] = {1e-3, 2e-3, 4e-3, 1e-2}, stiffnesses[] = {2e4, 1e5};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 2; j++)
            for (int each = 1; each < 4; each++) {
                grip g;
                make_heavy_grip(&g, steps[i], stiffnesses[j]);
                g.load[2] = -9.81;
                run(&g, 0.5);
                double before = 0;
                for (int k = -SETTLE; k < 500; k++) {
                    if (k == 0) before = dBodyGetPosition(g.block)[2];
                    set_hard(&g, (k + SETTLE) / each % 2);
                    run(&g, g.step);
                }
                assert_close(dBodyGetPosition(g.block)[2], before, 5e-5);
                end(&g);
            }
}

/* A load that goes while contacts are hard leaves nothing behind: as they become soft again the block springs back to
 * where it was without it, and no further on the way than a spring would throw it. */
static void test_a_load_that_goes_while_contacts_are_hard(void **state)
{
    (void)state;
    const double stiffness = 2e4, ratio = 2.0 / 3, load = 9.81;
    grip g;
    make_heavy_grip(&g, 4e-3, stiffness);
    run(&g, 0.5);
    double before = dBodyGetPosition(g.block)[2], sheared = load / (8 * ratio * stiffness);
    g.load[2] = -load;
    run(&g, 0.5);
    assert_close(before - dBodyGetPosition(g.block)[2], sheared, 0.01 * sheared);
    set_hard(&g, true);
    run(&g, 0.5);
    g.load[2] = 0;
    run(&g, 0.5);
    assert_close(before - dBodyGetPosition(g.block)[2], sheared, 0.01 * sheared);
    set_hard(&g, false);
    for (int k = 0; k < 100; k++) {
        run(&g, g.step);
        assert_true(dBodyGetPosition(g.block)[2] - before < sheared);
    }
    assert_close(dBodyGetPosition(g.block)[2], before, 0.01 * sheared);
    end(&g);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_faces_that_lie_on_each_other),
                                       cmocka_unit_test(test_tips_that_are_meshes),
                                       cmocka_unit_test(test_corners_that_are_left_out),
                                       cmocka_unit_test(test_contacts_that_are_soft_and_hard_in_turns),
                                       cmocka_unit_test(test_a_load_that_goes_while_contacts_are_hard)};
    dInitODE2(0);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    dCloseODE();
    return failed;
}
