# the dynamic side: contact law, islands, plugin, scenes in motion, the commands that run them
add_library(pinch_test_islands STATIC support/island.c support/referee.c)
target_include_directories(pinch_test_islands PUBLIC ${CMAKE_CURRENT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/core)
target_link_libraries(pinch_test_islands PUBLIC pinch::core PRIVATE pinch_compile_options)

pinch_test(test_contact_law SOURCES unit/test_contact_law.c LINK pinch::core)
pinch_test(test_mobility SOURCES unit/test_mobility.c LINK pinch_test_islands)
pinch_test(test_random_islands SOURCES property/test_random_islands.c LINK pinch_test_islands)

if(TARGET pinch::ode)
    pinch_test(test_storage SOURCES unit/test_storage.c LINK pinch::ode)
    pinch_test(test_manifold SOURCES unit/test_manifold.c LINK pinch::ode)
    foreach(name test_storage test_manifold)
        target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/plugin)
    endforeach()
endif()

if(TARGET pinch::ode)
    pinch_test(test_joint_mismatch SOURCES plugin/test_joint_mismatch.c LINK pinch::ode)
    pinch_test(test_contacts SOURCES plugin/test_contacts.c support/block.c LINK pinch::ode)
    pinch_test(test_drives SOURCES plugin/test_drives.c LINK pinch::ode)
    pinch_test(test_allocation SOURCES plugin/test_allocation.c support/block.c LINK pinch::ode)
    target_link_options(test_allocation PRIVATE -Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc)
endif()

if(TARGET pinch_scenes)
    add_library(pinch_test_scenes STATIC support/scene_run.c)
    target_link_libraries(pinch_test_scenes PUBLIC pinch_scenes pinch_test_program PRIVATE PkgConfig::CMOCKA pinch_compile_options)
    target_compile_definitions(pinch_test_scenes PRIVATE PINCH_SOURCE_DIR="${PROJECT_SOURCE_DIR}")

    pinch_test(test_pinched_capsule SOURCES reference/test_pinched_capsule.c LINK pinch_test_scenes)
    pinch_test(test_random_grasps SOURCES property/test_random_grasps.c LINK pinch_test_scenes)
endif()
