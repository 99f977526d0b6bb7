#include "support/blocks.h"

/* Each number of a result is the same sum in the same order in every width of registers, and comes out to the bit. */
enum { N = 6, ROW = PINCH_SINGLE_ROW, BLOCK = PINCH_SINGLE_BLOCK, ROWS = 3 };

#if defined(__x86_64__)

#include <immintrin.h>

#define AVX2        __attribute__((target("avx2")))
#define AVX2_INLINE static inline __attribute__((always_inline, target("avx2")))

AVX2_INLINE __m256 row_at(const float *a, int row)
{
    return _mm256_loadu_ps(a + ROW * row);
}

AVX2_INLINE void put_row(__m256 row, int at, float *a)
{
    _mm256_storeu_ps(a + ROW * at, row);
}

/* Subtracts from the rows of `tiles` blocks what the l-th row of their right factors adds to them; they share the left
 * factor. */
AVX2_INLINE void subtract_row(int tiles, const float *left, const float *right, int l, __m256 row[2][N])
{
    __m256 other[2];
#pragma GCC unroll 2
    for (int t = 0; t < tiles; t++) other[t] = row_at(right + BLOCK * t, l);
#pragma GCC unroll 6
    for (int i = 0; i < N; i++) {
        __m256 f = _mm256_broadcast_ss(left + ROW * l + i);
#pragma GCC unroll 2
        for (int t = 0; t < tiles; t++) row[t][i] = _mm256_sub_ps(row[t][i], _mm256_mul_ps(f, other[t]));
    }
}

AVX2_INLINE void subtract_in_tiles(int tiles, int count, const float *const left[], const float *const right[],
                                   int block, float *const to[2])
{
    __m256 row[2][N];
#pragma GCC unroll 2
    for (int t = 0; t < tiles; t++)
#pragma GCC unroll 6
        for (int i = 0; i < N; i++) row[t][i] = row_at(to[t], i);
    for (int p = 0; p < count; p++)
#pragma GCC unroll 1 /* or sums would leave their registers */
        for (int l = 0; l < N; l++) subtract_row(tiles, left[p], right[p] + BLOCK * block, l, row);
#pragma GCC unroll 2
    for (int t = 0; t < tiles; t++)
#pragma GCC unroll 6
        for (int i = 0; i < N; i++) put_row(row[t][i], i, to[t]);
}

static AVX2 void subtract_in_eights(int count, const float *const left[], const float *const right[], int blocks,
                                    float *const to[])
{
    int b = 0;
    for (; b + 2 <= blocks; b += 2) subtract_in_tiles(2, count, left, right, b, to + b);
    if (b < blocks) subtract_in_tiles(1, count, left, right, b, to + b);
}

static AVX2 void multiply_in_eights(const float *a, float *b)
{
    __m256 row[N], other[N];
#pragma GCC unroll 6
    for (int i = 0; i < N; i++) other[i] = row_at(b, i);
#pragma GCC unroll 6
    for (int i = 0; i < N; i++) {
        row[i] = _mm256_mul_ps(_mm256_broadcast_ss(a + ROW * i), other[0]);
#pragma GCC unroll 5
        for (int l = 1; l < N; l++)
            row[i] = _mm256_add_ps(row[i], _mm256_mul_ps(_mm256_broadcast_ss(a + ROW * i + l), other[l]));
    }
#pragma GCC unroll 6
    for (int i = 0; i < N; i++) put_row(row[i], i, b);
}

/* Sums are in strands of every fourth number, and of every second one of the last two of each row. */
static AVX2 void subtract_applied_in_fours(int count, const float *a, const double *const y[], double *x)
{
    __m256d sum[N];
    __m128d rest[N];
#pragma GCC unroll 6
    for (int i = 0; i < N; i++) {
        sum[i] = _mm256_setzero_pd();
        rest[i] = _mm_setzero_pd();
    }
    for (int e = 0; e < count; e++, a += BLOCK) {
        const __m256d head = _mm256_loadu_pd(y[e]);
        const __m128d tail = _mm_loadu_pd(y[e] + 4);
#pragma GCC unroll 6
        for (int i = 0; i < N; i++) {
            sum[i] = _mm256_add_pd(sum[i], _mm256_mul_pd(_mm256_cvtps_pd(_mm_loadu_ps(a + ROW * i)), head));
            rest[i] = _mm_add_pd(rest[i], _mm_mul_pd(_mm_cvtps_pd(_mm_loadu_ps(a + ROW * i + 4)), tail));
        }
    }
#pragma GCC unroll 6
    for (int i = 0; i < N; i++) {
        __m128d both =
            _mm_add_pd(_mm_add_pd(_mm256_castpd256_pd128(sum[i]), _mm256_extractf128_pd(sum[i], 1)), rest[i]);
        x[i] -= both[0] + both[1];
    }
}

static AVX2 void subtract_transposed_in_fours(const float *a, const double *y, double *x)
{
    __m256d head = _mm256_loadu_pd(x);
    __m128d tail = _mm_loadu_pd(x + 4);
#pragma GCC unroll 6
    for (int l = 0; l < N; l++) {
        const __m256d f = _mm256_broadcast_sd(y + l);
        head = _mm256_sub_pd(head, _mm256_mul_pd(f, _mm256_cvtps_pd(_mm_loadu_ps(a + ROW * l))));
        tail = _mm_sub_pd(tail, _mm_mul_pd(_mm256_castpd256_pd128(f), _mm_cvtps_pd(_mm_loadu_ps(a + ROW * l + 4))));
    }
    _mm256_storeu_pd(x, head);
    _mm_storeu_pd(x + 4, tail);
}

/* A row of six, in single precision. */
AVX2_INLINE __m256 single_row(const double *a)
{
    return _mm256_setr_m128(_mm256_cvtpd_ps(_mm256_loadu_pd(a)), _mm_cvtpd_ps(_mm_loadu_pd(a + 4)));
}

static AVX2 void add_contact_in_eights(const double *left, const double d[9], const double *right, float *to)
{
    __m256 g[ROWS], weighted[ROWS], row[N];
    float copy[ROWS * ROW];
#pragma GCC unroll 3
    for (int i = 0; i < ROWS; i++) {
        g[i] = single_row(right + N * i);
        _mm256_storeu_ps(copy + ROW * i, single_row(left + N * i));
    }
#pragma GCC unroll 3
    for (int i = 0; i < ROWS; i++) {
        __m256 first = _mm256_mul_ps(_mm256_set1_ps((float)d[ROWS * i]), g[0]);
        __m256 second = _mm256_mul_ps(_mm256_set1_ps((float)d[ROWS * i + 1]), g[1]);
        __m256 third = _mm256_mul_ps(_mm256_set1_ps((float)d[ROWS * i + 2]), g[2]);
        weighted[i] = _mm256_add_ps(_mm256_add_ps(first, second), third);
    }
#pragma GCC unroll 6
    for (int k = 0; k < N; k++) {
        __m256 first = _mm256_mul_ps(_mm256_broadcast_ss(copy + k), weighted[0]);
        __m256 second = _mm256_mul_ps(_mm256_broadcast_ss(copy + ROW + k), weighted[1]);
        __m256 third = _mm256_mul_ps(_mm256_broadcast_ss(copy + 2 * ROW + k), weighted[2]);
        row[k] = _mm256_add_ps(row_at(to, k), _mm256_add_ps(_mm256_add_ps(first, second), third));
    }
#pragma GCC unroll 6
    for (int k = 0; k < N; k++) put_row(row[k], k, to);
}

static inline bool in_eights(pinch_width width)
{
    return width >= PINCH_FOURS;
}

#else

static void subtract_in_eights(int count, const float *const left[], const float *const right[], int blocks,
                               float *const to[])
{
    (void)count, (void)left, (void)right, (void)blocks, (void)to;
}

static void multiply_in_eights(const float *a, float *b)
{
    (void)a, (void)b;
}

static void subtract_applied_in_fours(int count, const float *a, const double *const y[], double *x)
{
    (void)count, (void)a, (void)y, (void)x;
}

static void subtract_transposed_in_fours(const float *a, const double *y, double *x)
{
    (void)a, (void)y, (void)x;
}

static void add_contact_in_eights(const double *left, const double d[9], const double *right, float *to)
{
    (void)left, (void)d, (void)right, (void)to;
}

static inline bool in_eights(pinch_width width)
{
    (void)width;
    return false;
}

#endif

/* to -= a^T b */
static void subtract_product(const float *restrict a, const float *restrict b, float *restrict to)
{
    for (int l = 0; l < N; l++)
        for (int i = 0; i < N; i++)
            for (int j = 0; j < N; j++) to[ROW * i + j] -= a[ROW * l + i] * b[ROW * l + j];
}

void pinch_single_subtract_products(pinch_width width, int count, const float *const left[], const float *const right[],
                                    int blocks, float *const to[])
{
    if (in_eights(width)) {
        subtract_in_eights(count, left, right, blocks, to);
        return;
    }
    for (int b = 0; b < blocks; b++)
        for (int p = 0; p < count; p++) subtract_product(left[p], right[p] + BLOCK * b, to[b]);
}

void pinch_single_multiply(pinch_width width, const float *restrict a, float *restrict b)
{
    if (in_eights(width)) {
        multiply_in_eights(a, b);
        return;
    }
    for (int j = 0; j < N; j++) {
        float column[N];
        for (int i = 0; i < N; i++) {
            column[i] = a[ROW * i] * b[j];
            for (int l = 1; l < N; l++) column[i] += a[ROW * i + l] * b[ROW * l + j];
        }
        for (int i = 0; i < N; i++) b[ROW * i + j] = column[i];
    }
}

bool pinch_single_invert(float *a)
{
    double inverse[N * N];
    int pivot[N];
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) inverse[N * i + j] = a[ROW * i + j];
    if (!pinch_block_invert(N, inverse, pivot)) return false;
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++) a[ROW * i + j] = (float)inverse[N * i + j];
    return true;
}

void pinch_single_subtract_applied(pinch_width width, int count, const float *a, const double *const y[], double *x)
{
    if (in_eights(width)) {
        subtract_applied_in_fours(count, a, y, x);
        return;
    }
    double sum[N][N] = {{0}};
    for (int e = 0; e < count; e++, a += BLOCK)
        for (int i = 0; i < N; i++)
            for (int k = 0; k < N; k++) sum[i][k] += a[ROW * i + k] * y[e][k];
    for (int i = 0; i < N; i++) {
        const double *s = sum[i];
        x[i] -= ((s[0] + s[2]) + s[4]) + ((s[1] + s[3]) + s[5]);
    }
}

void pinch_single_subtract_transposed(pinch_width width, const float *a, const double *y, double *x)
{
    if (in_eights(width)) {
        subtract_transposed_in_fours(a, y, x);
        return;
    }
    for (int l = 0; l < N; l++)
        for (int k = 0; k < N; k++) x[k] -= y[l] * a[ROW * l + k];
}

void pinch_single_add_contact(pinch_width width, const double *left, const double d[9], const double *right, float *to)
{
    if (in_eights(width)) {
        add_contact_in_eights(left, d, right, to);
        return;
    }
    float weight[9], g[ROWS * N], weighted[ROWS * N];
    for (int i = 0; i < 9; i++) weight[i] = (float)d[i];
    for (int i = 0; i < ROWS * N; i++) g[i] = (float)right[i];
    for (int i = 0; i < ROWS; i++)
        for (int j = 0; j < N; j++)
            weighted[N * i + j] =
                weight[ROWS * i] * g[j] + weight[ROWS * i + 1] * g[N + j] + weight[ROWS * i + 2] * g[2 * N + j];
    for (int k = 0; k < N; k++) {
        float g0 = (float)left[k], g1 = (float)left[N + k], g2 = (float)left[2 * N + k];
        for (int j = 0; j < N; j++)
            to[ROW * k + j] += g0 * weighted[j] + g1 * weighted[N + j] + g2 * weighted[2 * N + j];
    }
}
