# What cmake --install installs, in four components: programs, runtime (the shared library), development (what
# links with it), python.
include(CMakePackageConfigHelpers)
if(HARDENED)
  install(CODE "set(CMAKE_INSTALL_DO_STRIP ON)" ALL_COMPONENTS)  # as cmake --install --strip
endif()

# ---- programs, and the services' units for systemd
install(TARGETS ${PROGRAMS} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT programs)
install(DIRECTORY scripts/systemd/ DESTINATION lib/systemd/system COMPONENT programs PATTERN README.md EXCLUDE)
# bash-completion looks for a file of the program's name.
set(COMPLETIONS ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES scripts/completion.bash DESTINATION ${COMPLETIONS} RENAME crsm-slam COMPONENT programs)
file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/completions)
foreach(program ${PROGRAMS})
  file(CREATE_LINK crsm-slam ${CMAKE_BINARY_DIR}/completions/${program} SYMBOLIC)
endforeach()
install(DIRECTORY ${CMAKE_BINARY_DIR}/completions/ DESTINATION ${COMPLETIONS} COMPONENT programs)

# ---- the library
install(TARGETS crsm_slam EXPORT crsm_slam-targets
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT runtime NAMELINK_COMPONENT development)
install(TARGETS crsm_slam_static EXPORT crsm_slam-targets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
install(DIRECTORY services/library/crsm_slam DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
set(CMAKE_PACKAGE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/crsm_slam)
install(EXPORT crsm_slam-targets NAMESPACE crsm_slam:: DESTINATION ${CMAKE_PACKAGE_DIR} COMPONENT development)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/crsm_slam-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES scripts/cmake/crsm_slam-config.cmake ${CMAKE_BINARY_DIR}/crsm_slam-config-version.cmake
        DESTINATION ${CMAKE_PACKAGE_DIR} COMPONENT development)
configure_file(scripts/cmake/crsm_slam.pc.in ${CMAKE_BINARY_DIR}/crsm_slam.pc @ONLY)
install(FILES ${CMAKE_BINARY_DIR}/crsm_slam.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT development)

# ---- the Python package
if(TARGET crsm_python)
  if(CRSM_PACKAGES)
    set(PYTHON_DESTINATION lib/python3/dist-packages/crsm_slam)  # as Debian's rules for packages say
  else()
    set(PYTHON_DESTINATION lib/python${Python_VERSION_MAJOR}.${Python_VERSION_MINOR}/dist-packages/crsm_slam)
  endif()
  install(TARGETS crsm_python LIBRARY DESTINATION ${PYTHON_DESTINATION} COMPONENT python)
  install(FILES ${PYTHON_FILES} DESTINATION ${PYTHON_DESTINATION} COMPONENT python)
endif()

# ---- the wire: the types, and what lcm-gen made of them for Python
install(FILES ${LCM_FILES} DESTINATION ${CMAKE_INSTALL_DATADIR}/crsm_slam/lcmtypes COMPONENT development)
install(DIRECTORY ${LCM_PYTHON}/ DESTINATION ${CMAKE_INSTALL_DATADIR}/crsm_slam/python COMPONENT development
        PATTERN crsm_slam EXCLUDE PATTERN __pycache__ EXCLUDE)

if(CRSM_PACKAGES)
  include(scripts/cmake/packages.cmake)
endif()
