/* What libccd says about two cores that overlap: the expanding polytope's nearest face (EPA). It allocates. */
#include "libccd.h"

#include "support/vec3.h"

#include <ccd/ccd.h>
#include <math.h>

static void support_a(const void *object, const ccd_vec3_t *direction, ccd_vec3_t *point)
{
    const pinch_core_pair *pair = object;
    const double d[3] = {-direction->v[0], -direction->v[1], -direction->v[2]};
    double x[3];
    pinch_pair_support_a(pair, d, x);
    ccdVec3Set(point, x[0], x[1], x[2]);
}

static void support_b(const void *object, const ccd_vec3_t *direction, ccd_vec3_t *point)
{
    const pinch_core_pair *pair = object;
    double x[3];
    pinch_pair_support_b(pair, direction->v, x);
    ccdVec3Set(point, x[0], x[1], x[2]);
}

static void first_direction(const void *a, const void *b, ccd_vec3_t *direction)
{
    const pinch_core_pair *pair = a;
    (void)b;
    ccdVec3Set(direction, pair->p[0], pair->p[1], pair->p[2]);
    if (!(ccdVec3Len2(direction) > 0)) ccdVec3Set(direction, 1, 0, 0);
}

bool pinch_ask_libccd(const pinch_core_pair *pair, pinch_tip_stats *stats, double normal[3])
{
    ccd_t ccd;
    ccd_real_t depth = 0;
    ccd_vec3_t direction = {{0, 0, 0}}, position;
    double size = fmin(pair->a->bound, pair->b->bound);
    CCD_INIT(&ccd);
    ccd.support1 = support_a;
    ccd.support2 = support_b;
    ccd.first_dir = first_direction;
    ccd.max_iterations = 60;
    ccd.epa_tolerance = 1e-3 * size * size; /* of squared distances: what follows only needs the right valley */
    stats->libccd_calls++;
    int result = ccdGJKPenetration(pair, pair, &ccd, &depth, &direction, &position);
    for (int i = 0; i < 3; i++) normal[i] = -direction.v[i]; /* it moves B */
    double length = pinch_v3_norm(normal);
    bool fine = result == 0 && isfinite(length) && length > 0.5 && isfinite(depth);
    if (fine) {
        pinch_v3_scale(normal, 1 / length);
        /* an inner polytope's face cannot be farther than the body: its distance is at most the overlap along it */
        fine = depth <= pinch_pair_overlap(pair, normal) + 1e-6 * size;
    }
    stats->libccd_failed += !fine;
    return fine;
}
