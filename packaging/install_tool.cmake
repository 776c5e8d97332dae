include(GNUInstallDirs)

# Installs a tool with its man page and its completion for bash, which it prints itself; nothing where
# it was not built.
function(install_tool tool)
  # Not optimised in the tests alone. Shipped, the linker would take such copies of templates for the libraries' too.
  target_compile_options(${tool} PRIVATE $<$<CXX_COMPILER_ID:Clang>:${KERBSTONE_PLAIN}>)
  install(TARGETS ${tool} OPTIONAL DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT kerbstone)
  set(share ${PROJECT_BINARY_DIR}/share)
  file(MAKE_DIRECTORY ${share}/man/man1 ${share}/bash-completion/completions)
  set(man ${share}/man/man1/${tool}.1)
  set(completion ${share}/bash-completion/completions/${tool})
  add_custom_command(TARGET ${tool} POST_BUILD VERBATIM BYPRODUCTS ${man} ${completion}
    COMMAND ${tool} --man > ${man}
    COMMAND ${tool} --completion > ${completion})
  install(FILES ${man} OPTIONAL DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT kerbstone)
  install(FILES ${completion} OPTIONAL
    DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT kerbstone)
endfunction()
