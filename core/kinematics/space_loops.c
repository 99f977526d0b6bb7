#include "kinematics/space_loops.h"

#include "kinematics/constraint_factor.h"
#include "support/dense.h"
#include "support/lu.h"

#include <math.h>
#include <string.h>

/* What is left of a row beside others, as a part of its length: an independent one has more than the first, and one
 * that depends on others has less than the second. Between them it would hold what it hardly moves. */
static const double INDEPENDENT = 1e-3, DEPENDENT = 1e-9;

/* Vectors of all hard rows: six a body, and one for each that closes a loop. */
static int all_rows(const pinch_joint_space *space, const pinch_space_loops *loops)
{
    return 6 * space->count + loops->count;
}

static pinch_space_loops *allocate(pinch_arena *arena, const pinch_joint_space *space, pinch_tree_rows rows)
{
    pinch_space_loops *loops = PINCH_ARENA_ARRAY(arena, pinch_space_loops, 1);
    if (!loops) return NULL;
    size_t count = (size_t)rows.count, rates = (size_t)space->rates, bodies = 6 * (size_t)space->count;
    loops->count = rows.count;
    loops->rank = 0;
    loops->row = PINCH_ARENA_ARRAY(arena, int, count);
    loops->place = (int(*)[2])PINCH_ARENA_ARRAY(arena, int, 2 * count);
    loops->part = PINCH_ARENA_ARRAY(arena, int, space->count);
    loops->end = PINCH_ARENA_ARRAY(arena, int, space->count);
    loops->length = PINCH_ARENA_ARRAY(arena, double, count);
    loops->pivot = PINCH_ARENA_ARRAY(arena, double, count);
    loops->order = PINCH_ARENA_ARRAY(arena, int, count);
    loops->held = PINCH_ARENA_ARRAY(arena, int, count);
    loops->pivots = PINCH_ARENA_ARRAY(arena, int, count);
    loops->reduced = PINCH_ARENA_ARRAY(arena, double, count *rates + 1);
    loops->combined = PINCH_ARENA_ARRAY(arena, double, count *count);
    loops->factors = PINCH_ARENA_ARRAY(arena, double, count *count);
    loops->common = PINCH_ARENA_ARRAY(arena, double, 2 * count);
    loops->scale = PINCH_ARENA_ARRAY(arena, double, count);
    loops->way = PINCH_ARENA_ARRAY(arena, double, count *bodies);
    loops->compliance = PINCH_ARENA_ARRAY(arena, double, bodies + count);
    loops->share = PINCH_ARENA_ARRAY(arena, double, count *(bodies + count));
    if (arena->failed) return NULL;
    memcpy(loops->row, rows.index, sizeof *loops->row * count);
    return loops;
}

/* The roots of the inertias of a row's bodies. Returns false where one is not positive definite. */
static bool roots_of(const pinch_problem *problem, const pinch_joint_row *row, pinch_root_inverse root[2])
{
    return (row->body1 < 0 || pinch_root_inverse_of(&problem->bodies[row->body1], &root[0])) &&
           (row->body2 < 0 || pinch_root_inverse_of(&problem->bodies[row->body2], &root[1]));
}

/* The square of a row's length in the metric of the inertia. */
static double length2_of(const pinch_joint_row *row, const pinch_root_inverse root[2])
{
    double length2 = 0, y[6];
    if (row->body1 >= 0) {
        pinch_root_apply_transposed(&root[0], row->j1, y);
        length2 += pinch_dot6(y, y);
    }
    if (row->body2 >= 0) {
        pinch_root_apply_transposed(&root[1], row->j2, y);
        length2 += pinch_dot6(y, y);
    }
    return length2;
}

/* The place of a body of the problem, -1: none */
static int place_of(const pinch_joint_space *space, int body)
{
    int place = space->count - 1;
    while (place >= 0 && space->bodies[place].body != body) place--;
    return body < 0 ? -1 : place;
}

/* Returns the first place of what is tied to a place, and shortens the way there. */
static int part_of(int *part, int place)
{
    while (part[place] != place) place = part[place] = part[part[place]];
    return place;
}

/* Finds the bodies of the rows, and which parts of the space the rows tie together. */
static void find_parts(const pinch_problem *problem, const pinch_joint_space *space, pinch_space_loops *loops)
{
    int *part = loops->part;
    for (int place = 0; place < space->count; place++) {
        int parent = space->bodies[place].parent;
        part[place] = parent < 0 ? place : part[parent];
    }
    for (int k = 0; k < loops->count; k++) {
        const pinch_joint_row *row = &problem->rows[loops->row[k]];
        int *place = loops->place[k];
        place[0] = place_of(space, row->body1);
        place[1] = place_of(space, row->body2);
        if (place[0] < 0 || place[1] < 0) continue;
        int a = part_of(part, place[0]), b = part_of(part, place[1]);
        part[a > b ? a : b] = a < b ? a : b;
    }
    for (int place = 0; place < space->count; place++) {
        part[place] = part_of(part, place);
        loops->end[part[place]] = place + 1;
    }
}

/* What row k says about motions of the bodies, 6 a body. */
static double row_velocity(const pinch_space_loops *loops, const pinch_problem *problem, int k, const double *motion)
{
    const pinch_joint_row *row = &problem->rows[loops->row[k]];
    const int *place = loops->place[k];
    double velocity = 0;
    if (place[0] >= 0) velocity += pinch_dot6(row->j1, motion + 6 * place[0]);
    if (place[1] >= 0) velocity += pinch_dot6(row->j2, motion + 6 * place[1]);
    return velocity;
}

/* x += f times row k */
static void add_row(const pinch_space_loops *loops, const pinch_problem *problem, int k, double f, double *x)
{
    const pinch_joint_row *row = &problem->rows[loops->row[k]];
    const int *place = loops->place[k];
    if (place[0] >= 0) pinch_add_multiple6(f, row->j1, x + 6 * place[0]);
    if (place[1] >= 0) pinch_add_multiple6(f, row->j2, x + 6 * place[1]);
}

/* Scales each direction to a kinetic energy of a half, and has it move no other bodies by nothing. Returns false where
 * that cannot be. */
static bool scale_ways(pinch_joint_space *space)
{
    size_t size = 6 * (size_t)space->count;
    for (int f = 0; f < space->rates; f++) {
        double *const vectors[2] = {space->way + (size_t)f * size, space->momentum + (size_t)f * size};
        pinch_space_stretch of = space->moved_bodies[f];
        double energy = pinch_space_dot(vectors[0], vectors[1], of);
        if (!(energy > 0)) return false;
        double scale = space->scale[f] = 1 / sqrt(energy);
        for (int k = 0; k < 2; k++) {
            memset(vectors[k], 0, 6 * sizeof(double) * (size_t)of.first);
            for (int i = 6 * of.first; i < 6 * of.end; i++) vectors[k][i] *= scale;
            memset(vectors[k] + 6 * of.end, 0, 6 * sizeof(double) * (size_t)(space->count - of.end));
        }
    }
    return true;
}

/* Writes the rows in scaled directions, each with a length of at most one. Returns false where a row has none. */
static bool fill_rows(const pinch_problem *problem, const pinch_joint_space *space, pinch_space_loops *loops)
{
    size_t size = 6 * (size_t)space->count, rates = (size_t)space->rates;
    pinch_root_inverse roots[2];
    memset(loops->reduced, 0, sizeof *loops->reduced * (size_t)loops->count * rates);
    for (int k = 0; k < loops->count; k++) {
        const pinch_joint_row *row = &problem->rows[loops->row[k]];
        const double *const j[2] = {row->j1, row->j2};
        bool known = k > 0 && row->body1 == problem->rows[loops->row[k - 1]].body1 &&
                     row->body2 == problem->rows[loops->row[k - 1]].body2;
        if (!known && !roots_of(problem, row, roots)) return false;
        double *reduced = loops->reduced + (size_t)k * rates, length = sqrt(length2_of(row, roots)), over = 1 / length;
        loops->length[k] = length;
        if (!(length > 0)) return false;
        for (int side = 0; side < 2; side++) {
            int place = loops->place[k][side];
            if (place < 0) continue;
            for (int f = space->moving[place]; f >= 0; f = space->above[f])
                reduced[f] += over * pinch_dot6(j[side], space->way + (size_t)f * size + 6 * place);
        }
    }
    return true;
}

/* A row and a rate, by their numbers. */
typedef struct entry {
    int row, rate;
    double value;
} entry;

/* Finds the largest entry of the rows that hold no rate yet. */
static entry largest_left(const pinch_joint_space *space, const pinch_space_loops *loops)
{
    entry most = {.row = -1};
    for (int i = loops->rank; i < loops->count; i++) {
        const double *row = loops->reduced + (size_t)loops->order[i] * (size_t)space->rates;
        for (int f = 0; f < space->rates; f++)
            if (fabs(row[f]) > fabs(most.value)) most = (entry){i, f, row[f]};
    }
    return most;
}

/* y -= f x, but for zeros */
static void subtract(size_t n, double f, const double *x, double *y)
{
    for (size_t i = 0; i < n; i++)
        if (x[i] != 0) y[i] -= f * x[i];
}

/* Has independent rows hold a rate each, which leaves all others (Gauss and Jordan's method). Returns false where a row
 * nearly depends on others. */
static bool hold_rates(const pinch_joint_space *space, pinch_space_loops *loops)
{
    size_t rates = (size_t)space->rates, count = (size_t)loops->count;
    memset(loops->combined, 0, count * count * sizeof *loops->combined);
    for (size_t k = 0; k < count; k++) {
        loops->order[k] = (int)k;
        loops->combined[k * (count + 1)] = 1;
    }
    while (loops->rank < loops->count) {
        const entry e = largest_left(space, loops);
        if (!(fabs(e.value) > DEPENDENT)) break;
        if (!(fabs(e.value) > INDEPENDENT)) return false;
        int own = loops->order[e.row], at = loops->rank++;
        loops->order[e.row] = loops->order[at];
        loops->order[at] = own;
        loops->held[at] = e.rate;
        loops->pivot[own] = fabs(e.value);
        double *row = loops->reduced + (size_t)own * rates, *combined = loops->combined + (size_t)own * count;
        for (size_t f = 0; f < rates; f++) row[f] /= e.value;
        for (size_t k = 0; k < count; k++) combined[k] /= e.value;
        for (size_t k = 0; k < count; k++) {
            double *other = loops->reduced + k * rates, f = other[e.rate];
            if ((int)k == own || f == 0) continue;
            subtract(rates, f, row, other);
            subtract(count, f, combined, loops->combined + k * count);
            other[e.rate] = 0;
        }
    }
    return true;
}

/* Writes the ways of the directions that are left, in which held rates follow from the others. */
static void join_ways(pinch_joint_space *space, pinch_space_loops *loops)
{
    size_t size = 6 * (size_t)space->count, bytes = size * sizeof(double);
    int left = 0;
    for (int i = 0; i < space->rates; i++) space->unknown[i] = 0;
    for (int r = 0; r < loops->rank; r++) space->unknown[loops->held[r]] = -1;
    for (int i = 0; i < space->rates; i++) {
        double *way = space->way + (size_t)i * size, *momentum = space->momentum + (size_t)i * size;
        for (int r = 0; r < loops->rank && space->unknown[i] == 0; r++) {
            double f = -loops->reduced[(size_t)loops->order[r] * (size_t)space->rates + (size_t)i];
            pinch_space_stretch of = space->moved_bodies[loops->held[r]];
            size_t held = (size_t)loops->held[r] * size, first = 6 * (size_t)of.first;
            if (f == 0) continue;
            pinch_add_multiple(6 * (of.end - of.first), f, space->way + held + first, way + first);
            pinch_add_multiple(6 * (of.end - of.first), f, space->momentum + held + first, momentum + first);
        }
    }
    for (int r = 0; r < loops->rank; r++) {
        loops->scale[r] = space->scale[loops->held[r]];
        memcpy(loops->way + (size_t)r * size, space->way + (size_t)loops->held[r] * size, bytes);
    }
    for (int i = 0; i < space->rates; i++) {
        if (space->unknown[i] < 0) continue;
        memmove(space->way + (size_t)left * size, space->way + (size_t)i * size, bytes);
        memmove(space->momentum + (size_t)left * size, space->momentum + (size_t)i * size, bytes);
        int part = loops->part[space->moved_bodies[i].first];
        space->moved_bodies[left] = (pinch_space_stretch){part, loops->end[part]};
        space->follows[i] = space->scale[i];
        space->unknown[i] = left++;
    }
    space->freedoms = left;
}

/* Tells of each held rate which unknown it is a multiple of. */
static void follow_unknowns(pinch_joint_space *space, const pinch_space_loops *loops)
{
    for (int r = 0; r < loops->rank; r++) {
        const double *row = loops->reduced + (size_t)loops->order[r] * (size_t)space->rates;
        int held = loops->held[r], others = 0;
        for (int i = 0; i < space->rates; i++) {
            if (i == held || row[i] == 0) continue;
            space->unknown[held] = others++ == 0 ? space->unknown[i] : -1;
            space->follows[held] = -loops->scale[r] * row[i];
        }
    }
}

/* From now on each direction is taken to move all bodies of its part. */
static void list_directions(pinch_joint_space *space, const pinch_space_loops *loops)
{
    for (int place = 0; place < space->count; place++) space->moving[place] = -1;
    for (int f = space->freedoms - 1; f >= 0; f--) {
        int *first = &space->moving[space->moved_bodies[f].first];
        space->above[f] = *first;
        *first = f;
    }
    for (int place = 0; place < space->count; place++) space->moving[place] = space->moving[loops->part[place]];
}

/* The compliance by which a row shares what it carries, as in the system of forces (54). */
static double compliance_of(const pinch_problem *problem, const pinch_joint_row *row)
{
    static const double PROXIMAL = 1e-7;
    pinch_root_inverse roots[2];
    if (row->yield > 0) return row->yield;
    return roots_of(problem, row, roots) ? PROXIMAL * problem->step * length2_of(row, roots) : 0;
}

static void find_compliances(const pinch_problem *problem, const pinch_joint_space *space, pinch_space_loops *loops)
{
    for (int place = 0; place < space->count; place++) {
        const pinch_space_body *b = &space->bodies[place];
        for (int k = 0; k < 6; k++)
            loops->compliance[6 * place + k] = k < b->hard ? compliance_of(problem, &problem->rows[b->row[k]]) : 0;
    }
    for (int k = 0; k < loops->count; k++)
        loops->compliance[6 * space->count + k] = compliance_of(problem, &problem->rows[loops->row[k]]);
}

/* Writes for each dependent row the forces of hard rows that move nothing together: one of its own, those of
 * independent rows that undo it along the rates, and what the tree's rows bear of these. */
static void find_shares(const pinch_problem *problem, const pinch_joint_space *space, pinch_space_loops *loops)
{
    int all = all_rows(space, loops);
    double *x = loops->way + (size_t)loops->rank * 6 * (size_t)space->count; /* room of a held rate that there is not */
    for (int d = loops->rank; d < loops->count; d++) {
        const double *combined = loops->combined + (size_t)loops->order[d] * (size_t)loops->count;
        double *share = loops->share + (size_t)(d - loops->rank) * (size_t)all;
        memset(share, 0, sizeof *share * (size_t)all);
        memset(x, 0, sizeof *x * 6 * (size_t)space->count);
        for (int k = 0; k < loops->count; k++) {
            double f = combined[k] * loops->length[loops->order[d]] / loops->length[k];
            share[6 * space->count + k] = f;
            add_row(loops, problem, k, -f, x);
        }
        pinch_space_bear(space, problem, x, share);
    }
}

/* Factors share^T compliance share. Returns false where shares depend on each other. */
static bool factor_shares(const pinch_joint_space *space, pinch_space_loops *loops)
{
    int all = all_rows(space, loops), dependent = loops->count - loops->rank;
    for (int a = 0; a < dependent; a++)
        for (int b = 0; b <= a; b++) {
            const double *x = loops->share + (size_t)a * (size_t)all, *y = loops->share + (size_t)b * (size_t)all;
            double sum = 0;
            for (int i = 0; i < all; i++) sum += x[i] * loops->compliance[i] * y[i];
            loops->factors[a * dependent + b] = loops->factors[b * dependent + a] = sum;
        }
    return dependent == 0 || pinch_lu_factor(dependent, loops->factors, loops->pivots, loops->common);
}

pinch_space_loops *pinch_space_close_loops(pinch_arena *arena, const pinch_problem *problem, pinch_tree_rows rows,
                                           pinch_joint_space *space)
{
    pinch_space_loops *loops = allocate(arena, space, rows);
    if (!loops) return NULL;
    find_parts(problem, space, loops);
    if (!scale_ways(space) || !fill_rows(problem, space, loops) || !hold_rates(space, loops)) return NULL;
    join_ways(space, loops);
    follow_unknowns(space, loops);
    list_directions(space, loops);
    if (loops->rank == loops->count) return loops;
    find_compliances(problem, space, loops);
    find_shares(problem, space, loops);
    return factor_shares(space, loops) ? loops : NULL;
}

bool pinch_space_follow_loops(const pinch_joint_space *space, const pinch_problem *problem)
{
    /* m/s or rad/s, and as a part of what the rows ask for: less than the check of an answer can tell */
    static const double LEAST = 2e-10, ROUNDING = 1e-9;
    const pinch_space_loops *loops = space->loops;
    size_t count = (size_t)loops->count;
    double *asked = loops->common; /* beyond what they get */
    for (int k = 0; k < loops->count; k++) {
        const pinch_joint_row *row = &problem->rows[loops->row[k]];
        asked[k] = row->rhs - row_velocity(loops, problem, k, space->moves);
        if (row->body1 >= 0) asked[k] -= pinch_dot6(row->j1, problem->bodies[row->body1].velocity);
        if (row->body2 >= 0) asked[k] -= pinch_dot6(row->j2, problem->bodies[row->body2].velocity);
        asked[k] /= loops->length[k];
    }
    for (int d = loops->rank; d < loops->count; d++) {
        const double *combined = loops->combined + (size_t)loops->order[d] * count;
        double missed = 0, size = 0, length = loops->length[loops->order[d]];
        for (size_t k = 0; k < count; k++) {
            missed += combined[k] * asked[k];
            size += fabs(combined[k] * asked[k]);
        }
        if (!(fabs(missed) * length <= LEAST + ROUNDING * size * length)) return false;
    }
    for (int r = 0; r < loops->rank; r++) {
        double change = pinch_dot(loops->combined + (size_t)loops->order[r] * count, asked, loops->count);
        pinch_add_multiple(6 * space->count, change, loops->way + (size_t)r * 6 * (size_t)space->count, space->moves);
        space->speed[loops->held[r]] += loops->scale[r] * change;
    }
    return true;
}

void pinch_space_bear_by_loops(const pinch_joint_space *space, const pinch_problem *problem, double *x)
{
    const pinch_space_loops *loops = space->loops;
    size_t count = (size_t)loops->count;
    double *force = space->force + 6 * space->count;
    memset(force, 0, sizeof *force * count);
    for (int r = 0; r < loops->rank; r++) {
        double left = pinch_space_dot(loops->way + (size_t)r * 6 * (size_t)space->count, x,
                                      (pinch_space_stretch){0, space->count});
        pinch_add_multiple(loops->count, left, loops->combined + (size_t)loops->order[r] * count, force);
    }
    for (int k = 0; k < loops->count; k++) {
        force[k] /= loops->length[k];
        add_row(loops, problem, k, -force[k], x);
    }
}

void pinch_space_share(const pinch_joint_space *space, pinch_problem *problem)
{
    const pinch_space_loops *loops = space->loops;
    int all = all_rows(space, loops), dependent = loops->count - loops->rank;
    double *force = space->force, *common = loops->common;
    for (int d = 0; d < dependent; d++) {
        const double *share = loops->share + (size_t)d * (size_t)all;
        common[d] = 0;
        for (int i = 0; i < all; i++) common[d] -= share[i] * loops->compliance[i] * force[i];
    }
    if (dependent > 0) pinch_lu_solve(dependent, loops->factors, loops->pivots, common, common);
    for (int d = 0; d < dependent; d++)
        pinch_add_multiple(all, common[d], loops->share + (size_t)d * (size_t)all, force);
    for (int i = 0; i < loops->count; i++) {
        int k = loops->order[i];
        problem->rows[loops->row[k]].force = force[6 * space->count + k];
        problem->rows[loops->row[k]].pivot = i < loops->rank ? loops->pivot[k] : 1;
    }
}
