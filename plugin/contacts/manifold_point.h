/* One point of a contact manifold: where it touches, as the two bodies carry it along and as colliders detect it. */
#ifndef PINCH_CONTACTS_MANIFOLD_POINT_H
#define PINCH_CONTACTS_MANIFOLD_POINT_H

#include <stdbool.h>
#include <stddef.h>

/* Position and rotation (ODE's 3 x 4 rows) of a geom. */
typedef struct pinch_pose {
    const double *position, *rotation;
} pinch_pose;

/* A contact point as a collider detected it in this step, in the order of its pair's geoms. */
typedef struct pinch_detected_point {
    double position[3], normal[3]; /* m; unit, into geom 0 */
    double depth;                  /* m */
    double anchor[2][3];           /* the touching points in the geoms' frames, see pinch_point_anchor */
    bool on_ball;                  /* its place is a ball's, whatever the collider says */
    int buffered;                  /* index of the buffered contact it comes from */
    int surface;                   /* and of its surface parameters, -1: the pair has a material */
    const double *tangent1;        /* the first friction direction that the program gave, NULL for none */
    int point;                     /* out: its place in the manifold, -1 for none */
    bool redundant;                /* out: another one is in its place, or it bears nothing beside deeper ones */
    bool bears;                    /* it is not left out: points that stay stand for it, too */
    double share, part;            /* out, where it stays: see pinch_own_law */
    double u[2], ahead, aside;     /* from here on scratch of reduction.c and shares.c */
    int group, edge;
    int kind; /* of its face, surface parameters and first friction direction; -1: it is not sorted */
    bool kept;
} pinch_detected_point;

/* What a point has besides where its pair has no material: a contact law of its own. */
typedef struct pinch_own_law {
    double tangent1[3];   /* the first friction direction when it was last detected, world */
    double compliance[3]; /* see pinch_contact */
    double step;          /* s, the length of the step that left it; 0: none has */
    double floor;
    double stands_for; /* how many contacts it stands for where a pair has more than its manifold holds; otherwise 1 */
    double part;       /* this over the largest of its pair, in (0, 1], where many contacts share a load; otherwise 0 */
    double rebound;    /* m/s, of this step: what a bounce asks for beyond what overlap and motion do; 0 without one */
    double impact;     /* N, of this step: the normal force by which it bounced; 0 without a bounce */
    double gave_way;   /* m/s, of this step: by how much it gave way to that */
    double pose_speed; /* m/s, of this step: see pinch_surface_conditions */
    double paced_step; /* s, of this step: the same */
    double eased;      /* m/s, of this step: the same, where a body that its owner moves comes in; otherwise 0 */
    double carries_at; /* m/s, >= 0, of this step: how fast a body that its owner moves goes along the contact */
    double carried_at; /* the same of the last step that was solved */
    double closes_at;  /* 1/s, of this step: k / (h k + c), at which its spring comes back without a load */
    double closed_at;  /* the same of the last step that was solved; 0: none was */
    double yields;     /* m/N, of this step: the inverse of the stiffness that its surface parameters prescribe */
    double yielded;    /* the same of the last step that was solved; 0: none was */
    double stiffens_from; /* (m/s)/N, of this step: the compliance along the tangents from which its shear goes on */
    int hold, hold_span;
    int surface; /* index of its surface parameters */
    /* where the point locks; otherwise 0 */
    double locked[3];   /* m, world: the shear that has locked as it became stiffer: see island_contacts.c */
    double locked_from; /* m/N, > 0: the softest it was before */
    double unlocks;     /* of this step: the part of that which comes loose, in [0, 1] */
} pinch_own_law;

/* What follows the own law in memory where the surface has rolling friction. */
typedef struct pinch_rolling {
    double rolled[3], moment[3]; /* elastic rotation and last moment about the tangents, world, rad, N m */
} pinch_rolling;

typedef struct pinch_manifold_point {
    double anchor[2][3];      /* the touching points in the two geoms' frames */
    double seen_normal[2][3]; /* the normal in the two geoms' frames when the collider last detected the point */
    double position[3], normal[3], depth;
    double elastic[3];  /* elastic tangential displacement, world, m */
    double twist;       /* elastic rotation about the normal, rad */
    double friction[3]; /* last friction force on body 1, world, N: the warm start */
    double normal_force, torsion;
    double weight;      /* in (0, 1]: how much it counts among points that share one stiffness, see manifold.c */
    double grown;       /* in [0, 1]: how much it has counted at most */
    bool slipping;      /* it slipped in the last step: kinetic friction counts */
    bool rolls;         /* a pinch_rolling follows `own` in memory */
    bool locks;         /* some of its shear has locked: see pinch_own_law */
    pinch_own_law *own; /* NULL: the pair has a material, or the point is new */
} pinch_manifold_point;

/* How the points of a manifold live on from step to step. Distances are in m. */
typedef struct pinch_manifold_rules {
    double merge_distance;  /* a detected point nearer than this to a known one continues it */
    double steady_distance; /* where bodies have moved less than this against each other since the last step, their
                             * points keep their places; 0: each point goes where the collider detects it */
    double quiet_distance;  /* where they have moved less than this, the collider's new points among the known ones do
                             * not count; 0: each counts */
    double turned[3];       /* rad, world: how far body 1 turned against body 2 in the last step */
    double stale_tilt;      /* rad: a point that was not detected goes when the bodies have tilted by more */
    bool rims_bear_nothing; /* points where surfaces only cross are left out beside deep ones, however few there are */
    bool shared;            /* the points share one stiffness, and their resultant shear outlives them; otherwise new
                             * points start without any shear */
    int most_points;        /* 1 to PINCH_MANIFOLD_POINTS; of shared ones, to PINCH_SHARED_POINTS */
    /* Tells whether the geoms bear a point that was not detected, at a slack as in pinch_point_refresh; NULL: they do.
     * It is asked for points only that would stay otherwise. */
    bool (*bears)(void *geoms, const pinch_manifold_point *point, double slack);
    void *geoms;
} pinch_manifold_rules;

/* Returns NULL for a point without rolling friction. */
static inline pinch_rolling *pinch_rolling_of(const pinch_manifold_point *point)
{
    return point->rolls ? (pinch_rolling *)(point->own + 1) : NULL;
}

/* Finds the anchors of a detected point, which are to be known wherever it is compared with points of the manifold or
 * becomes one. The touching points lie half the depth to either side of the contact position: body 1's deepest point is
 * inside body 2, and moving body 1 by the depth along the normal brings the two together. */
void pinch_point_anchor(const pinch_pose pose[2], pinch_detected_point *detected);

/* Puts the point where the collider detected it. */
void pinch_point_set_geometry(pinch_manifold_point *p, const pinch_pose pose[2], const pinch_detected_point *detected);

/* Continues a known point with a detected one. */
void pinch_point_continue(pinch_manifold_point *p, const pinch_pose pose[2], const pinch_manifold_rules *rules,
                          const pinch_detected_point *detected);

/*
 * Recomputes a point that was not detected from its anchors. Returns false when it is no contact any more. A corner
 * that has lifted by less than the others are pressed in (`slack`, m) still belongs to the patch: its share of the
 * fingertip's stiffness must not go to the others each time it loses touch.
 */
bool pinch_point_refresh(pinch_manifold_point *p, const pinch_pose pose[2], const pinch_manifold_rules *rules,
                         double slack);

/* Tells whether two normals differ by more than 60 degrees. In the corner of a room the floor's point and the wall's
 * may be in one place, and are two points. */
static inline bool pinch_on_other_face(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] < 0.5;
}

/* Returns how far (m) two detected points are apart. Of one place, colliders may return a point on either surface:
 * across the normal these do not lie apart, but along it by the depth. DBL_MAX: they are on different faces. */
double pinch_detected_apart(const pinch_detected_point *a, const pinch_detected_point *b);

/* Tells whether the bodies have moved less than a distance (m) against each other at the point since the last step. */
bool pinch_point_lies_still(const pinch_manifold_point *p, const pinch_pose pose[2], double distance);

/* Returns the squared distance (m^2) from a detected point to a known one: the smaller of the two anchors' motions, as
 * a point may be fixed on either body and slide over the other. It is DBL_MAX where they are on different faces. */
double pinch_point_distance2(const pinch_manifold_point *p, const pinch_detected_point *detected);

/* Returns the squared length of a way (m^2) between two places of a contact. Colliders put points on either surface or
 * half way between them, and may change their minds from step to step: half and all of the overlap (m) do not count
 * where the way goes by them along the unit normal. */
double pinch_across2(const double *way, const double *normal, double overlap);

/* Returns what pinch_point_distance2 does, but measures the anchors' motions so. It is never more. */
double pinch_point_distance2_across(const pinch_manifold_point *p, const pinch_detected_point *detected);

#endif
