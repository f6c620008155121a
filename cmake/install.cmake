# cmake --install: the programs, the libraries as porepack::<component>, the headers under porepack/<folder>/, and the data files.
include(CMakePackageConfigHelpers)

get_property(components GLOBAL PROPERTY porepack_components)
# ./Allrun builds only the program: what is missing is built first, or an installation would end half done.
add_custom_target(installed DEPENDS ${components})
if(TARGET porepack)
  # Man pages and the completion for bash, written by the program.
  add_custom_command(OUTPUT share/man/man1/porepack.1 COMMAND porepack manual --output share DEPENDS porepack)
  add_custom_target(porepack_manual DEPENDS share/man/man1/porepack.1)
  add_dependencies(installed porepack_manual porepack_benchmark)
endif()
if(TARGET porepack_python)
  add_dependencies(installed porepack_python)
endif()
install(CODE "execute_process(COMMAND \"${CMAKE_COMMAND}\" --build \"${CMAKE_BINARY_DIR}\" --target installed COMMAND_ERROR_IS_FATAL ANY)")
install(TARGETS ${components} EXPORT porepackTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR})
if(TARGET porepack)
  install(TARGETS porepack porepack_benchmark RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  install(DIRECTORY ${PROJECT_BINARY_DIR}/share/man ${PROJECT_BINARY_DIR}/share/bash-completion DESTINATION ${CMAKE_INSTALL_DATADIR})
endif()

# In the source tree a header is "folder/name.hpp"; installed it is "porepack/folder/name.hpp", for a user's program may have a folder of
# the same name.
install(CODE "
  file(GLOB_RECURSE headers RELATIVE \"${PROJECT_SOURCE_DIR}/src\" \"${PROJECT_SOURCE_DIR}/src/*.hpp\")
  list(FILTER headers EXCLUDE REGEX \"^apps/|/uses.hpp$\")
  foreach(header IN LISTS headers)
    file(READ \"${PROJECT_SOURCE_DIR}/src/\${header}\" text)
    string(REGEX REPLACE \"#include \\\"([a-z_]+/)\" \"#include \\\"porepack/\\\\1\" text \"\${text}\")
    set(target \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}/porepack/\${header}\")
    file(WRITE \"\${target}\" \"\${text}\")
    list(APPEND CMAKE_INSTALL_MANIFEST_FILES \"\${target}\")
  endforeach()
  message(STATUS \"Installed the headers under \${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}/porepack\")
")

set(data ${CMAKE_INSTALL_DATADIR}/porepack)
install(DIRECTORY liggghts_templates openfoam_cases DESTINATION ${data} USE_SOURCE_PERMISSIONS)
install(DIRECTORY src/report/templates DESTINATION ${data})
install(DIRECTORY evidence DESTINATION ${data} USE_SOURCE_PERMISSIONS PATTERN "__pycache__" EXCLUDE)
install(DIRECTORY cases DESTINATION ${data} USE_SOURCE_PERMISSIONS PATTERN results EXCLUDE)

set(porepack_DATA_FOLDER ${data})
get_property(porepack_light GLOBAL PROPERTY porepack_light)
configure_package_config_file(cmake/porepackConfig.cmake.in ${PROJECT_BINARY_DIR}/porepackConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/porepack PATH_VARS porepack_DATA_FOLDER)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/porepackConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/porepackConfig.cmake ${PROJECT_BINARY_DIR}/porepackConfigVersion.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/porepack)
install(EXPORT porepackTargets NAMESPACE porepack:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/porepack)
