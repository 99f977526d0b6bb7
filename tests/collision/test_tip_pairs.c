/*
 * Random pairs of every combination of shapes go through dCollide, and a search that shares nothing with the plugin
 * judges the answers. A combination gets ten thousand pairs; one with a superellipsoid, whose powers are slow, a
 * thousand; under sanitizers, which are slow too, a hundred. PINCH_TEST_FULL makes it a million. A tenth as many pairs
 * have their axes aligned.
 *
 * Arguments: `--shape` and the number of a shape take its pairs with itself and with the shapes after it. A count of
 * pairs and the numbers of two shapes take these two alone.
 */
#include "support/cmocka_all.h"

#include "support/sanitized.h"
#include "collision/hard_pairs.h"
#include "support/tips.h"

#include <stdio.h>
#include <string.h>

enum { SHAPES = 12 }; /* a shape is kept for this many poses */

static long pairs_each = 10000;
static int only_a = -1, only_b = -1;

typedef struct tally {
    long pairs, touching, wrong_depth, missed, invented, not_finite, wrong_normal, wrong_sign;
    double depth_error, normal_slope;
} tally;

static const char *const names[PINCH_TIP_COUNT] = {"sphere",   "capsule",   "flat capsule",   "box",
                                                   "cylinder", "ellipsoid", "superellipsoid", "convex"};

static void turn(const double *R, const dMatrix3 by, double *turned)
{
    for (int i = 0; i < 9; i++) {
        turned[i] = 0;
        for (int k = 0; k < 3; k++) turned[i] += R[3 * (i / 3) + k] * by[4 * k + i % 3];
    }
}

/* Axes along those of R, in some order, exactly or nearly; a direction along one of them, every other time, nearly. */
static void draw_aligned(pinch_random *random, const double *R, double *aligned, double *direction)
{
    dMatrix3 quarter, little;
    double v[3], quarter_turned[9], angle = draw_chance(random, 0.2) ? 0 : draw_log_uniform(random, 1e-10, 0.3);
    int about = (int)draw_index(random, 3), along = (int)draw_index(random, 3);
    dRFromAxisAndAngle(quarter, about == 0, about == 1, about == 2, draw_chance(random, 0.7) ? 0.5 * M_PI : 0);
    draw_direction(random, v);
    dRFromAxisAndAngle(little, v[0], v[1], v[2], angle);
    turn(R, quarter, quarter_turned);
    turn(quarter_turned, little, aligned);
    draw_direction(random, direction);
    if (draw_chance(random, 0.5)) return;
    double spread = draw_log_uniform(random, 1e-9, 0.5), length = 0;
    for (int i = 0; i < 3; i++) direction[i] = R[3 * i + along] + spread * direction[i];
    for (int i = 0; i < 3; i++) length = hypot(length, direction[i]);
    for (int i = 0; i < 3; i++) direction[i] /= length;
}

static void place(pinch_random *random, bool aligned, test_tip *a, test_tip *b)
{
    double Ra[9], Rb[9], x[3], y[3], away[3], back[3];
    draw_frame(random, Ra);
    if (!aligned) draw_frame(random, Rb);
    for (int i = 0; i < 3; i++) x[i] = draw_uniform(random, -3, 3);
    if (aligned)
        draw_aligned(random, Ra, Rb, away);
    else
        draw_direction(random, away);
    test_tip_place(a, x, Ra);
    test_tip_place(b, x, Rb);
    for (int i = 0; i < 3; i++) back[i] = -away[i];
    double touch = test_overlap(a, b, back); /* b, moved this far along `away`, is clear of a */
    double part = draw_chance(random, 0.5) ? 1 - draw_log_uniform(random, 1e-5, 0.3) : draw_uniform(random, 0, 1.02);
    for (int i = 0; i < 3; i++) y[i] = x[i] + part * touch * away[i];
    test_tip_place(b, y, Rb);
}

/* The overlap must not fall along any way out of the normal by 1e-4 rad. */
static bool normal_is_least(const test_tip *a, const test_tip *b, const double *n, double depth, double size)
{
    double t1[3] = {0, 0, 0}, t2[3];
    int axis = fabs(n[0]) < 0.6 ? 0 : 1;
    t1[axis] = 1;
    double along = n[axis];
    for (int i = 0; i < 3; i++) t1[i] -= along * n[i];
    double length = sqrt(t1[0] * t1[0] + t1[1] * t1[1] + t1[2] * t1[2]);
    for (int i = 0; i < 3; i++) t1[i] /= length;
    for (int i = 0; i < 3; i++) t2[i] = n[(i + 1) % 3] * t1[(i + 2) % 3] - n[(i + 2) % 3] * t1[(i + 1) % 3];
    for (int k = 0; k < 16; k++) {
        double angle = 0.3926990816987241 * k, m[3];
        for (int i = 0; i < 3; i++) m[i] = n[i] + 1e-4 * (cos(angle) * t1[i] + sin(angle) * t2[i]);
        length = sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
        for (int i = 0; i < 3; i++) m[i] /= length;
        if (test_overlap(a, b, m) < depth - 1e-9 * size) return false;
    }
    return true;
}

/*
 * Caps that are parallel within 5e-7 rad may count as parallel: the depth is then too large by no more than that part
 * of the radius, and overlaps 1e-4 rad from the normal may be less than the depth, though the least one is much nearer.
 */
static bool least_is_near(const test_tip *a, const test_tip *b, const double *n)
{
    double least[3] = {n[0], n[1], n[2]}, across = 0;
    (void)test_lower_overlap(a, b, least);
    for (int i = 0; i < 3; i++) across += (least[i] - n[i]) * (least[i] - n[i]);
    return across < 1e-8;
}

static void judge(test_tip *a, test_tip *b, int samples, tally *t)
{
    dContactGeom contacts[16];
    double size = fmin(a->size, b->size), n[3], depth = -1, normal[3] = {0, 0, 0};
    int count = dCollide(a->geom, b->geom, 16, contacts, sizeof contacts[0]);
    for (int k = 0; k < count; k++) {
        if (!(contacts[k].depth > depth)) continue;
        depth = contacts[k].depth;
        memcpy(normal, contacts[k].normal, sizeof normal);
    }
    double target = count ? depth - 1e-6 * size : 1e-6 * size;
    double least = test_least_overlap(a, b, samples, 3, target, n);
    t->pairs++;
    /* a quick search can get stuck in a crease: the thorough one has the last word */
    if (count == 0 && least > 1e-6 * size) least = fmin(least, test_least_overlap(a, b, 4096, 12, target, n));
    if (count == 0 && least > 1e-6 * size) least = fmin(least, test_lower_overlap(a, b, n));
    if (count == 0) {
        if (least > 1e-6 * size) {
            t->missed++;
            t->depth_error = fmax(t->depth_error, least / size);
        }
        return;
    }
    t->touching++;
    double length = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
    if (!(fabs(length - 1) < 1e-9) || !isfinite(depth)) {
        t->not_finite++;
        return;
    }
    double own = test_overlap(a, b, normal), error = fabs(own - depth) / size;
    error = fmax(error, (depth - least) / size);
    t->wrong_depth += error > 1e-6;
    t->invented += least < -1e-6 * size;
    t->depth_error = fmax(t->depth_error, error);
    double back[3] = {-normal[0], -normal[1], -normal[2]};
    t->wrong_sign += test_overlap(a, b, back) < depth - 1e-6 * size;
    t->wrong_normal += error <= 1e-6 && !normal_is_least(a, b, normal, depth, size) && !least_is_near(a, b, normal);
}

static long wrong_of(const tally *t)
{
    return t->wrong_depth + t->missed + t->invented + t->not_finite + t->wrong_normal + t->wrong_sign;
}

static void judge_hard(const hard_pair *h, const double *exponent, size_t k)
{
    static const double ORIGIN[3] = {0, 0, 0}, IDENTITY[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    test_tip tip[2];
    tally t;
    dMatrix3 turned;
    dQuaternion quaternion;
    double R[9];
    memset(&t, 0, sizeof t);
    for (int i = 0; i < 2; i++) {
        memset(&tip[i], 0, sizeof tip[i]);
        tip[i].tip = pinch_default_tip((pinch_tip_type)h->type[i]);
        memcpy(tip[i].tip.size, h->size[i], sizeof h->size[i]);
        tip[i].tip.skin = h->skin[i];
        if (h->type[i] == PINCH_TIP_SUPERELLIPSOID) memcpy(tip[i].tip.exponent, exponent, sizeof tip[i].tip.exponent);
        test_tip_make_geom(&tip[i]);
    }
    memcpy(quaternion, h->quaternion, sizeof quaternion);
    dNormalize4(quaternion);
    dRfromQ(turned, quaternion);
    for (int i = 0; i < 9; i++) R[i] = turned[4 * (i / 3) + i % 3];
    test_tip_place(&tip[0], ORIGIN, IDENTITY);
    test_tip_place(&tip[1], h->position, R);
    judge(&tip[0], &tip[1], 300, &t);
    if (wrong_of(&t)) print_message("hard pair %zu, %s and %s\n", k, names[h->type[0]], names[h->type[1]]);
    assert_int_equal(t.touching, 1);
    assert_int_equal(wrong_of(&t), 0);
    test_tip_free(&tip[0]);
    test_tip_free(&tip[1]);
}

static void test_hard_pairs(void **state)
{
    (void)state;
    for (size_t k = 0; k < sizeof hard_pairs / sizeof hard_pairs[0]; k++) judge_hard(&hard_pairs[k], NULL, k);
    for (size_t k = 0; k < sizeof hard_superellipsoids / sizeof hard_superellipsoids[0]; k++)
        judge_hard(&hard_superellipsoids[k].pair, hard_superellipsoids[k].exponent, k);
}

static long pairs_of(int a, int b)
{
    bool slow = a == PINCH_TIP_SUPERELLIPSOID || b == PINCH_TIP_SUPERELLIPSOID;
    return slow && pairs_each == 10000 ? 1000 : pairs_each;
}

/* Without a face, an edge or a side. */
static bool is_curved(int type)
{
    return type == PINCH_TIP_SPHERE || type == PINCH_TIP_ELLIPSOID || type == PINCH_TIP_SUPERELLIPSOID;
}

static void look_at_every_combination(bool aligned)
{
    int wrong = 0;
    for (int i = 0; i < PINCH_TIP_COUNT; i++)
        for (int j = i; j < PINCH_TIP_COUNT; j++) {
            if ((only_a >= 0 && i != only_a) || (only_b >= 0 && j != only_b)) continue;
            if (aligned && (is_curved(i) || is_curved(j))) continue;
            pinch_random random;
            pinch_random_seed(&random, (uint64_t)(1000 + 100 * i + j));
            tally t;
            memset(&t, 0, sizeof t);
            test_tip a, b;
            for (long k = 0; k < (aligned ? pairs_each / 10 : pairs_of(i, j)); k++) {
                if (k % SHAPES == 0) {
                    if (k) {
                        test_tip_free(&a);
                        test_tip_free(&b);
                    }
                    test_tip_make(&random, (pinch_tip_type)i, &a);
                    test_tip_make(&random, (pinch_tip_type)j, &b);
                }
                place(&random, aligned, &a, &b);
                judge(&a, &b, 300, &t);
            }
            test_tip_free(&a);
            test_tip_free(&b);
            long bad = wrong_of(&t);
            wrong += bad > 0;
            if (bad || only_b >= 0 || pairs_each > 100000)
                print_message(
                    "%s, %s%s: %ld pairs, %ld touching; depth wrong %ld (worst %.2g of the size), missed %ld, "
                    "invented %ld, normal wrong %ld, sign %ld, not finite %ld\n",
                    names[i], names[j], aligned ? ", aligned" : "", t.pairs, t.touching, t.wrong_depth, t.depth_error,
                    t.missed, t.invented, t.wrong_normal, t.wrong_sign, t.not_finite);
        }
    pinch_tip_stats stats = pinch_tip_statistics();
    print_message("pairs %ld, deep %ld, iteration limit %ld\n", stats.pairs, stats.deep, stats.iteration_limit);
    assert_int_equal(wrong, 0);
}

static void test_every_combination(void **state)
{
    (void)state;
    look_at_every_combination(false);
}

/* As things stand and lie: axes parallel or at right angles, to rounding or by little. */
static void test_aligned(void **state)
{
    (void)state;
    look_at_every_combination(true);
}

int main(int argc, char **argv)
{
    bool counted = argc > 1 && argv[1][0] != '-';
    if (SANITIZED) pairs_each = 100;
    if (getenv("PINCH_TEST_FULL")) pairs_each = 1000000;
    if (counted) pairs_each = atol(argv[1]);
    if (argc > 2) only_a = atoi(argv[2]);
    if (argc > 3) only_b = atoi(argv[3]);
    dInitODE2(0);
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_hard_pairs), cmocka_unit_test(test_every_combination),
                                       cmocka_unit_test(test_aligned)};
    int failed = cmocka_run_group_tests_name("tip pairs", tests, NULL, NULL);
    dCloseODE();
    pinch_close_tips();
    return failed;
}
