#include "statics/results.h"

#include "support/vec3.h"

#include <math.h>
#include <string.h>

void pinch_static_recover_finger(const pinch_static_model *model, const pinch_finger *finger,
                                 const pinch_static_contact *contact, const pinch_static_forces *forces,
                                 pinch_finger_result *result)
{
    const double *r = forces->r, *slip = forces->slip;
    double length = model->length, reach = model->force / model->stiffness; /* unit of displacement */
    *result = (pinch_finger_result){.state = forces->state, .slip_margin = NAN};
    for (int i = 0; i < 4; i++) result->r[i] = r[i] * model->force * (i == 3 ? length : 1.0);
    double t2[3];
    pinch_v3_cross(finger->normal, finger->tangent1, t2);
    for (int j = 0; j < 3; j++) {
        double t1j = finger->tangent1[j];
        result->tangential_force[j] = result->r[1] * t1j + result->r[2] * t2[j];
        result->force[j] = result->r[0] * finger->normal[j] + result->tangential_force[j];
        if (contact->rows > 1) {
            result->tangential_displacement[j] = -result->tangential_force[j] / finger->stiffness[1];
            result->slip[j] = reach * (slip[0] * t1j + slip[1] * t2[j]);
        }
        result->last_slip[j] = reach / (j == 2 ? length : 1.0) * forces->last_slip[j];
    }
    result->normal_displacement = result->r[0] / finger->stiffness[0];
    if (contact->rows == 4) {
        result->torsional_displacement = -result->r[3] / finger->stiffness[2];
        result->torsional_slip = reach / length * slip[2];
    }
    if (contact->rows == 1 || !(r[0] > 0.0) || contact->axis[0] + contact->axis[2] == 0.0) return;
    double tangential = hypot(r[1], r[2]);
    double level = tangential > 0.0 ? tangential / contact->axis[0] : 0.0;
    if (contact->rows == 4 && r[3] != 0.0) level = hypot(level, r[3] / contact->axis[2]);
    result->slip_margin = 1.0 - level / r[0];
}

void pinch_static_recover_object(const pinch_static_model *model, const pinch_grasp *grasp, const pinch_double_double *u,
                                 pinch_statics_result *result)
{
    double reach = model->force / model->stiffness, full[6] = {0};
    for (int j = 0; j < model->freedoms; j++) full[grasp->planar && j == 2 ? 5 : j] = u[j].high * reach;
    double moved = 0.0, turned = 0.0;
    const double *o = model->origin;
    for (int j = 0; j < 3; j++) result->rotation[j] = full[3 + j] / model->length;
    for (int j = 0; j < 3; j++) {
        /* u is the displacement of the origin: the centre of mass moves by u - rotation x origin */
        int a = (j + 1) % 3, b = (j + 2) % 3;
        result->translation[j] = full[j] - (result->rotation[a] * o[b] - result->rotation[b] * o[a]);
        moved = hypot(moved, result->translation[j]);
        turned = hypot(turned, result->rotation[j]);
    }
    result->large_displacement = moved > 0.2 * grasp->radius || turned > 0.1;
}

/*
 * Returns the state as it is reported. Rounding must not make a finger that only just does not press a sticking one,
 * nor one that slid to where it is and stays on its limit: within 1e-12 of the unit force the first is open, and within
 * 1e-9 of its limit the second slips.
 */
static pinch_contact_state reported_state(const pinch_static_model *model, const pinch_static_contact *contact,
                                          pinch_contact_state state, const double s[4], const double slip[3])
{
    pinch_static_model tighter = *model;
    double r[4];
    tighter.friction_factor *= 1.0 - 1e-9;
    if (pinch_static_law(model, contact, s, r, NULL) == PINCH_CONTACT_OPEN || r[0] <= 1e-12) return PINCH_CONTACT_OPEN;
    bool slid = slip[0] != 0.0 || slip[1] != 0.0 || slip[2] != 0.0;
    if (state == PINCH_CONTACT_STICK && slid) return pinch_static_law(&tighter, contact, s, r, NULL);
    return state;
}

void pinch_static_recover(const pinch_static_model *model, const pinch_grasp *grasp, const pinch_double_double *u,
                          pinch_finger_result *fingers, pinch_statics_result *result)
{
    for (int c = 0; c < model->count; c++) {
        const pinch_static_contact *contact = &model->contacts[c];
        pinch_static_forces f = {.state = PINCH_CONTACT_OPEN};
        double s[4];
        pinch_static_trial_extended(model, contact, u, s);
        f.state = pinch_static_law(model, contact, s, f.r, NULL);
        for (int i = 1; f.state != PINCH_CONTACT_OPEN && i < contact->rows; i++) {
            if (f.r[i] != s[i]) f.last_slip[i - 1] = (f.r[i] - s[i]) / contact->k[i];
            f.slip[i - 1] = contact->rest[i - 1] + f.last_slip[i - 1];
        }
        f.state = reported_state(model, contact, f.state, s, f.slip);
        pinch_static_recover_finger(model, &grasp->fingers[c], contact, &f, &fingers[c]);
    }
    pinch_static_recover_object(model, grasp, u, result);
}

pinch_contact_state pinch_static_state(const pinch_static_contact *contact, const double r[4], const double slip[3],
                                       double tolerance)
{
    if (r[0] <= tolerance) return PINCH_CONTACT_OPEN;
    if (r[0] >= contact->max_force - tolerance) return PINCH_CONTACT_YIELD;
    double way = 0.0;
    for (int i = 1; i < contact->rows; i++) way = hypot(way, contact->k[i] * slip[i - 1]);
    return way > tolerance ? PINCH_CONTACT_SLIP : PINCH_CONTACT_STICK;
}

void pinch_static_slide(const pinch_grasp *grasp, pinch_finger_result *fingers, const pinch_statics_result *result)
{
    for (int c = 0; c < grasp->finger_count; c++) {
        const pinch_finger *finger = &grasp->fingers[c];
        if (finger->model != PINCH_CONTACT_FRICTIONLESS || fingers[c].state == PINCH_CONTACT_OPEN) continue;
        if (fingers[c].state == PINCH_CONTACT_STICK) fingers[c].state = PINCH_CONTACT_SLIP;
        double *slip = fingers[c].slip;
        pinch_v3_cross(result->rotation, finger->point, slip);
        pinch_v3_add_scaled(slip, 1, result->translation);
        pinch_v3_make_perpendicular(slip, finger->normal);
    }
}

void pinch_static_stiffness(const pinch_static_model *model, const pinch_grasp *grasp,
                            const pinch_finger_result *fingers, double stiffness[36])
{
    int m = model->freedoms;
    memset(stiffness, 0, 36 * sizeof *stiffness);
    for (int c = 0; c < model->count; c++) {
        const pinch_static_contact *contact = &model->contacts[c];
        if (fingers[c].state == PINCH_CONTACT_OPEN) continue;
        for (int i = contact->controlled ? 1 : 0; i < contact->rows; i++)
            for (int a = 0; a < m; a++)
                for (int b = 0; b < m; b++) {
                    int row = grasp->planar && a == 2 ? 5 : a, column = grasp->planar && b == 2 ? 5 : b;
                    double lever = (row > 2 ? model->length : 1.0) * (column > 2 ? model->length : 1.0);
                    stiffness[6 * row + column] +=
                        model->stiffness * lever * contact->k[i] * contact->w[i][a] * contact->w[i][b];
                }
    }
}

void pinch_static_twist(const pinch_static_model *model, const pinch_grasp *grasp, const double *direction,
                        double twist[6])
{
    /* freedoms are (translation, radius * rotation) in one unit: already the metric */
    double length2 = 0.0;
    for (int j = 0; j < model->freedoms; j++) length2 += direction[j] * direction[j];
    for (int j = 0; j < 6; j++) twist[j] = 0.0;
    if (!(length2 > 0.0)) return;
    for (int j = 0; j < model->freedoms; j++) {
        int place = grasp->planar && j == 2 ? 5 : j;
        twist[place] = direction[j] / sqrt(length2) / (place > 2 ? model->length : 1.0);
    }
}

void pinch_static_forget(int finger_count, pinch_finger_result *fingers, pinch_statics_result *result)
{
    for (int i = 0; i < finger_count; i++) {
        pinch_finger_result *f = &fingers[i];
        *f = (pinch_finger_result){.normal_displacement = NAN,
                                   .torsional_displacement = NAN,
                                   .torsional_slip = NAN,
                                   .slip_margin = NAN,
                                   .r = {NAN, NAN, NAN, NAN}};
        for (int j = 0; j < 3; j++)
            f->force[j] = f->tangential_force[j] = f->tangential_displacement[j] = f->slip[j] = f->last_slip[j] = NAN;
    }
    for (int j = 0; j < 3; j++) result->translation[j] = result->rotation[j] = NAN;
    for (int j = 0; j < 36; j++) result->stiffness[j] = NAN;
    pinch_static_verification none = {.force_error = NAN,
                                      .torque_error = NAN,
                                      .cone = NAN,
                                      .complementarity = NAN,
                                      .slip_direction = NAN,
                                      .force_scale = NAN};
    result->verification = none;
}
