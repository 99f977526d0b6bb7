# fingertip geometry against references of its own
if(TARGET pinch::ode)
    add_library(pinch_test_tips STATIC support/tips.c)
    target_include_directories(pinch_test_tips PUBLIC ${CMAKE_CURRENT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/core)
    target_link_libraries(pinch_test_tips PUBLIC pinch::ode PRIVATE PkgConfig::CMOCKA pinch_compile_options)

    pinch_test(test_tip_pairs SOURCES geometry/test_tip_pairs.c LINK pinch_test_tips)
    foreach(name test_tip_rules test_tip_manifolds test_tip_classes test_tip_queries)
        pinch_test(${name} SOURCES geometry/${name}.c LINK pinch_test_tips)
    endforeach()
    pinch_test(test_tip_allocation SOURCES geometry/test_tip_allocation.c ../demos/bench/allocations.c LINK pinch_test_tips)
    target_link_options(test_tip_allocation PRIVATE -Wl,--wrap=malloc,--wrap=calloc,--wrap=realloc)
endif()
