# Installs the build tree into a folder of its own, and configures and builds an example against it.
set(prefix ${BUILD}/installed_package)
file(REMOVE_RECURSE ${prefix})
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${ARGN}\n${output}")
  endif()
endfunction()
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix}/usr)
run(${CMAKE_COMMAND} -S ${EXAMPLE} -B ${prefix}/build -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${COMPILER}
  -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH=${prefix}/usr)
run(${CMAKE_COMMAND} --build ${prefix}/build)
run(${prefix}/build/first ${prefix}/usr/share/stillframe/config/scenes/metrology_frame.yaml)
