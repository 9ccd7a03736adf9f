#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Topics whose node has another clock: a scanner's or a cloud's messages from an hour ahead, an hour ago or without stamps are merged
as of their arrival, and the WARN names topic, offset and remedy, also where the clock is set while all runs. Under /use_sim_time the
stamps are those of /clock, which are kept."""
import math
import threading
import time

import rospy
from harness import Starved, daemon, expect, wait_for, write
from ros_tools import Diagnostics, Listener, Talker, cloud_of, ros_test, set_parameters, wall_scan
from rosgraph_msgs.msg import Clock

CONFIG = """\
sensors:
  left: {topic: /left, pose: {xyz: [0, 0, 0.3]}}
  right: {topic: /right, pose: {xyz: [0, 0, 0.3]}}
  roof: {topic: /roof, pose: {xyz: [0, 0, 2]}}
  tail: {topic: /tail, pose: {xyz: [0, 0, 2]}}
merged_scans:
  around: {laserscan_topics: [left, right], range_max: 20}
merged_clouds:
  clouds: {sources: [roof, tail]}
virtual_scans:
  levels: {cloud_topic: clouds, virtual_laser_scan: [low], poses: {low: {xyz: [0, 0, 0.5]}}}
"""
SCAN = [4.0] * 300
POINTS = [(4 * math.cos(i / 100), 4 * math.sin(i / 100), -1.5) for i in range(600)]


def ages(listener, seconds, now=time.time):
    """How old the stamps are by that clock when the messages come."""
    before, ahead = len(listener.messages), now() - time.monotonic()
    time.sleep(seconds)
    return [at + ahead - message.header.stamp.to_sec() for message, at in list(zip(listener.messages, listener.times))[before:]]


def check(outputs, diagnostics, sensor, offset, what):
    text = wait_for(lambda: offset in diagnostics.message(f"sensor {sensor}") and diagnostics.message(f"sensor {sensor}"), 10,
                    f"{sensor} is a WARN, {what}")
    expect(f"/{sensor}" in text and "chrony" in text and "time_offset" in text and diagnostics.level(f"sensor {sensor}") == 1, text)
    wait_for(lambda: int(diagnostics.values(f"sensor {sensor}")["Stamps replaced"]) > 5, 10, "it is counted")
    for topic, listener in outputs.items():
        starved = Starved()
        old = ages(listener, 1.5)
        expect(len(old) > 10 * (1 - starved.seconds()), f"{topic} goes on: {len(old)}, {what}")
        expect(min(old) > 0 and max(old) < 0.3 + starved.seconds(), f"{topic} is {min(old):.3f} to {max(old):.3f} s old, {what}")
    print(f"{what}: {text}")


def other_clocks(config, outputs, diagnostics):
    talkers = {"left": Talker("/left", wall_scan("left", SCAN)), "right": Talker("/right", wall_scan("right", SCAN)),
               "roof": Talker("/roof", cloud_of(POINTS, "roof")), "tail": Talker("/tail", cloud_of(POINTS, "tail"))}
    with daemon(config) as child:
        wait_for(lambda: all(len(one.messages) > 5 for one in outputs.values()), 20, "outputs:\n" + child.said())
        wait_for(lambda: diagnostics.level("sensor right") == 0, 10, "all is well")
        for ahead in (3600, -3600, 7200):
            for sensor in ("right", "tail"):
                talkers[sensor].offset = rospy.Duration(ahead)
            time.sleep(1)
            direction = "ahead of" if ahead > 0 else "behind"
            for sensor in ("right", "tail"):
                check(outputs, diagnostics, sensor, direction, f"{ahead} s ahead")
        for sensor in ("right", "tail"):
            talkers[sensor].offset = rospy.Duration(0)
        wait_for(lambda: diagnostics.level("sensor right") == 0 and diagnostics.level("sensor tail") == 0, 20, "all is well again")
    for one in talkers.values():
        one.close()


class Simulator:
    """/clock, a scanner's messages that are stamped by it, and nothing else."""

    def __init__(self, begin):
        self.begin, self.started, self.running = begin, time.time(), True
        self.clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self.scans = {side: rospy.Publisher(f"/{side}", type(wall_scan(side, SCAN)), queue_size=5) for side in ("left", "right")}
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def now(self):
        return self.begin + time.time() - self.started

    def run(self):
        count = 0
        while self.running:
            self.clock.publish(Clock(clock=rospy.Time.from_sec(self.now())))
            for side, publisher in self.scans.items() if count % 5 == 0 else ():
                scan = wall_scan(side, SCAN)
                scan.header.stamp = rospy.Time.from_sec(self.now())
                publisher.publish(scan)
            count += 1
            time.sleep(0.01)

    def close(self):
        self.running = False
        self.thread.join()


def simulator(config, port, around, diagnostics):
    set_parameters(port, "", {"use_sim_time": True})
    simulated = Simulator(1000.0)
    before = len(around.messages)
    with daemon(config) as child:
        wait_for(lambda: len(around.messages) > before + 20, 20, "outputs:\n" + child.said())
        time.sleep(3)
        expect(diagnostics.level("sensor left") == 0 and diagnostics.level("sensor right") == 0, diagnostics.message("sensor right"))
        old = ages(around, 1.5, simulated.now)
        expect(len(old) > 5 and min(old) > -0.001 and max(old) < 1, f"the simulator's stamps: {old[:5]}")
        print(f"/use_sim_time: stamps of /clock, {min(old):.3f} to {max(old):.3f} s old")
    simulated.close()


def main():
    with ros_test() as (tmp, master):
        config = write(tmp / "live.yaml", CONFIG)
        diagnostics = Diagnostics()
        outputs = {topic: Listener(topic) for topic in ("/around", "/low")}
        other_clocks(config, outputs, diagnostics)
        simulator(config, master.port, outputs["/around"], diagnostics)
    print("ok")


if __name__ == "__main__":
    main()
