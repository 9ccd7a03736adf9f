#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""A replay to ROS takes part in it like the running daemon: a scan that another node publishes is merged with that of the capture,
odometry is used, and dynamic_reconfigure changes the scan while the capture plays. The other node lives by /clock."""
import math
import signal
import subprocess

import dynamic_reconfigure.client
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from harness import (LIDARD, LIDARD_SIM, SCANNER_SCENE, expect, folder, free_port, process, ros_master, use_master_at, wait_for)
from laser_tools import Listener, wall_scan
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan

CONFIG = """\
vehicle: {odometry_topic: /odom}
sensors:
  front: {model: sick_microscan3, ip_address: 192.168.0.21, ip_port: 6060, pose: {xyz: [0, 0, 0.35]}}
  side: {topic: /side/scan, pose: {xyz: [0, 0, 0.35], rpy_deg: [0, 0, 180]}}
merged_scans:
  around: {laserscan_topics: [front, side], angle_min: -3.0, angle_max: 3.0, angle_increment: 0.01, range_max: 20}
"""


class Vehicle:
    """A node that publishes a scanner's wall 3 m to the left behind and the odometry, stamped by the clock of the replay."""

    def __init__(self):
        self.odometry = rospy.Publisher("/odom", Odometry, queue_size=100)
        self.scans = rospy.Publisher("/side/scan", LaserScan, queue_size=100)
        self.told = self.scanned = rospy.Time()
        self.begin = self.now = None
        self.clock = rospy.Subscriber("/clock", Clock, self._live, queue_size=100)

    def _live(self, message):
        self.now = message.clock
        self.begin = self.begin or self.now
        if (self.now - self.told).to_sec() >= 0.02:
            self.told = self.now
            pose = Odometry()
            # A little ahead, so that no scan waits for it.
            pose.header.stamp = self.now + rospy.Duration.from_sec(0.1)
            pose.header.frame_id, pose.child_frame_id, pose.pose.pose.orientation.w = "odom", "base_link", 1
            self.odometry.publish(pose)
        if (self.now - self.scanned).to_sec() >= 0.05:
            self.scanned = self.now
            scan = wall_scan("whatever", [3.0] * 100)
            scan.header.stamp = self.now
            self.scans.publish(scan)


def beam(scan, angle):
    return scan.ranges[round((angle - scan.angle_min) / scan.angle_increment)]


def check(merged, items):
    newest = lambda: merged.messages[-1]
    wait_for(lambda: merged.messages and abs(beam(newest(), 2.0) - 3) < 0.01 and abs(beam(newest(), 0.0) - 8) < 0.1, 20,
             "the scan of the capture and that of the other node, merged")
    expect(not math.isfinite(beam(newest(), -2.0)), "nothing on the other side")
    expect(abs(newest().header.stamp.to_sec() - 1767225600) < 600, "the time of the capture")
    values = lambda name: {pair.key: pair.value for pair in items[name].values} if name in items else {}
    wait_for(lambda: values("merged around").get("Motion", "").startswith("deskewed"), 10, f"{items.get('merged around')}")
    expect(items["side input"].message == "receiving" and items["motion /odom"].message == "receiving",
           f"{items['side input']} {items['motion /odom']}")
    server = dynamic_reconfigure.client.Client("/lidard/around", timeout=20)
    expect(server.update_configuration({"range_max": 5.0})["range_max"] == 5, "taken")
    wait_for(lambda: newest().range_max == 5 and not math.isfinite(beam(newest(), 0.0)), 10, "the wall in front lies beyond 5 m")
    wait_for(lambda: abs(beam(newest(), 2.0) - 3) < 0.01, 5, "the other wall is there still")
    wait_for(lambda: values("reconfigure around").get("Changes") == "1", 10, "the change is told")
    server.close()


def main():
    port = free_port()
    use_master_at(port)
    with folder() as tmp, ros_master(port):
        (tmp / "scene.yaml").write_text(SCANNER_SCENE.format(port=6060).replace("duration: 600", "duration: 90"))
        made = subprocess.run([LIDARD_SIM, "make", tmp / "scene.yaml", "-o", tmp / "drive"], capture_output=True, text=True, check=False)
        expect(made.returncode == 0, made.stderr)
        (tmp / "replay.yaml").write_text(CONFIG)
        rospy.init_node("vehicle", disable_signals=True, anonymous=True)
        items, log, table = {}, tmp / "log.txt", tmp / "table.txt"
        rospy.Subscriber("/diagnostics", DiagnosticArray,
                         lambda array: items.update((s.name.split(": ")[-1], s) for s in array.status), queue_size=100)
        vehicle, merged = Vehicle(), Listener("/around")
        command = [LIDARD, "replay", "-c", tmp / "replay.yaml", "--pcap", tmp / "drive.pcap", "--clock", "--wait", "2"]
        with table.open("w") as out, log.open("w") as err, process(command, stdout=out, stderr=err) as child:
            wait_for(lambda: vehicle.now, 20, "the clock of the replay:\n" + log.read_text())
            check(merged, items)
            played = (vehicle.now - vehicle.begin).to_sec()
            child.send_signal(signal.SIGINT)
            expect(child.wait(40) == 0, "the replay ends well:\n" + log.read_text())
        print(table.read_text())
        expect("side (topic)" in table.read_text() or "side" in table.read_text(), "the other node's scanner is in the table")
        print(f"{len(merged.messages)} merged scans in {played:.1f} s")
        expect(len(merged.messages) > 5 * played, f"{len(merged.messages)} merged scans in {played:.1f} s")
    print("ok")


if __name__ == "__main__":
    main()
