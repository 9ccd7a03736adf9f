#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""laserscan_virtualizer with the parameters of ira_laser_tools on a real master: absolute names as the old node reads them and
private ones, several at once, frames whose tf comes late, and values that an independent computation gives."""
import math

from harness import expect, logged, named_program, wait_for
from ros_tools import (Listener, Talker, check_consistent, cloud_of, expect_quick_end, expect_same, nearest_per_beam, ros_test,
                       set_parameters, static_transforms, transform)

GRID = {"angle_min": -2.36, "angle_max": 2.36, "angle_increment": 0.0058, "range_min": 0.45, "range_max": 25.0}
TILT = 0.3
HALF_HEIGHT = 0.1


def room():
    """Walls around the sensor, points every 2 cm of height."""
    points = []
    for height in range(-60, 61):
        for step in range(600):
            a = step * math.pi / 300
            points.append((4 * math.cos(a) + 0.013, 3 * math.sin(a) + 0.007, height * 0.02 + 0.003))
    return points


def by_hand(points, height, tilt):
    """In a frame `height` above the sensor, looking down by `tilt`."""
    inside = []
    for x, y, z in points:
        z -= height
        u, w = math.cos(tilt) * x - math.sin(tilt) * z, math.sin(tilt) * x + math.cos(tilt) * z
        if -HALF_HEIGHT <= w <= HALF_HEIGHT:
            inside.append((u, y, w))
    return nearest_per_beam(inside, **GRID)


def check_values(scans, points):
    for topic, tilt in (("scandx", 0), ("scansx", TILT)):
        scan = scans[topic].messages[-1]
        check_consistent(scan)
        expect(scan.header.frame_id == topic, f"frame {scan.header.frame_id}")
        expected = by_hand(points, 0.2, tilt)
        expect(sum(r < 25 for r in expected) > 400, "the scene fills the scan")
        expect_same(scan, expected, topic)
    other = scans["all"].messages[-1]
    expect(other.header.frame_id == "scandx" and abs(other.range_max - 80) < 1e-6, f"the second: {other.header}")


def main():
    points = room()
    with ros_test() as (tmp, master):
        program = named_program(tmp, "laserscan_virtualizer")
        set_parameters(master.port, "/laserscan_virtualizer", {"cloud_topic": "/cloud_in", "base_frame": "/laser_frame",
                                                               "virtual_laser_scan": "scansx scandx"})
        set_parameters(master.port, "/second", {"output_laser_topic": "all", "virtual_laser_scan": "scandx", "range_max": 80.0})
        scans = {topic: Listener("/" + topic) for topic in ("scansx", "scandx", "all")}
        with logged([program], tmp / "log.txt") as node, logged([program, "__name:=second"], tmp / "second.txt"):
            wait_for(lambda: all(s.subscriber.get_num_connections() == 1 for s in scans.values()), 15,
                     "outputs before any input:\n" + node.said())
            talker = Talker("/cloud_in", cloud_of(points, "velodyne"), rate=4)
            base = [transform("laser_frame", "velodyne", (0, 0, -0.2)), transform("laser_frame", "scandx", (0, 0, 0))]
            tf = static_transforms(base)
            wait_for(lambda: len(scans["scandx"].messages) > 3, 20, "the frame that tf has:\n" + node.said())
            expect(not scans["scansx"].messages, "nothing in a frame that tf does not have")
            tf.unregister()
            tf = static_transforms([*base, transform("laser_frame", "scansx", (0, 0, 0), (0, TILT, 0))])
            wait_for(lambda: all(len(s.messages) > 3 for s in scans.values()), 20, "all frames:\n" + node.said())
            check_values(scans, points)
            expect_quick_end(node)
        talker.close()
        tf.unregister()
    print("ok")


if __name__ == "__main__":
    main()
