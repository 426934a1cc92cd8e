# find_package(crsm_slam): crsm_slam::crsm_slam is the shared library, crsm_slam::crsm_slam_static the static one. Neither
# needs more than the threads of the system.
include(CMakeFindDependencyMacro)
find_dependency(Threads)
include(${CMAKE_CURRENT_LIST_DIR}/crsm_slam-targets.cmake)
