# SPDX-License-Identifier: BSD-3-Clause
# What makes the sanitizer builds quick; every other build compiles each file as it stands.
#
# cas_precompile(<target> <header> ...): headers that most files of the target include are parsed once. A forgotten
# #include still shows in the other builds.
#
# cas_sanitize_unoptimised(<target> ...): the sanitizers make optimising slow; what computes little does without.
function(cas_precompile target)
  if(CAS_SANITIZE)
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
