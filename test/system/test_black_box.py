#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The black box of a running daemon: `lidard dump`, SIGUSR1 and an error write the last packets, which replay to the scans that
were published; a sensor that has not come yet makes no capture; SIGHUP does not end the daemon."""
import json
import os
import pathlib
import re
import signal
import subprocess
import time

import rosbag
import rospy
from harness import LIDARD, LIDARD_SIM, expect, folder, free_port, process, ros_master, run, use_master_at, wait_for
from sensor_msgs.msg import LaserScan

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
    ports = {name: free_port() for name in ("front", "lms", "master")}
    use_master_at(ports["master"])
    with folder() as tmp, ros_master(ports["master"]):
        check(tmp, ports)
    print("ok")


def check(tmp, ports):
    os.environ["LIDARD_SOCKET"] = str(tmp / "control")
    (tmp / "scene.yaml").write_text(SCENE.format(**ports))
    (tmp / "replay.yaml").write_text(CONFIG.format(**ports))
    (tmp / "live.yaml").write_text(LIVE_CONFIG.format(path=tmp / "box", **ports))
    rospy.init_node("listener", disable_signals=True, anonymous=True)
    published = {topic: [] for topic in TOPICS}
    for topic, scans in published.items():
        rospy.Subscriber(topic, LaserScan, scans.append, queue_size=1000)
    log = tmp / "log.txt"
    with log.open("w") as sink, process([LIDARD, "run", "-c", tmp / "live.yaml"], stdout=sink, stderr=subprocess.STDOUT) as daemon:
        with process([LIDARD_SIM, "live", tmp / "scene.yaml"], stdout=subprocess.DEVNULL) as simulator:
            wait_for(lambda: all(len(scans) > 250 for scans in published.values()), 30, "scans")
            wait_for(lambda: "late: nothing received" in log.read_text(), 10, "the sensor that does not come is an error")
            time.sleep(6)  # longer than it takes until an error is written
            # A simulator that is starved is silent.
            others = [line for line in log.read_text().splitlines() if " error: " in line and not re.search("sensor late|without late$", line)]
            expect(others or not dumped(tmp, 1), f"a capture of a sensor that has not come yet: {log.read_text()}")
            done = run("dump")
            capture = pathlib.Path(done.stdout.strip())
            expect(done.returncode == 0 and capture.suffix == ".pcap" and capture.exists(), done.stdout + done.stderr)
            check_replay(tmp, capture, published)
            events = json.loads(beside(capture).read_text())
            expect("events" in events, str(events))
            daemon.send_signal(signal.SIGHUP)
            daemon.send_signal(signal.SIGUSR1)
            wait_for(lambda: dumped(tmp, 2), 10, "the capture that SIGUSR1 asks for")
            expect(daemon.poll() is None, "SIGHUP ended the daemon")
            count = len(dumped(tmp, 1))
            simulator.kill()
        newest = wait_for(lambda: dumped(tmp, count + 1), 20, "a capture some seconds after the error")[-1]
        wait_for(lambda: "in " + str(newest) in log.read_text(), 10, "the log says where it is")
        expect("ERROR" in beside(newest).read_text(), "the error is among the events beside")
    expect("live.yaml is in force" in log.read_text(), "the log says what became of SIGHUP")


if __name__ == "__main__":
    main()
