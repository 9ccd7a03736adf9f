# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
# The Python package `lidard`, complete in the build folder: PYTHONPATH=build/python.
find_package(Python3 COMPONENTS Interpreter Development.Module)
find_package(pybind11 2.10 QUIET)
if(NOT Python3_FOUND OR NOT pybind11_FOUND OR LIDARD_SANITIZE OR LIDARD_FUZZ)
  message(STATUS "without the Python package (pybind11-dev, python3-dev; not with sanitizers)")
  return()
endif()
set(package ${CMAKE_CURRENT_BINARY_DIR}/python/lidard)
file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/*.cpp)
pybind11_add_module(lidard_python MODULE NO_EXTRAS ${sources})
target_link_libraries(lidard_python PRIVATE lidard_offline)
target_compile_definitions(lidard_python PRIVATE LIDARD_VERSION="${PROJECT_VERSION}")
set_target_properties(lidard_python PROPERTIES OUTPUT_NAME _lidard LIBRARY_OUTPUT_DIRECTORY ${package})
# Other libraries of a Python process do not see ours.
target_link_options(lidard_python PRIVATE LINKER:--as-needed LINKER:--exclude-libs,ALL)
foreach(file __init__.py py.typed)
  configure_file(${CMAKE_CURRENT_LIST_DIR}/lidard/${file} ${package}/${file} COPYONLY)
endforeach()
