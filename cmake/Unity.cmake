# unite_folders(TARGET SOURCE...): the sources of a stage (engine/src/STAGE) or of the cli become one translation unit, so
# that headers are parsed, and the inline functions of libraries compiled, once for each and not once for each source
# (docs/design/build.md). A source with compile options of its own stays by itself; CMake sees to that.
function(unite_folders target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  foreach(source IN LISTS ARGN)
    cmake_path(RELATIVE_PATH source BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} OUTPUT_VARIABLE file)
    string(REGEX MATCH "^(engine/src/)?[^/]+" folder ${file})
    string(MAKE_C_IDENTIFIER ${folder} group)
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
  endforeach()
endfunction()
