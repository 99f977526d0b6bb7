/*
 * The pace at which ODE takes errors of position back, where it solves joints in Pinch's place.
 *
 * Joints whose errors Pinch takes back slowly, because more energy would come of it than they may put in, would be
 * closed at once by ODE. So ODE is given that part of their ERP for its step. All stops have an ERP of their own, and
 * some types of joints; the others have the world's.
 */
#include "joints/island_joints.h"

typedef dReal getter(dJointID joint, int parameter);
typedef void setter(dJointID joint, int parameter, dReal value);

/* A type of joint: how its parameters are reached, which one is an ERP of its own (0: none), and how many axes have
 * stops. */
typedef struct joint_access {
    getter *get;
    setter *set;
    int own;
    int axes;
} joint_access;

static joint_access access_of(dJointID joint)
{
    switch (dJointGetType(joint)) {
    case dJointTypeBall:
        return (joint_access){dJointGetBallParam, dJointSetBallParam, dParamERP, 0};
    case dJointTypeFixed:
        return (joint_access){dJointGetFixedParam, dJointSetFixedParam, dParamERP, 0};
    case dJointTypeDBall:
        return (joint_access){dJointGetDBallParam, dJointSetDBallParam, dParamERP, 0};
    case dJointTypeDHinge:
        return (joint_access){dJointGetDHingeParam, dJointSetDHingeParam, dParamERP, 0};
    case dJointTypeTransmission:
        return (joint_access){dJointGetTransmissionParam, dJointSetTransmissionParam, dParamERP, 0};
    case dJointTypeHinge:
        return (joint_access){dJointGetHingeParam, dJointSetHingeParam, 0, 1};
    case dJointTypeSlider:
        return (joint_access){dJointGetSliderParam, dJointSetSliderParam, 0, 1};
    case dJointTypeHinge2:
        return (joint_access){dJointGetHinge2Param, dJointSetHinge2Param, dParamSuspensionERP, 1};
    case dJointTypeUniversal:
        return (joint_access){dJointGetUniversalParam, dJointSetUniversalParam, 0, 2};
    case dJointTypePR:
        return (joint_access){dJointGetPRParam, dJointSetPRParam, 0, 2};
    case dJointTypePiston:
        return (joint_access){dJointGetPistonParam, dJointSetPistonParam, 0, 2};
    case dJointTypePU:
        return (joint_access){dJointGetPUParam, dJointSetPUParam, 0, 3};
    case dJointTypeAMotor:
        return (joint_access){dJointGetAMotorParam, dJointSetAMotorParam, 0, 3};
    case dJointTypeLMotor:
        return (joint_access){dJointGetLMotorParam, dJointSetLMotorParam, 0, 3};
    default:
        return (joint_access){NULL, NULL, 0, 0};
    }
}

static int count_of(const joint_access *a)
{
    return a->axes + (a->own != 0);
}

/* Returns the parameter that is the k-th ERP of a joint of this type. */
static int parameter_of(const joint_access *a, int k)
{
    if (k == a->axes) return a->own;
    return dParamStopERP + k * dParamGroup;
}

void pinch_slow_ode_joints(const pinch_joint_store *store, const pinch_island_joints *joints)
{
    for (int k = 0; k < joints->range.count; k++) {
        pinch_step_joint *joint = pinch_island_joint(store, joints, k);
        joint_access a = access_of(joint->joint);
        for (int i = 0; i < count_of(&a); i++) {
            joint->erp[i] = a.get(joint->joint, parameter_of(&a, i));
            a.set(joint->joint, parameter_of(&a, i), joints->pace * joint->erp[i]);
        }
    }
}

void pinch_restore_ode_joints(const pinch_joint_store *store, const pinch_island_joints *joints)
{
    for (int k = 0; k < joints->range.count; k++) {
        const pinch_step_joint *joint = pinch_island_joint(store, joints, k);
        joint_access a = access_of(joint->joint);
        for (int i = 0; i < count_of(&a); i++) a.set(joint->joint, parameter_of(&a, i), joint->erp[i]);
    }
}
