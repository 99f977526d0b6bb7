/* Checks demos/exact by closed forms and by the referee on random islands, and then Pinch's answers by demos/exact. */
#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/island.h"
#include "support/referee.h"

#include "exact/exact.h"

#include <string.h>

/* A 1 kg ball of 0.1 m that lies on a point of kn = 1000 N/m, kt = 500 N/m; h = 0.01 s. */
static void make_ball(island *made, double mu)
{
    memset(made, 0, sizeof *made);
    pinch_problem *p = &made->problem;
    *p = (pinch_problem){.step = 0.01, .body_count = 1, .contact_count = 1};
    p->bodies = made->bodies;
    p->contacts = made->contacts;
    p->rows = made->rows;
    made->bodies[0] = (pinch_body){.mass = 1, .inertia = {0.004, 0, 0, 0, 0.004, 0, 0, 0, 0.004}, .radius = 0.1};
    made->contacts[0] = (pinch_contact){
        .body1 = 0,
        .body2 = PINCH_STATIC_BODY,
        .model = PINCH_CONTACT_HARD,
        .position = {0, 0, -0.1},
        .normal = {0, 0, 1},
        .tangent1 = {1, 0, 0},
        .depth = 0.01,
        .stiffness = {1000, 500, 0},
        .friction = {mu, mu},
        .max_force = INFINITY,
    };
}

static exact_answer solved(const island *made)
{
    exact_answer answer;
    assert_int_equal(exact_solve(&made->problem, &answer), EXACT_OK);
    assert_true(answer.residual <= 1e-15);
    return answer;
}

/* r = kn (delta - h w), w = v* + h r/m:  r = kn (delta - h v*) / (1 + h^2 kn/m) */
static void test_normal_force(void **state)
{
    (void)state;
    island made;
    make_ball(&made, 0);
    made.bodies[0].velocity[2] = -0.3;
    exact_answer answer = solved(&made);
    double r = 1000 * (0.01 + 0.01 * 0.3) / (1 + 1e-4 * 1000);
    assert_close(answer.force[0], r, 1e-14);
    assert_close(answer.velocity[2], -0.3 + 0.01 * r, 1e-15);
    exact_free(&answer);

    made.contacts[0].max_force = 5; /* yields */
    answer = solved(&made);
    assert_close(answer.force[0], 5, 0);
    exact_free(&answer);

    made.bodies[0].velocity[2] = 2; /* leaves */
    answer = solved(&made);
    assert_close(answer.force[0], 0, 0);
    assert_close(answer.velocity[2], 2, 0);
    exact_free(&answer);
}

/* The tangent's mass at the point is 1/(1/m + R^2/I): W = 1 + 0.01/0.004 = 3.5 /kg. Sticking: r = -kt h v0/(1 + h^2 kt
 * W); slipping: mu r_n against the motion. */
static void test_friction(void **state)
{
    (void)state;
    island made;
    make_ball(&made, 10);
    made.bodies[0].velocity[0] = 0.4;
    made.bodies[0].velocity[1] = -0.3;
    double normal = 1000 * 0.01 / 1.1, stick = -500 * 0.01 / (1 + 1e-4 * 500 * 3.5);
    exact_answer answer = solved(&made);
    assert_close(answer.force[0], normal, 1e-14);
    assert_close(answer.force[1], stick * 0.4, 1e-14);
    assert_close(answer.force[2], -stick * 0.3, 1e-14);
    exact_free(&answer);

    made.contacts[0].friction[0] = made.contacts[0].friction[1] = 0.05;
    answer = solved(&made);
    assert_close(answer.force[1], -0.05 * normal * 0.8, 1e-14);
    assert_close(answer.force[2], 0.05 * normal * 0.6, 1e-14);
    exact_free(&answer);

    /* an elastic state pushes back without any motion */
    make_ball(&made, 10);
    made.contacts[0].elastic[1] = 1e-3;
    answer = solved(&made);
    assert_close(answer.force[2], -0.5 / (1 + 1e-4 * 500 * 3.5), 1e-14);
    exact_free(&answer);
}

/* A massless drive pushes with exactly its force, whatever the stiffness: the ball between it and a wall. */
static void test_drive(void **state)
{
    (void)state;
    island made;
    make_ball(&made, 0.5);
    made.problem.body_count = made.problem.contact_count = 2;
    made.bodies[1] = (pinch_body){.radius = 1, .drive_axis = {0, 0, -1}, .drive_force = 7};
    made.contacts[1] = made.contacts[0];
    made.contacts[1].body2 = 1;
    made.contacts[1].position[2] = 0.1;
    made.contacts[1].normal[2] = -1;
    exact_answer answer = solved(&made);
    assert_close(answer.force[4], 7, 1e-14);
    exact_free(&answer);
}

/* A row that holds the ball's height takes over the normal force. */
static void test_joint_row(void **state)
{
    (void)state;
    island made;
    make_ball(&made, 0.5);
    made.problem.row_count = 1;
    made.rows[0] = (pinch_joint_row){.body1 = 0, .body2 = -1, .j1 = {0, 0, 1}, .low = -INFINITY, .high = INFINITY};
    made.bodies[0].velocity[2] = -0.2;
    exact_answer answer = solved(&made);
    assert_close(answer.velocity[2], 0, 1e-16);
    assert_close(answer.force[0], 10, 1e-14);
    assert_close(answer.row[0], 10, 1e-13); /* 1 kg at 0.2 m/s in 0.01 s is 20 N, of which the contact gives 10 */
    exact_free(&answer);
}

static void test_unsupported(void **state)
{
    (void)state;
    island made;
    exact_answer answer;
    make_ball(&made, 0.5);
    made.contacts[0].viscous[0] = 0.1;
    assert_int_equal(exact_solve(&made.problem, &answer), EXACT_UNSUPPORTED);
}

/* The answer into the problem's outputs, as the referee reads them. */
static void write_answer(island *made, const exact_answer *answer)
{
    const pinch_problem *p = &made->problem;
    for (int b = 0; b < p->body_count; b++)
        memcpy(p->bodies[b].velocity_end, answer->velocity + 6 * b, sizeof p->bodies[b].velocity_end);
    for (int k = 0; k < p->contact_count; k++) {
        memcpy(p->contacts[k].force, answer->force + 4 * k, sizeof p->contacts[k].force);
        memset(p->contacts[k].slip, 0, sizeof p->contacts[k].slip);
    }
    for (int k = 0; k < p->row_count; k++) p->rows[k].force = answer->row[k];
}

/* Velocities in double are rounded, and the laws multiply that: 64 roundings. */
static const char *fault_of(const referee_verdict *v)
{
    double allowed = 1e-11 * v->scale + 64 * v->rounding;
    if (!(v->balance <= allowed)) return "momentum balance";
    if (!(v->drive <= allowed)) return "balance of a drive";
    if (!(v->normal <= allowed)) return "normal law";
    if (!(v->friction <= allowed)) return "friction law";
    if (!(v->cone <= allowed)) return "cone";
    if (!(v->compliant <= allowed)) return "compliant row";
    if (!(v->joint <= 1e-12)) return "hard row";
    if (!(v->limited <= 1e-9 * fmax(v->scale, 1))) return "one-sided row";
    return NULL;
}

static void test_random_islands(void **state)
{
    (void)state;
    int count = draw_count(6000), wrong = 0, lost = 0, lost_drives = 0;
    for (island_kind kind = 0; kind < ISLAND_KIND_COUNT; kind++)
        for (int seed = 1; seed <= count; seed++) {
            static island made;
            exact_answer answer;
            referee_verdict verdict;
            island_make(&made, kind, (uint64_t)seed);
            if (exact_solve(&made.problem, &answer) != EXACT_OK) {
                if (kind == ISLAND_DRIVES)
                    lost_drives++;
                else
                    lost++;
                print_message("%s %d: no answer found\n", island_kind_name(kind), seed);
                continue;
            }
            write_answer(&made, &answer);
            exact_free(&answer);
            referee_judge(&made.problem, &verdict);
            const char *fault = fault_of(&verdict);
            if (!fault) continue;
            wrong++;
            print_error("%s %d: %s\n", island_kind_name(kind), seed, fault);
        }
    assert_int_equal(wrong, 0);
    /* of 6000 each: 8 of violent cold starts, and 61 with two drives, which may push past each other without a balance
     */
    assert_true(lost <= 1 + count / 100);
    assert_true(lost_drives <= 2 + count / 50);
}

/* Grasps have one answer: Pinch's is the same, found another way. */
static void test_beside_pinch(void **state)
{
    (void)state;
    pinch_step_solver *solver;
    pinch_solver_settings settings = pinch_default_solver_settings();
    assert_int_equal(pinch_step_solver_create(&solver), PINCH_OK);
    int count = draw_count(6000), other = 0;
    for (int seed = 1; seed <= count; seed++) {
        static island made;
        exact_answer answer;
        pinch_step_result result;
        island_make(&made, ISLAND_GRASP, (uint64_t)seed);
        assert_int_equal(exact_solve(&made.problem, &answer), EXACT_OK);
        assert_int_equal(pinch_step_solve(solver, &made.problem, &settings, &result), PINCH_OK);
        double off = 0;
        for (int k = 0; k < made.problem.contact_count; k++)
            for (int i = 0; i < 3; i++) off = fmax(off, fabs(answer.force[4 * k + i] - made.contacts[k].force[i]));
        if (result.solve.status != PINCH_SOLVE_CONVERGED || !(off <= 1e-9 * answer.scale)) {
            print_error("grasp %d: %g of %g N apart\n", seed, off, answer.scale);
            other++;
        }
        exact_free(&answer);
    }
    pinch_step_solver_destroy(solver);
    assert_int_equal(other, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_normal_force), cmocka_unit_test(test_friction),    cmocka_unit_test(test_drive),
        cmocka_unit_test(test_joint_row),    cmocka_unit_test(test_unsupported), cmocka_unit_test(test_random_islands),
        cmocka_unit_test(test_beside_pinch),
    };
    return cmocka_run_group_tests_name("the exact step", tests, NULL, NULL);
}
