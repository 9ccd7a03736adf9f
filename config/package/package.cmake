# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
# `cpack -G DEB` in the build folder makes the Debian packages: lidard, lidard-pcl, python3-lidard (where it is built),
# liblidard-dev, lidard-sim (where the simulator is built), and the debug symbols of each. What runs on a vehicle is lidard alone.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME lidard)
set(CPACK_PACKAGE_VENDOR "the lidard authors")
set(CPACK_PACKAGE_CONTACT "the lidard authors <maintainers@lidard.example>")
set(CPACK_PACKAGE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/packages)
set(CPACK_VERBATIM_VARIABLES ON)
# Files that name their own place, as units do, are told the place where they will be.
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_COMPONENTS_ALL lidard dev)
if(TARGET lidard_pcl)
  list(APPEND CPACK_COMPONENTS_ALL pcl)
endif()
if(TARGET lidard_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
if(TARGET lidard-sim)
  list(APPEND CPACK_COMPONENTS_ALL sim)
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/finish.cmake)
set(CPACK_POST_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/installed_size.cmake)

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_DEBUGINFO_PACKAGE ON)
set(CPACK_DEBIAN_DEV_DEBUGINFO_PACKAGE OFF)

# The first line is the synopsis. Lines of 80 characters, as Debian wants them.
set(family "The lidard suite takes the packets of SICK, Hokuyo and Velodyne lidars and
publishes laser scans and clouds for ROS 1.")
set(CPACK_DEBIAN_LIDARD_PACKAGE_NAME lidard)
set(CPACK_DEBIAN_LIDARD_PACKAGE_SECTION misc)
set(CPACK_DEBIAN_LIDARD_DESCRIPTION "daemon for the lidars of a vehicle
${family}

One process receives what all lidars of a vehicle send, merges planar scans
into one and cuts virtual scans out of clouds. It replays, records, decodes
and draws captures, too. It listens to nothing until the lidars are named in
/etc/lidard/lidard.yaml and the service is enabled.")
set(CPACK_DEBIAN_LIDARD_PACKAGE_SUGGESTS
    "lidard-pcl, lidard-sim, python3-yaml, python3-rosmaster, python3-roslaunch, python3-rospy, python3-sensor-msgs, python3-visualization-msgs, rviz")
set(control ${CMAKE_CURRENT_LIST_DIR}/control)
set(CPACK_DEBIAN_LIDARD_PACKAGE_CONTROL_EXTRA
    ${control}/conffiles ${control}/postinst ${control}/prerm ${control}/postrm)

set(CPACK_DEBIAN_PCL_PACKAGE_NAME lidard-pcl)
set(CPACK_DEBIAN_PCL_PACKAGE_SECTION misc)
set(CPACK_DEBIAN_PCL_DESCRIPTION "module of lidard for the Point Cloud Library
${family}

This package writes PCD files (lidard decode --format pcd) and removes
outliers from clouds. It is apart since the Point Cloud Library of Debian
brings VTK, which no vehicle needs.")
set(CPACK_DEBIAN_PCL_PACKAGE_DEPENDS "lidard (= ${PROJECT_VERSION})")

set(CPACK_DEBIAN_PYTHON_PACKAGE_NAME python3-lidard)
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "captures of lidars as numpy arrays
${family}

This package reads captures in Python, and makes the merged and virtual scans
of a configuration, without the daemon and without ROS.")
# An extension module is for one minor version of Python.
math(EXPR next_python "0${Python3_VERSION_MINOR} + 1")
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
    "python3 (>= 3.${Python3_VERSION_MINOR}~), python3 (<< 3.${next_python}), python3-numpy")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SUGGESTS "lidard, python3-matplotlib")

set(CPACK_DEBIAN_SIM_PACKAGE_NAME lidard-sim)
set(CPACK_DEBIAN_SIM_PACKAGE_SECTION misc)
set(CPACK_DEBIAN_SIM_DESCRIPTION "virtual vehicle with lidars
${family}

This package plays the lidars: it sends what they would see while driving
through a scene, over UDP and TCP, or writes a capture with the truth.")
set(CPACK_DEBIAN_SIM_PACKAGE_SUGGESTS lidard)

set(CPACK_DEBIAN_DEV_PACKAGE_NAME liblidard-dev)
set(CPACK_DEBIAN_DEV_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEV_DESCRIPTION "lidar decoders of lidard as static libraries
${family}

This package has its drivers, which turn packets into scans and clouds without
a socket, thread or clock of their own, and its merging, as libraries with
headers and an example. For CMake: find_package(lidard).")
set(CPACK_DEBIAN_DEV_PACKAGE_DEPENDS "libboost-dev, libeigen3-dev, libpcap-dev, libtinyxml2-dev, libzstd-dev, nlohmann-json3-dev, pkg-config, zlib1g-dev")
set(CPACK_DEBIAN_DEV_PACKAGE_SHLIBDEPS OFF)

foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER ${component} upper)
  set(package ${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  install(FILES ${CMAKE_CURRENT_LIST_DIR}/copyright ${CMAKE_CURRENT_LIST_DIR}/changelog
          DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package} COMPONENT ${component})
endforeach()
install(FILES ${CMAKE_CURRENT_LIST_DIR}/lintian-overrides DESTINATION ${CMAKE_INSTALL_DATADIR}/lintian/overrides
        RENAME lidard COMPONENT lidard)
include(CPack)
