#include "kinematics/joint_space.h"

#include "support/dense.h"
#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* A joint turns all that hangs from it: with the number of joints from root to leaf the condition of the inertia grows
 * with its fourth power. Hands and arms have up to a dozen. */
enum { DEEPEST = 12 };

/* Places the bodies and gives them their hard rows. Returns false where these make no tree, or one that is too deep. */
static bool place_bodies(const pinch_tree_search *s, pinch_space_members of, pinch_tree_rows rows,
                         pinch_joint_space *space)
{
    space->freedoms = 6 * space->count;
    for (int place = 0; place < space->count; place++) {
        pinch_space_body *b = &space->bodies[place];
        b->body = of.bodies[s->slot[place]];
        b->parent = s->parent[place];
        b->end = place + 1;
        b->hard = 0;
        int deep = 1;
        for (int above = b->parent; above >= 0; above = s->parent[above], deep++) space->bodies[above].end = place + 1;
        if (deep > DEEPEST) return false;
    }
    for (const pinch_row_run *run = s->runs; run < s->runs + s->run_count; run++) {
        int owner = pinch_tree_owner(s, run);
        if (owner < 0 || space->bodies[owner].hard + run->count > 6) return false;
        for (int k = 0; k < run->count; k++)
            space->bodies[owner].row[space->bodies[owner].hard++] = rows.index[run->first + k];
        space->freedoms -= run->count;
    }
    return true;
}

/* Numbers the directions, those of the last bodies first. */
static void number_directions(pinch_joint_space *space)
{
    int index = 0;
    for (int place = space->count - 1; place >= 0; place--) {
        space->bodies[place].first_direction = index;
        index += 6 - space->bodies[place].hard;
    }
}

/* Returns the first of the directions that move a body, or -1: nothing does. */
static int first_moving(const pinch_joint_space *space, int place)
{
    while (place >= 0 && space->bodies[place].hard == 6) place = space->bodies[place].parent;
    return place < 0 ? -1 : space->bodies[place].first_direction;
}

/* Lists for each direction the next one that moves its body. */
static void list_above(pinch_joint_space *space)
{
    for (int place = 0; place < space->count; place++) {
        const pinch_space_body *b = &space->bodies[place];
        for (int k = b->hard, f = b->first_direction; k < 6; k++, f++)
            space->above[f] = k < 5 ? f + 1 : first_moving(space, b->parent);
    }
}

/* momentum = M v of one body */
static void momentum_of(const pinch_body *body, const double *v, double *momentum)
{
    const double *I = body->inertia; /* symmetric */
    for (int i = 0; i < 3; i++) momentum[i] = body->mass * v[i];
    pinch_lanes_put(v[3] * pinch_lanes_at(I) + v[4] * pinch_lanes_at(I + 3) + v[5] * pinch_lanes_at(I + 6),
                    momentum + 3);
    momentum[5] = I[6] * v[3] + I[7] * v[4] + I[8] * v[5];
}

/* y = the motion of a body with its parent's, x */
static void carry(const pinch_space_body *b, const double *x, double *y)
{
    if (b->pinned) {
        const double *a = b->lever[0], *c = b->lever[1], *d = b->lever[2];
        pinch_lanes_put(
            pinch_lanes_at(x) + x[3] * pinch_lanes_at(a) + x[4] * pinch_lanes_at(c) + x[5] * pinch_lanes_at(d), y);
        y[2] = x[2] + x[3] * a[2] + x[4] * c[2] + x[5] * d[2];
        pinch_v3_copy(y + 3, x + 3);
        return;
    }
    for (int i = 0; i < 6; i++) y[i] = x[0] * b->carried[0][i];
    for (int k = 1; k < 6; k++) pinch_add_multiple6(x[k], b->carried[k], y);
}

/* Vectors of six components a body, per direction: how it moves the bodies at a rate of one, and their momenta. */
typedef struct motions {
    size_t size; /* 6 count */
    double *way, *momentum;
} motions;

static void follow_directions(const pinch_problem *problem, const pinch_joint_space *space, const motions *m)
{
    for (int place = 0; place < space->count; place++) {
        const pinch_space_body *b = &space->bodies[place];
        const pinch_body *body = &problem->bodies[b->body];
        int own = 6 - b->hard;
        for (int f = first_moving(space, place); f >= 0; f = space->above[f]) {
            double *way = m->way + (size_t)f * m->size + 6 * place;
            int k = f - b->first_direction;
            if (k >= 0 && k < own)
                memcpy(way, b->unit[b->hard + k], sizeof b->unit[0]);
            else
                carry(b, m->way + (size_t)f * m->size + 6 * b->parent, way);
            momentum_of(body, way, m->momentum + (size_t)f * m->size + 6 * place);
        }
    }
}

/* a . b over the bodies from one place to before another one, of vectors of six components a body */
static double dot_bodies(const double *a, const double *b, int first, int end)
{
    pinch_lanes sum = {0, 0};
    for (const double *last = a + 6 * end, *x = a + 6 * first, *y = b + 6 * first; x < last; x += 6, y += 6)
        sum += pinch_lanes_at(x) * pinch_lanes_at(y) + pinch_lanes_at(x + 2) * pinch_lanes_at(y + 2) +
               pinch_lanes_at(x + 4) * pinch_lanes_at(y + 4);
    return sum[0] + sum[1];
}

/* The inertia is scaled so that its diagonal is 1. Returns false where that cannot be. */
static bool find_inertia(pinch_joint_space *space, const motions *m)
{
    size_t n = (size_t)space->freedoms;
    double *H = space->inertia;
    memset(H, 0, n * n * sizeof *H);
    for (int place = 0; place < space->count; place++) {
        const pinch_space_body *b = &space->bodies[place];
        for (int k = b->hard, g = b->first_direction; k < 6; k++, g++)
            for (int f = g; f >= 0; f = space->above[f])
                H[(size_t)g * n + (size_t)f] =
                    dot_bodies(m->way + (size_t)f * m->size, m->momentum + (size_t)g * m->size, place, b->end);
    }
    for (size_t f = 0; f < n; f++) {
        if (!(H[f * n + f] > 0)) return false;
        space->scale[f] = 1 / sqrt(H[f * n + f]);
    }
    for (int g = 0; g < space->freedoms; g++) {
        H[(size_t)g * (n + 1)] = 1;
        for (int f = space->above[g]; f >= 0; f = space->above[f]) {
            double value = H[(size_t)g * n + (size_t)f] * space->scale[g] * space->scale[f];
            H[(size_t)g * n + (size_t)f] = H[(size_t)f * n + (size_t)g] = value;
        }
    }
    return true;
}

/* Factors the inertia, the leaves first, where nothing fills in (Featherstone, "Efficient factorization of the
 * joint-space inertia matrix for branched kinematic trees", 2005). Returns false where it is not positive definite. */
static bool factor_inertia(pinch_joint_space *space)
{
    size_t n = (size_t)space->freedoms;
    double *L = space->factor;
    const int *above = space->above;
    memcpy(L, space->inertia, n * n * sizeof *L);
    for (size_t k = 0; k < n; k++) {
        if (!(L[k * n + k] > 1e-12)) return false;
        double over = 1 / L[k * n + k];
        for (int i = above[k]; i >= 0; i = above[i]) {
            double factor = L[k * n + (size_t)i] * over;
            for (int j = i; j >= 0; j = above[j]) L[(size_t)i * n + (size_t)j] -= factor * L[k * n + (size_t)j];
            L[k * n + (size_t)i] = factor;
        }
    }
    return true;
}

/*
 * Finds a motion that the joints admit, with v* + moves as the bodies' velocities: the hard rows get what they ask for,
 * and the rates are as they were. What it changes in the momenta along the directions goes into `moved`.
 */
static void move_by_rows(const pinch_problem *problem, const pinch_joint_space *space, const motions *m, double *moves,
                         double *momentum)
{
    for (int place = 0; place < space->count; place++) {
        const pinch_space_body *b = &space->bodies[place];
        double *to = moves + 6 * place;
        memset(to, 0, 6 * sizeof *to);
        if (b->parent >= 0) carry(b, moves + 6 * b->parent, to);
        for (int k = 0; k < 6 && b->row[k] >= 0; k++) {
            const pinch_joint_row *row = &problem->rows[b->row[k]];
            double rate = 0;
            if (row->body1 >= 0) rate += pinch_dot6(row->j1, problem->bodies[row->body1].velocity);
            if (row->body2 >= 0) rate += pinch_dot6(row->j2, problem->bodies[row->body2].velocity);
            if (k >= b->hard) {
                space->speed[b->first_direction + k - b->hard] = rate;
                continue;
            }
            pinch_add_multiple6(row->rhs - rate, b->unit[k], to);
        }
        momentum_of(&problem->bodies[b->body], to, momentum + 6 * place);
    }
    for (int place = 0; place < space->count; place++) {
        const pinch_space_body *b = &space->bodies[place];
        for (int k = b->hard, f = b->first_direction; k < 6; k++, f++)
            space->moved[f] = space->scale[f] * dot_bodies(m->way + (size_t)f * m->size, momentum, place, b->end);
    }
}

static pinch_joint_space *allocate(pinch_arena *arena, int count)
{
    pinch_joint_space *space = PINCH_ARENA_ARRAY(arena, pinch_joint_space, 1);
    if (!space) return NULL;
    space->count = count;
    space->bodies = PINCH_ARENA_ARRAY(arena, pinch_space_body, count);
    return arena->failed ? NULL : space;
}

static bool allocate_directions(pinch_arena *arena, pinch_joint_space *space, motions *m)
{
    size_t n = (size_t)space->freedoms;
    m->size = 6 * (size_t)space->count;
    m->way = space->way = PINCH_ARENA_ARRAY(arena, double, n * m->size + 1);
    m->momentum = PINCH_ARENA_ARRAY(arena, double, (n + 1) * m->size); /* one at least, for moves */
    space->moves = PINCH_ARENA_ARRAY(arena, double, m->size);
    space->scale = PINCH_ARENA_ARRAY(arena, double, n + 1);
    space->speed = PINCH_ARENA_ARRAY(arena, double, n + 1);
    space->moved = PINCH_ARENA_ARRAY(arena, double, n + 1);
    space->inertia = PINCH_ARENA_ARRAY(arena, double, n *n + 1);
    space->factor = PINCH_ARENA_ARRAY(arena, double, n *n + 1);
    space->above = PINCH_ARENA_ARRAY(arena, int, n + 1);
    return !arena->failed;
}

/* Fills in the space of bodies that are in their places. Returns false as pinch_joint_space_build does. */
static bool find_motions(pinch_arena *arena, const pinch_problem *problem, pinch_joint_space *space,
                         pinch_loose_rows *loose)
{
    motions m;
    for (int place = 0; place < space->count; place++) {
        pinch_space_body *b = &space->bodies[place];
        if (!pinch_space_body_coordinates(problem, space->bodies, loose, b) || !pinch_space_body_solve(problem, b))
            return false;
    }
    if (!allocate_directions(arena, space, &m)) return false;
    list_above(space);
    follow_directions(problem, space, &m);
    if (!find_inertia(space, &m) || !factor_inertia(space)) return false;
    move_by_rows(problem, space, &m, space->moves, m.momentum);
    return true;
}

pinch_joint_space *pinch_joint_space_build(pinch_arena *arena, const pinch_problem *problem, pinch_space_members of,
                                           pinch_tree_rows rows, pinch_loose_rows *loose)
{
    pinch_tree_search s;
    pinch_joint_space *space = allocate(arena, of.count);
    int *scratch = PINCH_ARENA_ARRAY(arena, int, 3 * of.count);
    if (!pinch_tree_find(arena, problem, of.count, of.slot_of, rows, &s)) return NULL;
    pinch_tree_put_subtrees_together(&s, scratch);
    if (!place_bodies(&s, of, rows, space)) return NULL;
    number_directions(space);
    if (!find_motions(arena, problem, space, loose)) {
        pinch_space_forget_rates(problem, space, loose);
        return NULL;
    }
    for (int place = 0; place < of.count; place++) {
        of.bodies[place] = space->bodies[place].body;
        of.slot_of[of.bodies[place]] = place;
    }
    return space;
}

void pinch_joint_space_v0(const pinch_joint_space *space, const pinch_problem *problem, double *v0)
{
    for (int place = 0; place < space->count; place++) {
        const double *v = problem->bodies[space->bodies[place].body].velocity;
        for (int i = 6 * place; i < 6 * place + 6; i++) v0[i] = v[i - 6 * place] + space->moves[i];
    }
}

/* How direction f moves the body at a place at a rate of one. */
static const double *way_of(const pinch_joint_space *space, int f, int place)
{
    return space->way + 6 * ((size_t)f * (size_t)space->count + (size_t)place);
}

void pinch_joint_space_add_velocity(const pinch_joint_space *space, int place, const double *x, double *v)
{
    for (int f = first_moving(space, place); f >= 0; f = space->above[f])
        pinch_add_multiple6(space->scale[f] * x[f], way_of(space, f, place), v);
}

void pinch_joint_space_reduce(const pinch_joint_space *space, int place, int rows, const double *jacobian, double sign,
                              double *g)
{
    for (int f = first_moving(space, place); f >= 0; f = space->above[f]) {
        const double *way = way_of(space, f, place), scale = sign * space->scale[f];
        for (int row = 0; row < rows; row++)
            g[row * space->freedoms + f] += scale * pinch_dot6(jacobian + 6 * row, way);
    }
}

void pinch_joint_space_add_size(const pinch_joint_space *space, int place, double h, const double *wrench, double *size)
{
    for (int f = first_moving(space, place); f >= 0; f = space->above[f])
        size[f] += fabs(h * space->scale[f] * pinch_dot6(wrench, way_of(space, f, place)));
}

void pinch_joint_space_add_coupling(const pinch_joint_space *space, const double *x, double *y)
{
    size_t n = (size_t)space->freedoms;
    for (size_t g = 0; g < n; g++) {
        const double *row = space->inertia + g * n;
        double sum = 0;
        for (int f = space->above[g]; f >= 0; f = space->above[f]) {
            sum += row[f] * x[f];
            y[f] += row[f] * x[g];
        }
        y[g] += sum;
    }
}

void pinch_joint_space_solve(const pinch_joint_space *space, double *x)
{
    size_t n = (size_t)space->freedoms;
    for (size_t k = 0; k < n; k++) {
        const double *row = space->factor + k * n;
        for (int i = space->above[k]; i >= 0; i = space->above[i]) x[i] -= row[i] * x[k];
        x[k] /= row[k];
    }
    for (size_t k = n; k-- > 0;) {
        const double *row = space->factor + k * n;
        for (int i = space->above[k]; i >= 0; i = space->above[i]) x[k] -= row[i] * x[i];
    }
}

/* From the leaves on, what a body's change of momentum leaves of the other forces is carried by its rows. */
void pinch_joint_space_forces(const pinch_joint_space *space, pinch_problem *problem, const double *wrench,
                              double *scratch)
{
    double over = 1 / problem->step;
    for (int place = 0; place < space->count; place++) {
        const pinch_body *body = &problem->bodies[space->bodies[place].body];
        double change[6], *x = scratch + 6 * place;
        for (int i = 0; i < 6; i++) change[i] = over * (body->velocity_end[i] - body->velocity[i]);
        momentum_of(body, change, x);
        pinch_add_multiple6(-1, wrench + 6 * space->bodies[place].body, x);
    }
    for (int place = space->count - 1; place >= 0; place--) {
        const pinch_space_body *b = &space->bodies[place];
        const double *x = scratch + 6 * place;
        for (int k = 0; k < b->hard; k++) {
            pinch_joint_row *row = &problem->rows[b->row[k]];
            double force = pinch_dot6(b->unit[k], x);
            if (b->parent >= 0)
                pinch_add_multiple6(-force, pinch_row_ends_of(row, b->body).parent, scratch + 6 * b->parent);
            row->force = force;
            row->pivot = b->pivot[k];
        }
    }
}
