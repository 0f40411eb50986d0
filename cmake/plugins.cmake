# Plugins: shared objects that a program opens when it first needs them (plugins/include/maille/plugins/open_plugin.hpp), so that it starts
# without the libraries that they stand on. A plugin is closed: it holds its own copy of what it is linked to, and exports one function.
# Programs look for them by their RUNPATH: in the build tree, and where they are installed.
set(maille_plugin_folder ${CMAKE_INSTALL_LIBDIR}/maille)
# Programs that are not installed, such as tests, have this one:
set(CMAKE_BUILD_RPATH ${PROJECT_BINARY_DIR}/plugins)
# maille_runpath(TARGET PATH...): the RUNPATH in the build tree and where the target is installed. CMake would end a RUNPATH that it changes
# at installation with an empty entry, which the loader reads as the current folder.
function(maille_runpath target)
  set_target_properties(${target} PROPERTIES INSTALL_RPATH "${ARGN}" BUILD_WITH_INSTALL_RPATH ON)
endfunction()
file(RELATIVE_PATH from_programs_to_plugins ${CMAKE_CURRENT_SOURCE_DIR}/${CMAKE_INSTALL_BINDIR} ${CMAKE_CURRENT_SOURCE_DIR}/${maille_plugin_folder})
file(RELATIVE_PATH from_programs_to_data ${CMAKE_CURRENT_SOURCE_DIR}/${CMAKE_INSTALL_BINDIR} ${CMAKE_CURRENT_SOURCE_DIR}/${CMAKE_INSTALL_DATADIR})
set(maille_plugin_exports ${CMAKE_CURRENT_BINARY_DIR}/plugin_exports.map)
file(WRITE ${maille_plugin_exports} "{ global: maille_plugin; local: *; };\n")

# maille_plugin(NAME SOURCES ... LINK ...): the target maille_NAME_plugin, the file maille-NAME.so.
function(maille_plugin name)
  cmake_parse_arguments(arg "NOT_INSTALLED" "" "SOURCES;LINK" ${ARGN})
  set(target maille_${name}_plugin)
  add_library(${target} MODULE ${arg_SOURCES})
  set_target_properties(${target} PROPERTIES PREFIX "" OUTPUT_NAME maille-${name}
    LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/plugins LINK_DEPENDS ${maille_plugin_exports})
  maille_runpath(${target} "$ORIGIN")
  target_compile_features(${target} PRIVATE cxx_std_20)
  target_link_libraries(${target} PRIVATE ${arg_LINK} maille_compile_options maille_position_independent)
  target_link_options(${target} PRIVATE LINKER:--version-script=${maille_plugin_exports})
  if(NOT (MAILLE_SANITIZE OR MAILLE_SANITIZE_THREADS OR MAILLE_FUZZ)) # whose own functions are the program's
    target_link_options(${target} PRIVATE LINKER:-z,defs)
  endif()
  maille_use_precompiled(${target} position_independent)
  if(NOT arg_NOT_INSTALLED)
    install(TARGETS ${target} LIBRARY DESTINATION ${maille_plugin_folder} COMPONENT command)
  endif()
endfunction()
