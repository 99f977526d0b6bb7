/* Compares the sparse block factorization with the dense one, on random graphs of blocks of all sizes. */
#include "support/cmocka_all.h"

#include "support/block_dilu.h"
#include "support/blocks.h"
#include "support/crew.h"
#include "support/draw.h"
#include "support/lu.h"

#include <math.h>
#include <string.h>

enum { MAX_BLOCKS = 14, MAX_SIZE = 9, MAX_UNKNOWNS = MAX_BLOCKS * MAX_SIZE, MAX_EDGES = 40 };

typedef struct matrix {
    int count, size[MAX_BLOCKS], first[MAX_BLOCKS + 1], edges, edge[2 * MAX_EDGES];
    double dense[MAX_UNKNOWNS * MAX_UNKNOWNS];
} matrix;

static void fill_block(matrix *m, pinch_random *random, pinch_block_lu *lu, int row, int column)
{
    int n = m->first[m->count];
    double *block = pinch_block_lu_at(lu, row, column);
    for (int i = 0; i < m->size[row]; i++)
        for (int j = 0; j < m->size[column]; j++) {
            double value = draw_uniform(random, -1, 1) + (row == column && i == j ? 6 : 0);
            block[i * m->size[column] + j] += value;
            m->dense[(m->first[row] + i) * n + m->first[column] + j] += value;
        }
}

static void draw_structure(matrix *m, pinch_random *random)
{
    memset(m, 0, sizeof *m);
    m->count = 1 + draw_index(random, MAX_BLOCKS);
    for (int b = 0; b < m->count; b++) {
        m->size[b] = draw_chance(random, 0.5) ? 6 : 1 + draw_index(random, MAX_SIZE);
        m->first[b + 1] = m->first[b] + m->size[b];
    }
    int wanted = m->count > 1 ? draw_index(random, MAX_EDGES) : 0; /* repeated ones among them */
    while (m->edges < wanted) {
        int a = draw_index(random, m->count), b = draw_index(random, m->count);
        if (a == b) continue;
        m->edge[2 * m->edges] = a;
        m->edge[2 * m->edges++ + 1] = b;
    }
}

/* Diagonally dominant: neither factorization may hide behind the other's trouble. Returns the unknowns. */
static int fill_matrix(matrix *m, pinch_random *random, pinch_block_lu *lu)
{
    pinch_block_lu_clear(lu);
    for (int b = 0; b < m->count; b++) fill_block(m, random, lu, b, b);
    for (int e = 0; e < m->edges; e++) {
        fill_block(m, random, lu, m->edge[2 * e], m->edge[2 * e + 1]);
        fill_block(m, random, lu, m->edge[2 * e + 1], m->edge[2 * e]);
    }
    int n = m->first[m->count];
    for (int i = 0, b = 0; i < n; i++) {
        double sum = 0;
        while (i >= m->first[b + 1]) b++;
        for (int j = 0; j < n; j++) sum += fabs(m->dense[i * n + j]);
        m->dense[i * n + i] += sum;
        pinch_block_lu_at(lu, b, b)[(i - m->first[b]) * (m->size[b] + 1)] += sum;
    }
    return n;
}

static void test_agrees_with_the_dense_factorization(void **state)
{
    (void)state;
    static matrix m;
    static double x[MAX_UNKNOWNS], y[MAX_UNKNOWNS], scratch[MAX_UNKNOWNS];
    static int pivot[MAX_UNKNOWNS];
    pinch_random random;
    pinch_arena arena;
    pinch_random_seed(&random, 11);
    pinch_arena_init(&arena);
    for (int round = 0; round < 300; round++) {
        pinch_block_lu lu;
        pinch_arena_reset(&arena);
        draw_structure(&m, &random);
        assert_true(pinch_block_lu_plan(&arena, &(pinch_block_graph){m.count, m.count, m.edges, m.edge}, m.size,
                                        INFINITY, NULL, &lu));
        int n = fill_matrix(&m, &random, &lu);
        for (int i = 0; i < n; i++) x[i] = y[i] = draw_uniform(&random, -1, 1);
        assert_true(pinch_block_lu_factor_and_solve(&lu, NULL, x));
        assert_true(pinch_lu_factor(n, m.dense, pivot, scratch));
        pinch_lu_solve(n, m.dense, pivot, y, y);
        for (int i = 0; i < n; i++) assert_true(fabs(x[i] - y[i]) <= 1e-13);
    }
    pinch_arena_free(&arena);
}

/* ---- by many threads ---- */

/* Wide blocks are among those of every other round, and then one thread does it all. */
static void test_a_crew_finds_the_same_bits(void **state)
{
    (void)state;
    static matrix m;
    static double x[MAX_UNKNOWNS], y[MAX_UNKNOWNS];
    pinch_random random;
    pinch_arena arena;
    pinch_random_seed(&random, 17);
    pinch_arena_init(&arena);
    for (int round = 0; round < 200; round++) {
        pinch_block_lu lu, shared;
        int threads = round % CREW;
        const pinch_crew crew = {crew_call_all, &threads};
        pinch_arena_reset(&arena);
        draw_structure(&m, &random);
        for (int b = 0; b < m.count; b++) {
            if (round % 2 && m.size[b] > 6) m.size[b] = 6;
            m.first[b + 1] = m.first[b] + m.size[b];
        }
        const pinch_block_graph graph = {m.count, m.count, m.edges, m.edge};
        assert_true(pinch_block_lu_plan(&arena, &graph, m.size, INFINITY, NULL, &lu));
        assert_true(pinch_block_lu_plan(&arena, &graph, m.size, INFINITY, NULL, &shared));
        assert_true(pinch_block_lu_share(&arena, &shared));
        int n = fill_matrix(&m, &random, &lu);
        memcpy(shared.values, lu.values, sizeof *lu.values * lu.value_count);
        for (int i = 0; i < n; i++) x[i] = y[i] = draw_uniform(&random, -1, 1);
        assert_true(pinch_block_lu_factor_and_solve(&lu, NULL, x));
        assert_true(pinch_block_lu_factor_and_solve(&shared, &crew, y));
        assert_memory_equal(x, y, sizeof *x * (size_t)n);
        assert_memory_equal(lu.values, shared.values, sizeof *lu.values * lu.value_count);
        pinch_block_lu_solve(&lu, NULL, x);
        pinch_block_lu_solve(&shared, &crew, y);
        assert_memory_equal(x, y, sizeof *x * (size_t)n);
        pinch_block_lu_clear(&shared);
        assert_false(pinch_block_lu_factor_and_solve(&shared, &crew, y));
    }
    pinch_arena_free(&arena);
}

static void test_singular_blocks_are_noticed(void **state)
{
    (void)state;
    const int size[2] = {3, 2}, edge[2] = {0, 1};
    pinch_arena arena;
    pinch_block_lu lu;
    double b[5] = {0}, room[15];
    pinch_arena_init(&arena);
    for (int incomplete = 0; incomplete < 2; incomplete++) {
        assert_true(pinch_block_lu_plan(&arena, &(pinch_block_graph){2, 2, 1, edge}, size, incomplete ? 0 : INFINITY,
                                        NULL, &lu));
        pinch_block_lu_clear(&lu);
        assert_false(incomplete ? pinch_block_dilu_split(&lu, b, room) : pinch_block_lu_factor_and_solve(&lu, NULL, b));
        pinch_block_lu_clear(&lu);
        for (int k = 0; k < 2; k++)
            for (int i = 0; i < size[k]; i++) pinch_block_lu_at(&lu, k, k)[i * (size[k] + 1)] = 1;
        pinch_block_lu_at(&lu, 0, 0)[0] = NAN;
        assert_false(incomplete ? pinch_block_dilu_split(&lu, b, room) : pinch_block_lu_factor_and_solve(&lu, NULL, b));
    }
    assert_int_equal(pinch_block_dilu_room(&lu), sizeof room / sizeof room[0]);
    pinch_arena_free(&arena);
}

/* A chain of chance, which no elimination from its end fills in. */
static void draw_chain(matrix *m, pinch_random *random)
{
    draw_structure(m, random);
    m->edges = 0;
    for (int b = 1; b < m->count; b++) {
        m->edge[2 * m->edges] = b - 1;
        m->edge[2 * m->edges++ + 1] = b;
    }
}

static void copy_block(const matrix *m, pinch_block_lu *lu, int row, int column)
{
    int n = m->first[m->count];
    double *block = pinch_block_lu_at(lu, row, column);
    for (int i = 0; i < m->size[row]; i++)
        for (int j = 0; j < m->size[column]; j++)
            block[i * m->size[column] + j] = m->dense[(m->first[row] + i) * n + m->first[column] + j];
}

/* The same matrix once more. */
static void refill(const matrix *m, pinch_block_lu *lu)
{
    pinch_block_lu_clear(lu);
    for (int b = 0; b < m->count; b++) copy_block(m, lu, b, b);
    for (int e = 0; e < m->edges; e++) {
        copy_block(m, lu, m->edge[2 * e], m->edge[2 * e + 1]);
        copy_block(m, lu, m->edge[2 * e + 1], m->edge[2 * e]);
    }
}

static void dense_times(const matrix *m, const double *x, double *y)
{
    int n = m->first[m->count];
    for (int i = 0; i < n; i++) {
        y[i] = 0;
        for (int j = 0; j < n; j++) y[i] += m->dense[i * n + j] * x[j];
    }
}

/* With x = (1 + U)^-1 v: K v is what becomes of the right hand side A x. Without fill K is 1, else v is near K v. */
static void test_split(void **state)
{
    (void)state;
    static matrix m;
    static double v[MAX_UNKNOWNS], x[MAX_UNKNOWNS], kv[MAX_UNKNOWNS], y[MAX_UNKNOWNS], b[MAX_UNKNOWNS];
    pinch_random random;
    pinch_arena arena;
    int incomplete = 0;
    pinch_random_seed(&random, 12);
    pinch_arena_init(&arena);
    for (int round = 0; round < 300; round++) {
        pinch_block_lu lu;
        bool chain = round % 2 == 0;
        pinch_arena_reset(&arena);
        if (chain)
            draw_chain(&m, &random);
        else
            draw_structure(&m, &random);
        assert_true(
            pinch_block_lu_plan(&arena, &(pinch_block_graph){m.count, m.count, m.edges, m.edge}, m.size, 0, NULL, &lu));
        assert_true(lu.incomplete == (m.edges > 0)); /* no neighbours, no products */
        incomplete += lu.incomplete;
        int n = fill_matrix(&m, &random, &lu);
        double *room = PINCH_ARENA_ARRAY(&arena, double, pinch_block_dilu_room(&lu));
        assert_non_null(room);
        for (int i = 0; i < n; i++) {
            x[i] = v[i] = draw_uniform(&random, -1, 1);
            b[i] = 0;
        }
        assert_true(pinch_block_dilu_split(&lu, b, room));
        for (int i = 0; i < n; i++) assert_true(b[i] == 0);
        pinch_block_dilu_times(&lu, v, kv, y);
        pinch_block_dilu_upper(&lu, x);
        dense_times(&m, x, b);
        refill(&m, &lu);
        assert_true(pinch_block_dilu_split(&lu, b, room));
        pinch_block_dilu_lower(&lu, b);
        for (int i = 0; i < n; i++) {
            assert_true(fabs(b[i] - kv[i]) <= 1e-12);
            assert_true(fabs(v[i] - kv[i]) <= (chain ? 1e-12 : 0.3));
        }
    }
    assert_true(incomplete > 200);
    pinch_arena_free(&arena);
}

/* Nothing is left out while the work stays within the limit. */
static void test_the_limit_decides(void **state)
{
    (void)state;
    /* a ring of four: two neighbours, two (one filled in), one and none: 2 * 3 + 2 * 3 + 1 * 2 = 14 products */
    const int size[4] = {6, 6, 6, 6}, edge[8] = {0, 1, 1, 2, 2, 3, 3, 0};
    pinch_arena arena;
    pinch_block_lu lu;
    pinch_arena_init(&arena);
    assert_true(pinch_block_lu_plan(&arena, &(pinch_block_graph){4, 4, 4, edge}, size, 14, NULL, &lu));
    assert_false(lu.incomplete);
    assert_int_equal(lu.later_start[4], 5);
    assert_true(pinch_block_lu_plan(&arena, &(pinch_block_graph){4, 4, 4, edge}, size, 13.5, NULL, &lu));
    assert_true(lu.incomplete);
    assert_int_equal(lu.later_start[4], 4);
    pinch_arena_free(&arena);
}

/* One contact of two bodies, or of a body and what does not move: the same sums in the same order, number by number. */
static void test_a_contact_is_added(void **state)
{
    (void)state;
    enum { ROWS = 3, BODY = 6 };
    pinch_random random;
    pinch_random_seed(&random, 15);
    for (int round = 0; round < 200; round++) {
        double g[2][ROWS * BODY], d[ROWS * ROWS] = {0}, to[2][BODY * BODY], expected[2][BODY * BODY];
        for (int a = 0; a < 2; a++)
            for (int i = 0; i < ROWS * BODY; i++) g[a][i] = draw_uniform(&random, -1, 1);
        for (int i = 0; i < ROWS * ROWS; i++)
            if (i != 1 && i != 2) d[i] = draw_uniform(&random, -1, 1);
        for (int i = 0; i < 2 * BODY * BODY; i++)
            to[i / 36][i % 36] = expected[i / 36][i % 36] = draw_uniform(&random, -1, 1);
        int side = round % 2, missing = round % 3; /* 2: none */
        const double *right = g[side], *const left[2] = {g[0], g[1]};
        double *const blocks[2] = {missing == 0 ? NULL : to[0], missing == 1 ? NULL : to[1]};
        for (int a = 0; a < 2; a++)
            for (int l = 0; l < BODY && a != missing; l++)
                for (int k = 0; k < BODY; k++) {
                    double weighted[ROWS] = {d[0] * right[k]};
                    for (int i = 1; i < ROWS; i++)
                        weighted[i] =
                            d[3 * i] * right[k] + d[3 * i + 1] * right[BODY + k] + d[3 * i + 2] * right[2 * BODY + k];
                    expected[a][BODY * l + k] +=
                        g[a][l] * weighted[0] + g[a][BODY + l] * weighted[1] + g[a][2 * BODY + l] * weighted[2];
                }
        pinch_block_add_contact(left, d, right, blocks);
        assert_memory_equal(to, expected, sizeof to);
    }
}

/* Registers of any width give the same sums, number by number. */
static void test_wide_products_are_the_same(void **state)
{
    (void)state;
    enum { BODY = 6, ALL = BODY * BODY, MOST = 8, WIDTHS = 2 };
    static const pinch_width width[WIDTHS] = {PINCH_FOURS, PINCH_EIGHTS};
    pinch_random random;
    pinch_random_seed(&random, 21);
    for (int round = 0; round < 100; round++) {
        double a[MOST][ALL], b[MOST][ALL], before[ALL], expected[ALL], product[ALL] = {0}, c[ALL];
        const double *left[MOST], *right[MOST];
        int count = 1 + round % MOST;
        for (int p = 0; p < MOST; p++) {
            for (int i = 0; i < ALL; i++) {
                a[p][i] = draw_uniform(&random, -1, 1);
                b[p][i] = draw_uniform(&random, -1, 1);
            }
            left[p] = a[p], right[p] = b[p];
        }
        for (int i = 0; i < ALL; i++) before[i] = expected[i] = draw_uniform(&random, -1, 1);
        for (int i = 0; i < ALL; i++)
            for (int l = 0; l < BODY; l++) product[i] += a[0][i / BODY * BODY + l] * b[0][l * BODY + i % BODY];
        for (int p = 0; p < count; p++)
            for (int i = 0; i < ALL; i++)
                for (int l = 0; l < BODY; l++) expected[i] -= a[p][i / BODY * BODY + l] * b[p][l * BODY + i % BODY];
        memcpy(c, before, sizeof c);
        pinch_block_subtract_products(count, BODY, BODY, BODY, left, right, c);
        assert_memory_equal(c, expected, sizeof c);
        assert_false(pinch_wide_product(PINCH_PAIRS, a[0], b[0], c));
        for (int k = 0; k < WIDTHS && width[k] <= pinch_widest(); k++) {
            memcpy(c, before, sizeof c);
            assert_true(pinch_wide_subtract_products(width[k], count, left, right, c));
            assert_memory_equal(c, expected, sizeof c);
            assert_true(pinch_wide_product(width[k], a[0], b[0], c));
            assert_memory_equal(c, product, sizeof c);
        }
    }
}

enum { GRID = 18, NODES = GRID * GRID, LINKS = 2 * GRID * (GRID - 1), OF_BODY = 6 };

/* A grid of bodies, every `odd`-th of which has but two unknowns. */
typedef struct grid {
    int size[NODES], edge[2 * LINKS], edges;
} grid;

static void draw_grid(grid *g, int odd)
{
    g->edges = 0;
    for (int k = 0; k < NODES; k++) {
        g->size[k] = odd && k % odd == 0 ? 2 : OF_BODY;
        for (int next = 0; next < 2; next++) { /* to the right, and below */
            int other = next ? k + GRID : k + 1;
            if (next ? other >= NODES : other % GRID == 0) continue;
            g->edge[2 * g->edges] = k;
            g->edge[2 * g->edges++ + 1] = other;
        }
    }
}

/* Fills a block with the same numbers whatever the plan, with none where it is not read, and adds its products with
 * x. */
static void fill_of_grid(pinch_block_lu *lu, int row, int column, const double *x, double *product)
{
    double *block = pinch_block_lu_at(lu, row, column);
    int rows = lu->size[row], columns = lu->size[column];
    for (int i = 0; i < rows; i++)
        for (int j = 0; j < columns; j++) {
            double value = sin(row + 2.0 * column + 3 * i + 5 * j);
            if (lu->symmetric) value += sin(column + 2.0 * row + 3 * j + 5 * i);
            if (row == column && i == j) value += 40;
            block[i * columns + j] = pinch_block_lu_reads(lu, row, column) ? value : NAN;
            product[lu->first[row] + i] += value * x[lu->first[column] + j];
        }
}

/* Large graphs are put into the order of their tree, and runs of bodies are eliminated together. */
static void solve_grids(bool symmetric)
{
    static grid g;
    static double wanted[NODES * OF_BODY], x[NODES * OF_BODY], y[NODES * OF_BODY];
    pinch_arena arena;
    pinch_arena_init(&arena);
    for (int odd = 0; odd < 8; odd += 7) {
        int threads = 1, longest = 0;
        pinch_block_lu lu[2];
        draw_grid(&g, odd);
        pinch_arena_reset(&arena);
        for (int copy = 0; copy < 2; copy++) {
            const pinch_block_graph graph = {NODES, NODES, g.edges, g.edge};
            assert_true(pinch_block_lu_plan(&arena, &graph, g.size, INFINITY, NULL, &lu[copy]));
            if (copy == 1) assert_true(pinch_block_lu_share(&arena, &lu[copy]));
            double *b = copy == 0 ? x : y;
            memset(b, 0, sizeof x);
            for (int i = 0; i < lu->first[NODES]; i++) wanted[i] = cos(i);
            lu[copy].symmetric = symmetric;
            for (size_t i = 0; i < lu->value_count; i++) lu[copy].values[i] = NAN;
            pinch_block_lu_clear(&lu[copy]);
            for (int k = 0; k < NODES; k++) fill_of_grid(&lu[copy], k, k, wanted, b);
            for (int k = 0; k < 2 * g.edges; k++)
                fill_of_grid(&lu[copy], g.edge[k], g.edge[k % 2 ? k - 1 : k + 1], wanted, b);
        }
        for (int k = 0; k < NODES; k++) longest = lu->run[k] > longest ? lu->run[k] : longest;
        assert_true(lu->visit && longest > 1);
        assert_true(pinch_block_lu_factor_and_solve(&lu[0], NULL, x));
        for (int i = 0; i < lu->first[NODES]; i++) assert_true(fabs(x[i] - wanted[i]) <= 1e-12);
        assert_true(pinch_block_lu_factor_and_solve(&lu[1], &(pinch_crew){crew_call_all, &threads}, y));
        assert_memory_equal(x, y, sizeof *x * (size_t)lu->first[NODES]);
        assert_memory_equal(lu[0].values, lu[1].values, sizeof(double) * lu->value_count);
    }
    pinch_arena_free(&arena);
}

static void test_large_ones_are_solved_in_runs(void **state)
{
    (void)state;
    solve_grids(false);
}

static void test_half_of_a_symmetric_one_is_read(void **state)
{
    (void)state;
    solve_grids(true);
}

static void assert_same_order(const pinch_block_order *a, const pinch_block_order *b, int count)
{
    size_t bytes = sizeof(int) * (size_t)count;
    assert_int_equal(a->entries, b->entries);
    assert_true(a->without_fill == b->without_fill && !a->visit == !b->visit);
    assert_memory_equal(a->order, b->order, bytes);
    assert_memory_equal(a->place, b->place, bytes);
    assert_memory_equal(a->start, b->start, bytes + sizeof(int));
    assert_memory_equal(a->later, b->later, sizeof(int) * (size_t)a->entries);
    if (a->visit) assert_memory_equal(a->visit, b->visit, bytes);
}

/* A graph that comes again has the order that it would have without memory, whatever the limit and what came between.
 */
static void test_orders_are_remembered(void **state)
{
    (void)state;
    enum { ASKED = 6 };
    static const double MUCH = 1e6, limit[ASKED] = {INFINITY, 1e6, 1e6, 10, 10, 1e6};
    static const bool known[ASKED] = {false, true, false, false, true, false};
    static grid g;
    pinch_block_order_memory memory = {0};
    pinch_arena arena;
    pinch_arena_init(&arena);
    draw_grid(&g, 0);
    for (int k = 0; k < ASKED; k++) {
        const int *room = memory.order.order;
        pinch_block_order with, without;
        if (k == 2) g.edges--; /* another graph */
        const pinch_block_graph graph = {NODES, NODES, g.edges, g.edge};
        pinch_arena_reset(&arena);
        assert_true(pinch_block_order_make(&arena, &graph, limit[k], &memory, &with));
        assert_true(pinch_block_order_make(&arena, &graph, limit[k], NULL, &without));
        assert_same_order(&with, &without, NODES);
        assert_true(with.without_fill == (limit[k] < MUCH));
        assert_true((with.order == room && room != NULL) == known[k]);
    }
    pinch_block_order_forget(&memory);
    assert_null(memory.room);
    pinch_arena_free(&arena);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_contact_is_added),
        cmocka_unit_test(test_wide_products_are_the_same),
        cmocka_unit_test(test_large_ones_are_solved_in_runs),
        cmocka_unit_test(test_half_of_a_symmetric_one_is_read),
        cmocka_unit_test(test_orders_are_remembered),
        cmocka_unit_test(test_agrees_with_the_dense_factorization),
        cmocka_unit_test(test_a_crew_finds_the_same_bits),
        cmocka_unit_test(test_singular_blocks_are_noticed),
        cmocka_unit_test(test_split),
        cmocka_unit_test(test_the_limit_decides),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
