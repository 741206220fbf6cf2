# Writes the source that holds the commit of SOURCE_DIR to OUTPUT, and touches it only when the commit is
# another one.
execute_process(
  COMMAND git -C ${SOURCE_DIR} describe --always --dirty --tags
  OUTPUT_VARIABLE COMMIT RESULT_VARIABLE STATUS
  OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT STATUS EQUAL 0 OR COMMIT STREQUAL "")
  set(COMMIT unknown)
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT [[
#include "common/build_commit.hpp"

const char* const sextant::build_commit = "@COMMIT@";
]] @ONLY)
