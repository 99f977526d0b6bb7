/*
 * Random grasps. The default mode must end every one of them with a verified answer, with a proof that there is none,
 * or with an escape. The answers of linearized and exact cone must agree as the faces grow, and so must the forms of
 * the complementarity problem. A normal run does a hundredth of the 10,000 grasps; PINCH_TEST_FULL or `--full` does
 * all.
 */
#include "support/cmocka_all.h"
#include "support/grasps.h"

#include <stdlib.h>
#include <string.h>

static int full_count = 100;
static pinch_statics *statics;

static int set_up(void **state)
{
    (void)state;
    return pinch_statics_create(GRASP_MAX_FINGERS, 32, &statics) == PINCH_OK ? 0 : -1;
}

static int tear_down(void **state)
{
    (void)state;
    pinch_statics_destroy(statics);
    return 0;
}

typedef struct tally {
    int count[PINCH_SOLVE_UNVERIFIED + 1];
    int by[PINCH_SOLVED_BY_COUNT]; /* of those that converged */
} tally;

static bool proven(const test_grasp *g, const pinch_statics_settings *settings, const pinch_statics_result *r)
{
    return pinch_statics_proves_infeasible(&g->grasp, settings, r->twist);
}

/* Checks one result for what its status promises, and counts it. */
static void examine(const test_grasp *g, const pinch_statics_settings *settings, const pinch_finger_result *f,
                    const pinch_statics_result *r, tally *t)
{
    t->count[r->solve.status]++;
    pinch_static_verification again;
    switch (r->solve.status) {
    case PINCH_SOLVE_CONVERGED:
        pinch_statics_verify(&g->grasp, settings, f, r, &again);
        assert_true(again.passed);
        t->by[pinch_solver_solved_by(&settings->solver, &r->solve)]++;
        assert_true(r->load_fraction == 1.0);
        return;
    case PINCH_SOLVE_INFEASIBLE:
        assert_true(proven(g, settings, r));
        break;
    case PINCH_SOLVE_UNSTABLE:
        assert_false(proven(g, settings, r));
        assert_true(isnan(r->load_fraction) || (r->load_fraction >= 0.0 && r->load_fraction < 1.0));
        break;
    default:
        break;
    }
    for (int i = 0; i < g->grasp.finger_count; i++) assert_true(isnan(f[i].r[0]) && isnan(f[i].force[1]));
    assert_true(isnan(r->translation[0]));
}

static tally solve_many(pinch_statics_settings settings, uint64_t seed, int count)
{
    tally t = {.count = {0}};
    pinch_random random;
    pinch_random_seed(&random, seed);
    for (int i = 0; i < count; i++) {
        test_grasp g;
        grasp_random(&random, &g);
        pinch_finger_result f[GRASP_MAX_FINGERS];
        pinch_statics_result r;
        assert_int_equal(pinch_statics_solve(statics, &g.grasp, &settings, f, &r), PINCH_OK);
        examine(&g, &settings, f, &r, &t);
    }
    print_message("of %d: %d held, %d infeasible, %d unstable\n", count, t.count[PINCH_SOLVE_CONVERGED],
                  t.count[PINCH_SOLVE_INFEASIBLE], t.count[PINCH_SOLVE_UNSTABLE]);
    return t;
}

static pinch_solve_status solve_scaled(const test_grasp *g, double friction, double load, double grip)
{
    test_grasp scaled = *g;
    scaled.grasp.fingers = scaled.fingers;
    for (int i = 0; i < g->grasp.finger_count; i++) {
        scaled.fingers[i].friction *= friction;
        scaled.fingers[i].torsional_friction *= friction;
        scaled.fingers[i].closing *= grip;
        scaled.fingers[i].normal_force *= grip;
    }
    for (int j = 0; j < 6; j++) scaled.grasp.wrench[j] *= load;
    pinch_statics_settings settings = pinch_default_statics_settings();
    pinch_finger_result f[GRASP_MAX_FINGERS];
    pinch_statics_result r;
    assert_int_equal(pinch_statics_solve(statics, &scaled.grasp, &settings, f, &r), PINCH_OK);
    return r.solve.status;
}

typedef enum scaled { FRICTION, LOAD, GRIP } scaled;

/* Each end of the bracket is what it is called when it is solved by itself. True when the limit was found. */
static bool check_limit(const test_grasp *g, const pinch_static_limit *limit, scaled what)
{
    const double ends[2] = {limit->holds, limit->fails};
    for (int e = 0; e < 2; e++)
        if (isfinite(ends[e])) {
            double factor[3] = {1.0, 1.0, 1.0};
            factor[what] = ends[e];
            pinch_solve_status status = solve_scaled(g, factor[FRICTION], factor[LOAD], factor[GRIP]);
            assert_int_equal(status == PINCH_SOLVE_CONVERGED, e == 0);
        }
    if (limit->status == PINCH_SOLVE_CONVERGED && isfinite(limit->fails) && isfinite(limit->holds)) {
        assert_true(what == LOAD ? limit->fails > limit->holds : limit->fails < limit->holds);
        assert_close(limit->fails, limit->holds, 1e-6 * fmax(limit->fails, limit->holds));
    }
    return limit->status == PINCH_SOLVE_CONVERGED;
}

static void limits_are_where_solves_change_their_mind(void **state)
{
    (void)state;
    pinch_statics_settings settings = pinch_default_statics_settings();
    pinch_random random;
    pinch_random_seed(&random, 37);
    int held = 0, found = 0, wanted = full_count / 20;
    while (held < wanted) {
        test_grasp g;
        grasp_random(&random, &g);
        pinch_static_limits limits;
        if (solve_scaled(&g, 1.0, 1.0, 1.0) != PINCH_SOLVE_CONVERGED) continue;
        held++;
        assert_int_equal(pinch_statics_limits(statics, &g.grasp, &settings, &limits), PINCH_OK);
        const pinch_static_limit *friction = &limits.smallest_friction, *load = &limits.largest_load_factor;
        assert_true(load->holds >= 1.0 && !(friction->holds > 1.0));
        found += check_limit(&g, friction, FRICTION) + check_limit(&g, load, LOAD);
        pinch_static_limit grip;
        assert_int_equal(pinch_statics_least_closing(statics, &g.grasp, &settings, &grip), PINCH_OK);
        assert_true(!(grip.holds > 1.0));
        found += check_limit(&g, &grip, GRIP);
    }
    print_message("of %d limits %d found to 1e-6\n", 3 * held, found);
    assert_true(found >= 3 * held / 2);
}

static int undecided(const tally *t, int count)
{
    return count - t->count[PINCH_SOLVE_CONVERGED] - t->count[PINCH_SOLVE_INFEASIBLE] - t->count[PINCH_SOLVE_UNSTABLE];
}

static void default_mode_decides_random_grasps(void **state)
{
    (void)state;
    tally t = solve_many(pinch_default_statics_settings(), 31, full_count);
    assert_int_equal(t.count[PINCH_SOLVE_UNVERIFIED], 0);
    assert_true(undecided(&t, full_count) <= 2);
    assert_true(t.count[PINCH_SOLVE_CONVERGED] >= full_count / 2);
}

static void one_step_and_linearized_modes_do_too(void **state)
{
    (void)state;
    pinch_statics_settings settings = pinch_default_statics_settings();
    settings.one_step = true;
    tally t = solve_many(settings, 32, full_count / 4);
    /* Newton's steps alone settle about half of them */
    assert_true(t.by[PINCH_SOLVED_BY_NEWTON] + t.by[PINCH_SOLVED_BY_PROJECTIONS] > 0 && t.by[PINCH_SOLVED_BY_FLOW] > 0);
    assert_int_equal(t.count[PINCH_SOLVE_UNVERIFIED], 0);
    assert_true(undecided(&t, full_count / 4) <= 2);
    settings.formulation = PINCH_FORMULATION_LCP;
    t = solve_many(settings, 33, full_count / 4);
    assert_int_equal(t.count[PINCH_SOLVE_UNVERIFIED], 0);
    assert_true(undecided(&t, full_count / 4) <= 2);
    settings.inscribed = true;
    t = solve_many(settings, 34, full_count / 4);
    assert_int_equal(t.count[PINCH_SOLVE_UNVERIFIED], 0);
    assert_true(undecided(&t, full_count / 4) <= 2);
}

/* Whatever a complementarity solver calls converged is an answer. */
static void every_solver_s_answers_are_verified(void **state)
{
    (void)state;
    static const pinch_solver solvers[] = {PINCH_SOLVER_LEMKE, PINCH_SOLVER_NEWTON, PINCH_SOLVER_PGS};
    for (size_t s = 0; s < sizeof solvers / sizeof *solvers; s++) {
        pinch_statics_settings settings = pinch_default_statics_settings();
        settings.formulation = PINCH_FORMULATION_LCP;
        settings.solver.solver = solvers[s];
        settings.solver.max_iterations = 200;
        settings.faces = 6;
        tally t = solve_many(settings, 35, full_count / 4);
        /* residuals are of the non-dimensional system: what passes 1e-10 there may miss 1e-9 of a smaller force scale
         */
        assert_true(t.count[PINCH_SOLVE_UNVERIFIED] <= full_count / 20);
        if (solvers[s] == PINCH_SOLVER_LEMKE) assert_true(t.count[PINCH_SOLVE_CONVERGED] >= full_count / 8);
    }
}

/* One step of the exact cone against pyramids of more and more faces, hard fingers: the difference must fall. */
static void pyramids_approach_the_cone(void **state)
{
    (void)state;
    static const int faces[] = {4, 8, 32, 128};
    enum { LEVELS = 4, MOST = 400 };
    static double difference[LEVELS][MOST];
    int found = 0;
    pinch_random random;
    pinch_random_seed(&random, 36);
    for (int i = 0; i < full_count && found < MOST; i++) {
        test_grasp g;
        grasp_random(&random, &g);
        for (int k = 0; k < g.grasp.finger_count; k++)
            if (g.fingers[k].model == PINCH_CONTACT_SOFT) g.fingers[k].model = PINCH_CONTACT_HARD;
        pinch_statics_settings settings = pinch_default_statics_settings();
        settings.one_step = true;
        pinch_finger_result exact[GRASP_MAX_FINGERS], f[GRASP_MAX_FINGERS];
        pinch_statics_result r;
        pinch_statics_solve(statics, &g.grasp, &settings, exact, &r);
        if (r.solve.status != PINCH_SOLVE_CONVERGED || g.grasp.planar) continue;
        double scale = r.verification.force_scale;
        settings.formulation = PINCH_FORMULATION_LCP;
        bool all = true;
        for (int level = 0; level < LEVELS && all; level++) {
            settings.faces = faces[level];
            pinch_statics_solve(statics, &g.grasp, &settings, f, &r);
            all = r.solve.status == PINCH_SOLVE_CONVERGED;
            double worst = 0.0;
            for (int k = 0; all && k < g.grasp.finger_count; k++)
                for (int j = 0; j < 3; j++) worst = fmax(worst, fabs(f[k].force[j] - exact[k].force[j]));
            difference[level][found] = worst / scale;
        }
        found += all;
    }
    assert_true(found == MOST || found >= full_count / 4);
    /* where something slips the median of the differences falls level by level; sticking grasps are equal anyway */
    double sum[LEVELS] = {0.0};
    int counted = 0;
    for (int i = 0; i < found; i++) {
        if (difference[0][i] < 1e-6 || difference[0][i] > 0.5) continue;
        counted++;
        for (int level = 0; level < LEVELS; level++) sum[level] += log(difference[level][i] + 1e-12);
    }
    assert_true(counted > 0);
    for (int level = 1; level < LEVELS; level++) assert_true(sum[level] < sum[level - 1]);
    print_message("geometric mean of the difference at 4, 8, 32, 128 faces: %.2g %.2g %.2g %.2g\n",
                  exp(sum[0] / counted), exp(sum[1] / counted), exp(sum[2] / counted), exp(sum[3] / counted));
}

int main(int argc, char **argv)
{
    if (getenv("PINCH_TEST_FULL") || (argc > 1 && strcmp(argv[1], "--full") == 0)) full_count = 10000;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(default_mode_decides_random_grasps),
        cmocka_unit_test(one_step_and_linearized_modes_do_too),
        cmocka_unit_test(every_solver_s_answers_are_verified),
        cmocka_unit_test(limits_are_where_solves_change_their_mind),
        cmocka_unit_test(pyramids_approach_the_cone),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
