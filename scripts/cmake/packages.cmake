# Debian packages by CPack, one for each component: crsm-slam, libcrsm-slam1, libcrsm-slam-dev, python3-crsm-slam.
# scripts/packages makes them.
set(CRSM_MAINTAINER "CRSM SLAM authors <crsm-slam@users.noreply.github.com>" CACHE STRING "Who packages are from")
find_program(HELP2MAN help2man REQUIRED)

# ---- man pages, from --help
set(MAN_PAGES "")
foreach(program ${PROGRAMS})
  set(page ${CMAKE_BINARY_DIR}/man/${program}.1)
  add_custom_command(
    OUTPUT ${page}
    COMMAND ${CMAKE_SOURCE_DIR}/scripts/cmake/make_man_page $<TARGET_FILE:${program}> ${page}
    DEPENDS ${program} ${CMAKE_SOURCE_DIR}/scripts/cmake/make_man_page
    COMMENT "man page of ${program}")
  list(APPEND MAN_PAGES ${page})
endforeach()
add_custom_target(man_pages ALL DEPENDS ${MAN_PAGES})
install(DIRECTORY ${CMAKE_BINARY_DIR}/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT programs
        FILES_MATCHING PATTERN "*.1.gz")

# ---- lcm-spy's types and views: no library of others, and so not in share/java
file(GLOB_RECURSE PLUGINS CONFIGURE_DEPENDS scripts/spy_plugins/*)
set(JAR ${CMAKE_BINARY_DIR}/crsm_spy.jar)
add_custom_command(
  OUTPUT ${JAR}
  COMMAND ${CMAKE_SOURCE_DIR}/scripts/spy_plugins/make_jar ${JAR}
  DEPENDS ${PLUGINS} ${LCM_FILES}
  COMMENT "jar for lcm-spy")
add_custom_target(spy_jar ALL DEPENDS ${JAR})
install(FILES ${JAR} DESTINATION ${CMAKE_INSTALL_DATADIR}/crsm_slam RENAME crsm-spy.jar COMPONENT programs)

# ---- what every package has
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_NAME crsm-slam)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME libcrsm-slam${CRSM_SLAM_SOVERSION})
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libcrsm-slam-dev)
set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-crsm-slam)
string(TIMESTAMP NOW "%a, %d %b %Y %H:%M:%S +0000" UTC)  # or SOURCE_DATE_EPOCH, the last commit
# The licence as Debian's machine-readable format has it (DEP 5): lines indented, and a dot for an empty one.
file(READ LICENSE LICENSE_TEXT)
if(NOT LICENSE_TEXT MATCHES "^MIT License\n\nCopyright \\(c\\) ([^\n]+)\n\n(.*)\n$")
  message(FATAL_ERROR "LICENSE must be that of MIT, which Debian calls Expat")
endif()
set(COPYRIGHT "${CMAKE_MATCH_1}")
string(REGEX REPLACE "\n\n" "\n.\n" EXPAT "${CMAKE_MATCH_2}")
string(REGEX REPLACE "\n" "\n " EXPAT "${EXPAT}")
file(WRITE ${CMAKE_BINARY_DIR}/debian/copyright
     "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\nUpstream-Name: ${PROJECT_NAME}\n\n"
     "Files: *\nCopyright: ${COPYRIGHT}\nLicense: Expat\n ${EXPAT}\n")
foreach(component PROGRAMS RUNTIME DEVELOPMENT PYTHON)
  set(package ${CPACK_DEBIAN_${component}_PACKAGE_NAME})
  string(TOLOWER ${component} lower)
  set(changelog ${CMAKE_BINARY_DIR}/debian/${package}/changelog)
  file(WRITE ${changelog} "${package} (${PROJECT_VERSION}) unstable; urgency=medium\n\n  * See the history of the source.\n"
                          "\n -- ${CRSM_MAINTAINER}  ${NOW}\n")
  execute_process(COMMAND gzip -9nf ${changelog} COMMAND_ERROR_IS_FATAL ANY)
  set(doc ${CMAKE_INSTALL_DATADIR}/doc/${package})
  install(FILES ${changelog}.gz DESTINATION ${doc} COMPONENT ${lower})
  install(FILES ${CMAKE_BINARY_DIR}/debian/copyright DESTINATION ${doc} COMPONENT ${lower})
  set(overrides scripts/debian/${package}.lintian-overrides)
  if(EXISTS ${CMAKE_SOURCE_DIR}/${overrides})
    install(FILES ${overrides} DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides RENAME ${package} COMPONENT ${lower})
  endif()
endforeach()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME crsm-slam)
set(CPACK_PACKAGE_CONTACT ${CRSM_MAINTAINER})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
    WORLD_READ WORLD_EXECUTE)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL programs runtime development python)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS_POLICY ">=")  # the test `abi` sees to it that a later library fits
set(CPACK_DEBIAN_ENABLE_COMPONENT_DEPENDS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)

# ---- and what belongs to one
set(CPACK_COMPONENT_DEVELOPMENT_DEPENDS runtime)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SECTION science)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
math(EXPR NEXT_PYTHON "${Python_VERSION_MINOR} + 1")
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= 3.${Python_VERSION_MINOR}), python3 (<< 3.${NEXT_PYTHON}), python3-numpy")
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS crsm-slam)  # python3 -m crsm_slam
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS python3-matplotlib)
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_DEPENDS iproute2)  # crsm_bus.service
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_SUGGESTS "liblcm-bin, liblcm-java, default-jre")  # lcm-spy
set(CPACK_DEBIAN_PROGRAMS_PACKAGE_CONTROL_EXTRA
    "${CMAKE_SOURCE_DIR}/scripts/debian/postinst;${CMAKE_SOURCE_DIR}/scripts/debian/prerm;${CMAKE_SOURCE_DIR}/scripts/debian/postrm")
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA
    "${CMAKE_SOURCE_DIR}/scripts/debian/python/postinst;${CMAKE_SOURCE_DIR}/scripts/debian/python/prerm")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_CONTROL_EXTRA "${CMAKE_SOURCE_DIR}/scripts/debian/triggers")
# Below the project's own description.
set(CPACK_COMPONENT_PROGRAMS_DESCRIPTION "These programs make a map of a building and localise a robot in it, from the
scans of a planar laser, without odometry. They are processes that exchange LCM
messages. run_stack starts all of them, slam_offline does the same in one
process, and map_viewer shows the map in a browser. The package also contains
units for systemd, and types and views for lcm-spy.")
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION "This is the shared library for other programs. It needs the scans of a planar
laser, but neither odometry nor middleware.")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "This package is for developers. It contains the header, a CMake package, a
pkg-config file and the static library of CRSM SLAM. It also contains the types
of its LCM messages, and their Python code from lcm-gen.")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "This package is the library for Python: maps, poses and verdicts as NumPy
arrays, from arrays of ranges or from logs and bags.")
include(CPack)
