/* Epsilon and volume of grasp wrench spaces against closed forms and against a search that knows nothing of hulls. */
#include "support/cmocka_all.h"

#include "quality/grasp_quality.h"
#include "support/draw.h"

#include <string.h>

static const double PI = 3.14159265358979323846;

enum { MOST_FINGERS = 8 };

typedef struct rig {
    pinch_finger fingers[MOST_FINGERS];
    pinch_grasp grasp;
} rig;

static void add(rig *r, pinch_contact_model model, const double point[3], const double normal[3], double mu,
                double torsion)
{
    pinch_finger *f = &r->fingers[r->grasp.finger_count++];
    *f = (pinch_finger){
        .model = model, .stiffness = {1, 1, 1}, .friction = mu, .torsional_friction = torsion, .max_force = INFINITY};
    memcpy(f->point, point, sizeof f->point);
    memcpy(f->normal, normal, sizeof f->normal);
    /* in the plane z = 0 where the normal lies in it */
    double axis[3] = {fabs(normal[2]) > 0.9, 0, fabs(normal[2]) <= 0.9};
    cross(axis, normal, f->tangent1);
    double size = length(f->tangent1);
    for (int j = 0; j < 3; j++) f->tangent1[j] /= size;
    r->grasp.fingers = r->fingers;
}

/* `count` fingers around a disc of the grasp's radius in the plane z = 0, pressing on its centre */
static void around_disc(rig *r, int count, pinch_contact_model model, double radius, double mu, double torsion)
{
    memset(r, 0, sizeof *r);
    r->grasp.radius = radius;
    for (int i = 0; i < count; i++) {
        double angle = 2 * PI * i / count;
        double normal[3] = {-cos(angle), -sin(angle), 0};
        add(r, model, (double[3]){-radius * normal[0], -radius * normal[1], 0}, normal, mu, torsion);
    }
}

static grasp_quality quality_of(const rig *r, int faces, double tolerance)
{
    grasp_quality q;
    grasp_quality_settings settings = grasp_quality_default_settings();
    settings.faces = faces;
    settings.tolerance = tolerance;
    settings.most_points = 150;
    assert_int_equal(grasp_quality_find(&r->grasp, &settings, &q), GRASP_QUALITY_FINE);
    assert_int_equal(q.faces, faces);
    assert_true(q.epsilon <= q.epsilon_upper);
    return q;
}

/* An error in even powers of 1/faces is taken out by Romberg's scheme. */
static double extrapolated(const int *faces, int count, double *table)
{
    for (int k = 1; k < count; k++)
        for (int i = k - 1; i >= 0; i--) {
            double ratio = (double)faces[k] / faces[i];
            table[i] = table[i + 1] + (table[i + 1] - table[i]) / (ratio * ratio - 1);
        }
    return table[0];
}

static grasp_quality extrapolated_quality(const rig *r, const int *faces, int count)
{
    double volume[8], epsilon[8];
    for (int k = 0; k < count; k++) {
        grasp_quality q = quality_of(r, faces[k], INFINITY);
        volume[k] = q.volume;
        epsilon[k] = q.epsilon;
        if (k > 0) assert_true(volume[k] > volume[k - 1] && epsilon[k] >= epsilon[k - 1]);
    }
    return (grasp_quality){.volume = extrapolated(faces, count, volume),
                           .epsilon = extrapolated(faces, count, epsilon)};
}

/* Two, three and four fingers in the plane. The wrenches are n_i +- mu (t_i, 1) with torques over the disc's radius:
 * the corners of two regular polygons (for two fingers, of two crossed edges) at the heights +-mu, turned against each
 * other by 2 atan(mu). */
static void test_planar(void **state)
{
    (void)state;
    const double mus[] = {0.1, 0.3, 0.5};
    for (int m = 0; m < 3; m++) {
        double mu = mus[m], alpha = atan(mu), R = hypot(1, mu);
        rig r;
        around_disc(&r, 2, PINCH_CONTACT_HARD, 0.04, mu, 0);
        r.grasp.planar = true;
        grasp_quality q = quality_of(&r, 8, 1e-9);
        assert_close(q.volume, 8 * mu * mu / 3, 1e-12);
        assert_close(q.epsilon, mu / sqrt(2 + mu * mu), 1e-12);
        assert_close(q.epsilon_upper, q.epsilon, 1e-12);
        for (int n = 3; n <= 4; n++) {
            double half = PI / n;
            double area = n / 2.0 * R * R * sin(2 * half);
            double mixed = n / 2.0 * 2 * R * sin(half) * R * cos(half - 2 * alpha);
            double volume = 2 * mu / 6 * (2 * area + (area + area + 2 * mixed));
            /* a side face has an edge of one polygon and a corner of the other */
            double k = R * (cos(half - 2 * alpha) - cos(half)) / (2 * mu);
            double side = R * (cos(half) + cos(half - 2 * alpha)) / 2 / hypot(1, k);
            around_disc(&r, n, PINCH_CONTACT_HARD, 0.04, mu, 0);
            r.grasp.planar = true;
            q = quality_of(&r, 8, 1e-9);
            assert_close(q.volume, volume, 1e-12);
            assert_close(q.epsilon, fmin(mu, side), 1e-12);
        }
    }
}

/* Two soft fingers. Along the normal force's axis the slices are Minkowski sums of two ellipsoids that share the axis
 * of torsion, whose volumes integrate to 16 pi^2/45 mu^4 mu_tau/radius. Epsilon is the planar grasp's, unless torsion
 * is weaker. */
static void test_two_soft_fingers(void **state)
{
    (void)state;
    const double radius = 0.03, mu = 0.4;
    const double torsions[] = {0.004, 0.02};
    const int faces[] = {4, 8, 12, 16, 20};
    for (int k = 0; k < 2; k++) {
        rig r;
        around_disc(&r, 2, PINCH_CONTACT_SOFT, radius, mu, torsions[k]);
        double volume = 16 * PI * PI / 45 * pow(mu, 4) * torsions[k] / radius;
        double epsilon = fmin(torsions[k] / radius, mu / sqrt(2 + mu * mu));
        /* the ratio of the volumes is the same for both */
        grasp_quality q = extrapolated_quality(&r, faces, 5 - k);
        assert_close(q.volume, volume, (k == 0 ? 1e-6 : 1e-3) * volume);
        assert_close(q.epsilon, epsilon, 1e-6 * epsilon);
        /* the bounds enclose it */
        q = quality_of(&r, 8, 0.02);
        assert_true(q.epsilon <= epsilon && epsilon <= q.epsilon_upper);
        assert_close(q.epsilon, epsilon, 0.02 * epsilon);
    }
}

/* Contacts whose cones have six dimensions in all and are independent: the volume is |det G| times the integral over
 * the shares of the normal force. */
static void test_independent_cones(void **state)
{
    (void)state;
    const double mu = 0.6, torsion = 0.3;
    rig r = {.grasp = {.radius = 1}};
    /* a hard finger and three without friction: t1, t2 of the hard one, and four normals */
    add(&r, PINCH_CONTACT_HARD, (double[3]){0, 0, 0}, (double[3]){0, 0, 1}, mu, 0);
    add(&r, PINCH_CONTACT_FRICTIONLESS, (double[3]){0, 1, 0}, (double[3]){0, 0, -1}, 0, 0);
    add(&r, PINCH_CONTACT_FRICTIONLESS, (double[3]){-1, 0, 0}, (double[3]){0, 0, -1}, 0, 0);
    add(&r, PINCH_CONTACT_FRICTIONLESS, (double[3]){0, 1, 0}, (double[3]){1, 0, 0}, 0, 0);
    /* (fz) (fx, fy) and (fz, tx) (fz, ty) (fx, tz): the determinant is 1 */
    const int faces[] = {16, 24, 32, 48};
    double exact = PI * mu * mu / 360;
    assert_close(extrapolated_quality(&r, faces, 4).volume, exact, 1e-6 * exact);
    assert_close(quality_of(&r, 8, 1e-6).epsilon, 0, 0); /* the origin is a corner */

    /* a soft finger and two without friction */
    r = (rig){.grasp = {.radius = 1}};
    add(&r, PINCH_CONTACT_SOFT, (double[3]){0, 0, 0}, (double[3]){0, 0, 1}, mu, torsion);
    add(&r, PINCH_CONTACT_FRICTIONLESS, (double[3]){0, 1, 0}, (double[3]){0, 0, -1}, 0, 0);
    add(&r, PINCH_CONTACT_FRICTIONLESS, (double[3]){-1, 0, 0}, (double[3]){0, 0, -1}, 0, 0);
    exact = PI * mu * mu * torsion / 90;
    const int soft_faces[] = {16, 24, 32, 40};
    assert_close(extrapolated_quality(&r, soft_faces, 4).volume, exact, 1e-6 * exact);
}

/* Without closure, and with a wrench space that is flat, nothing is certain. */
static void test_no_closure(void **state)
{
    (void)state;
    rig r;
    around_disc(&r, 2, PINCH_CONTACT_HARD, 0.04, 0.5, 0); /* turns about the line through both */
    grasp_quality q = quality_of(&r, 8, 1e-6);
    assert_close(q.epsilon, 0, 0);
    assert_close(q.volume, 0, 0);
    around_disc(&r, 4, PINCH_CONTACT_FRICTIONLESS, 0.04, 0, 0);
    q = quality_of(&r, 8, 1e-6);
    assert_close(q.epsilon, 0, 0);
    assert_close(q.epsilon_upper, 0, 0);
}

/* Two soft fingers that miss each other by so much that eight faces leave the origin out of the hull, in some turns of
 * their tangents. What is found does not depend on where the faces are. */
static void test_closure_that_few_faces_miss(void **state)
{
    (void)state;
    static const double OFFSET[2] = {0.021711169014015236, 0.00899306066057961};
    int missed = 0;
    for (int turn = 0; turn <= 45; turn += 5) {
        double angle = turn * PI / 180;
        rig r = {.grasp = {.radius = 0.05 * sqrt(3)}};
        for (int side = -1; side <= 1; side += 2) {
            add(&r, PINCH_CONTACT_SOFT, (double[3]){0.05 * side, -OFFSET[0] * side, -OFFSET[1] * side},
                (double[3]){-side, 0, 0}, 0.5, 0.01);
            const double tangent[3] = {0, cos(angle), sin(angle)};
            memcpy(r.fingers[r.grasp.finger_count - 1].tangent1, tangent, sizeof tangent);
        }
        missed += quality_of(&r, 8, INFINITY).epsilon == 0;
        grasp_quality q;
        grasp_quality_settings settings = grasp_quality_default_settings();
        assert_int_equal(grasp_quality_find(&r.grasp, &settings, &q), GRASP_QUALITY_FINE);
        /* the lower bounds of all turns lie below all upper ones */
        assert_true(q.epsilon >= 0.014 && q.epsilon <= 0.014647);
        assert_true(q.epsilon_upper >= 0.014548 && q.epsilon_upper <= 0.0153);
    }
    assert_true(missed > 0);
}

/* Fingers that all press upwards from below: no force of theirs points down, which is proved whatever the faces are. */
static void test_proof_without_closure(void **state)
{
    (void)state;
    rig r = {.grasp = {.radius = 0.05}};
    for (int i = 0; i < 3; i++) {
        double angle = 2 * PI * i / 3, wrench[WRENCH_MOST];
        add(&r, PINCH_CONTACT_SOFT, (double[3]){0.04 * cos(angle), 0.04 * sin(angle), -0.03},
            (double[3]){-0.6 * cos(angle), -0.6 * sin(angle), 0.8}, 0.6, 0.005);
        if (i < 2) continue;
        grasp_quality q = quality_of(&r, 8, 0.01);
        wrench_space s = wrench_space_of(&r.grasp);
        assert_close(q.epsilon, 0, 0);
        assert_close(q.epsilon_upper, 0, 0);
        assert_true(wrench_space_reach(&s, q.weakest, wrench) <= 0);
    }
}

/* ---- The search. ---- */

/* How far the wrench space reaches along d, written out once more, and the wrench there. */
static double reach(const rig *r, const double d[6], double wrench[6])
{
    double largest = -INFINITY, R = r->grasp.radius;
    for (int i = 0; i < r->grasp.finger_count; i++) {
        const pinch_finger *f = &r->fingers[i];
        double turn[3] = {d[3] / R, d[4] / R, d[5] / R}, v[3], force[3], moment[3];
        cross(turn, f->point, v);
        for (int j = 0; j < 3; j++) v[j] += d[j];
        double along = dot(v, f->normal), across[3];
        for (int j = 0; j < 3; j++) across[j] = f->friction * (v[j] - along * f->normal[j]);
        double torsion = f->model == PINCH_CONTACT_SOFT ? f->torsional_friction * dot(turn, f->normal) : 0;
        double size = hypot(length(across), torsion);
        if (along + size <= largest) continue;
        largest = along + size;
        if (size == 0) size = 1;
        for (int j = 0; j < 3; j++) force[j] = f->normal[j] + f->friction * across[j] / size;
        cross(f->point, force, moment);
        for (int j = 0; j < 3; j++) {
            if (torsion != 0) moment[j] += f->torsional_friction * torsion / size * f->normal[j];
            wrench[j] = force[j];
            wrench[3 + j] = moment[j] / R;
        }
    }
    return largest;
}

static void draw_on_sphere(pinch_random *random, double d[6])
{
    double size = 0;
    for (int j = 0; j < 6; j++) {
        double u = pinch_random_uniform(random), angle = 2 * PI * pinch_random_uniform(random);
        d[j] = sqrt(-2 * log(1 - u)) * cos(angle);
        size += d[j] * d[j];
    }
    for (int j = 0; j < 6; j++) d[j] /= sqrt(size);
}

/* From random directions downhill against the subgradient, by steps that become shorter. */
static double search(const rig *r, pinch_random *random)
{
    enum { STARTS = 60, STEPS = 4000 };
    double least = INFINITY;
    for (int start = 0; start < STARTS; start++) {
        double d[6], w[6];
        draw_on_sphere(random, d);
        double step = 0.3;
        for (int k = 0; k < STEPS; k++, step *= 0.997) {
            double size = 0, slope = 0, value = reach(r, d, w);
            least = fmin(least, value);
            for (int j = 0; j < 6; j++) {
                w[j] -= value * d[j];
                slope += w[j] * w[j];
            }
            for (int j = 0; j < 6; j++) {
                d[j] -= step * w[j] / sqrt(slope + 1e-30);
                size += d[j] * d[j];
            }
            for (int j = 0; j < 6; j++) d[j] /= sqrt(size);
        }
    }
    return least;
}

static void test_search(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 7);
    int closed = 0;
    for (int k = 0; k < draw_count(600); k++) {
        rig r = {.grasp = {.radius = 0.05}};
        int count = 2 + draw_index(&random, 4);
        for (int i = 0; i < count; i++) {
            double point[3], normal[3], tilt[3];
            draw_direction(&random, normal);
            draw_direction(&random, tilt);
            for (int j = 0; j < 3; j++) {
                if (i == 1) normal[j] = -r.fingers[0].normal[j]; /* a pair that faces each other often has closure */
                point[j] = -0.05 * normal[j] + 0.01 * tilt[j];
            }
            double torsional = draw_uniform(&random, 0.002, 0.02), mu = draw_uniform(&random, 0.2, 1);
            bool soft = draw_chance(&random, 0.5) || count == 2;
            add(&r, soft ? PINCH_CONTACT_SOFT : PINCH_CONTACT_HARD, point, normal, mu, torsional);
        }
        grasp_quality q = quality_of(&r, 8, 1e-3);
        double wrench[6];
        if (q.epsilon == 0) { /* proved by a direction without support, or the bound is one that a direction has */
            assert_close(fmax(reach(&r, q.weakest, wrench), 0), q.epsilon_upper, 1e-9);
            continue;
        }
        closed++;
        double least = search(&r, &random);
        /* no direction is weaker than the lower bound, and the weakest is the search's to 1e-3 or to the bounds */
        assert_true(least >= q.epsilon * (1 - 1e-9));
        assert_close(least, q.epsilon_upper, fmax(1e-3 * least, q.epsilon_upper - q.epsilon));
        assert_true(q.epsilon_upper - q.epsilon < 0.05 * least);
        assert_close(reach(&r, q.weakest, wrench), q.epsilon_upper, 1e-9);
    }
    assert_true(closed >= 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_planar),
        cmocka_unit_test(test_two_soft_fingers),
        cmocka_unit_test(test_independent_cones),
        cmocka_unit_test(test_no_closure),
        cmocka_unit_test(test_closure_that_few_faces_miss),
        cmocka_unit_test(test_proof_without_closure),
        cmocka_unit_test(test_search),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
