# SPDX-License-Identifier: BSD-3-Clause
# Debian packages by CPack: cas-common (libraries, shipped configuration), casd (with casctl and casweb), cas-sim (hilsim with its
# plugins, hils, fcu_emulator), cas-dev, cas-mavlink-dev, python3-cas and, where pybind11-dev is installed,
# python3-cas-env. For a build with CAS_PACKAGE=ON and CMAKE_INSTALL_PREFIX=/usr: scripts/package. For a companion computer
# cas-common, casd without casweb, and cas-mavlink-dev.
set(debian ${PROJECT_SOURCE_DIR}/packaging/debian)
set(exactly "(= ${PROJECT_VERSION})")

# The service, its configuration in /etc, rules for devices.
install(FILES ${PROJECT_SOURCE_DIR}/config/topologies/pixhawk_usb.yaml DESTINATION /etc/cas RENAME casd.yaml
        COMPONENT casd)
install(FILES ${PROJECT_SOURCE_DIR}/config/systemd/casd.service DESTINATION /lib/systemd/system COMPONENT casd)
if(NOT CAS_COMPANION)
  install(FILES ${PROJECT_SOURCE_DIR}/config/systemd/casweb.service DESTINATION /lib/systemd/system COMPONENT casd)
endif()
install(FILES ${PROJECT_SOURCE_DIR}/config/udev/61-cas-pixhawk.rules DESTINATION /lib/udev/rules.d COMPONENT casd)
install(FILES ${PROJECT_SOURCE_DIR}/config/systemd/cas-modules.conf DESTINATION /usr/lib/modules-load.d
        RENAME cas.conf COMPONENT casd)
install(FILES ${PROJECT_SOURCE_DIR}/config/systemd/cas-sysusers.conf DESTINATION /usr/lib/sysusers.d
        RENAME cas.conf COMPONENT casd)
install(FILES ${PROJECT_SOURCE_DIR}/config/systemd/casd-realtime.conf
        ${PROJECT_SOURCE_DIR}/config/udev/62-cas-cpu-latency.rules
        DESTINATION ${CMAKE_INSTALL_DOCDIR}/../casd/examples COMPONENT casd)

# The Python package, with the dialects that its codec reads.
set(python_dir lib/python3/dist-packages/cas)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/python/cas/ DESTINATION ${python_dir} COMPONENT python
        FILES_MATCHING PATTERN "*.py" PATTERN "py.typed" PATTERN "__pycache__" EXCLUDE PATTERN "dialects" EXCLUDE)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/mavlink_gen/dialects DESTINATION ${python_dir} COMPONENT python
        FILES_MATCHING PATTERN "*.xml")
install(DIRECTORY ${PROJECT_SOURCE_DIR}/python/examples DESTINATION /usr/share/doc/python3-cas COMPONENT python
        FILES_MATCHING PATTERN "*.py" PATTERN "__pycache__" EXCLUDE)

# Files of each package in /usr/share/doc.
set(changelog ${PROJECT_BINARY_DIR}/changelog.gz)
execute_process(COMMAND gzip -9nc ${debian}/changelog OUTPUT_FILE ${changelog} COMMAND_ERROR_IS_FATAL ANY)
foreach(pair common:cas-common casd:casd sim:cas-sim dev:cas-dev mavlink:cas-mavlink-dev python:python3-cas)
  string(REPLACE ":" ";" pair ${pair})
  list(GET pair 0 component)
  list(GET pair 1 package)
  install(FILES ${debian}/copyright ${changelog} DESTINATION /usr/share/doc/${package} COMPONENT ${component})
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package})
  set(CPACK_DEBIAN_${upper}_FILE_NAME DEB-DEFAULT)
endforeach()
install(FILES ${PROJECT_SOURCE_DIR}/README.md DESTINATION /usr/share/doc/cas-common COMPONENT common)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/docs DESTINATION /usr/share/doc/cas-common COMPONENT common
        FILES_MATCHING PATTERN "*.md" PATTERN "*.png")

set(CPACK_GENERATOR DEB)
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL common casd mavlink)
if(NOT CAS_COMPANION)
  list(APPEND CPACK_COMPONENTS_ALL sim dev python)
endif()
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_PACKAGE_NAME cas)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
# Each package has a first line of its own: CPack puts nothing ahead of it if this equals its default.
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${CMAKE_PROJECT_NAME} built using CMake")
set(CPACK_PACKAGE_CONTACT "The CAS authors <cas@packages.debian.org>")
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/lib)

set(CPACK_DEBIAN_COMMON_PACKAGE_CONTROL_EXTRA ${debian}/triggers)
set(CPACK_DEBIAN_COMMON_PACKAGE_SECTION libs)
set(CPACK_COMPONENT_COMMON_DESCRIPTION "hardware-in-the-loop simulation for UAVs, common files
The libraries and the shipped configuration of CAS: vehicles, worlds, sensor
sets, scenarios and topologies, with the documentation.")

set(CPACK_DEBIAN_CASD_PACKAGE_DEPENDS "cas-common ${exactly}, passwd")
set(CPACK_DEBIAN_CASD_PACKAGE_CONTROL_EXTRA
    "${debian}/conffiles;${debian}/postinst;${debian}/prerm;${debian}/postrm")
set(CPACK_COMPONENT_CASD_DESCRIPTION "MAVLink router and command port for HIL simulation
casd routes MAVLink between simulator, flight controller and ground stations,
counts what is lost and why, and takes commands. casctl commands and watches
it from the terminal, casweb shows it in a browser.")

set(CPACK_DEBIAN_SIM_PACKAGE_DEPENDS "cas-common ${exactly}")
set(CPACK_DEBIAN_SIM_PACKAGE_CONTROL_EXTRA ${debian}/triggers)
set(CPACK_DEBIAN_SIM_PACKAGE_RECOMMENDS "casd ${exactly}")
set(CPACK_COMPONENT_SIM_DESCRIPTION "quadrotor simulator with HIL sensors and an emulated autopilot
hilsim simulates vehicles, sensors and weather as plugins; fcu_emulator is a
flight controller on a pseudo-terminal; hils flies experiments with both, or
with a real Pixhawk, measures and judges them.")

set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "cas-common ${exactly}, cas-mavlink-dev ${exactly}, libeigen3-dev")
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_DEV_DESCRIPTION "headers and CMake package of CAS
What it takes to build a plugin for the simulator outside of its tree.")

set(CPACK_DEBIAN_MAVLINK_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_MAVLINK_PACKAGE_SUGGESTS "g++, cmake, libexpat1-dev, nlohmann-json3-dev")
set(CPACK_COMPONENT_MAVLINK_DESCRIPTION "MAVLink for C++20: generator of codecs, runtime, parser
mavlink_gen turns dialects into headers that need the standard library alone;
with them come a receiver, signing, a dialect that is generated already,
services (commands, parameters, missions, vehicle state, logs) and libraries
that read dialects while a program runs (with libexpat1-dev).")

set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_PYTHON_PACKAGE_GENERATE_SHLIBS OFF)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.11)")
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS "casd ${exactly}, cas-sim ${exactly}")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "python3-numpy, python3-matplotlib")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_CONTROL_EXTRA "${debian}/python/postinst;${debian}/python/prerm")
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "HIL simulation for UAVs from Python
Package cas: commands casd, steps the simulator, starts whole benches and
scenarios, reads their results and logs, and speaks MAVLink.")

# The environments of cas.env, for the one Python that they were built with.
if(TARGET _cas_env)
  find_package(Python3 3.11 REQUIRED COMPONENTS Interpreter)
  install(TARGETS _cas_env LIBRARY DESTINATION lib/python3/dist-packages COMPONENT env)
  install(FILES ${debian}/copyright ${changelog} DESTINATION /usr/share/doc/python3-cas-env COMPONENT env)
  list(APPEND CPACK_COMPONENTS_ALL env)
  math(EXPR next_minor "${Python3_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_ENV_PACKAGE_NAME python3-cas-env)
  set(CPACK_DEBIAN_ENV_FILE_NAME DEB-DEFAULT)
  set(CPACK_DEBIAN_ENV_PACKAGE_DEPENDS "python3-cas ${exactly}, cas-sim ${exactly}, python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${next_minor})")
  set(CPACK_DEBIAN_ENV_PACKAGE_SUGGESTS "python3-numpy")
  set(CPACK_DEBIAN_ENV_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_ENV_PACKAGE_GENERATE_SHLIBS OFF)
  set(CPACK_COMPONENT_ENV_DESCRIPTION "simulator of UAVs as an environment for Python
Extension of package cas: reset and step by one control period, inside the
process, for optimisers and learners.")
endif()

include(CPack)
