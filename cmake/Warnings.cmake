# Target bgsim_warnings: what every source of this project is compiled with. Errors in a checkout that is worked on;
# scripts/bgsim switches that off, so that a newer compiler's new warning keeps nobody from running a model.
option(BGSIM_WARNINGS_AS_ERRORS "Compiler warnings are errors" ON)
add_library(bgsim_warnings INTERFACE)
target_compile_options(bgsim_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wsign-conversion $<$<BOOL:${BGSIM_WARNINGS_AS_ERRORS}>:-Werror>)
# In a unit of many sources Clang takes a local name for one that hides another source's; GCC does so for functions alone.
if(BGSIM_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  target_compile_options(bgsim_warnings INTERFACE -Wno-shadow)
endif()
# GCC 12 warns falsely about overlapping copies inside std::string when it optimises (GCC bug 105651, mended in 13).
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # clang-tidy reads the same flags and does not know this one.
  target_compile_options(bgsim_warnings INTERFACE -Wno-unknown-warning-option -Wno-restrict)
endif()
