# Writes a C++ file OUTPUT with one function for every file of TEXTS (page.html: page_html), each returning the text of that file.
# NAMESPACE: of these functions; maille::studies where it is not set.
if(NOT NAMESPACE)
  set(NAMESPACE maille::studies)
endif()
file(WRITE ${OUTPUT} "// Made by cmake/embed_texts.cmake.\n#include <string_view>\n\nnamespace ${NAMESPACE} {\n\n")
foreach(text IN LISTS TEXTS)
  get_filename_component(name ${text} NAME)
  string(REPLACE "." "_" name ${name})
  file(READ ${text} content)
  file(APPEND ${OUTPUT} "std::string_view ${name}();\nstd::string_view ${name}() {\n  return R\"embedded(${content})embedded\";\n}\n\n")
endforeach()
file(APPEND ${OUTPUT} "} // namespace ${NAMESPACE}\n")
