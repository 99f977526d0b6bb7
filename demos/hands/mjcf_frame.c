/* Positions and orientations: MJCF has five ways to give an orientation. */

#include "inertia.h"
#include "mjcf.h"

static const char alternatives[4][10] = {"axisangle", "xyaxes", "zaxis", "euler"};

static bool unit(double v[3])
{
    double length = scene_norm(v);
    if (!(length > 1e-14)) return false;
    for (int i = 0; i < 3; i++) v[i] /= length;
    return true;
}

void mjcf_orientation_of_z(const double axis[3], double q[4])
{
    double z[3] = {0, 0, 1}, across[3];
    scene_cross(z, axis, across);
    double s = scene_norm(across), angle = atan2(s, axis[2]);
    if (s < 1e-10) { /* along z, or against it: then by half a turn about x */
        across[0] = s = 1;
        across[1] = across[2] = 0;
    }
    q[0] = cos(0.5 * angle);
    for (int i = 0; i < 3; i++) q[i + 1] = sin(0.5 * angle) * across[i] / s;
    pose_normalize(q);
}

static bool from_axes(const double given[6], double q[4])
{
    double x[3], y[3], z[3], r[9];
    scene_copy(given, x);
    scene_copy(given + 3, y);
    if (!unit(x)) return false;
    scene_add_scaled(y, -scene_dot(x, y), x);
    if (!unit(y)) return false;
    scene_cross(x, y, z);
    for (int i = 0; i < 3; i++) {
        r[3 * i] = x[i];
        r[3 * i + 1] = y[i];
        r[3 * i + 2] = z[i];
    }
    inertia_quaternion(r, q);
    return true;
}

static bool from_alternative(const mjcf_element *e, const xmlNode *level, int which, double q[4])
{
    static const size_t sizes[4] = {4, 6, 3, 3};
    const mjcf_compiler *c = &e->m->compiler;
    double v[6], part = c->degrees ? SCENE_PI / 180 : 1;
    if (reader_numbers(e->m->r, level, alternatives[which], v, sizes[which], sizes[which]) == 0) return true;
    switch (which) {
    case 0:
        if (!unit(v)) return false;
        q[0] = cos(0.5 * part * v[3]);
        for (int i = 0; i < 3; i++) q[i + 1] = sin(0.5 * part * v[3]) * v[i];
        return true;
    case 1:
        return from_axes(v, q);
    case 2:
        if (!unit(v)) return false;
        mjcf_orientation_of_z(v, q);
        return true;
    default:
        for (int i = 0; i < 3; i++) v[i] *= part;
        return geometry_euler(v, c->sequence, q);
    }
}

void mjcf_orientation(const mjcf_element *e, double q[4])
{
    hand_reader *r = e->m->r;
    memcpy(q, (double[4]){1, 0, 0, 0}, 4 * sizeof *q);
    if (mjcf_numbers(e, "quat", q, 4, 4) && !pose_normalize(q))
        reader_refuse(r, e->node, "expected a quaternion that is not 0");
    /* Another way than quat comes before it on any level, as in MuJoCo. */
    for (int i = e->count - 1; i >= 0; i--) {
        int found = xml_text(e->levels[i], "quat") ? 1 : 0, which = -1;
        for (int k = 0; k < 4; k++)
            if (xml_text(e->levels[i], alternatives[k])) {
                which = k;
                found++;
            }
        if (found > 1) reader_refuse(r, e->levels[i], "expected one of quat, axisangle, xyaxes, zaxis and euler");
        if (which < 0) continue;
        if (r->status == HAND_OK && !from_alternative(e, e->levels[i], which, q))
            reader_refuse(r, e->levels[i], "expected axes with a direction in %s", alternatives[which]);
        return;
    }
}

hand_pose mjcf_pose(const mjcf_element *e)
{
    hand_pose pose = pose_identity();
    mjcf_numbers(e, "pos", pose.position, 3, 3);
    mjcf_orientation(e, pose.orientation);
    return pose;
}
