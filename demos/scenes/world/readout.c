/* Reads out what the fingers do at the end of a step. Also the hash of the state. */
#include "world_hand.h"

#include "common/vector.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void start_reading(world *w)
{
    for (int i = 0; i < w->finger_count; i++) {
        world_finger_state *s = &w->fingers[i].state;
        s->points = 0;
        s->normal_force = s->torsional_moment = s->stiffness = 0;
        s->least_margin = NAN;
        memset(s->force, 0, sizeof s->force);
        memset(s->tangential_force, 0, sizeof s->tangential_force);
        memset(s->moment, 0, sizeof s->moment);
        memset(s->elastic, 0, sizeof s->elastic);
    }
    for (int k = 0; k < w->object_count; k++) {
        memset(w->objects[k].force, 0, sizeof w->objects[k].force);
        memset(w->objects[k].moment, 0, sizeof w->objects[k].moment);
    }
}

/* The contribution of one contact point, as forces on the object. */
typedef struct point_reading {
    double position[3], normal_force, force[3], tangential[3], torsion, normal[3];
    double elastic[3], slip[3], slip_twist;
    double stiffness, shear_stiffness;    /* N/m, along the normal and across it; 0: not known */
    double friction_limit, torsion_limit; /* N, N m; 0: not known */
    bool slips, yields;
} point_reading;

/* Sums over a finger's loaded points that are not part of its state. */
struct finger_sums {
    double position[3], slip[3];
    double path; /* of the slips, see path_of */
    int slipping, yielding, all_points;
    double stiffness, weight; /* along the surface: of the first point, N/m; of all points, the first one counting 1 */
};

/* Adds the point's force and its moment about the object's centre of mass. */
static void add_wrench(dBodyID object, const point_reading *p, double *force, double *moment)
{
    const double *centre = dBodyGetPosition(object);
    double arm[3], turning[3];
    for (int i = 0; i < 3; i++) arm[i] = p->position[i] - centre[i];
    dCalcVectorCross3(turning, arm, p->force);
    for (int i = 0; i < 3; i++) {
        force[i] += p->force[i];
        moment[i] += turning[i] + p->torsion * p->normal[i];
    }
}

/*
 * The length of a point's slip, m. Turning about the normal by an angle counts as the angle times the ratio of the
 * limits of moment and force (m): as far as friction loses the same energy. The sum is by Pythagoras, as the limits are
 * an ellipse and the slip is normal to it.
 */
static double path_of(const point_reading *p)
{
    double lever = p->friction_limit > 0 ? p->torsion_limit / p->friction_limit : 0;
    return hypot(scene_norm(p->slip), lever * p->slip_twist);
}

static double margin_of(const point_reading *p)
{
    if (!(p->friction_limit > 0)) return NAN;
    double turning = p->torsion_limit > 0 ? p->torsion / p->torsion_limit : 0;
    return fmax(1 - hypot(scene_norm(p->tangential) / p->friction_limit, turning), 0); /* pyramids reach beyond */
}

static void add_point(dBodyID object, world_finger_state *s, finger_sums *sums, const point_reading *p)
{
    if (sums->all_points++ == 0) sums->stiffness = p->shear_stiffness;
    double weight = sums->stiffness > 0 ? p->shear_stiffness / sums->stiffness : 1;
    sums->weight += weight;
    for (int i = 0; i < 3; i++) s->elastic[i] += weight * p->elastic[i];
    if (!(p->normal_force > 0)) return;
    s->points++;
    sums->slipping += p->slips;
    sums->yielding += p->yields;
    s->normal_force += p->normal_force;
    s->torsional_moment += p->torsion;
    s->stiffness += p->stiffness;
    s->least_margin = fmin(s->least_margin, margin_of(p)); /* fmin takes the number of a number and NaN */
    sums->path += p->normal_force * path_of(p);
    add_wrench(object, p, s->force, s->moment);
    for (int i = 0; i < 3; i++) {
        s->tangential_force[i] += p->tangential[i];
        sums->position[i] += p->normal_force * p->position[i];
        sums->slip[i] += p->normal_force * p->slip[i];
    }
}

static void finish_reading(world_finger_state *s, const finger_sums *sums)
{
    s->state = PINCH_CONTACT_OPEN;
    if (sums->all_points > 0)
        for (int i = 0; i < 3; i++) s->elastic[i] /= sums->weight; /* as the points share one stiffness */
    if (s->points == 0) {
        memset(s->slip, 0, sizeof s->slip); /* slip counts from touch-down */
        return;
    }
    s->state = sums->yielding == s->points   ? PINCH_CONTACT_YIELD
               : sums->slipping == s->points ? PINCH_CONTACT_SLIP
                                             : PINCH_CONTACT_STICK;
    for (int i = 0; i < 3; i++) {
        s->point[i] = sums->position[i] / s->normal_force;
        s->slip[i] += sums->slip[i] / s->normal_force;
    }
    s->slip_total += sums->path / s->normal_force;
    s->peak_normal_force = fmax(s->peak_normal_force, s->normal_force);
}

int world_object_of(const world *w, dGeomID geom)
{
    for (int k = 0; k < w->object_count; k++)
        if (w->objects[k].geom == geom) return k;
    return -1;
}

/* The finger that the geom is against the object; -1: none. */
static int finger_of(const world *w, dGeomID geom, int object)
{
    for (int i = 0; i < w->geom_count; i++) {
        if (w->geoms[i] != geom) continue;
        if (w->hand_geoms[i].hand) return w->categories[i] + object;
        return object == 0 ? w->categories[i] : -1;
    }
    return -1;
}

int world_finger_of_pair(const world *w, dGeomID geom1, dGeomID geom2)
{
    int object = world_object_of(w, geom1);
    if (object >= 0) return finger_of(w, geom2, object);
    object = world_object_of(w, geom2);
    return object >= 0 ? finger_of(w, geom1, object) : -1;
}

/* Gives a point of a pair to the finger in it, or to what else an object touches. `p` is as on the first geom. */
static void add_to_pair(world *w, finger_sums *sums, dGeomID geom1, dGeomID geom2, const point_reading *p)
{
    int owner = world_finger_of_pair(w, geom1, geom2);
    for (int side = 0; side < 2; side++) {
        int object = world_object_of(w, side ? geom2 : geom1);
        if (object < 0) continue;
        world_object *o = &w->objects[object];
        point_reading mine = *p;
        double sign = side ? -1 : 1;
        /* The torsion about the normal is the same on either body, each with the normal into itself. */
        for (int i = 0; i < 3; i++) {
            mine.normal[i] *= sign;
            mine.force[i] *= sign;
            mine.tangential[i] *= sign;
            mine.elastic[i] *= sign;
            mine.slip[i] *= sign;
        }
        if (owner >= 0)
            add_point(o->body, &w->fingers[owner].state, &sums[owner], &mine);
        else
            add_wrench(o->body, &mine, o->force, o->moment);
    }
}

static bool has_object(const world *w, dGeomID geom1, dGeomID geom2)
{
    return world_object_of(w, geom1) >= 0 || world_object_of(w, geom2) >= 0;
}

static void read_pinch(world *w, finger_sums *sums)
{
    const pinch_ode_contact *list;
    int count;
    pinch_ode_contacts(w->plugin, &list, &count);
    for (int k = 0; k < count; k++) {
        const pinch_ode_contact *c = &list[k];
        if (!has_object(w, c->geom1, c->geom2)) continue;
        point_reading p = {.normal_force = c->normal_force, .torsion = c->torsion};
        for (int i = 0; i < 3; i++) {
            p.position[i] = c->position[i];
            p.normal[i] = c->normal[i];
            p.force[i] = c->force[i];
            p.tangential[i] = c->tangential[i];
            p.elastic[i] = c->elastic[i];
            p.slip[i] = c->slip[i];
        }
        p.slip_twist = c->slip_twist;
        p.stiffness = c->stiffness[0];
        p.shear_stiffness = c->stiffness[1];
        p.friction_limit = c->friction_limit;
        p.torsion_limit = c->torsion_limit;
        p.slips = c->state == PINCH_CONTACT_SLIP;
        p.yields = c->state == PINCH_CONTACT_YIELD;
        add_to_pair(w, sums, c->geom1, c->geom2, &p);
    }
}

/* ODE's contacts have no tangential elasticity: all tangential motion at them is slip. */
static void read_ode(world *w, finger_sums *sums)
{
    for (int k = 0; k < w->contact_count; k++) {
        const world_contact *c = &w->contacts[k];
        const dContactGeom *g = &c->contact.geom;
        if (!has_object(w, g->g1, g->g2)) continue;
        point_reading p = {.normal_force = 0};
        dVector3 v[2] = {{0, 0, 0}, {0, 0, 0}};
        for (int side = 0; side < 2; side++)
            if (c->body[side]) dBodyGetPointVel(c->body[side], g->pos[0], g->pos[1], g->pos[2], v[side]);
        double approach = 0;
        for (int i = 0; i < 3; i++) {
            p.position[i] = g->pos[i];
            p.normal[i] = g->normal[i];
            /* Where the contact is attached as (0, body), ODE writes the force on the body into f1. */
            p.force[i] = (c->body[0] ? 1 : -1) * c->feedback.f1[i];
            p.normal_force += p.force[i] * p.normal[i];
            p.slip[i] = (v[0][i] - v[1][i]) * w->scene->step;
            approach += p.slip[i] * p.normal[i];
        }
        for (int i = 0; i < 3; i++) {
            p.tangential[i] = p.force[i] - p.normal_force * p.normal[i];
            p.slip[i] -= approach * p.normal[i];
        }
        p.friction_limit = c->contact.surface.mu * fmax(p.normal_force, 0);
        p.slips = p.slip[0] != 0 || p.slip[1] != 0 || p.slip[2] != 0;
        add_to_pair(w, sums, g->g1, g->g2, &p);
    }
}

world_status world_read_fingers(world *w)
{
    size_t count = (size_t)w->finger_count + 1;
    if (!w->sums) w->sums = calloc(count, sizeof *w->sums);
    if (!w->sums) return WORLD_NO_MEMORY;
    finger_sums *sums = w->sums;
    memset(sums, 0, count * sizeof *sums);
    start_reading(w);
    if (w->settings.contact_solver == WORLD_PINCH)
        read_pinch(w, sums);
    else
        read_ode(w, sums);
    for (int i = 0; i < w->finger_count; i++) {
        world_finger *finger = &w->fingers[i];
        finish_reading(&finger->state, &sums[i]);
        bool limited = finger->finger->has_normal_force && finger->force >= finger->finger->max_force;
        if (limited && finger->state.points > 0) finger->state.state = PINCH_CONTACT_YIELD;
    }
    return WORLD_OK;
}

bool world_finger_is_shown(const world_finger *finger)
{
    return !finger->hand || finger->state.peak_normal_force > 0;
}

void world_contact_wrench(const world *w, int object, double force[3], double moment[3])
{
    memcpy(force, w->objects[object].force, 3 * sizeof *force);
    memcpy(moment, w->objects[object].moment, 3 * sizeof *moment);
    for (int f = 0; f < w->finger_count; f++) {
        if (w->fingers[f].object != object) continue;
        for (int i = 0; i < 3; i++) {
            force[i] += w->fingers[f].state.force[i];
            moment[i] += w->fingers[f].state.moment[i];
        }
    }
}

const pinch_material *world_object_material(const world *w, int object)
{
    return w->scene->objects[object].has_material ? &w->objects[object].material : NULL;
}

/* The smaller of the finger's coefficients of friction and those of its object, if it has any. */
static double friction_of(const world *w, const world_finger *finger)
{
    const pinch_material *object = world_object_material(w, finger->object);
    double own = finger->finger->friction.static_;
    return object ? fmin(own, object->friction) : own;
}

double world_slip_margin(const world *w, const world_finger *finger)
{
    const world_finger_state *s = &finger->state;
    double friction = friction_of(w, finger), torsional = finger->finger->torsional_friction;
    if (!(s->normal_force > 0) || !(friction > 0)) return NAN;
    double reach = scene_norm(s->tangential_force) / friction;
    if (torsional > 0) reach = hypot(reach, s->torsional_moment / torsional);
    return 1 - reach / s->normal_force;
}

double world_least_margin(const world *w, const world_finger *finger)
{
    double least = finger->state.least_margin;
    return isnan(least) ? world_slip_margin(w, finger) : least;
}

double world_normal_displacement(const world *w, const world_finger *finger)
{
    const world_finger_state *s = &finger->state;
    const pinch_material *object = world_object_material(w, finger->object);
    if (!(finger->finger->stiffness.hertz > 0) || !(s->stiffness > 0))
        return s->normal_force / finger->finger->stiffness.normal;
    double both = s->normal_force / s->stiffness; /* in series */
    return object ? both - s->normal_force / object->stiffness[0] : both;
}

double world_us_a_step(const world *w, double seconds)
{
    return w->timed_steps > 0 ? seconds / (double)w->timed_steps * 1e6 : NAN;
}

pinch_solve_status world_solve_status(const world *w)
{
    if (w->diverged) return PINCH_SOLVE_DIVERGED;
    if (!w->plugin) return PINCH_SOLVE_CONVERGED;
    pinch_ode_stats stats = pinch_ode_statistics(w->plugin);
    bool verified = stats.fallback_islands == 0 && stats.too_soft_islands == 0;
    return verified ? PINCH_SOLVE_CONVERGED : PINCH_SOLVE_MAX_ITERATIONS;
}

const char *world_solver_name(world_solver solver)
{
    static const char *const names[] = {"pinch", "quickstep", "worldstep"};
    return names[solver];
}

static void hash_doubles(uint64_t *hash, const double *values, int count)
{
    const unsigned char *bytes = (const unsigned char *)values;
    for (size_t i = 0; i < (size_t)count * sizeof *values; i++) *hash = (*hash ^ bytes[i]) * 1099511628211u;
}

static void hash_body(uint64_t *hash, dBodyID body)
{
    hash_doubles(hash, dBodyGetPosition(body), 3);
    hash_doubles(hash, dBodyGetQuaternion(body), 4);
}

uint64_t world_hash(const world *w)
{
    uint64_t hash = 14695981039346656037u;
    for (int k = 0; k < w->object_count; k++) {
        hash_body(&hash, w->objects[k].body);
        hash_doubles(&hash, dBodyGetLinearVel(w->objects[k].body), 3);
        hash_doubles(&hash, dBodyGetAngularVel(w->objects[k].body), 3);
    }
    for (int i = 0; i < w->finger_count; i++) {
        hash_body(&hash, w->fingers[i].body);
        hash_doubles(&hash, w->fingers[i].state.force, 3);
        hash_doubles(&hash, w->fingers[i].state.slip, 3);
    }
    for (int k = 0; k < w->hand_count; k++) {
        for (int i = 0; i < w->hands[k].joint_count; i++) {
            const world_joint *j = &w->hands[k].joints[i];
            hash_body(&hash, j->body);
            hash_doubles(&hash, &j->position, 1);
            hash_doubles(&hash, &j->torque, 1);
        }
    }
    return hash;
}
