#include "solvers/methods.h"
#include "statics/flow.h"
#include "statics/workspace.h"
#include "support/vec3.h"

#include <math.h>

static bool positive(double x)
{
    return x > 0.0 && isfinite(x);
}

static bool not_negative(double x)
{
    return x >= 0.0 && isfinite(x);
}

static bool valid_finger(const pinch_finger *f, bool planar)
{
    /* how far a frame may be from orthonormal: what rounding of a scene's numbers leaves */
    const double loose = 1e-9;
    bool frictional = f->model == PINCH_CONTACT_HARD || f->model == PINCH_CONTACT_SOFT;
    bool soft = f->model == PINCH_CONTACT_SOFT && !planar;
    if (!frictional && f->model != PINCH_CONTACT_FRICTIONLESS) return false;
    bool frame = isfinite(pinch_v3_dot(f->point, f->point)) && fabs(pinch_v3_dot(f->normal, f->normal) - 1.0) < loose &&
                 fabs(pinch_v3_dot(f->tangent1, f->tangent1) - 1.0) < loose &&
                 fabs(pinch_v3_dot(f->normal, f->tangent1)) < loose;
    if (planar) frame = frame && f->normal[2] == 0.0 && (!frictional || f->tangent1[2] == 0.0);
    bool springs =
        positive(f->stiffness[0]) && (!frictional || positive(f->stiffness[1])) && (!soft || positive(f->stiffness[2]));
    bool friction = (!frictional || not_negative(f->friction)) && (!soft || not_negative(f->torsional_friction));
    bool loads = isfinite(f->closing) && f->max_force > 0.0 && (!f->force_controlled || not_negative(f->normal_force));
    return frame && springs && friction && loads;
}

pinch_status pinch_static_validate(const pinch_statics *statics, const pinch_grasp *grasp,
                                   const pinch_statics_settings *settings)
{
    if (!statics || !grasp || !settings || !grasp->fingers) return PINCH_INVALID_ARGUMENT;
    if (grasp->finger_count < 1 || grasp->finger_count > statics->fingers || !positive(grasp->radius))
        return PINCH_INVALID_ARGUMENT;
    if (!isfinite(pinch_v3_dot(grasp->origin, grasp->origin))) return PINCH_INVALID_ARGUMENT;
    for (int i = 0; i < 6; i++)
        if (!isfinite(grasp->wrench[i])) return PINCH_INVALID_ARGUMENT;
    const double *p = grasp->wrench;
    if (grasp->planar && (p[2] != 0.0 || p[3] != 0.0 || p[4] != 0.0)) return PINCH_INVALID_ARGUMENT;
    for (int i = 0; i < grasp->finger_count; i++)
        if (!valid_finger(&grasp->fingers[i], grasp->planar)) return PINCH_INVALID_ARGUMENT;
    if (settings->faces < 3 || settings->faces > 4096 || settings->path_steps < 1 || !(settings->path_tolerance > 0.0))
        return PINCH_INVALID_ARGUMENT;
    if (settings->formulation != PINCH_FORMULATION_COULOMB && settings->formulation != PINCH_FORMULATION_LCP)
        return PINCH_INVALID_ARGUMENT;
    return pinch_check_solver_settings(&settings->solver);
}

pinch_status pinch_static_validate_method(const pinch_statics *statics, const pinch_grasp *grasp,
                                          const pinch_statics_settings *settings)
{
    pinch_solver solver = settings->solver.solver;
    bool for_systems = solver == PINCH_SOLVER_NSNMGK || solver == PINCH_SOLVER_NEWTON;
    if (settings->formulation == PINCH_FORMULATION_COULOMB && (settings->faithful || !for_systems))
        return PINCH_UNSUPPORTED;
    int faces = grasp->planar ? 3 : settings->faces;
    if (!pinch_static_uses_displacements(settings) && faces > statics->faces) return PINCH_INVALID_ARGUMENT;
    return PINCH_OK;
}
