# SPDX-License-Identifier: BSD-3-Clause
# Install rules and the exported package, in the components common, casd, sim and dev: find_package(cas) gives cas::base, cas::sim_api, cas::sim,
# cas::mavlink, cas_add_plugin() and cas_mavlink_generate().
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/cas)

install(TARGETS cas_base cas_sim_api cas_sim cas_mavlink EXPORT cas-targets
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT common NAMELINK_COMPONENT dev
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev
        INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cas)
install(TARGETS cas_sim_sdf LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT common NAMELINK_SKIP)
install(TARGETS mavlink_gen EXPORT cas-targets
        RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT dev)
install(TARGETS casd casctl RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT casd)
install(TARGETS hilsim fcu_emulator hils RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT sim)

foreach(folder base libsim/api libsim/core mavlink_gen/runtime)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder}/
          DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cas/${folder} COMPONENT dev
          FILES_MATCHING PATTERN "*.hpp" PATTERN "ode" EXCLUDE)
endforeach()
include(CasForward)
install(DIRECTORY ${CAS_MAVLINK_INCLUDE_DIR}/mavlink DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cas
        COMPONENT dev)

install(DIRECTORY ${PROJECT_SOURCE_DIR}/tests/plugins/example_plugin/
        DESTINATION ${CMAKE_INSTALL_DATADIR}/cas/examples/airspeed COMPONENT dev
        PATTERN build_and_run EXCLUDE)

install(EXPORT cas-targets NAMESPACE cas:: DESTINATION ${package_dir} COMPONENT dev)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/casConfig.cmake.in
                              ${PROJECT_BINARY_DIR}/casConfig.cmake
                              INSTALL_DESTINATION ${package_dir}
                              PATH_VARS CAS_PLUGIN_INSTALL_DIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/casConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/casConfig.cmake ${PROJECT_BINARY_DIR}/casConfigVersion.cmake
              ${PROJECT_SOURCE_DIR}/cmake/CasPlugin.cmake ${PROJECT_SOURCE_DIR}/cmake/CasMavlink.cmake
        DESTINATION ${package_dir} COMPONENT dev)
