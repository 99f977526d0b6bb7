/*
 * ODE's functions that Pinch calls and that programs do not reach through it.
 *
 * The library is not linked with ODE: a program may have another libode.so.8, or carry ODE in a library of its own, and
 * a second ODE in the process would be mixed up with that one. Each function here is a jump (ode_functions.c) to where
 * the program's ODE has it. One that is missing makes the library need libode.so.8, which a test notices.
 */
#ifndef PINCH_PRELOAD_ODE_FUNCTIONS_H
#define PINCH_PRELOAD_ODE_FUNCTIONS_H

/* clang-format off */
#define PINCH_ODE_FUNCTIONS(X)                                                                                         \
    X(dAllocateODEDataForThread) X(dBodyAddForce) X(dBodyAddTorque) X(dBodyDisable) X(dBodyEnable)                     \
    X(dBodyGetAngularDamping) X(dBodyGetAngularDampingThreshold) X(dBodyGetAngularVel)                                 \
    X(dBodyGetAutoDisableAngularThreshold) X(dBodyGetAutoDisableAverageSamplesCount) X(dBodyGetAutoDisableFlag)        \
    X(dBodyGetAutoDisableLinearThreshold) X(dBodyGetAutoDisableSteps) X(dBodyGetAutoDisableTime)                       \
    X(dBodyGetFiniteRotationAxis) X(dBodyGetFiniteRotationMode) X(dBodyGetFirstGeom) X(dBodyGetForce)                  \
    X(dBodyGetGravityMode) X(dBodyGetGyroscopicMode) X(dBodyGetJoint) X(dBodyGetLinearDamping)                         \
    X(dBodyGetLinearDampingThreshold) X(dBodyGetLinearVel) X(dBodyGetMass) X(dBodyGetMaxAngularSpeed)                  \
    X(dBodyGetNextGeom) X(dBodyGetNumJoints) X(dBodyGetPointVel) X(dBodyGetPosition) X(dBodyGetQuaternion)             \
    X(dBodyGetRotation) X(dBodyGetTorque) X(dBodyGetWorld) X(dBodyIsEnabled) X(dBodyIsKinematic) X(dBodySetAngularVel) \
    X(dBodySetAutoDisableAngularThreshold) X(dBodySetAutoDisableLinearThreshold) X(dBodySetForce) X(dBodySetLinearVel) \
    X(dBodySetPosition) X(dBodySetQuaternion) X(dBodySetTorque) X(dBodyVectorFromWorld) X(dBodyVectorToWorld)          \
    X(dDQfromW) X(dGeomBoxGetLengths) X(dGeomCapsuleGetParams) X(dGeomCylinderGetParams) X(dGeomGetAABB)   \
    X(dGeomGetBody) X(dGeomGetCategoryBits) X(dGeomGetClass) X(dGeomGetClassData) X(dGeomGetCollideBits)               \
    X(dGeomGetPosition) X(dGeomGetRotation) X(dGeomGetSpace) X(dGeomIsEnabled) X(dGeomIsOffset) X(dGeomIsSpace)        \
    X(dGeomPlaneGetParams) X(dGeomRayGet) X(dGeomRayGetLength) X(dGeomSetBody) X(dGeomSetPosition)                     \
    X(dGeomSphereGetRadius) X(dGeomSphereSetRadius) X(dGeomTransformGetCleanup) X(dGeomTransformGetGeom)               \
    X(dGeomTransformGetInfo) X(dGeomTriMeshGetArrayCallback) X(dGeomTriMeshGetCallback) X(dGeomTriMeshGetTriangle)     \
    X(dGeomTriMeshGetTriangleCount) X(dGetDebugHandler) X(dInvertPDMatrix) X(dJointCreateNull) X(dJointDisable)        \
    X(dJointEnable) X(dJointGetAMotorAngle) X(dJointGetAMotorAxis) X(dJointGetAMotorMode) X(dJointGetAMotorNumAxes)    \
    X(dJointGetAMotorParam) X(dJointGetBallAnchor) X(dJointGetBallAnchor2) X(dJointGetBallParam) X(dJointGetBody)      \
    X(dJointGetDBallAnchor1) X(dJointGetDBallAnchor2) X(dJointGetDBallDistance) X(dJointGetDBallParam)                 \
    X(dJointGetDHingeAxis) X(dJointGetDHingeParam) X(dJointGetFeedback) X(dJointGetFixedParam)                         \
    X(dJointGetHinge2Anchor) X(dJointGetHinge2Anchor2) X(dJointGetHinge2Angle1) X(dJointGetHinge2Angle2)               \
    X(dJointGetHinge2Axis1) X(dJointGetHinge2Axis2) X(dJointGetHinge2Param) X(dJointGetHingeAnchor)                    \
    X(dJointGetHingeAnchor2) X(dJointGetHingeAngle) X(dJointGetHingeAxis) X(dJointGetHingeParam)                       \
    X(dJointGetLMotorAxis) X(dJointGetLMotorNumAxes) X(dJointGetLMotorParam) X(dJointGetPRAnchor) X(dJointGetPRAngle)  \
    X(dJointGetPRAxis1) X(dJointGetPRAxis2) X(dJointGetPRParam) X(dJointGetPRPosition) X(dJointGetPUAnchor)            \
    X(dJointGetPUAngle1) X(dJointGetPUAngle2) X(dJointGetPUAxis1) X(dJointGetPUAxis2) X(dJointGetPUAxisP)              \
    X(dJointGetPUParam) X(dJointGetPUPosition) X(dJointGetPistonAnchor) X(dJointGetPistonAnchor2)                      \
    X(dJointGetPistonAngle) X(dJointGetPistonAxis) X(dJointGetPistonParam) X(dJointGetPistonPosition)                  \
    X(dJointGetSliderAxis) X(dJointGetSliderParam) X(dJointGetSliderPosition) X(dJointGetTransmissionAnchor1)          \
    X(dJointGetTransmissionAnchor2) X(dJointGetTransmissionAngle1) X(dJointGetTransmissionAngle2)                      \
    X(dJointGetTransmissionAxis1) X(dJointGetTransmissionAxis2) X(dJointGetTransmissionBacklash)                       \
    X(dJointGetTransmissionMode) X(dJointGetTransmissionParam) X(dJointGetTransmissionRadius1)                         \
    X(dJointGetTransmissionRadius2) X(dJointGetTransmissionRatio) X(dJointGetType) X(dJointGetUniversalAnchor)         \
    X(dJointGetUniversalAnchor2) X(dJointGetUniversalAngle1) X(dJointGetUniversalAngle2) X(dJointGetUniversalAxis1)    \
    X(dJointGetUniversalAxis2) X(dJointGetUniversalParam) X(dJointGroupCreate) X(dJointIsEnabled)                      \
    X(dJointSetAMotorNumAxes) X(dJointSetAMotorParam) X(dJointSetBallParam) X(dJointSetDBallParam)                     \
    X(dJointSetDHingeParam) X(dJointSetFeedback) X(dJointSetFixedParam) X(dJointSetHinge2Param) X(dJointSetHingeParam) \
    X(dJointSetLMotorNumAxes) X(dJointSetLMotorParam) X(dJointSetPRParam) X(dJointSetPUParam) X(dJointSetPistonParam)  \
    X(dJointSetSliderParam) X(dJointSetTransmissionBacklash) X(dJointSetTransmissionParam) X(dJointSetUniversalParam)  \
    X(dNormalize4) X(dPlaneSpace) X(dQFromAxisAndAngle) X(dQMultiply0) X(dQMultiply1) X(dQMultiply2) X(dRSetIdentity)  \
    X(dRfromQ) X(dSetDebugHandler) X(dSpaceCollide) X(dSpaceCollide2) X(dSpaceGetClass) X(dSpaceGetCleanup)            \
    X(dSpaceGetGeom) X(dSpaceGetNumGeoms) X(dWorldGetCFM) X(dWorldGetContactMaxCorrectingVel)                          \
    X(dWorldGetContactSurfaceLayer) X(dWorldGetERP) X(dWorldGetGravity) X(dWorldGetQuickStepNumIterations)             \
    X(dWorldSetERP)
/* clang-format on */

/* Finds the functions in an open library. Returns the name of one that is not there, NULL for success. */
const char *pinch_ode_functions_find(void *library);

#endif
