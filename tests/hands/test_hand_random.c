/*
 * Random trees of links, written once as URDF and once as MJCF. Both must be read back as what was written, to the last
 * digit, and as the same hand. Poses are held against a chain of homogeneous matrices, masses against sums over point
 * masses.
 */

#include "support/cmocka_all.h"

#include "hand_case.h"
#include "support/draw.h"
#include "support/program.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 14 };

typedef struct part {
    int parent; /* -1: the first link */
    int type;   /* 0: fixed, 1: hinge, 2: slider */
    double xyz[3], rpy[3], axis[3], lower, upper, damping, friction, effort;
    double mass, centre[3], moments[3], turn[3]; /* turn: roll, pitch and yaw of the inertia's axes */
} part;

/* Moments of a box with random sides, so that there is a body with them. */
static void draw_part(pinch_random *random, int index, part *p)
{
    double side[3];
    p->parent = index ? draw_index(random, index) : -1;
    p->type = index ? draw_index(random, 3) : 0;
    for (int i = 0; i < 3; i++) {
        p->xyz[i] = draw_uniform(random, -1, 1);
        p->rpy[i] = draw_uniform(random, -3, 3);
        p->centre[i] = draw_uniform(random, -0.1, 0.1);
        p->turn[i] = draw_uniform(random, -3, 3);
        side[i] = draw_log_uniform(random, 0.01, 1);
    }
    draw_direction(random, p->axis);
    p->mass = draw_log_uniform(random, 1e-3, 10);
    for (int i = 0; i < 3; i++)
        p->moments[i] = p->mass / 12 * (side[(i + 1) % 3] * side[(i + 1) % 3] + side[(i + 2) % 3] * side[(i + 2) % 3]);
    p->lower = draw_uniform(random, -2, 0);
    p->upper = draw_uniform(random, 0, 2);
    p->damping = draw_uniform(random, 0, 1);
    p->friction = draw_uniform(random, 0, 1);
    p->effort = draw_log_uniform(random, 0.1, 100);
}

static void write_urdf(FILE *f, const part *parts, int count)
{
    static const char *const types[] = {"fixed", "revolute", "prismatic"};
    fputs("<robot name=\"random\">\n", f);
    for (int i = 0; i < count; i++) {
        const part *p = &parts[i];
        fprintf(f, "<link name=\"l%d\"><inertial><origin xyz=\"%.17g %.17g %.17g\" rpy=\"%.17g %.17g %.17g\"/>", i,
                p->centre[0], p->centre[1], p->centre[2], p->turn[0], p->turn[1], p->turn[2]);
        fprintf(f,
                "<mass value=\"%.17g\"/><inertia ixx=\"%.17g\" iyy=\"%.17g\" izz=\"%.17g\" ixy=\"0\" ixz=\"0\" "
                "iyz=\"0\"/></inertial></link>\n",
                p->mass, p->moments[0], p->moments[1], p->moments[2]);
        if (i == 0) continue;
        fprintf(f, "<joint name=\"j%d\" type=\"%s\"><parent link=\"l%d\"/><child link=\"l%d\"/>", i, types[p->type],
                p->parent, i);
        fprintf(f, "<origin xyz=\"%.17g %.17g %.17g\" rpy=\"%.17g %.17g %.17g\"/>", p->xyz[0], p->xyz[1], p->xyz[2],
                p->rpy[0], p->rpy[1], p->rpy[2]);
        fprintf(f,
                "<axis xyz=\"%.17g %.17g %.17g\"/><limit lower=\"%.17g\" upper=\"%.17g\" effort=\"%.17g\" "
                "velocity=\"1\"/><dynamics damping=\"%.17g\" friction=\"%.17g\"/></joint>\n",
                p->axis[0], p->axis[1], p->axis[2], p->lower, p->upper, p->effort, p->damping, p->friction);
    }
    fputs("</robot>\n", f);
}

/* The same tree; roll, pitch and yaw are the sequence XYZ about fixed axes. */
static void write_mjcf_body(FILE *f, const part *parts, int count, int index)
{
    const part *p = &parts[index];
    fprintf(f, "<body name=\"l%d\"", index);
    if (index)
        fprintf(f, " pos=\"%.17g %.17g %.17g\" euler=\"%.17g %.17g %.17g\"", p->xyz[0], p->xyz[1], p->xyz[2], p->rpy[0],
                p->rpy[1], p->rpy[2]);
    fprintf(f,
            ">\n<inertial pos=\"%.17g %.17g %.17g\" euler=\"%.17g %.17g %.17g\" mass=\"%.17g\" diaginertia=\"%.17g "
            "%.17g %.17g\"/>\n",
            p->centre[0], p->centre[1], p->centre[2], p->turn[0], p->turn[1], p->turn[2], p->mass, p->moments[0],
            p->moments[1], p->moments[2]);
    if (p->type)
        fprintf(f,
                "<joint name=\"j%d\" type=\"%s\" axis=\"%.17g %.17g %.17g\" range=\"%.17g %.17g\" "
                "actuatorfrcrange=\"%.17g %.17g\" damping=\"%.17g\" frictionloss=\"%.17g\"/>\n",
                index, p->type == 1 ? "hinge" : "slide", p->axis[0], p->axis[1], p->axis[2], p->lower, p->upper,
                -p->effort, p->effort, p->damping, p->friction);
    for (int i = 1; i < count; i++)
        if (parts[i].parent == index) write_mjcf_body(f, parts, count, i);
    fputs("</body>\n", f);
}

static hand *read_back(const char *folder, const char *name, const part *parts, int count)
{
    char path[512];
    hand *h;
    hand_error error;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    if (strstr(name, ".urdf")) {
        write_urdf(f, parts, count);
    } else {
        fputs("<mujoco><compiler angle=\"radian\" eulerseq=\"XYZ\"/><worldbody>\n", f);
        write_mjcf_body(f, parts, count, 0);
        fputs("</worldbody></mujoco>\n", f);
    }
    fclose(f);
    if (hand_load(path, NULL, 0, &h, &error) != HAND_OK) fail_msg("%s", error.text);
    return h;
}

/* ---- The referee: 4 x 4 matrices, row-major. ---- */

static void multiply(const double *a, const double *b, double *c)
{
    for (int i = 0; i < 16; i++) {
        c[i] = 0;
        for (int k = 0; k < 4; k++) c[i] += a[4 * (i / 4) + k] * b[4 * k + i % 4];
    }
}

/* Rodrigues' formula for a turn about an axis. */
static void turn_matrix(const double axis[3], double angle, double m[16])
{
    double c = cos(angle), s = sin(angle);
    double cross[9] = {0, -axis[2], axis[1], axis[2], 0, -axis[0], -axis[1], axis[0], 0};
    memset(m, 0, 16 * sizeof *m);
    for (int i = 0; i < 9; i++)
        m[4 * (i / 3) + i % 3] = (i % 4 ? 0 : c) + s * cross[i] + (1 - c) * axis[i / 3] * axis[i % 3];
    m[15] = 1;
}

static void rpy_matrix(const double rpy[3], const double xyz[3], double m[16])
{
    static const double axes[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    double x[16], y[16], z[16], zy[16];
    turn_matrix(axes[0], rpy[0], x);
    turn_matrix(axes[1], rpy[1], y);
    turn_matrix(axes[2], rpy[2], z);
    multiply(z, y, zy);
    multiply(zy, x, m);
    for (int i = 0; i < 3; i++) m[4 * i + 3] = xyz[i];
}

static void link_matrix(const part *parts, const double *q, int index, double m[16])
{
    double above[16], own[16], joint[16], placed[16];
    if (index == 0) {
        rpy_matrix((double[3]){0}, (double[3]){0}, m);
        return;
    }
    const part *p = &parts[index];
    link_matrix(parts, q, p->parent, above);
    rpy_matrix(p->rpy, p->xyz, own);
    turn_matrix(p->axis, p->type == 1 ? q[index] : 0, joint);
    for (int i = 0; i < 3; i++) joint[4 * i + 3] = p->type == 2 ? q[index] * p->axis[i] : 0;
    multiply(above, own, placed);
    multiply(placed, joint, m);
}

/* The body as two point masses on each principal axis: one per cent of the mass apiece, at the distances that give the
 * moments, the rest in the middle. Sums the mass, its first and its second moments. */
static void add_points(const part *p, const double m[16], double sum[13])
{
    double inertia[16], whole[16];
    rpy_matrix(p->turn, p->centre, inertia);
    multiply(m, inertia, whole);
    double trace = (p->moments[0] + p->moments[1] + p->moments[2]) / 2, left = p->mass;
    for (int k = 0; k < 7; k++) {
        double x[3], mass = k < 6 ? 0.01 * p->mass : left;
        left -= k < 6 ? mass : 0;
        double away = k < 6 ? sqrt((trace - p->moments[k / 2]) / (0.02 * p->mass)) * (k % 2 ? 1 : -1) : 0;
        for (int i = 0; i < 3; i++) x[i] = whole[4 * i + 3] + (k < 6 ? away * whole[4 * i + k / 2] : 0);
        sum[0] += mass;
        for (int i = 0; i < 3; i++) sum[1 + i] += mass * x[i];
        for (int i = 0; i < 9; i++) sum[4 + i] += mass * x[i / 3] * x[i % 3];
    }
}

static void check_bodies(const hand *h, const part *parts, int count)
{
    double zero[MOST] = {0}, inverse[16];
    for (size_t b = 0; b < h->body_count; b++) {
        const hand_body *body = &h->bodies[b];
        double sum[13] = {0}, first[16], centre[3], inertia[9], m[16], local[16];
        link_matrix(parts, zero, atoi(h->links[body->link].name + 1), first);
        for (int i = 0; i < 16; i++) inverse[i] = i == 15;
        for (int i = 0; i < 3; i++)
            for (int k = 0; k < 3; k++) {
                inverse[4 * i + k] = first[4 * k + i];
                inverse[4 * i + 3] -= first[4 * k + i] * first[4 * k + 3];
            }
        for (int i = 0; i < count; i++) {
            char name[16];
            snprintf(name, sizeof name, "l%d", i);
            if (h->links[hand_find_link(h, name)].body != (int)b) continue;
            link_matrix(parts, zero, i, m);
            multiply(inverse, m, local);
            add_points(&parts[i], local, sum);
        }
        for (int i = 0; i < 3; i++) centre[i] = sum[1 + i] / sum[0];
        double trace = 0;
        for (int i = 0; i < 9; i++) sum[4 + i] -= sum[0] * centre[i / 3] * centre[i % 3];
        for (int i = 0; i < 3; i++) trace += sum[4 + 4 * i];
        for (int i = 0; i < 9; i++) inertia[i] = (i % 4 ? 0 : trace) - sum[4 + i];
        assert_close(body->mass.mass, sum[0], 1e-13 * sum[0]);
        assert_numbers(body->mass.centre, centre, 3, 1e-12);
        assert_numbers(body->mass.inertia, inertia, 9, 1e-11 * (trace + sum[0]));
    }
}

static void check_joints(const hand *h, const part *parts, int count)
{
    size_t found = 0;
    for (int i = 1; i < count; i++) {
        const part *p = &parts[i];
        char name[16];
        snprintf(name, sizeof name, "j%d", i);
        int k = hand_find_joint(h, name);
        assert_int_equal(k >= 0, p->type != 0);
        if (k < 0) continue;
        const hand_joint *j = &h->joints[k];
        found++;
        assert_int_equal(j->type, p->type == 1 ? HAND_HINGE : HAND_SLIDER);
        assert_string_equal(h->links[j->link].name + 1, name + 1);
        assert_numbers(j->axis, p->axis, 3, 1e-15);
        assert_true(j->lower == p->lower && j->upper == p->upper && j->effort == p->effort);
        assert_true(j->damping == p->damping && j->friction == p->friction);
    }
    assert_int_equal(h->joint_count, found);
    assert_int_equal(h->body_count, found + 1);
}

static void check_poses(const hand *h, const part *parts, int count, pinch_random *random)
{
    double of_part[MOST] = {0}, q[MOST] = {0}, m[16], r[9];
    hand_pose poses[MOST];
    for (size_t k = 0; k < h->joint_count; k++) {
        q[k] = draw_uniform(random, -3, 3);
        of_part[atoi(h->joints[k].name + 1)] = q[k];
    }
    hand_kinematics(h, q, poses);
    for (int i = 0; i < count; i++) {
        char name[16];
        snprintf(name, sizeof name, "l%d", i);
        const hand_pose *pose = &poses[hand_find_link(h, name)];
        link_matrix(parts, of_part, i, m);
        pose_matrix(pose->orientation, r);
        for (int k = 0; k < 3; k++) {
            assert_numbers(r + 3 * k, m + 4 * k, 3, 1e-13);
            assert_close(pose->position[k], m[4 * k + 3], 1e-12);
        }
    }
}

static void random_trees(void **state)
{
    (void)state;
    char *folder = program_make_folder();
    pinch_random random;
    pinch_random_seed(&random, 11);
    int rounds = draw_count(5000);
    for (int round = 0; round < rounds; round++) {
        part parts[MOST];
        int count = 1 + draw_index(&random, MOST);
        for (int i = 0; i < count; i++) draw_part(&random, i, &parts[i]);
        for (int format = 0; format < 2; format++) {
            hand *h = read_back(folder, format ? "h.xml" : "h.urdf", parts, count);
            assert_int_equal(h->link_count, count);
            assert_true(h->ignored_count == 0 && h->unmodelled_count == 0);
            check_joints(h, parts, count);
            check_bodies(h, parts, count);
            check_poses(h, parts, count, &random);
            hand_free(h);
        }
    }
    program_remove_folder(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(random_trees)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
