/*
 * What the public functions of the core refuse: every number of a grasp, and of a contact with all that it may have,
 * that is not finite or has the wrong sign; sizes and settings out of range. And the words for how a call ended: each
 * has its own, and what is no status has one too.
 */
#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/grasps.h"
#include "support/island.h"

#include <pinch/lcp.h>
#include <string.h>

/* ---- grasps ---- */

static pinch_statics *statics;

static pinch_status ask(const pinch_grasp *grasp, const pinch_statics_settings *settings)
{
    pinch_finger_result fingers[GRASP_MAX_FINGERS];
    pinch_statics_result result;
    pinch_static_limits limits;
    pinch_static_limit least;
    pinch_status status = pinch_statics_solve(statics, grasp, settings, fingers, &result);
    if (status == PINCH_OK) return status;
    /* what one refuses the others refuse, and what they write forms for does not exist */
    assert_int_equal(pinch_statics_limits(statics, grasp, settings, &limits), status);
    assert_int_equal(pinch_statics_least_closing(statics, grasp, settings, &least), status);
    return status;
}

/* A good grasp of soft fingers, one of which is force controlled. */
static void good_grasp(test_grasp *g, bool planar)
{
    grasp_paper(2, g);
    for (int i = 0; i < g->grasp.finger_count; i++) {
        pinch_finger *f = &g->fingers[i];
        f->model = PINCH_CONTACT_SOFT;
        for (int k = 0; k < 3; k++) f->stiffness[k] = 1000;
        f->friction = 0.5;
        f->torsional_friction = 0.01;
        f->closing = 0.001;
        f->max_force = INFINITY;
        f->force_controlled = i == 1;
        f->normal_force = 1;
    }
    if (!planar) return;
    static const double along[2][3] = {{1, 0, 0}, {-1, 0, 0}}, across[3] = {0, 1, 0};
    g->grasp.finger_count = 2;
    for (int i = 0; i < 2; i++) {
        memcpy(g->fingers[i].normal, along[i], sizeof along[i]);
        memcpy(g->fingers[i].tangent1, across, sizeof across);
        for (int k = 0; k < 3; k++) g->fingers[i].point[k] = -0.1 * along[i][k];
    }
    memset(g->grasp.wrench, 0, sizeof g->grasp.wrench);
    g->grasp.planar = true;
}

static void refuse_number(test_grasp *g, double *number, double wrong, const pinch_statics_settings *settings)
{
    double right = *number;
    *number = wrong;
    assert_int_equal(ask(&g->grasp, settings), PINCH_INVALID_ARGUMENT);
    *number = right;
}

static void test_numbers_of_a_grasp(void **state)
{
    (void)state;
    static const double wrong[] = {NAN, INFINITY, -INFINITY};
    pinch_statics_settings settings = pinch_default_statics_settings();
    for (int planar = 0; planar < 2; planar++) {
        test_grasp g;
        good_grasp(&g, planar);
        pinch_finger *f = &g.fingers[1];
        double *finite[] = {&f->point[0],       &f->point[1],       &f->point[2],       &f->normal[0],
                            &f->normal[1],      &f->tangent1[0],    &f->tangent1[1],    &f->stiffness[0],
                            &f->friction,       &f->closing,        &f->normal_force,   &g.grasp.radius,
                            &g.grasp.wrench[0], &g.grasp.wrench[5], &g.grasp.origin[0], &g.grasp.origin[2],
                            &f->stiffness[1]};
        double *not_negative[] = {&f->friction, &f->normal_force},
               *positive[] = {&f->stiffness[0], &f->stiffness[1], &f->max_force, &g.grasp.radius};
        assert_int_equal(ask(&g.grasp, &settings), PINCH_OK);
        for (size_t i = 0; i < sizeof finite / sizeof *finite; i++)
            for (int k = 0; k < 3; k++) refuse_number(&g, finite[i], wrong[k], &settings);
        for (size_t i = 0; i < 2; i++) refuse_number(&g, not_negative[i], -1e-300, &settings);
        for (size_t i = 0; i < 4; i++) {
            refuse_number(&g, positive[i], 0, &settings);
            refuse_number(&g, positive[i], NAN, &settings);
        }
        if (planar) { /* nothing may leave the plane */
            refuse_number(&g, &g.grasp.wrench[2], 1, &settings);
            refuse_number(&g, &g.grasp.wrench[3], 1, &settings);
            refuse_number(&g, &g.grasp.wrench[4], 1, &settings);
            refuse_number(&g, &f->normal[2], 1e-12, &settings);
            refuse_number(&g, &f->tangent1[2], 1e-12, &settings);
        } else {
            refuse_number(&g, &f->stiffness[2], 0, &settings);
            refuse_number(&g, &f->torsional_friction, -1, &settings);
            refuse_number(&g, &f->torsional_friction, NAN, &settings);
        }
        refuse_number(&g, &f->normal[0], f->normal[0] + 0.1, &settings); /* no unit vector */
        f->model = (pinch_contact_model)2;
        assert_int_equal(ask(&g.grasp, &settings), PINCH_INVALID_ARGUMENT);
    }
}

static void test_settings_of_a_grasp(void **state)
{
    (void)state;
    test_grasp g;
    good_grasp(&g, false);
    const pinch_statics_settings good = pinch_default_statics_settings();
#define WITH(status, change)                                                                                           \
    do {                                                                                                               \
        pinch_statics_settings s = good;                                                                               \
        change;                                                                                                        \
        assert_int_equal(ask(&g.grasp, &s), status);                                                                   \
    } while (0)
    WITH(PINCH_INVALID_ARGUMENT, s.faces = 2);
    WITH(PINCH_INVALID_ARGUMENT, s.faces = 4097);
    WITH(PINCH_INVALID_ARGUMENT, s.path_steps = 0);
    WITH(PINCH_INVALID_ARGUMENT, s.path_tolerance = 0);
    WITH(PINCH_INVALID_ARGUMENT, s.path_tolerance = NAN);
    WITH(PINCH_INVALID_ARGUMENT, s.solver.tolerance = 0);
    WITH(PINCH_INVALID_ARGUMENT, s.solver.max_iterations = 0);
    WITH(PINCH_INVALID_ARGUMENT, s.solver.solver = PINCH_SOLVER_COUNT);
    WITH(PINCH_INVALID_ARGUMENT, s.solver.budget = -1);
    WITH(PINCH_INVALID_ARGUMENT, s.solver.sweeps = -1);
    WITH(PINCH_INVALID_ARGUMENT, s.formulation = (pinch_formulation)2);
    WITH(PINCH_INVALID_ARGUMENT, s.formulation = (pinch_formulation)-1);
    WITH(PINCH_UNSUPPORTED, s.solver.solver = PINCH_SOLVER_LEMKE);
    WITH(PINCH_UNSUPPORTED, s.solver.solver = PINCH_SOLVER_NSNGRK);
    WITH(PINCH_UNSUPPORTED, s.faithful = true);
    g.grasp.finger_count = 0;
    WITH(PINCH_INVALID_ARGUMENT, (void)0);
    g.grasp.finger_count = GRASP_MAX_FINGERS + 1;
    WITH(PINCH_INVALID_ARGUMENT, (void)0);
#undef WITH
    /* forms are of the linearized cone, and need room for its facets */
    static double m[1000 * 1000], q[1000];
    static bool is_free[1000];
    pinch_statics_settings s = good;
    good_grasp(&g, false);
    assert_int_equal(pinch_statics_lcp_size(statics, &g.grasp, &s, PINCH_FORM_MIXED), 0);
    s.formulation = PINCH_FORMULATION_LCP;
    assert_true(pinch_statics_lcp_size(statics, &g.grasp, &s, PINCH_FORM_MIXED) > 0);
    s.faces = 9;
    assert_int_equal(pinch_statics_lcp_size(statics, &g.grasp, &s, PINCH_FORM_MIXED), 0);
    assert_int_equal(pinch_statics_lcp(statics, &g.grasp, &s, PINCH_FORM_MIXED, m, q, is_free), PINCH_INVALID_ARGUMENT);
    s.faces = 8;
    g.grasp.radius = -1;
    assert_int_equal(pinch_statics_lcp_size(statics, &g.grasp, &s, PINCH_FORM_MIXED), 0);
}

/* What is NULL is refused before it is looked into. */
static void test_no_grasp(void **state)
{
    (void)state;
    enum { WRONG = PINCH_INVALID_ARGUMENT };
    static double m[1000 * 1000], q[1000];
    static bool is_free[1000];
    test_grasp g;
    good_grasp(&g, false);
    pinch_statics_settings s = pinch_default_statics_settings();
    pinch_finger_result fingers[GRASP_MAX_FINGERS];
    pinch_statics_result result;
    assert_int_equal(pinch_statics_create(2, 8, NULL), WRONG);
    assert_int_equal(pinch_statics_solve(NULL, &g.grasp, &s, fingers, &result), WRONG);
    assert_int_equal(pinch_statics_solve(statics, NULL, &s, fingers, &result), WRONG);
    assert_int_equal(pinch_statics_solve(statics, &g.grasp, NULL, fingers, &result), WRONG);
    assert_int_equal(pinch_statics_solve(statics, &g.grasp, &s, NULL, &result), WRONG);
    assert_int_equal(pinch_statics_solve(statics, &g.grasp, &s, fingers, NULL), WRONG);
    assert_int_equal(pinch_statics_limits(statics, &g.grasp, &s, NULL), WRONG);
    assert_int_equal(pinch_statics_least_closing(statics, &g.grasp, &s, NULL), WRONG);
    s.formulation = PINCH_FORMULATION_LCP;
    assert_int_equal(pinch_statics_lcp_size(NULL, &g.grasp, &s, PINCH_FORM_MIXED), 0);
    assert_int_equal(pinch_statics_lcp(statics, &g.grasp, &s, PINCH_FORM_MIXED, NULL, q, is_free), WRONG);
    assert_int_equal(pinch_statics_lcp(statics, &g.grasp, &s, PINCH_FORM_MIXED, m, NULL, is_free), WRONG);
    assert_int_equal(pinch_statics_lcp(statics, &g.grasp, &s, PINCH_FORM_MIXED, m, q, NULL), WRONG);
    g.grasp.fingers = NULL;
    assert_int_equal(pinch_statics_lcp_size(statics, &g.grasp, &s, PINCH_FORM_MIXED), 0);
    s.formulation = PINCH_FORMULATION_COULOMB;
    assert_int_equal(ask(&g.grasp, &s), WRONG);
}

/* ---- islands, with everything that a contact may have ---- */

static pinch_step_solver *solver;

static pinch_status step(island *made)
{
    pinch_step_result result;
    pinch_solver_settings settings = pinch_default_solver_settings();
    return pinch_step_solve(solver, &made->problem, &settings, &result);
}

static void good_island(island *made)
{
    memset(made, 0, sizeof *made);
    island_make(made, ISLAND_JOINTS, 1);
    made->contacts[0].model = PINCH_CONTACT_ROLLING;
    for (int k = 0; k < 3; k++) made->contacts[0].stiffness[k] = 1000;
    made->contacts[0].may_soften = true;
}

/* The direction of a massless drive is a unit vector, but for rounding. */
static void refuse_drive_axes(island *made)
{
    static const double factors[] = {1 + 9e-7, 0, 2, 1 - 1e-5, INFINITY};
    for (size_t i = 0; i < sizeof factors / sizeof *factors; i++) {
        island_make(made, ISLAND_DRIVES, 1);
        for (int b = 0; b < made->problem.body_count; b++)
            for (int k = 0; k < 3; k++) made->bodies[b].drive_axis[k] *= factors[i];
        assert_int_equal(step(made), i == 0 ? PINCH_OK : PINCH_INVALID_ARGUMENT);
    }
}

static void refuse_counts(island *made)
{
    for (int wrong = -5; wrong < 0; wrong += 4) {
        island_make(made, ISLAND_HARD, 1);
        made->problem.contact_count = wrong;
        assert_int_equal(step(made), PINCH_INVALID_ARGUMENT);
        island_make(made, ISLAND_HARD, 1);
        made->problem.row_count = wrong;
        assert_int_equal(step(made), PINCH_INVALID_ARGUMENT);
        island_make(made, ISLAND_HARD, 1);
        made->problem.body_count = wrong;
        assert_int_equal(step(made), PINCH_INVALID_ARGUMENT);
    }
    island_make(made, ISLAND_HARD, 1);
    made->problem.body_count = made->problem.contact_count = made->problem.row_count = 0;
    assert_int_equal(step(made), PINCH_INVALID_ARGUMENT);
}

/* An inertia is symmetric, but for rounding, with contacts and without. */
static void test_lopsided_inertia(void **state)
{
    (void)state;
    static island made;
    static const int entries[] = {1, 2, 3, 5, 6, 7};
    for (int i = 0; i < 12; i++) {
        good_island(&made);
        if (i % 2) made.problem.contact_count = 0;
        double *inertia = made.bodies[0].inertia, *entry = &inertia[entries[i / 2]];
        double trace = inertia[0] + inertia[4] + inertia[8], right = *entry;
        *entry = right + 1e-8 * trace;
        assert_int_equal(step(&made), PINCH_OK);
        *entry = right + 1e-5 * trace;
        assert_int_equal(step(&made), PINCH_INVALID_ARGUMENT);
    }
}

static void test_settings_of_a_step(void **state)
{
    (void)state;
    static island made;
    pinch_step_result result;
    const pinch_solver_settings good = pinch_default_solver_settings();
    pinch_solver_settings wrong[4] = {good, good, good, good};
    wrong[0].budget = -1;
    wrong[1].budget = NAN;
    wrong[2].sweeps = -1;
    wrong[3].goal = 2 * good.tolerance;
    for (int i = 0; i < 4; i++) {
        island_make(&made, ISLAND_HARD, 1);
        assert_int_equal(pinch_step_solve(solver, &made.problem, &good, &result), PINCH_OK);
        assert_int_equal(pinch_step_solve(solver, &made.problem, &wrong[i], &result), PINCH_INVALID_ARGUMENT);
    }
}

static void test_numbers_of_an_island(void **state)
{
    (void)state;
    static island made;
    pinch_contact *c = &made.contacts[0];
    pinch_joint_row *r = &made.rows[0];
    const struct {
        double *number, wrong;
    } cases[] = {
        {&c->rolling_friction[0], -1},
        {&c->rolling_friction[1], NAN},
        {&c->rolling_elastic[0], NAN},
        {&c->rolling_moment[1], INFINITY},
        {&c->viscous[0], -1},
        {&c->viscous[1], NAN},
        {&c->viscous[1], INFINITY},
        {&c->friction_limit[0], -1},
        {&c->friction_limit[4], NAN},
        {&c->friction[0], NAN},
        {&c->max_force, NAN},
        {&c->stiffness[0], -1},
        {&c->stiffness[2], -1},
        {&c->damping[0], -1},
        {&c->damping[2], INFINITY},
        {&c->tangent1[0], NAN},
        {&c->depth, INFINITY},
        {&c->surface_velocity[5], NAN},
        {&c->elastic[2], NAN},
        {&c->force[3], NAN},
        {&r->j1[5], INFINITY},
        {&r->j2[0], NAN},
        {&r->rhs, NAN},
        {&r->cfm, -1},
        {&r->cfm, INFINITY},
        {&r->yield, -1},
        {&r->yield, NAN},
        {&r->yield, INFINITY},
        {&r->low, NAN},
        {&r->low, 1e9},
        {&r->force, NAN},
        {&made.problem.step, NAN},
        {&made.bodies[0].inertia[8], NAN},
        {&made.bodies[0].external[3], NAN},
        {&made.bodies[0].radius, NAN},
        {&made.bodies[0].mass, INFINITY},
    };
    good_island(&made);
    assert_int_equal(step(&made), PINCH_OK);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        good_island(&made);
        made.rows[0].high = 1;
        made.rows[0].low = -1;
        *cases[i].number = cases[i].wrong;
        assert_int_equal(step(&made), PINCH_INVALID_ARGUMENT);
    }
    static const int faces[] = {1, -1, 4097};
    for (int i = 0; i < 3; i++) {
        island_make(&made, ISLAND_HARD, 1);
        made.problem.faces = faces[i];
        assert_int_equal(step(&made), PINCH_INVALID_ARGUMENT);
    }
    good_island(&made);
    made.rows[0].body1 = made.problem.body_count;
    assert_int_equal(step(&made), PINCH_INVALID_ARGUMENT);
    good_island(&made);
    made.rows[0].body1 = made.rows[0].body2 = PINCH_STATIC_BODY;
    assert_int_equal(step(&made), PINCH_INVALID_ARGUMENT);
    good_island(&made);
    made.rows[0].continues = true; /* there is no row before it */
    assert_int_equal(step(&made), PINCH_INVALID_ARGUMENT);
    island_make(&made, ISLAND_DRIVES, 1); /* one of the bodies is a massless drive */
    for (int b = 0; b < made.problem.body_count; b++)
        if (made.bodies[b].mass == 0) made.bodies[b].drive_force = NAN;
    assert_int_equal(step(&made), PINCH_INVALID_ARGUMENT);
    island_make(&made, ISLAND_DRIVES, 1);
    for (int b = 0; b < made.problem.body_count; b++)
        if (made.bodies[b].mass == 0) made.bodies[b].drive_axis[1] = NAN;
    assert_int_equal(step(&made), PINCH_INVALID_ARGUMENT);
    refuse_drive_axes(&made);
    refuse_counts(&made);
    /* what no method has */
    good_island(&made);
    made.problem.faces = 4;
    assert_int_equal(step(&made), PINCH_UNSUPPORTED);
    assert_int_equal(pinch_step_solver_create(NULL), PINCH_INVALID_ARGUMENT);
    pinch_step_solver_destroy(NULL);
}

/* What is read from a file and put into a memory has to be factors, whose pivots are places. */
static void test_memories(void **state)
{
    (void)state;
    pinch_step_memory *memory = NULL;
    double lu[4] = {1, 2, 3, 4};
    int pivot[2] = {0, 1};
    unsigned char states[3] = {0, 1, 2};
    const pinch_step_factors good = {
        .tag = 7, .unknowns = 2, .element_count = 3, .lu = lu, .pivot = pivot, .states = states};
    assert_int_equal(pinch_step_memory_create(NULL), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_step_memory_create(&memory), PINCH_OK);
    assert_int_equal(pinch_step_memory_write(memory, &good), PINCH_OK);
    for (int defect = 0; defect < 10; defect++) {
        pinch_step_factors f = good;
        int wrong[2] = {0, defect == 0 ? -1 : 2};
        if (defect < 2) f.pivot = wrong;
        if (defect == 2) f.pivot = NULL;
        if (defect == 3) f.lu = NULL;
        if (defect == 4) f.states = NULL;
        if (defect == 5) f.unknowns = -1;
        if (defect == 6) f.element_count = -1;
        if (defect < 7) assert_int_equal(pinch_step_memory_write(memory, &f), PINCH_INVALID_ARGUMENT);
        if (defect == 7) assert_int_equal(pinch_step_memory_write(NULL, &f), PINCH_INVALID_ARGUMENT);
        if (defect == 8) assert_int_equal(pinch_step_memory_write(memory, NULL), PINCH_INVALID_ARGUMENT);
        /* what was refused has changed nothing */
        pinch_step_factors kept = pinch_step_memory_read(memory);
        assert_true(kept.tag == 7 && kept.unknowns == 2 && kept.element_count == 3);
        assert_memory_equal(kept.lu, lu, sizeof lu);
        assert_memory_equal(kept.pivot, pivot, sizeof pivot);
    }
    pinch_step_factors none = {.tag = 8}, no_elements = good;
    no_elements.element_count = 0;
    no_elements.states = NULL;
    assert_int_equal(pinch_step_memory_write(memory, &no_elements), PINCH_OK);
    assert_int_equal(pinch_step_memory_write(memory, &none), PINCH_OK);
    assert_int_equal(pinch_step_memory_read(memory).unknowns, 0);
    pinch_step_memory_destroy(memory);
    pinch_step_memory_destroy(NULL);
}

/* Where the work allowed is up, the step says so and leaves nothing that passes for an answer. */
static void test_budgets(void **state)
{
    (void)state;
    static island made;
    int over = 0, solved = 0;
    for (int kind = 0; kind < ISLAND_KIND_COUNT; kind++)
        for (int seed = 1; seed <= 4; seed++)
            for (int k = 0; k < 12; k++) {
                pinch_step_result result;
                pinch_solver_settings settings = pinch_default_solver_settings();
                settings.budget = pow(3, k - 4);
                memset(&made, 0, sizeof made);
                island_make(&made, (island_kind)kind, (uint64_t)seed);
                for (int i = 0; i < made.problem.contact_count; i++)
                    made.contacts[i].may_soften = kind != ISLAND_DRIVES;
                for (int j = 0; j < made.problem.row_count && seed % 2; j++) {
                    made.rows[j].low = -1;
                    made.rows[j].high = 1;
                }
                assert_int_equal(pinch_step_solve(solver, &made.problem, &settings, &result), PINCH_OK);
                bool answered = result.solve.status == PINCH_SOLVE_CONVERGED;
                over += result.over_budget;
                solved += answered;
                for (int b = 0; b < made.problem.body_count; b++)
                    assert_true(answered ? isfinite(made.bodies[b].velocity_end[0])
                                         : isnan(made.bodies[b].velocity_end[0]));
            }
    print_message("%d solves ran out of work, %d have an answer\n", over, solved);
    assert_true(over > 100 && solved > 100);
}

/* The bare methods do without what helps the default ones. What they call an answer is the same one. */
static void test_bare_methods(void **state)
{
    (void)state;
    pinch_random random;
    pinch_random_seed(&random, 31);
    int both = 0, same = 0;
    for (int i = 0; i < draw_count(3000); i++) {
        test_grasp g;
        pinch_finger_result fingers[GRASP_MAX_FINGERS];
        pinch_statics_result ours, bare;
        pinch_statics_settings settings = pinch_default_statics_settings();
        grasp_random(&random, &g);
        assert_int_equal(pinch_statics_solve(statics, &g.grasp, &settings, fingers, &ours), PINCH_OK);
        settings.solver.solver = i % 2 ? PINCH_SOLVER_NEWTON : PINCH_SOLVER_NSNMGK;
        settings.solver.newton_finish = false;
        settings.solver.max_iterations = 300;
        assert_int_equal(pinch_statics_solve(statics, &g.grasp, &settings, fingers, &bare), PINCH_OK);
        if (bare.solve.status == PINCH_SOLVE_CONVERGED) assert_true(bare.verification.passed);
        if (bare.solve.status != PINCH_SOLVE_CONVERGED || ours.solve.status != PINCH_SOLVE_CONVERGED) continue;
        double apart = 0, size = 0;
        for (int k = 0; k < 3; k++) {
            apart = fmax(apart, fabs(ours.translation[k] - bare.translation[k]));
            size = fmax(size, fabs(ours.translation[k]));
        }
        both++;
        same += apart <= 1e-3 * size; /* load steps of other lengths end a little apart */
    }
    print_message("%d grasps solved by both, %d with the same motion\n", both, same);
    assert_true(both > 3 && same >= both * 9 / 10);
}

/* ---- complementarity problems ---- */

static void test_complementarity_problems(void **state)
{
    (void)state;
    pinch_lcp_workspace *workspace = NULL;
    double m[4] = {2, 1, 1, 2}, q[2] = {-5, -6}, z[2] = {0, 0}, w[2];
    bool is_free[2] = {true, false};
    pinch_lcp p = {.size = 2, .m = m, .q = q};
    pinch_solver_settings settings = pinch_default_solver_settings();
    pinch_solver_result result;
    assert_int_equal(pinch_lcp_workspace_create(0, &workspace), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_lcp_workspace_create(10001, &workspace), PINCH_INVALID_ARGUMENT);
    assert_int_equal(pinch_lcp_workspace_create(2, &workspace), PINCH_OK);
    for (int s = 0; s < PINCH_SOLVER_COUNT; s++) {
        settings.solver = (pinch_solver)s;
        p.size = 3;
        assert_int_equal(pinch_lcp_solve(&p, &settings, workspace, z, w, &result), PINCH_INVALID_ARGUMENT);
        p.size = 0;
        assert_int_equal(pinch_lcp_solve(&p, &settings, workspace, z, w, &result), PINCH_INVALID_ARGUMENT);
        p.size = 2;
        m[1] = NAN;
        assert_int_equal(pinch_lcp_solve(&p, &settings, workspace, z, w, &result), PINCH_INVALID_ARGUMENT);
        m[1] = 1;
        q[1] = INFINITY;
        assert_int_equal(pinch_lcp_solve(&p, &settings, workspace, z, w, &result), PINCH_INVALID_ARGUMENT);
        q[1] = -6;
        z[0] = z[1] = 0;
        assert_int_equal(pinch_lcp_solve(&p, &settings, workspace, z, w, &result), PINCH_OK);
        assert_int_equal(result.status, PINCH_SOLVE_CONVERGED);
    }
    settings.solver = PINCH_SOLVER_COUNT;
    assert_int_equal(pinch_lcp_solve(&p, &settings, workspace, z, w, &result), PINCH_INVALID_ARGUMENT);
    /* what cannot be judged is not called infeasible */
    q[0] = q[1] = -1;
    m[0] = m[3] = -1;
    m[1] = m[2] = 0;
    assert_true(pinch_lcp_prove_infeasible(&p, workspace, z));
    q[0] = q[1] = 0; /* z = 0 solves it, although the rows of M are negative */
    assert_false(pinch_lcp_prove_infeasible(&p, workspace, z));
    q[0] = q[1] = -1;
    p.free = is_free;
    assert_false(pinch_lcp_prove_infeasible(&p, workspace, z));
    p.free = NULL;
    p.size = 3;
    assert_false(pinch_lcp_prove_infeasible(&p, workspace, z));
    pinch_lcp_workspace_destroy(workspace);
    pinch_lcp_workspace_destroy(NULL);
}

/* ---- words ---- */

#define ALL_DIFFER(function, count, type)                                                                              \
    do {                                                                                                               \
        for (int i = 0; i <= (count); i++)                                                                             \
            for (int j = 0; j < i; j++)                                                                                \
                assert_string_not_equal(function((type)i), function((type)j)); /* the last is none of them */          \
    } while (0)

static void test_words(void **state)
{
    (void)state;
    ALL_DIFFER(pinch_status_text, PINCH_SYSTEM_FAILURE + 1, pinch_status);
    ALL_DIFFER(pinch_solve_status_text, PINCH_SOLVE_UNVERIFIED + 1, pinch_solve_status);
    ALL_DIFFER(pinch_contact_state_text, PINCH_CONTACT_YIELD + 1, pinch_contact_state);
    ALL_DIFFER(pinch_solver_name, PINCH_SOLVER_COUNT, pinch_solver);
    ALL_DIFFER(pinch_solved_by_name, PINCH_SOLVED_BY_COUNT, pinch_solved_by);
    pinch_solver s;
    for (int i = 0; i < PINCH_SOLVER_COUNT; i++) {
        assert_int_equal(pinch_solver_from_name(pinch_solver_name((pinch_solver)i), &s), PINCH_OK);
        assert_int_equal(s, i);
    }
    assert_int_equal(pinch_solver_from_name("simplex", &s), PINCH_INVALID_ARGUMENT);
}

static int create(void **state)
{
    (void)state;
    return pinch_statics_create(GRASP_MAX_FINGERS, 8, &statics) != PINCH_OK ||
           pinch_step_solver_create(&solver) != PINCH_OK;
}

static int destroy(void **state)
{
    (void)state;
    pinch_statics_destroy(statics);
    pinch_statics_destroy(NULL);
    pinch_step_solver_destroy(solver);
    pinch_statics *none = NULL;
    bool refused = pinch_statics_create(0, 8, &none) == PINCH_INVALID_ARGUMENT &&
                   pinch_statics_create(3, -1, &none) == PINCH_INVALID_ARGUMENT &&
                   pinch_statics_create(3, 4097, &none) == PINCH_INVALID_ARGUMENT;
    return refused && !none ? 0 : 1;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_numbers_of_a_grasp),
        cmocka_unit_test(test_settings_of_a_grasp),
        cmocka_unit_test(test_no_grasp),
        cmocka_unit_test(test_numbers_of_an_island),
        cmocka_unit_test(test_lopsided_inertia),
        cmocka_unit_test(test_settings_of_a_step),
        cmocka_unit_test(test_complementarity_problems),
        cmocka_unit_test(test_words),
        cmocka_unit_test(test_memories),
        cmocka_unit_test(test_budgets),
        cmocka_unit_test(test_bare_methods),
    };
    return cmocka_run_group_tests(tests, create, destroy);
}
