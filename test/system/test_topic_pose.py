#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Topics of other drivers, whose messages name any frame and whose frames tf does not know: the pose that is configured for the
topic places them, in a merged and in a virtual scan. One that has no pose is named on /diagnostics."""
import math
import struct
import subprocess

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from harness import LIDARD, expect, folder, free_port, process, ros_master, use_master_at, wait_for
from laser_tools import Listener, Talker, expect_same, nearest_per_beam, place, scan_points, wall_scan
from sensor_msgs.msg import PointCloud2, PointField

CONFIG = """\
sensors:
  left: {topic: /left/scan, pose: {xyz: [0.3, 0.4, 0.2], rpy: [0, 0, 0.5]}}
  mast: {topic: /mast/points, pose: {xyz: [0, 0, 2], rpy: [0, 0, 1.5]}}
  lost: {topic: /lost/scan}
merged_scans:
  around: {laserscan_topics: [/left/scan], angle_min: -2.0, angle_max: 2.0, angle_increment: 0.0058, range_min: 0.3,
           range_max: 50, empty: range_max_plus_one}
  nothing: {laserscan_topics: [lost]}
virtual_scans:
  levels: {cloud_topic: mast, virtual_laser_scan: [low], poses: {low: {xyz: [0, 0, 0.5]}}, angle_min: -2.0, angle_max: 2.0,
           angle_increment: 0.0058, range_min: 0.3, range_max: 50, empty: range_max_plus_one}
"""
GRID = {"angle_min": -2.0, "angle_max": 2.0, "angle_increment": 0.0058, "range_min": 0.3, "range_max": 50.0}


def cloud(points):
    message = PointCloud2()
    message.header.frame_id = "some_cloud_frame"
    message.fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate("xyz")]
    message.height, message.width, message.point_step, message.row_step = 1, len(points), 12, 12 * len(points)
    message.data = b"".join(struct.pack("<fff", *point) for point in points)
    message.is_dense = True
    return message


def main():
    port = free_port()
    use_master_at(port)
    with folder() as tmp, ros_master(port):
        (tmp / "live.yaml").write_text(CONFIG)
        log = tmp / "log.txt"
        rospy.init_node("listener", disable_signals=True, anonymous=True)
        items = {}
        rospy.Subscriber("/diagnostics", DiagnosticArray,
                         lambda array: items.update((s.name.split(": ")[-1], s) for s in array.status))
        scan = wall_scan("some_scan_frame", [3 + math.sin(i / 20) for i in range(300)])
        points = [(4 * math.cos(a), 4 * math.sin(a), -1.5) for a in (i / 100 - 3 for i in range(600))]
        talkers = [Talker("/left/scan", scan), Talker("/mast/points", cloud(points)), Talker("/lost/scan", wall_scan("adrift", [1.0] * 9))]
        merged, low = Listener("/around"), Listener("/low")
        with log.open("w") as sink, process([LIDARD, "run", "-c", tmp / "live.yaml"], stdout=sink, stderr=subprocess.STDOUT):
            wait_for(lambda: len(merged.messages) > 3 and len(low.messages) > 3, 20, "scans:\n" + log.read_text())
            wait_for(lambda: "adrift" in getattr(items.get("merged nothing"), "message", ""), 10, "the frame without a pose is named")
        placed = place(scan_points(scan), (0.3, 0.4, 0.2), (0, 0, 0.5))
        expect_same(merged.messages[-1], nearest_per_beam(placed, **GRID), "merged scan")
        expect(merged.messages[-1].header.frame_id == "base_link", "its own frame")
        placed = place(points, (0, 0, 1.5), (0, 0, 1.5))
        expect_same(low.messages[-1], nearest_per_beam(placed, **GRID), "virtual scan")
        for one in [*talkers, merged, low]:
            one.close()
    print("ok")


if __name__ == "__main__":
    main()
