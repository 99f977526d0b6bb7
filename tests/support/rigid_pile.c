#include "support/rigid_pile.h"

#include "support/draw.h"

#include <math.h>
#include <string.h>

void rigid_pile_draw(pinch_random *random, bool stiff, bool doubled, rigid_pile *p)
{
    memset(p, 0, sizeof *p);
    int bodies = 1 + (int)(pinch_random_uniform(random) * (RIGID_BODIES - 1)), contacts = 0;
    double v[RIGID_BODIES][RIGID_FREEDOMS], root[RIGID_BODIES];
    for (int b = 0; b < bodies; b++) {
        p->freedoms[b] = RIGID_FREEDOMS;
        root[b] = stiff ? pow(10, 3 * pinch_random_uniform(random)) : 1;
        for (int i = 0; i < RIGID_FREEDOMS; i++)
            v[b][i] = (pinch_random_uniform(random) - 0.5) * (i < 3 ? 1 : 0.3) / root[b];
        v[b][0] -= 0.5 / root[b];
    }
    for (int b = 0; b < bodies; b++)
        for (int n = 0; n < 3 && contacts + 2 <= RIGID_CONTACTS; n++) {
            int other = b > 0 && n > 0 ? (int)(pinch_random_uniform(random) * b) : -1;
            pinch_friction_contact *k = &p->contacts[contacts];
            *k = (pinch_friction_contact){
                .body = {b, other}, .friction = pinch_random_uniform(random) < 0.1 ? 0 : pinch_random_uniform(random)};
            for (int s = 0; s < 2; s++) {
                if (k->body[s] < 0) continue;
                double *g = p->g[contacts][s], arm[RIGID_AXES], w = root[k->body[s]] * (s ? -1 : 1);
                for (int i = 0; i < RIGID_AXES; i++) arm[i] = pinch_random_uniform(random) - 0.5;
                for (int i = 0; i < RIGID_AXES; i++) { /* the velocity of a point along axis i */
                    int j = (i + 1) % RIGID_AXES, l = (i + 2) % RIGID_AXES;
                    g[RIGID_FREEDOMS * i + i] = w;
                    g[RIGID_FREEDOMS * i + RIGID_AXES + j] = w * arm[l];
                    g[RIGID_FREEDOMS * i + RIGID_AXES + l] = -w * arm[j];
                }
                k->g[s] = g;
                for (int i = 0; i < RIGID_AXES; i++)
                    for (int j = 0; j < RIGID_FREEDOMS; j++) k->free[i] += g[RIGID_FREEDOMS * i + j] * v[k->body[s]][j];
            }
            contacts++;
            if (doubled) p->contacts[contacts++] = *k;
        }
    p->problem = (pinch_friction_problem){bodies, p->freedoms, contacts, p->contacts};
}
