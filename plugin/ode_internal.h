/* What the drop-in layer uses beyond the plugin's public functions. */
#ifndef PINCH_PLUGIN_ODE_INTERNAL_H
#define PINCH_PLUGIN_ODE_INTERNAL_H

#include "joints/joint_pose.h"

#include <pinch/ode.h>

/* Returns PINCH_INVALID_ARGUMENT for a NULL pointer or values out of range, PINCH_UNSUPPORTED for a solver that cannot
 * step. */
pinch_status pinch_check_settings(const pinch_ode_settings *settings);
/* Uses the relative poses of joints that somebody else notes. */
void pinch_use_joint_poses(pinch_ode *plugin, pinch_joint_poses *poses);
/* From now on ODE moves all bodies that are not at rest, see pinch_ode_settings.move_bodies. */
void pinch_leave_motion_to_ode(pinch_ode *plugin);
/* The same as pinch_ode_add_joint, for an enabled joint whose bodies the caller has asked for. */
pinch_status pinch_add_joint_between(pinch_ode *plugin, dJointID joint, const dBodyID body[2], const dContact *contact);
/* The same as pinch_ode_statistics but for `memory`, which takes longer to find out and stays as it is. */
void pinch_count(const pinch_ode *plugin, pinch_ode_stats *stats);
/* The same as pinch_ode_solve, for a caller that lets nobody change the world before pinch_ode_advance. */
pinch_status pinch_solve_to_advance(pinch_ode *plugin, double h);

#endif
