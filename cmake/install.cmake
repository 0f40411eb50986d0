# `cmake --install` puts materials, scene, deform and render where find_package(maille) finds them (component development), and the command with
# its plugins where they find each other (component command). fem_ref and studies are programs' parts, not a library that others link.
include(CMakePackageConfigHelpers)

install(TARGETS maille_plugins maille_materials maille_images maille_scene maille_mechanics maille_warp maille_bodies maille_deform maille_render EXPORT maille
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development
  FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT development)
if(TARGET maille_command)
  maille_runpath(maille_command "$ORIGIN/${from_programs_to_plugins}" "$ORIGIN/plugins")
  install(TARGETS maille_command RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT command)
endif()
install(DIRECTORY scene/scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/maille COMPONENT command)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/maille)
install(EXPORT maille NAMESPACE maille:: DESTINATION ${package_folder} COMPONENT development)
configure_package_config_file(cmake/maille-config.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/maille-config.cmake
  INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/maille-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/maille-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/maille-config-version.cmake
  DESTINATION ${package_folder} COMPONENT development)

# Pages of the manual and completions of shells (studies/CMakeLists.txt), keys for editors, what ParaView runs.
if(TARGET maille_command)
  install(DIRECTORY ${PROJECT_BINARY_DIR}/share/ DESTINATION ${CMAKE_INSTALL_DATADIR} COMPONENT command)
  install(FILES ${PROJECT_SOURCE_DIR}/docs/scene.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/maille COMPONENT command)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/scripts/paraview DESTINATION ${CMAKE_INSTALL_DATADIR}/maille COMPONENT command)
  # The pages that help speaks of, where links between them find each other.
  install(FILES README.md NOTATION.md CHANGELOG.md CONTRIBUTING.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/maille COMPONENT command)
  install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/maille COMPONENT command)
  install(DIRECTORY python/examples DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/maille/python COMPONENT command)
endif()
