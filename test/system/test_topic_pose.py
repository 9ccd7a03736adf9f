#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Topics of other drivers, whose messages name any frame and whose frames tf does not know: the pose that is configured for the
topic places them, in a merged and in a virtual scan. One that has no pose is named on /diagnostics."""
import math

from harness import daemon, expect, wait_for, write
from ros_tools import Diagnostics, Listener, Talker, cloud_of, expect_same, nearest_per_beam, place, ros_test, scan_points, wall_scan

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


def main():
    with ros_test() as (tmp, _):
        diagnostics = Diagnostics()
        scan = wall_scan("some_scan_frame", [3 + math.sin(i / 20) for i in range(300)])
        points = [(4 * math.cos(a), 4 * math.sin(a), -1.5) for a in (i / 100 - 3 for i in range(600))]
        talkers = [Talker("/left/scan", scan), Talker("/mast/points", cloud_of(points, "some_cloud_frame")), Talker("/lost/scan", wall_scan("adrift", [1.0] * 9))]
        merged, low = Listener("/around"), Listener("/low")
        with daemon(write(tmp / "live.yaml", CONFIG)) as child:
            wait_for(lambda: len(merged.messages) > 3 and len(low.messages) > 3, 20, "scans:\n" + child.said())
            wait_for(lambda: "adrift" in diagnostics.message("merged nothing"), 10, "the frame without a pose is named")
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
