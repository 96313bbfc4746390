# SPDX-License-Identifier: BSD-3-Clause
# Install rules of parts that a companion computer does not need: simulator, hils and page, and the exported package for plugins:
# find_package(cas) gives cas::base, cas::sim_api, cas::sim, cas_add_plugin() and all of find_package(cas_mavlink).
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/cas)

install(TARGETS cas_base cas_sim_api cas_sim EXPORT cas-targets
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT common NAMELINK_COMPONENT dev
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev
        INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cas)
install(TARGETS cas_sim_sdf LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT common NAMELINK_SKIP)
foreach(part cas_sim_rays cas_sim_terrain)
  if(TARGET ${part})
    install(TARGETS ${part} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT common NAMELINK_SKIP)
  endif()
endforeach()
if(TARGET cas_tune_search)
  install(TARGETS cas_tune_search LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT sim NAMELINK_SKIP)
endif()
install(TARGETS casweb RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT casd)
install(TARGETS hilsim fcu_emulator hils RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT sim)
install(PROGRAMS ${PROJECT_SOURCE_DIR}/libsim/hilsim/hilsim_run DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT sim)

foreach(folder base libsim/api libsim/core)
  install(DIRECTORY ${PROJECT_SOURCE_DIR}/${folder}/
          DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/cas/${folder} COMPONENT dev
          FILES_MATCHING PATTERN "*.hpp" PATTERN "ode" EXCLUDE)
endforeach()
include(CasForward)

install(DIRECTORY ${PROJECT_SOURCE_DIR}/tests/plugins/example_plugin/
        DESTINATION ${CMAKE_INSTALL_DATADIR}/cas/examples/pitot COMPONENT dev
        PATTERN build_and_run EXCLUDE)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/tests/plugins/examples/battery/
        DESTINATION ${CMAKE_INSTALL_DATADIR}/cas/examples/battery COMPONENT dev)

install(EXPORT cas-targets NAMESPACE cas:: DESTINATION ${package_dir} COMPONENT dev)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/casConfig.cmake.in
                              ${PROJECT_BINARY_DIR}/casConfig.cmake
                              INSTALL_DESTINATION ${package_dir}
                              PATH_VARS CAS_PLUGIN_INSTALL_DIR)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/casConfigVersion.cmake
                                 COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/casConfig.cmake ${PROJECT_BINARY_DIR}/casConfigVersion.cmake
              ${PROJECT_SOURCE_DIR}/cmake/CasPlugin.cmake
        DESTINATION ${package_dir} COMPONENT dev)
