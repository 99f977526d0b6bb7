# What is installed, and where. README.md of this folder has it as a table.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(PINCH_COMPONENTS core)
set(pinch_package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/Pinch)

# pinch_install_library(NAME EXPORT): the shared library and the archive of a room, and the CMake targets that find them
function(pinch_install_library name export)
    install(TARGETS pinch_${name}_shared pinch_${name} EXPORT ${export}
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT libraries NAMELINK_COMPONENT development
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
        INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
    install(EXPORT ${export} NAMESPACE pinch:: DESTINATION ${pinch_package_folder} COMPONENT development)
endfunction()

pinch_install_library(core PinchCore)
install(DIRECTORY core/include/pinch DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
if(TARGET pinch_ode)
    list(APPEND PINCH_COMPONENTS ode)
    pinch_install_library(ode PinchOde)
    install(DIRECTORY plugin/include/pinch DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
endif()

# An archive may be linked by another compiler than this one: what is in it for this one's optimizer is left out.
if(CMAKE_INTERPROCEDURAL_OPTIMIZATION AND CMAKE_C_COMPILER_ID STREQUAL "GNU")
    install(CODE "
        file(GLOB archives \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_LIBDIR}/libpinch*.a\")
        foreach(archive IN LISTS archives)
            execute_process(COMMAND ${CMAKE_OBJCOPY} --wildcard --remove-section=.gnu.lto_* --strip-symbol=__gnu_lto_*
                --enable-deterministic-archives \${archive} COMMAND_ERROR_IS_FATAL ANY)
        endforeach()" COMPONENT development)
endif()

configure_package_config_file(assets/install/PinchConfig.cmake.in PinchConfig.cmake INSTALL_DESTINATION ${pinch_package_folder}
    NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(PinchConfigVersion.cmake COMPATIBILITY SameMajorVersion)
install(FILES ${PROJECT_BINARY_DIR}/PinchConfig.cmake ${PROJECT_BINARY_DIR}/PinchConfigVersion.cmake
    DESTINATION ${pinch_package_folder} COMPONENT development)

# pkg-config: the prefix is found from the file's own place
set(pinch_pc_folder ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
file(RELATIVE_PATH pinch_up /${pinch_pc_folder} /)
string(REGEX REPLACE "/$" "" pinch_up "${pinch_up}")
set(PINCH_PC_PREFIX "\${pcfiledir}/${pinch_up}")
configure_file(assets/install/pinch.pc.in pinch.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/pinch.pc DESTINATION ${pinch_pc_folder} COMPONENT development)
if(TARGET pinch_ode)
    # ODE's archive is C++, and calls libccd where it was built with it, which not every ode.pc says.
    set(PINCH_ODE_PC_PRIVATE "-pthread -lstdc++ -lm")
    find_library(PINCH_CCD_LIBRARY ccd)
    if(PINCH_CCD_LIBRARY)
        set(PINCH_ODE_PC_PRIVATE "-lccd ${PINCH_ODE_PC_PRIVATE}")
    endif()
    configure_file(assets/install/pinch_ode.pc.in pinch_ode.pc @ONLY)
    install(FILES ${PROJECT_BINARY_DIR}/pinch_ode.pc DESTINATION ${pinch_pc_folder} COMPONENT development)
endif()

if(TARGET pinch_cli)
    install(TARGETS pinch_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT command)
    install(TARGETS pinch_preload LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/pinch COMPONENT command)
    install(DIRECTORY assets/scenes assets/hands assets/schema DESTINATION ${CMAKE_INSTALL_DATADIR}/pinch
        COMPONENT command)
    install(DIRECTORY ${PROJECT_BINARY_DIR}/manual/ DESTINATION ${CMAKE_INSTALL_DATADIR} COMPONENT command)
    install(FILES assets/reference/paper.json DESTINATION ${CMAKE_INSTALL_DATADIR}/pinch/reference COMPONENT command)
endif()
