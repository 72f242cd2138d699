# Debian packages by CPack (`cpack -G DEB` in the build folder; ./dev deb): the library under the
# name of its soname, its files for development, the program, and the Python package for Debian's
# Python.
# Libraries of others are Debian's own, so packages fit the release that they are built on.

# The Python package is installed by CPack alone: elsewhere it is used from the source tree.
if(TARGET skybody_python)
  set(python_folder lib/python3/dist-packages/skybody)
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/python/skybody/" DESTINATION ${python_folder}
    COMPONENT python EXCLUDE_FROM_ALL PATTERN __pycache__ EXCLUDE PATTERN "_native*" EXCLUDE)
  install(FILES $<TARGET_FILE:skybody_python> "${SKYBODY_MODULE_FOLDER}/_native.pyi"
    DESTINATION ${python_folder} COMPONENT python EXCLUDE_FROM_ALL)
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME skybody)
set(CPACK_PACKAGE_VENDOR "The Skybody maintainers")
set(CPACK_PACKAGE_CONTACT "The Skybody maintainers <maintainers@skybody.invalid>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL library development program)
if(TARGET skybody_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_PRE_BUILD_SCRIPTS "${CMAKE_CURRENT_SOURCE_DIR}/debian/finish.cmake")
set(CPACK_SKYBODY_MANUAL "${PROJECT_SOURCE_DIR}/scripts/manual_pages.py")
set(CPACK_SKYBODY_PROGRAM "${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/skybody")

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "${PROJECT_BINARY_DIR}/lib")
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(same_version "(= ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})")
set(library libskybody${SKYBODY_ABI})

# A package's name, section and description, by component.
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "deterministic simulator of drones")
macro(skybody_debian_package component name section description)
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  set(CPACK_COMPONENT_${upper}_DESCRIPTION "Skybody flies drones with rotors, arms and loads, \
thousands at a time,\nwith the same bits on every processor, and trains policies for them.\n\n\
This package has ${description}")
endmacro()

skybody_debian_package(library ${library} libs
  "the library, its plugins and the shipped scenarios.")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA "${CMAKE_CURRENT_SOURCE_DIR}/debian/triggers")

skybody_debian_package(development libskybody-dev libdevel
  "headers, CMake and pkg-config files, and the renderer.")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "${library} ${same_version}, librandom123-dev")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS "cmake, libeigen3-dev, libgtest-dev, pkg-config")

skybody_debian_package(program skybody science
  "the command skybody. Training, plots and films are\ncommands of the Python package.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "${library} ${same_version}")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS python3-skybody)

if(TARGET skybody_python)
  skybody_debian_package(python python3-skybody python
    "the Python package, which trains, draws and exports.\nIts environments need Gymnasium, which \
neither Debian 12 nor 13 has.")
  get_target_property(suffix skybody_python SUFFIX)
  string(REGEX REPLACE ".*cpython-3([0-9]+).*" "\\1" minor "${suffix}")
  math(EXPR next "${minor} + 1")
  # Debian's NumPy provides its C interface under a name with a number, such as python3-numpy-abi9.
  execute_process(COMMAND apt-cache show python3-numpy OUTPUT_VARIABLE numpy ERROR_QUIET)
  string(REGEX MATCH "python3-numpy[0-9]*-abi[0-9]+" numpy_abi "${numpy}")
  string(JOIN ", " CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "${library} ${same_version}"
    "python3 (>= 3.${minor})" "python3 (<< 3.${next})"
    python3-h5py python3-matplotlib python3-numpy ${numpy_abi} python3-pil python3-tqdm)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS ffmpeg)
  set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA "${CMAKE_CURRENT_SOURCE_DIR}/debian/postinst"
    "${CMAKE_CURRENT_SOURCE_DIR}/debian/prerm")
endif()

include(CPack)
