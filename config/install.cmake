# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
# `cmake --install build --prefix ANYWHERE` needs no root. Paths that stand inside files follow the prefix given there.
set(share ${CMAKE_INSTALL_DATADIR}/lidard)
set(config ${CMAKE_CURRENT_SOURCE_DIR}/config)

install(TARGETS lidard RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS lidard_pcl LIBRARY DESTINATION lib/lidard)
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
    foreach(name lidard velodyne_node laserscan_multi_merger laserscan_virtualizer sick_safetyscanners_node urg_node)
      file(CREATE_LINK \"../../${CMAKE_INSTALL_BINDIR}/lidard\" \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/\${folder}/\${name}\" SYMBOLIC)
    endforeach()
  endforeach()")
install(FILES package.xml DESTINATION ${share})
install(FILES ${config}/lidard.launch ${config}/laserscan_multi_merger.launch ${config}/laserscan_virtualizer.launch
        DESTINATION ${share}/launch)
install(DIRECTORY ${config}/velodyne/ DESTINATION ${share}/launch FILES_MATCHING PATTERN "*.launch")
install(FILES ${config}/lidard.rviz DESTINATION ${share}/rviz)
install(DIRECTORY ${config}/ DESTINATION ${share}/config FILES_MATCHING PATTERN "*.yaml" PATTERN velodyne EXCLUDE)

install(FILES ${config}/60-lidard.conf DESTINATION lib/sysctl.d)
install(FILES daemon/lidard.8 DESTINATION ${CMAKE_INSTALL_MANDIR}/man8 OPTIONAL)
install(FILES daemon/lidard.yaml.5 DESTINATION ${CMAKE_INSTALL_MANDIR}/man5 OPTIONAL)
install(FILES daemon/completion.bash DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME lidard OPTIONAL)
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
    configure_file(\"${config}/demo.yaml\" \"\${example}\" COPYONLY)
    message(STATUS \"Installing: \${example}\")
  endif()
  set(environment \"\$ENV{DESTDIR}\${sysconfdir}/default/lidard\")
  if(NOT EXISTS \"\${environment}\")
    configure_file(\"${config}/lidard.default\" \"\${environment}\" COPYONLY)
    message(STATUS \"Installing: \${environment}\")
  endif()")
