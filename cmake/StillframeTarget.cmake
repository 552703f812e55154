# Settings that every target of the project shares, and one function to make a library of a folder.

set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

option(STILLFRAME_WARNINGS_AS_ERRORS "Treat compiler warnings as errors" OFF)
option(STILLFRAME_UNITY "Compile files in batches, which share their templates: half the time of a whole build" ON)
option(STILLFRAME_FUZZ "Build the fuzz targets, with clang, and nothing else" OFF)
set(STILLFRAME_SANITIZE "" CACHE STRING "Sanitizers to compile with, as in -fsanitize=...")

if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # The sloppiness lets ccache reuse objects that were compiled with a precompiled header.
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env
    CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime ${CCACHE_PROGRAM})
endif()

add_library(stillframe_settings INTERFACE)
target_compile_options(stillframe_settings INTERFACE -Wall -Wextra -Wpedantic -Wshadow
  # GCC 12 warns of std::string concatenation where there is nothing (its bug 105329).
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict$<SEMICOLON>-Wno-stringop-overflow$<SEMICOLON>-Wno-stringop-overread$<SEMICOLON>-Wno-array-bounds>
  $<$<AND:$<BOOL:${CCACHE_PROGRAM}>,$<CXX_COMPILER_ID:GNU>>:-fpch-preprocess>
  $<$<BOOL:${STILLFRAME_WARNINGS_AS_ERRORS}>:-Werror>)
if(STILLFRAME_SANITIZE)
  target_compile_options(stillframe_settings INTERFACE -fsanitize=${STILLFRAME_SANITIZE}
    -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(stillframe_settings INTERFACE -fsanitize=${STILLFRAME_SANITIZE})
endif()

# What a file has for itself, its anonymous namespace, is its batch's here: two names must not meet in it.
# Of 4, 8, 14 and 40 in a batch the mechanics take 136, 119, 127 and some 190 s; 14 cost less than 8 in control.
function(stillframe_batches target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${STILLFRAME_UNITY} UNITY_BUILD_BATCH_SIZE 14)
endfunction()

# stillframe_library(NAME SOURCES... [PUBLIC libs...] [PRIVATE libs...]) makes stillframe_NAME, known as
# stillframe::NAME, whose headers are included by their path from the top of the repository.
function(stillframe_library name)
  cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
  add_library(stillframe_${name} STATIC ${ARG_SOURCES})
  add_library(stillframe::${name} ALIAS stillframe_${name})
  target_include_directories(stillframe_${name} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}/stillframe>)
  target_compile_features(stillframe_${name} PUBLIC cxx_std_20)
  target_link_libraries(stillframe_${name} PUBLIC ${ARG_PUBLIC} stillframe::eigen
    PRIVATE ${ARG_PRIVATE} $<BUILD_INTERFACE:stillframe_settings>)
  stillframe_precompile(stillframe_${name})
  stillframe_batches(stillframe_${name})
  set_target_properties(stillframe_${name} PROPERTIES EXPORT_NAME ${name})
endfunction()
