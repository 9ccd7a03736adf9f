#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""One of two scanners dies while `lidard run` merges them: the merged scan stays at its rate, what only the dead one saw becomes
unobserved, /diagnostics says ERROR, and all is well again with the scanner's first sweep after its return."""
import math
import socket
import time

from harness import Starved, daemon, expect, free_port, scene_of, sim, wait_for, write
from ros_tools import Diagnostics, Listener, ros_test

SCANNER = "model: sick_microscan3, from: '192.168.0.{last}:6060', to: '127.0.0.1:{port}', pose: {{xyz: [0, {y}, 0.35], rpy_deg: [0, 0, {yaw}]}}"
ROOM = ("wall: {from: [8, -8], to: [8, 8], z: [-1, 2]}", "wall: {from: [-8, -8], to: [-8, 8], z: [-1, 2]}",
        "wall: {from: [-8, 8], to: [8, 8], z: [-1, 2]}", "wall: {from: [-8, -8], to: [8, -8], z: [-1, 2]}")
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
        self.around, self.own, self.states = Listener("/around"), Listener("/right/scan"), []
        self.diagnostics = Diagnostics(lambda name, status: name == "merged around" and self.states.append((time.monotonic(), status)))

    def scans(self):
        return list(zip(list(self.around.times), list(self.around.messages)))

    def first(self, condition, since, limit, what):
        """When the first scan came for which the condition holds."""
        return wait_for(lambda: next((t for t, m in self.scans() if t > since and condition(m)), None), limit, what)

    def first_state(self, condition, since, limit, what):
        return wait_for(lambda: next((t for t, s in list(self.states) if t > since and condition(s)), None), limit, what)

    def close(self):
        for one in (self.around, self.own, self.diagnostics):
            one.close()


def right_only(scan):
    """The ranges of the right scanner's own sector."""
    return [r for i, r in enumerate(scan.ranges)
            if RIGHT_ONLY[0] < math.remainder(scan.angle_min + i * scan.angle_increment, 2 * math.pi) < RIGHT_ONLY[1]]


def seen(scan):
    """The share of the sector that holds a range."""
    return sum(math.isfinite(r) for r in right_only(scan)) / len(right_only(scan))


def unobserved(scan):
    return all(math.isnan(r) for r in right_only(scan))


def check_rate(watch, begin, seconds, rate, starved, when):
    times = [t for t in list(watch.around.times) if begin < t < begin + seconds]
    gap = max((b - a for a, b in zip(times, times[1:])), default=9)
    print(f"{when}: {len(times) / seconds:.1f} scans/s, longest gap {gap * 1000:.0f} ms, starved {starved * 1000:.0f} ms")
    expect(abs(len(times) / seconds / rate - 1) < 0.15 + starved / seconds and gap < 0.3 + starved, f"{when}: {len(times)} scans in {seconds} s, gap {gap:.3f} s")
    stamps = [message.header.stamp for message in list(watch.around.messages)]
    bad = [(i, a, b) for i, (a, b) in enumerate(zip(stamps, stamps[1:])) if a >= b]
    expect(not bad, f"stamps increase: {bad[:3]} of {len(stamps)}")


def both_there(watch, policy, log):
    watch.first(lambda m: seen(m) > 0.95, 0, 20, "a scan of both:\n" + log())
    watch.first_state(lambda s: s.level == 0, 0, 5, "all is well")
    begin, starved = time.monotonic(), Starved()
    time.sleep(2)  # measured time
    check_rate(watch, begin, 2, RATES[policy], starved.seconds(), f"{policy}, both")


def one_dead(watch, policy, killed, starved):
    watch.first(unobserved, killed, 3, "its sector becomes unobserved")
    reported = watch.first_state(lambda s: s.level == 2 and "right" in s.message, killed, 3, "ERROR naming it") - killed
    late = starved.seconds()
    time.sleep(2)  # measured time
    check_rate(watch, killed, 2, RATES[policy], starved.seconds(), f"{policy}, one dead")
    # A daemon that is late may have scans of it to merge after a gap.
    gone = max((t for t, m in watch.scans() if not unobserved(m)), default=killed) - killed
    print(f"{policy}: sector unobserved {gone * 1000:.0f} ms, ERROR {reported * 1000:.0f} ms after the kill")
    expect(gone < 0.25 + late, f"sector unobserved only after {gone:.3f} s")
    expect(reported < 0.5 + late, f"ERROR only after {reported:.3f} s")


def comes_back(watch, policy, returned, starved):
    first = wait_for(lambda: next((t for t in list(watch.own.times) if t > returned), None), 10, "its scans again")
    back = watch.first(lambda m: seen(m) > 0.95, returned, 5, "its sector is back") - first
    watch.first_state(lambda s: s.level == 0, returned, 5, "all is well again")
    print(f"{policy}: sector back {back * 1000:.0f} ms after the scanner's first scan")
    expect(back < 0.2 + starved.seconds(), f"back only after {back:.3f} s")


def drop_out(policy, tmp, port):
    config = write(tmp / f"{policy}.yaml", CONFIG.format(port=port, keys=POLICIES[policy]))
    left, right = (write(tmp / f"{name}.yaml", scene_of({name: SCANNER.format(last=last, y=y, yaw=yaw, port=port)}, *ROOM))
                   for name, last, y, yaw in (("left", 21, 1, 45), ("right", 22, -1, -45)))
    watch = Watch()
    with daemon(config) as child, sim(left):
        with sim(right) as scanner:
            both_there(watch, policy, child.said)
            scanner.kill()
            scanner.wait()
            killed, starved = time.monotonic(), Starved()
        one_dead(watch, policy, killed, starved)
        returned, starved = time.monotonic(), Starved()
        with sim(right):
            comes_back(watch, policy, returned, starved)
    watch.close()


def main():
    port = free_port(socket.SOCK_DGRAM)
    with ros_test() as (tmp, _):
        for policy in POLICIES:
            drop_out(policy, tmp, port)
    print("ok")


if __name__ == "__main__":
    main()
