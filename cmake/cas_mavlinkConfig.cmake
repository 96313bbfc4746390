# SPDX-License-Identifier: BSD-3-Clause
# The parser is a static library above expat; everything else does without it.
find_package(EXPAT QUIET)

include(${CMAKE_CURRENT_LIST_DIR}/cas-mavlink-targets.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/CasMavlink.cmake)
