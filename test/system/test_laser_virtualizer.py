#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""laserscan_virtualizer with the parameters of ira_laser_tools on a real master: absolute names as the old node reads them and
private ones, several at once, frames whose tf comes late, and values that an independent computation gives."""
import math
import os
import signal
import struct
import subprocess
import time

import rospy
from harness import LIDARD, Starved, expect, folder, free_port, process, ros_master, use_master_at, wait_for
from laser_tools import Listener, Talker, check_consistent, expect_same, nearest_per_beam, set_parameters, static_transforms, transform
from sensor_msgs.msg import PointCloud2, PointField

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


def cloud_of(points):
    cloud = PointCloud2()
    cloud.header.frame_id = "velodyne"
    cloud.fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate("xyz")]
    cloud.height, cloud.width, cloud.point_step = 1, len(points), 12
    cloud.row_step = 12 * len(points)
    cloud.data = b"".join(struct.pack("<fff", *p) for p in points)
    return cloud


def by_hand(points, height, tilt):
    """In a frame `height` above the sensor, looking down by `tilt`."""
    inside = []
    for x, y, z in points:
        z -= height
        u, w = math.cos(tilt) * x - math.sin(tilt) * z, math.sin(tilt) * x + math.cos(tilt) * z
        if -HALF_HEIGHT <= w <= HALF_HEIGHT:
            inside.append((u, y, w))
    return nearest_per_beam(inside, **GRID)


def main():
    port = free_port()
    use_master_at(port)
    points = room()
    with folder() as tmp, ros_master(port):
        rospy.init_node("listener", disable_signals=True, anonymous=True)
        program, log = tmp / "laserscan_virtualizer", tmp / "log.txt"
        program.symlink_to(os.path.abspath(LIDARD))
        set_parameters(port, "/laserscan_virtualizer", {"cloud_topic": "/cloud_in", "base_frame": "/laser_frame",
                                                        "virtual_laser_scan": "scansx scandx"})
        set_parameters(port, "/second", {"output_laser_topic": "all", "virtual_laser_scan": "scandx", "range_max": 80.0})
        scans = {topic: Listener("/" + topic) for topic in ("scansx", "scandx", "all")}
        with log.open("w") as sink:
            options = {"stdout": sink, "stderr": subprocess.STDOUT}
            with process([program], **options) as node, process([program, "__name:=second"], **options):
                wait_for(lambda: all(s.subscriber.get_num_connections() == 1 for s in scans.values()), 15,
                         "outputs before any input:\n" + log.read_text())
                talker = Talker("/cloud_in", cloud_of(points), rate=4)
                base = [transform("laser_frame", "velodyne", (0, 0, -0.2)),
                        transform("laser_frame", "scandx", (0, 0, 0))]
                tf = static_transforms(base)
                wait_for(lambda: len(scans["scandx"].messages) > 3, 20, "the frame that tf has:\n" + log.read_text())
                expect(not scans["scansx"].messages, "nothing in a frame that tf does not have")
                tf.unregister()
                tf = static_transforms([*base, transform("laser_frame", "scansx", (0, 0, 0), (0, TILT, 0))])
                wait_for(lambda: all(len(s.messages) > 3 for s in scans.values()), 20, "all frames:\n" + log.read_text())
                for topic, tilt in (("scandx", 0), ("scansx", TILT)):
                    scan = scans[topic].messages[-1]
                    check_consistent(scan)
                    expect(scan.header.frame_id == topic, f"frame {scan.header.frame_id}")
                    expected = by_hand(points, 0.2, tilt)
                    expect(sum(r < 25 for r in expected) > 400, "the scene fills the scan")
                    expect_same(scan, expected, topic)
                other = scans["all"].messages[-1]
                expect(other.header.frame_id == "scandx" and abs(other.range_max - 80) < 1e-6, f"the second: {other.header}")
                node.send_signal(signal.SIGINT)
                begin, starved = time.monotonic(), Starved()
                expect(node.wait(20) == 0 and time.monotonic() - begin < 1 + starved.seconds(), f"Ctrl-C took {time.monotonic() - begin:.2f} s")
        talker.close()
        tf.unregister()
    print("ok")


if __name__ == "__main__":
    main()
