# find_package(bgsim): target bgsim::bgsim, the engine as a static library with its headers.
include("${CMAKE_CURRENT_LIST_DIR}/BgsimSundials.cmake")
include("${CMAKE_CURRENT_LIST_DIR}/bgsimTargets.cmake")
