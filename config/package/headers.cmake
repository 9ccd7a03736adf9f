# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
# Installs the headers of core and drivers below include/lidard, and lets them include each other as "lidard/core/...": a
# folder `core` of the program that uses them is not taken for theirs.
cmake_path(SET source NORMALIZE "${CMAKE_CURRENT_LIST_DIR}/../..")
file(GLOB_RECURSE headers RELATIVE ${source} ${source}/core/*.h ${source}/drivers/*.h)
foreach(header IN LISTS headers)
  file(READ ${source}/${header} text)
  string(REGEX REPLACE "#include \"(core|drivers)/" "#include \"lidard/\\1/" text "${text}")
  file(WRITE "$ENV{DESTDIR}${CMAKE_INSTALL_PREFIX}/include/lidard/${header}" "${text}")
  list(APPEND CMAKE_INSTALL_MANIFEST_FILES "${CMAKE_INSTALL_PREFIX}/include/lidard/${header}")
endforeach()
