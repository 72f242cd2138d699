# Run by CPack on the folders of all packages: paths of the build are taken out of programs and
# libraries, each package gets its copyright and changelog, and the program its manual pages.
file(GLOB packages LIST_DIRECTORIES true "${CPACK_TEMPORARY_INSTALL_DIRECTORY}/*")
foreach(package IN LISTS packages)
  get_filename_component(component "${package}" NAME)
  string(TOUPPER "${component}" upper)
  set(name "${CPACK_DEBIAN_${upper}_PACKAGE_NAME}")
  if(NOT name)
    continue()
  endif()

  file(GLOB_RECURSE elf "${package}/usr/bin/*" "${package}/usr/lib/*.so" "${package}/usr/lib/*.so.*")
  foreach(file IN LISTS elf)
    if(NOT IS_SYMLINK "${file}")
      execute_process(COMMAND patchelf --remove-rpath "${file}" COMMAND_ERROR_IS_FATAL ANY)
    endif()
  endforeach()

  if(component STREQUAL "program")
    set(manual "${package}/usr/share/man/man1")
    execute_process(COMMAND python3 "${CPACK_SKYBODY_MANUAL}" --program "${CPACK_SKYBODY_PROGRAM}"
                            --out "${manual}" COMMAND_ERROR_IS_FATAL ANY)
    file(GLOB pages "${manual}/*.1")
    execute_process(COMMAND gzip -9n ${pages} COMMAND_ERROR_IS_FATAL ANY)
  endif()

  set(doc "${package}/usr/share/doc/${name}")
  file(COPY "${CMAKE_CURRENT_LIST_DIR}/copyright" DESTINATION "${doc}"
    FILE_PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ)
  string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
  set(version "${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}")
  set(entry "skybody (${version}) unstable; urgency=medium\n\n")
  string(APPEND entry "  * Release ${CPACK_PACKAGE_VERSION}.\n\n")
  string(APPEND entry " -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
  file(WRITE "${doc}/changelog.Debian" "${entry}")
  execute_process(COMMAND gzip -9n "${doc}/changelog.Debian" COMMAND_ERROR_IS_FATAL ANY)
endforeach()
