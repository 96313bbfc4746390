# SPDX-License-Identifier: BSD-3-Clause
# cas_emulate(<folder> <program> ...): where programs are built for another processor, tests start each by a script of its
# name below CAS_TEST_BINARY_DIR, which is the build tree otherwise.
set(CAS_TEST_BINARY_DIR ${CMAKE_BINARY_DIR})
if(CMAKE_CROSSCOMPILING)
  set(CAS_TEST_BINARY_DIR ${CMAKE_BINARY_DIR}/emulated)
endif()
function(cas_emulate folder)
  if(NOT CMAKE_CROSSCOMPILING)
    return()
  endif()
  list(JOIN CMAKE_CROSSCOMPILING_EMULATOR " " emulator)
  file(RELATIVE_PATH below ${CMAKE_BINARY_DIR} ${folder})
  foreach(program IN LISTS ARGN)
    set(script ${CAS_TEST_BINARY_DIR}/${below}/${program})
    file(WRITE ${script} "#!/bin/sh\nexec ${emulator} ${folder}/${program} \"$@\"\n")
    file(CHMOD ${script} PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE)
  endforeach()
endfunction()
