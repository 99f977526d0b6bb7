#include "kinematics/joint_space.h"

#include "kinematics/space_loops.h"
#include "support/dense.h"
#include "support/vec3.h"

#include <math.h>
#include <string.h>

/* A joint turns all that hangs from it: with the number of joints from root to leaf the condition of the inertia grows
 * with its fourth power. Hands and arms have up to a dozen. */
enum { DEEPEST = 12 };

/* Places the bodies and gives them the hard rows of their joints; those that close loops go into `closing`. Returns
 * false where the tree is too deep, or a body has more than six. */
static bool place_bodies(const pinch_tree_search *s, pinch_space_members of, pinch_tree_rows rows, int *closing,
                         pinch_joint_space *space)
{
    int closings = 0;
    space->rates = 6 * space->count;
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
        for (int k = 0; k < run->count && owner < 0; k++) closing[closings++] = rows.index[run->first + k];
        if (owner < 0) continue;
        if (space->bodies[owner].hard + run->count > 6) return false;
        for (int k = 0; k < run->count; k++)
            space->bodies[owner].row[space->bodies[owner].hard++] = rows.index[run->first + k];
        space->rates -= run->count;
    }
    closing[closings] = -1;
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

/* Lists for each direction the bodies that it moves, and the next one that moves its own. */
static void list_directions(pinch_joint_space *space)
{
    for (int place = 0; place < space->count; place++) {
        const pinch_space_body *b = &space->bodies[place];
        int carrying = b->parent < 0 ? -1 : space->moving[b->parent];
        space->moving[place] = b->hard < 6 ? b->first_direction : carrying;
        for (int k = b->hard, f = b->first_direction; k < 6; k++, f++) {
            space->above[f] = k < 5 ? f + 1 : carrying;
            space->moved_bodies[f] = (pinch_space_stretch){place, b->end};
            space->unknown[f] = f;
            space->follows[f] = 1;
        }
    }
}

void pinch_space_momentum(const pinch_body *body, const double *v, double *momentum)
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

/* Finds how each direction moves the bodies, and their momenta. */
static void follow_directions(const pinch_problem *problem, const pinch_joint_space *space)
{
    size_t size = 6 * (size_t)space->count;
    for (int place = 0; place < space->count; place++) {
        const pinch_space_body *b = &space->bodies[place];
        const pinch_body *body = &problem->bodies[b->body];
        int own = 6 - b->hard;
        for (int f = space->moving[place]; f >= 0; f = space->above[f]) {
            double *way = space->way + (size_t)f * size + 6 * place;
            int k = f - b->first_direction;
            if (k >= 0 && k < own)
                memcpy(way, b->unit[b->hard + k], sizeof b->unit[0]);
            else
                carry(b, space->way + (size_t)f * size + 6 * b->parent, way);
            pinch_space_momentum(body, way, space->momentum + (size_t)f * size + 6 * place);
        }
    }
}

/* The inertia is scaled so that its diagonal is 1. Returns false where that cannot be. */
static bool find_inertia(pinch_joint_space *space)
{
    size_t n = (size_t)space->freedoms, size = 6 * (size_t)space->count;
    double *H = space->inertia;
    memset(H, 0, n * n * sizeof *H);
    for (int g = 0; g < space->freedoms; g++)
        for (int f = g; f >= 0; f = space->above[f])
            H[(size_t)g * n + (size_t)f] = pinch_space_dot(space->way + (size_t)f * size,
                                                           space->momentum + (size_t)g * size, space->moved_bodies[g]);
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
 * and the rates are as they were, but for those that follow from others. What it changes in the momenta along the
 * directions goes into `moved`. momentum: 6 count. Returns false where rows contradict each other.
 */
static bool move_by_rows(const pinch_problem *problem, const pinch_joint_space *space, double *momentum)
{
    for (int place = 0; place < space->count; place++) {
        const pinch_space_body *b = &space->bodies[place];
        double *to = space->moves + 6 * place;
        memset(to, 0, 6 * sizeof *to);
        if (b->parent >= 0) carry(b, space->moves + 6 * b->parent, to);
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
    }
    if (space->loops && !pinch_space_follow_loops(space, problem)) return false;
    for (int place = 0; place < space->count; place++)
        pinch_space_momentum(&problem->bodies[space->bodies[place].body], space->moves + 6 * place,
                             momentum + 6 * place);
    for (int f = 0; f < space->freedoms; f++)
        space->moved[f] = space->scale[f] * pinch_space_dot(space->way + 6 * (size_t)f * (size_t)space->count, momentum,
                                                            space->moved_bodies[f]);
    return true;
}

static pinch_joint_space *allocate(pinch_arena *arena, int count)
{
    pinch_joint_space *space = PINCH_ARENA_ARRAY(arena, pinch_joint_space, 1);
    if (!space) return NULL;
    memset(space, 0, sizeof *space);
    space->count = count;
    space->bodies = PINCH_ARENA_ARRAY(arena, pinch_space_body, count);
    return arena->failed ? NULL : space;
}

static bool allocate_directions(pinch_arena *arena, int closings, pinch_joint_space *space)
{
    size_t n = (size_t)space->rates, size = 6 * (size_t)space->count;
    space->way = PINCH_ARENA_ARRAY(arena, double, n *size + 1);
    space->momentum = PINCH_ARENA_ARRAY(arena, double, (n + 1) * size); /* one more, for moves */
    space->moves = PINCH_ARENA_ARRAY(arena, double, size);
    space->scale = PINCH_ARENA_ARRAY(arena, double, n + 1);
    space->speed = PINCH_ARENA_ARRAY(arena, double, n + 1);
    space->moved = PINCH_ARENA_ARRAY(arena, double, n + 1);
    space->inertia = PINCH_ARENA_ARRAY(arena, double, n *n + 1);
    space->factor = PINCH_ARENA_ARRAY(arena, double, n *n + 1);
    space->above = PINCH_ARENA_ARRAY(arena, int, n + 1);
    space->moving = PINCH_ARENA_ARRAY(arena, int, space->count);
    space->unknown = PINCH_ARENA_ARRAY(arena, int, n + 1);
    space->follows = PINCH_ARENA_ARRAY(arena, double, n + 1);
    space->moved_bodies = PINCH_ARENA_ARRAY(arena, pinch_space_stretch, n + 1);
    space->force = PINCH_ARENA_ARRAY(arena, double, size + (size_t)closings + 1);
    if (!arena->failed) memset(space->force, 0, sizeof *space->force * size); /* not all bodies have six hard rows */
    return !arena->failed;
}

/* Fills in the space of bodies that are in their places. Returns false as pinch_joint_space_build does. */
static bool find_motions(pinch_arena *arena, const pinch_problem *problem, const int *closing, pinch_joint_space *space,
                         pinch_loose_rows *loose)
{
    int closings = 0;
    for (int place = 0; place < space->count; place++) {
        pinch_space_body *b = &space->bodies[place];
        if (!pinch_space_body_coordinates(problem, space->bodies, loose, b) || !pinch_space_body_solve(problem, b))
            return false;
    }
    while (closing[closings] >= 0) closings++;
    if (!allocate_directions(arena, closings, space)) return false;
    list_directions(space);
    follow_directions(problem, space);
    if (closings > 0) {
        space->loops = pinch_space_close_loops(arena, problem, (pinch_tree_rows){closing, closings}, space);
        if (!space->loops) return false;
        pinch_space_forget_mixed_rates(problem, space, loose);
    }
    return find_inertia(space) && factor_inertia(space) &&
           move_by_rows(problem, space, space->momentum + 6 * (size_t)space->rates * (size_t)space->count);
}

/* Finds the tree and places its bodies. Returns false as place_bodies does, where joints do not tie the bodies
 * together, or when memory ran out. */
static bool find_tree(pinch_arena *arena, const pinch_problem *problem, pinch_space_members of, pinch_tree_rows rows,
                      pinch_tree_search *s, int *closing, pinch_joint_space *space)
{
    int *scratch = PINCH_ARENA_ARRAY(arena, int, 3 * of.count);
    if (!pinch_tree_find(arena, problem, of.count, of.slot_of, rows, s)) return false;
    pinch_tree_put_subtrees_together(s, scratch);
    return place_bodies(s, of, rows, closing, space);
}

/* Tells whether a joint that closes a loop has more rows than one of the tree. */
static bool closes_with_more(const pinch_tree_search *s)
{
    int least = 6, most = 0;
    for (const pinch_row_run *run = s->runs; run < s->runs + s->run_count; run++) {
        bool closing = pinch_tree_owner(s, run) < 0;
        if (closing && run->count > most) most = run->count;
        if (!closing && run->count < least) least = run->count;
    }
    return most > least;
}

/* Lists the joints of `rows` with so many rows, of those with six or more. Returns how many rows they have. */
static int list_runs(const pinch_tree_search *s, pinch_tree_rows rows, int size, int *index)
{
    int count = 0;
    for (const pinch_row_run *run = s->runs; run < s->runs + s->run_count; run++)
        for (int k = 0; k < run->count && (run->count < 6 ? run->count : 6) == size; k++)
            index[count++] = rows.index[run->first + k];
    return count;
}

/* Finds a tree of the joints with the most rows that do: those that leave more freedoms, as ball joints do, are to
 * close loops, and not to need a drive along each of these. Returns false as find_tree does. */
static bool find_longest_tree(pinch_arena *arena, const pinch_problem *problem, pinch_space_members of,
                              pinch_tree_rows rows, pinch_tree_search *s, int *closing, pinch_joint_space *space)
{
    const pinch_tree_search all = *s;
    int *index = PINCH_ARENA_ARRAY(arena, int, rows.count);
    if (!index) return false;
    pinch_tree_rows longest = {index, 0};
    for (int size = 6; size > 0 && !arena->failed; size--) {
        longest.count += list_runs(&all, rows, size, index + longest.count);
        if (longest.count == 0 || !find_tree(arena, problem, of, longest, s, closing, space)) continue;
        int closings = 0, next = longest.count;
        while (closing[closings] >= 0) closings++;
        while (--size > 0) next += list_runs(&all, rows, size, index + next);
        memcpy(closing + closings, index + longest.count, sizeof *index * (size_t)(next - longest.count));
        closing[closings + next - longest.count] = -1;
        return true;
    }
    return false;
}

pinch_joint_space *pinch_joint_space_build(pinch_arena *arena, const pinch_problem *problem, pinch_space_members of,
                                           pinch_tree_rows rows, pinch_loose_rows *loose)
{
    pinch_tree_search s;
    pinch_joint_space *space = allocate(arena, of.count);
    int *closing = PINCH_ARENA_ARRAY(arena, int, rows.count + 1);
    if (arena->failed || !find_tree(arena, problem, of, rows, &s, closing, space)) return NULL;
    bool other = closing[0] >= 0 && closes_with_more(&s);
    if (other && !find_longest_tree(arena, problem, of, rows, &s, closing, space)) return NULL;
    space->freedoms = space->rates;
    number_directions(space);
    if (!find_motions(arena, problem, closing, space, loose)) {
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
    for (int f = space->moving[place]; f >= 0; f = space->above[f])
        pinch_add_multiple6(space->scale[f] * x[f], way_of(space, f, place), v);
}

void pinch_joint_space_reduce(const pinch_joint_space *space, int place, int rows, const double *jacobian, double sign,
                              double *g)
{
    for (int f = space->moving[place]; f >= 0; f = space->above[f]) {
        const double *way = way_of(space, f, place), scale = sign * space->scale[f];
        for (int row = 0; row < rows; row++)
            g[row * space->freedoms + f] += scale * pinch_dot6(jacobian + 6 * row, way);
    }
}

void pinch_joint_space_add_size(const pinch_joint_space *space, int place, double h, const double *wrench, double *size)
{
    for (int f = space->moving[place]; f >= 0; f = space->above[f])
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

/* What a body's change of momentum leaves of the other forces is carried by the hard rows. */
void pinch_joint_space_forces(const pinch_joint_space *space, pinch_problem *problem, const double *wrench,
                              double *scratch)
{
    double over = 1 / problem->step;
    for (int place = 0; place < space->count; place++) {
        const pinch_body *body = &problem->bodies[space->bodies[place].body];
        double change[6], *x = scratch + 6 * place;
        for (int i = 0; i < 6; i++) change[i] = over * (body->velocity_end[i] - body->velocity[i]);
        pinch_space_momentum(body, change, x);
        pinch_add_multiple6(-1, wrench + 6 * space->bodies[place].body, x);
    }
    if (space->loops) pinch_space_bear_by_loops(space, problem, scratch);
    pinch_space_bear(space, problem, scratch, space->force);
    if (space->loops) pinch_space_share(space, problem);
    for (int place = 0; place < space->count; place++) {
        const pinch_space_body *b = &space->bodies[place];
        for (int k = 0; k < b->hard; k++) {
            problem->rows[b->row[k]].force = space->force[6 * place + k];
            problem->rows[b->row[k]].pivot = b->pivot[k];
        }
    }
}
