# component(name [LINKS components...])
# A library porepack_<name> (porepack::<name>) of the sources in src/<name>.
# Warnings and other flags are private: a program that links a component is compiled with its own.
function(component name)
  cmake_parse_arguments(arg "" "" "LINKS" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${name}/*.cpp)
  add_library(porepack_${name} STATIC ${sources})
  add_library(porepack::${name} ALIAS porepack_${name})
  set_target_properties(porepack_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_compile_features(porepack_${name} PUBLIC cxx_std_20)
  target_include_directories(porepack_${name}
    PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
    PRIVATE ${PROJECT_BINARY_DIR}/generated)
  private_options(porepack_${name})
  list(TRANSFORM arg_LINKS PREPEND porepack_)
  target_link_libraries(porepack_${name} PUBLIC ${arg_LINKS})
  set_property(GLOBAL APPEND PROPERTY porepack_components porepack_${name})
endfunction()

# A pour is chaotic: its last bits must not depend on what a compiler fuses, nor a grain's measures on the machine.
function(no_contraction)
  foreach(name ${ARGN})
    target_compile_options(porepack_${name} PRIVATE -ffp-contract=off)
  endforeach()
endfunction()

function(private_options target)
  target_compile_options(${target} PRIVATE -Wall -Wextra -Wshadow -Wno-psabi
    -Wno-missing-field-initializers  # designated initialisers leave members at their defaults
    -Wno-restrict                    # GCC 12 warns falsely in std::string (bug 105651)
    $<$<BOOL:${POREPACK_WERROR}>:-Werror>)
endfunction()
