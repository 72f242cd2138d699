# `cmake --install` and the build tree both serve find_package(Skybody): give CMake
# -DSkybody_DIR=build/release, or a prefix in CMAKE_PREFIX_PATH. The user's package registry is not
# modified.
#
#   PREFIX/bin/skybody
#   PREFIX/lib/libskybody.so
#   PREFIX/lib/skybody/plugins
#   PREFIX/lib/cmake/Skybody
#   PREFIX/lib/pkgconfig
#   PREFIX/include/skybody/{plugin.h,skybody.h,learn.h,task_kit.h,core/,learn/,render/}
#   PREFIX/include/skybody/plugins/{api,obstacles,task_kit}/
#   PREFIX/share/skybody/{scenarios/,template/,licenses/}
#
# The components library, development and program are those of the Debian packages (packaging/).

include(CMakePackageConfigHelpers)

set(skybody_config_dir "${CMAKE_INSTALL_LIBDIR}/cmake/Skybody")
set(skybody_header_dir "${CMAKE_INSTALL_INCLUDEDIR}/skybody")
set(skybody_data_dir "${CMAKE_INSTALL_DATADIR}/skybody")

function(skybody_install_tree component folder destination)
  if(EXISTS "${PROJECT_SOURCE_DIR}/${folder}")
    install(DIRECTORY "${PROJECT_SOURCE_DIR}/${folder}/" DESTINATION "${destination}"
      COMPONENT ${component} ${ARGN})
  endif()
endfunction()

# Headers that expose Simbody's types are private; their names begin with simbody_.
set(skybody_headers_only FILES_MATCHING PATTERN "*.h" PATTERN "simbody_*.h" EXCLUDE)
skybody_install_tree(development include "${CMAKE_INSTALL_INCLUDEDIR}" FILES_MATCHING
  PATTERN "*.h")
foreach(folder core learn render plugins/api plugins/obstacles plugins/task_kit)
  skybody_install_tree(development ${folder} "${skybody_header_dir}/${folder}"
    ${skybody_headers_only})
endforeach()
skybody_install_tree(program plugins/template "${skybody_data_dir}/template")
skybody_install_tree(library scenarios "${skybody_data_dir}/scenarios")
install(FILES "${PROJECT_BINARY_DIR}/include/skybody/version.h" DESTINATION "${skybody_header_dir}"
  COMPONENT development)

set(skybody_exported skybody skybody_learn skybody_headers skybody_plugin_api skybody_task_kit
  skybody_render)
if(TARGET skybody_cli)
  set_target_properties(skybody_cli PROPERTIES EXPORT_NAME cli)
  list(APPEND skybody_exported skybody_cli)
endif()
install(TARGETS ${skybody_exported} EXPORT SkybodyTargets
  RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT program
  LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT library NAMELINK_COMPONENT development
  ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT development)

set(skybody_modules SkybodyPlugin.cmake SkybodyTest.cmake)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/SkybodyConfigVersion.cmake"
  COMPATIBILITY ${SKYBODY_ABI_RELEASES})

# From a prefix. pkg-config's files say where it is relative to themselves. Plugins, which are
# headers alone, are compiled with `pkg-config --cflags --variable=plugin_flags skybody`.
file(RELATIVE_PATH SKYBODY_PREFIX_FROM_PKGCONFIG "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
string(JOIN " " SKYBODY_PLUGIN_FLAGS -fPIC -fvisibility=hidden ${SKYBODY_FP_FLAGS} ${SKYBODY_PACK_FLAGS})
configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/SkybodyConfig.cmake.in"
  "${PROJECT_BINARY_DIR}/install/SkybodyConfig.cmake" INSTALL_DESTINATION "${skybody_config_dir}")
install(EXPORT SkybodyTargets NAMESPACE Skybody:: DESTINATION "${skybody_config_dir}"
  COMPONENT development)
list(TRANSFORM skybody_modules PREPEND "${PROJECT_SOURCE_DIR}/cmake/" OUTPUT_VARIABLE
  skybody_module_files)
install(FILES "${PROJECT_BINARY_DIR}/install/SkybodyConfig.cmake"
  "${PROJECT_BINARY_DIR}/SkybodyConfigVersion.cmake" ${skybody_module_files}
  DESTINATION "${skybody_config_dir}" COMPONENT development)
foreach(name skybody skybody-learn)
  configure_file("${PROJECT_SOURCE_DIR}/cmake/${name}.pc.in"
    "${PROJECT_BINARY_DIR}/install/${name}.pc" @ONLY)
  install(FILES "${PROJECT_BINARY_DIR}/install/${name}.pc"
    DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig" COMPONENT development)
endforeach()

# From the build tree.
export(EXPORT SkybodyTargets NAMESPACE Skybody:: FILE "${PROJECT_BINARY_DIR}/SkybodyTargets.cmake")
configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/SkybodyConfig.cmake.in"
  "${PROJECT_BINARY_DIR}/SkybodyConfig.cmake" INSTALL_DESTINATION "${PROJECT_BINARY_DIR}"
  INSTALL_PREFIX "${PROJECT_BINARY_DIR}")
foreach(module IN LISTS skybody_modules)
  configure_file("${PROJECT_SOURCE_DIR}/cmake/${module}" "${PROJECT_BINARY_DIR}/${module}" COPYONLY)
endforeach()
