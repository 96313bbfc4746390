# SPDX-License-Identifier: BSD-3-Clause
# cas_add_test(<name> [LABEL unit|loopback|closed_loop|realtime] [TIMEOUT s] SOURCES ... LIBRARIES ... PROGRAMS ...)
# One GoogleTest program, registered test by test with its label. PROGRAMS are targets that the test runs. Real-time
# tests run alone. Tests whose name begins with casd, rpc or loopback also make up the target tsan_tests: what runs
# under ThreadSanitizer.
add_custom_target(tsan_tests)

function(cas_add_test name)
  cmake_parse_arguments(ARG "" "LABEL;TIMEOUT" "SOURCES;LIBRARIES;PROGRAMS" ${ARGN})
  if(NOT ARG_LABEL)
    set(ARG_LABEL unit)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE cas_options ${ARG_LIBRARIES} GTest::gtest_main)
  # Tests are compiled more often than they run, and AddressSanitizer makes optimising slower still: only
  # those that compute much themselves are worth it there.
  if(CAS_SANITIZE STREQUAL "address" AND NOT name MATCHES "^(libsim|plugins|fcu|closed_loop)")
    target_compile_options(${name} PRIVATE -O0)
  else()
    target_compile_options(${name} PRIVATE -O1)
  endif()
  target_compile_definitions(${name} PRIVATE CAS_SOURCE_DIR="${PROJECT_SOURCE_DIR}"
                             CAS_BINARY_DIR="${PROJECT_BINARY_DIR}")
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  if(ARG_PROGRAMS)
    add_dependencies(${name} ${ARG_PROGRAMS})
  endif()
  if(name MATCHES "^(casd|rpc|loopback)")
    add_dependencies(tsan_tests ${name})
  endif()
  set(properties LABELS ${ARG_LABEL} TIMEOUT ${ARG_TIMEOUT})
  if(ARG_LABEL STREQUAL "realtime")
    list(APPEND properties RUN_SERIAL ON)
  endif()
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST TEST_PREFIX "${name}." PROPERTIES ${properties})
endfunction()
