/* Random islands from a cold start: what is called converged is an answer, what is not is said so. */
#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/island.h"
#include "support/referee.h"

#include <float.h>
#include <string.h>

static pinch_step_solver *solver;

static int create_solver(void **state)
{
    (void)state;
    return pinch_step_solver_create(&solver) == PINCH_OK ? 0 : -1;
}

static int destroy_solver(void **state)
{
    (void)state;
    pinch_step_solver_destroy(solver);
    return 0;
}

/* The default solver; unless everything is wanted it gives up sooner, which is what takes the time. */
static pinch_solver_settings default_settings(void)
{
    pinch_solver_settings settings = pinch_default_solver_settings();
    if (!draw_full()) settings.max_iterations = 500;
    return settings;
}

static pinch_step_result solve(island *made, const pinch_solver_settings *settings)
{
    pinch_step_result result;
    assert_int_equal(pinch_step_solve(solver, &made->problem, settings, &result), PINCH_OK);
    return result;
}

/* Everything documented as output, one double at a time. */
static void each_output(island *made, void (*act)(void *context, double value), void *context)
{
    const pinch_problem *p = &made->problem;
    for (int b = 0; b < p->body_count; b++)
        for (int i = 0; i < 6; i++) act(context, p->bodies[b].velocity_end[i]);
    for (int k = 0; k < p->contact_count; k++) {
        const pinch_contact *c = &p->contacts[k];
        for (int i = 0; i < 4; i++) act(context, c->force[i]);
        for (int i = 0; i < 4; i++) act(context, c->relative_velocity[i]);
        for (int i = 0; i < 3; i++) act(context, c->elastic_end[i]);
        for (int i = 0; i < 3; i++) act(context, c->slip[i]);
    }
    for (int k = 0; k < p->row_count; k++) act(context, p->rows[k].force);
}

typedef struct output_count {
    int finite, nan;
} output_count;

static void count_output(void *context, double value)
{
    output_count *count = context;
    count->finite += isfinite(value) != 0;
    count->nan += isnan(value) != 0;
}

static void assert_all_nan(island *made)
{
    output_count count = {0, 0};
    each_output(made, count_output, &count);
    assert_int_equal(count.finite, 0);
    assert_true(count.nan > 0);
}

static void assert_all_finite(island *made)
{
    output_count count = {0, 0};
    each_output(made, count_output, &count);
    assert_int_equal(count.nan, 0);
    assert_true(count.finite > 0);
}

/* 1e-9 of the largest force, which is what problem.h's laws are verified to, and what the last bit of the velocities
 * makes of the forces (64 roundings of it). */
static double law_tolerance(const referee_verdict *v)
{
    return 1e-9 * v->scale + 64 * v->rounding;
}

static const char *fault_of(const pinch_problem *p, const referee_verdict *v)
{
    double law = law_tolerance(v);
    /* a body's balance is verified to a hundred times the solver's tolerance of 1e-10, relative to the sum of the
     * forces on it, of which `scale` is the largest */
    double forces = v->scale * (p->contact_count + 1);
    if (!(v->balance <= 1e-8 * forces + 64 * v->rounding)) return "momentum balance";
    if (!(v->drive <= 1e-8 * v->scale + 64 * v->rounding)) return "balance of a drive";
    if (!(v->normal <= law)) return "normal law";
    if (!(v->friction <= law)) return "friction law";
    if (!(v->cone <= law)) return "cone";
    if (!(v->direction <= law)) return "slip direction";
    if (!(v->compliant <= law)) return "compliant row";
    if (!(v->joint <= 1e-10)) return "hard row"; /* speeds of 1 m/s and some hundred roundings in the elimination */
    if (!(v->limited <= 1e-8 * fmax(v->scale, 1))) return "one-sided row";
    return NULL;
}

/* State words, elastic state and slip are those of the forces. */
static const char *state_fault(const pinch_problem *p, const referee_verdict *v)
{
    for (int k = 0; k < p->contact_count; k++) {
        const pinch_contact *c = &p->contacts[k];
        if ((c->state == PINCH_CONTACT_OPEN) != (c->force[0] == 0)) return "open state";
        if ((c->state == PINCH_CONTACT_YIELD) != (c->force[0] >= c->max_force)) return "yield state";
        for (int i = 0; i < 3; i++) {
            if (c->state == PINCH_CONTACT_STICK && c->slip[i] != 0) return "slip while sticking";
            if (c->state == PINCH_CONTACT_OPEN && (c->slip[i] != 0 || c->elastic_end[i] != 0))
                return "open and strained";
            double kt = c->stiffness[i < 2 ? 1 : 2], ct = c->damping[i < 2 ? 1 : 2];
            if (c->state == PINCH_CONTACT_OPEN || i + 1 >= (int)c->model) continue;
            /* r_t = -kt e+ - ct (e+ - e)/h */
            double force = -kt * c->elastic_end[i] - ct * (c->elastic_end[i] - c->elastic[i]) / p->step;
            double lever = i < 2 ? 1 : sqrt(c->stiffness[2] / c->stiffness[1]);
            if (!(fabs(force - c->force[1 + i]) <= law_tolerance(v) * fmax(lever, 1))) return "elastic state";
        }
    }
    return NULL;
}

static void test_answers_satisfy_the_laws(void **state)
{
    (void)state;
    pinch_solver_settings settings = default_settings();
    int wrong = 0;
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++) {
        static island made;
        int count = draw_count(10000), failed = 0;
        for (int seed = 1; seed <= count; seed++) {
            island_make(&made, kind, (uint64_t)seed);
            pinch_step_result result = solve(&made, &settings);
            if (result.solve.status != PINCH_SOLVE_CONVERGED) {
                assert_all_nan(&made);
                failed++;
                if (draw_full())
                    print_message("%s %d: %s, residual %g\n", island_kind_name(kind), seed,
                                  pinch_solve_status_text(result.solve.status), result.solve.residual);
                continue;
            }
            assert_all_finite(&made);
            referee_verdict v;
            referee_judge(&made.problem, &v);
            const char *fault = fault_of(&made.problem, &v);
            if (!fault) fault = state_fault(&made.problem, &v);
            if (!fault && !(result.solve.residual <= settings.tolerance)) fault = "residual above the tolerance";
            if (!fault) continue;
            wrong++;
            print_error("%s, seed %d: %s (scale %g N)\n", island_kind_name(kind), seed, fault, v.scale);
        }
        print_message("%s: %d of %d cold starts did not converge\n", island_kind_name(kind), failed, count);
        assert_int_equal(failed, 0); /* measured: none in 10,000 of any kind */
    }
    assert_int_equal(wrong, 0);
}

/* What the verification reports must not be better than what the referee finds: both in newtons. */
static void test_reported_errors_are_true(void **state)
{
    (void)state;
    pinch_solver_settings settings = default_settings();
    settings.tolerance = 1e-6; /* coarse, so that there is something to report */
    settings.goal = 1e-6;
    int seen = 0;
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++) {
        static island made;
        for (int seed = 1; seed <= 100; seed++) {
            island_make(&made, kind, (uint64_t)seed);
            pinch_step_result result = solve(&made, &settings);
            if (result.solve.status != PINCH_SOLVE_CONVERGED) continue;
            referee_verdict v;
            referee_judge(&made.problem, &v);
            assert_true(v.normal <= result.complementarity + 64 * v.rounding + 1e-13 * v.scale);
            assert_true(v.cone <= result.cone + 1e-13 * v.scale);
            /* relative to sums of magnitudes, which are at least the largest force over two bodies' worth */
            seen += v.balance > 1e-9 * v.scale;
            if (v.balance > 1e-9 * v.scale) assert_true(result.residual_max > 0);
            assert_true(v.balance <= 100 * settings.tolerance * 10 * v.scale);
        }
    }
    assert_true(seen > 50);
}

static double force_difference(const pinch_problem *a, const pinch_problem *b)
{
    double most = 0;
    for (int k = 0; k < a->contact_count; k++)
        for (int i = 0; i < 3; i++) most = fmax(most, fabs(a->contacts[k].force[i] - b->contacts[k].force[i]));
    return most;
}

/* Friction that depends on the normal force can leave a step several answers; then both have to be right. Without
 * friction there is one. */
static void two_answers(island_kind kind, int seed, const pinch_problem *other, double difference)
{
    referee_verdict v;
    referee_judge(other, &v);
    const char *fault = fault_of(other, &v);
    if (!fault && kind != ISLAND_FRICTIONLESS) return;
    print_error("%s, seed %d: %g N apart at a scale of %g N, %s\n", island_kind_name(kind), seed, difference, v.scale,
                fault ? fault : "without friction");
    fail();
}

static void test_newton_agrees(void **state)
{
    (void)state;
    pinch_solver_settings settings = default_settings(), newton = settings;
    newton.solver = PINCH_SOLVER_NEWTON;
    int compared = 0, different = 0;
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++) {
        static island a, b;
        int count = draw_count(10000);
        for (int seed = 1; seed <= count; seed++) {
            island_make(&a, kind, (uint64_t)seed);
            island_make(&b, kind, (uint64_t)seed);
            if (solve(&a, &settings).solve.status || solve(&b, &newton).solve.status) continue;
            referee_verdict v;
            referee_judge(&a.problem, &v);
            double difference = force_difference(&a.problem, &b.problem);
            compared++;
            if (difference <= law_tolerance(&v)) continue;
            different++;
            two_answers(kind, seed, &b.problem, difference);
        }
    }
    assert_true(compared > 7 * draw_count(10000));
    /* measured: 96 of 90,000 */
    print_message("%d of %d islands had two answers\n", different, compared);
    assert_true(different <= 2 + compared / 200);
}

/* How much stiffer the contacts are than the inertia: what a residual of 1e-10 becomes in the forces. */
static double stiffness_ratio(const pinch_problem *p)
{
    double most = 1;
    for (int k = 0; k < p->contact_count; k++) {
        const pinch_contact *c = &p->contacts[k];
        const int body[2] = {c->body1, c->body2};
        for (int side = 0; side < 2; side++) {
            if (body[side] < 0 || p->bodies[body[side]].mass == 0) continue;
            const pinch_body *b = &p->bodies[body[side]];
            double least = fmin(b->inertia[0], fmin(b->inertia[4], b->inertia[8])), arm2 = 0;
            for (int i = 0; i < 3; i++) arm2 += pow(c->position[i] - b->position[i], 2);
            double g = p->step * fmax(c->stiffness[0], c->stiffness[1]) + fmax(c->damping[0], c->damping[1]);
            most = fmax(most, p->step * g * (1 / b->mass + 2 * arm2 / least));
        }
    }
    return most;
}

/* The Kaczmarz methods by themselves stop at the tolerance: where they get there, they have the same answer. */
static void kaczmarz_agrees(pinch_solver name, int least)
{
    pinch_solver_settings settings = default_settings(), kaczmarz = settings;
    kaczmarz.solver = name;
    kaczmarz.newton_finish = false;
    kaczmarz.max_iterations = draw_full() ? 20000 : 1000;
    int compared = 0;
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++) {
        static island a, b;
        int count = draw_full() ? 200 : 15;
        for (int seed = 1; seed <= count; seed++) {
            island_make(&a, kind, (uint64_t)seed);
            island_make(&b, kind, (uint64_t)seed);
            if (solve(&a, &settings).solve.status) continue;
            pinch_step_result result = solve(&b, &kaczmarz);
            assert_int_equal(result.solve.newton_steps, 0);
            if (result.solve.status != PINCH_SOLVE_CONVERGED) {
                assert_all_nan(&b);
                continue;
            }
            referee_verdict v;
            referee_judge(&a.problem, &v);
            double tolerance = 10 * kaczmarz.tolerance * stiffness_ratio(&a.problem) * v.scale + law_tolerance(&v);
            double difference = force_difference(&a.problem, &b.problem);
            if (difference > tolerance) two_answers(kind, seed, &b.problem, difference);
            compared++;
        }
    }
    print_message("%s alone converged in %d islands\n", pinch_solver_name(name), compared);
    assert_true(compared >= least);
}

static void test_nsnmgk_alone_agrees(void **state)
{
    (void)state;
    kaczmarz_agrees(PINCH_SOLVER_NSNMGK, 30);
}

static void test_nsngrk_agrees(void **state)
{
    (void)state;
    kaczmarz_agrees(PINCH_SOLVER_NSNGRK, 30);
}

static void test_running_out_of_iterations_is_no_answer(void **state)
{
    (void)state;
    static const pinch_solver solvers[3] = {PINCH_SOLVER_NSNMGK, PINCH_SOLVER_NSNGRK, PINCH_SOLVER_NEWTON};
    int stopped = 0;
    for (int s = 0; s < 3; s++) {
        pinch_solver_settings settings = default_settings();
        settings.solver = solvers[s];
        settings.max_iterations = 1;
        for (int seed = 1; seed <= 50; seed++) {
            static island made;
            island_make(&made, ISLAND_JOINTS, (uint64_t)seed);
            pinch_step_result result = solve(&made, &settings);
            assert_true(result.solve.iterations <= 1);
            if (result.solve.status == PINCH_SOLVE_CONVERGED) continue;
            assert_int_equal(result.solve.status, PINCH_SOLVE_MAX_ITERATIONS);
            assert_true(result.solve.residual > settings.tolerance);
            assert_all_nan(&made);
            stopped++;
        }
    }
    assert_true(stopped > 75);
}

static void test_same_bits_again(void **state)
{
    (void)state;
    static const pinch_solver solvers[3] = {PINCH_SOLVER_NSNMGK, PINCH_SOLVER_NSNGRK, PINCH_SOLVER_NEWTON};
    for (int s = 0; s < 3; s++) {
        pinch_solver_settings settings = default_settings();
        settings.solver = solvers[s];
        settings.max_iterations = 300;
        for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++)
            for (int seed = 1; seed <= 10; seed++) {
                static island a, b, other;
                island_make(&a, kind, (uint64_t)seed);
                island_make(&b, kind, (uint64_t)seed);
                island_make(&other, kind, (uint64_t)seed + 1000);
                solve(&a, &settings);
                solve(&other, &settings); /* something else in between */
                solve(&b, &settings);
                assert_memory_equal(a.bodies, b.bodies, sizeof a.bodies);
                assert_memory_equal(a.contacts, b.contacts, sizeof a.contacts);
                assert_memory_equal(a.rows, b.rows, sizeof a.rows);
            }
    }
}

/* From the answer's own forces the same answer is found, at once. */
static void test_warm_start(void **state)
{
    (void)state;
    pinch_solver_settings settings = default_settings();
    int solved = 0;
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++)
        for (int seed = 1; seed <= 100; seed++) {
            static island a, b;
            island_make(&a, kind, (uint64_t)seed);
            island_make(&b, kind, (uint64_t)seed);
            if (solve(&a, &settings).solve.status) continue;
            referee_verdict v;
            referee_judge(&a.problem, &v);
            for (int k = 0; k < a.problem.contact_count; k++)
                memcpy(b.contacts[k].force, a.contacts[k].force, sizeof a.contacts[k].force);
            for (int k = 0; k < a.problem.row_count; k++) b.rows[k].force = a.rows[k].force;
            for (int k = 0; k < a.problem.body_count; k++)
                if (a.bodies[k].mass == 0) memcpy(b.bodies[k].velocity, a.bodies[k].velocity_end, sizeof(double[6]));
            pinch_step_result again = solve(&b, &settings);
            assert_int_equal(again.solve.status, PINCH_SOLVE_CONVERGED);
            assert_true(again.solve.iterations <= 3); /* rounding may leave it above the goal for a step or two */
            assert_true(force_difference(&a.problem, &b.problem) <= law_tolerance(&v));
            solved++;
        }
    assert_true(solved > 700);
}

/* What is remembered from the step before may save work but not change the answer, even where it does not fit. */
static void test_memory_does_not_change_answers(void **state)
{
    (void)state;
    pinch_solver_settings settings = default_settings();
    pinch_step_memory *memory;
    assert_int_equal(pinch_step_memory_create(&memory), PINCH_OK);
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++)
        for (int seed = 1; seed <= 100; seed++) {
            static island a, b;
            island_make(&a, kind, (uint64_t)seed);
            island_make(&b, kind, (uint64_t)seed);
            b.problem.memory = memory;
            b.problem.tag = 7; /* always the same: it claims to be the island it was */
            if (solve(&a, &settings).solve.status) continue;
            referee_verdict v;
            pinch_step_result with = solve(&b, &settings);
            if (with.solve.status) print_error("%s, seed %d\n", island_kind_name(kind), seed);
            assert_int_equal(with.solve.status, PINCH_SOLVE_CONVERGED);
            referee_judge(&b.problem, &v);
            assert_null(fault_of(&b.problem, &v));
            assert_true(force_difference(&a.problem, &b.problem) <= law_tolerance(&v));
        }
    pinch_step_memory_destroy(memory);
}

/* One change that makes a legal island illegal. */
typedef struct damage {
    const char *what;
    void (*make)(pinch_problem *p);
} damage;

static void no_step(pinch_problem *p)
{
    p->step = 0;
}
static void negative_step(pinch_problem *p)
{
    p->step = -1e-3;
}
static void endless_step(pinch_problem *p)
{
    p->step = INFINITY;
}
static void no_bodies(pinch_problem *p)
{
    p->body_count = 0;
}
static void negative_mass(pinch_problem *p)
{
    p->bodies[0].mass = -1;
}
static void no_radius(pinch_problem *p)
{
    p->bodies[0].radius = 0;
}
static void flat_inertia(pinch_problem *p)
{
    p->bodies[0].inertia[4] = 0;
}
static void indefinite_inertia(pinch_problem *p)
{
    p->bodies[0].inertia[1] = p->bodies[0].inertia[3] = 1e6;
}
static void body_beyond(pinch_problem *p)
{
    p->contacts[0].body2 = p->body_count;
}
static void body_below(pinch_problem *p)
{
    p->contacts[0].body1 = -2;
}
static void both_static(pinch_problem *p)
{
    p->contacts[0].body1 = p->contacts[0].body2 = PINCH_STATIC_BODY;
}
static void unknown_model(pinch_problem *p)
{
    p->contacts[0].model = (pinch_contact_model)2;
}
static void model_zero(pinch_problem *p)
{
    p->contacts[0].model = (pinch_contact_model)0;
}
static void large_model(pinch_problem *p)
{
    p->contacts[0].model = (pinch_contact_model)5;
}
static void no_normal(pinch_problem *p)
{
    memset(p->contacts[0].normal, 0, sizeof p->contacts[0].normal);
}
static void long_normal(pinch_problem *p)
{
    p->contacts[0].normal[0] += 1;
}
static void tangent_along_normal(pinch_problem *p)
{
    memcpy(p->contacts[0].tangent1, p->contacts[0].normal, sizeof p->contacts[0].normal);
}
static void no_stiffness(pinch_problem *p)
{
    p->contacts[0].stiffness[0] = 0;
}
static void negative_tangential(pinch_problem *p)
{
    p->contacts[0].stiffness[1] = -1;
}
static void no_torsional(pinch_problem *p)
{
    p->contacts[0].stiffness[2] = 0;
}
static void negative_damping(pinch_problem *p)
{
    p->contacts[0].damping[1] = -1;
}
static void negative_friction(pinch_problem *p)
{
    p->contacts[0].friction[1] = -0.1;
}
static void no_torsional_friction(pinch_problem *p)
{
    p->contacts[0].torsional_friction = -1e-3;
}
static void no_force_allowed(pinch_problem *p)
{
    p->contacts[0].max_force = 0;
}
static void endless_stiffness(pinch_problem *p)
{
    p->contacts[0].stiffness[0] = INFINITY;
}
static void row_beyond(pinch_problem *p)
{
    p->rows[0].body1 = p->body_count;
}
static void row_static(pinch_problem *p)
{
    p->rows[0].body1 = p->rows[0].body2 = PINCH_STATIC_BODY;
}
static void negative_cfm(pinch_problem *p)
{
    p->rows[0].cfm = -1;
}
static void crossed_limits(pinch_problem *p)
{
    p->rows[0].low = 1;
    p->rows[0].high = -1;
}

static void test_illegal_data_is_refused(void **state)
{
    (void)state;
    static const damage damages[] = {
        {"step 0", no_step},
        {"negative step", negative_step},
        {"infinite step", endless_step},
        {"no bodies", no_bodies},
        {"negative mass", negative_mass},
        {"radius 0", no_radius},
        {"singular inertia", flat_inertia},
        {"indefinite inertia", indefinite_inertia},
        {"body index too large", body_beyond},
        {"body index below static", body_below},
        {"both static", both_static},
        {"model 2", unknown_model},
        {"model 0", model_zero},
        {"model 5", large_model},
        {"normal 0", no_normal},
        {"normal not of length one", long_normal},
        {"tangent along the normal", tangent_along_normal},
        {"stiffness 0", no_stiffness},
        {"negative tangential stiffness", negative_tangential},
        {"torsional stiffness 0", no_torsional},
        {"negative damping", negative_damping},
        {"negative friction", negative_friction},
        {"torsional friction 0", no_torsional_friction},
        {"force limit 0", no_force_allowed},
        {"infinite stiffness", endless_stiffness},
        {"row's body too large", row_beyond},
        {"row between statics", row_static},
        {"negative compliance", negative_cfm},
        {"limits crossed", crossed_limits},
    };
    pinch_solver_settings settings = default_settings();
    static island made;
    pinch_step_result result;
    int wrong = 0;
    for (size_t i = 0; i < sizeof damages / sizeof damages[0]; i++) {
        island_make(&made, ISLAND_JOINTS, 3);
        made.contacts[0].model = PINCH_CONTACT_SOFT;
        damages[i].make(&made.problem);
        if (pinch_step_solve(solver, &made.problem, &settings, &result) == PINCH_INVALID_ARGUMENT) continue;
        print_error("not refused: %s\n", damages[i].what);
        wrong++;
    }
    assert_int_equal(wrong, 0);

    island_make(&made, ISLAND_HARD, 3);
    settings.solver = PINCH_SOLVER_LEMKE;
    assert_int_equal(pinch_step_solve(solver, &made.problem, &settings, &result), PINCH_UNSUPPORTED);
    settings.solver = PINCH_SOLVER_NSNMGK;
    settings.tolerance = 0;
    assert_int_equal(pinch_step_solve(solver, &made.problem, &settings, &result), PINCH_INVALID_ARGUMENT);
    settings = pinch_default_solver_settings();
    settings.max_iterations = 0;
    assert_int_equal(pinch_step_solve(solver, &made.problem, &settings, &result), PINCH_INVALID_ARGUMENT);
}

/* A NaN in any input is refused, or is in a field that this island does not use: then the answer is the same. */
static int poison_fields(void *array, size_t size, const size_t *offsets, const int *counts, int fields, island *made,
                         island *clean)
{
    pinch_solver_settings settings = default_settings();
    int refused = 0;
    (void)size;
    for (int f = 0; f < fields; f++)
        for (int i = 0; i < counts[f]; i++) {
            island_make(made, ISLAND_JOINTS, 3);
            made->contacts[0].model = PINCH_CONTACT_SOFT;
            *(double *)(void *)((char *)array + offsets[f] + sizeof(double) * (size_t)i) = NAN;
            pinch_step_result result;
            pinch_status status = pinch_step_solve(solver, &made->problem, &settings, &result);
            if (status == PINCH_INVALID_ARGUMENT) {
                refused++;
                continue;
            }
            assert_int_equal(status, PINCH_OK);
            assert_int_equal(result.solve.status, PINCH_SOLVE_CONVERGED);
            for (int k = 0; k < clean->problem.contact_count; k++)
                assert_memory_equal(made->contacts[k].force, clean->contacts[k].force, sizeof(double[4]));
        }
    return refused;
}

static void test_nan_is_refused(void **state)
{
    (void)state;
    static island made, clean;
    pinch_solver_settings settings = default_settings();
    island_make(&clean, ISLAND_JOINTS, 3);
    clean.contacts[0].model = PINCH_CONTACT_SOFT;
    assert_int_equal(solve(&clean, &settings).solve.status, PINCH_SOLVE_CONVERGED);

#define FIELD(type, name) offsetof(type, name)
    const size_t body[] = {FIELD(pinch_body, mass),     FIELD(pinch_body, inertia),  FIELD(pinch_body, position),
                           FIELD(pinch_body, velocity), FIELD(pinch_body, external), FIELD(pinch_body, radius)};
    const int body_counts[] = {1, 9, 3, 6, 6, 1};
    assert_int_equal(poison_fields(made.bodies, sizeof made.bodies[0], body, body_counts, 6, &made, &clean), 26);
    const size_t contact[] = {
        FIELD(pinch_contact, position),  FIELD(pinch_contact, normal),    FIELD(pinch_contact, tangent1),
        FIELD(pinch_contact, depth),     FIELD(pinch_contact, stiffness), FIELD(pinch_contact, damping),
        FIELD(pinch_contact, elastic),   FIELD(pinch_contact, friction),  FIELD(pinch_contact, torsional_friction),
        FIELD(pinch_contact, max_force), FIELD(pinch_contact, force),     FIELD(pinch_contact, surface_velocity)};
    const int contact_counts[] = {3, 3, 3, 1, 3, 3, 3, 2, 1, 1, 4, 4};
    assert_int_equal(poison_fields(made.contacts, sizeof made.contacts[0], contact, contact_counts, 12, &made, &clean),
                     31);
    const size_t row[] = {FIELD(pinch_joint_row, j1), FIELD(pinch_joint_row, j2), FIELD(pinch_joint_row, rhs),
                          FIELD(pinch_joint_row, cfm), FIELD(pinch_joint_row, force)};
    const int row_counts[] = {6, 6, 1, 1, 1};
    assert_int_equal(poison_fields(made.rows, sizeof made.rows[0], row, row_counts, 5, &made, &clean), 15);
    const size_t limits[] = {FIELD(pinch_joint_row, low), FIELD(pinch_joint_row, high)};
    const int limit_counts[] = {1, 1};
    assert_int_equal(poison_fields(made.rows, sizeof made.rows[0], limits, limit_counts, 2, &made, &clean), 2);
    const size_t step[] = {FIELD(pinch_problem, step)};
    const int step_count[] = {1};
    assert_int_equal(poison_fields(&made.problem, sizeof made.problem, step, step_count, 1, &made, &clean), 1);
}

/* Contacts that all but open while the forces of the step before say otherwise: what is left is measured by what is
 * left, not by what was. Next to no force, next to no velocity, a warm start a thousand times too large. */
static void test_contacts_that_hardly_touch(void **state)
{
    (void)state;
    pinch_solver_settings settings = default_settings();
    pinch_random random;
    pinch_random_seed(&random, 12);
    int unverified = 0;
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++) {
        if (kind == ISLAND_DRIVES || kind == ISLAND_JOINTS) continue;
        for (int seed = 1; seed <= 200; seed++) {
            static island made;
            island_make(&made, kind, (uint64_t)seed);
            for (int b = 0; b < made.problem.body_count; b++) {
                memset(made.bodies[b].external, 0, sizeof made.bodies[b].external);
                for (int i = 0; i < 6; i++) made.bodies[b].velocity[i] *= 1e-7;
            }
            for (int k = 0; k < made.problem.contact_count; k++) {
                pinch_contact *c = &made.contacts[k];
                c->depth = draw_uniform(&random, -1, 1) * 1e-6 / c->stiffness[0];
                memset(c->surface_velocity, 0, sizeof c->surface_velocity);
                memset(c->elastic, 0, sizeof c->elastic);
                c->force[0] = draw_uniform(&random, 0, 1e-3);
            }
            pinch_step_result result = solve(&made, &settings);
            if (result.solve.status == PINCH_SOLVE_UNVERIFIED) {
                print_error("%s, seed %d: residual %g\n", island_kind_name(kind), seed, result.residual_max);
                unverified++;
            }
        }
    }
    assert_int_equal(unverified, 0);
}

/* Bodies that fly freely, joints and all, with contacts that do not touch: nothing but rounding to balance. */
static void test_free_flight(void **state)
{
    (void)state;
    pinch_solver_settings settings = pinch_default_solver_settings();
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++) {
        if (kind == ISLAND_DRIVES) continue; /* a drive goes on until it touches */
        for (int seed = 1; seed <= 200; seed++) {
            static island made;
            island_make(&made, kind, (uint64_t)seed);
            int hard = 0;
            for (int k = 0; k < made.problem.contact_count; k++) made.contacts[k].depth = -1;
            for (int k = 0; k < made.problem.row_count; k++) {
                pinch_joint_row *row = &made.rows[k];
                if (row->cfm > 0 || isfinite(row->low) || isfinite(row->high)) continue;
                row->rhs = 0;
                made.rows[hard++] = *row;
            }
            made.problem.row_count = hard;
            for (int b = 0; b < made.problem.body_count; b++) {
                /* at v* the joints hold to rounding already, as after a step */
                memset(made.bodies[b].external, 0, sizeof made.bodies[b].external);
            }
            pinch_step_result result = solve(&made, &settings);
            assert_int_equal(result.solve.status, PINCH_SOLVE_CONVERGED);
            for (int b = 0; b < made.problem.body_count; b++)
                memcpy(made.bodies[b].velocity, made.bodies[b].velocity_end, sizeof made.bodies[b].velocity);
            result = solve(&made, &settings);
            if (result.solve.status) print_error("%s, seed %d\n", island_kind_name(kind), seed);
            assert_int_equal(result.solve.status, PINCH_SOLVE_CONVERGED);
            for (int k = 0; k < made.problem.contact_count; k++) assert_true(made.contacts[k].force[0] == 0);
        }
    }
}

/* A body without contacts and an island without unknowns. */
static void test_trivial_islands(void **state)
{
    (void)state;
    static island made;
    pinch_solver_settings settings = default_settings();
    island_make(&made, ISLAND_HARD, 1);
    made.problem.contact_count = 0;
    assert_int_equal(solve(&made, &settings).solve.status, PINCH_SOLVE_CONVERGED);
    for (int b = 0; b < made.problem.body_count; b++)
        for (int i = 0; i < 6; i++) assert_close(made.bodies[b].velocity_end[i], made.bodies[b].velocity[i], 1e-15);

    /* a body held by six hard rows has no freedom left: its contacts still get their forces, its rows take them */
    island_make(&made, ISLAND_GRASP, 1);
    made.problem.row_count = 6;
    for (int k = 0; k < 6; k++) {
        memset(&made.rows[k], 0, sizeof made.rows[k]);
        made.rows[k].body2 = PINCH_STATIC_BODY;
        made.rows[k].j1[k] = 1;
        made.rows[k].low = -INFINITY;
        made.rows[k].high = INFINITY;
    }
    pinch_step_result result = solve(&made, &settings);
    assert_int_equal(result.solve.status, PINCH_SOLVE_CONVERGED);
    assert_int_equal(result.unknowns, 0);
    referee_verdict v;
    referee_judge(&made.problem, &v);
    assert_null(fault_of(&made.problem, &v));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_answers_satisfy_the_laws),
        cmocka_unit_test(test_reported_errors_are_true),
        cmocka_unit_test(test_newton_agrees),
        cmocka_unit_test(test_nsnmgk_alone_agrees),
        cmocka_unit_test(test_nsngrk_agrees),
        cmocka_unit_test(test_running_out_of_iterations_is_no_answer),
        cmocka_unit_test(test_same_bits_again),
        cmocka_unit_test(test_warm_start),
        cmocka_unit_test(test_memory_does_not_change_answers),
        cmocka_unit_test(test_illegal_data_is_refused),
        cmocka_unit_test(test_nan_is_refused),
        cmocka_unit_test(test_contacts_that_hardly_touch),
        cmocka_unit_test(test_free_flight),
        cmocka_unit_test(test_trivial_islands),
    };
    return cmocka_run_group_tests_name("random islands", tests, create_solver, destroy_solver);
}
