#include "support/blocks.h"

#if defined(__x86_64__)

#include <immintrin.h>

enum { N = 6, SIX = 63 }; /* numbers of a row, and the mask of as many */

/* A row of a block fills six of the eight numbers of a register. */
static inline __attribute__((always_inline, target("avx512f"))) void
products_in_eights(bool subtract, int count, const double *const a[], const double *const b[], double *c)
{
    __m512d row[N];
#pragma GCC unroll 6
    for (int i = 0; i < N; i++) row[i] = subtract ? _mm512_maskz_loadu_pd(SIX, c + N * i) : _mm512_setzero_pd();
    for (int p = 0; p < count; p++)
#pragma GCC unroll 6
        for (int l = 0; l < N; l++) {
            __m512d right = _mm512_maskz_loadu_pd(SIX, b[p] + N * l);
#pragma GCC unroll 6
            for (int i = 0; i < N; i++) {
                __m512d product = _mm512_mul_pd(_mm512_set1_pd(a[p][N * i + l]), right);
                row[i] = subtract ? _mm512_sub_pd(row[i], product) : _mm512_add_pd(row[i], product);
            }
        }
#pragma GCC unroll 6
    for (int i = 0; i < N; i++) { /* what is written under a mask is read late */
        _mm256_storeu_pd(c + N * i, _mm512_castpd512_pd256(row[i]));
        _mm_storeu_pd(c + N * i + 4, _mm256_castpd256_pd128(_mm512_extractf64x4_pd(row[i], 1)));
    }
}

/* A row is a register of four numbers and one of two. */
static inline __attribute__((always_inline, target("avx2"))) void
products_in_fours(bool subtract, int count, const double *const a[], const double *const b[], double *c)
{
    __m256d row[N];
    __m128d rest[N];
#pragma GCC unroll 6
    for (int i = 0; i < N; i++) {
        row[i] = subtract ? _mm256_loadu_pd(c + N * i) : _mm256_setzero_pd();
        rest[i] = subtract ? _mm_loadu_pd(c + N * i + 4) : _mm_setzero_pd();
    }
    for (int p = 0; p < count; p++)
#pragma GCC unroll 1
        for (int l = 0; l < N; l++) {
            __m256d right = _mm256_loadu_pd(b[p] + N * l);
            __m128d last = _mm_loadu_pd(b[p] + N * l + 4);
#pragma GCC unroll 6
            for (int i = 0; i < N; i++) {
                __m256d f = _mm256_broadcast_sd(&a[p][N * i + l]);
                __m256d product = _mm256_mul_pd(f, right);
                __m128d other = _mm_mul_pd(_mm256_castpd256_pd128(f), last);
                row[i] = subtract ? _mm256_sub_pd(row[i], product) : _mm256_add_pd(row[i], product);
                rest[i] = subtract ? _mm_sub_pd(rest[i], other) : _mm_add_pd(rest[i], other);
            }
        }
#pragma GCC unroll 6
    for (int i = 0; i < N; i++) {
        _mm256_storeu_pd(c + N * i, row[i]);
        _mm_storeu_pd(c + N * i + 4, rest[i]);
    }
}

static __attribute__((target("avx512f"))) void subtract_in_eights(int count, const double *const a[],
                                                                  const double *const b[], double *c)
{
    products_in_eights(true, count, a, b, c);
}

static __attribute__((target("avx2"))) void subtract_in_fours(int count, const double *const a[],
                                                              const double *const b[], double *c)
{
    products_in_fours(true, count, a, b, c);
}

static __attribute__((target("avx512f"))) void form_in_eights(const double *a, const double *b, double *c)
{
    products_in_eights(false, 1, &a, &b, c);
}

static __attribute__((target("avx2"))) void form_in_fours(const double *a, const double *b, double *c)
{
    products_in_fours(false, 1, &a, &b, c);
}

bool pinch_wide_subtract_products(pinch_width width, int count, const double *const a[], const double *const b[],
                                  double *c)
{
    if (width == PINCH_EIGHTS)
        subtract_in_eights(count, a, b, c);
    else if (width == PINCH_FOURS)
        subtract_in_fours(count, a, b, c);
    return width != PINCH_PAIRS;
}

bool pinch_wide_product(pinch_width width, const double *a, const double *b, double *c)
{
    if (width == PINCH_EIGHTS)
        form_in_eights(a, b, c);
    else if (width == PINCH_FOURS)
        form_in_fours(a, b, c);
    return width != PINCH_PAIRS;
}

#else

bool pinch_wide_subtract_products(pinch_width width, int count, const double *const a[], const double *const b[],
                                  double *c)
{
    (void)width, (void)count, (void)a, (void)b, (void)c;
    return false;
}

bool pinch_wide_product(pinch_width width, const double *a, const double *b, double *c)
{
    (void)width, (void)a, (void)b, (void)c;
    return false;
}

#endif
