/*
 * A static grasp, with the core library alone: three fingertips hold a ball of 500 g and 4 cm radius. How do they share
 * its weight, and how much friction do they need?
 */
#include <pinch/statics.h>
#include <pinch/version.h>

#include <math.h>
#include <stdio.h>

enum { FINGERS = 3 };

int main(void)
{
    const double radius = 0.04, pi = 3.14159265358979323846;
    pinch_finger finger[FINGERS];
    for (int i = 0; i < FINGERS; i++) {
        double angle = 2 * pi * i / FINGERS, c = cos(angle), s = sin(angle);
        finger[i] = (pinch_finger){
            .point = {radius * c, radius * s, 0},
            .normal = {-c, -s, 0},
            .tangent1 = {0, 0, 1},
            .model = PINCH_CONTACT_SOFT,
            .stiffness = {20000, 13000, 1},
            .friction = 0.7,
            .torsional_friction = 0.003,
            .closing = 0.0004, /* m: presses with 8 N */
            .max_force = INFINITY,
        };
    }
    pinch_grasp grasp = {
        .finger_count = FINGERS, .fingers = finger, .wrench = {0, 0, -0.5 * 9.81, 0, 0, 0}, .radius = radius};
    pinch_statics_settings settings = pinch_default_statics_settings();

    pinch_statics *statics;
    pinch_finger_result result[FINGERS];
    pinch_statics_result whole;
    pinch_static_limits limits;
    pinch_status status = pinch_statics_create(FINGERS, 0, &statics); /* 0: no linearized cones are needed */
    if (status == PINCH_OK) status = pinch_statics_solve(statics, &grasp, &settings, result, &whole);
    if (status == PINCH_OK) status = pinch_statics_limits(statics, &grasp, &settings, &limits);
    if (status != PINCH_OK) {
        fprintf(stderr, "static_grasp: %s\n", pinch_status_text(status));
        return 1;
    }
    printf("%s, by libpinch %s\n", pinch_solve_status_text(whole.solve.status), pinch_version());
    for (int i = 0; i < FINGERS; i++)
        printf("finger %d: force (%.6f, %.6f, %.6f) N, margin %.4f, %s\n", i, result[i].force[0], result[i].force[1],
               result[i].force[2], result[i].slip_margin, pinch_contact_state_text(result[i].state));
    printf("it sinks by %.4f mm, and holds down to %.5f of its friction\n", -1e3 * whole.translation[2],
           limits.smallest_friction.holds);
    pinch_statics_destroy(statics);
    return whole.solve.status == PINCH_SOLVE_CONVERGED ? 0 : 1;
}
