/*
 * Two things are asked about a point that is to be kept.
 *
 * Is it there? The surface of either geom has to be where it touched, but for as much as the other points are pressed
 * in. Distances of a point are known for all shapes but meshes and height fields; there a small ball is laid onto the
 * surface.
 *
 * Does the program want it? The collider is asked for the pair's contacts once more. It answers as it did: what it left
 * out, it leaves out again. What it does return now the program has had, too, and has not handed over.
 *
 * Neither means anything where a program makes its contacts by itself, or gives them names of geoms that others touch.
 * Then the collider does not return what the program has handed over, and the point stays.
 */
#include "contacts/kept_points.h"

#include "support/extremes.h"
#include "support/vec3.h"

#include <pinch/fingertip.h>

#include <math.h>
#include <string.h>

/* Height fields and meshes write to themselves while they collide, and there is one ball for all worlds. Where neither
 * geom is one, nothing is written, and no thread waits for another. (Height fields also move what they meet: their
 * pairs wait until the threads are through, see pairs.c.) */
static mtx_t asking;
static dGeomID ball;

static void begin(void)
{
    (void)mtx_init(&asking, mtx_plain);
}

static bool is_surface(int class)
{
    return class == dTriMeshClass || class == dHeightfieldClass;
}

/* Classes of a program's own and meshes that call a program are not asked: what these calls do besides is not known. */
static bool may_be_asked(dGeomID geom)
{
    if (!geom) return false;
    int class = dGeomGetClass(geom);
    if (class == dTriMeshClass && (dGeomTriMeshGetCallback(geom) || dGeomTriMeshGetArrayCallback(geom))) return false;
    return class == pinch_tip_class() ||
           (class < dFirstSpaceClass && class != dRayClass && class != dGeomTransformClass);
}

/* Finds how far (m) a mesh or height field lies below a point, seen along `out`. Returns false where there is nothing
 * within `reach`. */
static bool surface_below(dGeomID surface, const double *point, const double *out, double reach, double *distance)
{
    enum { FEW = 16 };
    dContactGeom touched[FEW];
    double centre[3], box[6], radius = 2 * reach, nearest = INFINITY;
    if (!ball) ball = dCreateSphere(NULL, radius);
    pinch_v3_copy(centre, point);
    pinch_v3_add_scaled(centre, reach, out);
    dGeomSphereSetRadius(ball, radius);
    dGeomSetPosition(ball, centre[0], centre[1], centre[2]);
    dGeomGetAABB(ball, box); /* height fields read it without asking for it */
    int count = dCollide(ball, surface, FEW, touched, sizeof *touched);
    for (int k = 0; k < count; k++) nearest = fmin(nearest, radius - touched[k].depth);
    *distance = nearest - reach;
    return *distance < reach;
}

/* Finds how far (m) the surface of a geom lies below the point where it touched. Returns false where it is gone. A
 * shape that is not known is taken to be where it was. */
static bool distance_below(dGeomID geom, const double *point, const double *out, double reach, double *distance)
{
    double nearest[3], normal[3];
    if (is_surface(dGeomGetClass(geom))) return surface_below(geom, point, out, reach, distance);
    if (pinch_tip_closest_point(geom, point, distance, nearest, normal) != PINCH_OK) *distance = 0;
    return true;
}

static double largest_coordinate(const double *x)
{
    return pinch_larger(fabs(x[0]), pinch_larger(fabs(x[1]), fabs(x[2])));
}

/* Tells whether the geoms touch where the point has them touch. */
static bool is_there(const pinch_kept_points *kept, const pinch_manifold_point *p, double slack)
{
    static const double REACH = 0.25;                   /* of the merge distance */
    static const double UNEVEN = 1e-3, ROUNDING = 1e-6; /* of the reach; of coordinates, which meshes have as floats */
    /* colliders put contacts on either surface or between: the anchors are up to half the depth beside them */
    double near = REACH * kept->merge_distance, reach = near + pinch_larger(p->depth, 0), depth = p->depth, far = 0;
    for (int side = 0; side < 2; side++) {
        const pinch_pose *pose = &kept->pose[side];
        double touching[3], out[3], distance;
        pinch_v3_copy(touching, pose->position);
        for (int i = 0; i < 3; i++) touching[i] += pinch_v3_dot(pose->rotation + 4 * i, p->anchor[side]);
        for (int i = 0; i < 3; i++) out[i] = side ? p->normal[i] : -p->normal[i];
        if (!distance_below(kept->pair->id[side], touching, out, reach, &distance)) return false;
        depth -= distance;
        far = pinch_larger(far, largest_coordinate(touching));
    }
    return depth > -(slack + UNEVEN * near + ROUNDING * far);
}

static double distance2(const double *a, const double *b)
{
    double apart[3];
    pinch_v3_sub(a, b, apart);
    return pinch_v3_dot(apart, apart);
}

/* Asks the collider for up to `most` contacts, with the geoms in the program's order. Returns whether what the program
 * has handed over is among them. */
static bool find_again(pinch_kept_points *kept, int most)
{
    const pinch_pair *pair = kept->pair;
    const pinch_buffered_contact *handed = kept->store->buffer.items;
    double merge2 = kept->merge_distance * kept->merge_distance;
    bool swapped = handed[pair->first_buffered].swapped;
    kept->found_count = dCollide(pair->id[swapped], pair->id[!swapped], most, kept->found, sizeof *kept->found);
    for (int b = pair->first_buffered; b >= 0; b = handed[b].next) {
        bool among = false;
        for (int k = 0; k < kept->found_count && !among; k++)
            among = distance2(kept->found[k].pos, handed[b].found) < merge2;
        if (!among) return false;
    }
    return true;
}

/* Returns how many contacts the pair has had. After a snapshot, its points tell. */
static int count_before(const pinch_pair *pair)
{
    int before = pair->buffered_before > 0 ? pair->buffered_before : pair->manifold.count;
    return pair->buffered_count > before ? pair->buffered_count : before;
}

/*
 * Tells whether the collider returns what the program has handed over. It is asked for as many contacts as the pair has
 * had, because one that has room for few leaves others out. A program that has filtered them for long has asked for
 * more.
 */
static bool is_found_again(pinch_kept_points *kept)
{
    int most = count_before(kept->pair);
    if (kept->again == PINCH_NOT_ASKED_AGAIN)
        kept->again = most <= PINCH_MOST_FOUND && (find_again(kept, most) || find_again(kept, PINCH_MOST_FOUND))
                          ? PINCH_FOUND_AGAIN
                          : PINCH_FOUND_BY_PROGRAM;
    return kept->again == PINCH_FOUND_AGAIN;
}

static bool has_bodies_of(const pinch_pair *pair, const pinch_pair *other)
{
    bool same = other->body[0] == pair->body[0] && other->body[1] == pair->body[1];
    return same || (other->body[0] == pair->body[1] && other->body[1] == pair->body[0]);
}

/* Tells whether the program has handed over, between the pair's bodies, a contact that is nearer to the place than
 * the square root of this. It may name other geoms in it. */
static bool is_handed_over(const pinch_kept_points *kept, const double *place, double nearer2)
{
    const pinch_contact_store *store = kept->store;
    for (int b = kept->pair->first_buffered; b >= 0; b = store->buffer.items[b].next)
        if (distance2(place, store->buffer.items[b].found) <= nearer2) return true;
    for (int b = 0; b < store->buffer.count; b++) {
        const pinch_buffered_contact *contact = &store->buffer.items[b];
        if (contact->pair >= 0 && distance2(place, contact->found) <= nearer2 &&
            has_bodies_of(kept->pair, &store->pairs.items[contact->pair]))
            return true;
    }
    return false;
}

/* Tells whether the collider has returned the point, and the program has not handed it over. */
static bool is_taken_away(const pinch_kept_points *kept, const pinch_manifold_point *p)
{
    double merge2 = kept->merge_distance * kept->merge_distance;
    for (int k = 0; k < kept->found_count; k++) {
        double away[3];
        const double *place = kept->found[k].pos;
        pinch_v3_sub(place, p->position, away);
        if (pinch_across2(away, p->normal, p->depth) < merge2 &&
            !is_handed_over(kept, place, pinch_smaller(pinch_v3_dot(away, away), merge2)))
            return true;
    }
    return false;
}

void pinch_kept_points_init(pinch_kept_points *kept, const pinch_contact_store *store, const pinch_pair *pair,
                            const pinch_pose pose[2], double merge_distance)
{
    kept->store = store; /* the room for contacts stays as it is: it is large */
    kept->pair = pair;
    kept->pose = pose;
    kept->merge_distance = merge_distance;
    kept->again = PINCH_NOT_ASKED_AGAIN;
}

static bool has_surface(const pinch_pair *pair)
{
    return is_surface(dGeomGetClass(pair->id[0])) || is_surface(dGeomGetClass(pair->id[1]));
}

/* Returns false where the calling thread cannot ask ODE. */
static bool begin_asking(const pinch_pair *pair)
{
    static once_flag once = ONCE_FLAG_INIT;
    if (!has_surface(pair)) return true;
    call_once(&once, begin);
    if (!dAllocateODEDataForThread(dAllocateMaskAll)) return false; /* what meshes need */
    mtx_lock(&asking);
    return true;
}

static void end_asking(const pinch_pair *pair)
{
    if (has_surface(pair)) mtx_unlock(&asking);
}

/* Tells whether each of a pair's contacts counts by itself, as there are more than the corners of a face. Where a
 * program makes so many, those that it leaves out are gone. */
static bool counts_alone(const pinch_pair *pair)
{
    return !pair->has_material && pair->manifold.count > PINCH_SHARED_POINTS;
}

bool pinch_geoms_bear(void *context, const pinch_manifold_point *point, double slack)
{
    pinch_kept_points *kept = context;
    bool counts = counts_alone(kept->pair);
    if (!may_be_asked(kept->pair->id[0]) || !may_be_asked(kept->pair->id[1])) return !counts;
    if (!begin_asking(kept->pair)) return true;
    bool bear = is_found_again(kept) ? !is_taken_away(kept, point) && is_there(kept, point, slack) : !counts;
    end_asking(kept->pair);
    return bear;
}

uint64_t pinch_points_to_watch(const pinch_kept_points *kept, const pinch_manifold *points,
                               const pinch_detected_point *detected, int count)
{
    _Static_assert(PINCH_MANIFOLD_POINTS <= 64, "the result has a bit for each point");
    if (kept->again != PINCH_FOUND_AGAIN || !has_surface(kept->pair)) return 0;
    uint64_t watched = 0;
    for (int k = 0; k < points->count; k++) watched |= (uint64_t)1 << k;
    for (int i = 0; i < count; i++)
        if (detected[i].point >= 0) watched &= ~((uint64_t)1 << detected[i].point);
    return watched;
}

bool pinch_watched_points_stay(const pinch_kept_points *kept)
{
    const pinch_manifold *points = &kept->pair->manifold;
    uint64_t watched = kept->pair->watched;
    double slack = 0;
    for (int k = 0; k < points->count; k++)
        if (!(watched >> k & 1) && points->point[k].depth > slack) slack = points->point[k].depth;
    if (!begin_asking(kept->pair)) return true;
    bool stay = true;
    for (int k = 0; k < points->count && stay; k++)
        stay = !(watched >> k & 1) || is_there(kept, &points->point[k], slack);
    end_asking(kept->pair);
    return stay;
}
