# Finds Simbody, detects how it was built, and provides targets and functions to compile against it.
#
# Simbody's headers change the layout of their classes with NDEBUG, and Debian builds the library
# without it: a program compiled with -DNDEBUG (CMake's Release) against it crashes in
# realizeTopology. Every file that includes Simbody is therefore compiled in the same way as the
# library. A probe detects that way at configure time. Simbody's headers are not valid C++20 either,
# so these files are C++17.
#
#   SKYBODY_SIMBODY_NDEBUG
#       ON if the library was built with -DNDEBUG
#   skybody_simbody_headers
#       INTERFACE target: headers, libraries, -DNDEBUG or -UNDEBUG, at least C++17
#   skybody_use_simbody(TARGET)
#       compiles a whole target against Simbody, as C++17. The target must not link Skybody::core
#       (C++20): make it an OBJECT library and link that
#   skybody_add_simbody_sources(TARGET FILES...)
#       an OBJECT library of files that include Simbody, made part of libskybody

# Our own Simbody (./dev simbody) is preferred to the system's.
set(SKYBODY_SIMBODY_PREFIX "${PROJECT_SOURCE_DIR}/.simbody/install" CACHE PATH
  "Where to look for Simbody first (./dev simbody installs one there)")

function(skybody_prefer_own_simbody)
  file(GLOB own_config "${SKYBODY_SIMBODY_PREFIX}/lib*/cmake/[Ss]imbody/SimbodyConfig.cmake"
    "${SKYBODY_SIMBODY_PREFIX}/lib*/*/cmake/[Ss]imbody/SimbodyConfig.cmake")
  if(own_config)
    list(GET own_config 0 first)
    get_filename_component(folder "${first}" DIRECTORY)
    set(Simbody_DIR "${folder}" CACHE PATH "Simbody's CMake folder" FORCE)
  endif()
endfunction()

# Builds and runs the probe, a falling body, in a separate process, with or without NDEBUG.
function(skybody_try_simbody ndebug result log)
  try_run(exit_code compiled
    SOURCES "${PROJECT_SOURCE_DIR}/cmake/simbody_probe.cpp"
    COMPILE_DEFINITIONS "-DSKYBODY_PROBE_NDEBUG=${ndebug}"
    LINK_LIBRARIES SimTKsimbody SimTKmath SimTKcommon
    CXX_STANDARD 17 CXX_STANDARD_REQUIRED ON CXX_EXTENSIONS OFF
    COMPILE_OUTPUT_VARIABLE output
    NO_CACHE)
  set(${log} "${output}" PARENT_SCOPE)
  if(compiled AND exit_code STREQUAL "0")
    set(${result} ON PARENT_SCOPE)
  else()
    set(${result} OFF PARENT_SCOPE)
  endif()
endfunction()

function(skybody_simbody_library result)
  get_target_property(configurations SimTKsimbody IMPORTED_CONFIGURATIONS)
  list(GET configurations 0 configuration)
  get_target_property(library SimTKsimbody IMPORTED_LOCATION_${configuration})
  set(${result} "${library}" PARENT_SCOPE)
endfunction()

# Tries without NDEBUG first: that program only links with a library built without it. The probe
# takes seconds, so its result is cached as long as the library is the same file.
function(skybody_detect_simbody_ndebug)
  skybody_simbody_library(library)
  file(TIMESTAMP "${library}" time)
  set(probed "${library} ${time} ${CMAKE_CXX_COMPILER} ${CMAKE_CXX_COMPILER_VERSION}")
  if(DEFINED CACHE{SKYBODY_SIMBODY_NDEBUG} AND "${SKYBODY_SIMBODY_PROBED}" STREQUAL "${probed}")
    return()
  endif()
  set(ndebug OFF)
  skybody_try_simbody(0 works log_without)
  if(NOT works)
    set(ndebug ON)
    skybody_try_simbody(1 works log_with)
  endif()
  if(NOT works)
    message(FATAL_ERROR
      "A falling body does not build and run with ${library}. Without NDEBUG:\n${log_without}\n"
      "With NDEBUG:\n${log_with}")
  endif()
  set(SKYBODY_SIMBODY_NDEBUG ${ndebug} CACHE BOOL "Simbody was built with -DNDEBUG (detected)"
    FORCE)
  set(SKYBODY_SIMBODY_PROBED "${probed}" CACHE INTERNAL "The library that was probed")
endfunction()

skybody_prefer_own_simbody()
find_package(Simbody 3.7 REQUIRED CONFIG)
skybody_detect_simbody_ndebug()

add_library(skybody_simbody_headers INTERFACE)
target_compile_features(skybody_simbody_headers INTERFACE cxx_std_17)
target_link_libraries(skybody_simbody_headers INTERFACE SimTKsimbody SimTKmath SimTKcommon)
# A compile option and not a definition, because it must follow the -DNDEBUG of
# CMAKE_CXX_FLAGS_RELEASE.
if(SKYBODY_SIMBODY_NDEBUG)
  target_compile_options(skybody_simbody_headers INTERFACE -DNDEBUG)
else()
  target_compile_options(skybody_simbody_headers INTERFACE -UNDEBUG)
endif()

function(skybody_use_simbody target)
  target_link_libraries(${target} PRIVATE skybody_build_flags skybody_simbody_headers)
  set_target_properties(${target} PROPERTIES CXX_STANDARD 17)
endfunction()

function(skybody_add_simbody_sources target)
  add_library(${target} OBJECT ${ARGN})
  skybody_use_simbody(${target})
  target_link_libraries(skybody PRIVATE $<BUILD_INTERFACE:${target}> SimTKsimbody SimTKmath
    SimTKcommon)
endfunction()
