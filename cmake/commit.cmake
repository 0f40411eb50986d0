# Writes OUTPUT, which defines commit() (studies/version.hpp), anew only where it changes: the commit of the sources, with "-dirty" where tracked files
# differ from it, and nothing where the sources are no git checkout of their own.
execute_process(COMMAND git rev-parse --show-cdup WORKING_DIRECTORY ${SOURCES} OUTPUT_VARIABLE up RESULT_VARIABLE no_checkout
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
set(commit "")
if(no_checkout EQUAL 0 AND up STREQUAL "")
  execute_process(COMMAND git describe --always --dirty --abbrev=12 --exclude=* WORKING_DIRECTORY ${SOURCES} OUTPUT_VARIABLE commit
    OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT [[
#include "maille/studies/version.hpp"

namespace maille::studies {
const char* commit() {
  return "@commit@";
}
} // namespace maille::studies
]])
