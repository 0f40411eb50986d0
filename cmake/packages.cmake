# `cpack --config build/release/CPackConfig.cmake`: Debian packages of what is built (docs/install.md). A component of `install` is a package;
# those of what is not built here are left out.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME maille)
set(CPACK_PACKAGE_VENDOR "the Maille authors")
set(CPACK_PACKAGE_CONTACT "the Maille authors <maille@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
# Packages are of what stands there: cpack builds nothing.
set(CMAKE_SKIP_INSTALL_ALL_DEPENDENCY ON)

install(FILES ${PROJECT_SOURCE_DIR}/cmake/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libmaille-dev COMPONENT development)
set(CPACK_COMPONENTS_ALL development)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libmaille-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_DESCRIPTION "Maille's scenes and lattice methods for C++ programs
 Headers and static libraries for find_package(maille): scenes from label arrays or files, and the methods
 that answer them.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS # what cmake/maille-config.cmake.in looks for
  "libeigen3-dev, libfmt-dev, libhwy-dev, libpugixml-dev, libtomlplusplus-dev, nlohmann-json3-dev, zlib1g-dev")

if(TARGET maille_command)
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/maille COMPONENT command)
  list(APPEND CPACK_COMPONENTS_ALL command)
  set(CPACK_DEBIAN_COMMAND_PACKAGE_NAME maille)
  set(CPACK_DEBIAN_COMMAND_PACKAGE_SECTION science)
  set(CPACK_DEBIAN_COMMAND_DESCRIPTION "${PROJECT_DESCRIPTION}
 The command maille: soft tissue as voxels, deformed by neighbour limits or by elasticity, compared with
 finite elements (deal.II), written for ParaView and 3D Slicer.")
  # What programs and plugins are linked to, by dpkg-shlibdeps; plugins find each other without it.
  set(CPACK_DEBIAN_COMMAND_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_COMMAND_PACKAGE_RECOMMENDS "libegl1, libgl1-mesa-dri, openmpi-bin, python3-maille, python3-jinja2, python3-matplotlib, python3-scipy")
  set(CPACK_DEBIAN_COMMAND_PACKAGE_SUGGESTS "calculix-ccx, ffmpeg, paraview")
endif()

# Of the Python module, where it is built.
get_cmake_property(components COMPONENTS)
if("python" IN_LIST components)
  install(FILES ${PROJECT_SOURCE_DIR}/cmake/copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/python3-maille COMPONENT python)
  list(APPEND CPACK_COMPONENTS_ALL python)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-maille)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON_DESCRIPTION "Maille for Python: scenes and answers as numpy arrays
 The module maille: scenes from arrays, files and dictionaries, answers without copies.")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS ON)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.11), python3 (<< 3.12), python3-numpy")
  set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "python3-jinja2, python3-matplotlib, python3-nibabel, python3-scipy")
endif()
include(CPack)
