# Packs what is built as scripts/package does and looks at what the packages hold.
# -DBUILD=<build folder> -DWORK=<scratch folder>
function(run)
  execute_process(COMMAND ${ARGV} WORKING_DIRECTORY ${WORK} RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    string(REPLACE ";" " " command "${ARGV}")
    message(FATAL_ERROR "${command}\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

find_program(SHLIBDEPS dpkg-shlibdeps)
find_program(FILE file)
if(NOT SHLIBDEPS OR NOT FILE)
  message("skipped: needs dpkg-dev and file (scripts/setup test)")
  return()
endif()
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK})
# What is packed counts, not how small it is. Which packages hold the shared libraries is asked for one small package, which
# shows that it is asked; for all of them, which takes half a minute, with KERBSTONE_HEAVY=1.
set(quick -D CPACK_DEBIAN_COMPRESSION_TYPE=none)
set(depends "")
if(DEFINED ENV{KERBSTONE_HEAVY})
  set(depends "Depends: .*libassimp")
else()
  list(APPEND quick -D CPACK_DEBIAN_KERBSTONE_PACKAGE_SHLIBDEPS=OFF -D CPACK_DEBIAN_PYTHON_PACKAGE_SHLIBDEPS=OFF)
endif()
run(cpack --config ${BUILD}/CPackConfig.cmake -B ${WORK} ${quick})

# What the packed files hold: seen in the build folder, where they are not stripped.
include(${CMAKE_CURRENT_LIST_DIR}/check_holdings.cmake)

function(expect package)
  file(GLOB deb ${WORK}/${package}_*.deb)
  run(dpkg-deb --info ${deb})
  set(said "${output}")
  run(dpkg-deb --contents ${deb})
  string(APPEND said "${output}")
  foreach(wanted ${ARGN})
    if(NOT said MATCHES "${wanted}")
      message(SEND_ERROR "${package}: no '${wanted}' in\n${said}")
    endif()
  endforeach()
endfunction()

set(every "Maintainer: Kerbstone developers" "Version: [0-9.]+-1\n" "Architecture: " "/copyright\n" "/changelog.Debian.gz\n")
set(tools "")
foreach(tool crgbuild lidar2mesh crgdrive crgexplain crgidentify kerbstone)
  list(APPEND tools "-rwxr-xr-x root/root .* ./usr/bin/${tool}\n" "./usr/share/man/man1/${tool}.1.gz\n"
    "./usr/share/bash-completion/completions/${tool}\n")
endforeach()
expect(kerbstone ${every} ${tools} ${depends} "Section: science" "./usr/lib/.*kerbstone/kerbstone_car.so\n" "./usr/share/doc/kerbstone/docs/crgbuild.md\n")
expect(libcrg-dev ${every} "Section: libdevel" "libstdc\\+\\+-dev" "./usr/lib/.*libcrg.a\n" "./usr/include/crg.h\n"
  "./usr/include/crg/surface.h\n" "/crgConfig.cmake\n" "/pkgconfig/crg.pc\n" "/examples/c/example.c\n")
expect(libopencrg-kerbstone ${every} "Section: libs" "Depends: .*libc6" "./usr/lib/.*libOpenCRG.so\n" "./usr/include/crgBaseLib.h\n" "./usr/include/crgBaseLibPrivate.h\n"
  "/OpenCRGConfig.cmake\n" "/pkgconfig/OpenCRG.pc\n" "/examples/opencrg/drive.c\n")
file(GLOB python ${BUILD}/lib/python/kerbstone.*.so)
if(python)
  expect(python3-kerbstone ${every} "Section: python" "Depends: .*python3-numpy" "./usr/lib/python3/dist-packages/kerbstone.*.so\n"
    "./usr/lib/python3/dist-packages/kerbstone.pyi\n")
endif()
file(REMOVE_RECURSE ${WORK})
