#ifndef PINCH_SIMULATION_STATE_H
#define PINCH_SIMULATION_STATE_H

#include "simulation.h"

/* What a run has measured so far. simulation.c uses it, and checkpoint.c keeps it. */

/* An object as the measures need it. */
typedef struct track {
    world_pose start, middle, touched; /* at the start, half way, when last touched */
    world_pose start_in_hand, middle_in_hand;
    bool held; /* has a finger carried load since the last drop? */
    /* Where, how fast (m/s) and when (s) the object's fall began, in which it has weight and nothing touches it. */
    double fall_position[3], fall_velocity[3], fall_time;
} track;

struct simulation {
    world *w;
    long steps;              /* of the whole run */
    uint64_t fingerprint;    /* of what it is made from, see simulation_know_origin; 0: not known */
    track *track;            /* per object */
    bool *crushed, *slipped; /* per finger: has the event been reported? */
    bool **away, **limited;  /* per hand and joint: has it been away from its limits, has the event been reported? */
    int event_room;
    simulation_result result;
};

#endif
