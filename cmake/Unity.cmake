# unite_folders(TARGET SOURCE...): the sources of a stage (engine/src/STAGE) or of the cli become one translation unit, so
# that headers are parsed, and the inline functions of libraries compiled, once for each and not once for each source
# (docs/design/build.md). A source with compile options of its own stays by itself; CMake sees to that. Runs make two units,
# since one took as long as all others together on four cores; the matrices of Radau, a fifth of that one, are by themselves.
function(unite_folders target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  foreach(source IN LISTS ARGN)
    cmake_path(RELATIVE_PATH source BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} OUTPUT_VARIABLE file)
    string(REGEX MATCH "^(engine/src/)?[^/]+" folder ${file})
    if(file MATCHES "^engine/src/run/(watch|sink|measure)/")
      string(APPEND folder "/watch")
    endif()
    string(MAKE_C_IDENTIFIER ${folder} group)
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
  endforeach()
  set_source_files_properties(engine/src/run/integrate/radau_systems.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()
