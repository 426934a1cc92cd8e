# The algorithm, which is compiled once for the library and for the programs here, and the library: the algorithm, the
# journal and the files of results, which need the headers of Eigen, fmt, nlohmann-json and LCM to compile, and nothing to
# run. What it shows of itself is services/library/crsm_slam/slam.hpp.
include(GNUInstallDirs)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(fmt REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(Threads REQUIRED)
include(${CMAKE_CURRENT_LIST_DIR}/wire.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/unity.cmake)

# Sets `variable` to entries of {name, key, text}, one for each line `key = value` of the files that match `pattern`.
function(crsm_embed_values variable pattern)
  set(entries "")
  file(GLOB files CONFIGURE_DEPENDS "${pattern}")
  foreach(path ${files})
    get_filename_component(name ${path} NAME_WE)
    file(STRINGS ${path} lines REGEX "^[a-z]")
    foreach(line ${lines})
      if(NOT line MATCHES "^([a-z0-9_]+) = \"?([^ #\"]+)\"?( *#.*)?$")
        message(FATAL_ERROR "${path}: '${line}' must be a key, ' = ' and a value of one word")
      endif()
      string(APPEND entries "    {\"${name}\", \"${CMAKE_MATCH_1}\", \"${CMAKE_MATCH_2}\"},\n")
    endforeach()
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${path})
  endforeach()
  set(${variable} "${entries}" PARENT_SCOPE)
endfunction()

crsm_embed_values(PRESET_VALUES "${PROJECT_SOURCE_DIR}/scripts/presets/*.toml")
crsm_embed_values(PROFILE_VALUES "${PROJECT_SOURCE_DIR}/scripts/profiles/*.toml")
configure_file(${PROJECT_SOURCE_DIR}/services/library/presets.hpp.in
               ${PROJECT_BINARY_DIR}/generated/services/library/presets.hpp @ONLY)
configure_file(${PROJECT_SOURCE_DIR}/services/base/version.hpp.in
               ${PROJECT_BINARY_DIR}/generated/services/base/version.hpp @ONLY)

set(ALGORITHM_ROOMS math scan map match match/guess match/fit match/search match/judge graph marks)
list(TRANSFORM ALGORITHM_ROOMS REPLACE "(.+)" "${PROJECT_SOURCE_DIR}/common/\\1/*.cpp" OUTPUT_VARIABLE ALGORITHM_GLOBS)
file(GLOB ALGORITHM_SOURCES CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/common/slam.cpp ${ALGORITHM_GLOBS})
add_library(crsm_algorithm OBJECT ${ALGORITHM_SOURCES})

# Of other rooms what knows nothing of programs.
file(GLOB LIBRARY_SOURCES CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/services/library/*.cpp)
set(LIBRARY_FILES common/parameters common/diagnosis/format_changes common/diagnosis/handedness common/diagnosis/run_statistics
    common/diagnosis/self_contradiction common/diagnosis/verdict common/logs/crc32 common/logs/map_files
    common/logs/map_picture common/logs/png_file common/logs/regular_file common/logs/replacement common/metrics/format_trajectory
    common/results/mark_files common/results/result_files common/results/run_origin common/results/summary services/base/file_window
    services/base/identity services/base/path_lock services/base/printable services/base/process_info services/base/say
    services/journal/journal services/journal/journal_file services/journal/journal_reader services/journal/move_aside
    services/journal/results_lock services/library/without_overview/overview services/wire/conversions
    services/wire/graph_messages services/wire/lcm_event services/wire/wire)
list(TRANSFORM LIBRARY_FILES REPLACE "(.+)" "${PROJECT_SOURCE_DIR}/\\1.cpp" OUTPUT_VARIABLE LIBRARY_FILES)

# Raised with every change after which programs must be linked anew. The test `abi` says when.
set(CRSM_SLAM_SOVERSION 1)

add_library(crsm_slam_objects OBJECT ${LIBRARY_SOURCES} ${LIBRARY_FILES})
target_include_directories(crsm_slam_objects PRIVATE ${PROJECT_SOURCE_DIR}/services/library
                           ${PROJECT_BINARY_DIR}/generated)
target_link_libraries(crsm_slam_objects PRIVATE fmt::fmt-header-only nlohmann_json::nlohmann_json crsm_lcmtypes)
target_compile_definitions(crsm_slam_objects PRIVATE CRSM_SLAM_VERSION="${PROJECT_VERSION}")
foreach(target crsm_algorithm crsm_slam_objects)
  target_compile_features(${target} PUBLIC cxx_std_20)
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR})
  target_link_libraries(${target} PRIVATE Eigen3::Eigen Threads::Threads)
  # No contraction into fused multiply-adds: the same map on every x86-64 machine.
  target_compile_options(${target} PRIVATE -ffp-contract=off)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_EXTENSIONS OFF
                        CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  crsm_unity(${target})
endforeach()
# fitness_kernel.cpp has helpers of the same names.
set_source_files_properties(${PROJECT_SOURCE_DIR}/common/match/fit/fitness_kernel_avx2.cpp
                            PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)

function(crsm_library name)
  add_library(${name} ${ARGN} $<TARGET_OBJECTS:crsm_algorithm> $<TARGET_OBJECTS:crsm_slam_objects>)
  add_library(crsm_slam::${name} ALIAS ${name})
  target_compile_features(${name} PUBLIC cxx_std_20)
  target_link_libraries(${name} PRIVATE Threads::Threads)
  target_include_directories(${name} INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/services/library>
                             $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  set_target_properties(${name} PROPERTIES LINKER_LANGUAGE CXX OUTPUT_NAME crsm_slam
                        VERSION ${PROJECT_VERSION} SOVERSION ${CRSM_SLAM_SOVERSION})
  get_target_property(type ${name} TYPE)
  if(type STREQUAL SHARED_LIBRARY)
    # Also what the compiler made of the standard library's templates is nobody else's.
    target_link_options(${name} PRIVATE -Wl,--version-script=${PROJECT_SOURCE_DIR}/scripts/cmake/library.map)
  endif()
endfunction()

# In another project it is what that project's BUILD_SHARED_LIBS says.
if(PROJECT_IS_TOP_LEVEL)
  crsm_library(crsm_slam SHARED)
  crsm_library(crsm_slam_static STATIC)
else()
  crsm_library(crsm_slam)
endif()
