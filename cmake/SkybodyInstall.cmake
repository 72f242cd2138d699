# `cmake --install` and the build tree both serve find_package(Skybody): give CMake
# -DSkybody_DIR=build/release, or a prefix in CMAKE_PREFIX_PATH. The user's package registry is not
# modified.
#
#   PREFIX/bin/skybody
#   PREFIX/lib/libskybody.so
#   PREFIX/lib/skybody/plugins
#   PREFIX/lib/cmake/Skybody
#   PREFIX/include/skybody/{plugin.h,skybody.h,learn.h,core/,learn/}
#   PREFIX/include/skybody/plugins/{api,obstacles,task_kit}/
#   PREFIX/share/skybody/{scenarios/,template/}

include(CMakePackageConfigHelpers)

set(skybody_config_dir "${CMAKE_INSTALL_LIBDIR}/cmake/Skybody")
set(skybody_header_dir "${CMAKE_INSTALL_INCLUDEDIR}/skybody")
set(skybody_data_dir "${CMAKE_INSTALL_DATADIR}/skybody")

function(skybody_install_tree folder destination)
  if(EXISTS "${PROJECT_SOURCE_DIR}/${folder}")
    install(DIRECTORY "${PROJECT_SOURCE_DIR}/${folder}/" DESTINATION "${destination}" ${ARGN})
  endif()
endfunction()

# Headers that expose Simbody's types are private; their names begin with simbody_.
set(skybody_headers_only FILES_MATCHING PATTERN "*.h" PATTERN "simbody_*.h" EXCLUDE)
skybody_install_tree(include "${CMAKE_INSTALL_INCLUDEDIR}" FILES_MATCHING PATTERN "*.h")
skybody_install_tree(core "${skybody_header_dir}/core" ${skybody_headers_only})
skybody_install_tree(learn "${skybody_header_dir}/learn" ${skybody_headers_only})
skybody_install_tree(plugins/api "${skybody_header_dir}/plugins/api" ${skybody_headers_only})
skybody_install_tree(plugins/obstacles "${skybody_header_dir}/plugins/obstacles"
  ${skybody_headers_only})
skybody_install_tree(plugins/task_kit "${skybody_header_dir}/plugins/task_kit"
  ${skybody_headers_only})
skybody_install_tree(plugins/template "${skybody_data_dir}/template")
skybody_install_tree(scenarios "${skybody_data_dir}/scenarios")
install(FILES "${PROJECT_BINARY_DIR}/include/skybody/version.h" DESTINATION "${skybody_header_dir}")

set(skybody_exported skybody skybody_learn skybody_plugin_api)
if(TARGET skybody_cli)
  set_target_properties(skybody_cli PROPERTIES EXPORT_NAME cli)
  list(APPEND skybody_exported skybody_cli)
endif()
install(TARGETS ${skybody_exported} EXPORT SkybodyTargets
  RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}"
  LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}"
  ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}")

set(skybody_modules SkybodyPlugin.cmake SkybodyTest.cmake)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/SkybodyConfigVersion.cmake"
  COMPATIBILITY SameMinorVersion)

# From a prefix.
configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/SkybodyConfig.cmake.in"
  "${PROJECT_BINARY_DIR}/install/SkybodyConfig.cmake" INSTALL_DESTINATION "${skybody_config_dir}")
install(EXPORT SkybodyTargets NAMESPACE Skybody:: DESTINATION "${skybody_config_dir}")
install(FILES "${PROJECT_BINARY_DIR}/install/SkybodyConfig.cmake"
  "${PROJECT_BINARY_DIR}/SkybodyConfigVersion.cmake" DESTINATION "${skybody_config_dir}")
foreach(module IN LISTS skybody_modules)
  install(FILES "${PROJECT_SOURCE_DIR}/cmake/${module}" DESTINATION "${skybody_config_dir}")
endforeach()

# From the build tree.
export(EXPORT SkybodyTargets NAMESPACE Skybody:: FILE "${PROJECT_BINARY_DIR}/SkybodyTargets.cmake")
configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/SkybodyConfig.cmake.in"
  "${PROJECT_BINARY_DIR}/SkybodyConfig.cmake" INSTALL_DESTINATION "${PROJECT_BINARY_DIR}"
  INSTALL_PREFIX "${PROJECT_BINARY_DIR}")
foreach(module IN LISTS skybody_modules)
  configure_file("${PROJECT_SOURCE_DIR}/cmake/${module}" "${PROJECT_BINARY_DIR}/${module}" COPYONLY)
endforeach()
