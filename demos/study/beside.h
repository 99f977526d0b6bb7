#ifndef PINCH_STUDY_BESIDE_H
#define PINCH_STUDY_BESIDE_H

#include "crew.h"
#include "results.h"

/* The same study run otherwise, by another contact solver or with another step: whose verdicts differ, and who is
 * right? A trial on which they differ is run again by both with steps that are halved until the verdict stays. */

/* The most halvings, and for how many of them in a row a verdict has to stay. */
enum { BESIDE_MOST_HALVINGS = 6, BESIDE_STAYS = 2 };

/* The work of an order that is no trial: the trial `index` with its step halved 0, 1, 2, ... times, by the contact
 * solver order->kind - 1 and with the step order->value (0: the scene's). The answer is a list of rows of the table
 * `refinements`. NULL when memory runs out. */
json_t *beside_refine(const study *s, const crew_order *order, long index);
/* The same for a trial that has ended its worker. */
json_t *beside_crash(const crew_order *order, const char *status);

/* The orders that bring the first `most` trials on which both differ to verdicts that stay; those that are there are
 * left out. results_attach must have succeeded. The caller frees *list. */
bool beside_orders(results *r, const study *s, int most, crew_order **list, size_t *count, results_error *error);

/* What comes of the comparison: {"results", "contact_solver", "step", "trials": {"both_succeed", "both_fail",
 * "only_here", "only_beside"}, "differing": [trial numbers], "refined": [{"trial", "here": [...], "beside": [...],
 * "right"}]}. The lists of a refined trial are its verdicts by halvings: {"step_halvings", "success", "status",
 * "displacement", "rotation"}. `right` is "here" or "beside", where both come to rest at the same verdict;
 * "each of its own law", where they come to rest at different ones; "open", where one does not come to rest. NULL
 * after a failure. */
json_t *beside_document(results *r, const study *s, results_error *error);

#endif
