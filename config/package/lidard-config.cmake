# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
# find_package(lidard) gives lidard::lidard_core (scans, clouds, merging) and lidard::lidard_drivers (what lidars say).
include(CMakeFindDependencyMacro)
find_dependency(Threads)
find_dependency(PkgConfig)
find_dependency(Eigen3)
find_dependency(Boost)
find_dependency(nlohmann_json)
# The names are those of the project's own CMakeLists.txt.
foreach(library "PCAP libpcap" "TINYXML2 tinyxml2" "UNPACK zlib libzstd")
  separate_arguments(library)
  list(POP_FRONT library name)
  if(NOT TARGET PkgConfig::${name})
    pkg_check_modules(${name} REQUIRED QUIET IMPORTED_TARGET ${library})
  endif()
endforeach()
include(${CMAKE_CURRENT_LIST_DIR}/lidard-targets.cmake)
