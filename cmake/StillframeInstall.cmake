# What another project gets: the programs, the libraries and headers, and find_package(stillframe).
include(CMakePackageConfigHelpers)

install(TARGETS stillframe_eigen stillframe_files stillframe_numerics stillframe_systems stillframe_yaml stillframe_control
                stillframe_mechanics stillframe_design stillframe_robustness stillframe_core stillframe_msgs stillframe_floor stillframe_nodal
                stillframe_plant_sim stillframe_controller stillframe_report
  EXPORT stillframe_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT stillframe_targets NAMESPACE stillframe::
  FILE stillframe-targets.cmake DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/stillframe)
foreach(folder core msgs plant_sim controller report)
  install(DIRECTORY ${folder}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/stillframe/${folder}
    FILES_MATCHING PATTERN "*.hpp"
    # Libraries of the programs alone.
    PATTERN "analysis" EXCLUDE PATTERN "export" EXCLUDE PATTERN "live" EXCLUDE PATTERN "page" EXCLUDE)
endforeach()
install(FILES include/stillframe.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/stillframe)
install(DIRECTORY config DESTINATION ${CMAKE_INSTALL_DATADIR}/stillframe)
install(DIRECTORY docs/json DESTINATION ${CMAKE_INSTALL_DATADIR}/stillframe)
install(PROGRAMS scripts/private_network DESTINATION ${CMAKE_INSTALL_DATADIR}/stillframe)

configure_package_config_file(cmake/stillframe-config.cmake.in ${CMAKE_BINARY_DIR}/stillframe-config.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/stillframe)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/stillframe-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/stillframe-config.cmake ${CMAKE_BINARY_DIR}/stillframe-config-version.cmake
              cmake/Lcm.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/stillframe)
