# component(name [LINKS components...] [EXCEPT sources...] [PRECOMPILES headers...] [ORCHESTRATES] [HEAVY])
# A library porepack_<name> (porepack::<name>) of the sources in src/<name>.
# PRECOMPILES: headers that most of its sources parse, beside those that all do.
# Warnings and other flags are private: a program that links a component is compiled with its own.
# HEAVY: it needs more packages than the minimal build and its compression; so does what links it (porepackConfig.cmake).
# ORCHESTRATES: it calls others and handles documents, and computes nothing large itself; it is optimised less, which halves its compile
# time.
function(component name)
  cmake_parse_arguments(arg "ORCHESTRATES;HEAVY" "" "LINKS;EXCEPT;PRECOMPILES" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${name}/*.cpp)
  list(FILTER sources EXCLUDE REGEX "/tests/[^/]+$")
  foreach(source ${arg_EXCEPT})
    list(REMOVE_ITEM sources ${PROJECT_SOURCE_DIR}/src/${name}/${source})
  endforeach()
  add_library(porepack_${name} STATIC ${sources})
  add_library(porepack::${name} ALIAS porepack_${name})
  set_target_properties(porepack_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_compile_features(porepack_${name} PUBLIC cxx_std_20)
  target_include_directories(porepack_${name}
    PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>
    PRIVATE ${PROJECT_BINARY_DIR}/generated)
  private_options(porepack_${name})
  if(arg_ORCHESTRATES)
    optimise_less(porepack_${name})
    precompile(porepack_${name} orchestration)
  elseif(arg_PRECOMPILES)
    precompile(porepack_${name} ${name} ${arg_PRECOMPILES})
  else()
    precompile(porepack_${name} computation)
  endif()
  get_property(light GLOBAL PROPERTY porepack_light)
  set(heavy_links ${arg_LINKS})
  list(REMOVE_ITEM heavy_links ${light})
  if(NOT arg_HEAVY AND NOT heavy_links)
    set_property(GLOBAL APPEND PROPERTY porepack_light ${name})
  endif()
  list(TRANSFORM arg_LINKS PREPEND porepack_)
  target_link_libraries(porepack_${name} PUBLIC ${arg_LINKS})
  set_property(GLOBAL APPEND PROPERTY porepack_components porepack_${name})
endfunction()

# Fused multiplications and additions change the last bits from one machine to the next, and a pour is chaotic: only the kernels of
# lattice Boltzmann use them (instruction_sets.cmake).
function(private_options target)
  target_compile_options(${target} PRIVATE -ffp-contract=off -Wall -Wextra -Wshadow -Wno-psabi
    -Wno-missing-field-initializers                         # designated initialisers leave members at their defaults
    -Wno-restrict -Wno-stringop-overflow -Wno-array-bounds  # GCC 12 warns falsely in std::string (bug 105651)
    $<$<BOOL:${POREPACK_WERROR}>:-Werror>)
endfunction()

function(optimise_less target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# precompile(target set [headers...])
# The headers of packages that most sources parse, compiled once per set of flags: by the first target of the set, and used by the others.
# -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON builds without; a source includes what it uses, as if there were none.
function(precompile target set)
  get_property(first GLOBAL PROPERTY porepack_precompiled_${set})
  if(first)
    target_precompile_headers(${target} REUSE_FROM ${first})
  else()
    target_precompile_headers(${target} PRIVATE <algorithm> <cmath> <filesystem> <functional> <map> <memory> <optional> <set> <string> <vector>
      <Eigen/Dense> <fmt/format.h> <nlohmann/json.hpp> ${ARGN})
    set_property(GLOBAL PROPERTY porepack_precompiled_${set} ${target})
  endif()
endfunction()

# GCC collects its garbage from 128 MB on, which every source with a precompiled header exceeds; from 512 MB on, few do.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  add_compile_options($<$<COMPILE_LANGUAGE:CXX>:--param=ggc-min-heapsize=524288>)
endif()

# ccache, if it is installed, compiles nothing twice. It keeps precompiled headers, and what is compiled with them, only with these settings.
find_program(CCACHE ccache)
if(CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros ${CCACHE})
endif()
if(CMAKE_CXX_COMPILER_LAUNCHER MATCHES ccache)
  add_compile_options(-fpch-preprocess)
endif()
