# Settings of all our targets: folders, language, warnings, floating-point arithmetic.

include(GNUInstallDirs)

option(SKYBODY_PORTABLE
  "Kernels for the compiler's own instruction set alone, as on processors other than x86-64" OFF)
option(SKYBODY_CCACHE "Compile through ccache where it is found" ON)
set(SKYBODY_KERNELS "all" CACHE STRING
  "Instruction sets with kernels of their own: 'all', or 'host': this machine's best and the lowest, for builds that stay here")
set(SKYBODY_SANITIZE "" CACHE STRING "Sanitizers: 'address,undefined', 'thread' or empty")

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_CXX_SCAN_FOR_MODULES OFF)  # there are none
set(CMAKE_C_STANDARD 11)
set(CMAKE_C_STANDARD_REQUIRED ON)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

# build/PRESET/bin, build/PRESET/lib, build/PRESET/lib/skybody/plugins: plugins have the same place
# relative to libskybody as in an installation.
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/lib")
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/lib")
set(SKYBODY_PLUGIN_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/lib/skybody/plugins")

# An installed program finds libskybody relative to itself, and our own Simbody in the folder where
# it was built.
file(RELATIVE_PATH skybody_bin_to_lib "/${CMAKE_INSTALL_BINDIR}" "/${CMAKE_INSTALL_LIBDIR}")
set(CMAKE_INSTALL_RPATH "$ORIGIN" "$ORIGIN/${skybody_bin_to_lib}")
set(CMAKE_INSTALL_RPATH_USE_LINK_PATH ON)

# The number in the names of our libraries (soname). It changes with every release that breaks
# binaries built against the one before (docs/compatibility.md).
set(SKYBODY_ABI ${PROJECT_VERSION_MAJOR})
set(SKYBODY_ABI_RELEASES SameMajorVersion)
if(PROJECT_VERSION_MAJOR EQUAL 0)
  set(SKYBODY_ABI 0.${PROJECT_VERSION_MINOR})
  set(SKYBODY_ABI_RELEASES SameMinorVersion)
endif()

# Our shared libraries export only names of our own: no template of Eigen, Boost or Simbody can take
# the place of another library's, or the other way round. Calls inside a library stay inside it,
# whatever a consumer has compiled the same inline functions with.
function(skybody_export_own_names library)
  set(names "${PROJECT_SOURCE_DIR}/cmake/exported_names.map")
  target_link_options(${library} PRIVATE "LINKER:--version-script=${names}"
    LINKER:-Bsymbolic-functions)
  set_property(TARGET ${library} APPEND PROPERTY LINK_DEPENDS "${names}")
  set_target_properties(${library} PROPERTIES VERSION ${SKYBODY_ABI} SOVERSION ${SKYBODY_ABI})
endfunction()

if(SKYBODY_CCACHE)
  find_program(SKYBODY_CCACHE_PROGRAM ccache)
  if(SKYBODY_CCACHE_PROGRAM)
    # With precompiled headers (SkybodyTest), ccache compares their content instead of their time.
    # Paths below the checkout count as relative, so that a second checkout reuses the first one's
    # results.
    set(skybody_ccache "${CMAKE_COMMAND}" -E env CCACHE_SLOPPINESS=pch_defines,time_macros
      "CCACHE_BASEDIR=${PROJECT_SOURCE_DIR}" CCACHE_NOHASHDIR=1 "${SKYBODY_CCACHE_PROGRAM}")
    set(CMAKE_C_COMPILER_LAUNCHER "${skybody_ccache}")
    set(CMAKE_CXX_COMPILER_LAUNCHER "${skybody_ccache}")
  endif()
endif()

# skybody_precompile_headers(TARGET HEADER...): precompiles headers for the target and for targets
# that reuse them. g++ identifies a header with `#pragma once` by its bytes, comments included. By
# default ccache ignores comments and would return a precompiled header of other bytes. In depend
# mode it compares the bytes of all files.
function(skybody_precompile_headers name)
  target_precompile_headers(${name} PRIVATE ${ARGN})
  if(SKYBODY_CCACHE AND SKYBODY_CCACHE_PROGRAM AND CMAKE_CXX_COMPILER_LAUNCHER)
    set(launcher "${CMAKE_COMMAND}" -E env CCACHE_DEPEND=1 ${CMAKE_CXX_COMPILER_LAUNCHER})
    set_target_properties(${name} PROPERTIES CXX_COMPILER_LAUNCHER "${launcher}")
  endif()
endfunction()

# The Python of ./dev; `python3` on PATH may belong to a version manager.
if(NOT Python3_EXECUTABLE AND EXISTS "${PROJECT_SOURCE_DIR}/.venv/bin/python")
  set(Python3_EXECUTABLE "${PROJECT_SOURCE_DIR}/.venv/bin/python")
endif()

# Bit-stable arithmetic (docs/architecture.md). fp-contract and fast-math change results. errno and
# traps do not; without them sqrt is one instruction and selects are vectorized.
set(SKYBODY_FP_FLAGS -fno-fast-math -ffp-contract=off -fno-math-errno -fno-trapping-math)
# Options that tune or correct g++ alone. Other compilers do not need them, nor know all of them.
function(skybody_gnu_options variable)
  set(${variable} "" PARENT_SCOPE)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    set(${variable} ${ARGN} PARENT_SCOPE)
  endif()
endfunction()
# g++ 12 fuses adjacent products with sums and differences, whatever fp-contract is. Files affected
# by this (codegen_test.cpp lists them) take this option.
set(SKYBODY_UNFUSED_OPTION -fno-tree-slp-vectorize)

# Packs are wider than the baseline's registers; they never cross a library boundary by value.
set(SKYBODY_PACK_FLAGS -Wno-psabi)
# False alarms of GCC 12: on std::string (GCC bug 105651); on the undefined operands of its own
# AVX-512 intrinsics (GCC bug 105593), in the files that use these.
skybody_gnu_options(SKYBODY_STRING_FLAGS -Wno-restrict)
skybody_gnu_options(SKYBODY_INTRINSICS_FLAGS -Wno-maybe-uninitialized -Wno-uninitialized)

set(SKYBODY_SANITIZE_FLAGS "")
if(SKYBODY_SANITIZE)
  set(SKYBODY_SANITIZE_FLAGS
    -fsanitize=${SKYBODY_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
endif()

# Kernels and plugins are templates that expand to functions of 10^5 instructions. With a
# sanitizer's checks in them, g++ takes minutes for an optimised file and seconds for one that is
# not.
set(SKYBODY_KERNEL_OPTIONS "")
if(SKYBODY_SANITIZE)
  set(SKYBODY_KERNEL_OPTIONS -O0)
endif()

# For most files g++ takes longer to read headers than to compile, so several are compiled at once.
# Files with their own options (kernels) are compiled separately. Presets for debuggers and lint
# turn it off, so that each file is also compiled by itself.
option(SKYBODY_UNITY "Compile several files of the library and of the program at a time" OFF)
function(skybody_unite target)
  if(SKYBODY_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 6)
    # g++ treats the files as headers, where anonymous namespaces would be an error.
    skybody_gnu_options(options -Wno-subobject-linkage)
    target_compile_options(${target} PRIVATE ${options})
  endif()
endfunction()

# Tests run code that is compiled at full optimisation. Their own code runs once, and g++ compiles
# it in half the time if it does not optimise. Tests whose own code computes much take -O1.
set(SKYBODY_TEST_OPTIONS "$<$<CONFIG:Release>:-O0>")
set(SKYBODY_COMPUTING_TEST_OPTIONS "$<$<CONFIG:Release>:-O1>")

# Kernels take most of the time of a build. The lowest set is always built, so that every build runs
# everywhere.
set(SKYBODY_KERNEL_DEFINITIONS "")
if(SKYBODY_KERNELS STREQUAL "host" AND EXISTS /proc/cpuinfo)
  file(STRINGS /proc/cpuinfo skybody_flags REGEX "^flags" LIMIT_COUNT 1)
  if(skybody_flags MATCHES " avx512f " AND skybody_flags MATCHES " avx512vl ")
    set(SKYBODY_KERNEL_DEFINITIONS SKYBODY_BUILDS_v3=0)
  elseif(skybody_flags MATCHES " avx2 ")
    set(SKYBODY_KERNEL_DEFINITIONS SKYBODY_BUILDS_v4=0)
  endif()
elseif(NOT SKYBODY_KERNELS MATCHES "^(all|host)$")
  message(FATAL_ERROR "SKYBODY_KERNELS is '${SKYBODY_KERNELS}'; it is 'all' or 'host'")
endif()

# Flags and include folders of our targets. The C++ standard is not set here, because the files that
# include Simbody are C++17.
add_library(skybody_build_flags INTERFACE)
target_include_directories(skybody_build_flags INTERFACE
  "${PROJECT_SOURCE_DIR}" "${PROJECT_SOURCE_DIR}/include" "${PROJECT_BINARY_DIR}/include")
target_compile_options(skybody_build_flags INTERFACE
  ${SKYBODY_FP_FLAGS} ${SKYBODY_PACK_FLAGS} ${SKYBODY_SANITIZE_FLAGS}
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual
  ${SKYBODY_STRING_FLAGS}
  $<$<BOOL:${PROJECT_IS_TOP_LEVEL}>:-Werror>)
target_compile_definitions(skybody_build_flags INTERFACE ${SKYBODY_KERNEL_DEFINITIONS})
target_link_options(skybody_build_flags INTERFACE ${SKYBODY_SANITIZE_FLAGS})

# Adds a folder of this project if it exists.
function(skybody_add_folder folder)
  if(EXISTS "${CMAKE_CURRENT_SOURCE_DIR}/${folder}/CMakeLists.txt")
    add_subdirectory(${folder})
  endif()
endfunction()

function(skybody_print_summary)
  string(TOUPPER "${CMAKE_BUILD_TYPE}" type)
  if(SKYBODY_SIMBODY_NDEBUG)
    set(asserts "without asserts (NDEBUG)")
  else()
    set(asserts "with asserts (no NDEBUG); ./dev simbody builds a quicker one")
  endif()
  message(STATUS "Skybody ${PROJECT_VERSION}")
  message(STATUS "  build     ${CMAKE_BUILD_TYPE} (${CMAKE_CXX_FLAGS_${type}}) ${SKYBODY_SANITIZE}")
  message(STATUS "  compiler  ${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}")
  message(STATUS "  Simbody   ${Simbody_VERSION} in ${Simbody_ROOT_DIR}, built ${asserts}")
  message(STATUS "            SKYBODY_SIMBODY_NDEBUG ${SKYBODY_SIMBODY_NDEBUG}")
endfunction()
