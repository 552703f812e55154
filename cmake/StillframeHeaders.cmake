# What nearly every file includes is parsed once: one precompiled header for what is shipped and one for the tests,
# which are compiled with other options. clang takes a precompiled header from the same options only, so it does
# without; no file relies on them for its includes.

set(stillframe_headers ${PROJECT_SOURCE_DIR}/core/numerics/eigen/once.hpp
  <algorithm> <filesystem> <fstream> <functional> <iostream> <map> <memory> <optional> <random> <string> <vector>)

# stillframe_precompile(TARGET) for what is shipped; stillframe_precompile(TARGET TEST) for what links GoogleTest.
function(stillframe_precompile target)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    return()
  endif()
  if("TEST" IN_LIST ARGN)
    target_precompile_headers(${target} REUSE_FROM stillframe_test_headers)
  else()
    target_precompile_headers(${target} REUSE_FROM stillframe_eigen)
  endif()
endfunction()
