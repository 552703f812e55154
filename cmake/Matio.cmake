# matio ships a pkg-config file and no CMake package: find the parts directly.
find_path(MATIO_INCLUDE_DIR matio.h REQUIRED)
find_library(MATIO_LIBRARY matio REQUIRED)

add_library(matio::matio UNKNOWN IMPORTED)
set_target_properties(matio::matio PROPERTIES IMPORTED_LOCATION ${MATIO_LIBRARY}
  INTERFACE_INCLUDE_DIRECTORIES ${MATIO_INCLUDE_DIR} INTERFACE_SYSTEM_INCLUDE_DIRECTORIES ${MATIO_INCLUDE_DIR})
