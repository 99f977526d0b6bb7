#include "law/limit_polygon.h"

#include <math.h>

static const double PI = 3.14159265358979323846;

static void stick(const double s[2], double r[2], double dr_ds[4], double dr_dscale[2])
{
    r[0] = s[0];
    r[1] = s[1];
    if (dr_dscale) dr_dscale[0] = dr_dscale[1] = 0.0;
    if (dr_ds) {
        dr_ds[0] = dr_ds[3] = 1.0;
        dr_ds[1] = dr_ds[2] = 0.0;
    }
}

/*
 * In the sector of facet k, with coordinates a along its normal n and b along it, s has |b| <= a tan(pi/faces), and by
 * symmetry its closest point lies in the same sector: inside when a <= apothem, else on the facet at b clamped to the
 * corners +-apothem tan(pi/faces).
 */
bool pinch_limit_polygon_project(int faces, double apothem, const double s[2], double r[2], double dr_ds[4],
                                 double dr_dscale[2])
{
    /* within the inscribed circle no facet is reached, whichever is nearest */
    if (s[0] * s[0] + s[1] * s[1] <= apothem * apothem) {
        stick(s, r, dr_ds, dr_dscale);
        return true;
    }
    double sector = 2.0 * PI / faces;
    double angle = sector * round(atan2(s[1], s[0]) / sector);
    double n[2] = {cos(angle), sin(angle)}, t[2] = {-n[1], n[0]};
    double a = s[0] * n[0] + s[1] * n[1], b = s[0] * t[0] + s[1] * t[1];
    bool inside = a <= apothem;
    double half_edge = faces > 2 ? tan(0.5 * sector) : INFINITY;
    /* 0 * INFINITY must not appear for the strip of zero width */
    bool on_facet = faces == 2 || fabs(b) <= apothem * half_edge;
    double corner = b < 0.0 ? -half_edge : half_edge;
    double c = on_facet ? b : apothem * corner;
    for (int i = 0; i < 2; i++) {
        r[i] = inside ? s[i] : apothem * n[i] + c * t[i];
        if (dr_dscale) dr_dscale[i] = inside ? 0.0 : apothem * (n[i] + (on_facet ? 0.0 : corner * t[i]));
        for (int j = 0; dr_ds && j < 2; j++)
            dr_ds[2 * i + j] = inside ? (i == j ? 1.0 : 0.0) : on_facet ? t[i] * t[j] : 0.0;
    }
    return inside;
}
