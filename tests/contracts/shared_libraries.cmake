# Asserts that BINARY loads only the C and C++ runtime: SUNDIALS, KLU and whatever they would drag in are inside.
execute_process(COMMAND ldd ${BINARY} OUTPUT_VARIABLE listing ERROR_VARIABLE complaint RESULT_VARIABLE failed)
if(failed AND complaint MATCHES "not a dynamic executable") # a release, which loads nothing
  return()
elseif(failed)
  message(FATAL_ERROR "ldd ${BINARY}: ${complaint}")
endif()
string(REGEX MATCHALL "[^\n]+" lines "${listing}")
foreach(line IN LISTS lines)
  if(NOT line MATCHES "linux-vdso|ld-linux|libc\\.so|libm\\.so|libgcc_s\\.so|libstdc\\+\\+\\.so|libpthread\\.so")
    message(FATAL_ERROR "${BINARY} loads a further library:\n${line}")
  endif()
endforeach()
