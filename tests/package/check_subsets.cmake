# Installs from a build folder where nothing, then one tool only was built.
# -DBUILD=<build folder, everything built> -DSOURCE=<checkout> -DWORK=<scratch folder>
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE failed OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(failed)
    string(REPLACE ";" " " command "${ARGV}")
    message(FATAL_ERROR "${command}\n${output}")
  endif()
endfunction()

# The programs and libraries below the prefix are those.
function(expect prefix)
  file(GLOB_RECURSE found RELATIVE ${WORK}/${prefix} ${WORK}/${prefix}/bin/* ${WORK}/${prefix}/*.a ${WORK}/${prefix}/*.1
    ${WORK}/${prefix}/share/bash-completion/completions/* ${WORK}/${prefix}/include/*.h ${WORK}/${prefix}/*/crgConfig.cmake)
  if(NOT found STREQUAL "${ARGN}")
    message(SEND_ERROR "${prefix}: '${found}' was installed, '${ARGN}' expected")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} -G Ninja -S ${SOURCE} -B ${WORK}/build -DKERBSTONE_TESTS=OFF)
run(${CMAKE_COMMAND} --install ${WORK}/build --prefix ${WORK}/nothing)
expect(nothing)
foreach(built tools/crgbuild/crgbuild share/man/man1/crgbuild.1 share/bash-completion/completions/crgbuild)
  get_filename_component(folder ${built} DIRECTORY)
  file(COPY ${BUILD}/${built} DESTINATION ${WORK}/build/${folder})
endforeach()
run(${CMAKE_COMMAND} --install ${WORK}/build --prefix ${WORK}/one)
expect(one bin/crgbuild share/bash-completion/completions/crgbuild share/man/man1/crgbuild.1)
run(${WORK}/one/bin/crgbuild --version)
file(REMOVE_RECURSE ${WORK})
