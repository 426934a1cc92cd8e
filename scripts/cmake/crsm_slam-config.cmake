# find_package(crsm_slam): crsm_slam::crsm_slam is the shared library, crsm_slam::crsm_slam_static the static one. Neither
# needs another package.
include(${CMAKE_CURRENT_LIST_DIR}/crsm_slam-targets.cmake)
