# CPack runs this before it packs: what Debian wants of each package beside its files.
foreach(component ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${component} upper)
  set(command ${CMAKE_CURRENT_LIST_DIR}/finish ${CPACK_TEMPORARY_DIRECTORY}/${component} ${component} ${CPACK_DEBIAN_${upper}_PACKAGE_NAME}
    ${CPACK_PACKAGE_VERSION} ${CPACK_ARKMESH_SUITE} ${CPACK_DEBIAN_PACKAGE_MAINTAINER})
  execute_process(COMMAND ${command} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
