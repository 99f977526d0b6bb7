#include "point_query.h"

#include "penetration.h"
#include "statistics.h"
#include "support/vec3.h"

#include <float.h>
#include <string.h>

double pinch_body_distance(const pinch_tip_body *body, int piece, const double point[3], double normal[3])
{
    static const double IDENTITY[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    double least = DBL_MAX;
    for (int k = 0; k < body->core_count; k++) {
        if (piece >= 0 && k != piece) continue;
        const pinch_core *core = &body->cores[k];
        pinch_tip_body at;
        double from[3];
        memcpy(at.R, IDENTITY, sizeof at.R);
        pinch_v3_copy(at.position, point);
        pinch_v3_sub(point, body->position, from);
        memset(&at.own, 0, sizeof at.own);
        at.own.skin = at.own.bound = 2 * (pinch_v3_norm(from) + core->bound); /* no cutoff */
        pinch_core_pair pair;
        pinch_contact_normal found;
        pinch_least_face faces[2];
        pinch_pair_of(body, core, &at, &at.own, &pair); /* in the body's axes; the normal points into the body */
        pair.b = &at.own;
        if (!pinch_find_normal(&pair, pinch_tip_counters(), &found, faces)) continue;
        double distance = -found.overlap - core->skin;
        if (distance >= least) continue;
        least = distance;
        for (int i = 0; i < 3; i++) normal[i] = -pinch_v3_dot(body->R + 3 * i, found.normal);
    }
    return least;
}
