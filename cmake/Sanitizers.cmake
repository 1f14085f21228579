# BGSIM_SANITIZE=address,undefined instruments the engine and the command, by linking bgsim_sanitizers. The first finding
# ends the process. Tests are not instrumented: their code takes longest to compile, and is linked with the release, too.
set(BGSIM_SANITIZE "" CACHE STRING "Sanitizers, as -fsanitize= takes them")
add_library(bgsim_sanitizers INTERFACE)
if(BGSIM_SANITIZE)
  target_compile_options(bgsim_sanitizers INTERFACE -fsanitize=${BGSIM_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  if(BGSIM_SANITIZE MATCHES undefined)
    # What the address sanitizer finds as well (a null pointer, a place outside of an object) or the engine has no use for
    # (no pointer is cast) is a third of the compile time. A double that an integer does not hold is not in `undefined`.
    target_compile_options(bgsim_sanitizers INTERFACE
      -fno-sanitize=null,alignment,object-size,vptr,pointer-overflow,nonnull-attribute,returns-nonnull-attribute
      -fsanitize=float-cast-overflow)
  endif()
  # Under the address sanitizer Eigen would align memory by itself, and could not free what a test has allocated.
  target_compile_definitions(bgsim_sanitizers INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
  # GCC's flow analysis loses track among the instrumentation (its manual says so) and warns falsely inside <regex>; the
  # dev build has the same warning on the same sources. Clang has no such warning.
  target_compile_options(bgsim_sanitizers INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
endif()
