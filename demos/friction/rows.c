/* From the matrices of a file to rows in coordinates in which the inertia is one. */
#include "friction_solve.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { AXES = 3 };

static command_status no_memory(char *error)
{
    snprintf(error, 512, "out of memory");
    return COMMAND_SYSTEM;
}

/* Room for the contacts, without rows. */
static bool make_contacts(const friction_file *f, friction_rows *rows)
{
    rows->problem.contact_count = f->contacts;
    rows->problem.contacts = calloc((size_t)f->contacts + 1, sizeof *rows->problem.contacts);
    for (int c = 0; c < f->contacts && rows->problem.contacts; c++) {
        pinch_friction_contact *k = &rows->problem.contacts[c];
        k->body[0] = k->body[1] = -1;
        k->friction = f->coefficients[c];
        memcpy(k->free, f->free + c * f->dimension, sizeof *k->free * (size_t)f->dimension);
    }
    return rows->problem.contacts != NULL;
}

/* ---- local problems ---- */

/* A dense W: of more contacts it would take gigabytes. */
enum { MOST_LOCAL = 3000 };

/*
 * Factors the symmetric positive semidefinite a (n x n, destroyed) as L L^T with pivots from the largest on, and writes
 * the columns of L into the rows of `factor`. Returns the rank.
 */
static int factor_semidefinite(int n, double *a, double *factor)
{
    static const double RANK = 1e-13; /* of the largest */
    double largest = 0;
    for (int i = 0; i < n; i++) largest = fmax(largest, a[(size_t)i * (size_t)(n + 1)]);
    for (int rank = 0; rank < n; rank++) {
        int best = 0;
        for (int i = 1; i < n; i++)
            if (a[(size_t)i * (size_t)(n + 1)] > a[(size_t)best * (size_t)(n + 1)]) best = i;
        double pivot = a[(size_t)best * (size_t)(n + 1)], *column = factor + (size_t)rank * (size_t)n;
        if (!(pivot > RANK * largest)) return rank;
        for (int i = 0; i < n; i++) column[i] = a[(size_t)best * (size_t)n + (size_t)i] / sqrt(pivot);
        for (int i = 0; i < n; i++) {
            double *row = a + (size_t)i * (size_t)n;
            for (int j = 0; j < n && column[i] != 0; j++) row[j] -= column[i] * column[j];
        }
        a[(size_t)best * (size_t)(n + 1)] = 0; /* and not what rounding leaves */
    }
    return n;
}

/* The symmetric part of W, dense. */
static double *symmetric_part(const friction_matrix *w)
{
    size_t n = (size_t)w->rows;
    double *a = calloc(n * n + 1, sizeof *a);
    for (size_t k = 0; a && k < w->count; k++) {
        const friction_entry *e = &w->entries[k];
        a[(size_t)e->row * n + (size_t)e->column] += e->value / 2;
        a[(size_t)e->column * n + (size_t)e->row] += e->value / 2;
    }
    return a;
}

static command_status make_local(const friction_file *f, friction_rows *rows, char *error)
{
    int n = f->w.rows, d = f->dimension;
    if (f->contacts > MOST_LOCAL) {
        snprintf(error, 512, "expected at most %d contacts in a local problem", MOST_LOCAL);
        return COMMAND_BAD_INPUT;
    }
    double *a = symmetric_part(&f->w), *factor = malloc(sizeof *factor * ((size_t)n * (size_t)n + 1));
    rows->freedoms = malloc(sizeof *rows->freedoms);
    int rank = a && factor ? factor_semidefinite(n, a, factor) : 0;
    rows->storage = calloc((size_t)f->contacts * AXES * (size_t)rank + 1, sizeof *rows->storage);
    bool made = a && factor && rows->freedoms && rows->storage;
    if (made) {
        *rows->freedoms = rank;
        rows->problem.body_count = rank > 0;
        rows->problem.freedoms = rows->freedoms;
    }
    for (int c = 0; made && rank > 0 && c < f->contacts; c++) {
        double *g = rows->storage + (size_t)c * AXES * (size_t)rank;
        for (int i = 0; i < d; i++)
            for (int k = 0; k < rank; k++)
                g[(size_t)i * (size_t)rank + (size_t)k] = factor[(size_t)k * (size_t)n + (size_t)(c * d + i)];
        rows->problem.contacts[c].body[0] = 0;
        rows->problem.contacts[c].g[0] = g;
    }
    free(a);
    free(factor);
    return made ? COMMAND_DONE : no_memory(error);
}

/* ---- global problems ---- */

/* Parts of M whose freedoms belong together. */
typedef struct parts {
    int *parent;    /* per freedom: a forest whose trees are the parts */
    int *part, *at; /* per freedom: its part, and its place there */
    int *size;      /* per part */
    size_t *start;  /* per part: its block in `block` */
    double *block;  /* of M, then its Cholesky factor, lower */
    double *moved;  /* per freedom: L^-1 f */
} parts;

static int root_of(int *parent, int i)
{
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
}

static void join(int *parent, int a, int b)
{
    a = root_of(parent, a);
    b = root_of(parent, b);
    if (a < b)
        parent[b] = a;
    else
        parent[a] = b;
}

/* Of rigid bodies in space M may be diagonal, or nearly: six freedoms in a row belong together where nothing is coupled
 * across, because the contacts couple them all. In the plane they are three. */
static void join_bodies(const friction_file *f, int *parent)
{
    int size = f->dimension == 3 ? 6 : 3;
    bool apart = f->freedoms % size == 0;
    for (size_t k = 0; k < f->w.count && apart; k++)
        apart = f->w.entries[k].value == 0 || f->w.entries[k].row / size == f->w.entries[k].column / size;
    for (int i = 0; apart && i < f->freedoms; i++) join(parent, i, i / size * size);
}

static int by_column(const void *a, const void *b)
{
    const friction_entry *x = a, *y = b;
    if (x->column != y->column) return x->column < y->column ? -1 : 1;
    return x->row < y->row ? -1 : x->row > y->row;
}

/* A contact moves two parts at most: where it is more, they become one. h is sorted by columns. */
static void join_contacts(const friction_file *f, const friction_entry *h, int *parent)
{
    size_t k = 0;
    for (int c = 0; c < f->contacts; c++) {
        int end = (c + 1) * f->dimension, part[2] = {-1, -1};
        for (; k < f->h.count && h[k].column < end; k++) {
            if (h[k].value == 0) continue;
            int root = root_of(parent, h[k].row);
            for (int s = 0; s < 2; s++) part[s] = part[s] < 0 ? -1 : root_of(parent, part[s]);
            if (root == part[0] || root == part[1]) continue;
            if (part[0] < 0)
                part[0] = root;
            else if (part[1] < 0)
                part[1] = root;
            else
                join(parent, root, part[0]);
        }
    }
}

/* Numbers the parts. Returns how many there are. */
static int number_parts(const friction_file *f, parts *p)
{
    int count = 0;
    for (int i = 0; i < f->freedoms; i++) {
        int root = root_of(p->parent, i);
        if (root == i) {
            p->part[i] = count;
            p->size[count++] = 0;
        }
        p->part[i] = p->part[root]; /* a root is the first of its part */
        p->at[i] = p->size[p->part[i]]++;
    }
    return count;
}

static bool fill_blocks(const friction_file *f, parts *p, int count)
{
    size_t room = 0;
    for (int b = 0; b < count; b++) {
        p->start[b] = room;
        room += (size_t)p->size[b] * (size_t)p->size[b];
    }
    p->block = calloc(room + 1, sizeof *p->block);
    for (size_t k = 0; p->block && k < f->w.count; k++) {
        const friction_entry *e = &f->w.entries[k];
        int b = p->part[e->row];
        if (e->value != 0)
            p->block[p->start[b] + (size_t)p->at[e->row] * (size_t)p->size[b] + (size_t)p->at[e->column]] += e->value;
    }
    return p->block != NULL;
}

/* Cholesky's factor in place of a symmetric block. Returns false where it is not symmetric or not positive definite. */
static bool factor_block(int n, double *a)
{
    static const double EVEN = 1e-9;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < i; j++)
            if (!(fabs(a[i * n + j] - a[j * n + i]) <= EVEN * sqrt(fabs(a[i * n + i] * a[j * n + j])))) return false;
    for (int j = 0; j < n; j++) {
        for (int i = j; i < n; i++) {
            double sum = a[i * n + j];
            for (int k = 0; k < j; k++) sum -= a[i * n + k] * a[j * n + k];
            if (i == j && !(sum > 0)) return false;
            a[i * n + j] = i == j ? sqrt(sum) : sum / a[j * n + j];
        }
    }
    return true;
}

/* x = L^-1 x */
static void solve_lower(int n, const double *l, double *x)
{
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++) x[i] -= l[i * n + k] * x[k];
        x[i] /= l[i * n + i];
    }
}

/* Writes G = (L^-1 H)^T and q + G L^-1 f. h is sorted by columns. */
static bool write_rows(const friction_file *f, const friction_entry *h, parts *p, friction_rows *rows)
{
    int d = f->dimension;
    size_t room = 0, k = 0;
    for (int c = 0; c < f->contacts; c++) {
        pinch_friction_contact *contact = &rows->problem.contacts[c];
        for (; k < f->h.count && h[k].column < (c + 1) * d; k++) {
            int b = p->part[h[k].row], s = contact->body[0] < 0 || contact->body[0] == b ? 0 : 1;
            if (h[k].value == 0 || contact->body[s] == b) continue;
            contact->body[s] = b;
            room += AXES * (size_t)p->size[b];
        }
    }
    double *next = rows->storage = calloc(room + 1, sizeof *rows->storage);
    if (!next) return false;
    k = 0;
    for (int c = 0; c < f->contacts; c++) {
        pinch_friction_contact *contact = &rows->problem.contacts[c];
        double *g[2] = {next, contact->body[0] < 0 ? next : next + AXES * p->size[contact->body[0]]};
        for (int s = 0; s < 2; s++) {
            if (contact->body[s] < 0) continue;
            contact->g[s] = g[s];
            next += AXES * p->size[contact->body[s]];
        }
        for (; k < f->h.count && h[k].column < (c + 1) * d; k++) {
            if (h[k].value == 0) continue;
            int b = p->part[h[k].row], s = contact->body[0] == b ? 0 : 1;
            g[s][(h[k].column - c * d) * p->size[b] + p->at[h[k].row]] += h[k].value;
        }
        for (int s = 0; s < 2; s++) {
            int b = contact->body[s], size = b < 0 ? 0 : p->size[b];
            for (int i = 0; i < d && size > 0; i++) {
                solve_lower(size, p->block + p->start[b], g[s] + i * size);
                for (int j = 0; j < size; j++) contact->free[i] += g[s][i * size + j] * p->moved[rows->freedoms[b] + j];
            }
        }
    }
    return true;
}

static command_status write_global(const friction_file *f, friction_entry *h, parts *p, friction_rows *rows,
                                   char *error)
{
    qsort(h, f->h.count, sizeof *h, by_column);
    for (int i = 0; i < f->freedoms; i++) p->parent[i] = i;
    join_bodies(f, p->parent);
    for (size_t k = 0; k < f->w.count; k++)
        if (f->w.entries[k].value != 0) join(p->parent, f->w.entries[k].row, f->w.entries[k].column);
    join_contacts(f, h, p->parent);
    int count = number_parts(f, p);
    if (!fill_blocks(f, p, count)) return no_memory(error);
    int first = 0;
    for (int b = 0; b < count; b++) {
        if (!factor_block(p->size[b], p->block + p->start[b])) {
            snprintf(error, 512, "expected a mass matrix that is symmetric and positive definite");
            return COMMAND_BAD_INPUT;
        }
        rows->freedoms[b] = first; /* for now: where it begins */
        first += p->size[b];
    }
    for (int i = 0; i < f->freedoms; i++) p->moved[rows->freedoms[p->part[i]] + p->at[i]] = f->force[i];
    for (int b = 0; b < count; b++) solve_lower(p->size[b], p->block + p->start[b], p->moved + rows->freedoms[b]);
    if (!write_rows(f, h, p, rows)) return no_memory(error);
    memcpy(rows->freedoms, p->size, sizeof *p->size * (size_t)count);
    rows->problem.body_count = count;
    rows->problem.freedoms = rows->freedoms;
    return COMMAND_DONE;
}

static command_status make_global(const friction_file *f, friction_rows *rows, char *error)
{
    size_t n = (size_t)f->freedoms + 1;
    parts p = {.parent = malloc(4 * n * sizeof *p.parent),
               .start = malloc(n * sizeof *p.start),
               .moved = calloc(n, sizeof *p.moved)};
    friction_entry *h = malloc((f->h.count + 1) * sizeof *h);
    rows->freedoms = malloc(n * sizeof *rows->freedoms);
    command_status status = COMMAND_SYSTEM;
    if (p.parent && p.start && p.moved && h && rows->freedoms) {
        p.part = p.parent + n;
        p.at = p.part + n;
        p.size = p.at + n;
        memcpy(h, f->h.entries, f->h.count * sizeof *h);
        status = write_global(f, h, &p, rows, error);
    } else {
        status = no_memory(error);
    }
    free(p.parent);
    free(p.start);
    free(p.block);
    free(p.moved);
    free(h);
    return status;
}

command_status friction_rows_make(const friction_file *file, friction_rows *rows, char *error)
{
    memset(rows, 0, sizeof *rows);
    command_status status = COMMAND_SYSTEM;
    if (make_contacts(file, rows))
        status = file->global ? make_global(file, rows, error) : make_local(file, rows, error);
    else
        status = no_memory(error);
    if (status != COMMAND_DONE) friction_rows_free(rows);
    return status;
}

void friction_rows_free(friction_rows *rows)
{
    free(rows->problem.contacts);
    free(rows->storage);
    free(rows->freedoms);
    memset(rows, 0, sizeof *rows);
}
