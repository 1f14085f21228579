# Asserts that BINARY loads only the C and C++ runtime: SUNDIALS, KLU and whatever they would drag in are inside.
execute_process(COMMAND ldd ${BINARY} OUTPUT_VARIABLE listing COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "[^\n]+" lines "${listing}")
foreach(line IN LISTS lines)
  if(NOT line MATCHES "linux-vdso|ld-linux|libc\\.so|libm\\.so|libgcc_s\\.so|libstdc\\+\\+\\.so|libpthread\\.so")
    message(FATAL_ERROR "${BINARY} loads a further library:\n${line}")
  endif()
endforeach()
