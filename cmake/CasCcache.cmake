# SPDX-License-Identifier: BSD-3-Clause
# ccache, where it is installed: a second build of the same text compiles nothing. Paths below the checkout are seen as
# relative ones, so that another clone of the same tree finds the same objects (the compiler's working folder, which
# debug information names, is left out for that reason). CCACHE_DEPEND finds the headers of a file in the compiler's own
# list: a file that is not in the cache is not preprocessed first.
find_program(CAS_CCACHE ccache DOC "ccache, or empty to compile each file anew")
mark_as_advanced(CAS_CCACHE)
if(CAS_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${PROJECT_SOURCE_DIR} CCACHE_NOHASHDIR=1 CCACHE_DEPEND=1
      CCACHE_SLOPPINESS=time_macros,include_file_mtime,include_file_ctime ${CAS_CCACHE})
endif()
