/* Published values beside ours, and what becomes of the paper's claims. Everything is read from the document. */
#include "paper.h"

#include "common/output.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

static const char *text_of(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? text : "";
}

static double number_of(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    return json_is_number(value) ? json_number_value(value) : NAN;
}

static const json_t *named(const json_t *list, const char *key, const char *name)
{
    size_t i;
    json_t *entry;
    json_array_foreach(list, i, entry) if (strcmp(text_of(entry, key), name) == 0) return entry;
    return NULL;
}

static const json_t *row_of(const json_t *document, const char *example, const json_t *faces)
{
    size_t i;
    json_t *row;
    json_array_foreach(json_object_get(document, "rows"), i, row)
    {
        if (strcmp(text_of(row, "example"), example) == 0 && json_equal(json_object_get(row, "faces"), faces))
            return row;
    }
    return NULL;
}

/* ---- Published values. ---- */

/* What this run has for a published value; NaN where it was not asked for. */
static double our_value(const json_t *document, const json_t *value)
{
    const char *method = text_of(value, "method"), *quantity = text_of(value, "quantity");
    const char *finger = text_of(value, "finger"), *example = text_of(value, "example");
    if (*finger) {
        const json_t *e = named(json_object_get(document, "examples"), "example", example);
        const json_t *a = json_object_get(json_object_get(e, "answers"), method);
        return number_of(named(json_object_get(a, "fingers"), "name", finger), quantity);
    }
    const json_t *row = row_of(document, example, json_object_get(value, "faces"));
    return number_of(strcmp(method, "both") == 0 ? row : json_object_get(row, method), quantity);
}

json_t *paper_comparison_document(const json_t *document, const json_t *published)
{
    json_t *list = json_array(), *value;
    size_t i;
    json_array_foreach(json_object_get(published, "values"), i, value)
    {
        double theirs = number_of(value, "value"), ours = our_value(document, value);
        double tolerance = number_of(value, "tolerance");
        bool relative = json_is_true(json_object_get(value, "relative"));
        double difference = ours - theirs;
        bool within = fabs(difference) <= tolerance * (relative ? fabs(theirs) : 1.0);
        json_t *entry = json_deep_copy(value);
        json_object_set_new(entry, "ours", json_number(ours));
        json_object_set_new(entry, "difference", json_number(difference));
        json_object_set_new(entry, "relative_difference", json_number(difference / theirs));
        json_object_set_new(entry, "within_tolerance",
                            isnan(tolerance) || isnan(ours) ? json_null() : json_boolean(within));
        json_array_append_new(list, entry);
    }
    return list;
}

/* ---- Claims. ---- */

/* Appends a claim with its verdict and figures, which are a text with numbers in it and the numbers themselves. */
static void add_claim(json_t *claims, const char *claim, const char *verdict, json_t *figures, const char *why)
{
    json_array_append_new(claims, json_pack("{s:s, s:s, s:o, s:s}", "claim", claim, "verdict", verdict, "figures",
                                            figures, "remark", why));
}

static json_t *figure_of(const char *name, double value)
{
    return json_pack("{s:s, s:o}", "name", name, "value", json_number(value));
}

/* In how many rows is the quantity of NSNMGK less than that of NSNGRK? */
static int rows_won(const json_t *document, const char *quantity)
{
    int won = 0;
    size_t i;
    json_t *row;
    json_array_foreach(json_object_get(document, "rows"), i, row) won +=
        number_of(json_object_get(row, "nsnmgk"), quantity) < number_of(json_object_get(row, "nsngrk"), quantity);
    return won;
}

static void claim_by_rows(const json_t *document, json_t *claims, const char *claim, const char *quantity,
                          const char *why)
{
    int rows = (int)json_array_size(json_object_get(document, "rows")), won = rows_won(document, quantity);
    add_claim(claims, claim, won == rows ? "reproduced" : "not reproduced",
              json_pack("[o, o]", figure_of("rows in which it is so", won), figure_of("rows", rows)), why);
}

static void claim_speedups(const json_t *document, json_t *claims)
{
    int known = 0, met = 0;
    double least = INFINITY;
    size_t i;
    json_t *value, *row;
    json_array_foreach(json_object_get(document, "rows"), i, row) least = fmin(least, number_of(row, "speedup"));
    add_claim(claims, "NSNMGK takes less time than NSNGRK on every example.",
              least > 1.0 ? "reproduced" : "not reproduced", json_pack("[o]", figure_of("least speed-up", least)), "");
    json_array_foreach(json_object_get(document, "comparison"), i, value)
    {
        const json_t *within = json_object_get(value, "within_tolerance");
        if (strcmp(text_of(value, "quantity"), "speedup") != 0 || json_is_null(within)) continue;
        known++;
        met += json_is_true(within);
    }
    add_claim(claims, "The speed-ups are those of the tables.",
              known == 0     ? "cannot be checked"
              : met == known ? "reproduced"
                             : "not reproduced",
              json_pack("[o, o]", figure_of("within a tenth", met), figure_of("published and run here", known)),
              "A sweep contains all that a draw does but for one random number. The ratio of times follows the ratio "
              "of iterations, and that depends on parameters that are lost.");
}

/* Does the speed-up of the example grow from 4 to 8 faces? */
static void claim_growth(const json_t *document, json_t *claims, const char *example)
{
    json_t *four = json_integer(4), *eight = json_integer(8);
    const json_t *low = row_of(document, example, four), *high = row_of(document, example, eight);
    double a = number_of(low, "speedup"), b = number_of(high, "speedup");
    char claim[128];
    snprintf(claim, sizeof claim, "The speed-up grows with the problem: from 4 to 8 faces in Example %s.", example);
    add_claim(claims, claim,
              isnan(a) || isnan(b) ? "cannot be checked"
              : b > a              ? "reproduced"
                                   : "not reproduced",
              json_pack("[o, o]", figure_of("speed-up at 4 faces", a), figure_of("at 8 faces", b)), "");
    json_decref(four);
    json_decref(eight);
}

static double force_error(const json_t *example, const char *method, const char *which)
{
    const json_t *answer = json_object_get(json_object_get(example, "answers"), method);
    return number_of(json_object_get(answer, "force_error_N"), which);
}

/* "More accurate": by the residual, and by the forces themselves. */
static void claim_accuracy(const json_t *document, json_t *claims)
{
    int better = 0, examples = 0;
    size_t i;
    json_t *example;
    claim_by_rows(document, claims, "The final residual of NSNMGK is lower than the mean one of NSNGRK.", "residual",
                  "Both methods stop as soon as the residual is below 1e-4. Where below is chance.");
    json_array_foreach(json_object_get(document, "examples"), i, example)
    {
        examples++;
        better += force_error(example, "nsnmgk", "worst") < force_error(example, "nsngrk", "median");
    }
    add_claim(claims, "NSNMGK's forces are more accurate than NSNGRK's.",
              better == examples ? "reproduced" : "not reproduced",
              json_pack("[o, o]", figure_of("examples in which its error is below NSNGRK's median one", better),
                        figure_of("examples", examples)),
              "Error: the largest distance of a finger's force from the exact one.");
    const json_t *prism = named(json_object_get(document, "examples"), "example", "2");
    double worst = force_error(prism, "nsngrk", "worst");
    add_claim(claims, "At 5 faces, NSNGRK's forces in Example 2 deviate from the physical ones by about 0.3 N.",
              worst >= 0.1 ? "reproduced" : "not reproduced",
              json_pack("[o]", figure_of("largest error of all seeds, N", worst)),
              "With our stiffnesses a residual of 1e-4 leaves no room for such errors; the published ones are lost.");
}

static void claim_idle_fingers(const json_t *document, json_t *claims)
{
    const json_t *examples = json_object_get(document, "examples");
    const json_t *first = json_object_get(json_object_get(named(examples, "example", "1"), "answers"), "nsnmgk");
    const json_t *other = json_object_get(json_object_get(named(examples, "example", "1b"), "answers"), "nsnmgk");
    int idle = 0;
    double apart = 0.0, moved = 0.0;
    size_t i;
    json_t *finger;
    json_array_foreach(json_object_get(first, "fingers"), i, finger)
    {
        double force = number_of(finger, "normal_force");
        idle += fabs(force) < 1e-3;
        const json_t *same = named(json_object_get(other, "fingers"), "name", text_of(finger, "name"));
        if (force >= 1e-3) apart = fmax(apart, fabs(force - number_of(same, "normal_force")));
    }
    for (size_t j = 0; j < 3; j++)
        moved =
            fmax(moved, fabs(json_number_value(
                                 json_array_get(json_object_get(json_object_get(first, "object"), "translation"), j)) -
                             json_number_value(
                                 json_array_get(json_object_get(json_object_get(other, "object"), "translation"), j))));
    add_claim(claims, "Three of the six fingers of Example 1 exert no force.",
              idle == 3 ? "reproduced" : "not reproduced", json_pack("[o]", figure_of("fingers below 0.001 N", idle)),
              "By the choice of our parameters.");
    add_claim(claims, "Example 1b has the forces of Example 1 and other displacements.",
              apart < 1e-2 && moved > 1e-2 ? "reproduced" : "not reproduced",
              json_pack("[o, o]", figure_of("largest difference of forces, N", apart),
                        figure_of("of the object's displacement, m", moved)),
              "By the choice of our parameters.");
}

/* Do all examples fail with that solver? */
static void claim_failure(const json_t *document, json_t *claims, const char *solver, const char *claim)
{
    int solved = 0, runs = 0;
    size_t i, k;
    json_t *of, *entry;
    json_array_foreach(json_object_get(document, "solvers"), i, of)
        json_array_foreach(json_object_get(of, "results"), k, entry)
    {
        if (strcmp(text_of(entry, "solver"), solver) != 0) continue;
        runs++;
        solved += strcmp(text_of(entry, "status"), "converged") == 0;
    }
    add_claim(claims, claim,
              runs == 0     ? "cannot be checked"
              : solved == 0 ? "reproduced"
                            : "not reproduced",
              json_pack("[o, o]", figure_of("problems solved", solved), figure_of("problems", runs)), "");
}

/* The largest random grasps that both methods were tried on. */
static void claim_size(const json_t *document, json_t *claims)
{
    const json_t *nsnmgk = NULL, *nsngrk = NULL, *standard = NULL, *fingers = NULL;
    size_t i;
    json_t *size;
    json_array_foreach(json_object_get(json_object_get(document, "random_grasps"), "sizes"), i, size)
    {
        const json_t *results = json_object_get(size, "results"), *found = named(results, "solver", "nsnmgk");
        if (!found) continue;
        nsnmgk = found;
        nsngrk = named(results, "solver", "nsngrk");
        standard = json_array_get(results, 0);
        fingers = json_object_get(size, "fingers");
    }
    double solved = number_of(nsnmgk, "solved"), held = number_of(standard, "solved");
    double faster = number_of(nsngrk, "time_s") / number_of(nsnmgk, "time_s");
    add_claim(claims, "NSNMGK suits large problems better than NSNGRK.",
              !nsnmgk                          ? "cannot be checked"
              : solved >= held && faster > 1.0 ? "reproduced"
                                               : "not reproduced",
              json_pack("[o, o, o, o, o]", figure_of("fingers", fingers ? json_number_value(fingers) : NAN),
                        figure_of("grasps solved by NSNMGK", solved),
                        figure_of("by NSNGRK", number_of(nsngrk, "solved")),
                        figure_of("time of NSNGRK over NSNMGK", faster),
                        figure_of("of NSNMGK over the default mode",
                                  number_of(nsnmgk, "time_s") / number_of(standard, "time_s"))),
              "The paper itself has no large problem. These are the largest random grasps that were tried.");
}

/* The paper's future work: runs by projections alone. */
static void claim_dynamics(const json_t *document, json_t *claims)
{
    int scenes = 0, alone = 0;
    double apart = 0.0, cost = 0.0;
    size_t i;
    json_t *of;
    json_array_foreach(json_object_get(document, "dynamics"), i, of)
    {
        const json_t *runs = json_object_get(of, "runs"), *standard = json_array_get(runs, 0),
                     *r = json_array_get(runs, 1);
        scenes++;
        alone += number_of(r, "first_solves_failed") == 0 && strcmp(text_of(r, "status"), "converged") == 0;
        apart = fmax(apart, number_of(r, "force_difference_N"));
        cost = fmax(cost, number_of(r, "step_us") / number_of(standard, "step_us"));
    }
    add_claim(
        claims, "Future work: the method can be extended to dynamic grasps.",
        scenes == 0       ? "cannot be checked"
        : alone == scenes ? "reproduced"
                          : "not reproduced",
        json_pack("[o, o, o, o]", figure_of("scenes run by projections alone", alone), figure_of("scenes", scenes),
                  figure_of("largest difference of a force from the default mode, N", apart),
                  figure_of("most that a step costs over the default mode's", cost)),
        "On the system with end velocities as unknowns and the exact cone. The table of dynamics has the details.");
}

json_t *paper_claims_document(const json_t *document)
{
    json_t *claims = json_array();
    claim_by_rows(document, claims, "NSNMGK takes fewer iterations than NSNGRK on every example.", "iterations", "");
    claim_speedups(document, claims);
    claim_growth(document, claims, "2");
    claim_growth(document, claims, "3");
    claim_accuracy(document, claims);
    claim_idle_fingers(document, claims);
    claim_failure(document, claims, "pgs", "Projected Gauss-Seidel does not converge on these problems.");
    claim_failure(document, claims, "modulus", "Modulus-based splitting does not converge on these problems.");
    claim_size(document, claims);
    claim_dynamics(document, claims);
    add_claim(claims, "The times in seconds.", "cannot be checked", json_array(),
              "They were measured on another machine with another program.");
    return claims;
}
