# Run by CPack on the packages that it has made: takes out the scripts that call ldconfig. The trigger in `libpinch1`
# does so already, and a package with a script for its removal leaves an entry behind when it is removed.
find_program(DPKG_DEB dpkg-deb)
if(NOT DPKG_DEB)
    return()
endif()
foreach(package IN LISTS CPACK_PACKAGE_FILES)
    set(folder ${CPACK_TEMPORARY_DIRECTORY}-unpacked)
    file(REMOVE_RECURSE ${folder})
    execute_process(COMMAND ${DPKG_DEB} --raw-extract ${package} ${folder} COMMAND_ERROR_IS_FATAL ANY)
    file(REMOVE ${folder}/DEBIAN/postinst ${folder}/DEBIAN/postrm)
    execute_process(COMMAND ${DPKG_DEB} --root-owner-group --build ${folder} ${package} OUTPUT_QUIET
        COMMAND_ERROR_IS_FATAL ANY)
    file(REMOVE_RECURSE ${folder})
endforeach()
