# Scripts and styles of pages, made from report/page/web and embedded in a library.
set(STILLFRAME_WEB_DIR ${CMAKE_CURRENT_LIST_DIR}/web)
set(STILLFRAME_EMBED_DIR ${CMAKE_CURRENT_LIST_DIR})
find_program(NODE_PROGRAM NAMES node nodejs)

# stillframe_embed(TARGET SYMBOL FILE) puts a file into a library as
#   namespace stillframe::page { std::string_view SYMBOL(); }
# The assembler copies it, so that a megabyte costs no compile time.
function(stillframe_embed target symbol file)
  set(SYMBOL ${symbol})
  set(FILE ${file})
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${symbol}.cpp)
  configure_file(${STILLFRAME_EMBED_DIR}/embedded.cpp.in ${source} @ONLY)
  set_source_files_properties(${source} PROPERTIES OBJECT_DEPENDS ${file})
  target_sources(${target} PRIVATE ${source})
endfunction()

# stillframe_page_script(TARGET NAME) bundles web/src/NAME.js with all that it imports and embeds it as
# NAME_script() and NAME_script_hash(), the latter as a content security policy wants it.
function(stillframe_page_script target name)
  set(script ${CMAKE_CURRENT_BINARY_DIR}/${name}.js)
  set(hash ${CMAKE_CURRENT_BINARY_DIR}/${name}.hash)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${STILLFRAME_WEB_DIR}/src/*)
  if(NOT NODE_PROGRAM)
    message(FATAL_ERROR "Node.js is missing, which bundles the scripts of the report; run scripts/setup")
  endif()
  add_custom_command(OUTPUT ${script} ${hash}
    COMMAND ${NODE_PROGRAM} ${STILLFRAME_WEB_DIR}/build.mjs ${name}.js ${script} ${hash}
    DEPENDS ${sources} ${STILLFRAME_WEB_DIR}/build.mjs ${STILLFRAME_WEB_DIR}/package-lock.json
    COMMENT "Bundling ${name}.js" VERBATIM)
  stillframe_embed(${target} ${name}_script ${script})
  stillframe_embed(${target} ${name}_script_hash ${hash})
endfunction()
