/* Masses that MJCF infers from shapes: against sums over many small cubes, closed forms, and meshes of the same shape.
 */

#include "support/cmocka_all.h"

#include "hand_case.h"
#include "hands/inertia.h"
#include "support/program.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool is_inside(hand_geom_type type, const double s[3], const double x[3])
{
    double round = hypot(x[0], x[1]), over = fmax(0, fabs(x[2]) - s[1]);
    switch (type) {
    case HAND_BOX:
        return fabs(x[0]) < s[0] && fabs(x[1]) < s[1] && fabs(x[2]) < s[2];
    case HAND_SPHERE:
        return hypot(round, x[2]) < s[0];
    case HAND_CAPSULE:
        return hypot(round, over) < s[0];
    case HAND_CYLINDER:
        return round < s[0] && fabs(x[2]) < s[1];
    default:
        return x[0] * x[0] / (s[0] * s[0]) + x[1] * x[1] / (s[1] * s[1]) + x[2] * x[2] / (s[2] * s[2]) < 1;
    }
}

/* Cubes of which the middle is inside. They miss a part of the order of their size over that of the shape. */
static void solids_against_cubes(void **state)
{
    (void)state;
    const double s[3] = {0.5, 0.7, 0.9}, reach = 1.3, step = 0.01;
    for (int type = HAND_BOX; type <= HAND_ELLIPSOID; type++) {
        double volume = 0, moments[3] = {0}, own[3];
        for (double x = -reach + step / 2; x < reach; x += step)
            for (double y = -reach + step / 2; y < reach; y += step)
                for (double z = -reach + step / 2; z < reach; z += step)
                    if (is_inside((hand_geom_type)type, s, (double[]){x, y, z})) {
                        volume += step * step * step;
                        moments[0] += step * step * step * (y * y + z * z);
                        moments[1] += step * step * step * (x * x + z * z);
                        moments[2] += step * step * step * (x * x + y * y);
                    }
        geom_moments((hand_geom_type)type, s, false, own);
        assert_close(geom_volume((hand_geom_type)type, s, false), volume, 2e-3 * volume);
        for (int i = 0; i < 3; i++) assert_close(own[i], moments[i] / volume, 3e-3 * own[i]);
    }
}

/* A shell is the difference of two solids that are a little apart, over their difference in volume. Capsule, cylinder
 * and box have even walls if all half lengths grow by the same, or by the radius alone for the capsule's tube. */
static void shells_against_differences(void **state)
{
    (void)state;
    const double s[3] = {0.5, 0.7, 0.9}, wall = 1e-4;
    for (int type = HAND_BOX; type <= HAND_ELLIPSOID; type++) {
        double grown[3], shrunk[3], inner[3], outer[3], own[3];
        for (int i = 0; i < 3; i++) {
            double half = type == HAND_CAPSULE && i == 1 ? 0 : wall / 2;
            grown[i] = s[i] + half;
            shrunk[i] = s[i] - half;
        }
        double small = geom_volume((hand_geom_type)type, shrunk, false);
        double large = geom_volume((hand_geom_type)type, grown, false);
        geom_moments((hand_geom_type)type, shrunk, false, inner);
        geom_moments((hand_geom_type)type, grown, false, outer);
        geom_moments((hand_geom_type)type, s, true, own);
        for (int i = 0; i < 3; i++)
            assert_close(own[i], (large * outer[i] - small * inner[i]) / (large - small),
                         type == HAND_ELLIPSOID ? 1e-5 : 1e-7);
        if (type != HAND_ELLIPSOID) /* its walls are not even, and its surface is an approximation */
            assert_close(geom_volume((hand_geom_type)type, s, true), (large - small) / wall, 1e-7);
    }
}

static void principal_axes(void **state)
{
    (void)state;
    const double matrices[][9] = {{3, 0, 0, 0, 1, 0, 0, 0, 2},
                                  {2, -1, 0, -1, 2, -1, 0, -1, 2},
                                  {1e-9, 3e-10, -2e-10, 3e-10, 2e-9, 1e-10, -2e-10, 1e-10, 1.5e-9},
                                  {1, 0, 0, 0, 1, 0, 0, 0, 1},
                                  {1, 1e-9, 0, 1e-9, 1, 0, 0, 0, 1}};
    for (size_t k = 0; k < sizeof matrices / sizeof matrices[0]; k++) {
        double values[3], axes[9], back[9], q[4], turned[9];
        inertia_principal(matrices[k], values, axes);
        inertia_from_principal(values, axes, back);
        assert_true(values[0] >= values[1] && values[1] >= values[2]);
        assert_numbers(back, matrices[k], 9, 1e-15 * fabs(values[0]) * 4);
        inertia_quaternion(axes, q);
        pose_matrix(q, turned);
        assert_numbers(turned, axes, 9, 1e-15 * 4);
    }
}

/* A cube of side 2 about (1, 1, 1), an L of three such cubes, and the cube with one face turned inside out. */
#define CUBE_VERTEX "0 0 0 2 0 0 0 2 0 2 2 0 0 0 2 2 0 2 0 2 2 2 2 2"
#define CUBE_FACE   "0 2 3 0 3 1 4 5 7 4 7 6 0 1 5 0 5 4 2 6 7 2 7 3 0 4 6 0 6 2 1 3 7 1 7 5"
#define MESH_BODY(mesh, geom)                                                                                          \
    "<mujoco>\n<asset>\n" mesh "\n</asset>\n<worldbody><body name=\"b\">\n" geom "\n</body></worldbody></mujoco>"

static void meshes_weigh(void **state)
{
    (void)state;
    static const char *const modes[] = {"legacy", "exact", "convex"};
    char *folder = program_make_folder();
    for (int i = 0; i < 4; i++) {
        char text[1024];
        snprintf(text, sizeof text,
                 MESH_BODY("<mesh name=\"m\" vertex=\"" CUBE_VERTEX "\" face=\"" CUBE_FACE
                           "\" inertia=\"%s\" scale=\"1 %s 0.5\"/>",
                           "<geom type=\"mesh\" mesh=\"m\" density=\"10\" pos=\"1 0 0\"/>"),
                 modes[i % 3], i == 3 ? "-1" : "1");
        hand *h = hand_from_text(folder, "h.xml", text);
        const hand_mass *m = &h->links[0].mass;
        assert_close(m->mass, 40, 1e-13);
        assert_numbers(m->centre, (double[]){2, i == 3 ? -1 : 1, 0.5}, 3, 1e-14);
        assert_numbers(m->inertia, (double[]){40 * 5.0 / 12, 0, 0, 0, 40 * 5.0 / 12, 0, 0, 0, 40 * 8.0 / 12}, 9, 1e-12);
        hand_free(h);
    }
    /* a shell: six faces of 4 m^2, thin */
    hand *h = hand_from_text(folder, "h.xml",
                             MESH_BODY("<mesh name=\"m\" vertex=\"" CUBE_VERTEX "\" face=\"" CUBE_FACE
                                       "\" inertia=\"shell\"/>",
                                       "<geom type=\"mesh\" mesh=\"m\" mass=\"6\"/>"));
    double box[3];
    geom_moments(HAND_BOX, (double[]){1, 1, 1}, true, box);
    assert_numbers(h->links[0].mass.centre, (double[]){1, 1, 1}, 3, 1e-14);
    for (int i = 0; i < 3; i++) assert_close(h->links[0].mass.inertia[4 * i], 6 * box[i], 1e-13);
    hand_free(h);
    /* vertices alone stand for their hull */
    h = hand_from_text(
        folder, "h.xml",
        MESH_BODY("<mesh name=\"m\" vertex=\"" CUBE_VERTEX "\"/>", "<geom type=\"mesh\" mesh=\"m\" density=\"1\"/>"));
    assert_close(h->links[0].mass.mass, 8, 1e-13);
    assert_int_equal(h->meshes[0].hull.vertex_count, 8);
    hand_free(h);
    program_remove_folder(folder);
}

/* refpos and refquat move the mesh before the scale does; a shape that is fitted to a mesh has its moments. */
static void meshes_are_placed_and_fitted(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    hand *h = hand_from_text(folder, "h.xml",
                             MESH_BODY("<mesh name=\"m\" vertex=\"" CUBE_VERTEX "\" face=\"" CUBE_FACE
                                       "\" refpos=\"1 0 0\" refquat=\"1 0 0 1\" scale=\"1 3 1\"/>",
                                       "<geom type=\"mesh\" mesh=\"m\" mass=\"1\"/>\n<geom type=\"box\" mesh=\"m\" "
                                       "mass=\"0\"/>"));
    /* (0, 1, 1) in the axes turned by a quarter about z is (1, 0, 1) */
    assert_numbers(h->links[0].mass.centre, (double[]){1, 0, 1}, 3, 1e-13);
    double side[3] = {h->geoms[1].size[0], h->geoms[1].size[1], h->geoms[1].size[2]};
    assert_close(side[0] * side[1] * side[2], 3, 1e-6);
    assert_close(fmax(side[0], fmax(side[1], side[2])), 3, 1e-6);
    assert_numbers(h->geoms[1].pose.position, (double[]){1, 0, 1}, 3, 1e-13);
    hand_free(h);
    program_remove_folder(folder);
}

static void compiler_settings(void **state)
{
    (void)state;
    static const struct {
        const char *settings, *body;
        double mass, moments[3];
    } cases[] = {
        {"", "<geom size=\"1\" mass=\"5\"/>", 5, {2, 2, 2}},
        {"inertiafromgeom=\"false\" boundmass=\"3\" boundinertia=\"0.5\"", "<geom size=\"1\"/>", 3, {0.5, 0.5, 0.5}},
        {"inertiafromgeom=\"true\"",
         "<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/><geom size=\"1\" mass=\"5\"/>",
         5,
         {2, 2, 2}},
        {"balanceinertia=\"true\"", "<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 7\"/>", 1, {3, 3, 3}},
        {"settotalmass=\"10\"", "<geom size=\"1\" mass=\"5\"/>", 10, {4, 4, 4}},
        {"inertiagrouprange=\"1 2\"",
         "<geom size=\"1\" mass=\"5\" group=\"2\"/><geom size=\"1\" mass=\"9\"/>",
         5,
         {2, 2, 2}},
    };
    char *folder = program_make_folder();
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        char text[512];
        snprintf(text, sizeof text, "<mujoco><compiler %s/><worldbody><body>%s</body></worldbody></mujoco>",
                 cases[i].settings, cases[i].body);
        hand *h = hand_from_text(folder, "h.xml", text);
        assert_close(h->links[0].mass.mass, cases[i].mass, 1e-14);
        for (int k = 0; k < 3; k++) assert_close(h->links[0].mass.inertia[4 * k], cases[i].moments[k], 1e-14);
        hand_free(h);
    }
    program_remove_folder(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(solids_against_cubes),
        cmocka_unit_test(shells_against_differences),
        cmocka_unit_test(principal_axes),
        cmocka_unit_test(meshes_weigh),
        cmocka_unit_test(meshes_are_placed_and_fitted),
        cmocka_unit_test(compiler_settings),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
