#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""One of two scanners dies while `lidard run` merges them: the merged scan stays at its rate, what only the dead one saw becomes
unobserved, /diagnostics says ERROR, and all is well again with the scanner's first sweep after its return."""
import math
import socket
import subprocess
import time

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from harness import LIDARD, LIDARD_SIM, Starved, expect, folder, free_port, process, ros_master, use_master_at, wait_for
from sensor_msgs.msg import LaserScan

SCENE = """\
start: 2026-01-01T00:00:00Z
duration: 600
sensors:
  {name}: {{model: sick_microscan3, from: '192.168.0.{last}:6060', to: '127.0.0.1:{port}', pose: {{xyz: [0, {y}, 0.35], rpy_deg: [0, 0, {yaw}]}}}}
objects:
  - wall: {{from: [8, -8], to: [8, 8], z: [-1, 2]}}
  - wall: {{from: [-8, -8], to: [-8, 8], z: [-1, 2]}}
  - wall: {{from: [-8, 8], to: [8, 8], z: [-1, 2]}}
  - wall: {{from: [-8, -8], to: [8, -8], z: [-1, 2]}}
"""
CONFIG = """\
vehicle:
  footprint: [[-4.0, -0.9], [0.1, -0.9], [0.1, 0.9], [-4.0, 0.9]]
sensors:
  left: {{model: sick_microscan3, ip_address: 127.168.0.21, ip_port: {port}, pose: {{xyz: [0, 1, 0.35], rpy_deg: [0, 0, 45]}}}}
  right: {{model: sick_microscan3, ip_address: 127.168.0.22, ip_port: {port}, pose: {{xyz: [0, -1, 0.35], rpy_deg: [0, 0, -45]}}}}
merged_scans:
  around: {{laserscan_topics: [left, right], profile: strict, range_max: 30, scan_destination_topic: /around{keys}}}
"""
POLICIES = {"rate": ", policy: rate, rate: 20", "complete": ", policy: complete"}
RATES = {"rate": 20, "complete": 1 / 0.03}
# Directions that the left scanner cannot look into, seen from base_link.
RIGHT_ONLY = (math.radians(-160), math.radians(-100))


class Watch:
    """The merged scan and its state, each with the time of arrival."""

    def __init__(self):
        self.scans, self.own, self.states = [], [], []
        self.subscribers = [
            rospy.Subscriber("/around", LaserScan, lambda m: self.scans.append((time.monotonic(), m)), queue_size=1000),
            rospy.Subscriber("/right/scan", LaserScan, lambda m: self.own.append(time.monotonic()), queue_size=1000),
            rospy.Subscriber("/diagnostics", DiagnosticArray, self._state, queue_size=100)]

    def _state(self, array):
        for status in array.status:
            if status.name.endswith("merged around"):
                self.states.append((time.monotonic(), status))

    def first(self, condition, since, limit, what):
        """When the first scan came for which the condition holds."""
        return wait_for(lambda: next((t for t, m in list(self.scans) if t > since and condition(m)), None), limit, what)

    def first_state(self, condition, since, limit, what):
        return wait_for(lambda: next((t for t, s in list(self.states) if t > since and condition(s)), None), limit, what)

    def close(self):
        for subscriber in self.subscribers:
            subscriber.unregister()


def seen(scan):
    """The share of the right scanner's own sector that holds a range."""
    sector = [r for i, r in enumerate(scan.ranges)
              if RIGHT_ONLY[0] < math.remainder(scan.angle_min + i * scan.angle_increment, 2 * math.pi) < RIGHT_ONLY[1]]
    return sum(math.isfinite(r) for r in sector) / len(sector)


def unobserved(scan):
    sector = [r for i, r in enumerate(scan.ranges)
              if RIGHT_ONLY[0] < math.remainder(scan.angle_min + i * scan.angle_increment, 2 * math.pi) < RIGHT_ONLY[1]]
    return all(math.isnan(r) for r in sector)


def check_rate(watch, begin, seconds, rate, starved, when):
    times = [t for t, _ in watch.scans if begin < t < begin + seconds]
    gap = max((b - a for a, b in zip(times, times[1:])), default=9)
    print(f"{when}: {len(times) / seconds:.1f} scans/s, longest gap {gap * 1000:.0f} ms, starved {starved * 1000:.0f} ms")
    expect(abs(len(times) / seconds / rate - 1) < 0.15 + starved / seconds and gap < 0.3 + starved, f"{when}: {len(times)} scans in {seconds} s, gap {gap:.3f} s")
    stamps = [m.header.stamp for _, m in watch.scans]
    expect(all(a < b for a, b in zip(stamps, stamps[1:])), "stamps increase")


def drop_out(policy, tmp, port):
    (tmp / "live.yaml").write_text(CONFIG.format(port=port, keys=POLICIES[policy]))
    for name, last, y, yaw in (("left", 21, 1, 45), ("right", 22, -1, -45)):
        (tmp / f"{name}.yaml").write_text(SCENE.format(name=name, last=last, y=y, yaw=yaw, port=port))
    watch, log, rate = Watch(), tmp / f"{policy}.txt", RATES[policy]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    right = [LIDARD_SIM, "live", tmp / "right.yaml"]
    with log.open("w") as sink, process([LIDARD, "run", "-c", tmp / "live.yaml"], stdout=sink, stderr=subprocess.STDOUT):
        with process([LIDARD_SIM, "live", tmp / "left.yaml"], **quiet):
            with process(right, **quiet) as scanner:
                watch.first(lambda m: seen(m) > 0.95, 0, 20, "a scan of both:\n" + log.read_text())
                watch.first_state(lambda s: s.level == 0, 0, 5, "all is well")
                begin, starved = time.monotonic(), Starved()
                time.sleep(2)
                check_rate(watch, begin, 2, rate, starved.seconds(), f"{policy}, both")
                scanner.kill()
                scanner.wait()
                killed, starved = time.monotonic(), Starved()
            gone = watch.first(unobserved, killed, 3, "its sector becomes unobserved") - killed
            told = watch.first_state(lambda s: s.level == 2 and "right" in s.message, killed, 3, "ERROR naming it") - killed
            late = starved.seconds()
            time.sleep(2)
            check_rate(watch, killed, 2, rate, starved.seconds(), f"{policy}, one dead")
            print(f"{policy}: sector unobserved {gone * 1000:.0f} ms, ERROR {told * 1000:.0f} ms after the kill")
            expect(gone < 0.25 + late, f"sector unobserved only after {gone:.3f} s")
            expect(told < 0.5 + late, f"ERROR only after {told:.3f} s")
            expect(all(unobserved(m) for t, m in watch.scans if t > killed + gone), "and stays so")
            returned, starved = time.monotonic(), Starved()
            with process(right, **quiet):
                first = wait_for(lambda: next((t for t in watch.own if t > returned), None), 10, "its scans again")
                back = watch.first(lambda m: seen(m) > 0.95, returned, 5, "its sector is back") - first
                watch.first_state(lambda s: s.level == 0, returned, 5, "all is well again")
                print(f"{policy}: sector back {back * 1000:.0f} ms after the scanner's first scan")
                expect(back < 0.2 + starved.seconds(), f"back only after {back:.3f} s")
    watch.close()


def main():
    master, port = free_port(), free_port(socket.SOCK_DGRAM)
    use_master_at(master)
    with folder() as tmp, ros_master(master):
        rospy.init_node("listener", disable_signals=True, anonymous=True)
        for policy in POLICIES:
            drop_out(policy, tmp, port)
    print("ok")


if __name__ == "__main__":
    main()
