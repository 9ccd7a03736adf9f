# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
# `cmake --install build --prefix ANYWHERE` needs no root. Paths that stand inside files follow the prefix given there.
# A component is a Debian package, see package/package.cmake: lidard, pcl, sim, dev.
set(share ${CMAKE_INSTALL_DATADIR}/lidard)
set(config ${CMAKE_CURRENT_SOURCE_DIR}/config)
set(CMAKE_INSTALL_DEFAULT_COMPONENT_NAME lidard)

install(TARGETS lidard RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
if(TARGET lidard_pcl)
  install(TARGETS lidard_pcl lidard_outliers LIBRARY DESTINATION lib/lidard/modules COMPONENT pcl)
endif()
if(TARGET lidard-sim)
  # OPTIONAL: a build of the target lidard alone can be installed too.
  install(TARGETS lidard-sim RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT sim OPTIONAL)
  install(FILES test/sim/lidard-sim.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT sim)
  install(FILES pcaps/README.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/lidard-sim COMPONENT sim)
  install(FILES pcaps/demo.scene.yaml DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/lidard-sim/examples COMPONENT sim)
endif()
install(PROGRAMS daemon/dropin/read_launch.py DESTINATION lib/lidard)
# rosrun and roslaunch look for a package's executables under lib/<package> of /usr and of catkin workspaces, elsewhere
# beside package.xml, which they find under share/<package>.
install(CODE "
  set(folders lib/lidard)
  if(NOT CMAKE_INSTALL_PREFIX STREQUAL \"/usr\")
    list(APPEND folders ${share})
  endif()
  foreach(folder \${folders})
    file(MAKE_DIRECTORY \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/\${folder}\")
    file(INSTALL \"${config}/free_area\" DESTINATION \"\${CMAKE_INSTALL_PREFIX}/\${folder}\" USE_SOURCE_PERMISSIONS)
    foreach(name lidard velodyne_node laserscan_multi_merger laserscan_virtualizer sick_safetyscanners_node urg_node)
      file(CREATE_LINK \"../../${CMAKE_INSTALL_BINDIR}/lidard\" \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/\${folder}/\${name}\" SYMBOLIC)
    endforeach()
  endforeach()")
install(FILES package.xml DESTINATION ${share})
install(FILES ${config}/lidard.launch ${config}/demo.launch ${config}/laserscan_multi_merger.launch
        ${config}/laserscan_virtualizer.launch DESTINATION ${share}/launch)
install(DIRECTORY ${config}/velodyne/ DESTINATION ${share}/launch FILES_MATCHING PATTERN "*.launch")
install(FILES ${config}/lidard.rviz DESTINATION ${share}/rviz)
install(DIRECTORY ${config}/ DESTINATION ${share}/config FILES_MATCHING PATTERN "*.yaml"
        PATTERN velodyne EXCLUDE PATTERN package EXCLUDE)
install(FILES pcaps/demo.pcap DESTINATION ${share}/pcaps)
# The manual, and what its pages refer to, in the folders of the project: so its links lead somewhere.
set(manual ${CMAKE_INSTALL_DATADIR}/doc/lidard)
install(FILES README.md DESTINATION ${manual})
install(FILES ${config}/KEYS.md DESTINATION ${manual}/config)
install(DIRECTORY ${config}/doc DESTINATION ${manual}/config)
install(FILES pcaps/README.md DESTINATION ${manual}/pcaps)
install(FILES drivers/README.md DESTINATION ${manual}/drivers)

install(FILES ${config}/60-lidard.conf DESTINATION lib/sysctl.d)
install(FILES daemon/lidard.8 DESTINATION ${CMAKE_INSTALL_MANDIR}/man8 OPTIONAL)
install(FILES daemon/lidard.yaml.5 DESTINATION ${CMAKE_INSTALL_MANDIR}/man5 OPTIONAL)
install(FILES daemon/completion.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME lidard OPTIONAL)
install(FILES daemon/completion.zsh DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/vendor-completions RENAME _lidard)
install(CODE "
  set(bindir \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR}\")
  # The system's own prefix keeps its configuration in /etc (Filesystem Hierarchy Standard).
  if(CMAKE_INSTALL_PREFIX STREQUAL \"/usr\")
    set(sysconfdir /etc)
  else()
    set(sysconfdir \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_SYSCONFDIR}\")
  endif()
  # One daemon for the vehicle; and one per name, each with a configuration and a ROS node of its own.
  set(units \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/lib/systemd/system\")
  foreach(unit lidard lidard@)
    if(unit STREQUAL \"lidard\")
      set(config_name lidard)
      set(folder lidard)
    else()
      set(config_name %i)
      set(folder lidard-%i)
      set(of_instance \" (%i)\")
      set(node_name \" __name:=lidard_%i\")
    endif()
    configure_file(\"${config}/lidard.service.in\" \"\${units}/\${unit}.service\" @ONLY)
    message(STATUS \"Installing: \${units}/\${unit}.service\")
  endforeach()
  # What an administrator wrote stays.
  set(example \"\$ENV{DESTDIR}\${sysconfdir}/lidard/lidard.yaml\")
  if(NOT EXISTS \"\${example}\")
    configure_file(\"${config}/package/lidard.yaml\" \"\${example}\" COPYONLY)
    message(STATUS \"Installing: \${example}\")
  endif()
  set(environment \"\$ENV{DESTDIR}\${sysconfdir}/default/lidard\")
  if(NOT EXISTS \"\${environment}\")
    configure_file(\"${config}/lidard.default\" \"\${environment}\" COPYONLY)
    message(STATUS \"Installing: \${environment}\")
  endif()")

# What other programs decode captures and packets with: core and the drivers, which open no socket of their own.
install(TARGETS lidard_core lidard_drivers EXPORT lidard ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
install(SCRIPT ${config}/package/headers.cmake COMPONENT dev)
foreach(library lidard_core lidard_drivers)
  target_include_directories(${library} INTERFACE $<INSTALL_INTERFACE:include>)
  target_compile_features(${library} INTERFACE cxx_std_17)
endforeach()
set(cmake_folder ${CMAKE_INSTALL_LIBDIR}/cmake/lidard)
install(EXPORT lidard NAMESPACE lidard:: DESTINATION ${cmake_folder} FILE lidard-targets.cmake COMPONENT dev)
include(CMakePackageConfigHelpers)
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/lidard-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${config}/package/lidard-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/lidard-config-version.cmake
        DESTINATION ${cmake_folder} COMPONENT dev)
install(DIRECTORY ${config}/package/example/ DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/liblidard-dev/examples COMPONENT dev)
