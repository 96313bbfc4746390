# SPDX-License-Identifier: BSD-3-Clause
# Installed headers keep the names that users include: for each header in a room of base/ or libsim/core/
# ("base/time/clock.hpp") the name without the room ("base/clock.hpp") is installed too and includes it.
set(forward_dir ${PROJECT_BINARY_DIR}/forward)
file(REMOVE_RECURSE ${forward_dir})  # names of headers that are gone
foreach(room base/config base/earth base/measure base/os base/time
             libsim/core/body libsim/core/load libsim/core/run)
  get_filename_component(flat ${room} DIRECTORY)
  file(GLOB headers CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR}/${room} ${PROJECT_SOURCE_DIR}/${room}/*.hpp)
  foreach(header IN LISTS headers)
    file(CONFIGURE OUTPUT ${forward_dir}/${flat}/${header} CONTENT "#include \"${room}/${header}\"\n")
  endforeach()
endforeach()
install(DIRECTORY ${forward_dir}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cas COMPONENT dev)
