#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Somebody sets the host's clock while lidars of every family send: each stream of stamps makes that one step and no other, the
first frame after it is right, nothing is called silent, and the log says it once.

The program sees a clock that clock_shim.cpp moves, the kernel's stamps of packets too; the lidars and this test do not."""
import collections
import mmap
import os
import pathlib
import struct
import subprocess
import threading
import time

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from harness import LIDARD, LIDARD_SIM, Starved, expect, folder, free_port, process, ros_master, use_master_at, wait_for
from sensor_msgs.msg import LaserScan, PointCloud2
from tf2_msgs.msg import TFMessage

SCENE = """\
start: 2026-01-01T00:00:00Z
duration: 600
sensors:
  ms3: {{model: sick_microscan3, from: '192.168.0.21:6060', to: '127.0.0.1:{ms3}'}}
  roof: {{model: velodyne_vlp16, from: '192.168.1.201:2368', to: '127.0.0.1:{roof}'}}
  lms: {{model: sick_lms1xx, from: '192.168.0.10:{lms}', to: '127.0.0.1:40000'}}
  ust: {{model: hokuyo_ust_10lx, from: '192.168.0.13:{ust}', to: '127.0.0.1:40001'}}
objects:
  - wall: {{from: [4, -3], to: [4, 3], z: [-1, 1]}}
"""
CONFIG = """\
sensors:
  ms3: {{model: sick_microscan3, ip_address: 127.168.0.21, ip_port: {ms3}, listen_only: true, pose: {{xyz: [0, 0, 0.3]}}}}
  roof: {{model: velodyne_vlp16, ip_address: 127.168.1.201, ip_port: {roof}}}
  lms: {{model: sick_lms1xx, ip_address: 127.168.0.10, ip_port: {lms}, pose: {{xyz: [0, 0, 0.3]}}}}
  ust: {{model: hokuyo_ust_10lx, ip_address: 127.168.0.13, ip_port: {ust}}}
  other: {{topic: /other}}   # of a node that follows the host's clock, its pose is on tf
merged_scans:
  around: {{laserscan_topics: [ms3, lms, other]}}
"""
# Topic: message, period of its stamps in s.
STREAMS = {"/ms3/scan": (LaserScan, 0.03), "/roof/points": (PointCloud2, 0.1), "/lms/scan": (LaserScan, 0.02),
           "/ust/scan": (LaserScan, 0.025)}
SENSORS = ("ms3", "roof", "lms", "ust", "other", "merged around")
STEPS = [1.013, -1.013, 0.513, -0.513, 3600, -3600, 1e8, -1e8]
AGAIN = 4  # s between steps: clocks of devices are learnt by then
SHIM = pathlib.Path(os.environ["LIDARD_CLOCK_SHIM"])


class Clock:
    """What the program takes for the host's clock, moved by `seconds`."""

    def __init__(self, path):
        path.write_bytes(struct.pack("<q", 0))
        self.file = path.open("r+b")
        self.memory = mmap.mmap(self.file.fileno(), 8)
        self.seconds = 0

    def set_by(self, step):
        self.seconds += step
        self.memory[:] = struct.pack("<q", round(self.seconds * 1e9))


def check_steps(topic, stamps, period, step, starved):
    """Without the step in one place, neighbours are whole periods apart, and hardly anything is missing."""
    def fits(place):
        even = stamps[:place] + [stamp - step for stamp in stamps[place:]]
        apart = [after - before for before, after in zip(even, even[1:])]
        # The Hokuyo's counter is in whole ms: its stamps wander by a part of one.
        return all(0 < a < 0.5 + starved and abs(a - round(a / period) * period) < 0.003 for a in apart)

    places = [place for place in range(1, len(stamps)) if fits(place)]
    if len(places) != 1:
        steps = [f"{after - before:.6f}" for before, after in zip(stamps, stamps[1:])
                 if not 0 < after - before < 1.5 * period]
        expect(False, f"{topic}: not one step of {step} s and no other: {steps}")


def other_node(clock, stop):
    """A scanner's driver of somebody else, and its pose."""
    scans = rospy.Publisher("/other", LaserScan, queue_size=10)
    poses = rospy.Publisher("/tf", TFMessage, queue_size=10)
    scan = LaserScan(angle_min=-1, angle_max=1, angle_increment=0.02, range_min=0.1, range_max=20, scan_time=0.05, ranges=[4.0] * 101)
    scan.header.frame_id = "other_laser"
    pose = TransformStamped(child_frame_id="other_laser")
    pose.header.frame_id, pose.transform.rotation.w = "base_link", 1
    while not stop.wait(0.05):
        scan.header.stamp = rospy.Time.from_sec(time.time() + clock.seconds)
        pose.header.stamp = scan.header.stamp
        poses.publish(TFMessage([pose]))
        scans.publish(scan)


def main():
    ports = {name: free_port() for name in ("ms3", "roof", "lms", "ust", "master")}
    use_master_at(ports["master"])
    with folder() as tmp, ros_master(ports["master"]):
        (tmp / "scene.yaml").write_text(SCENE.format(**ports))
        (tmp / "live.yaml").write_text(CONFIG.format(**ports))
        clock = Clock(tmp / "clock")
        rospy.init_node("listener", disable_signals=True, anonymous=True)
        got, ages, levels = collections.defaultdict(list), collections.defaultdict(list), {}

        def take(message, topic):
            stamp = message.header.stamp.to_nsec() / 1e9
            got[topic].append(stamp)
            ages[topic].append(time.time() + clock.seconds - stamp)

        for topic, (kind, _) in STREAMS.items():
            rospy.Subscriber(topic, kind, take, topic, queue_size=1000)
        worst = collections.defaultdict(int)

        def judge(array):
            for status in array.status:
                name = status.name.split(": ")[-1]
                level = status.level if isinstance(status.level, int) else status.level[0]
                levels[name] = (level, status.message, {v.key: v.value for v in status.values})
                worst[name] = max(worst[name], level)

        rospy.Subscriber("/around", LaserScan, take, "/around", queue_size=1000)
        stop = threading.Event()
        threading.Thread(target=other_node, args=(clock, stop), daemon=True).start()
        rospy.Subscriber("/diagnostics", DiagnosticArray, judge, queue_size=100)
        log = tmp / "log.txt"
        environment = {**os.environ, "LD_PRELOAD": str(SHIM), "LIDARD_TEST_CLOCK": str(tmp / "clock")}
        with process([LIDARD_SIM, "live", tmp / "scene.yaml"], stdout=subprocess.DEVNULL), log.open("w") as sink, \
                process([LIDARD, "run", "-c", tmp / "live.yaml"], env=environment, stdout=sink, stderr=subprocess.STDOUT):
            wait_for(lambda: all(len(got[topic]) > 10 for topic in STREAMS), 30, "frames of all")
            time.sleep(AGAIN)
            for step in STEPS:
                starved = Starved()
                worst.clear()
                marks = {topic: len(got[topic]) - 1 for topic in STREAMS}
                clock.set_by(step)
                time.sleep(AGAIN)
                for topic, (_, period) in STREAMS.items():
                    check_steps(topic, got[topic][marks[topic]:], period, step, starved.seconds())
                    # What was on its way when the clock was set is judged by neither time.
                    late = ages[topic][marks[topic] + 20:]
                    expect(min(late) > -0.001, f"{topic}: a stamp {-min(late):.4f} s ahead of the clock after {step} s")
                merged = got["/around"][-1] - (time.time() + clock.seconds)
                expect(-1 - starved.seconds() < merged < 0.001, f"/around: its stamp is {merged:.3f} s from now after {step} s")
                ill = {name: levels[name][1] for name, level in worst.items() if level > 0 and name in SENSORS}
                expect(not ill or starved.seconds() > 0.1, f"after {step} s: {ill}")
                print(f"set by {step} s: one step in each of {len(STREAMS)} streams, ages "
                      + ", ".join(f"{1000 * sorted(ages[t][marks[t] + 20:])[len(ages[t][marks[t] + 20:]) // 2]:.1f}" for t in STREAMS) + " ms")
            expect(levels["clock"][2]["Steps"] == str(len(STEPS)), f"/diagnostics counts {levels['clock']}")
            stop.set()
        told = [line for line in log.read_text().splitlines() if "clock was set" in line]
        expect(len(told) == len(STEPS), f"the log says {len(told)} times that the clock was set:\n" + log.read_text())
    print("ok")


if __name__ == "__main__":
    main()
