/*
 * A box lies on the ground, and nothing moves. Then a program makes another shape of the ground or of the box, or takes
 * a part of the contacts away. Pinch keeps contact points from step to step, and none may be kept that is no more.
 */
#include "support/cmocka_all.h"

#include <math.h>
#include <pinch/ode.h>
#include <string.h>

enum { CONTACTS = 16, SETTLING = 150 /* steps */ };

static const double STEP = 0.01; /* s */

typedef struct scene scene;
struct scene {
    dWorldID world;
    dBodyID body;
    dGeomID ground, box;
    pinch_ode *plugin;
    bool (*hands_over)(const dContactGeom *found); /* NULL: all */
};

static void make(scene *s, dGeomID ground, const double *size, double x)
{
    dMass mass;
    pinch_ode_settings settings = pinch_ode_default_settings();
    memset(s, 0, sizeof *s);
    s->world = dWorldCreate();
    dWorldSetGravity(s->world, 0, 0, -9.81);
    s->ground = ground;
    s->body = dBodyCreate(s->world);
    dMassSetBoxTotal(&mass, 1, size[0], size[1], size[2]);
    dBodySetMass(s->body, &mass);
    s->box = dCreateBox(NULL, size[0], size[1], size[2]);
    dGeomSetBody(s->box, s->body);
    dBodySetPosition(s->body, x, 0, 0.5 * size[2]);
    assert_int_equal(pinch_ode_create(s->world, &settings, &s->plugin), PINCH_OK);
}

static void steps(scene *s, int count)
{
    dContact c[CONTACTS];
    for (int i = 0; i < count; i++) {
        int found = dCollide(s->box, s->ground, CONTACTS, &c[0].geom, sizeof c[0]);
        for (int k = 0; k < found; k++) {
            memset(&c[k].surface, 0, sizeof c[k].surface);
            c[k].surface.mode = dContactApprox1;
            c[k].surface.mu = 0.5;
            if (!s->hands_over || s->hands_over(&c[k].geom))
                assert_int_equal(pinch_ode_add_contact(s->plugin, &c[k], s->body, NULL), PINCH_OK);
        }
        assert_int_equal(pinch_ode_step(s->plugin, STEP), PINCH_OK);
    }
}

static void end(scene *s)
{
    pinch_ode_destroy(s->plugin);
    dGeomDestroy(s->box);
    dGeomDestroy(s->ground);
    dWorldDestroy(s->world);
}

/* ---- another shape ---- */

static const double CUBE[3] = {0.2, 0.2, 0.2};

static void raise_plane(scene *s, double by)
{
    dGeomPlaneSetParams(s->ground, 0, 0, 1, by);
}

static void raise_block(scene *s, double by)
{
    dGeomBoxSetLengths(s->ground, 6, 6, 1 + 2 * by);
}

static void grow_box(scene *s, double by)
{
    dGeomBoxSetLengths(s->box, CUBE[0], CUBE[1], CUBE[2] + 2 * by);
}

static dGeomID make_block(void)
{
    dGeomID block = dCreateBox(NULL, 6, 6, 1);
    dGeomSetPosition(block, 0, 0, -0.5);
    return block;
}

/* However deep the box is in the ground at once, it comes out. */
static void test_comes_out_of_a_shape_that_grows(void **state)
{
    (void)state;
    void (*const changes[])(scene * s, double by) = {raise_plane, raise_block, grow_box};
    for (int i = 0; i < 12; i++) {
        const double amounts[] = {0.01, 0.03, 0.05, 0.09}, by = amounts[i % 4];
        scene s;
        make(&s, i / 4 == 0 ? dCreatePlane(NULL, 0, 0, 1, 0) : make_block(), CUBE, 0);
        steps(&s, SETTLING);
        changes[i / 4](&s, by);
        steps(&s, 200);
        assert_close(dBodyGetPosition(s.body)[2], 0.1 + by, 1e-4);
        end(&s);
    }
}

/* The plane below it is tilted at once, beyond the angle of friction (0.46 rad) or not as far. */
static void test_slides_on_a_plane_that_tilts(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        const double angle = k ? 0.3 : 0.6;
        scene s;
        make(&s, dCreatePlane(NULL, 0, 0, 1, 0), CUBE, 0);
        steps(&s, SETTLING);
        dGeomPlaneSetParams(s.ground, sin(angle), 0, cos(angle), 0);
        steps(&s, 200);
        const double *x = dBodyGetPosition(s.body), *R = dBodyGetRotation(s.body), before = x[0];
        assert_close(sin(angle) * R[2] + cos(angle) * R[10], 1, 1e-3); /* it lies flat on the plane, and not in it */
        assert_close(sin(angle) * x[0] + cos(angle) * x[2], 0.1, 1e-3);
        steps(&s, 50);
        if (k)
            assert_close(x[0], before, 1e-4);
        else
            assert_true(x[0] > before + 0.5);
        end(&s);
    }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_comes_out_of_a_shape_that_grows),
        cmocka_unit_test(test_slides_on_a_plane_that_tilts),
    };
    int failed = cmocka_run_group_tests_name("changed shapes", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
