# Kernels for CUDA: PTX by nvcc, where it is installed, as bytes in the program. The driver compiles it for the card.
find_program(NVCC nvcc PATHS /usr/local/cuda/bin)
option(POREPACK_CUDA "Kernels for CUDA, if nvcc is installed" ON)
if(NOT NVCC OR NOT POREPACK_CUDA)
  return()
endif()

# ptx(target name OPTIONS options... SOURCES texts...): porepack_ptx_<name>, ends with a zero.
function(ptx target name)
  cmake_parse_arguments(arg "" "" "OPTIONS;SOURCES" ${ARGN})
  list(TRANSFORM arg_SOURCES PREPEND ${PROJECT_SOURCE_DIR}/src/)
  set(base ${PROJECT_BINARY_DIR}/generated/${name})
  add_custom_command(OUTPUT ${base}.ptx DEPENDS ${arg_SOURCES} VERBATIM
    COMMAND ${CMAKE_COMMAND} -E cat ${arg_SOURCES} > ${base}.cu
    COMMAND ${NVCC} -ptx -arch=compute_80 -DPIECES=1 ${arg_OPTIONS} -o ${base}.ptx ${base}.cu)
  file(CONFIGURE OUTPUT ${base}.cpp CONTENT [[// The bytes of @base@.ptx.
asm(".section .rodata\n.globl porepack_ptx_@name@\n.type porepack_ptx_@name@, @object\nporepack_ptx_@name@:\n.incbin \"@base@.ptx\"\n.byte 0\n.text\n");
]] @ONLY)
  set_source_files_properties(${base}.cpp PROPERTIES SKIP_PRECOMPILE_HEADERS ON OBJECT_DEPENDS ${base}.ptx)
  target_sources(${target} PRIVATE ${base}.cpp)
endfunction()

ptx(porepack_devices copy SOURCES devices/kernel_language.cl devices/copy.cl)
foreach(precision float double)
  if(precision STREQUAL double)
    set(options -DDOUBLE)
  endif()
  ptx(porepack_lbm lattice_${precision} OPTIONS ${options} SOURCES devices/kernel_language.cl lbm/kernels/opencl/lattice.cl)
endforeach()
target_compile_definitions(porepack_devices PRIVATE POREPACK_WITH_CUDA)
target_compile_definitions(porepack_lbm PRIVATE POREPACK_WITH_CUDA)
