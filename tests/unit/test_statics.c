/*
 * Tests the statics of a grasp piece by piece: closed forms, forms of the complementarity problem, limits, certificates
 * and refusals.
 */
#include "support/cmocka_all.h"
#include "support/grasps.h"

#include "law/friction_cone.h"

#include <string.h>

static pinch_statics *statics;

static int set_up(void **state)
{
    (void)state;
    return pinch_statics_create(GRASP_MAX_FINGERS, 16, &statics) == PINCH_OK ? 0 : -1;
}

static int tear_down(void **state)
{
    (void)state;
    pinch_statics_destroy(statics);
    return 0;
}

static pinch_statics_result solve(const test_grasp *g, const pinch_statics_settings *settings, pinch_finger_result *f)
{
    pinch_statics_result r;
    assert_int_equal(pinch_statics_solve(statics, &g->grasp, settings, f, &r), PINCH_OK);
    return r;
}

/* Two fingers squeeze a sphere along x with `squeeze` N each; kn 1000, kt 500. */
static void make_pinch(test_grasp *g, pinch_contact_model model, double mu, double squeeze)
{
    memset(g, 0, sizeof *g);
    g->grasp = (pinch_grasp){.finger_count = 2, .fingers = g->fingers, .radius = 0.02};
    for (int i = 0; i < 2; i++) {
        pinch_finger *f = &g->fingers[i];
        *f = (pinch_finger){.point = {i == 0 ? -0.02 : 0.02, 0.0, 0.0},
                            .model = model,
                            .stiffness = {1000.0, 500.0, 0.1},
                            .friction = mu,
                            .torsional_friction = 0.004,
                            .closing = squeeze / 1000.0,
                            .max_force = INFINITY};
        grasp_set_normal(f, i == 0 ? 1.0 : -1.0, 0.0, 0.0);
    }
}

static void a_pinched_ball_sinks_by_weight_over_stiffness(void **state)
{
    (void)state;
    test_grasp g;
    make_pinch(&g, PINCH_CONTACT_SOFT, 0.5, 10.0);
    g.grasp.wrench[2] = -4.0;
    for (int mode = 0; mode < 3; mode++) {
        pinch_statics_settings settings = pinch_default_statics_settings();
        settings.one_step = mode == 1;
        if (mode == 2) settings.formulation = PINCH_FORMULATION_LCP;
        pinch_finger_result f[2];
        pinch_statics_result r = solve(&g, &settings, f);
        assert_int_equal(r.solve.status, PINCH_SOLVE_CONVERGED);
        assert_close(r.translation[2], -4.0 / 1000.0, 1e-15);
        for (int i = 0; i < 2; i++) {
            assert_int_equal(f[i].state, PINCH_CONTACT_STICK);
            assert_close(f[i].r[0], 10.0, 1e-12);
            assert_close(f[i].force[2], 2.0, 1e-12);
            assert_close(f[i].normal_displacement, 0.01, 1e-15);
            assert_close(f[i].tangential_displacement[2], -0.004, 1e-15);
            assert_close(f[i].slip_margin, 1.0 - 2.0 / 5.0, 1e-12);
        }
        assert_close(r.stiffness[0], 2000.0, 1e-9);
        assert_close(r.stiffness[14], 1000.0, 1e-9);
        /* about the squeeze axis: two torsional springs */
        assert_close(r.stiffness[21], 0.2, 1e-12);
        /* about z: the tangential springs at a lever of 0.02 */
        assert_close(r.stiffness[35], 2.0 * 500.0 * 0.0004, 1e-12);
    }
}

static void check_limits(const test_grasp *g, const pinch_statics_settings *settings, double friction, double load)
{
    pinch_static_limits limits;
    assert_int_equal(pinch_statics_limits(statics, &g->grasp, settings, &limits), PINCH_OK);
    const pinch_static_limit *least = &limits.smallest_friction, *most = &limits.largest_load_factor;
    assert_int_equal(least->status, PINCH_SOLVE_CONVERGED);
    assert_int_equal(most->status, PINCH_SOLVE_CONVERGED);
    assert_close(least->holds, friction, 1e-6 * friction);
    assert_close(most->holds, load, 1e-6 * load);
    assert_true(least->fails < least->holds && least->fails >= (1.0 - 2e-6) * friction);
    assert_true(most->fails > most->holds && most->fails <= (1.0 + 2e-6) * load);
    /* forces scale with grip and wrench together */
    pinch_static_limit grip;
    assert_int_equal(pinch_statics_least_closing(statics, &g->grasp, settings, &grip), PINCH_OK);
    assert_int_equal(grip.status, PINCH_SOLVE_CONVERGED);
    assert_close(grip.holds, 1.0 / load, 1e-6 / load);
    assert_true(grip.fails < grip.holds && grip.fails >= (1.0 - 2e-6) / load);
}

/* Five fingers on a box of 29 kg that lets go of one equilibrium when the load has grown by 42 %, and is caught in
 * another one if it stops growing soon after, or has grown far beyond. */
static void make_letting_go(test_grasp *g)
{
    static const double POINT[5][3] = {{-0.0120749, -0.01809904, -0.01529249},
                                       {0.0120749, 0.01809904, 0.01529249},
                                       {-0.00990931, 0.01734996, 0.00231873},
                                       {-0.00586098, -0.01779209, -0.01172888},
                                       {-0.0202002, 0.00257348, 0.01192068}};
    static const double SIDE[5] = {-1, 1, 1, -1, 1}, NORMAL[3] = {0.39090867, -0.67726871, -0.62329568};
    static const double STIFFNESS[5][3] = {{19.858e6, 10.668e6, 10868.6},
                                           {29.937e6, 14.874e6, 3945.5},
                                           {11.532e6, 11.816e6, 0},
                                           {7.459e6, 9.796e6, 4736.6},
                                           {31.482e6, 15.111e6, 0}};
    static const double CLOSING[5] = {1.37726e-5, 1.00264e-5, 3.55614e-5, 5.99726e-5, 1.39951e-5};
    static const double FRICTION[5] = {0.57215, 1.16755, 0.69553, 1.2774, 1.07166};
    static const double TORSIONAL[5] = {0.00281088, 0.00302564, 0, 0.00704533, 0};
    *g = (test_grasp){.grasp = {.finger_count = 5,
                                .fingers = g->fingers,
                                .wrench = {173.8755, -273.2516, 116.3943, -0.391845, -0.458898, 0.705697},
                                .radius = 0.0369}};
    for (int i = 0; i < 5; i++) {
        pinch_finger *f = &g->fingers[i];
        f->model = STIFFNESS[i][2] > 0 ? PINCH_CONTACT_SOFT : PINCH_CONTACT_HARD;
        f->friction = FRICTION[i];
        f->torsional_friction = TORSIONAL[i];
        f->closing = CLOSING[i];
        f->max_force = INFINITY;
        memcpy(f->point, POINT[i], sizeof f->point);
        memcpy(f->stiffness, STIFFNESS[i], sizeof f->stiffness);
        grasp_set_normal(f, SIDE[i] * NORMAL[0], SIDE[i] * NORMAL[1], SIDE[i] * NORMAL[2]);
    }
}

/* The largest load is the one at which paths to all larger ones let go. */
static void the_largest_load_is_one_that_may_grow_no_further(void **state)
{
    (void)state;
    test_grasp g;
    make_letting_go(&g);
    pinch_statics_settings settings = pinch_default_statics_settings();
    pinch_static_limits limits;
    pinch_static_limit grip;
    pinch_finger_result f[GRASP_MAX_FINGERS];
    assert_int_equal(pinch_statics_limits(statics, &g.grasp, &settings, &limits), PINCH_OK);
    assert_int_equal(pinch_statics_least_closing(statics, &g.grasp, &settings, &grip), PINCH_OK);
    double load = limits.largest_load_factor.holds;
    assert_int_equal(limits.largest_load_factor.status, PINCH_SOLVE_CONVERGED);
    assert_close(load, 1.42, 0.005);
    assert_close(grip.holds * load, 1.0, 1e-3); /* forces scale with grip and wrench together */
    for (int j = 0; j < 6; j++) g.grasp.wrench[j] *= 800.0;
    pinch_statics_result r = solve(&g, &settings, f);
    assert_int_equal(r.solve.status, PINCH_SOLVE_UNSTABLE);
    assert_close(800.0 * r.load_fraction, load, 1e-3 * load);
}

static void least_closing_of(const test_grasp *g, double holds, double fails)
{
    pinch_statics_settings settings = pinch_default_statics_settings();
    pinch_static_limit grip;
    assert_int_equal(pinch_statics_least_closing(statics, &g->grasp, &settings, &grip), PINCH_OK);
    assert_int_equal(grip.status, PINCH_SOLVE_CONVERGED);
    assert_int_equal(isnan(grip.holds), isnan(holds));
    assert_int_equal(isnan(grip.fails), isnan(fails));
    if (!isnan(holds)) assert_close(grip.holds, holds, 1e-6 * holds);
    if (!isnan(fails)) assert_close(grip.fails, fails, 2e-6 * fails);
}

static void the_least_grip_of_a_pinch(void **state)
{
    (void)state;
    test_grasp g;
    /* too weak a grip is closed on: 1 N of normal force with friction 0.5 carries 1 N of the 4 N */
    make_pinch(&g, PINCH_CONTACT_HARD, 0.5, 1.0);
    g.grasp.wrench[2] = -4.0;
    least_closing_of(&g, 4.0, 4.0);
    /* prescribed normal forces count as closing does */
    for (int i = 0; i < 2; i++) {
        g.fingers[i].force_controlled = true;
        g.fingers[i].normal_force = 10.0;
    }
    least_closing_of(&g, 0.4, 0.4);
    /* fingers that yield at 3 N carry 3 N at most, whatever they close by */
    make_pinch(&g, PINCH_CONTACT_HARD, 0.5, 10.0);
    g.grasp.wrench[2] = -4.0;
    for (int i = 0; i < 2; i++) g.fingers[i].max_force = 3.0;
    least_closing_of(&g, NAN, 1e6);
    /* a weight along a finger's normal needs no grip; a finger that neither closes nor presses has none */
    make_pinch(&g, PINCH_CONTACT_FRICTIONLESS, 0.0, 10.0);
    g.grasp.wrench[0] = -4.0;
    least_closing_of(&g, 0.0, NAN);
    make_pinch(&g, PINCH_CONTACT_HARD, 0.5, 0.0);
    g.grasp.wrench[0] = -4.0;
    least_closing_of(&g, NAN, NAN);
}

static void the_limits_of_a_pinch_are_coulomb_s(void **state)
{
    (void)state;
    test_grasp g;
    make_pinch(&g, PINCH_CONTACT_SOFT, 0.5, 10.0);
    g.grasp.wrench[2] = -4.0;
    for (int mode = 0; mode < 2; mode++) {
        pinch_statics_settings settings = pinch_default_statics_settings();
        settings.one_step = mode == 1;
        check_limits(&g, &settings, 0.4, 2.5);
    }
    /* hung on its torsion alone: 0.004 m times 10 N per finger */
    memset(g.grasp.wrench, 0, sizeof g.grasp.wrench);
    g.grasp.wrench[3] = 0.02;
    pinch_statics_settings settings = pinch_default_statics_settings();
    check_limits(&g, &settings, 0.25, 4.0);
}

/* mu_tau down to a two-thousandth of the radius: torques that are small beside all other moments are resolved, too. */
static void torsion_ends_at_mu_tau_times_the_squeeze(void **state)
{
    (void)state;
    static const double radius[] = {1e-4, 4e-4, 2e-3, 1e-2}, beyond[] = {1e-5, 1e-4, 3e-4, 1e-3};
    enum { RADII = sizeof radius / sizeof *radius, BEYOND = sizeof beyond / sizeof *beyond };
    pinch_statics_settings settings = pinch_default_statics_settings();
    for (int i = 0; i < 2 * RADII; i++) {
        test_grasp g;
        pinch_finger_result f[2];
        bool force_controlled = i % 2;
        make_pinch(&g, PINCH_CONTACT_SOFT, 0.6, 5.0);
        g.grasp.radius = 0.2;
        for (int k = 0; k < 2; k++) {
            g.fingers[k].torsional_friction = radius[i / 2];
            g.fingers[k].force_controlled = force_controlled;
            g.fingers[k].normal_force = 5.0;
        }
        double most = 2.0 * radius[i / 2] * 5.0;
        g.grasp.wrench[3] = 0.5 * most;
        check_limits(&g, &settings, 0.5, 2.0);
        g.grasp.wrench[3] = (1.0 - 1e-6) * most;
        assert_int_equal(solve(&g, &settings, f).solve.status, PINCH_SOLVE_CONVERGED);
        for (int k = 0; k < BEYOND; k++) {
            g.grasp.wrench[3] = (1.0 + beyond[k]) * most;
            pinch_statics_result r = solve(&g, &settings, f);
            assert_true(r.solve.status == PINCH_SOLVE_UNSTABLE ||
                        (force_controlled && r.solve.status == PINCH_SOLVE_INFEASIBLE));
            assert_close(r.load_fraction, 1.0 / (1.0 + beyond[k]), 2e-6);
        }
    }
}

static void an_overloaded_pinch_is_infeasible_only_where_nothing_could_hold_it(void **state)
{
    (void)state;
    test_grasp g;
    pinch_finger_result f[2];
    pinch_statics_settings settings = pinch_default_statics_settings();
    /* too heavy for the squeeze, though a stronger one could hold it: the object falls */
    make_pinch(&g, PINCH_CONTACT_HARD, 0.5, 10.0);
    g.grasp.wrench[2] = -11.0;
    pinch_statics_result r = solve(&g, &settings, f);
    assert_int_equal(r.solve.status, PINCH_SOLVE_UNSTABLE);
    assert_close(r.load_fraction, 10.0 / 11.0, 1e-3);
    assert_close(r.twist[2], -1.0, 1e-6);
    assert_true(isnan(f[0].r[0]));
    /* two hard fingers cannot hold a torque about the line between them, whatever they press */
    g.grasp.wrench[2] = 0.0;
    g.grasp.wrench[3] = 0.001;
    r = solve(&g, &settings, f);
    assert_int_equal(r.solve.status, PINCH_SOLVE_INFEASIBLE);
    assert_true(pinch_statics_proves_infeasible(&g.grasp, &settings, r.twist));
    double back[6];
    for (int j = 0; j < 6; j++) back[j] = -r.twist[j];
    assert_false(pinch_statics_proves_infeasible(&g.grasp, &settings, back));
    /* a force limit caps the squeeze: now the weight is infeasible, too */
    g.grasp.wrench[3] = 0.0;
    g.grasp.wrench[2] = -11.0;
    g.fingers[0].max_force = g.fingers[1].max_force = 10.5;
    r = solve(&g, &settings, f);
    assert_int_equal(r.solve.status, PINCH_SOLVE_INFEASIBLE);
}

/* A finger under force control that yields at 6 N presses with the smaller of its share of the force and of that, while
 * the grasp closes. Two fingers along x hold against a third one that pushes along y, with 2 N from a fifth of its way
 * on, and a fourth one gives way: where the first presses with 6 N from a tenth of the way on, nothing slips, and the
 * springs of 1000 N/m share out the 2 N. */
static void force_control_that_comes_to_a_force_limit(void **state)
{
    (void)state;
    static const double sides[2][2] = {{0, 1}, {0, -1}};
    test_grasp g;
    make_pinch(&g, PINCH_CONTACT_HARD, 0.3, 0);
    g.fingers[0].force_controlled = true;
    g.fingers[0].normal_force = 60;
    g.fingers[0].max_force = 6;
    for (int i = 0; i < 2; i++) g.fingers[i].stiffness[1] = 1000;
    for (int i = 0; i < 2; i++) {
        pinch_finger *f = &g.fingers[2 + i];
        *f = g.fingers[1];
        f->model = PINCH_CONTACT_FRICTIONLESS;
        f->point[0] = 0;
        f->point[1] = -0.02 * sides[i][1];
        grasp_set_normal(f, sides[i][0], sides[i][1], 0);
    }
    g.fingers[2].closing = 0.015;
    g.fingers[2].max_force = 2;
    g.grasp.finger_count = 4;
    pinch_finger_result f[4];
    pinch_statics_settings settings = pinch_default_statics_settings();
    pinch_statics_result r = solve(&g, &settings, f);
    assert_int_equal(r.solve.status, PINCH_SOLVE_CONVERGED);
    assert_close(f[0].r[0], 6, 1e-12);
    assert_close(f[3].r[0], 2.0 / 3, 1e-9);
    for (int i = 0; i < 2; i++) assert_close(hypot(f[i].r[1], f[i].r[2]), 2.0 / 3, 1e-9);
}

static void force_control_and_force_limits(void **state)
{
    (void)state;
    test_grasp g;
    make_pinch(&g, PINCH_CONTACT_HARD, 0.5, 10.0);
    g.fingers[0].force_controlled = true;
    g.fingers[0].normal_force = 6.0;
    g.fingers[0].closing = 0.0;
    g.fingers[1].closing = 0.0;
    pinch_finger_result f[2];
    pinch_statics_settings settings = pinch_default_statics_settings();
    pinch_statics_result r = solve(&g, &settings, f);
    assert_int_equal(r.solve.status, PINCH_SOLVE_CONVERGED);
    assert_close(f[0].r[0], 6.0, 0.0);
    assert_close(f[1].r[0], 6.0, 1e-12);
    assert_close(r.translation[0], 0.006, 1e-15);

    /* position control against a finger that yields at 4 N, in every formulation */
    make_pinch(&g, PINCH_CONTACT_HARD, 0.5, 10.0);
    g.fingers[1].max_force = 4.0;
    for (int mode = 0; mode < 4; mode++) {
        settings = pinch_default_statics_settings();
        settings.one_step = mode == 1;
        settings.formulation = mode >= 2 ? PINCH_FORMULATION_LCP : PINCH_FORMULATION_COULOMB;
        if (mode == 3) settings.solver.solver = PINCH_SOLVER_LEMKE;
        r = solve(&g, &settings, f);
        assert_int_equal(r.solve.status, PINCH_SOLVE_CONVERGED);
        assert_int_equal(f[1].state, PINCH_CONTACT_YIELD);
        for (int i = 0; i < 2; i++) assert_close(f[i].r[0], 4.0, 1e-9);
        assert_close(r.translation[0], 0.006, 1e-12);
    }
}

/* The path remembers: a finger that slid while closing keeps its friction where the one-step answer has none. */
static void the_path_differs_from_one_step_and_both_are_verified(void **state)
{
    (void)state;
    test_grasp g;
    grasp_paper(3, &g);
    pinch_finger_result path[GRASP_MAX_FINGERS], once[GRASP_MAX_FINGERS];
    pinch_statics_settings settings = pinch_default_statics_settings();
    pinch_statics_result a = solve(&g, &settings, path);
    settings.one_step = true;
    pinch_statics_result b = solve(&g, &settings, once);
    assert_true(a.verification.passed && b.verification.passed);
    assert_true(fabs(path[0].r[0] - once[0].r[0]) > 1e-3);
}

/* Normal forces from one form of the complementarity problem, solved by Newton's method. */
static bool normals_of_form(const test_grasp *g, const pinch_statics_settings *settings, pinch_static_form form,
                            double *normals, int count)
{
    enum { MAX = 100 };
    static double m[MAX * MAX], q[MAX], z[MAX], w[MAX];
    static bool free_rows[MAX];
    int n = pinch_statics_lcp_size(statics, &g->grasp, settings, form);
    if (n == 0) return false;
    assert_true(n <= MAX);
    assert_int_equal(pinch_statics_lcp(statics, &g->grasp, settings, form, m, q, free_rows), PINCH_OK);
    pinch_lcp lcp = {.size = n, .m = m, .q = q, .free = form == PINCH_FORM_MIXED ? free_rows : NULL};
    pinch_solver_settings solver = pinch_default_solver_settings();
    pinch_lcp_workspace *ws;
    pinch_solver_result result;
    assert_int_equal(pinch_lcp_workspace_create(n, &ws), PINCH_OK);
    memset(z, 0, sizeof z);
    pinch_lcp_solve(&lcp, &solver, ws, z, w, &result);
    pinch_lcp_workspace_destroy(ws);
    assert_int_equal(result.status, PINCH_SOLVE_CONVERGED);
    memcpy(normals, z, (size_t)count * sizeof *z);
    return true;
}

/* On the paper's examples the forces are unique: the reduced system, every form of the complementarity problem and
 * every solver give the same. */
static void forms_and_solvers_agree_on_the_paper_s_examples(void **state)
{
    (void)state;
    int seen[PINCH_FORM_SPLIT + 1] = {0};
    for (int number = 0; number <= 4; number++)
        for (int faces = 4; faces <= 8; faces += 4) {
            test_grasp g;
            grasp_paper(number, &g);
            pinch_statics_settings settings = pinch_default_statics_settings();
            settings.formulation = PINCH_FORMULATION_LCP;
            settings.faces = faces;
            pinch_finger_result reduced[GRASP_MAX_FINGERS], f[GRASP_MAX_FINGERS];
            solve(&g, &settings, reduced);
            for (int s = PINCH_SOLVER_NEWTON; s <= PINCH_SOLVER_LEMKE; s++) {
                settings.solver.solver = (pinch_solver)s;
                pinch_statics_result r = solve(&g, &settings, f);
                assert_int_equal(r.solve.status, PINCH_SOLVE_CONVERGED);
                for (int i = 0; i < g.grasp.finger_count; i++)
                    for (int j = 0; j < 3; j++) assert_close(f[i].force[j], reduced[i].force[j], 1e-8);
            }
            /* raw, in the units of the example; Example 2's first finger is prescribed and not among the unknowns */
            settings.solver.solver = PINCH_SOLVER_NSNMGK;
            settings.faithful = true;
            int first = number == 2 ? 1 : 0, count = g.grasp.finger_count - first;
            for (int form = PINCH_FORM_MIXED; form <= PINCH_FORM_SPLIT; form++) {
                double normals[GRASP_MAX_FINGERS];
                if (!normals_of_form(&g, &settings, (pinch_static_form)form, normals, count)) continue;
                seen[form]++;
                for (int i = 0; i < count; i++) assert_close(normals[i], reduced[first + i].r[0], 1e-8);
            }
        }
    assert_true(seen[PINCH_FORM_MIXED] == 10 && seen[PINCH_FORM_SPLIT] == 10 && seen[PINCH_FORM_CONDENSED] == 6);
}

/* y is the closest point of the cone, and dy_dx its derivative. */
static void cone_projections_are_closest_points(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 42);
    for (int trial = 0; trial < 20000; trial++) {
        static const int kinds[] = {0, 2, 3, 4, 8};
        int faces = kinds[trial % 5];
        double high = trial % 3 == 0 ? 1.0 : INFINITY, low = trial % 7 == 0 ? 0.5 : 0.0;
        double x[4], y[4], d[16], z[4], s[4], dz[16];
        for (int i = 0; i < 4; i++) {
            x[i] = 4.0 * pinch_random_uniform(&random) - 2.0;
            z[i] = 4.0 * pinch_random_uniform(&random) - 2.0;
        }
        if (faces == 2) x[2] = z[2] = 0.0;
        pinch_friction_cone_project(faces, low, high, x, y, d);
        pinch_friction_cone_project(faces, low, high, z, s, dz); /* any point of the cone */
        double obtuse = 0.0;
        for (int i = 0; i < 4; i++) obtuse += (x[i] - y[i]) * (s[i] - y[i]);
        assert_true(obtuse <= 1e-12);
        double step = 1e-7, moved[4], at[4];
        int k = trial % 4;
        if (faces == 2 && k == 2) continue;
        memcpy(moved, x, sizeof x);
        moved[k] += step;
        pinch_friction_cone_project(faces, low, high, moved, at, dz);
        bool kink = false;
        for (int i = 0; i < 16; i++) kink = kink || fabs(dz[i] - d[i]) > 1e-3;
        for (int i = 0; !kink && i < 4; i++) assert_close((at[i] - y[i]) / step, d[4 * i + k], 1e-5);
    }
}

static void what_is_out_of_range_is_refused(void **state)
{
    (void)state;
    test_grasp good;
    make_pinch(&good, PINCH_CONTACT_SOFT, 0.5, 10.0);
    pinch_finger_result f[2];
    pinch_statics_result r;
    pinch_statics_settings settings = pinch_default_statics_settings();
    for (int defect = 0; defect < 12; defect++) {
        test_grasp g = good;
        g.grasp.fingers = g.fingers;
        switch (defect) {
        case 0:
            g.grasp.finger_count = 0;
            break;
        case 1:
            g.grasp.finger_count = GRASP_MAX_FINGERS + 1;
            break;
        case 2:
            g.grasp.radius = 0.0;
            break;
        case 3:
            g.grasp.wrench[1] = NAN;
            break;
        case 4:
            g.fingers[0].normal[0] = 0.5;
            break;
        case 5:
            g.fingers[0].tangent1[0] = 0.1;
            break;
        case 6:
            g.fingers[0].stiffness[0] = 0.0;
            break;
        case 7:
            g.fingers[0].stiffness[2] = -1.0;
            break;
        case 8:
            g.fingers[0].friction = -0.1;
            break;
        case 9:
            g.fingers[0].max_force = 0.0;
            break;
        case 10:
            g.fingers[0].closing = INFINITY;
            break;
        default:
            g.fingers[0].model = (pinch_contact_model)2;
            break;
        }
        assert_int_equal(pinch_statics_solve(statics, &g.grasp, &settings, f, &r), PINCH_INVALID_ARGUMENT);
    }
    settings.solver.solver = PINCH_SOLVER_LEMKE;
    assert_int_equal(pinch_statics_solve(statics, &good.grasp, &settings, f, &r), PINCH_UNSUPPORTED);
    settings.formulation = PINCH_FORMULATION_LCP;
    settings.faces = 17; /* more than memory was made for */
    assert_int_equal(pinch_statics_solve(statics, &good.grasp, &settings, f, &r), PINCH_INVALID_ARGUMENT);
    settings.faces = 2;
    assert_int_equal(pinch_statics_solve(statics, &good.grasp, &settings, f, &r), PINCH_INVALID_ARGUMENT);
}

/* The verification has to notice what is wrong. */
static void verification_catches_tampering(void **state)
{
    (void)state;
    test_grasp g;
    grasp_paper(3, &g);
    pinch_statics_settings settings = pinch_default_statics_settings();
    pinch_finger_result f[GRASP_MAX_FINGERS];
    pinch_statics_result r = solve(&g, &settings, f);
    settings.one_step = true;
    r = solve(&g, &settings, f);
    for (int tamper = 0; tamper < 6; tamper++) {
        pinch_finger_result changed[GRASP_MAX_FINGERS];
        pinch_statics_result moved = r;
        memcpy(changed, f, sizeof f);
        test_grasp other = g;
        other.grasp.fingers = other.fingers;
        switch (tamper) {
        case 0:
            changed[0].r[0] += 1e-6;
            break;
        case 1:
            changed[2].r[1] += 1e-6;
            break;
        case 2:
            moved.translation[2] += 1e-6;
            break;
        case 3:
            other.fingers[2].friction *= 1.0 - 1e-6;
            break;
        case 4:
            changed[2].last_slip[0] *= 1.1;
            break;
        default:
            other.grasp.wrench[4] += 1e-6;
            break;
        }
        pinch_static_verification v;
        pinch_statics_verify(&other.grasp, &settings, changed, &moved, &v);
        assert_false(v.passed);
    }
}

/* A grip of up to 1e18 times the weight: an answer that passes carries the weight, as long as that is no
 * rounding of the grip. */
static void a_huge_grip_hides_no_load(void **state)
{
    (void)state;
    pinch_statics_settings settings = pinch_default_statics_settings();
    int passed = 0;
    for (int k = 0; k <= 18; k++) {
        test_grasp g;
        make_pinch(&g, PINCH_CONTACT_HARD, 0.5, pow(10, k));
        g.grasp.wrench[2] = -1.0;
        pinch_finger_result f[GRASP_MAX_FINGERS];
        pinch_statics_result r = solve(&g, &settings, f);
        double carried = f[0].force[2] + f[1].force[2];
        if (r.verification.passed && k < 12) assert_close(carried, 1.0, 1e-3);
        passed += r.verification.passed && k <= 6;

        /* the same grip with the weight left out of the fingers' forces */
        pinch_static_verification v;
        for (int i = 0; i < g.grasp.finger_count; i++) f[i].r[1] = f[i].r[2] = 0;
        pinch_statics_verify(&g.grasp, &settings, f, &r, &v);
        if (k < 12) assert_false(v.passed);
    }
    assert_int_equal(passed, 7);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_huge_grip_hides_no_load),
        cmocka_unit_test(a_pinched_ball_sinks_by_weight_over_stiffness),
        cmocka_unit_test(the_limits_of_a_pinch_are_coulomb_s),
        cmocka_unit_test(the_largest_load_is_one_that_may_grow_no_further),
        cmocka_unit_test(the_least_grip_of_a_pinch),
        cmocka_unit_test(torsion_ends_at_mu_tau_times_the_squeeze),
        cmocka_unit_test(an_overloaded_pinch_is_infeasible_only_where_nothing_could_hold_it),
        cmocka_unit_test(force_control_and_force_limits),
        cmocka_unit_test(force_control_that_comes_to_a_force_limit),
        cmocka_unit_test(the_path_differs_from_one_step_and_both_are_verified),
        cmocka_unit_test(forms_and_solvers_agree_on_the_paper_s_examples),
        cmocka_unit_test(cone_projections_are_closest_points),
        cmocka_unit_test(what_is_out_of_range_is_refused),
        cmocka_unit_test(verification_catches_tampering),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
