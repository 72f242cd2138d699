# skybody_add_test(NAME [FILES] FILES... [LIBRARIES TARGETS...] [DEFINITIONS D...] [TIMEOUT S])
#
# A GoogleTest program NAME whose tests ctest lists one by one. It is linked with Skybody::core, GoogleTest's main and
# gmock, and runs in the project's root folder. SKYBODY_SOURCE_DIR and SKYBODY_BINARY_DIR are defined for it as strings.
# The label of its tests is the name of the folder (`ctest -L io`).

include_guard(GLOBAL)

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
