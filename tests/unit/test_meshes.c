/* Tests what a mesh file must be: whole text, whole numbers, a regular file; closed convex pieces without a common
 * volume. */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"
#include "support/draw.h"
#include "support/program.h"

#include "scenes/shape/shape.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static char *folder;

/* Loads a mesh; `error` is empty where it was taken. */
static void load(const char *path, char error[256], double *volume)
{
    scene_shape shape = {.type = SCENE_MESH, .u.mesh.file = strdup(path)};
    error[0] = '\0';
    scene_shape_fault fault = scene_shape_load_mesh(&shape, error);
    assert_true((fault == SCENE_SHAPE_FINE) == !*error);
    if (volume) *volume = shape.volume;
    scene_shape_free(&shape);
}

static void load_text(const char *text, char error[256], double *volume)
{
    char *path = program_write_file(folder, "mesh.obj", text);
    load(path, error, volume);
    free(path);
}

static void refused(const char *text, const char *says)
{
    char error[256];
    load_text(text, error, NULL);
    if (!strstr(error, says)) fail_msg("\"%s\" does not say \"%s\"", error, says);
}

/* ---- Text ---- */

#define TETRAHEDRON "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"

static void test_numbers_end_where_they_end(void **state)
{
    (void)state;
    char error[256];
    load_text(TETRAHEDRON, error, NULL);
    assert_string_equal(error, "");
    /* colours and weights may follow the coordinates */
    load_text("v 0 0 0 1 0 0\nv 1 0 0 0.5\nv 0 1 0\t\nv 0 0 1\r\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", error, NULL);
    assert_string_equal(error, "");
    refused("v 0 0 0\nv 1 0 -0.01abc\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
            "line 2: expected three");
    refused("v 0 0 0\nv 1 0,5 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", "line 2: expected three");
}

/* A backslash at the end of a line goes on in the next, also with DOS ends; lines are counted as they are in the file.
 */
static void test_lines_that_go_on(void **state)
{
    (void)state;
    char error[256];
    double volume = 0;
    load_text("# a comment \\\nf 9 9 9\nv 0 \\\n0 0\nv 1 0 0\nv 0 1 0\nv 0 0 \\\r\n\\\n1\r\nf 1 \\\n3 2\n"
              "f 1 2 4\nf 1 4 3\nf 2 3\\\n4",
              error, &volume);
    assert_string_equal(error, "");
    assert_float_equal(volume, 1.0 / 6, 1e-12);
    refused("v 0 0 \\\n0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 x\n", "line 6: expected a face");
    refused("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2 \\", "a face of corner numbers");
}

static void test_zero_bytes_are_refused(void **state)
{
    (void)state;
    static const char text[] =
        TETRAHEDRON "#\0\nv 5 0 0\nv 6 0 0\nv 5 1 0\nv 5 0 1\nf 5 7 6\nf 5 6 8\nf 5 8 7\nf 6 7 8\n";
    char *path = program_write_file(folder, "mesh.obj", ""), error[256];
    FILE *stream = fopen(path, "wb");
    assert_int_equal(fwrite(text, 1, sizeof text - 1, stream), sizeof text - 1);
    fclose(stream);
    load(path, error, NULL);
    if (!strstr(error, "line 9: expected text") || !strstr(error, "zero byte")) fail_msg("%s", error);
    free(path);
}

/* A pipe without a writer blocks whoever opens it for reading; the test would not end. */
static void test_only_regular_files_are_read(void **state)
{
    (void)state;
    char path[1024], error[256];
    snprintf(path, sizeof path, "%s/pipe.obj", folder);
    assert_int_equal(mkfifo(path, 0600), 0);
    load(path, error, NULL);
    assert_non_null(strstr(error, "no regular file"));
    unlink(path);
    load("/dev/zero", error, NULL);
    assert_non_null(strstr(error, "no regular file"));
    load(folder, error, NULL);
    assert_non_null(strstr(error, "Is a directory"));
    snprintf(path, sizeof path, "%s/absent.obj", folder);
    load(path, error, NULL);
    assert_non_null(strstr(error, "No such file"));
}

/* ---- Closed pieces ---- */

static const int side[12][3] = {{4, 3, 2}, {4, 2, 1}, {5, 6, 7}, {5, 7, 8}, {1, 2, 6}, {1, 6, 5},
                                {2, 3, 7}, {2, 7, 6}, {3, 4, 8}, {3, 8, 7}, {4, 1, 5}, {4, 5, 8}};
static const double sign[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                  {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};

/* The triangle that comes at place t when they are written from `first` on. */
static int at_place(int t, int first)
{
    return (t + first) % 12;
}

/* A box as piece k of the file; the rows of R are its axes. Triangles of `without` are left out. */
static void add_box(FILE *file, int k, const double half[3], const double centre[3], const double R[9],
                    unsigned without, int first)
{
    fprintf(file, "o box%d\n", k);
    for (int c = 0; c < 8; c++) {
        double x[3] = {centre[0], centre[1], centre[2]};
        for (int i = 0; i < 9; i++) x[i % 3] += R[i] * half[i / 3] * sign[c][i / 3];
        fprintf(file, "v %.17g %.17g %.17g\n", x[0], x[1], x[2]);
    }
    for (int t = 0; t < 12; t++) {
        const int *corner = side[at_place(t, first)];
        if (without >> at_place(t, first) & 1) continue;
        fprintf(file, "f %d %d %d\n", 8 * k + corner[0], 8 * k + corner[1], 8 * k + corner[2]);
    }
}

static FILE *begin(char path[1024])
{
    snprintf(path, 1024, "%s/boxes.obj", folder);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    return file;
}

static void end(FILE *file, const char *path, char error[256], double *volume)
{
    assert_int_equal(fclose(file), 0);
    load(path, error, volume);
}

/* Whichever triangles are missing, and whichever triangle stands first. */
static void test_open_pieces_are_refused(void **state)
{
    (void)state;
    static const double R[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const unsigned lid = 3, tube = 15, corner = 1;
    char path[1024], error[256];
    for (int first = 0; first < 12; first++)
        for (int t = 0; t < 12; t += 2) {
            const unsigned missing[4] = {0, lid << t, corner << t, t <= 8 ? tube << t : lid << t};
            for (int m = 0; m < 4; m++) {
                double volume;
                FILE *file = begin(path);
                add_box(file, 0, (double[]){0.01, 0.02, 0.03}, (double[]){0.1, 0.2, 0.3}, R, missing[m], first);
                end(file, path, error, &volume);
                if (m == 0) {
                    assert_string_equal(error, "");
                    assert_close(volume, 4.8e-5, 1e-15);
                } else if (!strstr(error, "closed pieces")) {
                    fail_msg("first %d, missing %x: \"%s\"", first, missing[m], error);
                }
            }
        }
}

/* ---- Pieces that share volume ---- */

/* The largest gap between two boxes along a face normal or a product of edges: below 0 they overlap, by so much. */
static double largest_gap(const double half[2][3], const double centre[2][3], double R[2][9])
{
    double most = -INFINITY;
    for (int axis = 0; axis < 15; axis++) {
        double n[3], reach = 0, apart = 0;
        if (axis < 6)
            for (int i = 0; i < 3; i++) n[i] = R[axis / 3][3 * (axis % 3) + i];
        else
            cross(R[0] + 3 * ((axis - 6) / 3), R[1] + 3 * ((axis - 6) % 3), n);
        double size = length(n);
        if (size < 1e-6) continue;
        for (int b = 0; b < 2; b++)
            for (int k = 0; k < 3; k++) reach += half[b][k] * fabs(dot(R[b] + 3 * k, n));
        for (int i = 0; i < 3; i++) apart += n[i] * (centre[1][i] - centre[0][i]);
        most = fmax(most, (fabs(apart) - reach) / size);
    }
    return most;
}

/* Boxes of all proportions at all angles. Bars that cross have no corner and no middle in each other. */
static void test_overlaps_are_found(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 5);
    int overlaps = 0, clear = 0;
    for (int trial = 0; trial < draw_count(50000); trial++) {
        double half[2][3], centre[2][3] = {{0}}, R[2][9], size = 0;
        char path[1024], error[256];
        FILE *file = begin(path);
        for (int b = 0; b < 2; b++) {
            draw_frame(&random, R[b]);
            for (int i = 0; i < 3; i++) half[b][i] = draw_log_uniform(&random, 0.003, 0.1);
            for (int i = 0; i < 3 && b; i++) centre[b][i] = draw_uniform(&random, -0.1, 0.1);
            add_box(file, b, half[b], centre[b], R[b], 0, 0);
            for (int i = 0; i < 3; i++) size += half[b][i];
        }
        end(file, path, error, NULL);
        double gap = largest_gap((const double(*)[3])half, (const double(*)[3])centre, R);
        if (gap < -0.01 * size) {
            overlaps++;
            if (!strstr(error, "overlap"))
                fail_msg("trial %d: an overlap of %g m is taken: \"%s\"", trial, -gap, error);
        } else if (gap > 0) {
            clear++;
            if (*error) fail_msg("trial %d: a gap of %g m is refused: %s", trial, gap, error);
        }
    }
    assert_true(overlaps > 0 && clear > 0);
}

/* A block of bricks, each of which touches all its neighbours, turned so that rounding is everywhere. */
static void test_many_pieces_touch(void **state)
{
    (void)state;
    enum { SIDE = 12 };
    static const double half[3] = {0.01, 0.01, 0.01};
    pinch_random random;
    pinch_random_seed(&random, 9);
    char path[1024], error[256];
    double R[9], volume;
    FILE *file = begin(path);
    draw_frame(&random, R);
    for (int k = 0; k < SIDE * SIDE * SIDE; k++) {
        double x[3] = {0};
        const int place[3] = {k % SIDE, k / SIDE % SIDE, k / SIDE / SIDE};
        for (int i = 0; i < 9; i++) x[i % 3] += R[i] * 0.02 * place[i / 3];
        add_box(file, k, half, x, R, 0, 0);
    }
    end(file, path, error, &volume);
    assert_string_equal(error, "");
    assert_close(volume, pow(0.02 * SIDE, 3), 1e-12);
}

static int make_folder(void **state)
{
    (void)state;
    folder = program_make_folder();
    return 0;
}

static int remove_folder(void **state)
{
    (void)state;
    program_remove_folder(folder);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_numbers_end_where_they_end), cmocka_unit_test(test_lines_that_go_on),
        cmocka_unit_test(test_zero_bytes_are_refused),     cmocka_unit_test(test_only_regular_files_are_read),
        cmocka_unit_test(test_open_pieces_are_refused),    cmocka_unit_test(test_overlaps_are_found),
        cmocka_unit_test(test_many_pieces_touch),
    };
    return cmocka_run_group_tests_name("meshes", tests, make_folder, remove_folder);
}
