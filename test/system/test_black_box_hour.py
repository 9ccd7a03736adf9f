#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""An hour of a black box in short: six lidars, three incidents a minute, a dump every five minutes. Each error lies in a capture
with all of its minute, the first capture of each kind of error stays, and the memory stays as it is after the first minute.

    test_black_box_hour.py [SECONDS]     default 240; 3600 for a release; with LIDARD, LIDARD_SIM and LIDARD_SOURCE_DIR set as
                                         ctest does
"""
import contextlib
import datetime
import json
import mmap
import os
import pathlib
import re
import signal
import struct
import subprocess
import sys
import time

from harness import LIDARD, LIDARD_SIM, expect, folder, free_port, process, ros_master, run, use_master_at, wait_for

# The truck of the manual's recipes. Those that fall silent again and again have simulators of their own.
SCENE = """\
start: 2026-01-01T00:00:00Z
duration: {duration}
objects:
  - box: {{center: [0.3, -0.7, 2], size: [37, 32, 9], rpy_deg: [0, 0, 12], reflectivity: 0.5}}
sensors:
"""
SENSORS = {
    "front_left": "model: sick_microscan3, from: '192.168.0.21:6060', to: '127.0.0.1:{front_left}'",
    "front_right": "model: sick_microscan3, from: '192.168.0.22:6060', to: '127.0.0.1:{front_right}'",
    "rear_left": "model: hokuyo_ust_10lx, from: '192.168.0.31:{rear_left}', to: '127.0.0.1:40000'",
    "rear_right": "model: hokuyo_ust_10lx, from: '192.168.0.32:{rear_right}', to: '127.0.0.1:40000'",
    "roof": "model: velodyne_vlp32c, from: '192.168.1.201:2368', to: '127.0.0.1:{roof}', pose: {{xyz: [0, 0, 3]}}",
    "tail": "model: velodyne_vlp16, from: '192.168.1.202:2368', to: '127.0.0.1:{tail}', pose: {{xyz: [-7, 0, 3]}}",
}
FILES = 10
FLAPPING = ("front_left", "rear_left")
CONFIG = """\
sensors:
  front_left: {{model: sick_microscan3, ip_address: 127.168.0.21, ip_port: {front_left}, listen_only: true, pose: {{xyz: [1.2, 1.2, 0.4]}}}}
  front_right: {{model: sick_microscan3, ip_address: 127.168.0.22, ip_port: {front_right}, listen_only: true, pose: {{xyz: [1.2, -1.2, 0.4]}}}}
  rear_left: {{model: hokuyo_ust_10lx, ip_address: 127.168.0.31, ip_port: {rear_left}, pose: {{xyz: [-6.9, 1.2, 0.4]}}}}
  rear_right: {{model: hokuyo_ust_10lx, ip_address: 127.168.0.32, ip_port: {rear_right}, pose: {{xyz: [-6.9, -1.2, 0.4]}}}}
  roof: {{model: velodyne_vlp32c, ip_address: 127.168.1.201, ip_port: {roof}}}
  tail: {{model: velodyne_vlp16, ip_address: 127.168.1.202, ip_port: {tail}}}
merged_scans:
  around: {{laserscan_topics: [front_left, front_right, rear_left, rear_right], range_max: 25}}
blackbox: {{seconds: {minute}, megabytes: {megabytes}, path: {path}, files: {files}}}
"""


def resident(daemon):
    """1e6 bytes."""
    return int(re.search(r"VmRSS:\s+(\d+) kB", pathlib.Path(f"/proc/{daemon.pid}/status").read_text())[1]) * 1024 / 1e6


def seconds_of(text):
    return datetime.datetime.fromisoformat(text.replace("Z", "+00:00")).timestamp()


def times(capture):
    """Of the first and the last packet, and how many there are."""
    with capture.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        at, first, count = 24, None, 0
        while at < len(data):
            s, ns, size = struct.unpack_from("<III", data, at)
            at, last, count = at + 16 + size, s + ns / 1e9, count + 1
            first = last if first is None else first
    return first, last, count


class Captures:
    """What the captures hold that were ever there."""

    def __init__(self, box):
        self.box, self.times, self.errors = box, {}, {}

    def look(self):
        for capture in sorted(self.box.glob("*.pcap")):
            if capture.name not in self.times:
                self.times[capture.name] = times(capture)
                for event in json.loads(capture.with_name(capture.name.replace(".pcap", ".events.json")).read_text())["events"]:
                    if event["level"] == "ERROR":
                        self.errors[(event["at"], event["source"])] = re.sub("[0-9]", "", event["text"])

    def hold(self, begin, end):
        """True if no moment between is missing."""
        for first, last, _ in sorted(self.times.values()):
            if first <= begin + 0.05:
                begin = max(begin, last)
        return begin >= end - 0.05


class Vehicle:
    def __init__(self, tmp, duration):
        self.tmp, self.ports = tmp, {name: free_port() for name in SENSORS}
        self.scene = SCENE.format(duration=duration)

    def simulate(self, stack, names):
        scene = self.tmp / f"{names[0]}.yaml"
        scene.write_text(self.scene + "".join(f"  {name}: {{{SENSORS[name].format(**self.ports)}}}\n" for name in names))
        return stack.enter_context(process([LIDARD_SIM, "live", scene], stdout=subprocess.DEVNULL))


def drive(daemon, simulators, captures, seconds, minute):
    """Runs the time out; returns when the incidents were, and what memory was used second by second."""
    begin, incidents, memory, dumps, stopped = time.monotonic(), [], [], 0, None
    while time.monotonic() < begin + seconds:
        now = time.monotonic() - begin
        if stopped is None and now > (len(incidents) + 1) * minute / 3 and now < seconds - 1.6 * minute:
            stopped = simulators[len(incidents) % len(simulators)]
            stopped.send_signal(signal.SIGSTOP)
            incidents.append(time.time())
        elif stopped is not None and time.time() > incidents[-1] + 3.6:
            stopped.send_signal(signal.SIGCONT)
            stopped = None
        if now > (dumps + 1) * 5 * minute:
            dumps += 1
            done = run("dump")
            expect(done.returncode == 0, done.stderr)
        captures.look()
        memory.append((time.monotonic() - begin, resident(daemon)))
        time.sleep(0.5)
    return incidents, memory


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 240
    minute, megabytes = 60, 256  # captures come a minute apart at least
    port = free_port()
    use_master_at(port)
    with folder() as tmp, ros_master(port), contextlib.ExitStack() as stack:
        os.environ["LIDARD_SOCKET"] = str(tmp / "control")
        vehicle, captures = Vehicle(tmp, int(seconds) + 120), Captures(tmp / "box")
        (tmp / "live.yaml").write_text(CONFIG.format(path=tmp / "box", minute=minute, megabytes=megabytes, files=FILES, **vehicle.ports))
        log = stack.enter_context((tmp / "log.txt").open("w"))
        simulators = [vehicle.simulate(stack, [name]) for name in FLAPPING]
        vehicle.simulate(stack, [name for name in SENSORS if name not in FLAPPING])
        daemon = stack.enter_context(process([LIDARD, "run", "-c", tmp / "live.yaml"], stdout=log, stderr=subprocess.STDOUT))
        wait_for(lambda: "6/6 lidars" in run("status").stdout, 30, "all lidars send")
        start = time.time()
        incidents, memory = drive(daemon, simulators, captures, seconds, minute)
        report(captures, incidents, memory, start, minute, megabytes, (tmp / "log.txt").read_text())
        print(f"{sum(1 for _ in (tmp / 'box').glob('*.pcap'))} captures are there")
    print("ok")


def report(captures, incidents, memory, start, minute, megabytes, log):
    without = memory[0][1]
    settled = max(mb for at, mb in memory if minute < at <= 2 * minute)
    most = max(mb for _, mb in memory)
    packets = sum(count for _, _, count in captures.times.values())
    print(f"{len(incidents)} incidents, {len(captures.errors)} errors, {len(captures.times)} captures with {packets} packets; "
          f"memory of the daemon {without:.0f} MB in the beginning, {settled:.0f} MB after the first minutes, at most {most:.0f} MB, {memory[-1][1]:.0f} MB in the end")
    expect("too slow" not in log, log)
    for at in incidents:
        expect(captures.hold(max(start, at - minute), at + 3.6), f"the incident at {at} is in no capture: {sorted(captures.times.values())}")
    lost = [error for error in captures.errors if not captures.hold(max(start, seconds_of(error[0]) - minute), seconds_of(error[0]))]
    expect(len(captures.errors) >= len(incidents) and not lost, f"errors in no capture: {lost}")
    for kind in {(source, text) for (_, source), text in captures.errors.items()}:
        first = min(seconds_of(at) for (at, source), text in captures.errors.items() if (source, text) == kind)
        kept = [name for name, (begin, end, _) in captures.times.items() if begin <= first <= end and (captures.box / name).exists()]
        # A starved machine has more kinds of errors than there are places; the first ones stay.
        older = [name for name, (begin, _, _) in captures.times.items() if begin < first and (captures.box / name).exists()]
        expect(kept or len(older) >= FILES - 1, f"the first capture of {kind} is gone")
    expect(most <= settled + 0.05 * megabytes, f"{settled:.0f} MB grew to {most:.0f} MB")
    expect(most - without <= 1.05 * megabytes, f"{without:.0f} MB grew to {most:.0f} MB")


if __name__ == "__main__":
    main()
