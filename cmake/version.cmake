cmake_minimum_required(VERSION 3.22)
execute_process(COMMAND git -C ${SOURCE} rev-parse --short HEAD OUTPUT_VARIABLE HASH OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
if(NOT HASH)
  set(HASH "unknown")
endif()
file(CONFIGURE OUTPUT ${OUT} CONTENT "#pragma once
#define POREPACK_VERSION \"@VERSION@\"
#define POREPACK_GIT_HASH \"@HASH@\"
" @ONLY)
