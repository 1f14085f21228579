# Where npm cannot fetch uPlot, the project is configured all the same, with a warning, and the page's assets lack it.
#   cmake -D SOURCE_DIR=... -D WORK_DIR=... -D GENERATOR=... -D COMPILER=... -P without_npm.cmake
file(REMOVE_RECURSE ${WORK_DIR})
# CMake itself is used as an npm that fails: it knows no command "ci".
execute_process(
  COMMAND ${CMAKE_COMMAND} -S ${SOURCE_DIR} -B ${WORK_DIR} -G ${GENERATOR} -D CMAKE_CXX_COMPILER=${COMPILER}
    -D BGSIM_TESTS=OFF -D NPM=${CMAKE_COMMAND}
  RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
if(NOT status EQUAL 0)
  message(FATAL_ERROR "the project cannot be configured without npm:\n${output}")
endif()
if(NOT output MATCHES "bgsim is built without uPlot")
  message(FATAL_ERROR "no word that uPlot is missing:\n${output}")
endif()
file(READ ${WORK_DIR}/web/assets.cpp assets)
if(NOT assets MATCHES "kUplotScript = R\"~uplot~\\(\\)~uplot~\"")
  message(FATAL_ERROR "the assets hold a uPlot that nobody fetched")
endif()
