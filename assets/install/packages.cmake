# Debian packages by `cpack`, from the install rules: libpinch1, libpinch-dev and pinch.
set(pinch_package_libraries libpinch${PROJECT_VERSION_MAJOR})
set(pinch_package_development libpinch-dev)
set(pinch_package_command pinch)

set(CPACK_GENERATOR DEB)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL libraries development command)
set(CPACK_PACKAGE_VENDOR Pinch)
# who makes packages says so as for Debian's own tools, in DEBFULLNAME and DEBEMAIL
set(CPACK_PACKAGE_CONTACT "Pinch maintainers <maintainers@pinch.example>")
if(DEFINED ENV{DEBEMAIL})
    set(CPACK_PACKAGE_CONTACT "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
endif()
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

# what programs and libraries need is read from them
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/core)

# the loader's cache follows by a trigger, and other packages learn from `shlibs` what they depend on
set(control ${PROJECT_BINARY_DIR}/debian)
file(WRITE ${control}/triggers "activate-noawait ldconfig\n")
file(WRITE ${control}/shlibs
    "libpinch ${PROJECT_VERSION_MAJOR} ${pinch_package_libraries} (>= ${PROJECT_VERSION})
libpinch_ode ${PROJECT_VERSION_MAJOR} ${pinch_package_libraries} (>= ${PROJECT_VERSION})
")
set(CPACK_DEBIAN_LIBRARIES_PACKAGE_CONTROL_EXTRA ${control}/triggers ${control}/shlibs)
# Debian's manual pages are compressed
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/assets/install/compress_pages.cmake)
set(CPACK_POST_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/assets/install/drop_scripts.cmake)

set(CPACK_DEBIAN_LIBRARIES_PACKAGE_NAME ${pinch_package_libraries})
set(CPACK_DEBIAN_LIBRARIES_PACKAGE_SECTION libs)
set(CPACK_COMPONENT_LIBRARIES_DESCRIPTION "solver of compliant frictional contact, shared libraries
Pinch finds the forces of compliant fingertips under Coulomb friction and
verifies every answer. libpinch solves islands of bodies and static grasps.
libpinch_ode is the contact solver of a world of the Open Dynamics Engine.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME ${pinch_package_development})
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
    "${pinch_package_libraries} (= ${PROJECT_VERSION}), libode-dev, libccd-dev, libc6-dev")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "solver of compliant frictional contact, development files
Headers, archives, the CMake package Pinch and the pkg-config modules pinch
and pinch_ode, to build programs with libpinch and libpinch_ode.")

set(CPACK_DEBIAN_COMMAND_PACKAGE_NAME ${pinch_package_command})
set(CPACK_DEBIAN_COMMAND_PACKAGE_SECTION science)
set(CPACK_COMPONENT_COMMAND_DESCRIPTION "simulator of robot grasps with compliant fingertips
The command pinch simulates grasp scenes, solves static grasps, compares
contact solvers, and runs unmodified programs of the Open Dynamics Engine
with Pinch as their contact solver.")

# the documents that every Debian package has; a plain installation leaves them out
file(WRITE ${PROJECT_BINARY_DIR}/changelog "pinch (${PROJECT_VERSION}) unstable; urgency=medium

  * Version ${PROJECT_VERSION}.

 -- ${CPACK_PACKAGE_CONTACT}  Sun, 01 Nov 2026 00:00:00 +0000
")
find_program(PINCH_GZIP gzip)
if(PINCH_GZIP)
    execute_process(COMMAND ${PINCH_GZIP} -9nc ${PROJECT_BINARY_DIR}/changelog
        OUTPUT_FILE ${PROJECT_BINARY_DIR}/changelog.gz)
    foreach(component libraries development command)
        set(folder ${CMAKE_INSTALL_DATADIR}/doc/${pinch_package_${component}})
        install(FILES LICENSE DESTINATION ${folder} RENAME copyright COMPONENT ${component} EXCLUDE_FROM_ALL)
        install(FILES ${PROJECT_BINARY_DIR}/changelog.gz DESTINATION ${folder} COMPONENT ${component} EXCLUDE_FROM_ALL)
    endforeach()
    include(CPack)
endif()
