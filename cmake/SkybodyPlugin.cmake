# skybody_add_plugin(NAME [SOURCES] FILES... [LIBRARIES TARGETS...] [PLUGINS NAMES...]
#                    [OUTPUT_DIRECTORY DIR] [NO_INSTALL])
#
# Builds the plugin NAME.so as the target NAME. The library exports only the plugin's descriptor. In
# Skybody's own tree it goes to lib/skybody/plugins and is installed. In another project it goes to
# the folder `plugins` of the build folder: add that folder to SKYBODY_PLUGIN_PATH.
#
# Skybody opens NAME.so when a scenario names the plugin NAME. If the library holds plugins of other
# names, list them all as PLUGINS: they are written to NAME.plugins beside it, one per line.
#
# Skybody does not open a library that other users may write: write permission of group and others
# is removed from NAME.so, whatever the umask. The permissions of the folders above are up to the
# author (docs/plugins.md).

include_guard(GLOBAL)

# Half of the compile time of most plugins is the header for authors, so the shipped plugins of a
# release build share it precompiled. SKYBODY_UNITY as for tests (SkybodyTest).
function(skybody_share_plugin_headers name)
  if(NOT SKYBODY_UNITY OR NOT PROJECT_IS_TOP_LEVEL)
    return()
  endif()
  if(NOT TARGET skybody_plugin_headers)
    set(source "${PROJECT_BINARY_DIR}/plugin_headers.cpp")
    file(CONFIGURE OUTPUT "${source}" CONTENT "")
    add_library(skybody_plugin_headers OBJECT EXCLUDE_FROM_ALL "${source}")
    skybody_compile_plugin(skybody_plugin_headers)
    skybody_precompile_headers(skybody_plugin_headers <skybody/plugin.h> <algorithm> <cmath>
      <stdexcept> <string> <vector>)
  endif()
  target_precompile_headers(${name} REUSE_FROM skybody_plugin_headers)
  # With it g++ 12 reports false alarms on std::string (GCC bug 105651), as -Wrestrict does.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(${name} PRIVATE -Wno-stringop-overflow -Wno-array-bounds)
  endif()
endfunction()

# How plugins are compiled, wherever they are built.
function(skybody_compile_plugin name)
  target_link_libraries(${name} PRIVATE Skybody::plugin_api)
  set_target_properties(${name} PROPERTIES
    C_VISIBILITY_PRESET hidden CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
    CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  if(TARGET skybody_build_flags)
    target_link_libraries(${name} PRIVATE skybody_build_flags)
    target_compile_options(${name} PRIVATE ${SKYBODY_KERNEL_OPTIONS})
  elseif(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
    target_compile_options(${name} PRIVATE -O3)  # default for projects without a build type
  endif()
endfunction()

function(skybody_add_plugin name)
  cmake_parse_arguments(PARSE_ARGV 1 plugin "NO_INSTALL" "OUTPUT_DIRECTORY"
    "SOURCES;LIBRARIES;PLUGINS")
  set(sources ${plugin_SOURCES} ${plugin_UNPARSED_ARGUMENTS})
  if(NOT sources)
    message(FATAL_ERROR "skybody_add_plugin(${name}): no source files given")
  endif()

  add_library(${name} MODULE ${sources})
  skybody_compile_plugin(${name})
  target_link_libraries(${name} PRIVATE ${plugin_LIBRARIES})
  set_target_properties(${name} PROPERTIES PREFIX "" SUFFIX ".so")
  set(own_tree OFF)  # also if a project has Skybody as a part of itself (FetchContent)
  if(DEFINED Skybody_SOURCE_DIR AND PROJECT_SOURCE_DIR STREQUAL Skybody_SOURCE_DIR)
    set(own_tree ON)
  endif()
  if(NOT SKYBODY_SANITIZE)
    # reports missing symbols here, not at load time
    target_link_options(${name} PRIVATE LINKER:-z,defs)
  endif()

  # Nothing of the standard library is exported either: a library that defines one of its unique
  # symbols is never unloaded.
  set(names "${CMAKE_CURRENT_BINARY_DIR}/plugin_names.map")
  file(CONFIGURE OUTPUT "${names}" CONTENT "{ global: skybody_plugin_library; local: *; };\n")
  target_link_options(${name} PRIVATE "LINKER:--version-script=${names}")

  set(folder "${plugin_OUTPUT_DIRECTORY}")
  if(NOT folder AND own_tree)
    set(folder "${SKYBODY_PLUGIN_OUTPUT_DIRECTORY}")
  elseif(NOT folder)
    set(folder "${CMAKE_CURRENT_BINARY_DIR}/plugins")
  endif()
  set_target_properties(${name} PROPERTIES LIBRARY_OUTPUT_DIRECTORY "${folder}")

  add_custom_command(TARGET ${name} POST_BUILD COMMAND chmod go-w "$<TARGET_FILE:${name}>" VERBATIM)

  # Runs after linking, when the library has its final name. Without PLUGINS an old list is removed.
  set(sidecar "$<TARGET_FILE_DIR:${name}>/$<TARGET_FILE_BASE_NAME:${name}>.plugins")
  if(plugin_PLUGINS)
    set(list "${CMAKE_CURRENT_BINARY_DIR}/${name}.plugins")
    string(JOIN "\n" names ${plugin_PLUGINS})
    file(CONFIGURE OUTPUT "${list}" CONTENT "${names}\n" @ONLY)
    set_property(TARGET ${name} APPEND PROPERTY LINK_DEPENDS "${list}")
    add_custom_command(TARGET ${name} POST_BUILD COMMAND "${CMAKE_COMMAND}" -E copy "${list}"
      "${sidecar}" VERBATIM)
  else()
    add_custom_command(TARGET ${name} POST_BUILD COMMAND "${CMAKE_COMMAND}" -E rm -f "${sidecar}"
      VERBATIM)
  endif()

  if(own_tree AND NOT plugin_NO_INSTALL AND NOT plugin_OUTPUT_DIRECTORY)
    if(plugin_PLUGINS)
      install(FILES "${list}" DESTINATION "${CMAKE_INSTALL_LIBDIR}/skybody/plugins" RENAME
        "${name}.plugins" COMPONENT library)
    endif()
    install(TARGETS ${name} LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}/skybody/plugins"
      COMPONENT library)
    set_property(GLOBAL APPEND PROPERTY SKYBODY_PLUGINS ${name})
    skybody_share_plugin_headers(${name})
  endif()
endfunction()
