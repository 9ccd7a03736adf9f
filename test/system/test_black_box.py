#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The black box of a running daemon: `lidard dump`, SIGUSR1 and an error write the last packets, which replay to the scans that
were published; a sensor that has not come yet makes no capture; SIGHUP does not end the daemon."""
import json
import pathlib
import re
import signal
import socket
import time

import rosbag
from harness import daemon, expect, free_port, run, sim, wait_for, write
from ros_tools import Listener, ros_test

SCENE = """\
start: 2026-01-01T00:00:00Z
duration: 600
sensors:
  front: {{model: sick_microscan3, from: '192.168.0.21:6060', to: '127.0.0.1:{front}', pose: {{xyz: [0, 0, 0.35]}}}}
  lms: {{model: sick_lms1xx, from: '192.168.0.10:{lms}', to: '127.0.0.1:40000'}}
objects:
  - wall: {{from: [8, -8], to: [4, 8], z: [-1, 2]}}
"""
CONFIG = """\
sensors:
  front: {{model: sick_microscan3, ip_address: 127.168.0.21, ip_port: {front}, listen_only: true, pose: {{xyz: [0, 0, 0.35]}}}}
  lms: {{model: sick_lms1xx, ip_address: 127.168.0.10, ip_port: {lms}, pose: {{xyz: [0, 0, 0.35]}}}}
"""
LIVE_CONFIG = CONFIG + """\
  late: {{model: sick_lms1xx, ip_address: 127.168.0.11, ip_port: {lms}, pose: {{xyz: [0, 0, 0.35]}}}}
merged_scans:
  around: {{laserscan_topics: [front, lms, late], range_max: 25}}
blackbox: {{seconds: 4, path: {path}}}
"""
TOPICS = ("/front/scan", "/lms/scan")


def dumped(tmp, count):
    captures = sorted((tmp / "box").glob("*.pcap"))
    return captures if len(captures) >= count else None


def beside(capture):
    return capture.with_name(capture.name.replace(".pcap", ".events.json"))


def check_replay(tmp, capture, published):
    """Each scan of the capture is one that was published: the same ranges at the same time."""
    bag = tmp / "again.bag"
    done = run("replay", "-c", tmp / "replay.yaml", "--pcap", capture, "--bag", bag)
    expect(done.returncode == 0, f"exit {done.returncode}: {done.stdout}{done.stderr}")
    for topic in TOPICS:
        live = {scan.ranges for scan in published[topic]}
        again = [message for _, message, _ in rosbag.Bag(str(bag)).read_messages(topics=[topic])]
        expect(len(again) > 20, f"{topic}: {len(again)} scans in {capture.name}")
        for scan in again:
            expect(scan.ranges in live, f"{topic}: a scan that was never published")
        # The clocks of the devices are learnt anew in a replay.
        near = [min(abs(scan.header.stamp.to_sec() - other.header.stamp.to_sec()) for other in published[topic]) for scan in again]
        expect(max(near) < 0.02, f"{topic}: stamps off by {max(near)} s")
        print(f"{topic}: {len(again)} scans again, stamps within {1000 * max(near):.1f} ms")


def main():
    ports = {name: free_port(socket.SOCK_DGRAM) for name in ("front", "lms")}
    with ros_test() as (tmp, _):
        scene, live = write(tmp / "scene.yaml", SCENE.format(**ports)), write(tmp / "live.yaml", LIVE_CONFIG.format(path=tmp / "box", **ports))
        write(tmp / "replay.yaml", CONFIG.format(**ports))
        published = {topic: Listener(topic).messages for topic in TOPICS}
        with daemon(live) as child:
            with sim(scene) as simulator:
                wait_for(lambda: all(len(scans) > 250 for scans in published.values()), 30, "scans")
                wait_for(lambda: "late: nothing received" in child.said(), 10, "the sensor that does not come is an error")
                time.sleep(6)  # longer than it takes until an error is written
                # A simulator that is starved is silent.
                others = [line for line in child.said().splitlines() if " error: " in line and not re.search("sensor late|without late$", line)]
                expect(others or not dumped(tmp, 1), f"a capture of a sensor that has not come yet: {child.said()}")
                done = run("dump")
                capture = pathlib.Path(done.stdout.strip())
                expect(done.returncode == 0 and capture.suffix == ".pcap" and capture.exists(), done.stdout + done.stderr)
                check_replay(tmp, capture, published)
                events = json.loads(beside(capture).read_text())
                expect("events" in events, str(events))
                child.send_signal(signal.SIGHUP)
                child.send_signal(signal.SIGUSR1)
                wait_for(lambda: dumped(tmp, 2), 10, "the capture that SIGUSR1 asks for")
                expect(child.poll() is None, "SIGHUP ended the daemon")
                count = len(dumped(tmp, 1))
                simulator.kill()
            newest = wait_for(lambda: dumped(tmp, count + 1), 20, "a capture some seconds after the error")[-1]
            wait_for(lambda: "in " + str(newest) in child.said(), 10, "the log says where it is")
            expect("ERROR" in beside(newest).read_text(), "the error is among the events beside")
            expect("live.yaml is in force" in child.said(), "the log says what became of SIGHUP")
    print("ok")


if __name__ == "__main__":
    main()
