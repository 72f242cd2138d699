# skybody_add_test(NAME [FILES] FILES... [LIBRARIES TARGETS...] [DEFINITIONS D...] [TIMEOUT S])
#
# Adds a GoogleTest program NAME; ctest lists its tests one by one. It is linked with Skybody::core,
# GoogleTest's main and gmock, and runs in the project's root folder. SKYBODY_SOURCE_DIR and
# SKYBODY_BINARY_DIR are defined for it as strings. The label of its tests is the name of the folder
# (`ctest -L io`).

include_guard(GLOBAL)

# Reading the headers of GoogleTest, gmock and the standard library takes g++ longer than compiling
# a test, so release tests share a precompiled header. Presets for lint and debuggers turn it off
# (SKYBODY_UNITY), so that each file is also compiled by itself.
function(skybody_share_test_headers name)
  if(NOT SKYBODY_UNITY OR NOT PROJECT_IS_TOP_LEVEL)
    return()
  endif()
  if(NOT TARGET skybody_test_headers)
    # An executable like the tests, because position-independent executables have other flags than
    # libraries.
    set(program "${PROJECT_BINARY_DIR}/test_headers.cpp")
    file(CONFIGURE OUTPUT "${program}" CONTENT "int main() {}\n")
    add_executable(skybody_test_headers EXCLUDE_FROM_ALL "${program}")
    set_target_properties(skybody_test_headers PROPERTIES RUNTIME_OUTPUT_DIRECTORY
      "${CMAKE_CURRENT_BINARY_DIR}")
    target_link_libraries(skybody_test_headers PRIVATE skybody_build_flags GTest::gmock)
    target_compile_options(skybody_test_headers PRIVATE ${SKYBODY_TEST_OPTIONS})
    target_precompile_headers(skybody_test_headers PRIVATE <gmock/gmock.h> <gtest/gtest.h>
      <algorithm> <array> <cmath>
      <filesystem> <fstream> <functional> <map> <memory> <numeric> <optional> <random> <set>
      <sstream> <string> <thread>
      <vector>)
  endif()
  target_precompile_headers(${name} REUSE_FROM skybody_test_headers)
endfunction()

function(skybody_add_test name)
  cmake_parse_arguments(PARSE_ARGV 1 test "" "TIMEOUT" "FILES;LIBRARIES;DEFINITIONS")
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
    target_compile_options(${name} PRIVATE ${SKYBODY_TEST_OPTIONS})
    skybody_share_test_headers(${name})
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
