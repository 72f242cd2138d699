# Third-party libraries, each as one target skybody_NAME, so that no other file depends on a
# distribution's names for them.

find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED CONFIG)
find_package(Boost 1.74 REQUIRED CONFIG)  # Boost.DLL, which is header-only
find_package(yaml-cpp REQUIRED CONFIG)
find_package(urdfdom REQUIRED CONFIG)
find_package(tinyxml2 REQUIRED CONFIG)
find_package(spdlog REQUIRED CONFIG)
find_package(CLI11 REQUIRED CONFIG)
find_package(HDF5 REQUIRED COMPONENTS C)
find_package(PNG 1.6 REQUIRED)
find_path(SKYBODY_TURBOJPEG_INCLUDE_DIR turbojpeg.h REQUIRED)
find_library(SKYBODY_TURBOJPEG_LIBRARY turbojpeg REQUIRED)
find_path(SKYBODY_RANDOM123_INCLUDE_DIR Random123/philox.h REQUIRED)

# SUNDIALS 6 or 7. The headers may be in the project (fetched by ./dev); without Debian's -dev
# package there is no plain .so either. Debian 13's libraries need MPI: there ./dev builds static
# ones without it into the project.
set(sundials_folder "${PROJECT_SOURCE_DIR}/.sundials")
find_path(SKYBODY_SUNDIALS_INCLUDE_DIR cvode/cvode.h HINTS "${sundials_folder}/include")
if(NOT SKYBODY_SUNDIALS_INCLUDE_DIR)
  message(FATAL_ERROR
    "no headers of SUNDIALS: `./dev build` fetches them (libsundials-dev has them, too, but "
                      "brings another BLAS, with which Simbody computes other bits)")
endif()
file(STRINGS "${SKYBODY_SUNDIALS_INCLUDE_DIR}/sundials/sundials_config.h" sundials_config
     REGEX "^#define SUNDIALS_(VERSION |MPI_ENABLED 1)")
string(REGEX REPLACE ".*SUNDIALS_VERSION \"([^\"]*)\".*" "\\1" SKYBODY_SUNDIALS_VERSION
  "${sundials_config}")
if(NOT SKYBODY_SUNDIALS_VERSION MATCHES "^6[.]" AND
   (NOT SKYBODY_SUNDIALS_VERSION MATCHES "^7[.]" OR sundials_config MATCHES "MPI_ENABLED 1"))
  message(FATAL_ERROR
    "SUNDIALS ${SKYBODY_SUNDIALS_VERSION} in ${SKYBODY_SUNDIALS_INCLUDE_DIR}; needed: 6, or 7 "
                      "without MPI, which `./dev build` makes")
endif()
set(sundials_libraries cvode arkode)
if(SKYBODY_SUNDIALS_VERSION MATCHES "^7")
  list(APPEND sundials_libraries core)
endif()
set(skybody_sundials_files "")
foreach(name IN LISTS sundials_libraries)
  string(TOUPPER "SKYBODY_${name}_LIBRARY" file)
  find_library(${file} NAMES sundials_${name} libsundials_${name}.so.6 libsundials_${name}.so.5
    HINTS "${sundials_folder}/lib" REQUIRED)
  list(APPEND skybody_sundials_files "${${file}}")
endforeach()

function(skybody_dependency name)
  add_library(skybody_${name} INTERFACE)
  target_link_libraries(skybody_${name} INTERFACE ${ARGN})
endfunction()

function(skybody_first_target result)
  foreach(candidate IN LISTS ARGN)
    if(TARGET ${candidate})
      set(${result} ${candidate} PARENT_SCOPE)
      return()
    endif()
  endforeach()
  message(FATAL_ERROR "none of the targets ${ARGN} exists")
endfunction()

skybody_first_target(yaml_target yaml-cpp::yaml-cpp yaml-cpp)
skybody_dependency(yaml ${yaml_target})
skybody_dependency(eigen Eigen3::Eigen)
skybody_dependency(dll Boost::headers ${CMAKE_DL_LIBS})
skybody_dependency(xml tinyxml2::tinyxml2)
# From its headers: the libraries of spdlog and fmt are larger than the program's few messages.
skybody_dependency(log Threads::Threads)
target_compile_definitions(skybody_log INTERFACE SPDLOG_FMT_EXTERNAL FMT_HEADER_ONLY)
target_include_directories(skybody_log SYSTEM INTERFACE
  $<TARGET_PROPERTY:spdlog::spdlog,INTERFACE_INCLUDE_DIRECTORIES>)
skybody_dependency(cli11 CLI11::CLI11)
skybody_dependency(pictures PNG::PNG "${SKYBODY_TURBOJPEG_LIBRARY}")
target_include_directories(skybody_pictures SYSTEM INTERFACE
  "${SKYBODY_TURBOJPEG_INCLUDE_DIR}")
skybody_dependency(hdf5)
list(FILTER HDF5_C_LIBRARIES INCLUDE REGEX "hdf5")  # drops HDF5's own dependencies
target_include_directories(skybody_hdf5 SYSTEM INTERFACE ${HDF5_C_INCLUDE_DIRS})
target_compile_definitions(skybody_hdf5 INTERFACE ${HDF5_C_DEFINITIONS})
target_link_libraries(skybody_hdf5 INTERFACE ${HDF5_C_LIBRARIES})
skybody_dependency(sundials ${skybody_sundials_files})
target_include_directories(skybody_sundials SYSTEM INTERFACE "${SKYBODY_SUNDIALS_INCLUDE_DIR}")
skybody_dependency(urdf)
if(TARGET urdfdom::urdfdom_model)
  target_link_libraries(skybody_urdf INTERFACE urdfdom::urdfdom_model)
else()
  target_include_directories(skybody_urdf SYSTEM INTERFACE ${urdfdom_INCLUDE_DIRS})
  target_link_libraries(skybody_urdf INTERFACE ${urdfdom_LIBRARIES})
endif()
if(NOT urdfdom_VERSION)  # missing in Debian's package; read it from the pkg-config file
  find_file(urdfdom_pkgconfig urdfdom.pc PATH_SUFFIXES lib/pkgconfig
    lib/${CMAKE_LIBRARY_ARCHITECTURE}/pkgconfig
            PATHS /usr NO_CACHE)
  if(urdfdom_pkgconfig)
    file(STRINGS "${urdfdom_pkgconfig}" urdfdom_VERSION REGEX "^Version:")
    string(REGEX REPLACE "^Version: *" "" urdfdom_VERSION "${urdfdom_VERSION}")
  else()
    set(urdfdom_VERSION unknown)
  endif()
endif()
set(SKYBODY_LIBRARY_VERSIONS
  # stamped into files
  "yaml-cpp ${yaml-cpp_VERSION}, urdfdom ${urdfdom_VERSION}, Boost ${Boost_VERSION}, SUNDIALS ${SKYBODY_SUNDIALS_VERSION}")

# DAQP, a solver of quadratic programs (MIT): C sources that ./dev fetches. Only its core is
# compiled, with our floating-point flags, for bit-stable results; api.c, which allocates, is left
# out. Without DAQP the plugins that need it are left out.
find_path(SKYBODY_DAQP_DIR csrc/src/daqp.c HINTS "${PROJECT_SOURCE_DIR}/.daqp" NO_DEFAULT_PATH)
if(SKYBODY_DAQP_DIR)
  add_library(skybody_daqp STATIC EXCLUDE_FROM_ALL "${SKYBODY_DAQP_DIR}/csrc/src/daqp.c"
    "${SKYBODY_DAQP_DIR}/csrc/src/auxiliary.c" "${SKYBODY_DAQP_DIR}/csrc/src/factorization.c"
    "${SKYBODY_DAQP_DIR}/csrc/src/utils.c")
  target_include_directories(skybody_daqp SYSTEM PUBLIC "${SKYBODY_DAQP_DIR}/csrc/include")
  target_compile_options(skybody_daqp PRIVATE ${SKYBODY_FP_FLAGS} ${SKYBODY_SANITIZE_FLAGS} -w)
  set_target_properties(skybody_daqp PROPERTIES C_VISIBILITY_PRESET hidden)
  install(FILES "${SKYBODY_DAQP_DIR}/LICENSE" DESTINATION
    "${CMAKE_INSTALL_DATADIR}/skybody/licenses"
    RENAME daqp.txt COMPONENT library)
else()
  message(STATUS "no DAQP in .daqp (`./dev build` fetches it): controller nmpc is left out")
endif()

if(EXISTS "${sundials_folder}/LICENSE")  # linked in
  install(FILES "${sundials_folder}/LICENSE" DESTINATION "${CMAKE_INSTALL_DATADIR}/skybody/licenses"
    RENAME sundials.txt COMPONENT library)
endif()

if(SKYBODY_BUILD_TESTS)
  find_package(GTest REQUIRED CONFIG)
endif()
find_package(benchmark CONFIG)
