# skybody_wheel_blas and skybody_wheel_lapack: the parts of LAPACK that Simbody calls, and the BLAS,
# from Debian's static libraries, in lib/wheel/lapack under the names that Simbody asks for. They
# are a sixth of Debian's shared ones, compute the same bits, and need no Fortran library.

find_library(SKYBODY_STATIC_LAPACK liblapack.a PATH_SUFFIXES lapack)
find_library(SKYBODY_STATIC_BLAS libblas.a PATH_SUFFIXES blas)
if(NOT SKYBODY_STATIC_LAPACK OR NOT SKYBODY_STATIC_BLAS)
  message(STATUS "no wheels: static LAPACK or BLAS is missing (liblapack-dev, libblas-dev)")
  return()
endif()

# The Fortran functions that files call (kind U) or have (kind T), as options that take them from an
# archive. Names of C functions do not end in an underscore.
function(skybody_fortran_names result kind)
  execute_process(COMMAND "${CMAKE_NM}" ${ARGN} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
  string(REGEX MATCHALL " ${kind} [a-z0-9]+_\n" found "${symbols}")
  list(TRANSFORM found REPLACE " ${kind} ([a-z0-9]+_)\n" "LINKER:-u,\\1")
  list(REMOVE_DUPLICATES found)
  set(${result} ${found} PARENT_SCOPE)
endfunction()

set(simbody "")
foreach(target SimTKsimbody SimTKmath SimTKcommon)
  get_target_property(configurations ${target} IMPORTED_CONFIGURATIONS)
  list(GET configurations 0 configuration)
  get_target_property(file ${target} IMPORTED_LOCATION_${configuration})
  list(APPEND simbody "${file}")
endforeach()
skybody_fortran_names(of_lapack U -D --undefined-only ${simbody})
skybody_fortran_names(of_blas T --defined-only "${SKYBODY_STATIC_BLAS}")

set(names "${CMAKE_CURRENT_SOURCE_DIR}/wheel/fortran_names.map")
foreach(name blas lapack)
  add_library(skybody_wheel_${name} SHARED EXCLUDE_FROM_ALL wheel/fortran_surroundings.c)
  set_target_properties(skybody_wheel_${name} PROPERTIES OUTPUT_NAME ${name} SOVERSION 3
    LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/lib/wheel/lapack")
  target_link_options(skybody_wheel_${name} PRIVATE "LINKER:--version-script=${names}"
    LINKER:-z,defs ${of_${name}})
endforeach()
target_link_libraries(skybody_wheel_blas PRIVATE "${SKYBODY_STATIC_BLAS}" m)
target_link_libraries(skybody_wheel_lapack PRIVATE "${SKYBODY_STATIC_LAPACK}" skybody_wheel_blas m)
