/* Factors in single precision: their products number by number, and whole solves beside those in double precision. */
#include "support/cmocka_all.h"

#include "support/block_lu.h"
#include "support/blocks.h"
#include "support/crew.h"
#include "support/draw.h"

#include <math.h>
#include <string.h>

enum { N = 6, ROW = PINCH_SINGLE_ROW, BLOCK = PINCH_SINGLE_BLOCK, MOST = 8, BLOCKS = 5, ROWS = 3 };

static void draw_block(pinch_random *random, float *block)
{
    for (int i = 0; i < N; i++)
        for (int j = 0; j < ROW; j++) block[ROW * i + j] = j < N ? (float)draw_uniform(random, -1, 1) : 0;
}

static int widths(pinch_width width[2])
{
    width[0] = PINCH_PAIRS;
    width[1] = pinch_widest();
    return width[1] == PINCH_PAIRS ? 1 : 2;
}

/* Five blocks, so that there are two pairs of them and one alone; the sixth may not be touched. */
static void test_products_are_the_same_in_all_widths(void **state)
{
    (void)state;
    pinch_random random;
    pinch_width width[2];
    int kinds = widths(width);
    pinch_random_seed(&random, 31);
    for (int round = 0; round < 64; round++) {
        float a[MOST][BLOCK], b[MOST][BLOCKS * BLOCK], before[BLOCKS + 1][BLOCK], wanted[BLOCKS + 1][BLOCK];
        const float *left[MOST], *right[MOST];
        int count = 1 + round % MOST, blocks = round % (BLOCKS + 1);
        for (int p = 0; p < MOST; p++) {
            draw_block(&random, a[p]);
            for (int k = 0; k < BLOCKS; k++) draw_block(&random, b[p] + BLOCK * k);
            left[p] = a[p], right[p] = b[p];
        }
        for (int k = 0; k <= BLOCKS; k++) draw_block(&random, before[k]);
        memcpy(wanted, before, sizeof wanted);
        for (int k = 0; k < blocks; k++)
            for (int i = 0; i < N; i++)
                for (int j = 0; j < N; j++)
                    for (int p = 0; p < count; p++)
                        for (int l = 0; l < N; l++)
                            wanted[k][ROW * i + j] -= a[p][ROW * l + i] * b[p][BLOCK * k + ROW * l + j];
        for (int w = 0; w < kinds; w++) {
            float c[BLOCKS + 1][BLOCK], *to[BLOCKS];
            memcpy(c, before, sizeof c);
            for (int k = 0; k < BLOCKS; k++) to[k] = c[k];
            pinch_single_subtract_products(width[w], count, left, right, blocks, to);
            assert_memory_equal(c, wanted, sizeof c);
        }
        float product[BLOCK] = {0};
        for (int i = 0; i < N; i++)
            for (int j = 0; j < N; j++) {
                float sum = a[0][ROW * i] * b[0][j];
                for (int l = 1; l < N; l++) sum += a[0][ROW * i + l] * b[0][ROW * l + j];
                product[ROW * i + j] = sum;
            }
        for (int w = 0; w < kinds; w++) {
            float c[BLOCK];
            memcpy(c, b[0], sizeof c);
            pinch_single_multiply(width[w], a[0], c);
            for (int i = 0; i < BLOCK; i++) assert_true(c[i] == product[i]); /* zeros beyond a row may be negative */
        }
    }
}

/* With vectors, too; and both are right. */
static void test_vectors_and_contacts_are_the_same_in_all_widths(void **state)
{
    (void)state;
    pinch_random random;
    pinch_width width[2];
    int kinds = widths(width);
    pinch_random_seed(&random, 32);
    for (int round = 0; round < 64; round++) {
        float a[BLOCKS * BLOCK], block[BLOCK], of_contact[2][BLOCK];
        double y[BLOCKS][N], x[N], by_rows[2][N], by_columns[2][N], g[2][ROWS * N], d[ROWS * ROWS];
        const double *parts[BLOCKS];
        int count = 1 + round % BLOCKS;
        for (int e = 0; e < BLOCKS; e++) {
            draw_block(&random, a + BLOCK * e);
            for (int k = 0; k < N; k++) y[e][k] = draw_uniform(&random, -1, 1);
            parts[e] = y[e];
        }
        draw_block(&random, block);
        for (int k = 0; k < N; k++) x[k] = draw_uniform(&random, -1, 1);
        for (int i = 0; i < 2 * ROWS * N; i++) g[i / (ROWS * N)][i % (ROWS * N)] = draw_uniform(&random, -1, 1);
        for (int i = 0; i < ROWS * ROWS; i++) d[i] = draw_uniform(&random, -1, 1);
        for (int w = 0; w < kinds; w++) {
            memcpy(by_rows[w], x, sizeof x);
            memcpy(by_columns[w], x, sizeof x);
            memcpy(of_contact[w], block, sizeof block);
            pinch_single_subtract_applied(width[w], count, a, parts, by_rows[w]);
            pinch_single_subtract_transposed(width[w], a, y[0], by_columns[w]);
            pinch_single_add_contact(width[w], g[0], d, g[1], of_contact[w]);
        }
        assert_memory_equal(by_rows[0], by_rows[kinds - 1], sizeof x);
        assert_memory_equal(by_columns[0], by_columns[kinds - 1], sizeof x);
        assert_memory_equal(of_contact[0], of_contact[kinds - 1], sizeof block);
        for (int i = 0; i < N; i++) {
            double rows = x[i], columns = x[i];
            for (int e = 0; e < count; e++)
                for (int k = 0; k < N; k++) rows -= a[BLOCK * e + ROW * i + k] * y[e][k];
            for (int l = 0; l < N; l++) columns -= a[ROW * l + i] * y[0][l];
            assert_true(fabs(by_rows[0][i] - rows) <= 1e-14);
            assert_true(fabs(by_columns[0][i] - columns) <= 1e-14);
            for (int j = 0; j < N; j++) {
                double sum = block[ROW * i + j];
                for (int r = 0; r < ROWS; r++)
                    for (int q = 0; q < ROWS; q++) sum += g[0][N * r + i] * d[ROWS * r + q] * g[1][N * q + j];
                assert_true(fabs(of_contact[0][ROW * i + j] - sum) <= 2e-6);
            }
            for (int j = N; j < ROW; j++) assert_true(of_contact[0][ROW * i + j] == 0);
        }
    }
}

enum { GRID = 18, NODES = GRID * GRID, LINKS = 2 * GRID * (GRID - 1), UNKNOWNS = NODES * N };

static int link_grid(int *size, int *edge)
{
    int edges = 0;
    for (int k = 0; k < NODES; k++) {
        size[k] = N;
        for (int next = 0; next < 2; next++) { /* to the right, and below */
            int other = next ? k + GRID : k + 1;
            if (next ? other >= NODES : other % GRID == 0) continue;
            edge[2 * edges] = k;
            edge[2 * edges++ + 1] = other;
        }
    }
    return edges;
}

static double value_at(const pinch_block_lu *lu, int row, int column, int i, int j)
{
    double value = sin(row + 2.0 * column + 3 * i + 5 * j);
    if (lu->symmetric) value += sin(column + 2.0 * row + 3 * j + 5 * i);
    return value + (row == column && i == j ? 40 : 0);
}

/* Fills a block, with no numbers where it is not read, and adds its products with x. */
static void fill(pinch_block_lu *lu, int row, int column, const double *x, double *product)
{
    float *block = lu->singles + pinch_block_lu_offset(lu, row, column);
    bool lower = pinch_block_lu_is_lower(lu, row, column), read = pinch_block_lu_reads(lu, row, column);
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) {
            double value = value_at(lu, row, column, i, j);
            block[lower ? ROW * j + i : ROW * i + j] = read ? (float)value : NAN;
            product[N * row + i] += value * x[N * column + j];
        }
}

static void fill_grid(pinch_block_lu *lu, const int *edge, int edges, const double *x, double *product)
{
    memset(product, 0, sizeof *product * UNKNOWNS);
    for (size_t i = 0; i < lu->value_count; i++) lu->singles[i] = NAN;
    pinch_block_lu_clear(lu);
    for (int k = 0; k < NODES; k++) fill(lu, k, k, x, product);
    for (int e = 0; e < edges; e++) {
        fill(lu, edge[2 * e], edge[2 * e + 1], x, product);
        fill(lu, edge[2 * e + 1], edge[2 * e], x, product);
    }
}

/* A solve leaves some millionths, and with its factors they go away. Two threads find the same bits. */
static void test_solves(void **state)
{
    (void)state;
    static int size[NODES], edge[2 * LINKS];
    static double wanted[UNKNOWNS], b[UNKNOWNS], x[UNKNOWNS], again[UNKNOWNS], left[UNKNOWNS];
    int helpers = 1;
    const pinch_crew crew = {crew_call_all, &helpers};
    pinch_arena arena;
    int edges = link_grid(size, edge);
    const pinch_block_graph graph = {NODES, NODES, edges, edge};
    pinch_arena_init(&arena);
    for (int i = 0; i < UNKNOWNS; i++) wanted[i] = cos(i);
    for (int symmetric = 0; symmetric < 2; symmetric++) {
        pinch_block_lu lu;
        pinch_arena_reset(&arena);
        assert_true(pinch_block_lu_plan_single(&arena, &graph, size, INFINITY, NULL, &lu));
        assert_true(lu.single && !lu.incomplete && pinch_block_lu_share(&arena, &lu));
        lu.symmetric = symmetric;
        fill_grid(&lu, edge, edges, wanted, again);
        assert_true(pinch_block_lu_factor_and_solve(&lu, &crew, again));
        fill_grid(&lu, edge, edges, wanted, b);
        memcpy(x, b, sizeof x);
        assert_true(pinch_block_lu_factor_and_solve(&lu, NULL, x));
        assert_memory_equal(x, again, sizeof x);
        double off = 0, refined = 0;
        memcpy(left, b, sizeof left);
        for (int row = 0; row < NODES; row++)
            for (int i = 0; i < N; i++)
                for (int j = 0; j < N; j++) left[N * row + i] -= value_at(&lu, row, row, i, j) * x[N * row + j];
        for (int e = 0; e < 2 * edges; e++) {
            int row = edge[e], column = edge[e ^ 1];
            for (int i = 0; i < N; i++)
                for (int j = 0; j < N; j++) left[N * row + i] -= value_at(&lu, row, column, i, j) * x[N * column + j];
        }
        memcpy(again, left, sizeof again);
        pinch_block_lu_solve(&lu, &crew, again);
        pinch_block_lu_solve(&lu, NULL, left);
        assert_memory_equal(left, again, sizeof left);
        for (int i = 0; i < UNKNOWNS; i++) {
            off = fmax(off, fabs(x[i] - wanted[i]));
            refined = fmax(refined, fabs(x[i] + left[i] - wanted[i]));
        }
        assert_true(off > 1e-9 && off < 3e-6);
        assert_true(refined < 1e-12);
    }
    pinch_arena_free(&arena);
}

static void test_says_where_it_is_singular(void **state)
{
    (void)state;
    const int size[2] = {N, N}, edge[2] = {0, 1};
    double x[2 * N] = {1};
    pinch_arena arena;
    pinch_block_lu lu;
    pinch_arena_init(&arena);
    assert_true(pinch_block_lu_plan_single(&arena, &(pinch_block_graph){2, 2, 1, edge}, size, INFINITY, NULL, &lu));
    pinch_block_lu_clear(&lu);
    for (int i = 0; i < N; i++) lu.singles[pinch_block_lu_offset(&lu, 0, 0) + (size_t)(ROW * i + i)] = 1;
    assert_false(pinch_block_lu_factor_and_solve(&lu, NULL, x));
    pinch_arena_free(&arena);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_products_are_the_same_in_all_widths),
        cmocka_unit_test(test_vectors_and_contacts_are_the_same_in_all_widths),
        cmocka_unit_test(test_solves),
        cmocka_unit_test(test_says_where_it_is_singular),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
