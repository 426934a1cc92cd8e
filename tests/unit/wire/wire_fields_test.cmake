# cmake -P wire_fields_test.cmake [FILE.lcm]: a count whose comment does not say how many there may be stops the build, and
# so does a line that is no field. With FILE: what is to be stopped.
cmake_minimum_required(VERSION 3.22)
include(${CMAKE_CURRENT_LIST_DIR}/../../../scripts/cmake/wire_fields.cmake)
set(folder ${CMAKE_CURRENT_BINARY_DIR}/wire_fields_test)
if(CMAKE_ARGC GREATER 3)
  crsm_make_wire_fields(${CMAKE_ARGV3} ${folder})
  return()
endif()

function(check_refused field expected)
  file(WRITE ${folder}/a_t.lcm "package crsm;\nstruct a_t\n{\n    ${field}\n    byte cells[num_cells];\n}\n")
  execute_process(COMMAND ${CMAKE_COMMAND} -P ${CMAKE_CURRENT_FUNCTION_LIST_FILE} ${folder}/a_t.lcm
                  RESULT_VARIABLE result ERROR_VARIABLE error)
  if(result EQUAL 0 OR NOT error MATCHES "${expected}")
    message(FATAL_ERROR "${field}: exit code ${result}, ${error}")
  endif()
endfunction()

check_refused("int32_t num_cells;  // how many" "lcmtypes/a_t.lcm: the comment of num_cells must")
check_refused("int32_t num_cells" "lcmtypes/a_t.lcm: cannot read")

file(WRITE ${folder}/a_t.lcm "package crsm;\nstruct a_t\n{\n    int32_t num_cells;  // of a map,\n      // 0 to 9\n"
     "    byte cells[num_cells];\n    robot.b_t b[2];  // two\n    const int8_t ONE = 1;\n}\n")
crsm_make_wire_fields(${folder}/a_t.lcm ${folder})
file(READ ${folder}/wire_fields/crsm/a_t.hpp header)
foreach(expected "visit(&T::num_cells)" "visit(Array(&T::cells, &T::num_cells, 9))" "visit(&T::b)" "#include <wire_fields/robot/b_t.hpp>")
  string(FIND "${header}" "${expected}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "${expected} is not in ${header}")
  endif()
endforeach()
