# How everything here is compiled: warnings, sanitizers, hardening.

# No contraction into fused multiply-adds: the same seed gives the same map on every x86-64 machine.
add_compile_options(-Wall -Wextra -Wpedantic -Wconversion -Wshadow -ffp-contract=off)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  add_compile_options(-Wno-restrict)  # false alarms on std::string, gcc bug 105651
endif()
if(CRSM_WARNINGS_AS_ERRORS)
  add_compile_options(-Werror)
endif()
if(CRSM_SANITIZERS)
  # Without vptr: it takes the subscriptions of LCM's C++ header for objects of a wrong type.
  add_compile_options(-fsanitize=${CRSM_SANITIZERS} -fno-sanitize=vptr -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_link_options(-fsanitize=${CRSM_SANITIZERS})
endif()

# One compile for programs and for the Python module, which shows of itself only what Python asks for.
if(NOT CRSM_SANITIZERS)
  set(CMAKE_POSITION_INDEPENDENT_CODE ON)
  set(CMAKE_CXX_VISIBILITY_PRESET hidden)
  set(CMAKE_VISIBILITY_INLINES_HIDDEN ON)
endif()

# Hardening of what is installed: release builds only, because the sanitizers bring guards of their own and FORTIFY needs
# an optimiser. Stack protector, checked calls of the C library, addresses that change from run to run, and tables of
# the linker that nobody can write once the program runs. What it costs: scripts/bench --instructions.
if(CMAKE_BUILD_TYPE STREQUAL Release AND NOT CRSM_SANITIZERS)
  set(HARDENED ON)
  set(FORTIFY_LEVEL 2)
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND NOT CMAKE_CXX_COMPILER_VERSION VERSION_LESS 12)
    set(FORTIFY_LEVEL 3)
  endif()
  add_compile_options(-fstack-protector-strong -U_FORTIFY_SOURCE -D_FORTIFY_SOURCE=${FORTIFY_LEVEL})
  add_link_options($<$<STREQUAL:$<TARGET_PROPERTY:TYPE>,EXECUTABLE>:-pie> -Wl,-z,relro,-z,now)
endif()
