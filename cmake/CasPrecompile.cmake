# SPDX-License-Identifier: BSD-3-Clause
# Options that speed up builds.
#
# cas_precompile(<target> <header> ...): headers that most files of the target include are parsed once. With
# CAS_PRECOMPILE=OFF each file is compiled as it stands, so that a forgotten #include shows (scripts/test --full).
#
# cas_sanitize_unoptimised(<target> ...): the sanitizers make optimising slow; targets that compute little do without.
option(CAS_PRECOMPILE "Parse the headers that most files of a target include once" ON)
if(CAS_PRECOMPILE AND CMAKE_CXX_COMPILER_ID MATCHES Clang)
  # Clang refuses a precompiled header of ccache's whose sources have other times of change.
  target_compile_options(cas_options INTERFACE "SHELL:-Xclang -fno-pch-timestamp")
endif()

function(cas_precompile target)
  if(CAS_PRECOMPILE)
    list(TRANSFORM ARGN REPLACE "(.+)" "<\\1>")
    target_precompile_headers(${target} PRIVATE ${ARGN})
  endif()
endfunction()

function(cas_sanitize_unoptimised)
  if(CAS_SANITIZE)
    foreach(target ${ARGN})
      target_compile_options(${target} PRIVATE -O0)
    endforeach()
  endif()
endfunction()
