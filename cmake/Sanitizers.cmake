# BGSIM_SANITIZE=address,undefined instruments everything that is built here. The first finding ends the process.
set(BGSIM_SANITIZE "" CACHE STRING "Sanitizers, as -fsanitize= takes them")
if(BGSIM_SANITIZE)
  add_compile_options(-fsanitize=${BGSIM_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  # GCC's flow analysis loses track among the instrumentation (its manual says so) and warns falsely inside <regex>; the
  # dev build has the same warning on the same sources. Clang has no such warning.
  add_compile_options($<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
  add_link_options(-fsanitize=${BGSIM_SANITIZE})
endif()
