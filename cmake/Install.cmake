# cmake --install: the command, the library with its headers, and the package config that find_package(bgsim) reads.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(bgsim_config_dir ${CMAKE_INSTALL_LIBDIR}/cmake/bgsim)

install(TARGETS bgsim EXPORT bgsimTargets ARCHIVE INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
if(TARGET bgsim_cli)
  install(TARGETS bgsim_cli RUNTIME)
endif()
install(DIRECTORY engine/include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(EXPORT bgsimTargets NAMESPACE bgsim:: DESTINATION ${bgsim_config_dir})
write_basic_package_version_file(bgsimConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES cmake/bgsimConfig.cmake cmake/BgsimSundials.cmake ${CMAKE_CURRENT_BINARY_DIR}/bgsimConfigVersion.cmake
        DESTINATION ${bgsim_config_dir})
