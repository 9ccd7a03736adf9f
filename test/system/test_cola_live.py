#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""SICK scanners that wait on loopback, in both dialects, `lidard run` and subscribers: scans at the scanners' rate, and again
after they were away."""
import json
import signal
import subprocess
import time

import rospy
from harness import LIDARD, LIDARD_SIM, Starved, check_stream, expect, folder, free_port, process, ros_master, run, use_master_at, wait_for
from sensor_msgs.msg import LaserScan, PointCloud2

SCENE = """\
start: 2026-01-01T00:00:00Z
duration: 600
sensors:
  lms: {{model: sick_lms1xx, from: '192.168.0.10:{lms}', to: '127.0.0.1:40000', jitter_us: 5000, options: {{clock_ppm: 100}}}}
  tim: {{model: sick_tim5xx, from: '192.168.0.11:{tim}', to: '127.0.0.1:40001', options: {{dialect: a}}}}
  mrs: {{model: sick_mrs1000, from: '192.168.0.12:{mrs}', to: '127.0.0.1:40002'}}
objects:
  - wall: {{from: [4, -3], to: [4, 3], z: [-1, 1]}}
"""
CONFIG = """\
sensors:
  lms: {{model: sick_lms1xx, ip_address: 127.168.0.10, ip_port: {lms}}}
  tim: {{model: sick_tim5xx, ip_address: 127.168.0.11, ip_port: {tim}}}
  mrs: {{model: sick_mrs1000, ip_address: 127.168.0.12, ip_port: {mrs}}}
"""
BEAMS = {"lms": 541, "tim": 811}


def check(name, scans, period, seconds, starved):
    check_stream(name, [scan.header.stamp.to_sec() for scan in scans], period, seconds, starved)
    expect(abs(scans[-1].header.stamp.to_sec() - time.time()) < 60, f"{name}: stamps are of today")
    for scan in scans if name in BEAMS else []:
        expect(len(scan.ranges) == BEAMS[name], f"{name}: {len(scan.ranges)} beams")
        ahead = scan.ranges[round(-scan.angle_min / scan.angle_increment)]
        expect(abs(ahead - 4) < 0.002, f"{name}: wall at {ahead} m")


def stand_still(daemon, scans):
    """What comes while the daemon stands for half a second is published afterwards: TCP loses nothing."""
    begin, started, starved = len(scans), time.monotonic(), Starved()
    for _ in range(3):
        daemon.send_signal(signal.SIGSTOP)
        time.sleep(0.5)
        daemon.send_signal(signal.SIGCONT)
        time.sleep(1.5)
    check("lms", scans[begin:], 0.02, time.monotonic() - started, starved.seconds())
    dropped = {topic["topic"]: topic["dropped"] for topic in json.loads(run("status", "--json").stdout)["topics"]}
    expect(dropped["lms/scan"] == 0, f"dropped on their way: {dropped}")
    print("lms: no scan is missing after three stops of 0.5 s")


def main():
    ports = {"lms": free_port(), "tim": free_port(), "mrs": free_port(), "master": free_port()}
    use_master_at(ports["master"])
    with folder() as tmp, ros_master(ports["master"]):
        (tmp / "scene.yaml").write_text(SCENE.format(**ports))
        (tmp / "live.yaml").write_text(CONFIG.format(**ports))
        log = tmp / "log.txt"
        simulator = [LIDARD_SIM, "live", tmp / "scene.yaml"]
        rospy.init_node("listener", disable_signals=True, anonymous=True)
        got = {"lms": [], "tim": [], "mrs": []}
        for name, frames in got.items():
            if name == "mrs":
                rospy.Subscriber("/mrs/points", PointCloud2, frames.append, queue_size=1000)
            else:
                rospy.Subscriber(f"/{name}/scan", LaserScan, frames.append, queue_size=1000)
        with log.open("w") as sink, process([LIDARD, "run", "-c", tmp / "live.yaml"], stdout=sink,
                                            stderr=subprocess.STDOUT) as daemon:
            with process(simulator, stdout=subprocess.DEVNULL):
                wait_for(lambda: all(len(frames) > 10 for frames in got.values()), 30, "frames of all")
                begin = {name: len(frames) for name, frames in got.items()}
                started, starved = time.monotonic(), Starved()
                time.sleep(4)
                seconds = time.monotonic() - started
                taken = {name: frames[begin[name]:] for name, frames in got.items()}
                starved = starved.seconds()
                for name, period in (("lms", 0.02), ("tim", 1 / 15), ("mrs", 0.08)):
                    check(name, taken[name], period, seconds, starved)
                stand_still(daemon, got["lms"])
            time.sleep(2)
            begin = {name: len(frames) for name, frames in got.items()}
            with process(simulator, stdout=subprocess.DEVNULL):
                back = time.monotonic()
                wait_for(lambda: all(len(frames) > begin[name] + 5 for name, frames in got.items()), 10,
                         "frames after the scanners were away")
                print(f"frames again {time.monotonic() - back:.1f} s after the scanners were back")
    print("ok")


if __name__ == "__main__":
    main()
