# SPDX-License-Identifier: BSD-3-Clause
# cas_add_plugin(<name> <source>...): builds plugin <name> as a loadable library lib<name>.so.
#
# Inside the project the library lands in the build tree's plugins/ folder and is installed; outside, in the
# current binary folder. Symbols are hidden apart from the entry point, and unresolved ones fail the link.
function(cas_add_plugin name)
  set(target ${name}_plugin)
  add_library(${target} MODULE ${ARGN})
  set_target_properties(${target} PROPERTIES OUTPUT_NAME ${name} PREFIX "lib"
                        CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
  target_link_options(${target} PRIVATE -Wl,-z,defs)
  if(TARGET cas_options)
    if(CAS_SANITIZE)  # the sanitizer runtime is resolved by the program that loads the plugin
      set_target_properties(${target} PROPERTIES LINK_OPTIONS "")
    endif()
    target_link_libraries(${target} PRIVATE cas_options cas_sim_api cas_base)
    set_source_files_properties(${name}_plugin.cpp PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)  # cas_plugin_models is without
    set_target_properties(${target} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${CAS_PLUGIN_BUILD_DIR})
    if(NOT CAS_PLUGIN_NO_INSTALL)
      set_property(GLOBAL APPEND PROPERTY CAS_PLUGINS ${target})
      install(TARGETS ${target} LIBRARY DESTINATION ${CAS_PLUGIN_INSTALL_DIR} COMPONENT sim)
    endif()
  else()
    target_compile_features(${target} PRIVATE cxx_std_20)
    target_link_libraries(${target} PRIVATE cas::sim_api cas::base)
  endif()
endfunction()
