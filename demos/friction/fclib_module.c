/* The module that is linked with FCLIB. It runs in a process of its own. */
#define _POSIX_C_SOURCE 200809L

#include "fclib_link.h"
#include "problem_file.h"

#include "common/pipe.h"

#include <errno.h>
#include <fclib.h>
#include <stdio.h>
#include <string.h>

/* FCLIB stores columns (nz = -1), rows (-2) or single entries, of which there are nz. */
static int count_of(const struct fclib_matrix *m)
{
    return m->nz >= 0 ? m->nz : m->p[m->nz == -1 ? m->n : m->m];
}

/* Do the rows of single entries stand in p? FCLIB's description says so, but the collection's files have them in i. */
static bool rows_in_p(const struct fclib_matrix *m)
{
    bool fits = true;
    for (int k = 0; k < m->nz; k++) fits = fits && m->i[k] < m->m && m->p[k] < m->n;
    return !fits;
}

static bool send_matrix(int to, const struct fclib_matrix *m)
{
    bool sent = true;
    if (m->nz >= 0) {
        bool described = rows_in_p(m);
        for (int k = 0; k < m->nz && sent; k++) {
            friction_entry e = {described ? m->p[k] : m->i[k], described ? m->i[k] : m->p[k], m->x[k]};
            sent = pipe_send(to, &e, sizeof e);
        }
        return sent;
    }
    int lines = m->nz == -1 ? m->n : m->m;
    for (int line = 0; line < lines; line++)
        for (int k = m->p[line]; k < m->p[line + 1] && sent; k++) {
            friction_entry e = {m->nz == -1 ? m->i[k] : line, m->nz == -1 ? line : m->i[k], m->x[k]};
            sent = pipe_send(to, &e, sizeof e);
        }
    return sent;
}

static bool refuse(int to, const char *what)
{
    fclib_head head;
    memset(&head, 0, sizeof head);
    snprintf(head.error, sizeof head.error, "%s", what);
    return pipe_send(to, &head, sizeof head);
}

static bool send_local(int to, const struct fclib_local *p)
{
    fclib_head head;
    memset(&head, 0, sizeof head);
    if ((p->V && p->V->n > 0) || (p->R && p->R->n > 0))
        return refuse(to, "expected a problem without bilateral constraints (V, R)");
    if (p->spacedim < 2 || p->spacedim > 3) return refuse(to, "expected a problem in 2 or 3 dimensions");
    head.dimension = p->spacedim;
    head.contacts = p->W->m / p->spacedim;
    head.w_size = p->W->m;
    head.w_count = count_of(p->W);
    return pipe_send(to, &head, sizeof head) && send_matrix(to, p->W) &&
           pipe_send(to, p->q, sizeof(double) * (size_t)p->W->m) &&
           pipe_send(to, p->mu, sizeof(double) * (size_t)head.contacts);
}

static bool send_global(int to, const struct fclib_global *p)
{
    fclib_head head;
    memset(&head, 0, sizeof head);
    if (p->G && p->G->n > 0) return refuse(to, "expected a problem without equality constraints (G)");
    if (p->spacedim < 2 || p->spacedim > 3) return refuse(to, "expected a problem in 2 or 3 dimensions");
    head.global = true;
    head.dimension = p->spacedim;
    head.contacts = p->H->n / p->spacedim;
    head.w_size = head.freedoms = p->M->m;
    head.h_rows = p->H->m;
    head.h_columns = p->H->n;
    head.w_count = count_of(p->M);
    head.h_count = count_of(p->H);
    return pipe_send(to, &head, sizeof head) && send_matrix(to, p->M) && send_matrix(to, p->H) &&
           pipe_send(to, p->w, sizeof(double) * (size_t)p->H->n) &&
           pipe_send(to, p->f, sizeof(double) * (size_t)p->M->m) &&
           pipe_send(to, p->mu, sizeof(double) * (size_t)head.contacts);
}

__attribute__((visibility("default"))) bool pinch_fclib_send(const char *path, int to);

bool pinch_fclib_send(const char *path, int to)
{
    struct fclib_local *local = fclib_read_local(path);
    if (local) return send_local(to, local);
    struct fclib_global *global = errno == ENOMEM ? NULL : fclib_read_global(path);
    if (global) return send_global(to, global);
    if (errno == ENOMEM) return false;
    return refuse(to, "expected a file of FCLIB with a problem fclib_local or fclib_global");
}
