# SPDX-License-Identifier: BSD-3-Clause
# Install rules and the exported packages, in the components common, casd, sim, dev and mavlink; for a companion computer
# (CAS_COMPANION) in common, casd and mavlink.
include(CMakePackageConfigHelpers)

install(TARGETS casd casctl RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT casd)
if(CAS_COMPANION)
  install(TARGETS cas_base LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT common NAMELINK_SKIP)
else()
  include(CasSimInstall)
endif()

# The MAVLink library is a package of its own, which needs nothing else of the project: find_package(cas_mavlink) gives
# cas::mavlink_runtime, cas::mavlink, cas::mavlink_services, cas::mavlink_json, cas::mavlink_parser and cas_mavlink_generate().
set(mavlink_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/cas_mavlink)
install(TARGETS cas_mavlink_runtime cas_mavlink cas_mavlink_parser cas_mavlink_services cas_mavlink_json mavlink_gen EXPORT cas-mavlink-targets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT mavlink
        RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT mavlink
        INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cas)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/mavlink_gen/runtime ${PROJECT_SOURCE_DIR}/mavlink_gen/parser
                  ${PROJECT_SOURCE_DIR}/mavlink_gen/services ${PROJECT_SOURCE_DIR}/mavlink_gen/json
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cas/mavlink_gen COMPONENT mavlink FILES_MATCHING PATTERN "*.hpp")
install(DIRECTORY ${CAS_MAVLINK_INCLUDE_DIR}/mavlink DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cas COMPONENT mavlink)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/mavlink_gen/dialects/ DESTINATION ${CMAKE_INSTALL_DATADIR}/cas/mavlink
        COMPONENT mavlink FILES_MATCHING PATTERN "*.xml")
install(DIRECTORY ${PROJECT_SOURCE_DIR}/tests/mavlink_gen/examples/ DESTINATION ${CMAKE_INSTALL_DATADIR}/cas/examples/mavlink
        COMPONENT mavlink)
install(EXPORT cas-mavlink-targets NAMESPACE cas:: DESTINATION ${mavlink_package_dir} COMPONENT mavlink)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/cas_mavlinkConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_SOURCE_DIR}/cmake/cas_mavlinkConfig.cmake ${PROJECT_SOURCE_DIR}/cmake/CasMavlink.cmake
              ${PROJECT_BINARY_DIR}/cas_mavlinkConfigVersion.cmake
        DESTINATION ${mavlink_package_dir} COMPONENT mavlink)
