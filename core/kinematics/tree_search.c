#include "kinematics/tree_search.h"

/* Parts the rows into runs. */
static void find_runs(pinch_tree_search *s, const pinch_problem *problem, const int *slot_of, pinch_tree_rows rows)
{
    const pinch_joint_row *before = NULL;
    for (int k = 0; k < rows.count; k++) {
        const pinch_joint_row *row = &problem->rows[rows.index[k]];
        if (!before || row->body1 != before->body1 || row->body2 != before->body2)
            s->runs[s->run_count++] = (pinch_row_run){
                .first = k,
                .end = {row->body1 >= 0 ? slot_of[row->body1] : -1, row->body2 >= 0 ? slot_of[row->body2] : -1}};
        s->runs[s->run_count - 1].count++;
        before = row;
    }
}

static void place_body(pinch_tree_search *s, int slot, int parent)
{
    s->place[slot] = s->placed;
    s->slot[s->placed] = slot;
    s->parent[s->placed++] = parent;
}

/* Goes through the joints once and places what hangs from what has been placed. */
static void place_in_one_pass(pinch_tree_search *s, bool backward)
{
    for (int i = 0; i < s->run_count; i++) {
        const int *end = s->runs[backward ? s->run_count - 1 - i : i].end;
        for (int side = 0; side < 2; side++) {
            int body = end[side], other = end[!side];
            if (body >= 0 && s->place[body] < 0 && (other < 0 || s->place[other] >= 0))
                place_body(s, body, other < 0 ? -1 : s->place[other]);
        }
    }
}

/* Joints are gone through to and fro: two ways do for a chain, whichever way its joints are listed. */
static void place_bodies(pinch_tree_search *s)
{
    for (int slot = 0; slot < s->count; slot++) s->place[slot] = -1;
    if (s->count == 1) place_body(s, 0, -1);
    for (int way = 0; s->placed < s->count; way++) {
        int before = s->placed;
        place_in_one_pass(s, way % 2 == 1);
        if (s->placed == 0)
            place_body(s, 0, -1); /* nothing holds it */
        else if (s->placed == before && way % 2 == 1)
            return; /* not one cluster */
    }
}

void pinch_tree_put_subtrees_together(pinch_tree_search *s, int *scratch)
{
    int roots = 0, *size = scratch, *next = size + s->count, *slots = next + s->count;
    if (s->count == 1) return;
    for (int p = 0; p < s->count; p++) size[p] = 1;
    for (int p = s->count - 1; p >= 0; p--)
        if (s->parent[p] >= 0) size[s->parent[p]] += size[p];
    for (int p = 0; p < s->count; p++) { /* s->place is per slot: it takes the new places, by which parents are told */
        int parent = s->parent[p], *free_place = parent < 0 ? &roots : &next[parent], at = *free_place;
        *free_place += size[p];
        next[p] = at + 1;
        slots[p] = s->slot[p];
        s->place[slots[p]] = at;
        size[p] = parent < 0 ? -1 : s->place[slots[parent]]; /* from here on the parent's new place */
    }
    for (int p = 0; p < s->count; p++) {
        int at = s->place[slots[p]];
        s->slot[at] = slots[p];
        s->parent[at] = size[p];
    }
}

int pinch_tree_owner(const pinch_tree_search *s, const pinch_row_run *run)
{
    int at[2];
    for (int side = 0; side < 2; side++) at[side] = run->end[side] >= 0 ? s->place[run->end[side]] : -1;
    int child = at[0] > at[1] ? 0 : 1;
    return at[child] >= 0 && s->parent[at[child]] == at[!child] ? at[child] : -1;
}

bool pinch_tree_find(pinch_arena *arena, const pinch_problem *problem, int count, const int *slot_of,
                     pinch_tree_rows rows, pinch_tree_search *s)
{
    *s = (pinch_tree_search){.count = count,
                             .runs = PINCH_ARENA_ARRAY(arena, pinch_row_run, rows.count),
                             .place = PINCH_ARENA_ARRAY(arena, int, count),
                             .slot = PINCH_ARENA_ARRAY(arena, int, count),
                             .parent = PINCH_ARENA_ARRAY(arena, int, count)};
    if (arena->failed) return false;
    find_runs(s, problem, slot_of, rows);
    place_bodies(s);
    return s->placed == count;
}
