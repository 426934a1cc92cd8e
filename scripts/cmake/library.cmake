# The library: the algorithm alone, which needs Eigen to compile and nothing to run. What it shows of itself is
# common/library/crsm_slam/slam.hpp.
include(GNUInstallDirs)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(Threads REQUIRED)

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
configure_file(${PROJECT_SOURCE_DIR}/common/library/presets.hpp.in
               ${PROJECT_BINARY_DIR}/generated/common/library/presets.hpp @ONLY)

set(LIBRARY_ROOMS math scan map match graph library)
list(TRANSFORM LIBRARY_ROOMS REPLACE "(.+)" "${PROJECT_SOURCE_DIR}/common/\\1/*.cpp" OUTPUT_VARIABLE LIBRARY_GLOBS)
file(GLOB LIBRARY_SOURCES CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/common/*.cpp ${LIBRARY_GLOBS})
# What only programs say: it would need fmt.
list(FILTER LIBRARY_SOURCES EXCLUDE REGEX "/(laser_judge|thin_beams|g2o)\\.cpp$")

add_library(crsm_slam_objects OBJECT ${LIBRARY_SOURCES})
target_compile_features(crsm_slam_objects PUBLIC cxx_std_20)
target_include_directories(crsm_slam_objects PRIVATE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/common/library
                           ${PROJECT_BINARY_DIR}/generated)
target_link_libraries(crsm_slam_objects PRIVATE Eigen3::Eigen Threads::Threads)
target_compile_definitions(crsm_slam_objects PRIVATE CRSM_SLAM_VERSION="${PROJECT_VERSION}")
# No contraction into fused multiply-adds: the same map on every x86-64 machine.
target_compile_options(crsm_slam_objects PRIVATE -ffp-contract=off)
set_target_properties(crsm_slam_objects PROPERTIES POSITION_INDEPENDENT_CODE ON CXX_EXTENSIONS OFF
                      CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)

function(crsm_library name)
  add_library(${name} ${ARGN} $<TARGET_OBJECTS:crsm_slam_objects>)
  add_library(crsm_slam::${name} ALIAS ${name})
  target_compile_features(${name} PUBLIC cxx_std_20)
  target_link_libraries(${name} PRIVATE Threads::Threads)
  target_include_directories(${name} INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/common/library>
                             $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  set_target_properties(${name} PROPERTIES LINKER_LANGUAGE CXX OUTPUT_NAME crsm_slam
                        VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR})
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
