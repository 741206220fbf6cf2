# Install and export: find_package(Sextant) gives the targets sextant::core, sextant::control, …
include(CMakePackageConfigHelpers)

foreach(folder ${SEXTANT_FOLDERS})
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/sextant/${folder} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/sextant)
endforeach()
if(NOT SEXTANT_HEADER_ONLY)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/configs DESTINATION ${CMAKE_INSTALL_DATADIR}/sextant)
endif()
install(TARGETS sextant_flags EXPORT SextantTargets)
install(EXPORT SextantTargets NAMESPACE sextant:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/Sextant)

configure_package_config_file(
  ${PROJECT_SOURCE_DIR}/cmake/SextantConfig.cmake.in ${PROJECT_BINARY_DIR}/SextantConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/Sextant)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/SextantConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/SextantConfig.cmake ${PROJECT_BINARY_DIR}/SextantConfigVersion.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/Sextant)
