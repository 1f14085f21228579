# The tests of one program in groups, since a start under the sanitizers takes longer than most tests.
#   cmake -D PROGRAM=... -D SPEC=... -D LABEL=... -D ENVIRONMENT=... -D FILES=... -P groups.cmake
# writes FILES.cmake for ctest, and the names of each group beside it.
#   cmake -D PROGRAM=... -D NAMES=... -D COUNT=... -P groups.cmake
# runs one group: it passes if so many tests were run, and all passed.
if(NAMES)
  execute_process(COMMAND ${PROGRAM} --input-file ${NAMES} RESULT_VARIABLE status OUTPUT_VARIABLE output ERROR_VARIABLE output)
  message("${output}")
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${PROGRAM} --input-file ${NAMES} ended with ${status}")
  endif()
  if(NOT output MATCHES "All tests passed \\([0-9]+ assertions? in ${COUNT} test cases?\\)")
    message(FATAL_ERROR "${PROGRAM} --input-file ${NAMES} has not run ${COUNT} tests")
  endif()
  return()
endif()

execute_process(COMMAND ${PROGRAM} --list-test-names-only ${SPEC} OUTPUT_VARIABLE names)
foreach(character "\\" "," "[" "]") # as Catch2 wants them in a name
  string(REPLACE "${character}" "\\${character}" names "${names}")
endforeach()
set(tests "")
set(group 0)
while(NOT names STREQUAL "")
  math(EXPR group "${group} + 1")
  set(lines "")
  set(count 0)
  while(NOT names STREQUAL "" AND count LESS 10)
    string(FIND "${names}" "\n" end)
    math(EXPR end "${end} + 1") # each name ends its line
    string(SUBSTRING "${names}" 0 ${end} name)
    string(SUBSTRING "${names}" ${end} -1 names)
    string(APPEND lines "${name}")
    math(EXPR count "${count} + 1")
  endwhile()
  file(WRITE ${FILES}_${group}.txt "${lines}")
  string(APPEND tests "add_test([==[${LABEL}: group ${group}]==] [==[${CMAKE_COMMAND}]==] [==[-DPROGRAM=${PROGRAM}]==] "
    "[==[-DNAMES=${FILES}_${group}.txt]==] -DCOUNT=${count} -P [==[${CMAKE_CURRENT_LIST_FILE}]==])\n"
    "set_tests_properties([==[${LABEL}: group ${group}]==] PROPERTIES LABELS [==[${LABEL}]==] ENVIRONMENT [==[${ENVIRONMENT}]==])\n")
endwhile()
file(WRITE ${FILES}.cmake "${tests}")
