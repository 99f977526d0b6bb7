#include "kinematics/joint_tree.h"

#include "support/dense.h"

#include <math.h>
#include <string.h>

/* A row's own part on its body, beside those before it, has to be this much of the whole row. Below, errors grow too
 * much on the way from body to body, or rows depend on each other. */
static const double SMALLEST_PIVOT = 1e-3;

static void reflect(const pinch_tree_row *row, double *x)
{
    pinch_add_multiple6(-row->scale * pinch_dot6(row->vector, x), row->vector, x);
}

/* x <- Q x and Q^T x of one body */
static void apply_q(const pinch_joint_tree *tree, const pinch_tree_body *body, double *x)
{
    for (int k = body->rows - 1; k >= 0; k--) reflect(&tree->rows[body->first_row + k], x);
}

static void apply_q_transposed(const pinch_joint_tree *tree, const pinch_tree_body *body, double *x)
{
    for (int k = 0; k < body->rows; k++) reflect(&tree->rows[body->first_row + k], x);
}

/* Computes the motion Q1 R^-T (c - P u_p) of a body. `moves` holds those of all bodies before it. Without with_rhs c is
 * 0. */
static void follow_parent(const pinch_joint_tree *tree, int place, bool with_rhs, double *moves)
{
    const pinch_tree_body *body = &tree->bodies[place];
    const pinch_tree_row *rows = tree->rows + body->first_row;
    const double *parent = body->parent >= 0 ? moves + 6 * body->parent : NULL;
    double *x = moves + 6 * place;
    for (int k = 0; k < 6; k++) x[k] = 0;
    for (int k = 0; k < body->rows; k++) {
        double sum = with_rhs ? rows[k].rhs : 0;
        if (parent) sum -= pinch_dot6(rows[k].parent, parent);
        for (int i = 0; i < k; i++) sum -= rows[k].r[i] * x[i];
        x[k] = sum / rows[k].r[k];
    }
    apply_q(tree, body, x);
}

/* Forms the Householder vectors of one body's rows. Returns false where a pivot is small. */
static bool factorize_block(pinch_tree_row *rows, int count)
{
    /* Either sign of the diagonal will do unless the vector's head comes out of a cancellation. Zeros are frequent and
     * come with rounding: they must not turn the directions over from one step to the next. */
    static const double CANCELS = 0.1;
    for (int k = 0; k < count; k++) {
        double *v = rows[k].vector, size2 = 0;
        for (int i = 0; i < k; i++) {
            rows[k].r[i] = v[i];
            v[i] = 0;
        }
        size2 = pinch_dot6(v, v);
        double size = sqrt(size2), alpha = v[k] > CANCELS * size ? -size : size;
        if (!(size > SMALLEST_PIVOT)) return false;
        rows[k].r[k] = alpha;
        rows[k].scale = 1 / (size2 - alpha * v[k]);
        v[k] -= alpha;
        for (int j = k + 1; j < count; j++) reflect(&rows[k], rows[j].vector);
    }
    return true;
}

/* Fills in a row whose own body is on the side `own`, scaled to length one. Returns false where it has none. */
static bool fill_row(const pinch_problem *problem, const pinch_root_inverse *roots, int own, pinch_tree_row *to)
{
    const pinch_joint_row *row = &problem->rows[to->row];
    const int body[2] = {row->body1, row->body2};
    const double *const j[2] = {row->j1, row->j2};
    pinch_root_apply_transposed(&roots[body[own]], j[own], to->vector);
    if (body[!own] >= 0)
        pinch_root_apply_transposed(&roots[body[!own]], j[!own], to->parent);
    else
        memset(to->parent, 0, sizeof to->parent);
    to->length = sqrt(pinch_dot6(to->vector, to->vector) + pinch_dot6(to->parent, to->parent));
    if (!(to->length > 0)) return false;
    double inverse = 1 / to->length;
    for (int i = 0; i < 6; i++) to->vector[i] *= inverse;
    for (int i = 0; i < 6; i++) to->parent[i] *= inverse;
    return true;
}

/* Fills in all rows, body by body. */
static bool fill_rows(pinch_joint_tree *tree, const pinch_tree_search *s, const pinch_problem *problem,
                      const pinch_root_inverse *roots, const int *row_indices)
{
    for (const pinch_row_run *run = s->runs; run < s->runs + s->run_count; run++) {
        int place = pinch_tree_owner(s, run), own = run->end[0] == s->slot[place] ? 0 : 1;
        pinch_tree_body *body = &tree->bodies[place];
        for (int k = 0; k < run->count; k++) {
            pinch_tree_row *to = &tree->rows[body->first_row + body->rows++];
            to->row = row_indices[run->first + k];
            if (!fill_row(problem, roots, own, to)) return false;
        }
    }
    return true;
}

/* Fills in the bodies, and makes room for their rows. */
static bool fill_bodies(pinch_joint_tree *tree, const pinch_tree_search *s, const pinch_root_inverse *roots,
                        const int *bodies)
{
    tree->freedoms = 6 * tree->count;
    for (int place = 0; place < tree->count; place++) {
        pinch_tree_body *body = &tree->bodies[place];
        body->parent = s->parent[place];
        body->end = place + 1;
        body->rows = 0;
        for (int above = body->parent; above >= 0 && tree->bodies[above].end == place; above = s->parent[above])
            tree->bodies[above].end = place + 1;
        body->root = roots[bodies[s->slot[place]]];
    }
    for (const pinch_row_run *run = s->runs; run < s->runs + s->run_count; run++) {
        int owner = pinch_tree_owner(s, run);
        if (owner < 0 || (tree->bodies[owner].rows += run->count) > 6) return false;
    }
    for (int place = 0, first = 0; place < tree->count; place++) {
        pinch_tree_body *body = &tree->bodies[place];
        if (body->parent < 0 && place > 0 && body->rows == 0) return false;
        tree->freedoms -= body->rows;
        body->first_row = first;
        first += body->rows;
        body->rows = 0;
    }
    return true;
}

static bool factorize_blocks(pinch_joint_tree *tree)
{
    for (int place = 0; place < tree->count; place++)
        if (!factorize_block(tree->rows + tree->bodies[place].first_row, tree->bodies[place].rows)) return false;
    return true;
}

/*
 * Makes direction `index` orthogonal to those of the bodies that hang from its own, which begin with direction `first`,
 * and its length one. Only these move what it moves, and only what hangs from their own bodies. A second pass is made
 * where much was taken away: what is left then is mostly rounding.
 */
static bool orthonormalize(const pinch_joint_tree *tree, int first, int index)
{
    size_t all = 6 * (size_t)tree->count;
    const pinch_tree_range *own = &tree->moves[index];
    double *x = tree->directions + (size_t)index * all;
    double before = sqrt(pinch_dot_strands(x + own->first, x + own->first, own->count)), size = before;
    for (int pass = 0; pass < 2; pass++) {
        for (int k = first; k < index; k++) {
            const pinch_tree_range *of = &tree->moves[k];
            const double *other = tree->directions + (size_t)k * all + of->first;
            double *to = x + of->first;
            pinch_add_multiple(of->count, -pinch_dot_strands(other, to, of->count), other, to);
        }
        size = sqrt(pinch_dot_strands(x + own->first, x + own->first, own->count));
        if (size > 0.5 * before) break;
    }
    if (!(size > 1e-8 * before)) return false;
    const pinch_lanes both = {size, size};
    for (double *at = x + own->first; at < x + own->first + own->count; at += 2)
        pinch_lanes_put(pinch_lanes_at(at) / both, at);
    return true;
}

/* Numbers the directions, those of the last bodies first, and notes what each moves. */
static void number_directions(pinch_joint_tree *tree)
{
    int index = 0;
    for (int place = tree->count - 1; place >= 0; place--) {
        pinch_tree_body *body = &tree->bodies[place];
        body->first_direction = index;
        for (int k = body->rows; k < 6; k++)
            tree->moves[index++] = (pinch_tree_range){6 * place, 6 * (body->end - place)};
    }
}

/* Writes how each direction moves its own body and what hangs from it: body by body, because the motions of a body
 * along several directions do not wait for each other, and those of several bodies along one do. */
static void follow_directions(pinch_joint_tree *tree)
{
    size_t n = 6 * (size_t)tree->count;
    for (int place = 0; place < tree->count; place++) {
        const pinch_tree_body *body = &tree->bodies[place];
        double *x = tree->directions + (size_t)body->first_direction * n;
        for (int k = body->rows; k < 6; k++, x += n) {
            memset(x + 6 * place, 0, 6 * sizeof *x);
            x[6 * place + k] = 1;
            apply_q(tree, body, x + 6 * place);
        }
        for (int above = body->parent; above >= 0; above = tree->bodies[above].parent) {
            x = tree->directions + (size_t)tree->bodies[above].first_direction * n;
            for (int k = tree->bodies[above].rows; k < 6; k++, x += n) follow_parent(tree, place, false, x);
        }
    }
}

/*
 * Each direction is made orthogonal to those of the bodies that hang from its own alone, because others do not move
 * what it moves, and so it goes on moving nothing but these: of the rows of a finger, the columns that belong to other
 * fingers are zero. In the order of the unknowns a direction stands before those that move its body, too, and factors
 * fill in no zeros (Featherstone, "Efficient factorization of the joint-space inertia matrix for branched kinematic
 * trees", 2005).
 */
static bool find_directions(pinch_joint_tree *tree)
{
    number_directions(tree);
    follow_directions(tree);
    for (int place = tree->count - 1; place >= 0; place--) {
        const pinch_tree_body *body = &tree->bodies[place];
        int first = tree->bodies[body->end - 1].first_direction;
        for (int k = body->rows, index = body->first_direction; k < 6; k++, index++)
            if (!orthonormalize(tree, first, index)) return false;
    }
    return true;
}

static pinch_joint_tree *allocate(pinch_arena *arena, int count, int row_count)
{
    pinch_joint_tree *tree = PINCH_ARENA_ARRAY(arena, pinch_joint_tree, 1);
    if (!tree) return NULL;
    tree->count = count;
    tree->bodies = PINCH_ARENA_ARRAY(arena, pinch_tree_body, count);
    tree->rows = PINCH_ARENA_ARRAY(arena, pinch_tree_row, row_count);
    tree->moved = PINCH_ARENA_ARRAY(arena, double, 6 * count);
    return arena->failed ? NULL : tree;
}

/* The parts of a body's rows on the body itself, made orthonormal. */
typedef struct own_parts {
    int count;
    double v[6][6];
} own_parts;

/* Adds the part x of a row whose square is length2 as a whole. Returns false where what is left of it beside those
 * before it is too little. */
static bool add_part(own_parts *own, double x[6], double length2)
{
    if (own->count == 6) return false;
    for (int k = 0; k < own->count; k++) pinch_add_multiple6(-pinch_dot6(own->v[k], x), own->v[k], x);
    double size2 = pinch_dot6(x, x);
    if (!(size2 > SMALLEST_PIVOT * SMALLEST_PIVOT * length2)) return false;
    double over = 1 / sqrt(size2), *to = own->v[own->count++];
    for (int i = 0; i < 6; i++) to[i] = over * x[i];
    return true;
}

/* Adds a row whose own body is on the side `mine`. Returns false as add_part does. */
static bool add_row(own_parts *own, const pinch_joint_row *row, int mine, const pinch_root_inverse *roots)
{
    const int body[2] = {row->body1, row->body2};
    const double *const j[2] = {row->j1, row->j2};
    double part[2][6], length2 = 0;
    for (int side = 0; side < 2; side++) {
        if (body[side] < 0) continue;
        pinch_root_apply_transposed(&roots[body[side]], j[side], part[side]);
        length2 += pinch_dot6(part[side], part[side]);
    }
    return add_part(own, part[mine], length2);
}

bool pinch_joint_tree_is_independent(pinch_arena *arena, const pinch_problem *problem, const pinch_root_inverse *roots,
                                     int count, const int *slot_of, pinch_tree_rows rows)
{
    pinch_tree_search s;
    own_parts *own = PINCH_ARENA_ARRAY(arena, own_parts, count);
    if (rows.count > 6 * count || !pinch_tree_find(arena, problem, count, slot_of, rows, &s)) return false;
    for (int place = 0; place < count; place++) own[place].count = 0;
    for (const pinch_row_run *run = s.runs; run < s.runs + s.run_count; run++) {
        int place = pinch_tree_owner(&s, run);
        if (place < 0) return false;
        int mine = run->end[0] == s.slot[place] ? 0 : 1;
        for (int k = 0; k < run->count; k++)
            if (!add_row(&own[place], &problem->rows[rows.index[run->first + k]], mine, roots)) return false;
    }
    for (int place = 1; place < count; place++)
        if (s.parent[place] < 0 && own[place].count == 0) return false;
    return true;
}

pinch_joint_tree *pinch_joint_tree_build(pinch_arena *arena, const pinch_problem *problem,
                                         const pinch_root_inverse *roots, int *bodies, int count, int *slot_of,
                                         pinch_tree_rows rows)
{
    pinch_tree_search s;
    pinch_joint_tree *tree = allocate(arena, count, rows.count);
    int *scratch = PINCH_ARENA_ARRAY(arena, int, 3 * count);
    if (rows.count > 6 * count || !pinch_tree_find(arena, problem, count, slot_of, rows, &s)) return NULL;
    pinch_tree_put_subtrees_together(&s, scratch);
    if (!fill_bodies(tree, &s, roots, bodies) || !fill_rows(tree, &s, problem, roots, rows.index) ||
        !factorize_blocks(tree))
        return NULL;
    tree->directions = PINCH_ARENA_ARRAY(arena, double, (size_t)(6 * count) * (size_t)(tree->freedoms + 1));
    tree->moves = PINCH_ARENA_ARRAY(arena, pinch_tree_range, tree->freedoms + 1);
    if (arena->failed || !find_directions(tree)) return NULL;
    for (int place = 0; place < count; place++) s.slot[place] = bodies[s.slot[place]];
    for (int place = 0; place < count; place++) {
        bodies[place] = s.slot[place];
        slot_of[bodies[place]] = place;
    }
    return tree;
}

void pinch_joint_tree_basis(const pinch_joint_tree *tree, double *basis)
{
    size_t m = (size_t)tree->freedoms, n = 6 * (size_t)tree->count;
    for (int place = 0; place < tree->count; place++) {
        double *own = basis + 6 * (size_t)place * m;
        size_t first = (size_t)tree->bodies[place].first_direction;
        for (size_t i = 0; i < 6; i++) memset(own + i * m + first, 0, sizeof *own * (m - first));
        for (int above = place; above >= 0; above = tree->bodies[above].parent) {
            size_t f = (size_t)tree->bodies[above].first_direction;
            for (int k = tree->bodies[above].rows; k < 6; k++, f++) {
                double u[6];
                pinch_root_apply(&tree->bodies[place].root, tree->directions + f * n + 6 * place, u);
                for (size_t i = 0; i < 6; i++) own[i * m + f] = u[i];
            }
        }
    }
}

/* removes from x its part along the directions */
static void remove_directions(const pinch_joint_tree *tree, double *x)
{
    size_t n = 6 * (size_t)tree->count;
    for (int f = 0; f < tree->freedoms; f++) {
        const pinch_tree_range *moves = &tree->moves[f];
        const double *direction = tree->directions + (size_t)f * n + moves->first;
        double *to = x + moves->first;
        pinch_add_multiple(moves->count, -pinch_dot_strands(direction, to, moves->count), direction, to);
    }
}

void pinch_joint_tree_v0(pinch_joint_tree *tree, const pinch_problem *problem, const int *bodies, double *v0)
{
    for (int place = 0; place < tree->count; place++) {
        const pinch_tree_body *body = &tree->bodies[place];
        for (int k = 0; k < body->rows; k++) {
            pinch_tree_row *to = &tree->rows[body->first_row + k];
            const pinch_joint_row *row = &problem->rows[to->row];
            double rhs = row->rhs;
            if (row->body1 >= 0) rhs -= pinch_dot6(row->j1, problem->bodies[row->body1].velocity);
            if (row->body2 >= 0) rhs -= pinch_dot6(row->j2, problem->bodies[row->body2].velocity);
            to->rhs = rhs / to->length;
        }
        follow_parent(tree, place, true, tree->moved);
    }
    remove_directions(tree, tree->moved);
    for (int place = 0; place < tree->count; place++) {
        const double *v = problem->bodies[bodies[place]].velocity;
        pinch_root_apply(&tree->bodies[place].root, tree->moved + 6 * place, v0 + 6 * place);
        for (int i = 0; i < 6; i++) v0[6 * place + i] += v[i];
    }
}

/*
 * With q = h U^T f the joints' part of the balance is J'^T lambda = Y^-1 (v0 - v*) / h - (1 - D D^T) Y^T f, D the
 * directions: from the leaves on, C^T lambda_b is what the rows of the children leave of it, lambda_b = R^-1 Q1^T of
 * that.
 */
void pinch_joint_tree_forces(const pinch_joint_tree *tree, pinch_problem *problem, const int *bodies,
                             const double *wrench, double *scratch)
{
    for (int place = 0; place < tree->count; place++)
        pinch_root_apply_transposed(&tree->bodies[place].root, wrench + 6 * bodies[place], scratch + 6 * place);
    remove_directions(tree, scratch);
    for (int i = 0; i < 6 * tree->count; i++) scratch[i] = tree->moved[i] / problem->step - scratch[i];
    for (int place = tree->count - 1; place >= 0; place--) {
        const pinch_tree_body *body = &tree->bodies[place];
        const pinch_tree_row *rows = tree->rows + body->first_row;
        double *x = scratch + 6 * place;
        apply_q_transposed(tree, body, x);
        for (int k = body->rows - 1; k >= 0; k--) {
            x[k] /= rows[k].r[k];
            for (int i = 0; i < k; i++) x[i] -= rows[k].r[i] * x[k];
            if (body->parent >= 0) pinch_add_multiple6(-x[k], rows[k].parent, scratch + 6 * body->parent);
            problem->rows[rows[k].row].force = x[k] / rows[k].length;
            problem->rows[rows[k].row].pivot = fabs(rows[k].r[k]);
        }
    }
}
