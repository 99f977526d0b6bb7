/* Couplings of rates: which hard rows for more than two bodies the velocities as unknowns can have. */
#include "kinematics/mobility.h"

#include <string.h>

/* The unknown whose rate row k is along, or -1. */
static int unknown_of_rate(const pinch_problem *problem, const pinch_mobility *mobility, int k)
{
    int direction = mobility->loose.rate[k].direction;
    if (direction < 0) return -1;
    const pinch_cluster *cluster = &mobility->clusters[pinch_cluster_of_row(mobility, &problem->rows[k])];
    return cluster->first + cluster->space->unknown[direction];
}

/* Counts for each rate how many rows without compliance and without a bound act on it: stops and couplings. Returns
 * false where a coupling is of something else as well. */
static bool count_stiff_rows(const pinch_problem *problem, const pinch_mobility *mobility, int *stiff)
{
    bool coupling = false, counts = false; /* of the row that this one is, or continues */
    for (int i = 0; i < mobility->remaining_count; i++) {
        int k = mobility->remaining[i];
        const pinch_joint_row *row = &problem->rows[k];
        if (!row->continues) {
            counts = row->cfm == 0 && (row->low == -INFINITY || row->high == INFINITY);
            coupling = pinch_row_is_coupling(problem, k);
        }
        int unknown = unknown_of_rate(problem, mobility, k);
        if (unknown < 0 && coupling) return false;
        if (unknown >= 0 && counts) stiff[unknown]++;
    }
    return true;
}

bool pinch_couplings_follow_rates(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility)
{
    int *stiff = PINCH_ARENA_ARRAY(arena, int, mobility->unknowns + 1);
    if (!stiff || !mobility->loose.rate) return false;
    for (int i = 0; i < mobility->unknowns; i++) stiff[i] = 0;
    if (!count_stiff_rows(problem, mobility, stiff)) return false;
    for (int r = 0; r < mobility->remaining_count; r++) {
        int k = mobility->remaining[r];
        bool follows = false;
        if (!pinch_row_is_coupling(problem, k)) continue;
        for (int i = 0, parts = pinch_row_parts(problem, k); i < parts && !follows; i++)
            follows = stiff[unknown_of_rate(problem, mobility, k + i)] == 1;
        if (!follows) return false;
    }
    return true;
}

/* The first cluster with loops that a row acts on, or NULL. */
static const pinch_cluster *looped_cluster_of(const pinch_mobility *mobility, const pinch_joint_row *row)
{
    const int body[2] = {row->body1, row->body2};
    for (int side = 0; side < 2; side++) {
        if (body[side] < 0) continue;
        const pinch_cluster *cluster = &mobility->clusters[mobility->cluster_of[body[side]]];
        if (cluster->space && cluster->space->loops) return cluster;
    }
    return NULL;
}

bool pinch_loops_are_held_once(pinch_arena *arena, const pinch_problem *problem, const pinch_mobility *mobility)
{
    bool *held = PINCH_ARENA_ARRAY(arena, bool, mobility->unknowns + 1);
    if (!held) return false;
    memset(held, 0, sizeof *held * (size_t)(mobility->unknowns + 1));
    for (int i = 0; i < mobility->remaining_count; i++) {
        int k = mobility->remaining[i];
        const pinch_joint_row *row = &problem->rows[k];
        if (row->cfm > 0 || row->continues || pinch_row_goes_on(problem, k)) continue;
        if (!looped_cluster_of(mobility, row)) continue;
        int unknown = unknown_of_rate(problem, mobility, k);
        if (unknown < 0 || held[unknown]) return false;
        held[unknown] = true;
    }
    return true;
}
