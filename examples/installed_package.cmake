# Installs the build tree into a folder of its own, and configures and builds the examples against it.
set(prefix ${BUILD}/installed_package)
file(REMOVE_RECURSE ${prefix})
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${ARGN}\n${output}")
  endif()
endfunction()
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix}/usr)
if(NOT EXISTS ${prefix}/usr/share/stillframe/json/verdict.schema.json)
  message(FATAL_ERROR "the schemas of docs/json are not installed")
endif()
if(NOT EXISTS ${prefix}/usr/share/man/man1/stillframe-design.1.gz)
  message(FATAL_ERROR "no manual pages are installed")
endif()
run(bash -c "source ${prefix}/usr/share/bash-completion/completions/stillframe
  COMP_WORDS=(stillframe sweep --se) COMP_CWORD=2; _stillframe; test \"\${COMPREPLY[*]}\" = --set
  COMP_WORDS=(stillframe swe) COMP_CWORD=1; _stillframe; test \"\${COMPREPLY[*]}\" = sweep")
foreach(example 01_linear_model 02_gains 03_closed_loop 04_hardware 05_scene_in_cpp 06_rig)
  run(${CMAKE_COMMAND} -S ${EXAMPLES}/${example} -B ${prefix}/${example} -G ${GENERATOR} -DCMAKE_CXX_COMPILER=${COMPILER}
    # With other vector instructions than the package has: what one allocates the other must be able to free.
    -DCMAKE_BUILD_TYPE=Release -DCMAKE_PREFIX_PATH=${prefix}/usr -DCMAKE_CXX_FLAGS=${NATIVE})
  run(${CMAKE_COMMAND} --build ${prefix}/${example})
endforeach()
run(${prefix}/02_gains/gains ${prefix}/usr/share/stillframe/config/scenes/metrology_frame.yaml)
