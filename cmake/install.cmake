# `cmake --install` puts materials, scene, deform and render where find_package(maille) finds them, and the command
# where it was built. fem_ref and studies are programs' parts, not a library that others link.
include(CMakePackageConfigHelpers)

install(TARGETS maille_materials maille_scene maille_deform maille_render EXPORT maille
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
if(TARGET maille_command)
  install(TARGETS maille_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
install(DIRECTORY scene/scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/maille)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/maille)
install(EXPORT maille NAMESPACE maille:: DESTINATION ${package_folder})
configure_package_config_file(cmake/maille-config.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/maille-config.cmake
  INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/maille-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/maille-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/maille-config-version.cmake
  DESTINATION ${package_folder})
