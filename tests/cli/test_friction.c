/*
 * The real `pinch friction` on files of FCLIB that are written here: closed forms, the same problem in both forms,
 * matrices in every way of storing them, files that are damaged. With PINCH_TEST_FCLIB=FOLDER it also solves the files
 * of the collection that lie there.
 */
#define _POSIX_C_SOURCE 200809L

#include "support/cmocka_all.h"

#include "support/command.h"
#include "support/draw.h"
#include "support/schema.h"

#include <dirent.h>
#include <fclib.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

enum { AXES = 3, BODIES = 5, FREEDOMS = 6 * BODIES, CONTACTS = 3 * BODIES, ROWS = AXES * CONTACTS };

/* How a matrix is stored: by columns, by rows, entry by entry as the collection does it and as FCLIB's header says. */
typedef enum storage { BY_COLUMNS = -1, BY_ROWS = -2, BY_ENTRIES = 0, BY_ENTRIES_AS_DESCRIBED = 1 } storage;

typedef struct stored {
    struct fclib_matrix matrix;
    struct fclib_matrix_info info;
} stored;

static void store(int rows, int columns, const double *dense, storage how, stored *s)
{
    char none[] = "none";
    int count = 0, lines = how == BY_ROWS ? rows : columns, others = how == BY_ROWS ? columns : rows;
    struct fclib_matrix *m = &s->matrix;
    memset(s, 0, sizeof *s);
    s->info.comment = strdup(none);
    *m = (struct fclib_matrix){.m = rows, .n = columns, .info = &s->info};
    m->p = calloc((size_t)(rows * columns + 1), sizeof *m->p);
    m->i = calloc((size_t)(rows * columns + 1), sizeof *m->i);
    m->x = calloc((size_t)(rows * columns + 1), sizeof *m->x);
    assert_true(m->p && m->i && m->x && s->info.comment);
    for (int line = 0; line < lines; line++) {
        for (int other = 0; other < others; other++) {
            int row = how == BY_ROWS ? line : other, column = how == BY_ROWS ? other : line;
            double x = dense[row * columns + column];
            if (x == 0) continue;
            m->x[count] = x;
            m->i[count] = how < 0 ? other : how == BY_ENTRIES ? row : column;
            if (how >= 0) m->p[count] = how == BY_ENTRIES ? column : row;
            count++;
        }
        if (how < 0) m->p[line + 1] = count;
    }
    m->nzmax = count;
    m->nz = how < 0 ? (int)how : count;
}

static void release(stored *s)
{
    free(s->matrix.p);
    free(s->matrix.i);
    free(s->matrix.x);
    free(s->info.comment);
}

/* Bodies that fall onto each other and onto a floor. */
typedef struct pile {
    double mass[FREEDOMS * FREEDOMS], h[FREEDOMS * ROWS], force[FREEDOMS], free[ROWS], mu[CONTACTS];
    double w[ROWS * ROWS], q[ROWS]; /* the same as a local problem */
} pile;

static void draw_pile(uint64_t seed, pile *p)
{
    pinch_random random;
    pinch_random_seed(&random, seed);
    memset(p, 0, sizeof *p);
    for (int i = 0; i < FREEDOMS; i++) {
        p->mass[i * FREEDOMS + i] = i % 6 < 3 ? 2 : 0.1;
        p->force[i] = p->mass[i * FREEDOMS + i] * (draw_uniform(&random, -0.5, 0.5) - (i % 6 == 0));
    }
    for (int c = 0; c < CONTACTS; c++) {
        int body = c / 3, other = c % 3 && body > 0 ? draw_index(&random, body) : -1;
        p->mu[c] = draw_uniform(&random, 0.1, 1);
        for (int s = 0; s < 2; s++) {
            int of = s ? other : body;
            double arm[AXES], sign = s ? -1 : 1;
            for (int i = 0; i < AXES && of >= 0; i++) arm[i] = draw_uniform(&random, -0.3, 0.3);
            for (int i = 0; i < AXES && of >= 0; i++) {
                int j = (i + 1) % AXES, l = (i + 2) % AXES;
                p->h[(6 * of + i) * ROWS + AXES * c + i] = sign;
                p->h[(6 * of + 3 + j) * ROWS + AXES * c + i] = sign * arm[l];
                p->h[(6 * of + 3 + l) * ROWS + AXES * c + i] = -sign * arm[j];
            }
        }
    }
    for (int a = 0; a < ROWS; a++)
        for (int k = 0; k < FREEDOMS; k++) {
            double over = p->h[k * ROWS + a] / p->mass[k * FREEDOMS + k];
            p->q[a] += over * p->force[k];
            for (int b = 0; b < ROWS; b++) p->w[a * ROWS + b] += over * p->h[k * ROWS + b];
        }
}

static void write_local(const char *path, int rows, const double *w, double *q, double *mu, storage how)
{
    stored s;
    char none[] = "none";
    struct fclib_info info = {none, none, none};
    store(rows, rows, w, how, &s);
    struct fclib_local problem = {.W = &s.matrix, .mu = mu, .q = q, .spacedim = AXES, .info = &info};
    remove(path);
    assert_int_equal(fclib_write_local(&problem, path), 1);
    release(&s);
}

static void write_global(const char *path, pile *p, storage how)
{
    stored mass, h;
    char none[] = "none";
    struct fclib_info info = {none, none, none};
    store(FREEDOMS, FREEDOMS, p->mass, how, &mass);
    store(FREEDOMS, ROWS, p->h, how, &h);
    struct fclib_global problem = {
        .M = &mass.matrix, .H = &h.matrix, .mu = p->mu, .f = p->force, .w = p->free, .spacedim = AXES, .info = &info};
    remove(path);
    assert_int_equal(fclib_write_global(&problem, path), 1);
    release(&mass);
    release(&h);
}

/* Runs the command. Returns its document, which follows the schema. */
static json_t *solve(const char *path, int status)
{
    program_result r = PINCH(NULL, "friction", path, "--json");
    if (r.status != status) print_error("%s: status %d, %s\n", path, r.status, r.err);
    assert_int_equal(r.status, status);
    json_t *document = cli_document(&r);
    json_t *schema = json_load_file(PINCH_SOURCE_DIR "/assets/schema/pinch-friction-1.json", 0, NULL);
    assert_int_equal(schema_faults(schema, document), 0);
    json_decref(schema);
    program_free(&r);
    return document;
}

static double at(const json_t *document, int contact, const char *what, int axis)
{
    const json_t *one = json_array_get(json_object_get(document, "contacts"), (size_t)contact);
    return json_number_value(json_array_get(json_object_get(one, what), (size_t)axis));
}

static void test_point(void **state)
{
    (void)state;
    char *folder = program_make_folder(), path[512];
    snprintf(path, sizeof path, "%s/point.hdf5", folder);
    double w[9] = {0.5, 0, 0, 0, 0.5, 0, 0, 0, 0.5}, q[3] = {-1, 2, 0}, mu = 0.5; /* 2 kg that slip */
    write_local(path, AXES, w, q, &mu, BY_COLUMNS);
    json_t *d = solve(path, 0);
    assert_close(at(d, 0, "impulse", 0), 2, 1e-7);
    assert_close(at(d, 0, "impulse", 1), -1, 1e-7);
    assert_close(at(d, 0, "velocity", 1), 1.5, 1e-7);
    json_decref(d);
    program_remove_folder(folder);
}

/* FCLIB's own measure of what the command answers. It takes matrices by columns. */
static double judged_by_fclib(pile *p, const json_t *document)
{
    stored s;
    double r[ROWS], u[ROWS];
    for (int i = 0; i < ROWS; i++) {
        r[i] = at(document, i / AXES, "impulse", i % AXES);
        u[i] = at(document, i / AXES, "velocity", i % AXES);
    }
    store(ROWS, ROWS, p->w, BY_COLUMNS, &s);
    struct fclib_local problem = {.W = &s.matrix, .mu = p->mu, .q = p->q, .spacedim = AXES};
    struct fclib_solution solution = {.u = u, .r = r};
    double merit = fclib_merit_local(&problem, MERIT_1, &solution);
    release(&s);
    return merit;
}

static void test_piles(void **state)
{
    (void)state;
    static const storage ways[] = {BY_COLUMNS, BY_ROWS, BY_ENTRIES, BY_ENTRIES_AS_DESCRIBED};
    char *folder = program_make_folder(), path[512];
    static pile p;
    int count = draw_count(1000);
    snprintf(path, sizeof path, "%s/pile.hdf5", folder);
    for (int i = 0; i < count; i++) {
        draw_pile((uint64_t)i + 1, &p);
        write_local(path, ROWS, p.w, p.q, p.mu, ways[i % 3]);
        json_t *local = solve(path, 0);
        assert_true(judged_by_fclib(&p, local) < 1e-7);
        write_global(path, &p, ways[i % 4]);
        json_t *global = solve(path, 0);
        assert_true(judged_by_fclib(&p, global) < 1e-7);
        assert_string_equal(json_string_value(json_object_get(local, "problem")), "local");
        assert_string_equal(json_string_value(json_object_get(global, "problem")), "global");
        json_decref(local);
        json_decref(global);
        /* a W that is not symmetric, as that of a simulation with gyroscopic forces */
        for (int a = 0; a < ROWS; a++)
            for (int b = 0; b < a; b++) p.w[a * ROWS + b] *= 1.001;
        write_local(path, ROWS, p.w, p.q, p.mu, ways[i % 3]);
        json_t *uneven = solve(path, 0);
        assert_true(json_integer_value(json_object_get(uneven, "corrections")) > 0);
        assert_true(judged_by_fclib(&p, uneven) < 1e-7);
        json_decref(uneven);
    }
    program_remove_folder(folder);
}

static void refused(const char *path, const char *says)
{
    cli_refused(PINCH(NULL, "friction", path), 2, says);
}

static void test_refusals(void **state)
{
    (void)state;
    char *folder = program_make_folder(), path[512];
    static pile p;
    snprintf(path, sizeof path, "%s/bad.hdf5", folder);
    refused(path, "No such file");
    refused(folder, "directory");
    assert_int_equal(mkfifo(path, 0600), 0);
    refused(path, "pipe");
    remove(path);
    free(program_write_file(folder, "bad.hdf5", "HDF5"));
    refused(path, "fclib_local");
    double w[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, q[3] = {-1, NAN, 0}, mu = -1;
    write_local(path, AXES, w, q, &mu, BY_ROWS);
    refused(path, "finite");
    q[1] = 0;
    write_local(path, AXES, w, q, &mu, BY_ROWS);
    refused(path, "friction of at least 0");
    mu = 0.5;
    w[4] = INFINITY;
    write_local(path, AXES, w, q, &mu, BY_ENTRIES);
    refused(path, "finite");
    draw_pile(1, &p);
    p.mass[0] = -1;
    write_global(path, &p, BY_COLUMNS);
    refused(path, "positive definite");
    draw_pile(1, &p);
    p.mass[1] = 0.5; /* and not the other way */
    write_global(path, &p, BY_COLUMNS);
    refused(path, "symmetric");
    /* no impulse stops what a contact cannot move: no answer, and said so */
    memset(w, 0, sizeof w);
    write_local(path, AXES, w, q, &mu, BY_COLUMNS);
    program_result r = PINCH(NULL, "friction", path);
    assert_int_equal(r.status, 1);
    assert_null(strstr(r.out, "converged"));
    program_free(&r);
    program_remove_folder(folder);
}

/* Damaged files are refused, or read as another problem; nothing crashes. One that makes FCLIB ask for more memory than
 * there is cannot be told from memory that has run out: that is a failure of the system. */
static void test_damage(void **state)
{
    (void)state;
    char *folder = program_make_folder(), path[512];
    static pile p;
    pinch_random random;
    pinch_random_seed(&random, 5);
    snprintf(path, sizeof path, "%s/bad.hdf5", folder);
    for (int i = 0; i < draw_count(3000); i++) {
        draw_pile(3, &p);
        if (i % 2)
            write_global(path, &p, BY_COLUMNS);
        else
            write_local(path, ROWS, p.w, p.q, p.mu, BY_ROWS);
        struct stat status;
        assert_int_equal(stat(path, &status), 0);
        FILE *file = fopen(path, "r+b");
        assert_non_null(file);
        for (int k = 0; k < 40; k++) {
            fseek(file, (long)(pinch_random_uniform(&random) * (double)status.st_size), SEEK_SET);
            fputc(draw_index(&random, 256), file);
        }
        fclose(file);
        program_result r = PINCH(NULL, "friction", path);
        bool too_much = r.status == 3 && strstr(r.err, "the file asks for more than there is");
        if (r.status > 2 && !too_much) print_error("status %d: %s\n", r.status, r.err);
        assert_true((r.status <= 2 || too_much) && (r.status < 2 || strchr(r.err, '\n') == r.err + strlen(r.err) - 1));
        program_free(&r);
    }
    program_remove_folder(folder);
}

static void test_collection(void **state)
{
    (void)state;
    const char *place = getenv("PINCH_TEST_FCLIB");
    DIR *folder = place ? opendir(place) : NULL;
    for (struct dirent *entry = folder ? readdir(folder) : NULL; entry; entry = readdir(folder)) {
        char path[1024];
        if (!strstr(entry->d_name, ".hdf5")) continue;
        snprintf(path, sizeof path, "%s/%s", place, entry->d_name);
        program_result r = PINCH(NULL, "friction", path);
        print_message("%s: %s%s", entry->d_name, r.out, r.err);
        assert_true(r.status <= 2);
        program_free(&r);
    }
    if (folder) closedir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_point),  cmocka_unit_test(test_piles),      cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_damage), cmocka_unit_test(test_collection),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
