# solvers, complementarity problems, static grasps
pinch_test(test_solvers SOURCES unit/test_solvers.c LINK pinch::core)
