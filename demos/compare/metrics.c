#include "metrics.h"

#include <string.h>

const double metric_thresholds[METRIC_THRESHOLDS] = {1e-6, 1e-5, 1e-4, 1e-3, 1e-2};

static const metric_info table[METRIC_COUNT] = {
    [METRIC_FORCE_ERROR_MAX] = {"force_error_max", "1", "largest force error",
                                "of a contact's force against the exact answer of the same step, over the step's force "
                                "scale; largest over the sampled steps"},
    [METRIC_FORCE_ERROR_MEDIAN] = {"force_error_median", "1", "median force error",
                                   "the same: each sampled step's largest, median over the steps"},
    [METRIC_FORCE_JITTER] = {"force_jitter", "N", "force jitter",
                             "root mean square over the second half of what a finger's force changes beyond a steady "
                             "change, as noise on each step; the worst finger's"},
    [METRIC_CREEP] = {"creep", "m/s", "creep", "of the object, mean over the second half"},
    [METRIC_CREEP_ANGULAR] = {"creep_angular", "rad/s", "angular creep", "of the object, mean over the second half"},
    [METRIC_CREEP_IN_HAND] =
        {"creep_in_hand", "m/s", "creep in the hand",
         "of the object against the hand that carries it, mean over the second half; where no hand "
         "moves the same as creep"},
    [METRIC_CREEP_IN_HAND_ANGULAR] = {"creep_in_hand_angular", "rad/s", "angular creep in the hand", "likewise"},
    [METRIC_DISPLACEMENT] = {"displacement", "m", "displacement", "of the object from the start to the end"},
    [METRIC_ROTATION] = {"rotation", "rad", "rotation", "of the object from the start to the end"},
    [METRIC_GRIP_FORCE] = {"grip_force", "N", "grip force", "sum of the fingers' normal forces at the end"},
    [METRIC_SLIP] = {"slip", "m", "slip", "path that the contact has slipped at the finger that slips most"},
    [METRIC_SLIP_MARGIN] = {"slip_margin", "1", "slip margin",
                            "part of its friction that the finger nearest to slipping has left at the end"},
    [METRIC_PENETRATION] = {"penetration", "m", "penetration", "largest depth of a contact over the run"},
    [METRIC_POINTS] = {"points", "1", "contact points", "of the fingers on the object under load, mean over the steps"},
    [METRIC_MOMENTUM_ERROR] = {"momentum_error", "N", "momentum balance",
                               "largest difference over the steps between the object's change of momentum and the "
                               "reported forces"},
    [METRIC_ANGULAR_MOMENTUM_ERROR] = {"angular_momentum_error", "N m", "angular momentum balance",
                                       "the same for moments about its centre of mass"},
    [METRIC_ENERGY_CLOSURE] = {"energy_closure", "J", "energy left over",
                               "what the energy ledger does not account for at the end"},
    [METRIC_ENERGY_CLOSURE_RELATIVE] = {"energy_closure_relative", "1", "energy left over, of the work",
                                        "the same over the work of all forces"},
    [METRIC_CONSTRAINT_ERROR] = {"constraint_error", "m", "joint error",
                                 "largest distance of a tip on a slider from its rail"},
    [METRIC_CONSTRAINT_ERROR_ANGULAR] = {"constraint_error_angular", "rad", "joint error, turning",
                                         "largest angle of a tip on a slider against its rail"},
    [METRIC_DETERMINISTIC] = {"deterministic", "", "same bits again", "does a second run end in the same bits?"},
    [METRIC_VERIFIED] = {"verified", "", "verified", "was every step solved and verified?"},
    [METRIC_DROPPED] = {"dropped", "", "dropped", "was the object dropped?"},
    [METRIC_UNCONVERGED_STEPS] = {"unconverged_steps", "1", "steps solved late", "steps whose first solve failed"},
    [METRIC_ITERATIONS_MEAN] = {"iterations_mean", "1", "iterations, mean", "of a solve"},
    [METRIC_ITERATIONS_MAX] = {"iterations_max", "1", "iterations, largest", "of a solve"},
    [METRIC_START_RESIDUAL] = {"start_residual", "1", "residual at the start",
                               "how far from its answer Pinch's solve starts, in its own residual; median over the "
                               "sampled steps"},
    [METRIC_DIVERGENCE_MAX] = {"divergence_max", "m", "largest divergence",
                               "largest distance of the object's pose from that of Pinch's run: hypot of the "
                               "distance and of the angle times the object's bounding radius"},
    [METRIC_DIVERGENCE_END] = {"divergence_end", "m", "divergence at the end", "that distance at the end"},
    [METRIC_DIVERGES_1UM] = {"diverges_1um", "s", "1 um apart after", "when the runs are that far apart first"},
    [METRIC_DIVERGES_10UM] = {"diverges_10um", "s", "10 um apart after", "when the runs are that far apart first"},
    [METRIC_DIVERGES_100UM] = {"diverges_100um", "s", "0.1 mm apart after", "when the runs are that far apart first"},
    [METRIC_DIVERGES_1MM] = {"diverges_1mm", "s", "1 mm apart after", "when the runs are that far apart first"},
    [METRIC_DIVERGES_10MM] = {"diverges_10mm", "s", "10 mm apart after", "when the runs are that far apart first"},
    [METRIC_COST] = {"cost", "us", "cost of a step",
                     "wall time from the first contact handed over to the emptying of the contacts, median over the "
                     "steps of runs that take turns of 50 steps"},
};

const metric_info *metric_about(metric m)
{
    return &table[m];
}

metric metric_of_key(const char *key)
{
    int m = 0;
    while (m < METRIC_COUNT && strcmp(table[m].key, key) != 0) m++;
    return (metric)m;
}

/* The tolerances say which changes mean something; they are not about bits. Another compiler or a faster solver moves
 * the last digits of everything, and in long runs a few more. A stiffness that is 1 % off moves displacements by 1 %, a
 * friction coefficient moves the slip margin, a lost manifold point the number of points, a lost warm start the
 * residual at which solves start. Cost is never checked. */
typedef struct entry {
    metric m;
    tolerance t;
} entry;

static const entry pinch[] = {
    {METRIC_FORCE_ERROR_MAX, {1e-9, 0}},    /* what Pinch promises */
    {METRIC_FORCE_ERROR_MEDIAN, {1e-9, 0}}, /* likewise */
    {METRIC_FORCE_JITTER, {1e-6, 0.1}},
    {METRIC_CREEP, {1e-9, 0.02}},         /* a nanometre in a second */
    {METRIC_CREEP_ANGULAR, {1e-7, 0.02}}, /* the same at a lever of a centimetre */
    {METRIC_DISPLACEMENT, {1e-8, 2e-3}},
    {METRIC_ROTATION, {1e-6, 5e-3}},
    {METRIC_GRIP_FORCE, {1e-6, 1e-3}},
    {METRIC_SLIP, {1e-8, 0.02}},
    {METRIC_SLIP_MARGIN, {1e-3, 0}},
    {METRIC_PENETRATION, {1e-8, 2e-3}},
    {METRIC_POINTS, {0.02, 0.005}},
    {METRIC_MOMENTUM_ERROR, {1e-8, 0}},
    {METRIC_ANGULAR_MOMENTUM_ERROR, {1e-8, 0.5}}, /* for moving bodies it is the second order of the time step */
    {METRIC_ENERGY_CLOSURE_RELATIVE, {1e-5, 0.2}},
    {METRIC_CONSTRAINT_ERROR, {1e-8, 0.1}},
    {METRIC_CONSTRAINT_ERROR_ANGULAR, {1e-7, 0.1}},
    {METRIC_DETERMINISTIC, {0, 0}},
    {METRIC_VERIFIED, {0, 0}},
    {METRIC_DROPPED, {0, 0}},
    {METRIC_UNCONVERGED_STEPS, {2, 0.5}},
    {METRIC_ITERATIONS_MEAN, {0.2, 0.3}}, /* about half of the steps at rest need no iteration, depending on rounding */
    {METRIC_ITERATIONS_MAX, {6, 0.5}},
    {METRIC_START_RESIDUAL, {0.05, 0}}, /* a warm start is below 0.02, a cold one 0.1 to 1 */
};

/* ODE's solvers are there to be seen beside Pinch; what they do is not Pinch's to promise. */
static const entry ode[] = {
    {METRIC_FORCE_ERROR_MEDIAN, {5e-3, 0.5}},
    {METRIC_DETERMINISTIC, {0, 0}},
};

tolerance tolerance_default(metric m, bool of_ode)
{
    const tolerance none = {-1, 0};
    const entry *list = of_ode ? ode : pinch;
    size_t count = of_ode ? sizeof ode / sizeof *ode : sizeof pinch / sizeof *pinch;
    for (size_t i = 0; i < count; i++)
        if (list[i].m == m) return list[i].t;
    return none;
}
