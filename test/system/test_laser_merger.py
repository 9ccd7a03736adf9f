#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""laserscan_multi_merger with the parameters of ira_laser_tools on a real master: the merged scan is what an independent
computation makes of the inputs, it comes whatever starts when."""
import math
import os
import shutil
import time

from harness import ROOT, expect, logged, named_program, wait_for
from ros_tools import (Listener, Talker, check_consistent, expect_quick_end, expect_same, nearest_per_beam, place, ros_test,
                       scan_points, set_parameters, static_transforms, transform, wall_scan, wrong_beams)
from sensor_msgs.msg import PointCloud2

MOUNTS = {"left_laser": ((0.3, 0.4, 0.2), (0, 0, 0.5)), "right_laser": ((0.3, -0.4, 0.2), (math.pi, 0, -0.5))}
GRID = {"angle_min": -2.0, "angle_max": 2.0, "angle_increment": 0.0058, "range_min": 0.3, "range_max": 50.0}

def left_scan():
    return wall_scan("left_laser", [3 + math.sin(i / 20) for i in range(300)])


def right_scan():
    ranges = [5 + 2 * math.cos(i / 9) for i in range(300)]
    ranges[10:20] = [math.inf] * 10
    ranges[30:40] = [math.nan] * 10
    return wall_scan("right_laser", ranges)


def merged_by_hand(scans):
    points = []
    for scan in scans:
        points += place(scan_points(scan), *MOUNTS[scan.header.frame_id])
    return points, nearest_per_beam(points, **GRID)


class Program:
    """The executable below its name."""

    def __init__(self, tmp):
        self.path, self.log = named_program(tmp, "laserscan_multi_merger"), tmp / "log.txt"

    def run(self, *arguments):
        return logged([self.path, *arguments], self.log)


def check_values(program, port):
    """Names with and without slash, a remapping, late topics, tf that comes last: outputs are there from the start."""
    set_parameters(port, "/scan_merger", {"destination_frame": "cart_frame", "laserscan_topics": "/scansx scandx",
                                          "scan_time": 0.0333333, **GRID})
    merged, cloud = Listener("/scan_multi"), Listener("/merged_cloud", PointCloud2)
    with program.run("__name:=scan_merger", "scandx:=/right/scan") as node:
        wait_for(lambda: merged.subscriber.get_num_connections() == 1, 10, "output before any input:\n" + program.log.read_text())
        left = Talker("/scansx", left_scan())
        time.sleep(1)  # one input is late
        right = Talker("/right/scan", right_scan())
        wait_for(lambda: "cart_frame" in program.log.read_text(), 15, "a message about the missing tf")
        expect(not merged.messages, "nothing without tf")
        mounts = static_transforms([transform("cart_frame", frame, *pose) for frame, pose in MOUNTS.items()])
        wait_for(lambda: len(merged.messages) > 10 and cloud.messages, 15, "scans:\n" + program.log.read_text())
        scan = merged.messages[-1]
        check_consistent(scan)
        points, expected = merged_by_hand([left.message, right.message])
        expect(len(expected) == 691, "691 beams as slam_toolbox counts")
        expect_same(scan, expected, "merged scan")
        expect(scan.header.frame_id == "cart_frame" and abs(scan.scan_time - 0.0333333) < 1e-6, f"{scan.header}")
        expect(cloud.messages[-1].width * cloud.messages[-1].height == len(points), "the cloud holds every point")
        expect_quick_end(node)
    for one in (left, right, merged, cloud):
        one.close()
    return mounts


def check_two_in_namespaces(program, port):
    """Private parameters of each, relative topics below each namespace, a relative output."""
    talkers, listeners = [], []
    for side, frame, message in (("a", "left_laser", left_scan()), ("b", "right_laser", right_scan())):
        set_parameters(port, f"/{side}/laser_multi_merger", {"laserscan_topics": "scan", "destination_frame": frame,
                                                             "scan_destination_topic": "merged", "empty": "inf"})
        talkers.append(Talker(f"/{side}/scan", message))
        listeners.append(Listener(f"/{side}/merged"))
    with program.run("__ns:=/a"), program.run("__ns:=/b"):
        wait_for(lambda: all(len(one.messages) > 5 for one in listeners), 15, "two at once:\n" + program.log.read_text())
        frames = [one.messages[-1].header.frame_id for one in listeners]
        expect(frames == ["left_laser", "right_laser"], f"each merges its own: {frames}")
        expect(any(math.isinf(r) for r in listeners[1].messages[-1].ranges), "empty: inf")
        expect(len(listeners[0].messages[-1].ranges) == 815, "the default grid")
    for one in talkers + listeners:
        one.close()


def check_launch_file(tmp, port):
    """The launch file that is shipped, which is ira_laser_tools' with another pkg=."""
    package = tmp / "lidard"
    package.mkdir()
    shutil.copy(ROOT / "package.xml", package)
    named_program(package, "laserscan_multi_merger")
    set_parameters(port, "", {"run_id": "lidard-test"})  # which roscore gives, and roslaunch waits for
    environment = {**os.environ, "ROS_PACKAGE_PATH": f"{tmp}", "ROS_HOME": str(tmp)}
    talkers = [Talker("/scansx", left_scan()), Talker("/scandx", right_scan())]
    expected = merged_by_hand([t.message for t in talkers])[1]
    launch, merged = ROOT / "config/laserscan_multi_merger.launch", Listener("/scan_multi")
    with logged(["/usr/bin/roslaunch", "--wait", launch], tmp / "roslaunch.txt", env=environment) as child:
        wait_for(lambda: len(merged.messages) > 5, 30, f"scans with {launch}:\n" + child.said())
        # A busy machine may delay a scanner: then the newest scan is without it.
        wait_for(lambda: not wrong_beams(merged.messages[-1], expected), 5, "the merged scan")
    expect("has no effect" not in child.said(), "every parameter is known:\n" + child.said())
    for one in [*talkers, merged]:
        one.close()


def main():
    with ros_test() as (tmp, master):
        program = Program(tmp)
        mounts = check_values(program, master.port)
        check_two_in_namespaces(program, master.port)
        check_launch_file(tmp, master.port)
        mounts.unregister()
    print("ok")


if __name__ == "__main__":
    main()
