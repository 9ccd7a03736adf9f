#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""A replay to ROS takes part in it like the running daemon: a scan that another node publishes is merged with that of the capture,
turn rates and a speed are used, and dynamic_reconfigure changes the scan while the capture plays. The other node lives by /clock."""
import math
import re
import signal

import dynamic_reconfigure.client
import rospy
from geometry_msgs.msg import TwistStamped
from harness import LIDARD, SCANNER_SCENE, expect, expect_end, logged, make_capture, wait_for, write
from ros_tools import Diagnostics, Listener, ros_test, wall_scan
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, LaserScan

CONFIG = """\
vehicle: {imu_topic: /imu, speed_topic: /speed}
sensors:
  front: {model: sick_microscan3, ip_address: 192.168.0.21, ip_port: 6060, pose: {xyz: [0, 0, 0.35]}}
  side: {topic: /side/scan, pose: {xyz: [0, 0, 0.35], rpy_deg: [0, 0, 180]}}
merged_scans:
  around: {laserscan_topics: [front, side], angle_min: -3.0, angle_max: 3.0, angle_increment: 0.01, range_max: 20}
"""


class Vehicle:
    """A node that publishes a scanner's wall 3 m to the left behind and how it moves, stamped by the clock of the replay."""

    def __init__(self):
        self.rates = rospy.Publisher("/imu", Imu, queue_size=100)
        self.speed = rospy.Publisher("/speed", TwistStamped, queue_size=100)
        self.scans = rospy.Publisher("/side/scan", LaserScan, queue_size=100)
        self.reported = self.scanned = rospy.Time()
        self.begin = self.now = None
        self.clock = rospy.Subscriber("/clock", Clock, self._live, queue_size=100)

    def _live(self, message):
        self.now = message.clock
        self.begin = self.begin or self.now
        if (self.now - self.reported).to_sec() >= 0.02:
            self.reported = self.now
            rates, ahead = Imu(), TwistStamped()
            # A little ahead, so that no scan waits for it.
            rates.header.stamp = ahead.header.stamp = self.now + rospy.Duration.from_sec(0.1)
            rates.header.frame_id, rates.angular_velocity.z, ahead.twist.linear.x = "base_link", 0.3, 1.5
            self.rates.publish(rates)
            self.speed.publish(ahead)
        if (self.now - self.scanned).to_sec() >= 0.05:
            self.scanned = self.now
            scan = wall_scan("whatever", [3.0] * 100)
            scan.header.stamp = self.now
            self.scans.publish(scan)


def beam(scan, angle):
    return scan.ranges[round((angle - scan.angle_min) / scan.angle_increment)]


def check(merged, diagnostics):
    newest = lambda: merged.messages[-1]
    wait_for(lambda: merged.messages and abs(beam(newest(), 2.0) - 3) < 0.01 and abs(beam(newest(), 0.0) - 8) < 0.1, 20,
             "the scan of the capture and that of the other node, merged")
    expect(not math.isfinite(beam(newest(), -2.0)), "nothing on the other side")
    expect(abs(newest().header.stamp.to_sec() - 1767225600) < 600, "the time of the capture")
    values = diagnostics.values
    wait_for(lambda: values("merged around").get("Motion", "").startswith("deskewed"), 10, f"deskewed scans, not {values('merged around')}")
    for name, text in (("side input", "receiving"), ("motion", "poses come in")):
        expect(diagnostics.message(name) == text, f"{name}: {diagnostics.message(name)}")
    server = dynamic_reconfigure.client.Client("/lidard/around", timeout=20)
    expect(server.update_configuration({"range_max": 5.0})["range_max"] == 5, "accepted")
    wait_for(lambda: newest().range_max == 5 and not math.isfinite(beam(newest(), 0.0)), 10, "the wall in front lies beyond 5 m")
    wait_for(lambda: abs(beam(newest(), 2.0) - 3) < 0.01, 5, "the other wall is there still")
    wait_for(lambda: values("reconfigure around").get("Changes") == "1", 10, "the change is reported")
    server.close()


def main():
    with ros_test() as (tmp, _):
        capture = make_capture(tmp / "drive", SCANNER_SCENE.format(port=6060).replace("duration: 600", "duration: 90"))
        config = write(tmp / "replay.yaml", CONFIG)
        diagnostics, vehicle, merged = Diagnostics(), Vehicle(), Listener("/around")
        with logged([LIDARD, "replay", "-c", config, "--pcap", capture, "--clock", "--wait", "2"], tmp / "log.txt") as child:
            wait_for(lambda: vehicle.now, 20, "the clock of the replay:\n" + child.said())
            check(merged, diagnostics)
            played = (vehicle.now - vehicle.begin).to_sec()
            expect_end(child, signal.SIGINT, 40)
        table = child.said().split("\noutput ")[0]
        print(table)
        expect(re.search(r"^side\b", table, re.MULTILINE), "the other node's scanner is in the table")
        print(f"{len(merged.messages)} merged scans in {played:.1f} s")
        expect(len(merged.messages) > 5 * played, f"{len(merged.messages)} merged scans in {played:.1f} s")
    print("ok")


if __name__ == "__main__":
    main()
