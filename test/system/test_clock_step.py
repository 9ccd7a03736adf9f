#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Somebody sets the host's clock while lidars of every family send: each stream of stamps makes that one step and no other, the
first frame after it is right, nothing is called silent, and the log says it once.

The program sees a clock that clock_shim.cpp moves, the kernel's stamps of packets too; the lidars and this test do not."""
import collections
import threading
import time

import rospy
from geometry_msgs.msg import TransformStamped
from harness import Clock, Starved, daemon, expect, free_port, scene_of, sim, wait_for, write
from ros_tools import Diagnostics, ros_test
from sensor_msgs.msg import LaserScan, PointCloud2
from tf2_msgs.msg import TFMessage

SENSORS = {"ms3": "model: sick_microscan3, from: '192.168.0.21:6060', to: '127.0.0.1:{}'",
           "roof": "model: velodyne_vlp16, from: '192.168.1.201:2368', to: '127.0.0.1:{}'",
           "lms": "model: sick_lms1xx, from: '192.168.0.10:{}', to: '127.0.0.1:40000'",
           "ust": "model: hokuyo_ust_10lx, from: '192.168.0.13:{}', to: '127.0.0.1:40001'"}
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
SENSORS_AND_SCANS = ("sensor ms3", "sensor roof", "sensor lms", "sensor ust", "other input", "merged around")
STEPS = [1.013, -1.013, 0.513, -0.513, 3600, -3600, 1e8, -1e8]
AGAIN = 4  # s between steps: clocks of devices are known by then
# s: where all packets of a device are late by more for a while, its clock was set (step_limit of DeviceClock).
LATE = 0.05


def check_steps(topic, stamps, period, step, starved, late):
    """Without the step in one place, neighbours are whole periods apart, and hardly anything is missing. Of lidars that were
    late themselves, whose pauses may be longer than the step, the order is checked alone; 1 ns apart is one number here."""
    def fits(place):
        even = stamps[:place] + [stamp - step for stamp in stamps[place:]]
        apart = [after - before for before, after in zip(even, even[1:])]
        if late > LATE:
            return all(-1e-6 < a < 0.5 + starved for a in apart)
        # The Hokuyo's counter is in whole ms: its stamps wander by a part of one.
        return all(0 < a < 0.5 + starved and abs(a - round(a / period) * period) < 0.003 for a in apart)

    places = [place for place in range(1, len(stamps)) if fits(place)]
    if len(places) != 1 and not (places and late > LATE):
        steps = [f"{after - before:.6f}" for before, after in zip(stamps, stamps[1:])
                 if not 0 < after - before < 1.5 * period]
        expect(False, f"{topic}: not one step of {step} s and no other, lidars late by {late:.3f} s: {steps}")


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


class Streams:
    """What comes on the topics: stamps, and how old they were by the moved clock; the worst level of each item."""

    def __init__(self, clock):
        self.clock, self.stamps, self.ages = clock, collections.defaultdict(list), collections.defaultdict(list)
        self.worst = collections.defaultdict(int)
        self.diagnostics = Diagnostics(lambda name, status: self.worst.update({name: max(self.worst[name], status.level)}))
        for topic, (kind, _) in {**STREAMS, "/around": (LaserScan, 0)}.items():
            rospy.Subscriber(topic, kind, self.keep, topic, queue_size=1000)

    def keep(self, message, topic):
        stamp = message.header.stamp.to_nsec() / 1e9
        self.stamps[topic].append(stamp)
        self.ages[topic].append(time.time() + self.clock.seconds - stamp)


def check_step(streams, step, lidars):
    clock, starved, late_lidars = streams.clock, Starved(), Starved([lidars])
    streams.worst.clear()
    marks = {topic: len(streams.stamps[topic]) - 1 for topic in STREAMS}
    clock.set_by(step)
    time.sleep(AGAIN)
    medians = []
    for topic, (_, period) in STREAMS.items():
        check_steps(topic, streams.stamps[topic][marks[topic]:], period, step, starved.seconds(), late_lidars.seconds())
        # What was on its way when the clock was set is judged by neither time.
        late = sorted(streams.ages[topic][marks[topic] + 20:])
        expect(late[0] > -0.001, f"{topic}: a stamp {-late[0]:.4f} s ahead of the clock after {step} s")
        medians.append(f"{1000 * late[len(late) // 2]:.1f}")
    merged = streams.stamps["/around"][-1] - (time.time() + clock.seconds)
    expect(-1 - starved.seconds() < merged < 0.001, f"/around: its stamp is {merged:.3f} s from now after {step} s")
    ill = {name: streams.diagnostics.message(name) for name, level in streams.worst.items() if level > 0 and name in SENSORS_AND_SCANS}
    expect(not ill or starved.seconds() > 0.1, f"after {step} s: {ill}")
    print(f"set by {step} s: one step in each of {len(STREAMS)} streams, ages {', '.join(medians)} ms")


def main():
    ports = {name: free_port() for name in SENSORS}
    with ros_test() as (tmp, _):
        scene = write(tmp / "scene.yaml", scene_of({name: keys.format(ports[name]) for name, keys in SENSORS.items()}))
        config = write(tmp / "live.yaml", CONFIG.format(**ports))
        clock, stop = Clock(tmp / "clock"), threading.Event()
        streams = Streams(clock)
        threading.Thread(target=other_node, args=(clock, stop), daemon=True).start()
        with sim(scene) as lidars, daemon(config, env=clock.environment()) as child:
            wait_for(lambda: all(len(streams.stamps[topic]) > 10 for topic in STREAMS), 30, "frames of all")
            time.sleep(AGAIN)
            for step in STEPS:
                check_step(streams, step, lidars)
            steps = streams.diagnostics.values("clock")["Steps"]
            expect(steps == str(len(STEPS)), f"/diagnostics counts {steps} steps")
            stop.set()
        logged = child.said().count("clock was set")
        expect(logged == len(STEPS), f"the log says {logged} times that the clock was set:\n" + child.said())
    print("ok")


if __name__ == "__main__":
    main()
