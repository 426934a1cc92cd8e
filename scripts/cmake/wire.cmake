# The wire: C++ types made from lcmtypes/ at build time, and their Python code.
find_program(LCM_GEN lcm-gen REQUIRED)
# LCM's lcm.pc asks for the headers of GLib, 90 MB that nothing here includes.
find_path(LCM_INCLUDE_DIR lcm/lcm_coretypes.h REQUIRED)

file(GLOB LCM_FILES CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/lcmtypes/*.lcm)
set(LCM_HEADERS ${PROJECT_BINARY_DIR}/lcmtypes)
set(LCM_PYTHON ${PROJECT_BINARY_DIR}/python)  # for scripts/examples, and whoever writes a process in Python
add_custom_command(
  OUTPUT ${LCM_HEADERS}/stamp
  COMMAND ${LCM_GEN} --cpp --cpp-std=c++11 --cpp-hpath ${LCM_HEADERS} ${LCM_FILES}
  COMMAND ${LCM_GEN} --python --ppath ${LCM_PYTHON} ${LCM_FILES}
  COMMAND ${CMAKE_COMMAND} -E touch ${LCM_HEADERS}/stamp
  DEPENDS ${LCM_FILES}
  COMMENT "lcm-gen")
add_custom_target(crsm_lcmtypes_gen DEPENDS ${LCM_HEADERS}/stamp)
add_library(crsm_lcmtypes INTERFACE)
add_dependencies(crsm_lcmtypes crsm_lcmtypes_gen)
target_include_directories(crsm_lcmtypes SYSTEM INTERFACE ${LCM_HEADERS} ${LCM_INCLUDE_DIR})
# -pthread as lcm.pc says: LCM has threads. LCM's header decodes a float as an int32_t: a compiler that believes in types
# takes such a field for what it was before.
target_compile_options(crsm_lcmtypes INTERFACE -pthread -fno-strict-aliasing)

include(${PROJECT_SOURCE_DIR}/scripts/cmake/wire_fields.cmake)
foreach(lcm_file ${LCM_FILES})
  crsm_make_wire_fields(${lcm_file} ${PROJECT_BINARY_DIR}/generated)
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${lcm_file})
endforeach()
