# Debian packages of what is installed (docs/releasing.md): the programs, what others build against, and the Python
# module. `cpack` in the build tree makes them; scripts/package does all of it.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME stillframe)
set(CPACK_PACKAGE_CONTACT "The stillframe authors <stillframe@example.org>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL program development python)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)

set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME stillframe)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_DEPENDS "liblcm-bin, gnuplot-nox, iproute2, util-linux")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "python3-stillframe, slurm-client, parallel")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libstillframe-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION "libraries, headers and find_package(stillframe)")
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "libeigen3-dev, libspectra-dev, libsundials-dev, liblcm-dev, libglib2.0-dev, \
libyaml-cpp-dev, nlohmann-json3-dev, libspdlog-dev, libmatio-dev, libkissfft-dev, zlib1g-dev")

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-stillframe)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_ARCHITECTURE all)
set(CPACK_COMPONENT_PYTHON_DESCRIPTION "the Python module")
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3, python3-numpy, stillframe (>= ${PROJECT_VERSION})")
include(CPack)
