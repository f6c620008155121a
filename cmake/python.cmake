# The package porepack for Python, complete in build/python: the compiled module porepack._core and the package's own sources.
option(POREPACK_PYTHON "Build the package for Python (needs pybind11)" ON)
if(NOT POREPACK_PYTHON)
  return()
endif()
if(NOT Python_EXECUTABLE AND EXISTS /usr/bin/python3)
  set(Python_EXECUTABLE /usr/bin/python3)  # Debian's, whose NumPy is used
endif()
find_package(Python 3.9 COMPONENTS Interpreter Development.Module REQUIRED)
set(PYBIND11_FINDPYTHON ON)
find_package(pybind11 2.10 REQUIRED)

file(GLOB binding_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/python/bindings/*.cpp)
pybind11_add_module(porepack_python MODULE NO_EXTRAS ${binding_sources})
target_include_directories(porepack_python PRIVATE ${PROJECT_SOURCE_DIR}/python)
target_link_libraries(porepack_python PRIVATE porepack_design)
target_link_options(porepack_python PRIVATE -Wl,--exclude-libs,ALL)  # its symbols are its own, beside other packages' VTK
private_options(porepack_python)
optimise_less(porepack_python)
set_target_properties(porepack_python PROPERTIES OUTPUT_NAME _core CXX_VISIBILITY_PRESET hidden
  LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/python/porepack)
add_custom_target(porepack_python_sources ALL
  COMMAND ${CMAKE_COMMAND} -E copy_directory ${PROJECT_SOURCE_DIR}/python/porepack ${PROJECT_BINARY_DIR}/python/porepack)
add_dependencies(porepack_python porepack_python_sources)

# Below the prefix as Debian has it; in a wheel, where scikit-build-core builds, at its root and with the files that are found in the
# prefix otherwise.
if(SKBUILD)
  set(POREPACK_PYTHON_FOLDER .)
  install(DIRECTORY liggghts_templates openfoam_cases src/report/templates DESTINATION porepack/data COMPONENT python USE_SOURCE_PERMISSIONS)
else()
  set(POREPACK_PYTHON_FOLDER lib/python3/dist-packages CACHE STRING "Folder of Python's packages, below the prefix")
endif()
install(TARGETS porepack_python LIBRARY DESTINATION ${POREPACK_PYTHON_FOLDER}/porepack COMPONENT python)
install(DIRECTORY python/porepack DESTINATION ${POREPACK_PYTHON_FOLDER} COMPONENT python PATTERN __pycache__ EXCLUDE)
