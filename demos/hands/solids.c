/* Volumes, surfaces and moments of inertia of the shapes that a hand is made of. */

#include "inertia.h"

static double ellipsoid_surface(const double s[3])
{
    /* Thomsen's formula, as MuJoCo has it; it is off by at most one per cent. */
    const double p = 1.6075;
    double sum = pow(s[0] * s[1], p) + pow(s[1] * s[2], p) + pow(s[2] * s[0], p);
    return 4 * SCENE_PI * pow(sum / 3, 1 / p);
}

double geom_volume(hand_geom_type type, const double s[3], bool shell)
{
    double r = s[0], height = 2 * s[1];
    switch (type) {
    case HAND_BOX:
        return 8 * (shell ? s[0] * s[1] + s[1] * s[2] + s[2] * s[0] : s[0] * s[1] * s[2]);
    case HAND_SPHERE:
        return 4 * SCENE_PI * (shell ? r * r : r * r * r / 3);
    case HAND_CAPSULE:
        return SCENE_PI * (shell ? 4 * r * r + 2 * r * height : r * r * height + 4 * r * r * r / 3);
    case HAND_CYLINDER:
        return SCENE_PI * (shell ? 2 * r * r + 2 * r * height : r * r * height);
    case HAND_ELLIPSOID:
        return shell ? ellipsoid_surface(s) : 4 * SCENE_PI * s[0] * s[1] * s[2] / 3;
    default:
        return 0;
    }
}

/* Two half spheres of radius r together have the mass `ball`; their flat sides are `height` apart. A solid half sphere
 * has its centre of mass at 3/8 r, a hollow one at r/2. */
static void capsule_moments(double r, double height, bool shell, double moments[3])
{
    double ball = shell ? 2 * r / (2 * r + height) : 4 * r / (4 * r + 3 * height), tube = 1 - ball;
    double own = (shell ? 2.0 / 3 : 2.0 / 5) * ball * r * r, depth = (shell ? 1.0 / 2 : 3.0 / 8) * r;
    /* Steiner's rule from the centre of the ball to that of the half sphere, and from there to the capsule's */
    double out = 0.5 * height + depth, shift = ball * (out * out - depth * depth);
    double across = tube * ((shell ? 6 : 3) * r * r + height * height) / 12;
    moments[0] = moments[1] = across + own + shift;
    moments[2] = (shell ? 1 : 0.5) * tube * r * r + own;
}

static void cylinder_moments(double r, double height, bool shell, double moments[3])
{
    double lids = shell ? r / (r + height) : 0, tube = 1 - lids; /* both lids, over the whole surface */
    moments[0] = moments[1] =
        tube * ((shell ? 6 : 3) * r * r + height * height) / 12 + lids * (r * r / 4 + height * height / 4);
    moments[2] = (shell ? 1 : 0.5) * tube * r * r + lids * r * r / 2;
}

/* A thin ellipsoid of even thickness is taken as the difference of two solid ones, as in MuJoCo: a micrometre thick. */
static void ellipsoid_shell(const double s[3], double moments[3])
{
    const double thickness = 1e-6;
    double outer[3] = {s[0] + thickness, s[1] + thickness, s[2] + thickness};
    double inside = s[0] * s[1] * s[2], whole = outer[0] * outer[1] * outer[2], density = 1 / (whole - inside);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        moments[i] =
            density / 5 * (whole * (outer[j] * outer[j] + outer[k] * outer[k]) - inside * (s[j] * s[j] + s[k] * s[k]));
    }
}

/* The pair of sides across axis i has half the distance s[i], and its area is a part of the surface. */
static void box_shell(const double s[3], double moments[3])
{
    double part[3], sum = s[0] * s[1] + s[1] * s[2] + s[2] * s[0];
    for (int i = 0; i < 3; i++) part[i] = s[(i + 1) % 3] * s[(i + 2) % 3] / sum;
    double square[3]; /* mean of the square of the coordinate */
    for (int i = 0; i < 3; i++) square[i] = s[i] * s[i] * (part[i] + (1 - part[i]) / 3);
    for (int i = 0; i < 3; i++) moments[i] = square[(i + 1) % 3] + square[(i + 2) % 3];
}

void geom_moments(hand_geom_type type, const double s[3], bool shell, double moments[3])
{
    double part = type == HAND_BOX ? 1.0 / 3 : 1.0 / 5;
    moments[0] = moments[1] = moments[2] = 0;
    switch (type) {
    case HAND_SPHERE:
        for (int i = 0; i < 3; i++) moments[i] = (shell ? 2.0 / 3 : 2.0 / 5) * s[0] * s[0];
        return;
    case HAND_CAPSULE:
        capsule_moments(s[0], 2 * s[1], shell, moments);
        return;
    case HAND_CYLINDER:
        cylinder_moments(s[0], 2 * s[1], shell, moments);
        return;
    case HAND_BOX:
    case HAND_ELLIPSOID:
        if (shell) {
            (type == HAND_BOX ? box_shell : ellipsoid_shell)(s, moments);
            return;
        }
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3, k = (i + 2) % 3;
            moments[i] = part * (s[j] * s[j] + s[k] * s[k]);
        }
        return;
    default:
        return;
    }
}
