# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
find_package(GTest REQUIRED)
find_package(benchmark REQUIRED)

# Paths are compiled into these files alone, so that a compiler cache can serve a second clone.
set_source_files_properties(test/support/captures.cpp test/bench/bench_decode.cpp PROPERTIES
  COMPILE_DEFINITIONS LIDARD_SOURCE_DIR="${CMAKE_CURRENT_SOURCE_DIR}")
set_source_files_properties(test/sim/servers/capture_test.cpp PROPERTIES
  COMPILE_DEFINITIONS LIDARD_SIM_BINARY="$<TARGET_FILE:lidard-sim>")

set(test_headers <filesystem> <fstream> <random> <gmock/gmock.h> <gtest/gtest.h>)
# What several tests and benchmarks stand on; what knows ROS is the daemon's tests' alone.
file(GLOB support CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/test/support/*.cpp)
set(ros_support ${support})
list(FILTER support EXCLUDE REGEX "/support/ros_")
list(FILTER ros_support INCLUDE REGEX "/support/ros_")
add_library(lidard_support STATIC ${support})
target_link_libraries(lidard_support PUBLIC lidard_sim GTest::gtest GTest::gmock)
target_precompile_headers(lidard_support PRIVATE ${common_headers} ${test_headers})
lidard_unity(lidard_support 6)

# test/<folder>/*_test.cpp is one GoogleTest program; folders mirror the sources. Its tests run in a few processes, since
# a process of its own costs most tests more than what they do. ctest counts thirds of a processor, because most of the
# system tests below wait. Tests that put every model through the mill take half of the time: ./test/run --all.
set(mills "BoundedTime.*" "VelodyneLoss.*ForEveryModelAndMode" "VelodyneStamp.IsTheEarliest*"
          "VelodyneWholeTurn.*")
string(REPLACE ";" ":" mills "${mills}")
# s until a test hangs; sanitizers make programs several times slower.
set(limit 900)
if(LIDARD_SANITIZE)
  set(limit 3600)
endif()
set(programs)
function(lidard_tests folder shards)
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/test/${folder}/*_test.cpp)
  set(name test_${folder})
  add_executable(${name} ${sources})
  target_link_libraries(${name} PRIVATE lidard_support ${ARGN} GTest::gtest_main)
  # A test runs for milliseconds; what it calls is optimised.
  target_compile_options(${name} PRIVATE $<$<CONFIG:RelWithDebInfo>:-O1>)
  # Names of one file may hide those of another one that it is compiled with.
  set_target_properties(${name} PROPERTIES LIDARD_MAY_SHADOW ON)
  target_precompile_headers(${name} PRIVATE ${common_headers} ${test_headers})
  lidard_unity(${name} 6)
  foreach(shard RANGE 1 ${shards})
    math(EXPR index "${shard} - 1")
    add_test(NAME ${folder}.${shard} COMMAND ${name})
    set_tests_properties(${folder}.${shard} PROPERTIES PROCESSORS 3 TIMEOUT ${limit} ENVIRONMENT
      "GTEST_FILTER=-${mills};GTEST_TOTAL_SHARDS=${shards};GTEST_SHARD_INDEX=${index};GTEST_OUTPUT=xml:${CMAKE_CURRENT_BINARY_DIR}/Testing/${folder}.${shard}.xml")
  endforeach()
  set(programs ${programs} $<TARGET_FILE:${name}> PARENT_SCOPE)
endfunction()

lidard_tests(core 4 lidard_core)
lidard_tests(drivers 4 lidard_drivers)
add_test(NAME drivers.mills COMMAND test_drivers)
set_tests_properties(drivers.mills PROPERTIES PROCESSORS 3 TIMEOUT ${limit} LABELS endurance ENVIRONMENT
  "GTEST_FILTER=${mills};GTEST_OUTPUT=xml:${CMAKE_CURRENT_BINARY_DIR}/Testing/drivers.mills.xml")
# What users' programs and ira_laser_tools make of scans with; the daemon needs none of them.
pkg_check_modules(ANCESTOR REQUIRED IMPORTED_TARGET laser_geometry tf pcl_common)
list(REMOVE_ITEM ANCESTOR_INCLUDE_DIRS /include)
set_target_properties(PkgConfig::ANCESTOR PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${ANCESTOR_INCLUDE_DIRS}")
lidard_tests(daemon 6 lidard_daemon lidard_rosbag PkgConfig::ANCESTOR ${CAIRO_LINK_LIBRARIES})
target_sources(test_daemon PRIVATE ${ros_support})
# The modules are loaded at run time.
add_dependencies(test_daemon lidard_pcl lidard_outliers lidard_pictures lidard_bags)
lidard_tests(sim 2 lidard_drivers)
add_dependencies(test_sim lidard-sim)
# The skeleton of a driver, which only its test makes known to the program.
lidard_tests(skeleton 1 lidard_daemon lidard_rosbag)
target_sources(test_skeleton PRIVATE test/skeleton/disc_driver.cpp)
add_dependencies(test_skeleton lidard_bags)

add_test(NAME layering COMMAND /usr/bin/python3 ${CMAKE_CURRENT_SOURCE_DIR}/test/layering.py ${CMAKE_CURRENT_SOURCE_DIR})
add_test(NAME page_names COMMAND /usr/bin/python3 ${CMAKE_CURRENT_SOURCE_DIR}/test/page_names.py ${CMAKE_CURRENT_SOURCE_DIR})
add_test(NAME sentences COMMAND /usr/bin/python3 ${CMAKE_CURRENT_SOURCE_DIR}/test/sentences.py)
add_test(NAME page_names_test COMMAND /usr/bin/python3 ${CMAKE_CURRENT_SOURCE_DIR}/test/page_names_test.py)
add_test(NAME test_names COMMAND /usr/bin/python3 ${CMAKE_CURRENT_SOURCE_DIR}/test/test_names.py ${programs})
add_test(NAME skipped_tests COMMAND /usr/bin/python3 ${CMAKE_CURRENT_SOURCE_DIR}/test/skipped_test.py)
add_test(NAME mutate COMMAND /usr/bin/python3 ${CMAKE_CURRENT_SOURCE_DIR}/test/mutate_test.py)

# A library that moves a program's clock, for the test of a host whose clock is set.
add_library(clock_shim MODULE test/system/clock_shim.cpp)
target_link_libraries(clock_shim PRIVATE lidard_options ${CMAKE_DL_LIBS})

# test/system/*.py drive the real programs: sockets on loopback, a real rosmaster, roscpp, bags. They have a network of
# their own (harness.py) and run side by side. Alone run those that load the machine, or that count what a loaded one loses.
set(alone test_live_equals_replay test_memory test_network_losses test_noise test_planes_first test_random_faults
          test_soak test_velodyne_rate)
# What shows that lidard lasts, and its packages: ./test/run --all.
set(endurance test_bad_packet test_noise test_package test_random_faults test_soak)
# What takes longest begins first, before the tests above, which compute.
set(long test_network_silence test_watchdog test_node_name test_network_changes test_fault_table test_clock_step
         test_package)
# These compute, too.
set(busy test_bad_packet test_decode test_import test_inspect test_package test_python)
file(GLOB system_tests CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/test/system/test_*.py)
foreach(script ${system_tests})
  get_filename_component(name ${script} NAME_WE)
  add_test(NAME system.${name} COMMAND /usr/bin/python3 ${script})
  set_tests_properties(system.${name} PROPERTIES TIMEOUT ${limit} SKIP_RETURN_CODE 77
    ENVIRONMENT "LIDARD=$<TARGET_FILE:lidard>;LIDARD_SIM=$<TARGET_FILE:lidard-sim>;LIDARD_CLOCK_SHIM=$<TARGET_FILE:clock_shim>;LIDARD_PYTHON=${CMAKE_BINARY_DIR}/python;LIDARD_SOURCE_DIR=${CMAKE_CURRENT_SOURCE_DIR}")
  if(name IN_LIST long)
    set_tests_properties(system.${name} PROPERTIES COST 1000)
  endif()
  if(name IN_LIST busy)
    set_tests_properties(system.${name} PROPERTIES PROCESSORS 3)
  endif()
  if(name IN_LIST endurance)
    set_tests_properties(system.${name} PROPERTIES LABELS endurance)
  endif()
  if(name IN_LIST alone)
    set_tests_properties(system.${name} PROPERTIES RUN_SERIAL TRUE)
  endif()
endforeach()

# Benches are for who measures: cmake --build build --target benches.
add_custom_target(benches)
file(GLOB benches CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/test/bench/*.cpp)
foreach(source ${benches})
  get_filename_component(name ${source} NAME_WE)
  add_executable(${name} EXCLUDE_FROM_ALL ${source})
  add_dependencies(benches ${name})
  target_link_libraries(${name} PRIVATE lidard_support lidard_daemon benchmark::benchmark)
  if(name STREQUAL bench_merge OR name STREQUAL bench_virtual)
    target_link_libraries(${name} PRIVATE PkgConfig::ANCESTOR)
  endif()
endforeach()

if(LIDARD_FUZZ)
  file(GLOB fuzzers CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/test/fuzz/*.cpp)
  foreach(source ${fuzzers})
    get_filename_component(name ${source} NAME_WE)
    add_executable(${name} ${source})
    target_compile_options(${name} PRIVATE -fsanitize=fuzzer)
    target_link_options(${name} PRIVATE -fsanitize=fuzzer)
    target_link_libraries(${name} PRIVATE lidard_support lidard_sim lidard_drivers)
    if(name MATCHES "fuzz_(calibration|config|pcap|ros)")
      target_link_libraries(${name} PRIVATE lidard_daemon)
    endif()
  endforeach()
endif()
