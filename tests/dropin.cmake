# Pinch under ODE programs: the layer, its source level, `pinch exec`

# plain ODE programs, linked with ODE alone
set(pinch_programs stack wall spheres boxes chain car gripper ragdoll heavy slope feedback sleep conveyor bounce slip limit
    infinite crash forks)
set(pinch_program_folder ${CMAKE_CURRENT_BINARY_DIR}/programs)
add_library(pinch_program_sim STATIC programs/sim.c)
target_link_libraries(pinch_program_sim PUBLIC PkgConfig::ODE m PRIVATE pinch_compile_options)
foreach(name ${pinch_programs})
    add_executable(program_${name} programs/${name}.c)
    target_link_libraries(program_${name} PRIVATE pinch_program_sim pinch_compile_options)
endforeach()
add_library(program_module MODULE programs/module.c)
set_target_properties(program_module PROPERTIES PREFIX "" OUTPUT_NAME module C_VISIBILITY_PRESET default LIBRARY_OUTPUT_DIRECTORY ${pinch_program_folder})
target_link_libraries(program_module PRIVATE PkgConfig::ODE pinch_compile_options)
foreach(name loader lookup)
    add_executable(program_${name} programs/${name}.c)
    target_link_libraries(program_${name} PRIVATE ${CMAKE_DL_LIBS} pinch_compile_options)
endforeach()
foreach(name ${pinch_programs} loader lookup)
    set_target_properties(program_${name} PROPERTIES OUTPUT_NAME ${name} RUNTIME_OUTPUT_DIRECTORY ${pinch_program_folder}
        C_EXTENSIONS OFF)
    target_compile_definitions(program_${name} PRIVATE _XOPEN_SOURCE=700)
endforeach()

pinch_test(test_dropin SOURCES dropin/test_dropin.c LINK pinch::ode)
pinch_test(test_dropin_joints SOURCES dropin/test_dropin_joints.c LINK pinch::ode)
pinch_test(test_dropin_car SOURCES dropin/test_dropin_car.c LINK pinch::ode)
pinch_test(test_dropin_fuzz SOURCES dropin/test_dropin_fuzz.c LINK pinch::ode)
pinch_test(test_dropin_threads SOURCES dropin/test_dropin_threads.c LINK pinch::ode Threads::Threads)
target_include_directories(test_dropin PRIVATE ${PROJECT_SOURCE_DIR}/plugin)
target_link_options(test_dropin PRIVATE -Wl,--wrap=calloc)

if(TARGET pinch_cli)
    pinch_test(test_exec SOURCES cli/test_exec.c support/exec.c LINK pinch_test_program PkgConfig::JANSSON)
    pinch_test(test_exec_library SOURCES cli/test_exec_library.c support/exec.c LINK pinch_test_program PkgConfig::JANSSON)
    pinch_test(test_exec_programs SOURCES cli/test_exec_programs.c support/exec.c LINK pinch_test_program PkgConfig::JANSSON)
    pinch_test(test_exec_physics SOURCES cli/test_exec_physics.c support/exec.c LINK pinch_test_program PkgConfig::JANSSON)
    foreach(name test_exec test_exec_library test_exec_programs test_exec_physics)
        target_compile_definitions(${name} PRIVATE PINCH_PROGRAMS="${pinch_program_folder}")
        foreach(program ${pinch_programs} loader lookup module)
            add_dependencies(${name} program_${program})
        endforeach()
        if(PINCH_SANITIZE)
            # the preloaded library wants the sanitizer's, which programs that are not ours do not have
            execute_process(COMMAND ${CMAKE_C_COMPILER} -print-file-name=libasan.so
                OUTPUT_VARIABLE pinch_asan OUTPUT_STRIP_TRAILING_WHITESPACE)
            set_tests_properties(${name} PROPERTIES ENVIRONMENT
                "ASAN_OPTIONS=verify_asan_link_order=0:detect_leaks=0;LD_PRELOAD=${pinch_asan}")
        endif()
    endforeach()
endif()
