/*
 * The persistent manifold meets colliders that flicker and points that come, go and merge. The shear must survive all
 * of it.
 */
#include "support/cmocka_all.h"

#include "contacts/manifold.h"
#include "support/draw.h"

#include <float.h>
#include <string.h>

static const double MERGE = 1e-3, TILT = 0.05;

typedef struct placed {
    double position[3], rotation[12];
} placed;

static placed placed_at(double x, double y, double z)
{
    placed p = {{x, y, z}, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
    return p;
}

static void turn(placed *p, int axis, double angle)
{
    int i = (axis + 1) % 3, j = (axis + 2) % 3;
    memset(p->rotation, 0, sizeof p->rotation);
    p->rotation[5 * axis] = 1;
    p->rotation[5 * i] = p->rotation[5 * j] = cos(angle);
    p->rotation[4 * i + j] = -sin(angle);
    p->rotation[4 * j + i] = sin(angle);
}

static pinch_detected_point fresh_at(double x, double y, double depth)
{
    pinch_detected_point f = {.position = {x, y, 0}, .normal = {0, 0, 1}, .depth = depth, .buffered = -1, .point = -1};
    return f;
}

static void update_all(pinch_manifold *m, const placed *a, const placed *b, pinch_detected_point *pool, int count,
                       double steady, double quiet, bool shared)
{
    pinch_pose pose[2] = {{a->position, a->rotation}, {b->position, b->rotation}};
    pinch_manifold_rules rules = {.merge_distance = MERGE,
                                  .steady_distance = steady,
                                  .quiet_distance = quiet,
                                  .stale_tilt = TILT,
                                  .shared = shared,
                                  .most_points = PINCH_SHARED_POINTS};
    pinch_manifold_update(m, pose, pool, count, &rules);
}

static void update_with(pinch_manifold *m, const placed *a, const placed *b, pinch_detected_point *pool, int count)
{
    update_all(m, a, b, pool, count, 0, 0, true);
}

static const pinch_manifold_point *point_near(const pinch_manifold *m, double x, double y)
{
    for (int k = 0; k < m->count; k++)
        if (hypot(m->point[k].position[0] - x, m->point[k].position[1] - y) < MERGE) return &m->point[k];
    return NULL;
}

/* Mean shear, and moment of the shear about a fixed origin and z; the mean twist. Equal stiffness shares: what the
 * pair's resultant force and moment are proportional to. */
static void resultant(const pinch_manifold *m, double out[4])
{
    memset(out, 0, 4 * sizeof *out);
    for (int k = 0; k < m->count; k++) {
        const pinch_manifold_point *p = &m->point[k];
        out[0] += p->elastic[0] / m->count;
        out[1] += p->elastic[1] / m->count;
        out[2] += (p->position[0] * p->elastic[1] - p->position[1] * p->elastic[0]) / m->count;
        out[3] += p->twist / m->count;
    }
}

/* ODE's capsule-box collider returns one point, at alternating ends. */
static void test_flickering_collider_keeps_both_ends(void **state)
{
    (void)state;
    pinch_manifold_point points[PINCH_MANIFOLD_POINTS];
    pinch_manifold m = {0, points};
    placed a = placed_at(0, 0, 0.01), b = placed_at(0, 0, -0.01);
    for (int step = 0; step < 50; step++) {
        pinch_detected_point pool[1] = {fresh_at(step % 2 ? 0.02 : -0.02, 0, 1e-4)};
        update_with(&m, &a, &b, pool, 1);
        if (step == 1) {
            m.point[0].elastic[0] = m.point[1].elastic[0] = 1e-5;
            m.point[0].twist = m.point[1].twist = 1e-3;
        }
        assert_int_equal(m.count, step == 0 ? 1 : 2);
    }
    for (int k = 0; k < 2; k++) {
        assert_close(m.point[k].elastic[0], 1e-5, 1e-18);
        assert_close(m.point[k].twist, 1e-3, 1e-15);
        assert_close(m.point[k].depth, 1e-4, 1e-15); /* from anchors about 0.02 m away: 0.02 eps */
    }
    assert_non_null(point_near(&m, -0.02, 0));
    assert_non_null(point_near(&m, 0.02, 0));
}

static void test_merge_within_the_distance_only(void **state)
{
    (void)state;
    pinch_manifold_point points[PINCH_MANIFOLD_POINTS];
    pinch_manifold m = {0, points};
    placed a = placed_at(0, 0, 0.01), b = placed_at(0, 0, -0.01);
    pinch_detected_point first[1] = {fresh_at(0, 0, 1e-4)}, near[1] = {fresh_at(0.9 * MERGE, 0, 2e-4)},
                         far[1] = {fresh_at(-3 * MERGE, 0, 1e-4)};
    update_with(&m, &a, &b, first, 1);
    m.point[0].elastic[1] = 3e-6;
    update_with(&m, &a, &b, near, 1);
    assert_int_equal(m.count, 1);
    assert_close(m.point[0].position[0], 0.9 * MERGE, 0); /* it takes the fresh geometry */
    assert_close(m.point[0].depth, 2e-4, 0);
    assert_close(m.point[0].elastic[1], 3e-6, 1e-20); /* and goes on with its state */
    update_with(&m, &a, &b, far, 1);
    assert_int_equal(m.count, 2);
}

/* What the collider does not return goes when it separates, drifts sideways or tilts away. */
static void test_stale_points_go(void **state)
{
    (void)state;
    struct {
        double up, aside, tilt;
        int stay;
    } cases[] = {
        {0, 0, 0, 1},           {5e-5, 0, 0, 1},        {1.5e-4, 0, 0, 0}, /* depth 1e-4: half of it, all of it */
        {0, 0.9 * MERGE, 0, 1}, {0, 1.1 * MERGE, 0, 0}, {0, 0, 0.9 * TILT, 1}, {0, 0, 1.1 * TILT, 0},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        pinch_manifold_point points[PINCH_MANIFOLD_POINTS];
        pinch_manifold m = {0, points};
        placed a = placed_at(0, 0, 0), b = placed_at(0, 0, -0.01); /* a turns about the point itself */
        pinch_detected_point pool[2] = {fresh_at(0, 0, 1e-4), fresh_at(0.02, 0, 1e-4)};
        update_with(&m, &a, &b, pool, 2);
        a.position[2] += cases[i].up;
        a.position[0] += cases[i].aside;
        turn(&a, 0, cases[i].tilt);
        /* the collider returns the second point only, where it is now on a */
        pinch_detected_point now[1] = {fresh_at(0.02 + cases[i].aside, 0, 1e-4 - cases[i].up)};
        update_with(&m, &a, &b, now, 1);
        assert_int_equal(m.count, 1 + cases[i].stay);
        if (cases[i].stay) assert_close(point_near(&m, cases[i].aside, 0)->depth, 1e-4 - cases[i].up, 1e-7);
    }
}

static void test_no_fresh_points_at_all(void **state)
{
    (void)state;
    pinch_manifold_point points[PINCH_MANIFOLD_POINTS];
    pinch_manifold m = {0, points};
    placed a = placed_at(0, 0, 0.01), b = placed_at(0, 0, -0.01);
    pinch_detected_point pool[1] = {fresh_at(0, 0, 1e-4)};
    update_with(&m, &a, &b, pool, 1);
    update_with(&m, &a, &b, NULL, 0);
    assert_int_equal(m.count, 1);
    a.position[2] += 1;
    update_with(&m, &a, &b, NULL, 0);
    assert_int_equal(m.count, 0);
}

/* Returns by how much a place lies outside of the convex hull of a manifold's points: the largest, over all directions,
 * of how far it is in front of all of them. */
static double outside_of_hull(const pinch_manifold *m, double x, double y)
{
    enum { DIRECTIONS = 720 };
    double outside = 0;
    for (int i = 0; i < DIRECTIONS; i++) {
        double angle = 2 * acos(-1) * i / DIRECTIONS, c = cos(angle), s = sin(angle), front = -DBL_MAX;
        for (int k = 0; k < m->count; k++)
            front = fmax(front, c * m->point[k].position[0] + s * m->point[k].position[1]);
        outside = fmax(outside, c * x + s * y - front);
    }
    return outside;
}

/*
 * More points than the manifold holds: the deepest stays, and those that span the patch. Of a circle with infinitely
 * many points a heptagon (the eighth point may be the deepest) cuts off 1 - cos(pi/7) = 0.1 of the radius, which is
 * sqrt(2) of half the width here. The points are chosen one by one, which cuts off a little more than the best choice.
 */
static const double CUT_OFF = 0.16;

static void test_many_fresh_points(void **state)
{
    enum { MANY = 300 };
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 3);
    for (int trial = 0; trial < 100; trial++) {
        pinch_manifold_point points[PINCH_MANIFOLD_POINTS];
        pinch_manifold m = {0, points};
        placed a = placed_at(0, 0, 0.01), b = placed_at(0, 0, -0.01);
        pinch_detected_point pool[MANY];
        int count = 9 + draw_index(&random, MANY - 8), deepest = 0;
        double width = trial % 2 ? 0.05 : 0.001; /* a patch as wide as it is long, and a narrow one */
        for (int i = 0; i < count; i++) {
            double depth = draw_uniform(&random, 1e-5, 1e-3), y = draw_uniform(&random, -width, width);
            pool[i] = fresh_at(draw_uniform(&random, -0.05, 0.05), y, depth);
            if (pool[i].depth > pool[deepest].depth) deepest = i;
        }
        double depth = pool[deepest].depth;
        update_with(&m, &a, &b, pool, count);
        assert_in_range(m.count, 3, PINCH_MANIFOLD_POINTS);
        bool found = false;
        for (int k = 0; k < m.count; k++) found = found || m.point[k].depth >= depth * (1 - 1e-3);
        assert_true(found);
        for (int i = 0; i < count; i++) {
            double x = pool[i].position[0], y = pool[i].position[1];
            assert_true(outside_of_hull(&m, x, y) < CUT_OFF * 0.05);
            for (int k = 0; k < m.count; k++) m.point[k].position[1] *= 0.05 / width;
            assert_true(outside_of_hull(&m, x, y * 0.05 / width) < CUT_OFF * 0.05); /* across, in units of the width */
            for (int k = 0; k < m.count; k++) m.point[k].position[1] *= width / 0.05;
        }
    }
}

static int place_of(const pinch_manifold *m, double x, double y)
{
    int places = 0;
    for (int k = 0; k < m->count; k++)
        places += hypot(m->point[k].position[0] - x, m->point[k].position[1] - y) < 1e-12;
    return places;
}

/* A face of many equally deep points, in any order and turned by any angle: its corners stay, and the choice is the
 * same for each order. */
static void test_corners_of_a_face(void **state)
{
    enum { ROWS = 18, COUNT = ROWS * ROWS };
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 5);
    for (int trial = 0; trial < 50; trial++) {
        pinch_manifold_point points[2][PINCH_MANIFOLD_POINTS];
        pinch_manifold m[2] = {{0, points[0]}, {0, points[1]}};
        placed a = placed_at(0, 0, 0.01), b = placed_at(0, 0, -0.01);
        pinch_detected_point pool[COUNT];
        double angle = draw_uniform(&random, 0, 7), c = cos(angle), s = sin(angle);
        double width = trial % 3 ? 0.05 : 0.0005;
        for (int i = 0; i < COUNT; i++) {
            double x = 0.05 * (2.0 * (i % ROWS) / (ROWS - 1) - 1), y = width * (2.0 * (i / ROWS) / (ROWS - 1) - 1);
            pool[i] = fresh_at(c * x - s * y, s * x + c * y, 1e-4 * (1 + 1e-12 * draw_uniform(&random, -1, 1)));
        }
        for (int order = 0; order < 2; order++) {
            for (int i = COUNT - 1; i > 0; i--) {
                int k = draw_index(&random, i + 1);
                pinch_detected_point other = pool[k];
                pool[k] = pool[i];
                pool[i] = other;
            }
            update_all(&m[order], &a, &b, pool, COUNT, 0, 0, false);
            for (int i = 0; i < 4; i++) {
                double x = i % 2 ? 0.05 : -0.05, y = i / 2 ? width : -width;
                assert_int_equal(place_of(&m[order], c * x - s * y, s * x + c * y), 1);
            }
        }
        assert_int_equal(m[0].count, m[1].count);
        for (int k = 0; k < m[0].count; k++)
            assert_int_equal(place_of(&m[1], m[0].point[k].position[0], m[0].point[k].position[1]), 1);
    }
}

/* Points on a floor and on a wall: both faces keep theirs. */
static void test_floor_and_wall(void **state)
{
    enum { EACH = 100 };
    (void)state;
    pinch_manifold_point points[PINCH_MANIFOLD_POINTS];
    pinch_manifold m = {0, points};
    placed a = placed_at(0, 0, 0.01), b = placed_at(0, 0, -0.01);
    pinch_detected_point pool[2 * EACH];
    for (int i = 0; i < EACH; i++) {
        pool[2 * i] = fresh_at(0.01 * (i % 10), 0.01 * (i / 10), 1e-4);
        pool[2 * i + 1] = fresh_at(0, 0.01 * (i / 10), 1e-4);
        pool[2 * i + 1].position[2] = 0.01 * (i % 10);
        pool[2 * i + 1].normal[0] = 1, pool[2 * i + 1].normal[2] = 0;
    }
    update_all(&m, &a, &b, pool, 2 * EACH, 0, 0, false);
    int on_wall = 0;
    for (int k = 0; k < m.count; k++) on_wall += m.point[k].normal[0] > 0.5;
    assert_int_equal(m.count, 8);
    assert_int_equal(on_wall, 4);
}

/*
 * Points come, go and flicker in a plane patch: the mean shear (the resultant force over the stiffness), the moment of
 * the shear and the mean twist stay what they were. Least-squares arithmetic on shears of 1e-5 m: 1e-18 m.
 */
static void test_resultant_survives(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 4);
    int changes = 0;
    for (int trial = 0; trial < 200; trial++) {
        pinch_manifold_point points[PINCH_MANIFOLD_POINTS];
        pinch_manifold m = {0, points};
        placed a = placed_at(0, 0, 0.01), b = placed_at(0, 0, -0.01);
        double grid[6][2];
        for (int i = 0; i < 6; i++) {
            grid[i][0] = 0.01 * (i % 3) + draw_uniform(&random, -1e-3, 1e-3);
            grid[i][1] = 0.01 * (i / 3) + draw_uniform(&random, -1e-3, 1e-3);
        }
        pinch_detected_point pool[6];
        for (int i = 0; i < 3; i++) pool[i] = fresh_at(grid[i == 2 ? 4 : i][0], grid[i == 2 ? 4 : i][1], 1e-4);
        update_with(&m, &a, &b, pool, 3);
        for (int k = 0; k < m.count; k++) {
            for (int i = 0; i < 2; i++) m.point[k].elastic[i] = draw_uniform(&random, -1e-5, 1e-5);
            m.point[k].twist = draw_uniform(&random, -1e-3, 1e-3);
        }
        double before[4], after[4];
        resultant(&m, before);
        for (int step = 0; step < 10; step++) {
            int count = 0, was = m.count;
            /* now and then every point not returned is lifted off and set down again, so that it goes */
            bool lift = draw_chance(&random, 0.5);
            bool keep[6];
            int kept = 0;
            for (int i = 0; i < 6; i++) kept += keep[i] = draw_chance(&random, 0.6);
            if (kept < 2) continue; /* a single point cannot carry a moment */
            for (int i = 0; i < 6; i++)
                if (keep[i]) pool[count++] = fresh_at(grid[i][0], grid[i][1], lift ? -1e-6 : 1e-4);
            if (lift) a.position[2] += 1.01e-4;
            update_with(&m, &a, &b, pool, count);
            if (lift) {
                a.position[2] -= 1.01e-4;
                assert_int_equal(m.count, kept);
            }
            changes += m.count != was;
            resultant(&m, after);
            assert_close(after[0], before[0], 1e-18);
            assert_close(after[1], before[1], 1e-18);
            assert_close(after[2], before[2], 1e-19);
            assert_close(after[3], before[3], 1e-16);
        }
    }
    assert_true(changes > 500);
}

/* A pair taken the other way round has the mirrored state: same points, opposite normals and shears. */
static void test_swapped_order_mirrors(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 8);
    for (int trial = 0; trial < 100; trial++) {
        pinch_manifold_point points[2][PINCH_MANIFOLD_POINTS];
        pinch_manifold m = {0, points[0]}, mirrored = {0, points[1]};
        placed a = placed_at(0, 0, 0.01), b = placed_at(0, 0, -0.01);
        for (int step = 0; step < 8; step++) {
            pinch_detected_point pool[5], flipped[5];
            int count = 1 + draw_index(&random, 5);
            for (int i = 0; i < count; i++) {
                double y = 0.01 * draw_index(&random, 2);
                pool[i] = fresh_at(0.01 * draw_index(&random, 3), y, 1e-4);
                flipped[i] = pool[i];
                flipped[i].normal[2] = -1;
            }
            update_with(&m, &a, &b, pool, count);
            update_with(&mirrored, &b, &a, flipped, count);
            assert_int_equal(m.count, mirrored.count);
            for (int k = 0; k < m.count; k++) {
                const pinch_manifold_point *p = &m.point[k], *q = &mirrored.point[k];
                for (int i = 0; i < 3; i++) {
                    assert_close(q->position[i], p->position[i], 1e-17);
                    assert_close(q->normal[i], -p->normal[i], 1e-16);
                    assert_close(q->elastic[i], -p->elastic[i], 1e-18);
                }
                assert_close(q->depth, p->depth, 1e-17);
                assert_close(q->twist, p->twist, 1e-16);
            }
            if (step > 0) continue;
            for (int k = 0; k < m.count; k++) {
                m.point[k].elastic[0] = draw_uniform(&random, -1e-5, 1e-5);
                m.point[k].elastic[1] = draw_uniform(&random, -1e-5, 1e-5);
                m.point[k].twist = mirrored.point[k].twist = draw_uniform(&random, -1e-3, 1e-3);
                for (int i = 0; i < 3; i++) mirrored.point[k].elastic[i] = -m.point[k].elastic[i];
            }
        }
    }
}

/* The bodies turn together: shear and normal of a point that the collider returns turn with them. */
static void test_shear_follows_the_normal(void **state)
{
    (void)state;
    pinch_manifold_point points[PINCH_MANIFOLD_POINTS];
    pinch_manifold m = {0, points};
    placed a = placed_at(0, 0, 0), b = placed_at(0, 0, 0);
    pinch_detected_point pool[1] = {fresh_at(0, 0, 1e-4)};
    update_with(&m, &a, &b, pool, 1);
    m.point[0].elastic[0] = 3e-6;
    m.point[0].elastic[1] = 4e-6;
    turn(&a, 0, 0.3);
    turn(&b, 0, 0.3);
    pool[0].normal[1] = -sin(0.3);
    pool[0].normal[2] = cos(0.3);
    update_with(&m, &a, &b, pool, 1);
    assert_close(m.point[0].elastic[0], 3e-6, 1e-20);
    assert_close(m.point[0].elastic[1], 4e-6 * cos(0.3), 1e-20);
    assert_close(m.point[0].elastic[2], 4e-6 * sin(0.3), 1e-20);
}

/* A collider whose points wander on bodies that lie still, as the crossings of almost parallel edges do. */
static void points_of_bodies_at_rest_stay(void **state)
{
    (void)state;
    const double steady = 1e-12;
    pinch_manifold_point points[PINCH_MANIFOLD_POINTS];
    pinch_manifold m = {0, points};
    placed a = placed_at(0, 0, 0.1), b = placed_at(0, 0, -0.1);
    pinch_detected_point pool[2] = {fresh_at(0.02, 0, 1e-5), fresh_at(-0.02, 0, 1e-5)};
    update_all(&m, &a, &b, pool, 2, steady, 0, false);
    assert_int_equal(m.count, 2);
    for (int step = 1; step <= 50; step++) {
        for (int i = 0; i < 2; i++) pool[i] = fresh_at((i ? -0.02 : 0.02) + 4e-6 * step, 0, 1e-5 + 1e-10 * sin(step));
        update_all(&m, &a, &b, pool, 2, steady, 0, false);
        assert_int_equal(m.count, 2);
        for (int i = 0; i < 2; i++) {
            assert_true(fabs(fabs(m.point[i].position[0]) - 0.02) < 1e-14);
            assert_true(fabs(m.point[i].depth - 1e-5) < 1e-14);
        }
    }
    /* a body that moves takes its points along, and they go where the collider finds them */
    a.position[0] += 1e-9;
    update_all(&m, &a, &b, pool, 2, steady, 0, false);
    for (int i = 0; i < 2; i++) assert_true(point_near(&m, pool[i].position[0], 0) != NULL);
    assert_true(fabs(m.point[0].position[0] - pool[0].position[0]) < 1e-14);
    /* a depth that is another's is another point's */
    pool[0].depth += 1e-6;
    update_all(&m, &a, &b, pool, 2, steady, 0, false);
    assert_true(fabs(m.point[0].depth - pool[0].depth) < 1e-14);
}

/* Between bodies that hardly move a collider's new points count only where they reach beyond the known ones. */
static void points_between_others_do_not_flicker(void **state)
{
    (void)state;
    const double quiet = 1e-7, far = 0.02;
    pinch_manifold_point points[PINCH_MANIFOLD_POINTS];
    pinch_manifold m = {0, points};
    placed a = placed_at(0, 0, 0.1), b = placed_at(0, 0, -0.1);
    const double corners[4][2] = {{far, far}, {-far, far}, {-far, -far}, {far, -far}};
    pinch_detected_point pool[6];
    for (int i = 0; i < 3; i++) pool[i] = fresh_at(corners[i][0], corners[i][1], 1e-5);
    update_all(&m, &a, &b, pool, 3, 0, quiet, false);
    assert_int_equal(m.count, 3);
    /* the fourth corner reaches beyond the three, the middle of an edge and of the face do not */
    for (int step = 0; step < 4; step++) {
        for (int i = 0; i < 4; i++) pool[i] = fresh_at(corners[i][0], corners[i][1], 1e-5);
        pool[4] = fresh_at(0, far, 1e-5);
        pool[5] = fresh_at(0, 0, 1e-5);
        a.position[0] += 0.5 * quiet;
        update_all(&m, &a, &b, pool, step % 2 ? 4 : 6, 0, quiet, false);
        assert_int_equal(m.count, 4);
        assert_non_null(point_near(&m, corners[3][0], corners[3][1]));
        for (int i = 0; i < 6 && step % 2 == 0; i++) assert_int_equal(pool[i].point >= 0, i < 4);
    }
    /* in the corner of a room the wall's point is none of the floor's */
    pool[4] = fresh_at(0, 0, 1e-5);
    pool[4].normal[0] = 1;
    pool[4].normal[2] = 0;
    update_all(&m, &a, &b, pool, 5, 0, quiet, false);
    assert_int_equal(m.count, 5);
    /* bodies that move get all points */
    for (int i = 0; i < 4; i++) pool[i] = fresh_at(corners[i][0], corners[i][1], 1e-5);
    pool[4] = fresh_at(0, far, 1e-5);
    a.position[0] += 2 * quiet;
    update_all(&m, &a, &b, pool, 5, 0, quiet, false);
    assert_non_null(point_near(&m, 0, far));
}

/* Points with stiffness of their own that come together and go apart: one comes or goes at different distances. */
static void twins_do_not_flicker(void **state)
{
    (void)state;
    const double limit = 0.02 * MERGE;
    pinch_manifold_point points[PINCH_MANIFOLD_POINTS];
    pinch_manifold m = {0, points};
    placed a = placed_at(0, 0, 0.1), b = placed_at(0, 0, -0.1);
    const double apart[] = {1.1, 0.95, 1.05, 0.8, 0.6, 0.45, 0.6, 0.9, 0.99, 1.01, 0.95};
    const int expected[] = {2, 2, 2, 2, 2, 1, 1, 1, 1, 2, 2};
    for (int step = 0; step < 11; step++) {
        pinch_detected_point pool[2] = {fresh_at(0, 0, 1e-5), fresh_at(apart[step] * limit, 0, 1e-5)};
        update_all(&m, &a, &b, pool, 2, 0, 0, false);
        assert_int_equal(m.count, expected[step]);
    }
}

/* Bodies that overlap by more than the merge distance, and a collider that puts the points on either surface, half way
 * between them, or each elsewhere: they are the known ones. Farther along the normal, or across it, they are not. */
static void points_go_on_on_either_surface(void **state)
{
    (void)state;
    const double depth = 2 * MERGE;
    const double up[] = {0.5, -0.5, 0.5, 0, -0.5, 0.5}; /* in depths */
    pinch_manifold_point points[2 * PINCH_MANIFOLD_POINTS];
    pinch_manifold m = {0, points};
    placed a = placed_at(0, 0, 0.1), b = placed_at(0, 0, -0.1);
    pinch_detected_point pool[2];
    for (int step = 0; step < 6; step++) {
        for (int i = 0; i < 2; i++) {
            pool[i] = fresh_at(i ? -0.02 : 0.02, 0, (1 + 0.02 * step) * depth);
            pool[i].position[2] = (step == 4 && i ? -up[step] : up[step]) * pool[i].depth;
        }
        update_all(&m, &a, &b, pool, 2, 0, 0, false);
        assert_int_equal(m.count, 2);
        for (int i = 0; i < 2 && step == 0; i++) m.point[i].elastic[1] = i ? 2e-6 : 1e-6;
        for (int i = 0; i < 2; i++) assert_close(m.point[pool[i].point].elastic[1], i ? 2e-6 : 1e-6, 1e-20);
    }
    pool[0].position[2] += 2.1 * depth;
    pool[1].position[0] += 1.1 * MERGE;
    update_all(&m, &a, &b, pool, 2, 0, 0, false);
    for (int i = 0; i < 2; i++) assert_close(m.point[pool[i].point].elastic[1], 0, 0);
}

/* Two contacts of one pair, one above the other by less than they are deep, as at a thin shelf: each is its own, in
 * either order and when they have moved. */
static void points_above_each_other_stay_apart(void **state)
{
    (void)state;
    const double depth = 4 * MERGE;
    pinch_manifold_point points[PINCH_MANIFOLD_POINTS];
    pinch_manifold m = {0, points};
    placed a = placed_at(0, 0, 0.1), b = placed_at(0, 0, -0.1);
    for (int step = 0; step < 6; step++) {
        pinch_detected_point pool[2] = {fresh_at(0, 0, depth), fresh_at(0, 0, depth)};
        int upper = step % 2;
        pool[upper].position[2] = 2 * MERGE;
        for (int i = 0; i < 2; i++) pool[i].position[2] += 0.1 * MERGE * step;
        update_all(&m, &a, &b, pool, 2, 0, 0, false);
        assert_int_equal(m.count, 2);
        for (int i = 0; i < 2 && step == 0; i++) m.point[pool[i].point].elastic[0] = i == upper ? 2e-6 : 1e-6;
        for (int i = 0; i < 2; i++) assert_close(m.point[pool[i].point].elastic[0], i == upper ? 2e-6 : 1e-6, 1e-20);
    }
}

/* A mesh's corners pressed into a face by `depth`: on each a deep point, another where its edge goes through the face,
 * a little farther out, and a third where an edge of the side does. They come in any order. */
static int pressed_corners(pinch_random *random, double depth, pinch_detected_point *pool)
{
    const double half = 0.02;
    int count = 0;
    for (int corner = 0; corner < 4; corner++) {
        double x = corner % 2 ? half : -half, y = corner / 2 ? half : -half,
               out = 1 + 1e-3 * draw_uniform(random, -1, 1);
        double deep = depth * (1 + 0.2 * draw_uniform(random, -1, 1)), rounding = 1e-18 * draw_index(random, 3);
        pool[count] = fresh_at(x, y, deep);
        pool[count++].position[2] = 0.5 * depth;
        pool[count++] = fresh_at(out * x, out * y, rounding - 1e-18);
        pool[count++] = fresh_at(x, y - (y > 0 ? 1.5 : -1.5) * depth, rounding - 1e-18);
    }
    for (int i = count - 1; i > 0; i--) {
        int k = draw_index(random, i + 1);
        pinch_detected_point other = pool[k];
        pool[k] = pool[i];
        pool[i] = other;
    }
    return count;
}

/* Points where surfaces only cross neither hide the corners beside them nor count with them. */
static void rims_do_not_hide_corners(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 6);
    for (int shared = 0; shared < 2; shared++) {
        pinch_manifold_point points[2 * PINCH_MANIFOLD_POINTS];
        pinch_manifold m = {0, points};
        placed a = placed_at(0, 0, 0.1), b = placed_at(0, 0, -0.1);
        for (int step = 0; step < 100; step++) {
            pinch_detected_point pool[12];
            int count = pressed_corners(&random, 0.9 * MERGE, pool), left_out = 0;
            update_all(&m, &a, &b, pool, count, 0, 0, shared);
            assert_int_equal(m.count, 4);
            for (int k = 0; k < 4 && step == 0; k++) m.point[k].elastic[0] = 1e-6;
            for (int k = 0; k < 4; k++) assert_close(m.point[k].elastic[0], 1e-6, 1e-20);
            for (int i = 0; i < count; i++) {
                assert_int_equal(pool[i].redundant, pool[i].depth < 1e-9);
                assert_int_equal(pool[i].point < 0, pool[i].redundant);
                left_out += pool[i].redundant;
            }
            assert_int_equal(left_out, 8);
        }
    }
}

/* A body that lies on a row of points, and on one end of it by rounding only: it does not lose the other end. */
static void corners_that_only_touch_stay(void **state)
{
    enum { COUNT = 12 };
    (void)state;
    pinch_manifold_point points[2 * PINCH_MANIFOLD_POINTS];
    pinch_manifold m = {0, points};
    placed a = placed_at(0, 0, 0.1), b = placed_at(0, 0, -0.1);
    pinch_detected_point pool[COUNT];
    for (int i = 0; i < COUNT; i++) pool[i] = fresh_at(i < COUNT / 2 ? -0.02 : 0.02, 0.004 * (i % (COUNT / 2)), 0);
    for (int i = 0; i < COUNT / 2; i++) pool[i].depth = 1e-5;
    update_all(&m, &a, &b, pool, COUNT, 0, 0, false);
    assert_non_null(point_near(&m, 0.02, 0));
    assert_non_null(point_near(&m, 0.02, 0.02));
    for (int i = 0; i < COUNT; i++) assert_false(pool[i].redundant);
}

/* A collider that returns each corner several times, or on both surfaces, has returned it once. */
static void corners_returned_again_are_one(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 7);
    pinch_manifold_point points[2 * PINCH_MANIFOLD_POINTS];
    pinch_manifold m = {0, points};
    placed a = placed_at(0, 0, 0.1), b = placed_at(0, 0, -0.1);
    for (int step = 0; step < 100; step++) {
        pinch_detected_point pool[20];
        int count = 0;
        for (int corner = 0; corner < 4; corner++) {
            for (int times = 1 + draw_index(&random, 5); times > 0; times--) {
                pool[count] = fresh_at(corner % 2 ? 0.02 : -0.02, corner / 2 ? 0.02 : -0.02, 2 * MERGE);
                pool[count].position[2] = draw_chance(&random, 0.5) ? MERGE : -MERGE;
                count++;
            }
        }
        update_all(&m, &a, &b, pool, count, 0, 0, false);
        assert_int_equal(m.count, 4);
        for (int k = 0; k < 4 && step == 0; k++) m.point[k].elastic[0] = 1e-6;
        for (int k = 0; k < 4; k++) assert_close(m.point[k].elastic[0], 1e-6, 1e-20);
        int redundant = 0;
        for (int i = 0; i < count; i++) redundant += pool[i].redundant;
        assert_int_equal(redundant, count - 4);
    }
}

/* A new point beside a known one does not take its state, though the collider returns it first. */
static void new_points_take_no_others_state(void **state)
{
    (void)state;
    pinch_manifold_point points[2 * PINCH_MANIFOLD_POINTS];
    pinch_manifold m = {0, points};
    placed a = placed_at(0, 0, 0.1), b = placed_at(0, 0, -0.1);
    pinch_detected_point pool[3] = {fresh_at(0.02, 0, 1e-4), fresh_at(-0.02, 0, 1e-4)};
    update_all(&m, &a, &b, pool, 2, 0, 0, false);
    m.point[0].elastic[0] = 1e-6;
    pool[0] = fresh_at(0.02 - 0.7 * MERGE, 0, 1e-5);
    pool[2] = fresh_at(0.02 + 1e-6, 0, 1e-4);
    update_all(&m, &a, &b, pool, 3, 0, 0, false);
    assert_int_equal(m.count, 3);
    assert_close(m.point[pool[2].point].elastic[0], 1e-6, 1e-20);
    assert_close(m.point[pool[0].point].elastic[0], 0, 0);
}

/* The same by the weights of the points, which share one stiffness. */
static void weighted_resultant(const pinch_manifold *m, double out[2])
{
    double all = pinch_manifold_weight(m);
    out[0] = out[1] = 0;
    for (int k = 0; k < m->count; k++) {
        const pinch_manifold_point *p = &m->point[k];
        out[0] += p->weight * p->elastic[1] / all;
        out[1] += p->weight * p->position[0] * p->elastic[1] / all;
    }
}

/*
 * A pad with points at either side tilts until one has lifted and is dropped, and back. Its share goes over to the
 * other one little by little, and what the springs bear stays. Flat on each other, both count fully.
 */
static void test_shares_go_over_without_jumps(void **state)
{
    (void)state;
    enum { TURN = 320 };
    static const double SIDE = 0.01, DEPTH = 1e-4, SPEED = 2e-4;
    static const double MOST_OUT = 0.01,
                        MOST_BACK = 0.07; /* 2 SPEED/TILT; 4 times what the part of the depth grows by */
    pinch_manifold_point points[PINCH_MANIFOLD_POINTS];
    pinch_manifold m = {0, points};
    placed a = placed_at(0, 0, 0.01), b = placed_at(0, 0, -0.01);
    double weight_before = 1, before[2], now[2];
    bool gone = false;
    for (int step = 0; step < 2 * TURN; step++) {
        double tilt = SPEED * (step < TURN ? step : 2 * TURN - 1 - step), lift = SIDE * sin(tilt);
        pinch_detected_point pool[2] = {fresh_at(SIDE, 0, DEPTH + lift), fresh_at(-SIDE, 0, DEPTH - lift)};
        turn(&a, 1, tilt);
        update_with(&m, &a, &b, pool, lift < DEPTH ? 2 : 1);
        const pinch_manifold_point *lifted = point_near(&m, -SIDE, 0), *pressed = point_near(&m, SIDE, 0);
        double weight = lifted ? lifted->weight / pressed->weight : 0;
        assert_non_null(pressed);
        assert_true(pressed->weight == 1);
        assert_true(fabs(weight - weight_before) <= (step < TURN ? MOST_OUT : MOST_BACK));
        if (tilt == 0) assert_true(weight == 1);
        gone = gone || !lifted;
        weight_before = weight;
        weighted_resultant(&m, now);
        if (step == 0) m.point[0].elastic[1] = m.point[1].elastic[1] = 1e-6;
        if (step > 1 && step < TURN) {
            assert_close(now[0], before[0], 1e-18);
            if (lifted) assert_close(now[1], before[1], 1e-4 * SIDE * 1e-6); /* places move with the tilt */
        }
        weighted_resultant(&m, before);
    }
    assert_true(gone);
    assert_true(weight_before == 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_flickering_collider_keeps_both_ends),
        cmocka_unit_test(test_merge_within_the_distance_only),
        cmocka_unit_test(test_stale_points_go),
        cmocka_unit_test(test_shares_go_over_without_jumps),
        cmocka_unit_test(test_no_fresh_points_at_all),
        cmocka_unit_test(test_many_fresh_points),
        cmocka_unit_test(test_corners_of_a_face),
        cmocka_unit_test(test_floor_and_wall),
        cmocka_unit_test(test_resultant_survives),
        cmocka_unit_test(test_swapped_order_mirrors),
        cmocka_unit_test(test_shear_follows_the_normal),
        cmocka_unit_test(points_of_bodies_at_rest_stay),
        cmocka_unit_test(points_between_others_do_not_flicker),
        cmocka_unit_test(twins_do_not_flicker),
        cmocka_unit_test(points_go_on_on_either_surface),
        cmocka_unit_test(points_above_each_other_stay_apart),
        cmocka_unit_test(rims_do_not_hide_corners),
        cmocka_unit_test(corners_that_only_touch_stay),
        cmocka_unit_test(corners_returned_again_are_one),
        cmocka_unit_test(new_points_take_no_others_state),
    };
    return cmocka_run_group_tests_name("manifold", tests, NULL, NULL);
}
