#include "joints/joint_aside.h"

/* An Euler motor's parameters without which it has no rows, and their values then. */
static const int parameter[3] = {dParamFMax, dParamLoStop, dParamHiStop};
static const double silent[3] = {0, -dInfinity, dInfinity};

static bool is_euler_motor(dJointID joint, dJointType type)
{
    return type == dJointTypeAMotor && dJointGetAMotorMode(joint) == dAMotorEuler;
}

void pinch_set_joint_aside(dJointID joint, pinch_joint_aside *aside)
{
    dJointType type = dJointGetType(joint);
    bool transmission = type == dJointTypeTransmission;
    aside->enabled = transmission || is_euler_motor(joint, type);
    if (!aside->enabled) {
        dJointDisable(joint);
        return;
    }
    aside->feedback = dJointGetFeedback(joint); /* it has Pinch's forces by now */
    dJointSetFeedback(joint, NULL);
    if (transmission) {
        aside->values[0][0] = dJointGetTransmissionBacklash(joint);
        aside->values[0][1] = dJointGetTransmissionParam(joint, dParamCFM);
        dJointSetTransmissionBacklash(joint, dInfinity);
        dJointSetTransmissionParam(joint, dParamCFM, 1); /* the row acts on nothing, and would be singular without */
        return;
    }
    for (int axis = 0; axis < 3; axis++)
        for (int k = 0; k < 3; k++) {
            aside->values[axis][k] = dJointGetAMotorParam(joint, parameter[k] + axis * dParamGroup);
            dJointSetAMotorParam(joint, parameter[k] + axis * dParamGroup, silent[k]);
        }
}

void pinch_put_joint_back(dJointID joint, pinch_joint_aside *aside)
{
    if (!aside->enabled) {
        dJointEnable(joint);
        return;
    }
    aside->enabled = false;
    dJointSetFeedback(joint, aside->feedback);
    if (dJointGetType(joint) == dJointTypeTransmission) {
        dJointSetTransmissionBacklash(joint, aside->values[0][0]);
        dJointSetTransmissionParam(joint, dParamCFM, aside->values[0][1]);
        return;
    }
    for (int axis = 0; axis < 3; axis++)
        for (int k = 0; k < 3; k++)
            dJointSetAMotorParam(joint, parameter[k] + axis * dParamGroup, aside->values[axis][k]);
}
