/* Products of matrices and vectors are those of ODE's header, whose order of additions is that of ODE's steppers. */
#include "bodies/body_motion.h"

#include "bodies/matrix3.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

bool pinch_body_stays_awake(dBodyID body)
{
    return dBodyIsEnabled(body) && !dBodyGetAutoDisableFlag(body);
}

bool pinch_body_moves_alone(dBodyID body, int first_joint)
{
    if (!pinch_body_stays_awake(body)) return false;
    int count = dBodyGetNumJoints(body);
    for (int i = first_joint; i < count; i++)
        if (dJointIsEnabled(dBodyGetJoint(body, i))) return false;
    return true;
}

/* As dBodySetMass, which takes the unit matrix where there is no inverse. */
static const double *inverse_of(const double *inertia, pinch_inverse_inertia *inverse)
{
    if (inverse->known && memcmp(inverse->inertia, inertia, sizeof inverse->inertia) == 0) return inverse->inverse;
    memcpy(inverse->inertia, inertia, sizeof inverse->inertia);
    if (!dInvertPDMatrix(inverse->inertia, inverse->inverse, 3)) dRSetIdentity(inverse->inverse);
    inverse->known = true;
    return inverse->inverse;
}

/*
 * Adds the gyroscopic torque, which is implicit in the angular momentum L = I w (see bodies/step_bodies.c), I in world
 * axes:
 *
 *     tau = (I (I - h [L]x)^-1 - 1) L/h
 *
 * It is added only where that matrix can be inverted.
 */
static void add_gyroscopic_torque(const double *I, const double *w, double h, double *torque)
{
    dMatrix3 matrix, inverse = {0};
    dVector3 L, tau;
    dMultiply0_331(L, I, w);
    memcpy(matrix, I, sizeof matrix);
    matrix[1] += L[2] * h, matrix[2] -= L[1] * h;
    matrix[4] -= L[2] * h, matrix[6] += L[0] * h;
    matrix[8] += L[1] * h, matrix[9] -= L[0] * h;
    dScaleVector3(L, dRecip(h));
    if (dInvertMatrix3(inverse, matrix) == 0) return;
    pinch_matrix3_product(I, inverse, matrix);
    for (int i = 0; i < 3; i++) matrix[5 * i] -= 1;
    dMultiply0_331(tau, matrix, L);
    dAddVectors3(torque, torque, tau);
}

/* The angular velocity is cut where it is larger than the body may have. */
static void cap(dBodyID body, double *w)
{
    double most = dBodyGetMaxAngularSpeed(body), speed2 = dCalcVectorDot3(w, w);
    if (speed2 > most * most) dScaleVector3(w, most / dSqrt(speed2));
}

/* Of a body, in ODE's own memory. */
typedef struct forces_and_velocities {
    double *force, *torque, *v, *w;
} forces_and_velocities;

/* Damping acts on velocities above a threshold, after the body has moved with them. ODE takes roots of its thresholds
 * to show them: they are asked for only where they count. */
static inline void damp(dBodyID body, bool spins, double *v, double *w)
{
    double linear = dBodyGetLinearDamping(body), angular = spins ? dBodyGetAngularDamping(body) : 0;
    if (linear != 0) {
        double threshold = dBodyGetLinearDampingThreshold(body);
        if (dCalcVectorDot3(v, v) > threshold * threshold) dScaleVector3(v, 1 - linear);
    }
    if (angular != 0) {
        double threshold = dBodyGetAngularDampingThreshold(body);
        if (dCalcVectorDot3(w, w) > threshold * threshold) dScaleVector3(w, 1 - angular);
    }
}

static inline bool is_negative_zero(double a)
{
    static const double NEGATIVE_ZERO = -0.0;
    return memcmp(&a, &NEGATIVE_ZERO, sizeof a) == 0;
}

static inline bool has_negative_zero(const double *v)
{
    return is_negative_zero(v[0]) || is_negative_zero(v[1]) || is_negative_zero(v[2]);
}

/* Adds gravity, and makes velocities of the forces. A kinematic body has no inverse mass and inertia. */
static void accelerate(dBodyID body, bool kinematic, const double gravity[3], double h, pinch_inverse_inertia *inverse,
                       const forces_and_velocities *of)
{
    static const dMatrix3 NONE = {0};
    const double *R = dBodyGetRotation(body);
    dMass mass;
    dVector3 force, torque;
    dMatrix3 turned, world;
    dBodyGetMass(body, &mass);
    dCopyVector3(force, of->force);
    dCopyVector3(torque, of->torque);
    bool falls = dBodyGetGravityMode(body);
    for (int i = 0; i < 3; i++)
        if (falls && gravity[i] != 0) force[i] += mass.mass * gravity[i];
    pinch_matrix3_transpose(R, turned);
    if (!kinematic && dBodyGetGyroscopicMode(body)) {
        pinch_matrix3_turn(mass.I, R, turned, world);
        add_gyroscopic_torque(world, of->w, h, torque);
    }
    dAddVectorScaledVector3(of->v, of->v, force, h * (kinematic ? 0 : dRecip(mass.mass)));
    dScaleVector3(torque, h);
    pinch_matrix3_turn(kinematic ? NONE : inverse_of(mass.I, inverse), R, turned, world);
    dMultiplyAdd0_331(of->w, world, torque);
}

/* sin(x)/x */
static double sinc(double x)
{
    return fabs(x) < 1e-4 ? 1 - x * x * 0.166666666666666666667 : sin(x) / x;
}

/* Turns the quaternion by `half` times twice the angular velocity, along an arc. */
static void turn_along_arc(double *quaternion, const double *w, double speed, double half)
{
    double part = sinc(speed * half) * half;
    dQuaternion turn = {cos(speed * half), w[0] * part, w[1] * part, w[2] * part}, turned;
    dQMultiply0(turned, turn, quaternion);
    memcpy(quaternion, turned, sizeof turned);
}

/* As dDQfromW gives the rate. */
static void turn_along_tangent(double *quaternion, const double *w, double h)
{
    const double q[4] = {quaternion[0], quaternion[1], quaternion[2], quaternion[3]};
    quaternion[0] += h * (0.5 * (-w[0] * q[1] - w[1] * q[2] - w[2] * q[3]));
    quaternion[1] += h * (0.5 * (w[0] * q[0] + w[1] * q[3] - w[2] * q[2]));
    quaternion[2] += h * (0.5 * (-w[0] * q[3] + w[1] * q[0] + w[2] * q[1]));
    quaternion[3] += h * (0.5 * (w[0] * q[2] - w[1] * q[1] + w[2] * q[0]));
}

/* As dNormalize4. A length of 1 to the bit, as that of what moves without turning mostly is, takes no root. */
static void normalize(double *q)
{
    double length2 = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if (length2 == 1) return;
    double over = 1 / sqrt(length2);
    for (int i = 0; i < 4; i++) q[i] *= over;
}

/* As dRfromQ. */
static void rotation_of(const double *q, double *R)
{
    double x2 = 2 * q[1] * q[1], y2 = 2 * q[2] * q[2], z2 = 2 * q[3] * q[3];
    R[0] = 1 - y2 - z2;
    R[1] = 2 * (q[1] * q[2] - q[0] * q[3]);
    R[2] = 2 * (q[1] * q[3] + q[0] * q[2]);
    R[4] = 2 * (q[1] * q[2] + q[0] * q[3]);
    R[5] = 1 - x2 - z2;
    R[6] = 2 * (q[2] * q[3] - q[0] * q[1]);
    R[8] = 2 * (q[1] * q[3] - q[0] * q[2]);
    R[9] = 2 * (q[2] * q[3] + q[0] * q[1]);
    R[10] = 1 - x2 - y2;
    R[3] = R[7] = R[11] = 0;
}

/* Where a finite rotation has an axis, ODE turns along an arc about that axis, and along the tangent, by half of what
 * is left of the spin, about the others. */
static void turn(dBodyID body, const double *w, double h, double *quaternion)
{
    dVector3 axis, rest;
    if (!dBodyGetFiniteRotationMode(body)) {
        turn_along_tangent(quaternion, w, h);
        return;
    }
    dBodyGetFiniteRotationAxis(body, axis);
    if (axis[0] == 0 && axis[1] == 0 && axis[2] == 0) {
        turn_along_arc(quaternion, w, dSqrt(dCalcVectorDot3(w, w)), 0.5 * h);
        return;
    }
    double about = dCalcVectorDot3(axis, w);
    dScaleVector3(axis, about);
    dSubtractVectors3(rest, w, axis);
    turn_along_arc(quaternion, axis, about, 0.5 * h);
    turn_along_tangent(quaternion, rest, 0.5 * h);
}

/* Pinch has no need to ask how a body turns that has no spin: what ODE adds to its quaternion then is zero, which
 * changes at most a negative zero. */
static inline bool may_turn(const double *w, const double *q)
{
    return w[0] != 0 || w[1] != 0 || w[2] != 0 || is_negative_zero(q[0]) || has_negative_zero(q + 1);
}

static inline void change_pose(dBodyID body, const double *v, const double *w, double h)
{
    double *position = (double *)dBodyGetPosition(body), *kept = (double *)dBodyGetQuaternion(body), quaternion[4];
    for (int i = 0; i < 3; i++) position[i] += h * v[i];
    memcpy(quaternion, kept, sizeof quaternion);
    if (may_turn(w, quaternion)) turn(body, w, h, quaternion);
    normalize(quaternion);
    memcpy(kept, quaternion, sizeof quaternion);
    rotation_of(quaternion, (double *)dBodyGetRotation(body));
}

/* All is written into ODE's own memory: its setters compute a rotation and a quaternion from each other, which changes
 * last digits, and those of velocities and forces do nothing else. */
void pinch_move_body(dBodyID body, const double gravity[3], double h, pinch_inverse_inertia *inverse)
{
    const forces_and_velocities of = {(double *)dBodyGetForce(body), (double *)dBodyGetTorque(body),
                                      (double *)dBodyGetLinearVel(body), (double *)dBodyGetAngularVel(body)};
    /* what forces add to the velocity of a kinematic body is zero, which changes at most a negative zero */
    bool kinematic = dBodyIsKinematic(body);
    if (!kinematic || has_negative_zero(of.v) || has_negative_zero(of.w))
        accelerate(body, kinematic, gravity, h, inverse, &of);
    bool spins = of.w[0] != 0 || of.w[1] != 0 || of.w[2] != 0;
    if (spins) cap(body, of.w);
    change_pose(body, of.v, of.w, h);
    damp(body, spins, of.v, of.w);
    for (int i = 0; i < 3; i++) of.force[i] = of.torque[i] = 0;
}

void pinch_tell_geoms(dBodyID body)
{
    for (dGeomID geom = dBodyGetFirstGeom(body); geom; geom = dBodyGetNextGeom(geom))
        dGeomSetBody(geom, body); /* its own: ODE takes it for moved, and writes nothing into the body */
}
