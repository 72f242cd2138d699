# skybody_add_test(NAME [FILES] FILES... [LIBRARIES TARGETS...] [DEFINITIONS D...] [TIMEOUT S]
#                  [COMPUTES])
#
# Adds a GoogleTest program NAME; ctest lists its tests one by one. It is linked with Skybody::core,
# GoogleTest's main and gmock, and runs in the project's root folder. SKYBODY_SOURCE_DIR and
# SKYBODY_BINARY_DIR are defined for it as strings. The label of its tests is the name of the folder
# (`ctest -L io`). In Skybody's own release build the test's code is not optimised; with COMPUTES it
# is, a little.

include_guard(GLOBAL)

# kind: `test` or `computing_test`.
function(skybody_compile_test name kind)
  string(TOUPPER "SKYBODY_${kind}_OPTIONS" options)
  target_compile_options(${name} PRIVATE ${${options}})
endfunction()

# Reading the headers of GoogleTest, gmock and the standard library takes g++ longer than compiling
# a test, so release tests share a precompiled header. Presets for lint and debuggers turn it off
# (SKYBODY_UNITY), so that each file is also compiled by itself.
function(skybody_share_test_headers name kind)
  if(NOT SKYBODY_UNITY OR NOT PROJECT_IS_TOP_LEVEL)
    return()
  endif()
  set(headers skybody_${kind}_headers)
  if(NOT TARGET ${headers})
    # An executable like the tests, because position-independent executables have other flags than
    # libraries.
    set(program "${PROJECT_BINARY_DIR}/test_headers.cpp")
    file(CONFIGURE OUTPUT "${program}" CONTENT "int main() {}\n")
    add_executable(${headers} EXCLUDE_FROM_ALL "${program}")
    set_target_properties(${headers} PROPERTIES RUNTIME_OUTPUT_DIRECTORY
      "${CMAKE_CURRENT_BINARY_DIR}")
    target_link_libraries(${headers} PRIVATE skybody_build_flags GTest::gmock)
    skybody_compile_test(${headers} ${kind})
    skybody_precompile_headers(${headers} <gmock/gmock.h> <gtest/gtest.h>
      <algorithm> <array> <cmath>
      <filesystem> <fstream> <functional> <map> <memory> <numeric> <optional> <random> <set>
      <sstream> <string> <thread>
      <vector>)
  endif()
  target_precompile_headers(${name} REUSE_FROM ${headers})
endfunction()

function(skybody_add_test name)
  cmake_parse_arguments(PARSE_ARGV 1 test "COMPUTES" "TIMEOUT" "FILES;LIBRARIES;DEFINITIONS")
  set(files ${test_FILES} ${test_UNPARSED_ARGUMENTS})
  if(NOT files)
    message(FATAL_ERROR "skybody_add_test(${name}): no source files given")
  endif()
  if(NOT test_TIMEOUT)
    set(test_TIMEOUT 300)
  endif()
  if(NOT TARGET GTest::gmock_main)
    find_package(GTest REQUIRED CONFIG)
  endif()
  include(GoogleTest)
  get_filename_component(area "${CMAKE_CURRENT_SOURCE_DIR}" NAME)

  add_executable(${name} ${files})
  target_link_libraries(${name} PRIVATE ${test_LIBRARIES} GTest::gmock GTest::gtest_main)
  if(TARGET skybody_build_flags)
    target_link_libraries(${name} PRIVATE skybody_build_flags)
    set(kind test)
    if(test_COMPUTES)
      set(kind computing_test)
    endif()
    skybody_compile_test(${name} ${kind})
    skybody_share_test_headers(${name} ${kind})
  endif()
  if(TARGET Skybody::core)
    target_link_libraries(${name} PRIVATE Skybody::core)
  endif()
  target_compile_definitions(${name} PRIVATE ${test_DEFINITIONS}
    "SKYBODY_SOURCE_DIR=\"${PROJECT_SOURCE_DIR}\"" "SKYBODY_BINARY_DIR=\"${PROJECT_BINARY_DIR}\"")
  gtest_discover_tests(${name}
    DISCOVERY_MODE PRE_TEST
    DISCOVERY_TIMEOUT 60
    WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}"
    PROPERTIES TIMEOUT ${test_TIMEOUT} LABELS "${area}")
endfunction()
