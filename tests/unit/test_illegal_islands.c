/* These islands are wrong by one number, or have one that is not a number. Every solver must refuse them. */
#include "support/cmocka_all.h"

#include "support/island_check.h"

#include <string.h>

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
static void with_itself(pinch_problem *p)
{
    p->contacts[0].body1 = p->contacts[0].body2 = 0;
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
        {"body with itself", with_itself},
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
    pinch_solver_settings settings = island_settings();
    static island made;
    pinch_step_result result;
    int wrong = 0;
    for (size_t i = 0; i < sizeof damages / sizeof damages[0]; i++) {
        island_make(&made, ISLAND_JOINTS, 3);
        made.contacts[0].model = PINCH_CONTACT_SOFT;
        damages[i].make(&made.problem);
        if (pinch_step_solve(island_solver, &made.problem, &settings, &result) == PINCH_INVALID_ARGUMENT) continue;
        print_error("not refused: %s\n", damages[i].what);
        wrong++;
    }
    assert_int_equal(wrong, 0);

    island_make(&made, ISLAND_HARD, 3);
    settings.solver = PINCH_SOLVER_LEMKE;
    assert_int_equal(pinch_step_solve(island_solver, &made.problem, &settings, &result), PINCH_UNSUPPORTED);
    settings.solver = PINCH_SOLVER_NSNMGK;
    settings.tolerance = 0;
    assert_int_equal(pinch_step_solve(island_solver, &made.problem, &settings, &result), PINCH_INVALID_ARGUMENT);
    settings = pinch_default_solver_settings();
    settings.max_iterations = 0;
    assert_int_equal(pinch_step_solve(island_solver, &made.problem, &settings, &result), PINCH_INVALID_ARGUMENT);
}

/* A NaN in any input is refused, or is in a field that this island does not use: then the answer is the same. */
static int poison_fields(void *array, size_t size, const size_t *offsets, const int *counts, int fields, island *made,
                         island *clean)
{
    pinch_solver_settings settings = island_settings();
    int refused = 0;
    (void)size;
    for (int f = 0; f < fields; f++)
        for (int i = 0; i < counts[f]; i++) {
            island_make(made, ISLAND_JOINTS, 3);
            made->contacts[0].model = PINCH_CONTACT_SOFT;
            *(double *)(void *)((char *)array + offsets[f] + sizeof(double) * (size_t)i) = NAN;
            pinch_step_result result;
            pinch_status status = pinch_step_solve(island_solver, &made->problem, &settings, &result);
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
    pinch_solver_settings settings = island_settings();
    island_make(&clean, ISLAND_JOINTS, 3);
    clean.contacts[0].model = PINCH_CONTACT_SOFT;
    assert_int_equal(island_solve(&clean, &settings).solve.status, PINCH_SOLVE_CONVERGED);

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_illegal_data_is_refused),
        cmocka_unit_test(test_nan_is_refused),
    };
    return cmocka_run_group_tests_name("illegal islands", tests, island_create_solver, island_destroy_solver);
}
