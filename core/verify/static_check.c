/*
 * Checks a static grasp from the grasp's own data, in newtons and metres. Nothing here is shared with the model or the
 * solvers, not even the geometry: displacements of contact points are computed as translation + rotation x point.
 */
#include <pinch/statics.h>

#include <float.h>
#include <math.h>

typedef struct vec3 {
    double x, y, z;
} vec3;

static vec3 vec(const double a[3])
{
    return (vec3){a[0], a[1], a[2]};
}

static vec3 add_scaled(vec3 a, double s, vec3 b)
{
    return (vec3){a.x + s * b.x, a.y + s * b.y, a.z + s * b.z};
}

static double inner(vec3 a, vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static double length(vec3 a)
{
    return sqrt(inner(a, a));
}

static vec3 outer(vec3 a, vec3 b)
{
    return (vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* The larger one; NaN where one of them is, which fmax passes over. */
static double worst(double a, double b)
{
    return isnan(a) || a >= b ? a : b;
}

/* The friction limit, as the grasp asks for it: a disc or ellipsoid, or a polygon of this many facets. */
typedef struct friction_limit {
    int faces;     /* 0: disc and ellipsoid */
    double radius; /* m/m and m: tangential and torsional limit per newton of normal force */
    double torsion;
} friction_limit;

static friction_limit limit_of(const pinch_grasp *grasp, const pinch_statics_settings *settings,
                               const pinch_finger *finger)
{
    bool soft = finger->model == PINCH_CONTACT_SOFT && !grasp->planar;
    friction_limit limit = {.radius = finger->model == PINCH_CONTACT_FRICTIONLESS ? 0.0 : finger->friction,
                            .torsion = soft ? finger->torsional_friction : 0.0};
    if (settings->formulation == PINCH_FORMULATION_COULOMB) return limit;
    limit.faces = grasp->planar ? 2 : settings->faces;
    if (settings->inscribed) {
        if (!grasp->planar) limit.radius *= cos(acos(-1.0) / limit.faces);
        if (soft) limit.radius /= sqrt(2.0);
        limit.torsion /= sqrt(2.0);
    }
    return limit;
}

/* Returns by how many newtons the friction f = (t1, t2, tau) exceeds what the normal force rn allows. */
static double cone_excess(const friction_limit *limit, double rn, const double f[3])
{
    double tangential = hypot(f[0], f[1]);
    if (limit->faces > 0) {
        double excess = 0.0;
        /* within the inscribed circle no facet is reached */
        for (int k = 0; tangential > limit->radius * rn && k < limit->faces; k++) {
            double angle = 2.0 * acos(-1.0) * k / limit->faces;
            excess = fmax(excess, cos(angle) * f[0] + sin(angle) * f[1] - limit->radius * rn);
        }
        if (limit->torsion > 0.0) excess = fmax(excess, fabs(f[2]) / limit->torsion - rn);
        return fmax(excess, 0.0);
    }
    if (limit->torsion == 0.0) return fmax(tangential - limit->radius * rn, 0.0);
    double level = hypot(limit->radius > 0.0 ? tangential / limit->radius : 0.0, f[2] / limit->torsion);
    return fmax(level - rn, 0.0);
}

/* Returns the most work that friction could do along y = (m, m, rad) at the normal force rn: the support function of
 * the limit. */
static double most_work(const friction_limit *limit, double rn, const double y[3])
{
    if (limit->faces == 0) return rn * hypot(limit->radius * hypot(y[0], y[1]), limit->torsion * y[2]);
    if (limit->faces == 2) return rn * limit->radius * fabs(y[0]);
    double best = -INFINITY, pi = acos(-1.0), corner = limit->radius * rn / cos(pi / limit->faces);
    for (int k = 0; k < limit->faces; k++) {
        double angle = pi * (2 * k + 1) / limit->faces;
        best = fmax(best, corner * (cos(angle) * y[0] + sin(angle) * y[1]));
    }
    return best + limit->torsion * rn * fabs(y[2]);
}

typedef struct contact_check {
    double complementarity, cone, slip, slack;
} contact_check;

/*
 * Checks one finger. slack is what rounding of the displacements costs in newtons: stiffness times a few units in the
 * last place of what is subtracted.
 */
static contact_check check_finger(const pinch_grasp *grasp, const pinch_statics_settings *settings,
                                  const pinch_finger *finger, const pinch_finger_result *f, const double translation[3],
                                  const double rotation[3])
{
    vec3 n = vec(finger->normal), t1 = vec(finger->tangent1), t2 = outer(n, t1);
    vec3 moved = add_scaled(vec(translation), 1.0, outer(vec(rotation), vec(finger->point)));
    double reach = length(vec(translation)) + length(vec(rotation)) * length(vec(finger->point));
    double kn = finger->stiffness[0], kt = finger->stiffness[1], ktau = finger->stiffness[2];
    contact_check check = {.slack = 8.0 * DBL_EPSILON * kn * (reach + fabs(finger->closing))};

    double rn = f->r[0];
    double wanted = finger->force_controlled ? finger->normal_force : kn * (finger->closing - inner(n, moved));
    wanted = fmin(fmax(wanted, 0.0), finger->max_force);
    check.complementarity = fabs(rn - wanted);
    if (finger->model == PINCH_CONTACT_FRICTIONLESS) {
        check.cone = hypot(f->r[3] / grasp->radius, hypot(f->r[1], f->r[2]));
        return check;
    }

    friction_limit limit = limit_of(grasp, settings, finger);
    check.cone = cone_excess(&limit, rn, f->r + 1);
    bool soft = finger->model == PINCH_CONTACT_SOFT && !grasp->planar;
    if (rn > 0.0) {
        vec3 slip = vec(f->slip);
        double e1 = inner(t1, moved) - inner(t1, slip), e2 = inner(t2, moved) - inner(t2, slip);
        double spring = hypot(f->r[1] + kt * e1, f->r[2] + kt * e2);
        check.slack += 8.0 * DBL_EPSILON * kt * (reach + length(slip));
        if (soft) {
            double e3 = inner(n, vec(rotation)) - f->torsional_slip;
            spring = hypot(spring, (f->r[3] + ktau * e3) / grasp->radius);
            check.slack += 8.0 * DBL_EPSILON * ktau * (fabs(f->torsional_slip) + length(vec(rotation))) / grasp->radius;
        }
        check.complementarity = worst(check.complementarity, spring);
    }

    /* friction works against the slip as hard as it can: over the slip in metres that is a force */
    double y[3] = {-f->last_slip[0], -f->last_slip[1], soft ? -f->last_slip[2] : 0.0};
    double way = hypot(hypot(y[0], y[1]), grasp->radius * y[2]);
    double work = y[0] * f->r[1] + y[1] * f->r[2] + y[2] * f->r[3];
    if (way > 0.0) check.slip = fmax((most_work(&limit, rn, y) - work) / way, 0.0);
    /* a slip that the tangential springs' tolerance cannot tell from none proves nothing */
    double doubt = 1e-9 * rn + check.slack;
    if (fmin(kt, soft ? ktau / (grasp->radius * grasp->radius) : kt) * way <= doubt) check.slip = 0.0;
    return check;
}

void pinch_statics_verify(const pinch_grasp *grasp, const pinch_statics_settings *settings,
                          const pinch_finger_result *fingers, const pinch_statics_result *result,
                          pinch_static_verification *verification)
{
    vec3 force = vec(grasp->wrench), torque = vec(grasp->wrench + 3);
    const double load = fmax(length(force), length(torque) / grasp->radius);
    double scale = load, slack = 0.0, stiffest = 0.0;
    *verification = (pinch_static_verification){0};
    bool finite = true;
    for (int i = 0; i < grasp->finger_count; i++) {
        const pinch_finger *finger = &grasp->fingers[i];
        const pinch_finger_result *f = &fingers[i];
        vec3 n = vec(finger->normal), t1 = vec(finger->tangent1), t2 = outer(n, t1);
        vec3 r = add_scaled(add_scaled(add_scaled((vec3){0, 0, 0}, f->r[0], n), f->r[1], t1), f->r[2], t2);
        force = add_scaled(force, 1.0, r);
        torque = add_scaled(add_scaled(torque, 1.0, outer(vec(finger->point), r)), f->r[3], n);
        scale = worst(scale, length(r));
        finite = finite && isfinite(f->r[0] + f->r[1] + f->r[2] + f->r[3]);

        contact_check check = check_finger(grasp, settings, finger, f, result->translation, result->rotation);
        verification->cone = worst(verification->cone, check.cone);
        verification->complementarity = worst(verification->complementarity, check.complementarity);
        verification->slip_direction = worst(verification->slip_direction, check.slip);
        slack = worst(slack, check.slack);
        stiffest = fmax(stiffest, finger->stiffness[0]);
    }
    if (grasp->planar) {
        force.z = 0.0;
        torque.x = torque.y = 0.0;
    }
    verification->force_error = length(force);
    verification->torque_error = length(torque);
    verification->force_scale = scale;
    /* An object that was let out of its fingers is held by forces that are rounding themselves: slack holds for all.
     * Where displacements are so large that it is no small part of the forces, nothing is verified. */
    double limit = 1e-9 * scale + slack;
    bool judged = slack <= 1e-6 * scale + 1e-12 * stiffest * grasp->radius;
    /* A grip that is many times the load must not hide that the load is not carried. A load that is rounding of the
     * grip is none: a component of gravity along a level axis, for example. */
    double unbalanced = worst(length(force), length(torque) / grasp->radius);
    bool carried = load <= 1e-12 * scale || unbalanced <= 1e-3 * load;
    verification->passed = finite && judged && carried && isfinite(limit) && verification->force_error <= limit &&
                           verification->cone <= 1e-9 * scale && verification->torque_error <= limit * grasp->radius &&
                           verification->complementarity <= limit && verification->slip_direction <= limit;
}

/*
 * Along the twist v a contact force r does the work  r_n (w_n + most friction work per newton): if that is never
 * positive and the wrench's own work is negative, nothing balances the wrench. Numbers being rounded, `push` > 0 may
 * remain for some contact; forces that balance must then add up to at least -work/push.
 */
bool pinch_statics_proves_infeasible(const pinch_grasp *grasp, const pinch_statics_settings *settings,
                                     const double twist[6])
{
    vec3 v = vec(twist), omega = vec(twist + 3);
    double work = inner(v, vec(grasp->wrench)) + inner(omega, vec(grasp->wrench + 3)), push = 0.0;
    double scale = fmax(length(vec(grasp->wrench)), length(vec(grasp->wrench + 3)) / grasp->radius);
    for (int i = 0; i < grasp->finger_count; i++) {
        const pinch_finger *finger = &grasp->fingers[i];
        vec3 n = vec(finger->normal), t1 = vec(finger->tangent1), t2 = outer(n, t1);
        vec3 moved = add_scaled(v, 1.0, outer(omega, vec(finger->point)));
        double y[3] = {inner(t1, moved), inner(t2, moved), inner(n, omega)};
        friction_limit limit = limit_of(grasp, settings, finger);
        double per_newton = inner(n, moved) + most_work(&limit, 1.0, y);
        if (finger->force_controlled) {
            double prescribed = fmin(finger->normal_force, finger->max_force);
            work += prescribed * per_newton;
            scale = fmax(scale, prescribed);
        } else if (isfinite(finger->max_force)) {
            work += finger->max_force * fmax(per_newton, 0.0);
        } else {
            push = fmax(push, per_newton);
        }
    }
    return work <= -1e-9 * scale && -work >= 1e6 * push * scale;
}
