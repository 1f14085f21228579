# unite_folders(TARGET SOURCE...): the sources of a stage (engine/src/STAGE), of several small ones or of the cli become one
# translation unit, so that headers are parsed, and the inline functions of libraries compiled, once for each and not once
# for each source (docs/design/build.md). A source with compile options of its own stays by itself; CMake sees to that. Runs
# make two units, since one took as long as all others together on four cores; Radau's matrices, a fifth of that one, are by
# themselves; so are the decompositions of linear analysis. Of the stages that runs go through, what is done once a run
# (bgsim_cold) shares units with others.
set(unit_of_base first)
set(unit_of_expression first)
set(unit_of_model first)
set(unit_of_units first)
set(unit_of_scene first)
set(unit_of_graph middle)
set(unit_of_equations middle)
set(unit_of_draw middle)
set(unit_of_describe middle)
set(unit_of_program once)
set(unit_of_run once)
set(cold_unit_of_study once)
set(hot_unit_of_base evaluation)
set(hot_unit_of_expression evaluation)
set(hot_unit_of_program evaluation)
# A unit fills more memory than GCC likes to see used, and a twentieth of its time goes into searching it for what can be freed.
# Where all that are compiled at a time (Ninja: two more than there are cores) find 2 GB each, it need not search.
if(BGSIM_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  cmake_host_system_information(RESULT cores QUERY NUMBER_OF_LOGICAL_CORES)
  cmake_host_system_information(RESULT memory QUERY TOTAL_PHYSICAL_MEMORY) # in MiB
  math(EXPR wanted "2048 * (${cores} + 2)")
  if(memory GREATER wanted)
    add_compile_options(--param=ggc-min-heapsize=1000000)
  endif()
endif()
function(unite_folders target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  foreach(source IN LISTS ARGN)
    cmake_path(RELATIVE_PATH source BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} OUTPUT_VARIABLE file)
    string(REGEX REPLACE "^(engine/src/)?([^/]+)/.*" "\\2" group ${file})
    if(NOT target STREQUAL bgsim_hot)
      if(DEFINED unit_of_${group})
        set(group ${unit_of_${group}})
      elseif(target STREQUAL bgsim_cold AND DEFINED cold_unit_of_${group})
        set(group ${cold_unit_of_${group}})
      endif()
    elseif(file MATCHES "^engine/src/run/(watch|sink)/")
      set(group watch)
    elseif(DEFINED hot_unit_of_${group})
      set(group ${hot_unit_of_${group}})
    endif()
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
  endforeach()
  set_source_files_properties(engine/src/run/integrate/radau_systems.cpp engine/src/linear/eigenvalues.cpp engine/src/linear/sparse_eigenvalues.cpp
    PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()
