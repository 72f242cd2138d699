# cmake -DSOURCE=... -DOUTPUT=... -P git_describe.cmake: writes a header with `git describe`.
execute_process(COMMAND git -C "${SOURCE}" describe --always --dirty --tags
  OUTPUT_VARIABLE describe OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET RESULT_VARIABLE failed)
if(failed)
  set(describe "")
endif()
set(text "#pragma once\n\n#define SKYBODY_GIT_DESCRIBE \"${describe}\"\n")
set(before "")
if(EXISTS "${OUTPUT}")
  file(READ "${OUTPUT}" before)
endif()
if(NOT before STREQUAL text)
  file(WRITE "${OUTPUT}" "${text}")
endif()
