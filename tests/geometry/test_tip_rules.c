/*
 * What must hold for contacts whatever the shapes: mirrored to the bit when swapped, the same when moved together;
 * closed forms; ODE's own answers where ODE is exact; manifolds; queries; failures counted.
 */
#include "support/cmocka_all.h"

#include "support/tips.h"

#include <string.h>

enum { CONTACTS = 16, TRIALS = 400, MOVES = 1000 };

static int collide(const test_tip *a, const test_tip *b, dContactGeom *c)
{
    return dCollide(a->geom, b->geom, CONTACTS, c, sizeof *c);
}

static int deepest(const dContactGeom *c, int count)
{
    int best = 0;
    for (int k = 1; k < count; k++)
        if (c[k].depth > c[best].depth) best = k;
    return best;
}

static void place_touching(pinch_random *random, test_tip *a, test_tip *b, double low, double high)
{
    double R[9], x[3], y[3], away[3], back[3];
    draw_frame(random, R);
    for (int i = 0; i < 3; i++) x[i] = draw_uniform(random, -3, 3);
    test_tip_place(a, x, R);
    draw_frame(random, R);
    test_tip_place(b, x, R);
    draw_direction(random, away);
    for (int i = 0; i < 3; i++) back[i] = -away[i];
    double touch = test_overlap(a, b, back), part = draw_uniform(random, low, high);
    for (int i = 0; i < 3; i++) y[i] = x[i] + part * touch * away[i];
    test_tip_place(b, y, R);
}

static void test_swapped_is_mirrored(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 1);
    for (int trial = 0; trial < TRIALS; trial++) {
        test_tip a, b;
        dContactGeom c[CONTACTS], d[CONTACTS];
        test_tip_make(&random, (pinch_tip_type)draw_index(&random, PINCH_TIP_COUNT), &a);
        if (draw_chance(&random, 0.3)) {
            b = a; /* the same shape twice */
            if (b.tip.pieces) b.tip.pieces = &a.convex;
            test_tip_make_geom(&b);
        } else {
            test_tip_make(&random, (pinch_tip_type)draw_index(&random, PINCH_TIP_COUNT), &b);
        }
        place_touching(&random, &a, &b, 0.3, 1);
        int count = collide(&a, &b, c);
        assert_int_equal(collide(&b, &a, d), count);
        for (int k = 0; k < count; k++) {
            assert_true(c[k].g1 == a.geom && c[k].g2 == b.geom && d[k].g1 == b.geom && d[k].g2 == a.geom);
            assert_true(c[k].depth == d[k].depth);
            for (int i = 0; i < 3; i++) assert_true(c[k].pos[i] == d[k].pos[i] && c[k].normal[i] == -d[k].normal[i]);
        }
        test_tip_free(&a);
        test_tip_free(&b);
    }
}

static void turn(const double Q[9], const double *v, double *out)
{
    double r[3];
    for (int i = 0; i < 3; i++) r[i] = Q[3 * i] * v[0] + Q[3 * i + 1] * v[1] + Q[3 * i + 2] * v[2];
    memcpy(out, r, sizeof r);
}

static void move(test_tip *t, const double Q[9], const double *shift)
{
    double x[3], R[9];
    turn(Q, t->position, x);
    for (int i = 0; i < 3; i++) x[i] += shift[i];
    for (int j = 0; j < 3; j++) {
        double column[3] = {t->R[j], t->R[3 + j], t->R[6 + j]};
        turn(Q, column, column);
        for (int i = 0; i < 3; i++) R[3 * i + j] = column[i];
    }
    test_tip_place(t, x, R);
}

/* Depth and normal, and where there is one point its position; a point of a manifold may be another one where two are
 * equally deep. */
static void test_moved_together(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 2);
    int compared = 0;
    for (int trial = 0; trial < MOVES; trial++) {
        test_tip a, b;
        dContactGeom c[CONTACTS], d[CONTACTS];
        test_tip_make(&random, (pinch_tip_type)draw_index(&random, PINCH_TIP_COUNT), &a);
        test_tip_make(&random, (pinch_tip_type)draw_index(&random, PINCH_TIP_COUNT), &b);
        place_touching(&random, &a, &b, 0.7, 1);
        int count = collide(&a, &b, c);
        double Q[9], shift[3];
        draw_frame(&random, Q);
        for (int i = 0; i < 3; i++) shift[i] = draw_uniform(&random, -5, 5);
        move(&a, Q, shift);
        move(&b, Q, shift);
        int moved = collide(&a, &b, d);
        if (count > 0 && c[deepest(c, count)].depth > 1e-9) {
            assert_true(moved > 0);
            const dContactGeom *x = &c[deepest(c, count)], *y = &d[deepest(d, moved)];
            assert_close(x->depth, y->depth, 1e-9);
            double n[3];
            turn(Q, x->normal, n);
            for (int i = 0; i < 3; i++) assert_close(n[i], y->normal[i], 1e-9);
            /* a superellipsoid's flat spots make much of rounding in the normal */
            bool smooth = a.tip.type != PINCH_TIP_SUPERELLIPSOID && b.tip.type != PINCH_TIP_SUPERELLIPSOID;
            double at[3];
            turn(Q, x->pos, at);
            for (int i = 0; i < 3 && count == 1 && moved == 1; i++)
                assert_close(at[i] + shift[i], y->pos[i], smooth ? 1e-9 : 1e-6);
            compared++;
        }
        test_tip_free(&a);
        test_tip_free(&b);
    }
    assert_true(compared > MOVES / 2);
}

/* The same body, its corners given from another origin, `from` in its axes. */
static void make_about(const test_tip *tip, const double from[3], test_tip *about)
{
    double origin[3];
    *about = *tip;
    for (unsigned k = 0; k < 3 * tip->convex.point_count; k++) about->points[k] -= from[k % 3];
    for (unsigned k = 0; k < tip->convex.plane_count; k++)
        for (int i = 0; i < 3; i++) about->planes[4 * k + 3] -= about->planes[4 * k + i] * from[i];
    about->convex.points = about->points;
    about->convex.planes = about->planes;
    about->convex.polygons = about->polygons;
    about->tip.pieces = &about->convex;
    test_tip_make_geom(about);
    for (int i = 0; i < 3; i++)
        origin[i] =
            tip->position[i] + tip->R[3 * i] * from[0] + tip->R[3 * i + 1] * from[1] + tip->R[3 * i + 2] * from[2];
    test_tip_place(about, origin, tip->R);
}

/* A polyhedron's origin, which is not inside it where it is a piece of a larger body, is of no matter. */
static void test_origin_outside(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 11);
    for (int trial = 0; trial < TRIALS; trial++) {
        test_tip a, b, about;
        dContactGeom c[CONTACTS], d[CONTACTS];
        double from[3];
        test_tip_make(&random, PINCH_TIP_CONVEX, &a);
        test_tip_make(&random, (pinch_tip_type)draw_index(&random, PINCH_TIP_COUNT), &b);
        place_touching(&random, &a, &b, 0.5, 1);
        for (int i = 0; i < 3; i++) from[i] = draw_uniform(&random, -4, 4);
        make_about(&a, from, &about);
        int count = collide(&a, &b, c), again = collide(&about, &b, d);
        double depth = count ? c[deepest(c, count)].depth : 0, same = again ? d[deepest(d, again)].depth : 0;
        assert_close(depth, same, 1e-9);
        test_tip_free(&about);
        test_tip_free(&a);
        test_tip_free(&b);
    }
}

/* A polyhedron on a triangle of a mesh whose origin is far away is as deep as on a plane. */
static void test_mesh_far_from_its_origin(void **state)
{
    (void)state;
    static const double V[9] = {-10, 20, 7, 30, 20, 7, 10, 60, 7};
    static const dTriIndex T[3] = {0, 1, 2};
    static const double MIDDLE[3] = {10, 30, 7};
    pinch_random random;
    pinch_random_seed(&random, 12);
    dTriMeshDataID data = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildDouble(data, V, 3 * sizeof(double), 3, T, 3, 3 * sizeof(dTriIndex));
    dGeomID mesh = dCreateTriMesh(NULL, data, NULL, NULL, NULL), plane = dCreatePlane(NULL, 0, 0, 1, 7);
    for (int trial = 0; trial < 100; trial++) {
        test_tip a;
        dContactGeom c[CONTACTS], d[CONTACTS];
        double R[9], down[3] = {0, 0, -1}, x[3] = {MIDDLE[0], MIDDLE[1], MIDDLE[2]};
        test_tip_make(&random, PINCH_TIP_CONVEX, &a);
        draw_frame(&random, R);
        test_tip_place(&a, x, R);
        x[2] += draw_uniform(&random, 0.1, 0.99) * (test_tip_reach(&a, down) + MIDDLE[2]);
        test_tip_place(&a, x, R);
        int on_plane = dCollide(a.geom, plane, CONTACTS, c, sizeof *c);
        int on_mesh = dCollide(a.geom, mesh, CONTACTS, d, sizeof *d);
        assert_true(on_plane > 0 && on_mesh > 0);
        assert_close(c[deepest(c, on_plane)].depth, d[deepest(d, on_mesh)].depth, 1e-9);
        test_tip_free(&a);
    }
    dGeomDestroy(mesh);
    dGeomDestroy(plane);
    dGeomTriMeshDataDestroy(data);
}

/* An ellipsoid with equal radii is a sphere. */
static void test_round_ellipsoid(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 3);
    for (int trial = 0; trial < TRIALS; trial++) {
        test_tip a, b;
        dContactGeom c[CONTACTS];
        for (int k = 0; k < 2; k++) {
            test_tip *t = k ? &b : &a;
            memset(t, 0, sizeof *t);
            t->tip = pinch_default_tip(PINCH_TIP_ELLIPSOID);
            t->tip.size[0] = t->tip.size[1] = t->tip.size[2] = draw_log_uniform(&random, 0.3, 3);
            test_tip_make_geom(t);
        }
        place_touching(&random, &a, &b, 0.1, 1.1);
        int count = collide(&a, &b, c);
        double n[3], distance = 0;
        for (int i = 0; i < 3; i++) n[i] = a.position[i] - b.position[i];
        distance = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        double depth = a.tip.size[0] + b.tip.size[0] - distance;
        assert_int_equal(count, depth > 0);
        if (count) {
            assert_close(c[0].depth, depth, 1e-9);
            for (int i = 0; i < 3; i++) assert_close(c[0].normal[i], n[i] / distance, 1e-9);
            for (int i = 0; i < 3; i++)
                assert_close(c[0].pos[i], b.position[i] + (b.tip.size[0] - 0.5 * depth) * n[i] / distance, 1e-9);
        }
        test_tip_free(&a);
        test_tip_free(&b);
    }
}

/* ODE's sphere against its box, capsule, cylinder, plane and sphere, and a round ellipsoid in the sphere's place. */
static void test_like_odes_sphere(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 4);
    int touching = 0;
    for (int trial = 0; trial < 5 * TRIALS; trial++) {
        double r = draw_log_uniform(&random, 0.3, 2), R[9], x[3], d[3];
        pinch_tip tip = pinch_default_tip(PINCH_TIP_ELLIPSOID);
        tip.size[0] = tip.size[1] = tip.size[2] = r;
        dGeomID ball, sphere = dCreateSphere(NULL, r), other;
        assert_int_equal(pinch_create_tip(NULL, &tip, &ball), PINCH_OK);
        double p = draw_uniform(&random, 0.3, 2), q = draw_uniform(&random, 0.3, 2), s = draw_uniform(&random, 0.3, 2);
        int kind = trial % 5;
        other = kind == 0   ? dCreateSphere(NULL, p)
                : kind == 1 ? dCreateBox(NULL, p, q, s)
                : kind == 2 ? dCreateCapsule(NULL, p, q)
                : kind == 3 ? dCreateCylinder(NULL, p, q)
                            : dCreatePlane(NULL, 0.6, 0, 0.8, p - 1);
        draw_frame(&random, R);
        dMatrix3 rotation = {R[0], R[1], R[2], 0, R[3], R[4], R[5], 0, R[6], R[7], R[8], 0};
        if (kind != 4) dGeomSetRotation(other, rotation);
        draw_direction(&random, d);
        for (int i = 0; i < 3; i++) x[i] = draw_uniform(&random, 0.5, 1) * (r + 0.5 * (p + q)) * d[i];
        dGeomSetPosition(ball, x[0], x[1], x[2]);
        dGeomSetPosition(sphere, x[0], x[1], x[2]);
        dContactGeom theirs[CONTACTS], ours[CONTACTS];
        int n = dCollide(sphere, other, CONTACTS, theirs, sizeof theirs[0]);
        int m = dCollide(ball, other, CONTACTS, ours, sizeof ours[0]);
        /* a centre inside: ODE's sphere-box and sphere-cylinder take the nearest face there, too, but not the rest */
        double distance, nearest[3], normal[3];
        if (kind != 4) assert_int_equal(pinch_tip_closest_point(other, x, &distance, nearest, normal), PINCH_OK);
        if (n == 1 && theirs[0].depth > 1e-9 && (kind == 4 || distance > 1e-3)) {
            assert_int_equal(m, 1);
            touching++;
            assert_close(ours[0].depth, theirs[0].depth, 1e-9);
            for (int i = 0; i < 3; i++) assert_close(ours[0].normal[i], theirs[0].normal[i], 1e-9);
            assert_true(ours[0].g1 == ball && ours[0].g2 == other);
            int k = dCollide(other, ball, CONTACTS, ours, sizeof ours[0]);
            assert_int_equal(k, 1);
            assert_true(ours[0].g1 == other && ours[0].g2 == ball);
            for (int i = 0; i < 3; i++) assert_close(ours[0].normal[i], -theirs[0].normal[i], 1e-9);
        }
        dGeomDestroy(ball);
        dGeomDestroy(sphere);
        dGeomDestroy(other);
    }
    assert_true(touching > TRIALS);
}

static test_tip tip_of(pinch_tip_type type, double a, double b, double c, double skin)
{
    test_tip t;
    memset(&t, 0, sizeof t);
    t.tip = pinch_default_tip(type);
    t.tip.size[0] = a;
    t.tip.size[1] = b;
    t.tip.size[2] = c;
    t.tip.skin = skin;
    test_tip_make_geom(&t);
    return t;
}

static const double UPRIGHT[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, LYING[9] = {1, 0, 0, 0, 0, -1, 0, 1, 0};

/* Flat and straight parts get as many points as they need, all of the true depth, around the true middle. */
static void test_manifolds(void **state)
{
    (void)state;
    test_tip ground = tip_of(PINCH_TIP_BOX, 1, 1, 0.2, 0);
    test_tip_place(&ground, (const double[3]){0, 0, -0.1}, UPRIGHT);
    const struct {
        test_tip tip;
        const double *R;
        double height;
        int points;
    } cases[] = {
        {tip_of(PINCH_TIP_BOX, 0.1, 0.2, 0.06, 0), UPRIGHT, 0.03, 4},
        {tip_of(PINCH_TIP_BOX, 0.1, 0.2, 0.06, 0.01), UPRIGHT, 0.03, 4},
        {tip_of(PINCH_TIP_CYLINDER, 0.05, 0.2, 0, 0), UPRIGHT, 0.1, 8},
        {tip_of(PINCH_TIP_CYLINDER, 0.05, 0.2, 0, 0.01), UPRIGHT, 0.1, 8},
        {tip_of(PINCH_TIP_CYLINDER, 0.05, 0.2, 0, 0), LYING, 0.05, 2},
        {tip_of(PINCH_TIP_CAPSULE, 0.05, 0.2, 0, 0), LYING, 0.05, 2},
        {tip_of(PINCH_TIP_CAPSULE, 0.05, 0.2, 0, 0), UPRIGHT, 0.15, 1},
        {tip_of(PINCH_TIP_ELLIPSOID, 0.05, 0.2, 0.1, 0), UPRIGHT, 0.1, 1},
        {tip_of(PINCH_TIP_FLAT_CAPSULE, 0.05, 0.2, 0, 0), LYING, 0.05, 2},
    };
    double depth = 1e-4;
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        test_tip t = cases[k].tip;
        dContactGeom c[CONTACTS];
        double middle[3] = {0, 0, 0};
        test_tip_place(&t, (const double[3]){0.1, 0.05, cases[k].height - depth}, cases[k].R);
        int count = collide(&t, &ground, c);
        assert_int_equal(count, cases[k].points);
        for (int i = 0; i < count; i++) {
            assert_close(c[i].depth, depth, 1e-12);
            assert_close(c[i].normal[2], 1, 1e-12);
            assert_close(c[i].pos[2], -0.5 * depth, 1e-12);
            for (int j = 0; j < 3; j++) middle[j] += c[i].pos[j] / count;
        }
        assert_close(middle[0], 0.1, 1e-9);
        if (t.tip.type != PINCH_TIP_FLAT_CAPSULE) assert_close(middle[1], 0.05, 1e-9);
        test_tip_free(&t);
    }
    test_tip_free(&ground);
}

/* Tilted about a level axis by `tilt`, it stands with a pole on the pad, at z = 0, `overlap` deep. Where the middle of
 * the contact's points is; returns how deep they all are. */
static double press_tilted(test_tip *t, int pole, double tilt, dGeomID pad, double overlap, double *middle)
{
    double up[3][9] = {{0, 0, -1, 0, 1, 0, 1, 0, 0}, {1, 0, 0, 0, 0, -1, 0, 1, 0}, {1, 0, 0, 0, 1, 0, 0, 0, 1}}, R[9];
    dMatrix3 tilted;
    dContactGeom c[CONTACTS];
    dRFromAxisAndAngle(tilted, 0.6, 0.8, 0, tilt);
    for (int i = 0; i < 9; i++) {
        R[i] = 0;
        for (int k = 0; k < 3; k++) R[i] += tilted[4 * (i / 3) + k] * up[pole][3 * k + i % 3];
    }
    test_tip_place(t, (const double[3]){0, 0, t->tip.size[pole] - overlap}, R);
    int count = dCollide(t->geom, pad, CONTACTS, c, sizeof c[0]);
    assert_in_range(count, 1, 8);
    for (int i = 0; i < 3; i++) middle[i] = 0;
    for (int k = 0; k < count; k++) {
        assert_close(c[k].depth, c[0].depth, 1e-12);
        for (int i = 0; i < 3; i++) middle[i] += c[k].pos[i] / count;
    }
    return c[0].depth;
}

/* Where a superellipsoid is nearly flat, the point that reaches farthest runs away at the least tilt. The pressure's
 * middle goes with the tilt: to the side that is pressed in deeper, and never by a jump. */
static void test_flat_spots(void **state)
{
    (void)state;
    static const double EXPONENTS[4][2] = {{0.5, 0.5}, {0.25, 1}, {1, 0.3}, {0.7, 0.8}};
    enum { TILTS = 120 };
    const double overlap = 5e-4;
    dGeomID pads[4] = {dCreatePlane(NULL, 0, 0, 1, 0), dCreateBox(NULL, 0.02, 0.015, 0.01),
                       dCreateCylinder(NULL, 0.008, 0.01), dCreateCapsule(NULL, 0.004, 0.02)};
    dMatrix3 turned;
    dRFromAxisAndAngle(turned, 0, 0, 1, 0.4);
    for (int k = 1; k < 3; k++) {
        dGeomSetRotation(pads[k], turned);
        dGeomSetPosition(pads[k], 1e-4, 2e-4, -0.005);
    }
    dRFromAxisAndAngle(turned, 0.8, 0.6, 0, 1.5707963267948966); /* lying */
    dGeomSetRotation(pads[3], turned);
    dGeomSetPosition(pads[3], 0, 0, -0.004);
    for (int e = 0; e < 4; e++) {
        test_tip t;
        bool flat = EXPONENTS[e][0] < 1 && EXPONENTS[e][1] < 1; /* all around */
        memset(&t, 0, sizeof t);
        t.tip = pinch_default_tip(PINCH_TIP_SUPERELLIPSOID);
        for (int i = 0; i < 3; i++) t.tip.size[i] = 0.02 + 0.005 * i;
        for (int i = 0; i < 2; i++) t.tip.exponent[i] = EXPONENTS[e][i];
        test_tip_make_geom(&t);
        for (int pad = 0; pad < 4; pad++)
            for (int pole = 0; pole < 3; pole++)
                for (int sign = -1; sign < 2; sign += 2) {
                    double level[3], before[3], last = 0, m[3];
                    (void)press_tilted(&t, pole, 0, pads[pad], overlap, level);
                    memcpy(before, level, sizeof before);
                    for (int k = 0; k < TILTS; k++) {
                        double tilt = pow(10, -15 + 13.7 * k / (TILTS - 1)), moved = 0;
                        assert_true(press_tilted(&t, pole, sign * tilt, pads[pad], overlap, m) > 0.9 * overlap);
                        for (int i = 0; i < 2; i++) moved += (m[i] - before[i]) * (m[i] - before[i]);
                        assert_true(sqrt(moved) < 0.5 * (tilt - last) + 1e-11);
                        double deeper = 0.6 * (m[1] - level[1]) - 0.8 * (m[0] - level[0]);
                        if (flat && tilt > 1e-9 && tilt < 1e-3) assert_true(sign * deeper < 0);
                        last = tilt;
                        memcpy(before, m, sizeof m);
                    }
                }
        test_tip_free(&t);
    }
    for (int k = 0; k < 4; k++) dGeomDestroy(pads[k]);
}

/* Two cylinders side by side: two points on the common line. Crossed: one. */
static void test_lines(void **state)
{
    (void)state;
    static const double ACROSS[9] = {0, 0, 1, 0, 1, 0, -1, 0, 0};
    dContactGeom c[CONTACTS];
    test_tip a = tip_of(PINCH_TIP_CYLINDER, 0.05, 0.2, 0, 0), b = tip_of(PINCH_TIP_CAPSULE, 0.03, 0.1, 0, 0);
    test_tip_place(&a, (const double[3]){0, 0, 0}, UPRIGHT);
    test_tip_place(&b, (const double[3]){0.079, 0, 0.02}, UPRIGHT);
    assert_int_equal(collide(&a, &b, c), 2);
    for (int k = 0; k < 2; k++) {
        assert_close(c[k].depth, 0.001, 1e-9);
        assert_close(c[k].normal[0], -1, 1e-9);
        assert_close(c[k].pos[2], fabs(c[k].pos[2] - 0.07) < 0.01 ? 0.07 : -0.03, 1e-9);
    }
    test_tip_place(&b, (const double[3]){0, 0.079, 0.02}, ACROSS);
    assert_int_equal(collide(&a, &b, c), 1);
    assert_close(c[0].depth, 0.001, 1e-9);
    assert_close(c[0].pos[2], 0.02, 1e-9);
    test_tip_free(&a);
    test_tip_free(&b);
}

/* ODE's other classes: plane, trimesh, convex, transform, offset, ray. */
static void test_odes_classes(void **state)
{
    (void)state;
    static const double V[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    static const dTriIndex T[] = {0, 1, 2, 0, 2, 3};
    test_tip t = tip_of(PINCH_TIP_ELLIPSOID, 0.2, 0.1, 0.05, 0), box = tip_of(PINCH_TIP_BOX, 0.2, 0.1, 0.06, 0);
    dContactGeom c[CONTACTS];
    dTriMeshDataID data = dGeomTriMeshDataCreate();
    dGeomTriMeshDataBuildDouble(data, V, 3 * sizeof(double), 4, T, 6, 3 * sizeof(dTriIndex));
    dGeomID ground[2] = {dCreateTriMesh(NULL, data, NULL, NULL, NULL), dCreatePlane(NULL, 0, 0, 1, 0)};
    for (int k = 0; k < 2; k++) {
        test_tip_place(&t, (const double[3]){0.3, 0.3, 0.049}, UPRIGHT); /* over the triangles' common edge */
        assert_int_equal(dCollide(t.geom, ground[k], CONTACTS, c, sizeof c[0]), 1);
        assert_close(c[0].depth, 0.001, 1e-9);
        assert_close(c[0].normal[2], 1, 1e-9);
        assert_int_equal(dCollide(ground[k], t.geom, CONTACTS, c, sizeof c[0]), 1);
        assert_close(c[0].normal[2], -1, 1e-9);
        test_tip_place(&t, (const double[3]){0.1, 0.3, 0.049}, UPRIGHT); /* the edge's triangles see it differently */
        assert_int_equal(dCollide(t.geom, ground[k], CONTACTS, c, sizeof c[0]), 1);
        assert_close(c[0].normal[2], 1, 1e-9);
        test_tip_place(&box, (const double[3]){0.2, 0.25, 0.029}, UPRIGHT);
        int count = dCollide(box.geom, ground[k], CONTACTS, c, sizeof c[0]);
        assert_in_range(count, 4, 8);
        for (int i = 0; i < count; i++) {
            assert_close(c[i].depth, 0.001, 1e-9);
            assert_close(c[i].normal[2], 1, 1e-9);
        }
    }
    test_tip_place(&t, (const double[3]){0, 0, 0.5}, UPRIGHT);
    assert_int_equal(dCollide(t.geom, ground[0], CONTACTS, c, sizeof c[0]), 0);
    for (int k = 0; k < 2; k++) dGeomDestroy(ground[k]);
    dGeomTriMeshDataDestroy(data);

    dGeomID ray = dCreateRay(NULL, 2);
    dGeomRaySet(ray, 0, 0.05, 2, 0, 0, -1);
    assert_int_equal(dCollide(ray, t.geom, CONTACTS, c, sizeof c[0]), 1);
    assert_close(c[0].depth, 1.5 - 0.05 * sqrt(0.75), 1e-9); /* z = c sqrt(1 - (y/b)^2) */
    assert_true(c[0].normal[2] > 0 && c[0].g1 == ray);
    dGeomRaySet(ray, 0, 0, 0.5, 0, 0, -1); /* from inside */
    assert_int_equal(dCollide(t.geom, ray, CONTACTS, c, sizeof c[0]), 1);
    assert_close(c[0].depth, 0.05, 1e-9);
    dGeomRaySet(ray, 0, 0.101, 2, 0, 0, -1);
    assert_int_equal(dCollide(ray, t.geom, CONTACTS, c, sizeof c[0]), 0);
    dGeomDestroy(ray);
    test_tip_free(&box);
    test_tip_free(&t);
}

static void test_convex_and_offsets(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 5);
    dContactGeom c[CONTACTS], d[CONTACTS];
    dWorldID world = dWorldCreate();
    for (int trial = 0; trial < 200; trial++) {
        test_tip a, b;
        do {
            test_tip_make(&random, PINCH_TIP_CONVEX, &b);
            if (b.tip.skin == 0) break;
            test_tip_free(&b);
        } while (true);
        test_tip_make(&random, PINCH_TIP_ELLIPSOID, &a);
        place_touching(&random, &a, &b, 0.7, 1);
        int count = collide(&a, &b, c);
        /* ODE's convex, on a body, with an offset */
        dGeomID convex =
            dCreateConvex(NULL, b.planes, b.convex.plane_count, b.points, b.convex.point_count, b.polygons);
        dBodyID body = dBodyCreate(world);
        dGeomSetBody(convex, body);
        dBodySetPosition(body, 1, 2, 3);
        dGeomSetOffsetWorldPosition(convex, b.position[0], b.position[1], b.position[2]);
        dGeomSetOffsetWorldRotation(convex, dGeomGetRotation(b.geom));
        pinch_tip_reset_statistics();
        assert_int_equal(dCollide(a.geom, convex, CONTACTS, d, sizeof d[0]), 0);
        assert_int_equal(pinch_tip_statistics().unknown_convex, 1);
        assert_int_equal(pinch_tip_know_convex(convex, &b.convex), PINCH_OK);
        assert_int_equal(dCollide(a.geom, convex, CONTACTS, d, sizeof d[0]), count);
        for (int k = 0; k < count; k++)
            for (int i = 0; i < 3; i++) assert_close(c[k].pos[i], d[k].pos[i], 1e-9);
        assert_int_equal(pinch_tip_know_convex(convex, NULL), PINCH_OK);
        dGeomDestroy(convex);
        test_tip_free(&a);
        test_tip_free(&b);
    }
    dWorldDestroy(world);
}

/* Closest points lie on the surface, and the way there is along the normal: checked on the reference's support. */
static void test_closest_points(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 6);
    for (int trial = 0; trial < TRIALS; trial++) {
        test_tip t;
        test_tip_make(&random, (pinch_tip_type)draw_index(&random, PINCH_TIP_COUNT), &t);
        double x[3], n[3], nearest[3], distance, R[9];
        draw_frame(&random, R);
        test_tip_place(&t, (const double[3]){0.3, -0.2, 0.1}, R);
        for (int i = 0; i < 3; i++) x[i] = draw_uniform(&random, -2, 2);
        assert_int_equal(pinch_tip_closest_point(t.geom, x, &distance, nearest, n), PINCH_OK);
        double along = n[0] * x[0] + n[1] * x[1] + n[2] * x[2];
        assert_close(along - test_tip_reach(&t, n), distance, 1e-9); /* the plane at the nearest point touches */
        for (int i = 0; i < 3; i++) assert_close(nearest[i] + distance * n[i], x[i], 1e-12);
        test_tip_free(&t);
    }
}

static void test_curvatures(void **state)
{
    (void)state;
    double k[2], u[3];
    test_tip e = tip_of(PINCH_TIP_ELLIPSOID, 3, 2, 1, 0), c = tip_of(PINCH_TIP_CYLINDER, 2, 3, 0, 0.5);
    test_tip b = tip_of(PINCH_TIP_BOX, 2, 2, 2, 0.25);
    assert_int_equal(pinch_tip_curvature(e.geom, (const double[3]){0, 0, 1}, k, u), PINCH_OK);
    assert_close(k[0], 1.0 / 9, 1e-12); /* c/a^2 along x, c/b^2 along y */
    assert_close(k[1], 1.0 / 4, 1e-12);
    assert_close(fabs(u[0]), 1, 1e-12);
    assert_int_equal(pinch_tip_curvature(c.geom, (const double[3]){1, 0, 0}, k, u), PINCH_OK);
    assert_close(k[0], 0, 0);
    assert_close(k[1], 0.5, 1e-12);
    assert_close(fabs(u[2]), 1, 1e-12);
    assert_int_equal(pinch_tip_curvature(c.geom, (const double[3]){0, 0, -1}, k, u), PINCH_OK);
    assert_close(k[1], 0, 0);
    assert_int_equal(pinch_tip_curvature(b.geom, (const double[3]){0.6, 0.8, 0}, k, u), PINCH_OK);
    assert_close(k[0], 0, 0);
    assert_close(k[1], 4, 1e-9);
    test_tip_free(&e);
    test_tip_free(&c);
    test_tip_free(&b);
}

/* Volume and inertia by the divergence theorem on a fine grid of normals would need the surface; counting points inside
 * needs only the distance. */
static void test_inertia(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 7);
    for (int type = 0; type < PINCH_TIP_COUNT; type++) {
        test_tip t;
        do {
            test_tip_make(&random, (pinch_tip_type)type, &t);
            if (type != PINCH_TIP_CONVEX || t.tip.skin == 0) break;
            test_tip_free(&t);
        } while (true);
        double volume, inertia[9], sum[4] = {0, 0, 0, 0};
        dReal box[6];
        assert_int_equal(pinch_tip_inertia(&t.tip, &volume, inertia), PINCH_OK);
        dGeomGetAABB(t.geom, box);
        double whole = (box[1] - box[0]) * (box[3] - box[2]) * (box[5] - box[4]);
        enum { N = 16 };
        for (int k = 0; k < N * N * N; k++) {
            int cell[3] = {k % N, k / N % N, k / (N * N)};
            double x[3], n[3], nearest[3], distance;
            for (int i = 0; i < 3; i++) x[i] = box[2 * i] + (cell[i] + 0.5) / N * (box[2 * i + 1] - box[2 * i]);
            assert_int_equal(pinch_tip_closest_point(t.geom, x, &distance, nearest, n), PINCH_OK);
            if (distance > 0) continue;
            sum[3] += whole / (N * N * N);
            for (int i = 0; i < 3; i++) sum[i] += whole / (N * N * N) * x[i] * x[i];
        }
        assert_close(sum[3] / volume, 1, 0.06); /* the grid's accuracy */
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            assert_close((sum[j] + sum[k]) / (volume * inertia[4 * i]), 1, 0.1);
        }
        test_tip_free(&t);
    }
}

/* ODE's own classes, taken over: capsule beside cylinder, axes parallel, is a line. It lasts: the last of the tests. */
static void test_taken_over(void **state)
{
    (void)state;
    dGeomID capsule = dCreateCapsule(NULL, 0.03, 0.1), cylinder = dCreateCylinder(NULL, 0.05, 0.2);
    dContactGeom c[CONTACTS];
    dGeomSetPosition(capsule, 0.079, 0, 0.02);
    assert_int_equal(pinch_tip_take_over(dCapsuleClass, dCylinderClass), PINCH_OK);
    for (int swapped = 0; swapped < 2; swapped++) {
        dGeomID first = swapped ? cylinder : capsule, second = swapped ? capsule : cylinder;
        assert_int_equal(dCollide(first, second, CONTACTS, c, sizeof c[0]), 2);
        for (int k = 0; k < 2; k++) {
            assert_true(c[k].g1 == first && c[k].g2 == second);
            assert_close(c[k].depth, 0.001, 1e-9);
            assert_close(c[k].normal[0], swapped ? -1 : 1, 1e-9);
        }
    }
    dGeomDestroy(capsule);
    dGeomDestroy(cylinder);
}

static void test_refusals(void **state)
{
    (void)state;
    dGeomID geom;
    pinch_tip tip = pinch_default_tip(PINCH_TIP_BOX);
    assert_int_equal(pinch_create_tip(NULL, &tip, &geom), PINCH_INVALID_ARGUMENT);
    for (int i = 0; i < 3; i++) tip.size[i] = 1;
    tip.skin = 0.5;
    assert_int_equal(pinch_create_tip(NULL, &tip, &geom), PINCH_INVALID_ARGUMENT);
    tip.skin = NAN;
    assert_int_equal(pinch_create_tip(NULL, &tip, &geom), PINCH_INVALID_ARGUMENT);
    tip = pinch_default_tip(PINCH_TIP_CONVEX);
    assert_int_equal(pinch_create_tip(NULL, &tip, &geom), PINCH_INVALID_ARGUMENT);
    static const double POINTS[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const double S = 0.57735026918962576;
    static const double PLANES[16] = {-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, S, S, S, S};
    static const unsigned POLYGONS[16] = {3, 0, 3, 2, 3, 0, 1, 3, 3, 0, 2, 1, 3, 1, 2, 3};
    static const unsigned BEYOND[16] = {3, 0, 3, 2, 3, 0, 1, 3, 3, 0, 2, 1, 3, 1, 2, 4};
    pinch_convex corner = {PLANES, 4, POINTS, POLYGONS, 4};
    tip.pieces = &corner;
    tip.piece_count = 1;
    assert_int_equal(pinch_create_tip(NULL, &tip, &geom), PINCH_OK);
    dGeomDestroy(geom);
    corner.polygons = BEYOND; /* names a point that there is not */
    assert_int_equal(pinch_create_tip(NULL, &tip, &geom), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_create_tip(NULL, NULL, &geom), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_tip_take_over(dRayClass, dSphereClass), PINCH_INVALID_ARGUMENT);
}

int main(void)
{
    dInitODE2(0);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_swapped_is_mirrored),
        cmocka_unit_test(test_moved_together),
        cmocka_unit_test(test_origin_outside),
        cmocka_unit_test(test_mesh_far_from_its_origin),
        cmocka_unit_test(test_round_ellipsoid),
        cmocka_unit_test(test_like_odes_sphere),
        cmocka_unit_test(test_manifolds),
        cmocka_unit_test(test_flat_spots),
        cmocka_unit_test(test_lines),
        cmocka_unit_test(test_odes_classes),
        cmocka_unit_test(test_convex_and_offsets),
        cmocka_unit_test(test_closest_points),
        cmocka_unit_test(test_curvatures),
        cmocka_unit_test(test_inertia),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_taken_over),
    };
    int failed = cmocka_run_group_tests_name("tip rules", tests, NULL, NULL);
    dCloseODE();
    pinch_close_tips();
    return failed;
}
