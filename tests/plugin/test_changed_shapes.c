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

/* ---- a part taken away ---- */

static const double SLAB[3] = {0.8, 0.4, 0.5};

static double dug; /* m: the height field lies by that much lower where x >= 0 */

static dReal height(void *data, int x, int z)
{
    (void)data, (void)z;
    return x >= 40 ? -dug : 0;
}

/* A height field of 8 m by 8 m, whose y axis ODE has pointing up. */
static dGeomID make_field(void)
{
    dMatrix3 upright;
    dHeightfieldDataID data = dGeomHeightfieldDataCreate();
    dGeomHeightfieldDataBuildCallback(data, NULL, height, 8, 8, 81, 81, 1, 0, 2, 0);
    dGeomHeightfieldDataSetBounds(data, -3, 3);
    dGeomID field = dCreateHeightfield(NULL, data, 1);
    dRFromAxisAndAngle(upright, 1, 0, 0, M_PI / 2);
    dGeomSetRotation(field, upright);
    return field;
}

static void end_field(scene *s)
{
    dHeightfieldDataID data = dGeomHeightfieldGetHeightfieldData(s->ground);
    end(s);
    dGeomHeightfieldDataDestroy(data);
    dug = 0;
}

static bool behind(const dContactGeom *found)
{
    return found->pos[0] <= 0;
}

static bool to_the_left(const dContactGeom *found)
{
    return found->pos[1] >= 0;
}

static void assert_topples(scene *s)
{
    steps(s, 40);
    assert_true(dBodyGetRotation(s->body)[10] < 0.8); /* under ODE, too */
}

/* Its centre is above what has been dug away. */
static void test_topples_where_the_ground_is_dug_away(void **state)
{
    (void)state;
    scene s;
    make(&s, make_field(), SLAB, 0.1);
    steps(&s, SETTLING);
    assert_close(dBodyGetRotation(s.body)[10], 1, 1e-9);
    dug = 2;
    assert_topples(&s);
    end_field(&s);
}

/* A program hands over some of the points only that the collider returns. */
static void test_topples_where_contacts_are_filtered(void **state)
{
    (void)state;
    bool (*const filters[])(const dContactGeom *found) = {behind, to_the_left};
    for (int k = 0; k < 4; k++) {
        scene s;
        make(&s, k < 2 ? dCreatePlane(NULL, 0, 0, 1, 0) : make_block(), SLAB, 0.1);
        if (k % 2) dBodySetPosition(s.body, 0.1, -0.05, 0.25);
        steps(&s, SETTLING);
        s.hands_over = filters[k % 2];
        assert_topples(&s);
        end(&s);
    }
}

/* ---- a collider that flickers ---- */

static int turn; /* which two of the corners it returns */

/* The corners of the box that are below z = 0, two at a time. */
static int flickering(dGeomID box, dGeomID ground, int flags, dContactGeom *contacts, int skip)
{
    int count = 0;
    (void)flags;
    for (int k = 0; k < 4; k++) {
        if ((k & 1) != turn % 2) continue;
        dContactGeom *c = (dContactGeom *)((char *)contacts + (ptrdiff_t)skip * count);
        const double x = k & 1 ? 0.5 : -0.5, y = k & 2 ? 0.5 : -0.5;
        dVector3 corner;
        dBodyGetRelPointPos(dGeomGetBody(box), x * SLAB[0], y * SLAB[1], -0.5 * SLAB[2], corner);
        if (corner[2] > 0) continue;
        memset(c, 0, sizeof *c);
        memcpy(c->pos, corner, 3 * sizeof(double));
        c->normal[2] = 1;
        c->depth = -corner[2];
        c->g1 = box;
        c->g2 = ground;
        count++;
    }
    return count;
}

static dGeomID make_mesh(dTriMeshDataID *data)
{
    static const double vertices[12] = {-4, -4, 0, 4, -4, 0, 4, 4, 0, -4, 4, 0};
    static const dTriIndex indices[6] = {0, 1, 2, 0, 2, 3};
    *data = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildDouble(*data, vertices, 3 * sizeof(double), 4, indices, 6, 3 * sizeof(dTriIndex));
    return dCreateTriMesh(NULL, *data, NULL, NULL, NULL);
}

/* A collider leaves out two of four corners, others in each step, or the same for long. As long as the ground is there,
 * the box lies on all four; and where it is dug away below those that are left out, on these no more. */
static void test_lies_on_points_that_flicker(void **state)
{
    (void)state;
    const int classes[] = {dPlaneClass, dTriMeshClass, dHeightfieldClass};
    for (int i = 0; i < 3; i++) dSetColliderOverride(dBoxClass, classes[i], flickering);
    for (int i = 0; i < 3; i++) {
        scene s;
        dTriMeshDataID data = NULL;
        dGeomID ground = i == 0 ? dCreatePlane(NULL, 0, 0, 1, 0) : i == 1 ? make_mesh(&data) : make_field();
        make(&s, ground, SLAB, 0.1);
        dBodySetPosition(s.body, 0.1, 0, 0.5 * SLAB[2] - 1e-6);
        for (int k = 0; k < 200; k++) {
            turn = k < 100 ? k : 0;
            steps(&s, 1);
        }
        assert_close(dBodyGetRotation(s.body)[10], 1, 1e-11);
        assert_close(dBodyGetPosition(s.body)[2], 0.5 * SLAB[2], 1e-5);
        if (i == 2) {
            dug = 2;
            assert_topples(&s);
            end_field(&s);
        } else {
            end(&s);
        }
        if (data) dGeomTriMeshDataDestroy(data);
    }
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_comes_out_of_a_shape_that_grows),
        cmocka_unit_test(test_slides_on_a_plane_that_tilts),
        cmocka_unit_test(test_topples_where_the_ground_is_dug_away),
        cmocka_unit_test(test_topples_where_contacts_are_filtered),
        cmocka_unit_test(test_lies_on_points_that_flicker), /* last: it changes ODE's colliders */
    };
    int failed = cmocka_run_group_tests_name("changed shapes", tests, NULL, NULL);
    dCloseODE();
    return failed;
}
