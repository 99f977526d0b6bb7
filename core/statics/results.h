#ifndef PINCH_STATICS_RESULTS_H
#define PINCH_STATICS_RESULTS_H

#include "statics/model.h"

/* Writes everything in the results that follows from u, given the law of the last load step; SI units. */
void pinch_static_recover(const pinch_static_model *model, const pinch_grasp *grasp, const pinch_double_double *u,
                          pinch_finger_result *fingers, pinch_statics_result *result);

/* Forces and slip of one finger, model units. */
typedef struct pinch_static_forces {
    pinch_contact_state state;
    double r[4], slip[3];
    double last_slip[3]; /* of the last load step */
} pinch_static_forces;

/* These write the results of one finger and of the object, SI units. */
void pinch_static_recover_finger(const pinch_static_model *model, const pinch_finger *finger,
                                 const pinch_static_contact *contact, const pinch_static_forces *forces,
                                 pinch_finger_result *result);
void pinch_static_recover_object(const pinch_static_model *model, const pinch_grasp *grasp, const pinch_double_double *u,
                                 pinch_statics_result *result);

/* Returns the state of a finger whose forces r and slip are known only to the tolerance of the solve. */
pinch_contact_state pinch_static_state(const pinch_static_contact *contact, const double r[4], const double slip[3],
                                       double tolerance);

/* A finger that presses without friction slides with all of the object's tangential motion at its point: writes that
 * into its slip, and PINCH_CONTACT_SLIP where it would be said to stick. */
void pinch_static_slide(const pinch_grasp *grasp, pinch_finger_result *fingers, const pinch_statics_result *result);

/* Writes d(load)/d(displacement), SI, with open fingers left out and all others sticking; a controlled normal force
 * does not stiffen.
 */
void pinch_static_stiffness(const pinch_static_model *model, const pinch_grasp *grasp,
                            const pinch_finger_result *fingers, double stiffness[36]);

/* Writes a direction in model freedoms as a twist of unit length in the metric of the radius. */
void pinch_static_twist(const pinch_static_model *model, const pinch_grasp *grasp, const double *direction,
                        double twist[6]);

/* Sets all outputs of a failed solve to NaN. */
void pinch_static_forget(int finger_count, pinch_finger_result *fingers, pinch_statics_result *result);

#endif
