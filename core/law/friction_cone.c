#include "law/friction_cone.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

/* At a prescribed y_0 the closest point of the ball of radius y_0. */
static void project_onto_ball(double radius, const double x[4], double y[4], double d[16])
{
    double length = sqrt(x[1] * x[1] + x[2] * x[2] + x[3] * x[3]);
    bool inside = length <= radius;
    y[0] = radius;
    for (int i = 1; i < 4; i++) {
        y[i] = inside ? x[i] : radius / length * x[i];
        for (int j = 1; j < 4; j++) {
            double unit = i == j ? 1.0 : 0.0;
            d[4 * i + j] = inside ? unit : radius / length * (unit - x[i] / length * (x[j] / length));
        }
    }
}

/* The second-order cone: the point itself, the apex, or half way between the axis and the mantle's normal. */
static void project_onto_round_cone(double low, double high, const double x[4], double y[4], double d[16])
{
    double length = sqrt(x[1] * x[1] + x[2] * x[2] + x[3] * x[3]);
    double height = length <= x[0] ? x[0] : length <= -x[0] ? 0.0 : 0.5 * (x[0] + length);
    if (height <= low || height >= high) {
        project_onto_ball(fmin(fmax(height, low), high), x, y, d);
        return;
    }
    if (length <= x[0]) {
        memcpy(y, x, 4 * sizeof *y);
        for (int i = 0; i < 4; i++) d[5 * i] = 1.0;
        return;
    }
    double e[4] = {1.0, x[1] / length, x[2] / length, x[3] / length};
    for (int i = 0; i < 4; i++) y[i] = height * e[i];
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            double bend = i > 0 && j > 0 ? height / length * ((i == j ? 1.0 : 0.0) - e[i] * e[j]) : 0.0;
            d[4 * i + j] = 0.5 * e[i] * e[j] + bend;
        }
}

/*
 * In the sector of the nearest facet, with a along its normal and b along it, the closest point obeys
 * a <= y_0, |b| <= T y_0 (T = tan(pi/faces)), |x_3| <= y_0, each exceeded by c_j-fold y_0: c = (1, T, 1). y_0 solves
 *
 *     y_0 - x_0 = sum over exceeded j of c_j (v_j - c_j y_0),   v = (a, |b|, |x_3|),
 *
 * whose right-hand side falls as y_0 grows; the limits are exceeded in the order of v_j/c_j.
 */
static void project_onto_prism_cone(int faces, double low, double high, const double x[4], double y[4], double d[16])
{
    double sector = 2.0 * PI / faces, angle = sector * round(atan2(x[2], x[1]) / sector);
    double n[2] = {cos(angle), sin(angle)};
    double a = x[1] * n[0] + x[2] * n[1], b = x[2] * n[0] - x[1] * n[1];
    double c[3] = {1.0, faces > 2 ? tan(0.5 * sector) : 0.0, 1.0};
    double v[3] = {a, fabs(b), fabs(x[3])}, sign[3] = {1.0, copysign(1.0, b), copysign(1.0, x[3])};
    double at[3];
    for (int j = 0; j < 3; j++) at[j] = c[j] > 0.0 ? v[j] / c[j] : -INFINITY; /* a strip has no corners */

    bool exceeded[3] = {false, false, false};
    double sum = x[0], weight = 1.0, height = x[0];
    for (;;) {
        int next = -1;
        for (int j = 0; j < 3; j++)
            if (!exceeded[j] && at[j] > height && (next < 0 || at[j] > at[next])) next = j;
        if (next < 0) break;
        exceeded[next] = true;
        sum += c[next] * v[next];
        weight += c[next] * c[next];
        height = sum / weight;
    }
    bool free = height > low && height < high;
    height = fmin(fmax(height, low), high);
    for (int j = 0; j < 3; j++) exceeded[j] = at[j] > height;

    /* in the sector's axes: e spans the normal force and what moves with it */
    double e[4] = {1.0, 0.0, 0.0, 0.0}, local[4] = {height, a, b, x[3]}, ld[16] = {0};
    for (int j = 0; j < 3; j++) {
        if (exceeded[j]) {
            e[j + 1] = sign[j] * c[j];
            local[j + 1] = e[j + 1] * height;
        } else {
            ld[5 * (j + 1)] = 1.0;
        }
    }
    for (int i = 0; free && i < 4; i++)
        for (int j = 0; j < 4; j++) ld[4 * i + j] += e[i] * e[j] / weight;

    const double turn[16] = {1, 0, 0, 0, 0, n[0], -n[1], 0, 0, n[1], n[0], 0, 0, 0, 0, 1};
    for (int i = 0; i < 4; i++) {
        y[i] = 0.0;
        for (int k = 0; k < 4; k++) {
            y[i] += turn[4 * i + k] * local[k];
            for (int l = 0; l < 4; l++)
                for (int j = 0; j < 4; j++) d[4 * i + j] += turn[4 * i + k] * ld[4 * k + l] * turn[4 * j + l];
        }
    }
}

void pinch_cone_project(int faces, double low, double high, const double x[4], double y[4], double dy_dx[16])
{
    memset(dy_dx, 0, 16 * sizeof *dy_dx);
    if (faces == 0)
        project_onto_round_cone(low, high, x, y, dy_dx);
    else
        project_onto_prism_cone(faces, low, high, x, y, dy_dx);
}
