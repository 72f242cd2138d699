# skybody_wheel_library: libskybody as the wheel has it, in lib/wheel, linked from the objects of
# the ordinary one. HDF5 is inside, with hidden names: Debian's shared HDF5 brings libcurl, OpenSSL
# and 40 more libraries for files on web servers, which Skybody does not open.
#
# Debian's static HDF5 is not compiled for shared libraries. The C library's streams are the only
# variables of others that it uses, so these get names of our own.

find_library(SKYBODY_STATIC_HDF5 libhdf5.a PATH_SUFFIXES hdf5/serial)
find_library(SKYBODY_STATIC_SZ libsz.a)
find_library(SKYBODY_STATIC_AEC libaec.a)
foreach(library HDF5 SZ AEC)
  if(NOT SKYBODY_STATIC_${library})
    message(STATUS "no wheels: static HDF5, SZ or AEC is missing (libhdf5-dev)")
    return()
  endif()
endforeach()
find_package(ZLIB REQUIRED)

set(hdf5 "${CMAKE_CURRENT_BINARY_DIR}/libhdf5.a")
add_custom_command(OUTPUT "${hdf5}"
  COMMAND "${CMAKE_OBJCOPY}" --redefine-sym stderr=hdf5_stderr --redefine-sym stdout=hdf5_stdout
          "${SKYBODY_STATIC_HDF5}" "${hdf5}"
  DEPENDS "${SKYBODY_STATIC_HDF5}" VERBATIM)

add_library(skybody_wheel_library SHARED EXCLUDE_FROM_ALL "${hdf5}" wheel/hdf5_surroundings.c
  $<TARGET_OBJECTS:skybody>)
skybody_export_own_names(skybody_wheel_library)
set_target_properties(skybody_wheel_library PROPERTIES OUTPUT_NAME skybody LINKER_LANGUAGE CXX
  LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/lib/wheel")
get_target_property(libraries skybody LINK_LIBRARIES)
list(REMOVE_ITEM libraries skybody_hdf5 skybody_headers skybody_build_flags)
target_link_libraries(skybody_wheel_library PRIVATE ${libraries} "${hdf5}" "${SKYBODY_STATIC_SZ}"
  "${SKYBODY_STATIC_AEC}" ZLIB::ZLIB)
