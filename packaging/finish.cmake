# Run by cpack between installing and packing: what Debian's policy asks of every package.
set(root ${CPACK_TEMPORARY_DIRECTORY})
set(version ${CPACK_DEBIAN_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})
foreach(component ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${component} COMPONENT)
  set(package ${CPACK_DEBIAN_${COMPONENT}_PACKAGE_NAME})
  set(usr ${root}/${component}/usr)
  if(component STREQUAL kerbstone)
    foreach(tool crgbuild lidar2mesh crgdrive crgexplain)
      if(NOT EXISTS ${usr}/bin/${tool})
        message(FATAL_ERROR "${tool} is not built; build all four tools before packing (scripts/package)")
      endif()
    endforeach()
    file(GLOB_RECURSE car ${usr}/lib/kerbstone_car.so)
    if(NOT car)
      message(FATAL_ERROR "kerbstone_car.so is not built; build everything before packing (scripts/package)")
    endif()
    # What goes into units must need libc alone on machines that are not Debian.
    file(WRITE ${usr}/share/lintian/overrides/kerbstone
      "kerbstone: embedded-library zlib *kerbstone_car.so*\n")
  elseif(component STREQUAL opencrg)
    if(NOT EXISTS ${usr}/include/crgBaseLib.h)
      message(FATAL_ERROR "libOpenCRG.so is not built; build it before packing (scripts/package)")
    endif()
    # Programs know the library by a name without a version, and may bring another C++ runtime.
    file(WRITE ${usr}/share/lintian/overrides/libopencrg-kerbstone
      "libopencrg-kerbstone: shared-library-lacks-version *\n"
      "libopencrg-kerbstone: link-to-shared-library-in-wrong-package *\n")
  elseif(NOT EXISTS ${usr}/include/crg.h)
    message(FATAL_ERROR "libcrg.a is not built; build it before packing (scripts/package)")
  endif()
  set(doc ${usr}/share/doc/${package})
  file(MAKE_DIRECTORY ${doc})
  file(COPY ${CMAKE_CURRENT_LIST_DIR}/copyright DESTINATION ${doc})
  string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
  file(WRITE ${doc}/changelog.Debian
    "${package} (${version}) unstable; urgency=medium\n\n  * Packed from the source; see CHANGELOG.md of the project.\n\n"
    " -- ${CPACK_DEBIAN_PACKAGE_MAINTAINER}  ${date}\n")
  if(EXISTS ${doc}/CHANGELOG.md)
    file(RENAME ${doc}/CHANGELOG.md ${doc}/changelog)
  endif()
  file(GLOB compressed ${doc}/changelog* ${usr}/share/man/man1/*.1)
  execute_process(COMMAND gzip --best --no-name ${compressed} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
