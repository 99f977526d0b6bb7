#include "statics/model.h"

#include "law/friction_cone.h"
#include "support/vec3.h"

#include <limits.h>
#include <math.h>
#include <string.h>

/* Writes the column of W for a unit force along e at the contact (moment arm in units of length), or for a unit moment
 * about e. */
static void wrench_column(const pinch_static_model *model, const pinch_finger *finger, const double e[3], bool moment,
                          bool planar, double column[6])
{
    double arm[3], torque[3], full[6] = {0};
    for (int i = 0; i < 3; i++) arm[i] = finger->point[i] - model->origin[i];
    pinch_v3_cross(arm, e, torque);
    for (int i = 0; i < 3; i++) {
        full[i] = moment ? 0.0 : e[i];
        full[3 + i] = moment ? e[i] : torque[i] / model->length;
    }
    if (!planar) {
        memcpy(column, full, sizeof full);
        return;
    }
    memset(column, 0, sizeof full);
    column[0] = full[0];
    column[1] = full[1];
    column[2] = full[5];
}

static int rows_of(const pinch_finger *finger, bool planar)
{
    if (finger->model == PINCH_CONTACT_FRICTIONLESS) return 1;
    return finger->model == PINCH_CONTACT_SOFT && !planar ? 4 : 3;
}

/*
 * Chooses the units. length is the object's radius. stiffness is the geometric mean of the fingers'. force is the
 * largest of the wrench, the prescribed normal forces, and what closing alone can build up: a finger that closes by d
 * works against all the others, so its force is at most d / (1/kn + 1/(sum of the others' kn)).
 */
static void choose_units(pinch_static_model *model, const pinch_grasp *grasp)
{
    double log_sum = 0.0, k_sum = 0.0;
    for (int i = 0; i < grasp->finger_count; i++) {
        log_sum += log(grasp->fingers[i].stiffness[0]);
        k_sum += grasp->fingers[i].stiffness[0];
    }
    model->length = grasp->radius;
    model->stiffness = exp(log_sum / grasp->finger_count);
    double force = fmax(pinch_v3_norm(grasp->wrench), pinch_v3_norm(grasp->wrench + 3) / model->length);
    for (int i = 0; i < grasp->finger_count; i++) {
        const pinch_finger *f = &grasp->fingers[i];
        double kn = f->stiffness[0], others = k_sum - kn;
        double closing = others > 0.0 ? fmax(f->closing, 0.0) * kn * others / (kn + others) : 0.0;
        force = fmax(force, f->force_controlled ? f->normal_force : closing);
    }
    model->force = force > 0.0 ? force : 1.0;
}

static void build_contact(const pinch_static_model *model, const pinch_grasp *grasp, const pinch_finger *finger,
                          pinch_static_contact *c)
{
    double tangent2[3], k0 = model->stiffness, length = model->length;
    pinch_v3_cross(finger->normal, finger->tangent1, tangent2);
    *c = (pinch_static_contact){.rows = rows_of(finger, grasp->planar),
                                .controlled = finger->force_controlled,
                                .normal_force = finger->normal_force / model->force,
                                .closing = finger->closing * k0 / model->force,
                                .max_force = finger->max_force / model->force};
    const double *directions[4] = {finger->normal, finger->tangent1, tangent2, finger->normal};
    for (int i = 0; i < c->rows; i++) wrench_column(model, finger, directions[i], i == 3, grasp->planar, c->w[i]);
    c->k[0] = finger->stiffness[0] / k0;
    c->k[1] = c->k[2] = finger->stiffness[1] / k0;
    c->k[3] = finger->stiffness[2] / (k0 * length * length);
    c->axis[0] = c->axis[1] = c->rows > 1 ? finger->friction : 0.0;
    c->axis[2] = c->rows > 3 ? finger->torsional_friction / length : 0.0;
}

/* The flow is measured in the stiffness of the grasp when everything sticks, with a little added where that has none.
 */
void pinch_static_build_reference(pinch_static_model *model)
{
    int m = model->freedoms;
    double trace = 0.0;
    if (model->has_reference) return;
    model->has_reference = true;
    memset(model->reference, 0, sizeof model->reference);
    for (int c = 0; c < model->count; c++)
        for (int i = 0; i < model->contacts[c].rows; i++)
            for (int a = 0; a < m; a++)
                for (int b = 0; b < m; b++) {
                    const pinch_static_contact *contact = &model->contacts[c];
                    model->reference[a * m + b] += contact->k[i] * contact->w[i][a] * contact->w[i][b];
                }
    for (int a = 0; a < m; a++) trace += model->reference[a * m + a];
    for (int a = 0; a < m; a++) model->reference[a * m + a] += 1e-3 * trace / m;
}

void pinch_static_model_build(pinch_static_model *model, pinch_static_contact *contacts, const pinch_grasp *grasp,
                              const pinch_statics_settings *settings, bool raw)
{
    memset(model, 0, sizeof *model);
    model->count = grasp->finger_count;
    model->work_left = LONG_MAX;
    model->contacts = contacts;
    model->freedoms = grasp->planar ? 3 : 6;
    model->closing_factor = model->wrench_factor = model->friction_factor = 1.0;
    model->force = model->stiffness = model->length = 1.0;
    if (!raw) choose_units(model, grasp);
    if (settings->faithful) memcpy(model->origin, grasp->origin, sizeof model->origin);
    for (int i = 0; i < model->count; i++) build_contact(model, grasp, &grasp->fingers[i], &contacts[i]);
    double shift[3];
    pinch_v3_cross(model->origin, grasp->wrench, shift);
    for (int i = 0; i < 3; i++) {
        double torque = (grasp->wrench[3 + i] - shift[i]) / (model->force * model->length);
        if (!grasp->planar) {
            model->wrench[i] = grasp->wrench[i] / model->force;
            model->wrench[3 + i] = torque;
        } else {
            model->wrench[i] = i < 2 ? grasp->wrench[i] / model->force : torque;
        }
    }
    model->apothem = model->torsion = 1.0;
    if (settings->formulation == PINCH_FORMULATION_LCP) {
        model->faces = grasp->planar ? 2 : settings->faces;
        if (settings->inscribed) {
            model->apothem = grasp->planar ? 1.0 : cos(3.14159265358979323846 / settings->faces);
            model->torsion = 1.0 / sqrt(2.0);
        }
    }
}

void pinch_static_displacement(const pinch_static_model *model, const pinch_static_contact *contact, const double *u,
                               double w[4])
{
    for (int i = 0; i < 4; i++) {
        w[i] = 0.0;
        for (int j = 0; j < model->freedoms; j++) w[i] += contact->w[i][j] * u[j];
    }
}

void pinch_static_trial(const pinch_static_model *model, const pinch_static_contact *contact, const double *u,
                        double s[4])
{
    double w[4];
    pinch_static_displacement(model, contact, u, w);
    s[0] = contact->k[0] * (model->closing_factor * contact->closing - w[0]);
    for (int i = 1; i < 4; i++) s[i] = contact->k[i] * (contact->rest[i - 1] - w[i]);
}

void pinch_static_trial_extended(const pinch_static_model *model, const pinch_static_contact *contact,
                                 const pinch_double_double *u, double s[4])
{
    for (int i = 0; i < 4; i++) {
        pinch_double_double elongation = i == 0 ? pinch_dd_product(model->closing_factor, contact->closing)
                                                : (pinch_double_double){contact->rest[i - 1], 0};
        for (int j = 0; j < model->freedoms; j++)
            elongation = pinch_dd_add(elongation, pinch_dd_times(-contact->w[i][j], u[j]));
        s[i] = pinch_dd_times(contact->k[i], elongation).high;
    }
}

/* Projects friction onto the limit surface with the axes (mu, mu, mu_tau) r_n, or onto the prism that stands in for it.
 */
static bool project(const pinch_static_model *model, const pinch_static_contact *contact, const double axis[3],
                    const double s[3], double r[3], double dr_ds[9], double dr_dscale[3])
{
    if (model->faces == 0) return pinch_limit_surface_project(axis, contact->k + 1, s, r, dr_ds, dr_dscale);
    /* a corner of an inscribed prism must not leave the ellipsoid */
    double apothem = axis[0] * model->apothem * (contact->rows == 4 ? model->torsion : 1.0);
    double height = axis[2] * model->torsion, d2[4], scale[2];
    bool inside = pinch_limit_polygon_project(model->faces, apothem, s, r, d2, scale);
    bool torsion_inside = fabs(s[2]) <= height;
    r[2] = torsion_inside ? s[2] : copysign(height, s[2]);
    if (dr_ds) {
        const double values[9] = {d2[0], d2[1], 0.0, d2[2], d2[3], 0.0, 0.0, 0.0, torsion_inside ? 1.0 : 0.0};
        memcpy(dr_ds, values, sizeof values);
        dr_dscale[0] = scale[0];
        dr_dscale[1] = scale[1];
        dr_dscale[2] = torsion_inside ? 0.0 : r[2];
    }
    return inside && torsion_inside;
}

double pinch_static_controlled_force(const pinch_static_model *model, const pinch_static_contact *contact)
{
    return fmin(model->closing_factor * contact->normal_force, contact->max_force);
}

pinch_contact_state pinch_static_law(const pinch_static_model *model, const pinch_static_contact *contact,
                                     const double s[4], double r[4], double d[16])
{
    pinch_contact_state state = PINCH_CONTACT_STICK;
    double slope =
        0.0; /* -dr_n/dw_n; at touching the contact counts as closed, so that a start at rest has stiffness */
    if (contact->controlled) {
        r[0] = pinch_static_controlled_force(model, contact);
    } else {
        r[0] = fmin(fmax(s[0], 0.0), contact->max_force);
        if (s[0] >= 0.0 && s[0] < contact->max_force) slope = contact->k[0];
    }
    if (r[0] >= contact->max_force) state = PINCH_CONTACT_YIELD;
    r[1] = r[2] = r[3] = 0.0;
    if (d) {
        memset(d, 0, 16 * sizeof *d);
        d[0] = slope;
    }
    if (contact->rows > 1) {
        double axis[3], dr_ds[9], dr_dscale[3];
        for (int i = 0; i < 3; i++) axis[i] = model->friction_factor * contact->axis[i] * r[0];
        bool stick = project(model, contact, axis, s + 1, r + 1, d ? dr_ds : NULL, d ? dr_dscale : NULL);
        if (!stick && state == PINCH_CONTACT_STICK) state = PINCH_CONTACT_SLIP;
        for (int i = 0; d && i < 3; i++) {
            d[4 * (i + 1)] = r[0] > 0.0 ? dr_dscale[i] / r[0] * slope : 0.0;
            for (int j = 0; j < 3; j++) d[4 * (i + 1) + j + 1] = dr_ds[3 * i + j] * contact->k[j + 1];
        }
    }
    return r[0] > 0.0 ? state : PINCH_CONTACT_OPEN;
}

void pinch_static_equilibrium(const pinch_static_model *model, const double *u, double *equilibrium)
{
    for (int j = 0; j < model->freedoms; j++) equilibrium[j] = model->wrench_factor * model->wrench[j];
    for (int c = 0; c < model->count; c++) {
        const pinch_static_contact *contact = &model->contacts[c];
        double s[4], r[4];
        pinch_static_trial(model, contact, u, s);
        pinch_static_law(model, contact, s, r, NULL);
        for (int i = 0; i < contact->rows; i++)
            for (int j = 0; j < model->freedoms; j++) equilibrium[j] += contact->w[i][j] * r[i];
    }
}

void pinch_static_commit(pinch_static_model *model, const double *u)
{
    for (int c = 0; c < model->count; c++) {
        pinch_static_contact *contact = &model->contacts[c];
        double s[4], r[4], w[4];
        pinch_static_trial(model, contact, u, s);
        pinch_contact_state state = pinch_static_law(model, contact, s, r, NULL);
        contact->open = state == PINCH_CONTACT_OPEN;
        if (contact->open) {
            /* out of contact the springs are relaxed: the next touch starts where the object then is */
            pinch_static_displacement(model, contact, u, w);
            memcpy(contact->rest, w + 1, sizeof contact->rest);
            continue;
        }
        /* k (rest+ - w) = r; where r = s nothing slipped and rest keeps its digits */
        for (int i = 1; i < contact->rows; i++)
            if (r[i] != s[i]) contact->rest[i - 1] += (r[i] - s[i]) / contact->k[i];
    }
}
