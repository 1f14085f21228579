# SUNDIALS 6 and KLU as static archives: target bgsim::sundials.
#
# SUNDIALS' own package config is not used: its static solvers name shared ones as their dependencies, and loading it
# searches for OpenMP, MPI and PETSc, which bgsim does not need. Linked this way, a bgsim binary needs nothing but the
# C++ runtime. This file serves the build and, installed beside the package config, whoever links the library.
if(TARGET bgsim::sundials)
  return()
endif()

find_path(BGSIM_SUNDIALS_INCLUDE_DIR cvode/cvode.h)
find_path(BGSIM_KLU_INCLUDE_DIR klu.h PATH_SUFFIXES suitesparse)
mark_as_advanced(BGSIM_SUNDIALS_INCLUDE_DIR BGSIM_KLU_INCLUDE_DIR)
set(_bgsim_missing "")
if(NOT BGSIM_SUNDIALS_INCLUDE_DIR)
  list(APPEND _bgsim_missing "cvode/cvode.h")
endif()
if(NOT BGSIM_KLU_INCLUDE_DIR)
  list(APPEND _bgsim_missing "klu.h")
endif()

set(_bgsim_archives "")
foreach(_bgsim_name IN ITEMS
    sundials_cvode sundials_arkode sundials_ida sundials_sunlinsolklu sundials_sunlinsoldense sundials_sunmatrixsparse
    sundials_sunmatrixdense sundials_nvecserial klu amd colamd btf suitesparseconfig)
  find_library(BGSIM_${_bgsim_name}_ARCHIVE NAMES lib${_bgsim_name}.a)
  mark_as_advanced(BGSIM_${_bgsim_name}_ARCHIVE)
  if(BGSIM_${_bgsim_name}_ARCHIVE)
    list(APPEND _bgsim_archives "${BGSIM_${_bgsim_name}_ARCHIVE}")
  else()
    list(APPEND _bgsim_missing "lib${_bgsim_name}.a")
  endif()
endforeach()
if(_bgsim_missing)
  list(JOIN _bgsim_missing ", " _bgsim_missing)
  message(FATAL_ERROR "bgsim needs SUNDIALS 6 and KLU as static libraries; not found: ${_bgsim_missing} "
                      "(Debian: apt-get install libsundials-dev libsuitesparse-dev)")
endif()

file(STRINGS "${BGSIM_SUNDIALS_INCLUDE_DIR}/sundials/sundials_config.h" _bgsim_version
     REGEX "^#define SUNDIALS_VERSION_MAJOR ")
if(NOT _bgsim_version MATCHES " 6$")
  message(FATAL_ERROR "bgsim needs SUNDIALS 6; ${BGSIM_SUNDIALS_INCLUDE_DIR} says: ${_bgsim_version}")
endif()

add_library(bgsim::sundials INTERFACE IMPORTED)
set_target_properties(bgsim::sundials PROPERTIES
  INTERFACE_INCLUDE_DIRECTORIES "${BGSIM_SUNDIALS_INCLUDE_DIR};${BGSIM_KLU_INCLUDE_DIR}"
  INTERFACE_LINK_LIBRARIES "${_bgsim_archives};m")
unset(_bgsim_missing)
unset(_bgsim_archives)
unset(_bgsim_version)
unset(_bgsim_name)
