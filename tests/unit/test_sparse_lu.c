/* Compares the factorization that leaves out zeros with the dense one, on random matrices of trees. */
#include "support/cmocka_all.h"

#include "support/draw.h"
#include "support/lu.h"
#include "support/sparse_lu.h"

#include <math.h>
#include <string.h>

enum { MOST = 150 };

/* Places of a tree, the leaves first: entry (i, j) is not zero only where one hangs from the other. Returns how many
 * entries are not zero. */
static int fill_tree(pinch_random *random, int n, double *a)
{
    int entries = 0;
    int above[MOST];
    memset(a, 0, sizeof *a * (size_t)n * (size_t)n);
    for (int i = 0; i < n; i++) above[i] = i + 1 < n ? i + 1 + draw_index(random, n - i - 1 < 8 ? n - i - 1 : 8) : n;
    for (int i = 0; i < n; i++) {
        a[i * n + i] = 2 + n * draw_uniform(random, 0.1, 1);
        entries++;
        for (int j = above[i]; j < n; j = above[j]) {
            a[i * n + j] = draw_uniform(random, -1, 1);
            a[j * n + i] = draw_uniform(random, -1, 1);
            entries += 2;
        }
    }
    return entries;
}

static int not_zero(int n, const double *a)
{
    int count = 0;
    for (int i = 0; i < n * n; i++) count += a[i] != 0;
    return count;
}

static void test_trees_fill_nothing_in(void **state)
{
    (void)state;
    static double a[MOST * MOST], dense[MOST * MOST];
    for (int seed = 1; seed <= 300; seed++) {
        double b[MOST], x[MOST], y[MOST], scratch[MOST];
        int pivot[MOST], none[MOST];
        pinch_random random;
        pinch_arena arena;
        pinch_sparse_lu lu;
        pinch_random_seed(&random, (uint64_t)seed);
        pinch_arena_init(&arena);
        pinch_arena_reset(&arena);
        int n = 1 + draw_index(&random, MOST);
        assert_true(pinch_sparse_lu_allocate(&arena, n, &lu));
        int entries = fill_tree(&random, n, a);
        memcpy(dense, a, sizeof dense);
        for (int i = 0; i < n; i++) {
            b[i] = draw_uniform(&random, -1, 1);
            none[i] = i;
        }
        assert_true(pinch_lu_factor(n, dense, pivot, scratch));
        assert_true(pinch_sparse_lu_factor(&lu, n, a));
        assert_int_equal(not_zero(n, a), entries);
        pinch_lu_solve(n, dense, pivot, b, x);
        memcpy(y, b, sizeof y);
        pinch_lu_solve_strands(n, a, none, y);
        for (int i = 0; i < n; i++) assert_true(fabs(x[i] - y[i]) < 1e-12);
        pinch_lu_solve(n, a, none, b, y);
        for (int i = 0; i < n; i++) assert_true(fabs(x[i] - y[i]) < 1e-12);
        pinch_arena_free(&arena);
    }
}

/* What fills in is counted in: an arrow whose head comes first is full afterwards. */
static void test_fill_in_is_kept(void **state)
{
    (void)state;
    enum { N = 70 };
    static double a[N * N], dense[N * N];
    double b[N], x[N], y[N], scratch[N];
    int pivot[N], none[N];
    pinch_arena arena;
    pinch_sparse_lu lu;
    pinch_arena_init(&arena);
    pinch_arena_reset(&arena);
    assert_true(pinch_sparse_lu_allocate(&arena, N, &lu));
    memset(a, 0, sizeof a);
    for (int i = 0; i < N; i++) {
        a[i * N + i] = N;
        a[i] = a[i * N] = i == 0 ? N : 1;
        b[i] = i;
        none[i] = i;
    }
    memcpy(dense, a, sizeof a);
    assert_true(pinch_lu_factor(N, dense, pivot, scratch));
    assert_true(pinch_sparse_lu_factor(&lu, N, a));
    assert_int_equal(not_zero(N, a), N * N);
    pinch_lu_solve(N, dense, pivot, b, x);
    pinch_lu_solve(N, a, none, b, y);
    for (int i = 0; i < N; i++) assert_true(fabs(x[i] - y[i]) < 1e-12);
    pinch_arena_free(&arena);
}

static void test_bad_pivots_are_reported(void **state)
{
    (void)state;
    double zero[] = {0, 1, 1, 0}, tiny[] = {1e-12, 1, 1, 1}, nan[] = {NAN, 1, 1, 1};
    pinch_arena arena;
    pinch_sparse_lu lu;
    pinch_arena_init(&arena);
    pinch_arena_reset(&arena);
    assert_true(pinch_sparse_lu_allocate(&arena, 2, &lu));
    assert_false(pinch_sparse_lu_factor(&lu, 2, zero));
    assert_false(pinch_sparse_lu_factor(&lu, 2, tiny));
    assert_false(pinch_sparse_lu_factor(&lu, 2, nan));
    pinch_arena_free(&arena);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_trees_fill_nothing_in),
        cmocka_unit_test(test_fill_in_is_kept),
        cmocka_unit_test(test_bad_pivots_are_reported),
    };
    return cmocka_run_group_tests_name("sparse LU", tests, NULL, NULL);
}
