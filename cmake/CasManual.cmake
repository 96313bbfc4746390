# SPDX-License-Identifier: BSD-3-Clause
# Manual pages and completion scripts of the programs, which print them themselves (`--manual`), and their installation.
find_program(GZIP gzip REQUIRED)
set(manual_dir ${PROJECT_BINARY_DIR}/manual)
set(manual_files)

# cas_add_manual(<program> <component>)
function(cas_add_manual program component)
  set(man ${manual_dir}/${program}.1)
  set(bash ${manual_dir}/bash/${program})
  set(zsh ${manual_dir}/zsh/_${program})
  set(fish ${manual_dir}/fish/${program}.fish)
  add_custom_command(
    OUTPUT ${man}.gz ${bash} ${zsh} ${fish}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${manual_dir}/bash ${manual_dir}/zsh ${manual_dir}/fish
    COMMAND ${program} --manual man > ${man}
    COMMAND ${GZIP} -9nf ${man}
    COMMAND ${program} --manual bash > ${bash}
    COMMAND ${program} --manual zsh > ${zsh}
    COMMAND ${program} --manual fish > ${fish}
    DEPENDS ${program} VERBATIM COMMENT "Manual of ${program}")
  install(FILES ${man}.gz DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT ${component})
  install(FILES ${bash} DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT ${component})
  install(FILES ${zsh} DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions COMPONENT ${component})
  install(FILES ${fish} DESTINATION ${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d COMPONENT ${component})
  set(manual_files ${manual_files} ${man}.gz ${bash} PARENT_SCOPE)
endfunction()

cas_add_manual(casd casd)
cas_add_manual(casctl casd)
cas_add_manual(mavlink_gen mavlink)
if(NOT CAS_COMPANION)
  cas_add_manual(casweb casd)
  cas_add_manual(hilsim sim)
  cas_add_manual(fcu_emulator sim)
  cas_add_manual(hils sim)
endif()
add_custom_target(manual ALL DEPENDS ${manual_files})
