# scene files and the command around them; every program here may run the real command
add_library(pinch_test_program STATIC support/program.c)
target_include_directories(pinch_test_program PUBLIC ${CMAKE_CURRENT_SOURCE_DIR})
target_link_libraries(pinch_test_program PRIVATE pinch_compile_options)
target_compile_definitions(pinch_test_program PUBLIC PINCH_EXECUTABLE="$<TARGET_FILE:pinch_cli>")
add_dependencies(pinch_test_program pinch_cli)

pinch_test(test_shape SOURCES unit/test_shape.c LINK pinch_scenes)
pinch_test(test_scene SOURCES unit/test_scene.c LINK pinch_scenes pinch_test_program)
pinch_test(test_validate SOURCES cli/test_validate.c cli/broken_scenes.c LINK pinch_test_program)
pinch_test(test_schema SOURCES unit/test_schema.c LINK pinch_scenes)
pinch_test(test_options SOURCES unit/test_options.c LINK pinch_commands)
pinch_test(test_scene_fuzz SOURCES fuzz/test_scene_fuzz.c cli/broken_scenes.c LINK pinch_scenes pinch_test_program)
pinch_test(test_solve SOURCES cli/test_solve.c LINK pinch_test_program PkgConfig::JANSSON)
