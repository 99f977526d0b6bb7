/* Couplings of rates: which hard rows for more than two bodies the velocities as unknowns can have. */
#include "kinematics/mobility.h"

/* The unknown whose rate row k is along, or -1. */
static int unknown_of_rate(const pinch_problem *problem, const pinch_mobility *mobility, int k)
{
    int direction = mobility->loose.rate[k].direction;
    return direction < 0 ? -1 : mobility->clusters[pinch_cluster_of_row(mobility, &problem->rows[k])].first + direction;
}

/* Counts for each rate how many rows without compliance and without a bound act on it: stops and couplings. Returns
 * false where a coupling is of something else as well. */
static bool count_stiff_rows(const pinch_problem *problem, const pinch_mobility *mobility, int *stiff)
{
    bool coupling = false, counts = false; /* of the row that this one is, or continues */
    for (int k = 0; k < problem->row_count; k++) {
        const pinch_joint_row *row = &problem->rows[k];
        if (mobility->eliminated[k]) continue;
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
    for (int k = 0; k < problem->row_count; k++) {
        bool follows = !pinch_row_is_coupling(problem, k);
        for (int i = 0, parts = pinch_row_parts(problem, k); i < parts && !follows; i++)
            follows = stiff[unknown_of_rate(problem, mobility, k + i)] == 1;
        if (!follows) return false;
    }
    return true;
}
