# skybody_stable_module: the Python module for Python 3.12 and later (abi3), in lib/wheel.
# SKYBODY_STABLE_PYTHON is a folder such as /usr/include with the headers of such a Python; this
# machine's Python and its module stay as they are.
set(SKYBODY_STABLE_PYTHON "" CACHE PATH
  "Folder that has python3.12 or a newer one, for the module with a stable ABI")
if(NOT SKYBODY_STABLE_PYTHON OR NOT TARGET skybody_python)
  return()
endif()

function(skybody_add_stable_module)
  # As nanobind reads them.
  set(Python_VERSION 3.12)
  set(Python_INTERPRETER_ID Python)
  file(GLOB headers "${SKYBODY_STABLE_PYTHON}/python3.*")
  set(Python_INCLUDE_DIRS ${headers} "${SKYBODY_STABLE_PYTHON}")
  if(NOT TARGET Python::SABIModule)
    add_library(Python::SABIModule INTERFACE IMPORTED)
  endif()
  get_target_property(sources skybody_python SOURCES)
  list(TRANSFORM sources PREPEND "${PROJECT_SOURCE_DIR}/python/")
  nanobind_add_module(skybody_stable_module STABLE_ABI NB_SUPPRESS_WARNINGS NOMINSIZE ${sources})
endfunction()
skybody_add_stable_module()

set_target_properties(skybody_stable_module PROPERTIES OUTPUT_NAME _native EXCLUDE_FROM_ALL ON
  LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/lib/wheel")
foreach(property LINK_LIBRARIES INCLUDE_DIRECTORIES COMPILE_DEFINITIONS)
  get_target_property(values skybody_python ${property})
  list(FILTER values EXCLUDE REGEX "nanobind")
  set_property(TARGET skybody_stable_module APPEND PROPERTY ${property} ${values})
endforeach()
add_dependencies(skybody_stable_module skybody_git_describe)
