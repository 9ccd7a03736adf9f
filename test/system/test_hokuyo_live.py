#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Hokuyos that wait on loopback, `lidard run` and subscribers: scans at the sensors' rate, and again after they were away;
one that refuses is told of on /diagnostics in words."""
import subprocess
import time

import rospy
from harness import LIDARD, LIDARD_SIM, Starved, check_stream, expect, folder, free_port, process, ros_master, use_master_at, wait_for
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import LaserScan

SCENE = """\
start: 2026-01-01T00:00:00Z
duration: 600
sensors:
  ust: {{model: hokuyo_ust_10lx, from: '192.168.0.10:{ust}', to: '127.0.0.1:40000', options: {{clock_ppm: 100}}}}
  uam: {{model: hokuyo_uam_05lp, from: '192.168.0.11:{uam}', to: '127.0.0.1:40001'}}
  slow: {{model: hokuyo_ust_10lx, from: '192.168.0.12:{ust}', to: '127.0.0.1:40000', options: {{boot: 100000}}}}
objects:
  - wall: {{from: [4, -3], to: [4, 3], z: [-1, 1]}}
"""
CONFIG = """\
sensors:
  ust: {{model: hokuyo_ust_10lx, ip_address: 127.168.0.10, ip_port: {ust}}}
  uam: {{model: hokuyo_uam_05lp, ip_address: 127.168.0.11, ip_port: {uam}}}
  slow: {{model: hokuyo_ust_10lx, ip_address: 127.168.0.12, ip_port: {ust}}}
"""


def ahead(scan):
    """The range straight ahead, where the wall stands."""
    return scan.ranges[round(-scan.angle_min / scan.angle_increment)]


def check(name, scans, period, seconds, starved):
    check_stream(name, [scan.header.stamp.to_sec() for scan in scans], period, seconds, starved)
    for scan in scans:
        expect(len(scan.ranges) == 1081, f"{len(scan.ranges)} beams")
        expect(abs(ahead(scan) - 4) < 0.002, f"wall at {ahead(scan)} m")
        expect(abs(scan.header.stamp.to_sec() - time.time()) < 60, "stamps are of today")


def main():
    ports = {"ust": free_port(), "uam": free_port(), "master": free_port()}
    use_master_at(ports["master"])
    with folder() as tmp, ros_master(ports["master"]):
        (tmp / "scene.yaml").write_text(SCENE.format(**ports))
        (tmp / "live.yaml").write_text(CONFIG.format(**ports))
        log = tmp / "log.txt"
        simulator = [LIDARD_SIM, "live", tmp / "scene.yaml"]
        rospy.init_node("listener", disable_signals=True, anonymous=True)
        got = {"ust": [], "uam": []}
        for name, scans in got.items():
            rospy.Subscriber(f"/{name}/scan", LaserScan, scans.append, queue_size=1000)
        told = {}
        rospy.Subscriber("/diagnostics", DiagnosticArray,
                         lambda array: told.update((status.name.split(": ")[-1], status) for status in array.status), queue_size=100)
        with log.open("w") as sink, process([LIDARD, "run", "-c", tmp / "live.yaml"], stdout=sink,
                                            stderr=subprocess.STDOUT):
            with process(simulator, stdout=subprocess.DEVNULL):
                wait_for(lambda: all(len(scans) > 20 for scans in got.values()), 20, "scans of both:\n" + log.read_text())
                begin = {name: len(scans) for name, scans in got.items()}
                started, starved = time.monotonic(), Starved()
                time.sleep(4)
                seconds = time.monotonic() - started
                taken = {name: scans[begin[name]:] for name, scans in got.items()}
                starved = starved.seconds()
                check("ust", taken["ust"], 0.025, seconds, starved)
                check("uam", taken["uam"], 0.03, seconds, starved)
                status = told.get("sensor slow")
                expect(status is not None and status.level > 0 and "status 10: " in status.message and ";" in status.message,
                       f"the refusal is told in words: {status}")
                expect(told["sensor ust"].message == "receiving", f"{told['sensor ust'].message}")
            time.sleep(2)
            begin = {name: len(scans) for name, scans in got.items()}
            with process(simulator, stdout=subprocess.DEVNULL):
                back = time.monotonic()
                wait_for(lambda: all(len(scans) > begin[name] + 10 for name, scans in got.items()), 10,
                         "scans after the sensors were away:\n" + log.read_text())
                print(f"scans again {time.monotonic() - back:.1f} s after the sensors were back")
    print("ok")


if __name__ == "__main__":
    main()
