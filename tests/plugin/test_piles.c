/*
 * Bodies of several shapes, all of them fingertips, tumble into a box, where everything slips, rolls and stacks. Every
 * step must be solved, and what lies must lie still.
 */
#include "support/cmocka_all.h"

#include "support/draw.h"

#include <pinch/ode.h>
#include <stdio.h>
#include <string.h>

enum { MAX_BODIES = 10, MAX_POINTS = 16, WALLS = 5 };

typedef struct pile {
    dWorldID world;
    dSpaceID space;
    pinch_ode *plugin;
    int count;
    dBodyID body[MAX_BODIES];
    double friction;
} pile;

static void give_material(pile *p, pinch_random *random, dGeomID geom, double mass)
{
    pinch_material m = pinch_default_material();
    m.model = draw_chance(random, 0.3) ? PINCH_CONTACT_SOFT : PINCH_CONTACT_HARD;
    double kn = draw_log_uniform(random, 2e3, 5e4);
    m.stiffness[0] = kn;
    m.stiffness[1] = kn * draw_uniform(random, 0.4, 1);
    m.stiffness[2] = kn * 1e-4;
    for (int i = 0; i < 3; i++) m.damping[i] = m.stiffness[i] / kn * sqrt(kn * mass) * draw_uniform(random, 0.2, 1.5);
    m.friction = m.friction_kinetic = p->friction * draw_uniform(random, 0.7, 1);
    if (draw_chance(random, 0.3)) m.friction_kinetic *= 0.7;
    m.torsional_friction = 2e-3;
    assert_int_equal(pinch_ode_set_material(p->plugin, geom, &m), PINCH_OK);
}

static void pile_make(pile *p, uint64_t seed)
{
    pinch_random random;
    memset(p, 0, sizeof *p);
    pinch_random_seed(&random, seed);
    p->world = dWorldCreate();
    dWorldSetGravity(p->world, 0, 0, -9.81);
    p->space = dSimpleSpaceCreate(NULL);
    p->friction = draw_uniform(&random, 0.1, 1.2);
    pinch_ode_settings settings = pinch_ode_default_settings();
    assert_int_equal(pinch_ode_create(p->world, &settings, &p->plugin), PINCH_OK);
    for (int i = 0; i < WALLS; i++) { /* a floor and four walls, 12 cm apart */
        dGeomID wall = dCreateBox(p->space,
                                  i == 0  ? 1
                                  : i < 3 ? 0.1
                                          : 1,
                                  i == 0  ? 1
                                  : i < 3 ? 1
                                          : 0.1,
                                  i == 0 ? 0.1 : 1);
        double x = i == 1 ? 0.11 : i == 2 ? -0.11 : 0, y = i == 3 ? 0.11 : i == 4 ? -0.11 : 0;
        dGeomSetPosition(wall, x, y, i == 0 ? -0.05 : 0.5);
        give_material(p, &random, wall, 0.1);
    }
    p->count = 3 + draw_index(&random, MAX_BODIES - 2);
    for (int i = 0; i < p->count; i++) {
        double size = draw_uniform(&random, 0.01, 0.025), total = draw_log_uniform(&random, 0.02, 0.5), frame[9];
        dMass mass;
        dGeomID geom;
        dMatrix3 R;
        switch (draw_index(&random, 3)) {
        case 0:
            geom = dCreateSphere(p->space, size);
            dMassSetSphereTotal(&mass, total, size);
            break;
        case 1:
            geom = dCreateCapsule(p->space, 0.5 * size, 2 * size);
            dMassSetCapsuleTotal(&mass, total, 3, 0.5 * size, 2 * size);
            break;
        default: {
            double a = size * draw_uniform(&random, 1, 2), b = size * draw_uniform(&random, 1, 2);
            geom = dCreateBox(p->space, 1.5 * size, a, b);
            dMassSetBoxTotal(&mass, total, 1.5 * size, a, b);
        }
        }
        p->body[i] = dBodyCreate(p->world);
        dBodySetMass(p->body[i], &mass);
        dGeomSetBody(geom, p->body[i]);
        draw_frame(&random, frame);
        for (int r = 0; r < 3; r++) {
            for (int c = 0; c < 3; c++) R[4 * r + c] = frame[3 * r + c];
            R[4 * r + 3] = 0;
        }
        dBodySetRotation(p->body[i], R);
        double y = draw_uniform(&random, -0.03, 0.03), x = draw_uniform(&random, -0.03, 0.03);
        double turn_y = draw_uniform(&random, -5, 5), turn_x = draw_uniform(&random, -5, 5);
        dBodySetPosition(p->body[i], x, y, 0.04 + 0.06 * i);
        dBodySetAngularVel(p->body[i], turn_x, turn_y, 0);
        give_material(p, &random, geom, total);
    }
}

static void near_callback(void *data, dGeomID a, dGeomID b)
{
    pile *p = data;
    dContactGeom found[MAX_POINTS];
    dBodyID body1 = dGeomGetBody(a), body2 = dGeomGetBody(b);
    if (!body1 && !body2) return;
    int count = dCollide(a, b, MAX_POINTS, found, sizeof found[0]);
    for (int i = 0; i < count; i++) {
        dContact contact;
        memset(&contact, 0, sizeof contact);
        contact.geom = found[i];
        assert_int_equal(
            pinch_ode_add_contact(p->plugin, &contact, dGeomGetBody(found[i].g1), dGeomGetBody(found[i].g2)), PINCH_OK);
    }
}

static void pile_free(pile *p)
{
    pinch_ode_destroy(p->plugin);
    dSpaceDestroy(p->space);
    dWorldDestroy(p->world);
}

static void test_piles(void **state)
{
    (void)state;
    int wrong = 0, count = draw_count(2000);
    long steps = 0, unconverged = 0, fallbacks = 0, slow = 0;
    for (int seed = 1; seed <= count; seed++) {
        pile p;
        pile_make(&p, (uint64_t)seed);
        for (int step = 0; step < 2000; step++) {
            dSpaceCollide(p.space, &p, near_callback);
            assert_int_equal(pinch_ode_step(p.plugin, 1e-3), PINCH_OK);
        }
        pinch_ode_stats stats = pinch_ode_statistics(p.plugin);
        steps += stats.steps;
        assert_true(stats.contacts_solved > 500 * p.count); /* they do touch */
        unconverged += stats.unconverged_steps;
        fallbacks += stats.fallback_islands;
        slow += stats.iterations_max > 100;
        double fastest = 0;
        bool inside = true;
        for (int i = 0; i < p.count; i++) {
            const double *x = dBodyGetPosition(p.body[i]);
            fastest = fmax(fastest, dCalcVectorLength3(dBodyGetLinearVel(p.body[i])));
            inside = inside && fabs(x[0]) < 0.061 && fabs(x[1]) < 0.061 && x[2] > 0;
        }
        if (stats.unconverged_steps || stats.fallback_islands || !inside)
            print_error("seed %d: %d bodies, friction %.2f: %ld unconverged steps, %ld fallbacks, most iterations %d, "
                        "fastest at the end %g m/s%s\n",
                        seed, p.count, p.friction, stats.unconverged_steps, stats.fallback_islands,
                        stats.iterations_max, fastest, inside ? "" : ", left the box");
        wrong += stats.fallback_islands > 0 || !inside;
        pile_free(&p);
    }
    print_message("%d piles, %ld steps: %ld unconverged, %ld left to ODE, %ld piles with a step of more than 100 "
                  "iterations\n",
                  count, steps, unconverged, fallbacks, slow);
    assert_int_equal(wrong, 0);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_piles)};
    int failed = cmocka_run_group_tests_name("piles", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
