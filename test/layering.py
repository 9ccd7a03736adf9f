#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Every folder may include only what its layer may know; headers of core and drivers stay light.

Debian installs ROS, PCL and the rest under /usr/include, so a wrong include compiles without a murmur.
"""
import pathlib
import re
import sys

ROS = r"ros/|rosbag/|tf2|tf2_ros/|\w+_msgs/|diagnostic_updater/|dynamic_reconfigure/|XmlRpc"
FILES_AND_SOCKETS = r"boost/asio|boost/beast|pcap|sys/socket|netinet/|arpa/|fstream$|filesystem$"
THREADS_AND_CLOCKS = r"thread$|mutex$|condition_variable$|future$"
FORBIDDEN = {
    "core": "|".join([ROS, FILES_AND_SOCKETS, THREADS_AND_CLOCKS, r"yaml-cpp|spdlog|drivers/|daemon/|test/"]),
    "drivers": "|".join([ROS, THREADS_AND_CLOCKS, r"yaml-cpp|spdlog|pcl/|daemon/|test/"]),
    "daemon": r"test/",
}
HEAVY_IN_HEADERS = "|".join([ROS, r"pcl/|spdlog"])
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')


def violations(root):
    for folder, forbidden in FORBIDDEN.items():
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in (".h", ".hpp", ".cpp"):
                continue
            rule = forbidden
            if path.suffix != ".cpp" and folder != "daemon":
                rule += "|" + HEAVY_IN_HEADERS
            for number, line in enumerate(path.read_text().splitlines(), 1):
                found = INCLUDE.match(line)
                if found and re.match(rule, found.group(1)):
                    yield f"{path.relative_to(root)}:{number}: {folder}/ must not include {found.group(1)}"
                if folder == "core" and re.search(r"(system|steady)_clock::now|gettimeofday|clock_gettime", line):
                    yield f"{path.relative_to(root)}:{number}: core/ has no clock"


def main():
    root = pathlib.Path(sys.argv[1])
    checked = sum(1 for folder in FORBIDDEN for _ in (root / folder).rglob("*.cpp"))
    if checked == 0:
        sys.exit(f"no source file found below {root}")
    found = list(violations(root))
    print("\n".join(found) or f"{checked} source files keep to their layers")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
