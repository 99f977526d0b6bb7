
# fingertip contacts as they behave: grips that hold and turn and slip, rolling, energy, steps, statics
if(TARGET pinch_scenes)
    pinch_test(test_grips SOURCES fingertips/test_grips.c LINK pinch_test_scenes)
    pinch_test(test_steps_and_energy SOURCES fingertips/test_steps_and_energy.c LINK pinch_test_scenes)
    pinch_test(test_ledger SOURCES fingertips/test_ledger.c LINK pinch_test_scenes)
    pinch_test(test_rolling SOURCES fingertips/test_rolling.c LINK pinch_test_scenes)
    pinch_test(test_limits SOURCES fingertips/test_limits.c LINK pinch_test_scenes)
    pinch_test(test_static_limit SOURCES fingertips/test_static_limit.c support/box_grasp.c support/slow_motion.c
               LINK pinch_test_scenes)
    pinch_test(test_tip_scenes SOURCES fingertips/test_tip_scenes.c LINK pinch_test_scenes)
endif()
