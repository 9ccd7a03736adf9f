#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Under /use_sim_time the stamps of topics are those of /clock, which are kept."""
import threading
import time

import rospy
from harness import daemon, expect, wait_for, write
from ros_tools import Diagnostics, Listener, ros_test, set_parameters, wall_scan
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan

CONFIG = """\
sensors:
  left: {topic: /left, pose: {xyz: [0, 0, 0.3]}}
  right: {topic: /right, pose: {xyz: [0, 0, 0.3]}}
merged_scans:
  around: {laserscan_topics: [left, right], range_max: 20}
"""
SCAN = [4.0] * 300


def ages(listener, seconds, now):
    """How old the stamps are by that clock when the messages come."""
    before, ahead = len(listener.messages), now() - time.monotonic()
    time.sleep(seconds)
    return [at + ahead - message.header.stamp.to_sec() for message, at in list(zip(listener.messages, listener.times))[before:]]


class Simulator:
    """/clock, a scanner's messages that are stamped by it, and nothing else."""

    def __init__(self, begin):
        self.begin, self.started, self.running = begin, time.time(), True
        self.clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self.scans = {side: rospy.Publisher(f"/{side}", LaserScan, queue_size=5) for side in ("left", "right")}
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


def main():
    with ros_test() as (tmp, master):
        set_parameters(master.port, "", {"use_sim_time": True})
        diagnostics, around, simulated = Diagnostics(), Listener("/around"), Simulator(1000.0)
        with daemon(write(tmp / "live.yaml", CONFIG)) as child:
            wait_for(lambda: len(around.messages) > 20, 20, "outputs:\n" + child.said())
            time.sleep(3)
            expect(diagnostics.level("sensor left") == 0 and diagnostics.level("sensor right") == 0, diagnostics.message("sensor right"))
            old = ages(around, 1.5, simulated.now)
            expect(len(old) > 5 and min(old) > -0.001 and max(old) < 1, f"the simulator's stamps: {old[:5]}")
            print(f"/use_sim_time: stamps of /clock, {min(old):.3f} to {max(old):.3f} s old")
        simulated.close()
    print("ok")


if __name__ == "__main__":
    main()
