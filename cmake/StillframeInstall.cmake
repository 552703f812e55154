# What another project gets: the programs, the libraries and headers, and find_package(stillframe).
include(CMakePackageConfigHelpers)

set(installed_libraries
  stillframe_eigen stillframe_files stillframe_numerics stillframe_systems stillframe_yaml stillframe_control stillframe_mechanics stillframe_design stillframe_robustness stillframe_fitting
  stillframe_core stillframe_msgs stillframe_floor stillframe_nodal stillframe_plant_sim stillframe_controller stillframe_report)
install(TARGETS ${installed_libraries}
  EXPORT stillframe_targets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT development)
# All that is installed, without tests and benches.
add_custom_target(installed DEPENDS ${installed_libraries} stillframe stillframe-plant stillframe-controller)
install(EXPORT stillframe_targets NAMESPACE stillframe::
  FILE stillframe-targets.cmake DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/stillframe COMPONENT development)
foreach(folder core msgs plant_sim controller report)
  install(DIRECTORY ${folder}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/stillframe/${folder}
    COMPONENT development
    FILES_MATCHING PATTERN "*.hpp"
    # Libraries of the programs alone.
    PATTERN "analysis" EXCLUDE PATTERN "export" EXCLUDE PATTERN "live" EXCLUDE PATTERN "page" EXCLUDE)
endforeach()
install(FILES include/stillframe.hpp DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/stillframe COMPONENT development)
install(DIRECTORY config DESTINATION ${CMAKE_INSTALL_DATADIR}/stillframe COMPONENT program)
install(DIRECTORY docs/json DESTINATION ${CMAKE_INSTALL_DATADIR}/stillframe COMPONENT program)
install(FILES docs/scene.md DESTINATION ${CMAKE_INSTALL_DATADIR}/stillframe/docs COMPONENT program)
install(PROGRAMS scripts/private_network DESTINATION ${CMAKE_INSTALL_DATADIR}/stillframe COMPONENT program)
install(FILES LICENSE RENAME copyright DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT program)
# From what the programs say of themselves: manual pages, and completion for bash.
install(CODE "execute_process(COMMAND ${CMAKE_SOURCE_DIR}/cmake/manual.py ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}
  \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR} COMMAND_ERROR_IS_FATAL ANY)" COMPONENT program)
install(DIRECTORY python/stillframe DESTINATION lib/python3/dist-packages COMPONENT python
  FILES_MATCHING PATTERN "*.py" PATTERN "py.typed")

configure_package_config_file(cmake/stillframe-config.cmake.in ${CMAKE_BINARY_DIR}/stillframe-config.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/stillframe)
write_basic_package_version_file(${CMAKE_BINARY_DIR}/stillframe-config-version.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_BINARY_DIR}/stillframe-config.cmake ${CMAKE_BINARY_DIR}/stillframe-config-version.cmake
              cmake/Lcm.cmake
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/stillframe COMPONENT development)

include(StillframePackages)
