# SPDX-License-Identifier: BSD-3-Clause
# What makes builds quick.
#
# cas_precompile(<target> <header> ...): headers that most files of the target include are parsed once. With
# CAS_PRECOMPILE=OFF each file is compiled as it stands, so that a forgotten #include shows (scripts/test --full).
#
# cas_sanitize_unoptimised(<target> ...): the sanitizers make optimising slow; what computes little does without.
option(CAS_PRECOMPILE "Parse the headers that most files of a target include once" ON)

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
