# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
install(TARGETS lidard RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
# rosrun and roslaunch look for a package's executables under lib/<package> and for package.xml under share/<package>.
install(CODE "
  file(MAKE_DIRECTORY \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/lib/lidard\")
  file(CREATE_LINK \"../../${CMAKE_INSTALL_BINDIR}/lidard\" \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/lib/lidard/lidard\" SYMBOLIC)")
install(FILES package.xml DESTINATION ${CMAKE_INSTALL_DATADIR}/lidard)
