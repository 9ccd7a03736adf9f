# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
# find_package(lidard) gives lidard::lidard_core (scans, clouds, merging) and lidard::lidard_drivers (what lidars say).
include(CMakeFindDependencyMacro)
find_dependency(Threads)
find_dependency(PkgConfig)
find_dependency(Eigen3)
find_dependency(Boost)
find_dependency(nlohmann_json)
if(NOT TARGET PkgConfig::PCAP)
  pkg_check_modules(PCAP REQUIRED QUIET IMPORTED_TARGET libpcap)
endif()
if(NOT TARGET PkgConfig::UNPACK)
  pkg_check_modules(UNPACK REQUIRED QUIET IMPORTED_TARGET zlib liblzma libzstd)
endif()
if(NOT TARGET PkgConfig::TINYXML2)
  pkg_check_modules(TINYXML2 REQUIRED QUIET IMPORTED_TARGET tinyxml2)
endif()
include(${CMAKE_CURRENT_LIST_DIR}/lidard-targets.cmake)
