# Everything beyond the minimal build: engines, surfaces, the stages, the program, its tests.
find_package(CLI11 REQUIRED)
find_package(OpenSSL REQUIRED)
find_package(ZLIB REQUIRED)
find_package(CGAL REQUIRED)
find_package(muparser REQUIRED)
find_package(TIFF REQUIRED)
set(POREPACK_ITK ITKCommon ITKIOImageBase ITKIOPNG ITKIOGDCM ITKImageIntensity ITKBinaryMathematicalMorphology
  ITKConnectedComponents ITKDistanceMap ITKMathematicalMorphology ITKWatersheds ITKLabelMap)
find_package(ITK 5 REQUIRED COMPONENTS ${POREPACK_ITK})
set(POREPACK_VTK CommonCore CommonDataModel IOCore IOXMLParser IOXML IOImage FiltersSources FiltersCore RenderingCore RenderingOpenGL2)
find_package(VTK 9.1 REQUIRED COMPONENTS ${POREPACK_VTK})

target_link_libraries(porepack_packing PRIVATE ZLIB::ZLIB)
target_compile_definitions(porepack_packing PRIVATE POREPACK_WITH_ZLIB)

list(TRANSFORM record_of_files PREPEND ${PROJECT_SOURCE_DIR}/src/record/)
target_sources(porepack_record PRIVATE ${record_of_files})
target_link_libraries(porepack_record PRIVATE OpenSSL::Crypto)
component(parallel LINKS core HEAVY)
find_package(MPI COMPONENTS C)
if(MPI_C_FOUND)
  target_link_libraries(porepack_parallel PRIVATE MPI::MPI_C)
  target_compile_definitions(porepack_parallel PRIVATE POREPACK_WITH_MPI)
endif()
component(io LINKS geometry HEAVY)
target_link_libraries(porepack_io PRIVATE ${VTK_LIBRARIES} ZLIB::ZLIB)
vtk_module_autoinit(TARGETS porepack_io MODULES ${VTK_LIBRARIES})
component(imaging LINKS io record)
target_include_directories(porepack_imaging SYSTEM PRIVATE ${ITK_INCLUDE_DIRS})
target_link_libraries(porepack_imaging PRIVATE ${ITK_LIBRARIES} gdcmCommon gdcmDSED gdcmMSFF TIFF::TIFF ZLIB::ZLIB)
component(pouring LINKS packing)
component(converters LINKS pore_space io
  PRECOMPILES <CGAL/Exact_predicates_inexact_constructions_kernel.h> <CGAL/Surface_mesh.h> <CGAL/Polygon_mesh_processing/measure.h>)
target_link_libraries(porepack_converters PRIVATE CGAL::CGAL)
# With sanitizers, GCC takes ten minutes or more and 6 GB for CGAL's exact intersections.
if(CMAKE_CXX_FLAGS MATCHES "-fsanitize")
  set_source_files_properties(${PROJECT_SOURCE_DIR}/src/converters/mesh_intersections.cpp PROPERTIES COMPILE_OPTIONS -fno-sanitize=all)
endif()
component(openfoam LINKS converters)
component(tortuosity LINKS converters)
component(pores LINKS packing)
component(scans LINKS imaging pore_space pores)
component(permeability LINKS record)
component(uncertainty LINKS permeability)
target_include_directories(porepack_uncertainty SYSTEM PRIVATE ${Boost_INCLUDE_DIRS})
component(falling_head LINKS record)
target_include_directories(porepack_falling_head SYSTEM PRIVATE ${Boost_INCLUDE_DIRS})
component(results LINKS lbm openfoam scans uncertainty falling_head ORCHESTRATES)
component(report LINKS io results vessels ORCHESTRATES)
target_link_libraries(porepack_report PRIVATE OpenSSL::Crypto)
component(evidence LINKS report ORCHESTRATES)
component(pipeline LINKS record ORCHESTRATES)
component(inputs LINKS results ORCHESTRATES)
component(analysis LINKS inputs pouring tortuosity report ORCHESTRATES)
component(stages LINKS pipeline analysis ORCHESTRATES)
component(study LINKS stages ORCHESTRATES)
target_link_libraries(porepack_study PRIVATE muparser::muparser)
component(design LINKS study ORCHESTRATES)

# Flows, arrays and scans that are known exactly, for tests and benchmarks.
file(GLOB support_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/tests/support/*.cpp)
add_library(porepack_test_support STATIC ${support_sources})
set_target_properties(porepack_test_support PROPERTIES POSITION_INDEPENDENT_CODE ON)
target_include_directories(porepack_test_support PUBLIC ${PROJECT_SOURCE_DIR}/tests)
target_link_libraries(porepack_test_support PUBLIC porepack_lbm porepack_scans)
private_options(porepack_test_support)
precompile(porepack_test_support computation)

file(GLOB_RECURSE app_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/apps/porepack/*.cpp)
add_executable(porepack ${app_sources})
file(GLOB benchmark_sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/benchmarks/*.cpp)
add_executable(porepack_benchmark ${benchmark_sources})
target_include_directories(porepack_benchmark PRIVATE ${PROJECT_SOURCE_DIR})
target_link_libraries(porepack_benchmark PRIVATE porepack_test_support)
foreach(program porepack porepack_benchmark)
  private_options(${program})
  optimise_less(${program})
  precompile(${program} programs)
  target_link_libraries(${program} PRIVATE porepack_design porepack_evidence porepack_parallel CLI11::CLI11)
  set_target_properties(${program} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR})
endforeach()

# What must be clean before a commit: format, includes, scripts, clang-tidy (slow: it reads every source).
add_custom_target(check
  COMMAND sh -c "for p in clang-format run-clang-tidy shellcheck; do command -v $p || { echo apt-get install clang-format clang-tidy shellcheck; exit 1; }; done"
  COMMAND sh -c "find src tests benchmarks examples python '(' -name '*.cpp' -o -name '*.hpp' ')' -exec clang-format --dry-run --Werror {} +"
  COMMAND scripts/check_includes
  COMMAND scripts/check_shell
  COMMAND run-clang-tidy -quiet -p ${PROJECT_BINARY_DIR} "${PROJECT_SOURCE_DIR}/src/.*"
  WORKING_DIRECTORY ${PROJECT_SOURCE_DIR} VERBATIM)

include(cmake/python.cmake)

if(POREPACK_TESTS)
  enable_testing()
  add_subdirectory(tests)
endif()
