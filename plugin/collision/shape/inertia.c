/* Mass properties of the shapes at uniform density. */
#include "tip_data.h"

#include "convex_shape.h"
#include "support/vec3.h"

#include <math.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

/* The volume, and the integrals of x^2, y^2 and z^2 over the body. */
typedef struct moments {
    double volume, xx, yy, zz;
} moments;

/*
 * A rounded box is cut along x. For |x| < hx the section is the rectangle rounded by s. At x = hx + u it is rounded by
 * rho = sqrt(s^2 - u^2). The section has the area A(rho) = A0 + P rho + pi rho^2 with A0 = 4 hy hz and P = 4 (hy + hz).
 * With the integrals of rho^k u^m over u from 0 to s, the integral of (hx + u)^2 A is a closed form.
 */
static double rounded_box_xx(double hx, double hy, double hz, double s)
{
    double A0 = 4 * hy * hz, P = 4 * (hy + hz), s2 = s * s, s3 = s2 * s, s4 = s2 * s2, s5 = s4 * s;
    double flat = (A0 + P * s + PI * s2) * 2 * hx * hx * hx / 3;
    double ends = A0 * (hx * hx * s + hx * s2 + s3 / 3) + P * (hx * hx * PI * s2 / 4 + 2 * hx * s3 / 3 + PI * s4 / 16) +
                  PI * (hx * hx * 2 * s3 / 3 + hx * s4 / 2 + 2 * s5 / 15);
    return flat + 2 * ends;
}

static moments rounded_box(const pinch_shape *shape)
{
    const double *h = shape->half, s = shape->margin;
    moments m;
    m.volume = 8 * h[0] * h[1] * h[2] + 8 * s * (h[0] * h[1] + h[1] * h[2] + h[2] * h[0]) +
               2 * PI * s * s * (h[0] + h[1] + h[2]) + 4 * PI / 3 * s * s * s;
    m.xx = rounded_box_xx(h[0], h[1], h[2], s);
    m.yy = rounded_box_xx(h[1], h[2], h[0], s);
    m.zz = rounded_box_xx(h[2], h[0], h[1], s);
    return m;
}

/* A rounded cylinder is a stack of discs of radius r + rho along z, and is integrated likewise. A capsule has r = 0. */
static moments rounded_cylinder(double r, double h, double s)
{
    double s2 = s * s, s3 = s2 * s, s4 = s2 * s2, s5 = s4 * s, R = r + s, r2 = r * r;
    moments m;
    m.volume = PI * (R * R * 2 * h + 2 * (r2 * s + 2 * r * PI * s2 / 4 + 2 * s3 / 3));
    m.zz = PI * (R * R * 2 * h * h * h / 3 + 2 * (r2 * (h * h * s + h * s2 + s3 / 3) +
                                                  2 * r * (h * h * PI * s2 / 4 + 2 * h * s3 / 3 + PI * s4 / 16) +
                                                  h * h * 2 * s3 / 3 + h * s4 / 2 + 2 * s5 / 15));
    m.xx = PI / 4 *
           (R * R * R * R * 2 * h + 2 * (r2 * r2 * s + 4 * r2 * r * PI * s2 / 4 + 6 * r2 * 2 * s3 / 3 +
                                         4 * r * 3 * PI * s4 / 16 + 8 * s5 / 15));
    m.yy = m.xx;
    return m;
}

static moments flat_capsule(const pinch_shape *shape)
{
    double r = shape->radius, h = shape->half[2], z = shape->middle;
    double tube = PI * r * r * 2 * h, dome = 2 * PI / 3 * r * r * r, top = z + h; /* z of the dome's flat side */
    moments m = {.volume = tube + dome};
    m.xx = m.yy = tube * r * r / 4 + dome * r * r / 5;
    m.zz = tube * (h * h / 3 + z * z) + dome * (r * r / 5 + 2 * top * 0.375 * r + top * top);
    return m;
}

static double beta(double x, double y)
{
    return tgamma(x) * tgamma(y) / tgamma(x + y);
}

static moments superellipsoid(const double *a, const double *e)
{
    double scale = a[0] * a[1] * a[2] * e[0] * e[1];
    double across = beta(1.5 * e[1], 0.5 * e[1]) * beta(0.5 * e[0], 2 * e[0] + 1);
    double along = beta(0.5 * e[1], 0.5 * e[1] + 1) * beta(1.5 * e[0], e[0] + 1);
    moments m = {.volume = 2 * scale * beta(0.5 * e[0] + 1, e[0]) * beta(0.5 * e[1], 0.5 * e[1])};
    m.xx = 0.5 * scale * a[0] * a[0] * across;
    m.yy = 0.5 * scale * a[1] * a[1] * across;
    m.zz = 2 * scale * a[2] * a[2] * along;
    return m;
}

/* Sums over tetrahedra from the origin to the faces. Each has the volume d/6 and the second moments d/120 (s s' + a a'
 * + b b' + c c'). */
static void polyhedron(const pinch_convex *c, double *volume, double second[9])
{
    const unsigned *polygon = c->polygons;
    for (unsigned f = 0; f < c->plane_count; f++, polygon += 1 + polygon[0])
        for (unsigned k = 2; k < polygon[0]; k++) {
            const double *x[3] = {c->points + 3 * polygon[1], c->points + 3 * polygon[k],
                                  c->points + 3 * polygon[k + 1]};
            double cross[3], s[3];
            pinch_v3_cross(x[1], x[2], cross);
            double d = pinch_v3_dot(x[0], cross);
            for (int i = 0; i < 3; i++) s[i] = x[0][i] + x[1][i] + x[2][i];
            *volume += d / 6;
            for (int i = 0; i < 9; i++) {
                double sum = s[i / 3] * s[i % 3];
                for (int j = 0; j < 3; j++) sum += x[j][i / 3] * x[j][i % 3];
                second[i] += d / 120 * sum;
            }
        }
}

pinch_status pinch_tip_inertia(const pinch_tip *tip, double *volume, double unit_inertia[9])
{
    if (!pinch_tip_legal(tip) || !volume || !unit_inertia) return PINCH_INVALID_ARGUMENT;
    double second[9] = {0};
    moments m = {0, 0, 0, 0};
    pinch_shape shape;
    memset(&shape, 0, sizeof shape);
    if (tip->type != PINCH_TIP_CONVEX) shape = pinch_shape_of_tip(tip, NULL);
    switch (tip->type) {
    case PINCH_TIP_CONVEX:
        for (int k = 0; k < tip->piece_count; k++) polyhedron(&tip->pieces[k], &m.volume, second);
        break;
    case PINCH_TIP_BOX:
        m = rounded_box(&shape);
        break;
    case PINCH_TIP_FLAT_CAPSULE:
        m = flat_capsule(&shape);
        break;
    case PINCH_TIP_ELLIPSOID:
    case PINCH_TIP_SUPERELLIPSOID: {
        static const double ROUND[2] = {1, 1};
        m = superellipsoid(tip->size, tip->type == PINCH_TIP_ELLIPSOID ? ROUND : tip->exponent);
        break;
    }
    default:
        m = rounded_cylinder(shape.radius, shape.half[2], shape.margin);
    }
    if (tip->type != PINCH_TIP_CONVEX) {
        second[0] = m.xx;
        second[4] = m.yy;
        second[8] = m.zz;
    }
    double trace = second[0] + second[4] + second[8];
    for (int i = 0; i < 9; i++) unit_inertia[i] = ((i % 4 ? 0 : trace) - second[i]) / m.volume;
    *volume = m.volume;
    return m.volume > 0 ? PINCH_OK : PINCH_INVALID_ARGUMENT;
}
