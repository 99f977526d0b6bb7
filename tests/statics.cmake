# solvers, complementarity problems, static grasps
pinch_test(test_solvers SOURCES unit/test_solvers.c LINK pinch::core)
pinch_test(test_block_lu SOURCES unit/test_block_lu.c LINK pinch::core)
pinch_test(test_limit_surface SOURCES unit/test_limit_surface.c LINK pinch::core)
pinch_test(test_lcp SOURCES property/test_lcp.c LINK pinch::core)
pinch_test(test_paper SOURCES reference/test_paper.c support/grasps.c LINK pinch::core)
pinch_test(test_statics SOURCES unit/test_statics.c support/grasps.c LINK pinch::core)
pinch_test(test_grasps SOURCES property/test_grasps.c support/grasps.c LINK pinch::core)
pinch_test(test_static_dynamic SOURCES property/test_static_dynamic.c support/grasps.c LINK pinch::core)
