# skybody_add_plugin(NAME [SOURCES] FILES... [LIBRARIES TARGETS...] [PLUGINS NAMES...] [OUTPUT_DIRECTORY DIR]
#                    [NO_INSTALL])
#
# Builds the plugin NAME.so. Inside Skybody's own tree it goes to lib/skybody/plugins and is installed; in a project that
# has called find_package(Skybody), to the folder `plugins` of its build folder: name that in SKYBODY_PLUGIN_PATH.
# The target is called NAME. It exports the plugin's descriptor and nothing else.
#
# Skybody opens NAME.so where a scenario names the plugin NAME. If the library holds plugins of other names, give them
# all as PLUGINS: they are written into NAME.plugins beside it, one a line.
#
# Skybody opens no library that others may write: NAME.so loses the group's and others' permission, whatever the umask.
# The folders above are the author's to keep (docs/plugins.md).

include_guard(GLOBAL)

function(skybody_add_plugin name)
  cmake_parse_arguments(PARSE_ARGV 1 plugin "NO_INSTALL" "OUTPUT_DIRECTORY" "SOURCES;LIBRARIES;PLUGINS")
  set(sources ${plugin_SOURCES} ${plugin_UNPARSED_ARGUMENTS})
  if(NOT sources)
    message(FATAL_ERROR "skybody_add_plugin(${name}): no source files given")
  endif()

  add_library(${name} MODULE ${sources})
  target_link_libraries(${name} PRIVATE Skybody::plugin_api ${plugin_LIBRARIES})
  set_target_properties(${name} PROPERTIES
    PREFIX "" SUFFIX ".so"
    C_VISIBILITY_PRESET hidden CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON
    CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)

  set(own_tree OFF)
  if(TARGET skybody_build_flags)
    set(own_tree ON)
    target_link_libraries(${name} PRIVATE skybody_build_flags)
    target_compile_options(${name} PRIVATE ${SKYBODY_KERNEL_OPTIONS})
  elseif(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
    target_compile_options(${name} PRIVATE -O3)  # nobody chose a build type: not the slowest, then
  endif()
  if(NOT SKYBODY_SANITIZE)
    target_link_options(${name} PRIVATE LINKER:-z,defs)  # what is missing shows here, not at load time
  endif()

  set(folder "${plugin_OUTPUT_DIRECTORY}")
  if(NOT folder AND own_tree)
    set(folder "${SKYBODY_PLUGIN_OUTPUT_DIRECTORY}")
  elseif(NOT folder)
    set(folder "${CMAKE_CURRENT_BINARY_DIR}/plugins")
  endif()
  set_target_properties(${name} PROPERTIES LIBRARY_OUTPUT_DIRECTORY "${folder}")

  add_custom_command(TARGET ${name} POST_BUILD COMMAND chmod go-w "$<TARGET_FILE:${name}>" VERBATIM)

  # After linking, when the library has its final name; without PLUGINS an old list must not stay.
  set(sidecar "$<TARGET_FILE_DIR:${name}>/$<TARGET_FILE_BASE_NAME:${name}>.plugins")
  if(plugin_PLUGINS)
    set(list "${CMAKE_CURRENT_BINARY_DIR}/${name}.plugins")
    string(JOIN "\n" names ${plugin_PLUGINS})
    file(CONFIGURE OUTPUT "${list}" CONTENT "${names}\n" @ONLY)
    set_property(TARGET ${name} APPEND PROPERTY LINK_DEPENDS "${list}")
    add_custom_command(TARGET ${name} POST_BUILD COMMAND "${CMAKE_COMMAND}" -E copy "${list}" "${sidecar}" VERBATIM)
  else()
    add_custom_command(TARGET ${name} POST_BUILD COMMAND "${CMAKE_COMMAND}" -E rm -f "${sidecar}" VERBATIM)
  endif()

  if(own_tree AND NOT plugin_NO_INSTALL AND NOT plugin_OUTPUT_DIRECTORY)
    if(plugin_PLUGINS)
      install(FILES "${list}" DESTINATION "${CMAKE_INSTALL_LIBDIR}/skybody/plugins" RENAME "${name}.plugins")
    endif()
    install(TARGETS ${name} LIBRARY DESTINATION "${CMAKE_INSTALL_LIBDIR}/skybody/plugins")
    set_property(GLOBAL APPEND PROPERTY SKYBODY_PLUGINS ${name})
  endif()
endfunction()
