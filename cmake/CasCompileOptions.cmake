# SPDX-License-Identifier: BSD-3-Clause
# Interface target cas_options: warnings and sanitizers that each target of the project links privately.
add_library(cas_options INTERFACE)
target_include_directories(cas_options INTERFACE ${PROJECT_SOURCE_DIR})
target_compile_options(cas_options INTERFACE -Wall -Wextra -Wpedantic -Wconversion -Wshadow)
if(CAS_UNITY)
  # A source sees the names of those that are compiled with it, and none of them is the main file.
  target_compile_options(cas_options INTERFACE -Wno-shadow $<$<CXX_COMPILER_ID:GNU>:-Wshadow=local -Wno-subobject-linkage>)
endif()
if(CMAKE_CXX_COMPILER_ID MATCHES Clang)
  target_compile_options(cas_options INTERFACE -Wthread-safety)  # base/os/mutex.hpp
endif()
if(CAS_WERROR)
  target_compile_options(cas_options INTERFACE -Werror)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # GCC 12 takes `"text" + std::string` for an overlapping copy (GCC bug 105651), and where it optimises little
  # `std::string("text") + "more"` for one beyond the end of the string's own buffer.
  target_compile_options(cas_options INTERFACE -Wno-restrict)
  if(CAS_SANITIZE)
    target_compile_options(cas_options INTERFACE -Wno-array-bounds)
  endif()
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CAS_SANITIZE)
  # GCC 12 reports values that only the instrumentation fails to follow.
  target_compile_options(cas_options INTERFACE -Wno-maybe-uninitialized)
  if(CAS_SANITIZE STREQUAL "thread")
    # ThreadSanitizer does not model fences; ours order atomics alone.
    target_compile_options(cas_options INTERFACE -Wno-tsan)
  endif()
endif()

if(CAS_SANITIZE STREQUAL "address")
  # Left out: null and object-size end in a report of AddressSanitizer, too; vptr asks for RTTI everywhere.
  set(_cas_sanitize -fsanitize=address,undefined -fno-sanitize-recover=undefined
      -fno-sanitize=null,object-size,vptr -fno-omit-frame-pointer)
  if(CAS_BUILD_FUZZERS)
    # libFuzzer finds its way by the branches that it sees: those of the libraries, too.
    list(APPEND _cas_sanitize -fsanitize=fuzzer-no-link)
  else()
    list(APPEND _cas_sanitize -fno-sanitize=alignment)  # a third of the compile time
  endif()
elseif(CAS_SANITIZE STREQUAL "thread")
  # Asio's fenced blocks use atomic fences, which ThreadSanitizer does not model.
  set(_cas_sanitize -fsanitize=thread -fno-omit-frame-pointer)
  target_compile_definitions(cas_options INTERFACE BOOST_ASIO_DISABLE_FENCED_BLOCK)
elseif(CAS_SANITIZE)
  message(FATAL_ERROR "CAS_SANITIZE is '${CAS_SANITIZE}'; it takes address or thread")
endif()
if(CAS_BUILD_FUZZERS AND NOT (CAS_BUILD_TESTS AND CAS_SANITIZE STREQUAL "address" AND CMAKE_CXX_COMPILER_ID MATCHES Clang))
  message(FATAL_ERROR "CAS_BUILD_FUZZERS needs Clang, CAS_BUILD_TESTS and CAS_SANITIZE=address")
endif()
if(CAS_SANITIZE)
  target_compile_options(cas_options INTERFACE ${_cas_sanitize})
  target_link_options(cas_options INTERFACE ${_cas_sanitize})
endif()

# Asio: no deprecated interfaces.
add_library(cas_asio INTERFACE)
target_link_libraries(cas_asio INTERFACE Boost::headers Threads::Threads)
target_compile_definitions(cas_asio INTERFACE BOOST_ASIO_NO_DEPRECATED)

# cas_sanitize_unoptimised(<target> ...): the sanitizers make optimising slow; targets that compute little do without.
function(cas_sanitize_unoptimised)
  if(CAS_SANITIZE)
    foreach(target ${ARGN})
      target_compile_options(${target} PRIVATE -O0)
    endforeach()
  endif()
endfunction()

# cas_compile_faster(<target> [<room> ...]): what waits for people, files or other programs, and computes little: optimising it
# fully would take a third of its compile time. Of the rooms named, else all of it.
function(cas_compile_faster target)
  if(CAS_SANITIZE)
    return()
  endif()
  if(NOT ARGN)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
    return()
  endif()
  list(JOIN ARGN "|" rooms)
  get_target_property(sources ${target} SOURCES)
  get_target_property(folder ${target} SOURCE_DIR)
  foreach(source IN LISTS sources)
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${folder} NORMALIZE)
    cmake_path(RELATIVE_PATH source BASE_DIRECTORY ${folder} OUTPUT_VARIABLE below)
    if(below MATCHES "^(${rooms})/.*cpp$")
      set_source_files_properties(${source} TARGET_DIRECTORY ${target} PROPERTIES COMPILE_OPTIONS "$<$<CONFIG:Release>:-O1>")
    endif()
  endforeach()
endfunction()
