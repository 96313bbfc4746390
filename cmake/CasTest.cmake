# SPDX-License-Identifier: BSD-3-Clause
# cas_add_test(<name> [LABEL unit|loopback|closed_loop|many_flights|realtime|long] [TIMEOUT s]
#              SOURCES ... LIBRARIES ... PROGRAMS ... SUITES ... MANY_FLIGHTS ...)
# One GoogleTest program. A program of unit tests is one test, because its start costs as much as many of them; one of its tests
# is run by --gtest_filter. Others are registered test by test with their label, but for SUITES, which are one test each: their
# shared setup (a flight) would be repeated for every test. MANY_FLIGHTS are patterns of tests with that label, whatever the
# label of the others. PROGRAMS are targets that the test runs. Real-time tests run alone. Tests whose name begins with casd,
# rpc or loopback also make up the target tsan_tests, which runs under ThreadSanitizer.
add_custom_target(tsan_tests)

include(CasEmulate)

function(cas_add_test name)
  cmake_parse_arguments(ARG "" "LABEL;TIMEOUT" "SOURCES;LIBRARIES;PROGRAMS;SUITES;MANY_FLIGHTS" ${ARGN})
  if(NOT ARG_LABEL)
    set(ARG_LABEL unit)
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 120)
  endif()
  if(CMAKE_CROSSCOMPILING)  # emulated
    math(EXPR ARG_TIMEOUT "${ARG_TIMEOUT} * 5")
  endif()
  add_executable(${name} ${ARG_SOURCES})
  target_link_libraries(${name} PRIVATE cas_options ${ARG_LIBRARIES} cas_test_paths GTest::gtest_main)
  # Tests are compiled more often than they run: only those that compute much themselves are worth optimising
  # under a sanitizer.
  target_compile_options(${name} PRIVATE -O1)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13 AND NOT CAS_SANITIZE)
    target_compile_options(${name} PRIVATE -Wno-array-bounds)  # as in cas_options under a sanitizer
  endif()
  if(CAS_SANITIZE AND NOT name MATCHES "^(libsim|plugins|fcu|closed_loop)")
    cas_sanitize_unoptimised(${name})
  endif()
  set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/tests)
  if(ARG_PROGRAMS)
    add_dependencies(${name} ${ARG_PROGRAMS})
  endif()
  if(CAS_SANITIZE AND ARG_LABEL MATCHES "^(realtime|long)$")  # never run there
    set_target_properties(${name} PROPERTIES EXCLUDE_FROM_ALL ON)
  elseif(name MATCHES "^(casd|rpc|loopback)")
    add_dependencies(tsan_tests ${name})
  endif()
  set(properties TIMEOUT ${ARG_TIMEOUT} COST ${ARG_TIMEOUT})  # what may take long begins first
  if(ARG_LABEL STREQUAL "realtime")
    list(APPEND properties RUN_SERIAL ON)
  endif()
  list(TRANSFORM ARG_SUITES APPEND ".*" OUTPUT_VARIABLE suites)
  set(others "*")
  if(ARG_SUITES OR ARG_MANY_FLIGHTS)
    list(JOIN suites ":" suites)
    list(JOIN ARG_MANY_FLIGHTS ":" many)
    set(others "*-${suites}:${many}")
    string(REPLACE "-:" "-" others "${others}")
  endif()
  foreach(suite IN LISTS ARG_SUITES)
    add_test(NAME ${name}.${suite} COMMAND ${name} --gtest_filter=${suite}.*)
    set_tests_properties(${name}.${suite} PROPERTIES LABELS ${ARG_LABEL} ${properties})
  endforeach()
  if(ARG_MANY_FLIGHTS)
    gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST TEST_PREFIX "${name}." TEST_FILTER "${many}" TEST_LIST ${name}_many
                         PROPERTIES LABELS many_flights ${properties})
  endif()
  if(ARG_LABEL STREQUAL "unit" AND NOT CMAKE_CROSSCOMPILING)  # some tests are left out beneath an emulator
    math(EXPR timeout "${ARG_TIMEOUT} * 5")
    add_test(NAME ${name} COMMAND ${name} --gtest_filter=${others})
    set_tests_properties(${name} PROPERTIES LABELS unit TIMEOUT ${timeout} COST ${timeout})
    return()
  endif()
  gtest_discover_tests(${name} DISCOVERY_MODE PRE_TEST TEST_PREFIX "${name}." TEST_FILTER "${others}"
                       PROPERTIES LABELS ${ARG_LABEL} ${properties})
endfunction()
