#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The recipe of two computers: scanners and the ROS master on one, the merged scan on the other, each in a network namespace of
its own, with the configurations of config/doc/recipes.md."""
import os
import re
import time

import rospy
from harness import LIDARD, LIDARD_SIM, ROOT, Starved, daemon, expect, folder, item, level, scene_of, wait_for, write
from network import Network
from ros_tools import Listener

SCENE = scene_of(
    {"front": "model: sick_microscan3, from: '192.168.1.21:6060', to: '127.0.0.1:6060', pose: {xyz: [1, 0, 0.3]}",
     "rear": "model: sick_microscan3, from: '192.168.1.22:6060', to: '127.0.0.1:6061', pose: {xyz: [-1, 0, 0.3], rpy_deg: [0, 0, 180]}"},
    "wall: {from: [6, -9], to: [6, 9], z: [-1, 2]}", "wall: {from: [-7, -9], to: [-7, 9], z: [-1, 2]}")
MASTER = "http://10.0.0.1:11311"


def recipe():
    """The two configurations; the lidars are those of lidard-sim, which sends from 127.168.0.0/16 and answers no dialogue."""
    page = (ROOT / "config/doc/recipes.md").read_text()
    first, second = re.findall(r"^```yaml\n(.*?)^```", page[page.index("## Two computers"):], re.S | re.M)
    return first.replace("192.168.", "127.168.").replace("model: sick_microscan3,", "model: sick_microscan3, listen_only: true,"), second


def main():
    network = Network()
    network.plug(host="10.0.0.2/24", lidars=("10.0.0.1/24",))
    with folder() as tmp:
        first, second = (write(tmp / f"{name}.yaml", text) for name, text in zip(("first", "second"), recipe()))
        there = ["env", "ROS_IP=10.0.0.1", f"ROS_MASTER_URI={MASTER}", f"ROS_LOG_DIR={tmp}", f"LIDARD_SOCKET={tmp}/first.socket"]
        os.environ.update(ROS_IP="10.0.0.2", ROS_MASTER_URI=MASTER, ROS_LOG_DIR=str(tmp), LIDARD_SOCKET=str(tmp / "second.socket"))
        os.environ.pop("ROS_HOSTNAME", None)
        network.start_lidar([*there, "/usr/bin/python3", "/usr/bin/rosmaster", "--core", "-p", "11311"])
        network.start_lidar([LIDARD_SIM, "live", str(write(tmp / "scene.yaml", SCENE))])
        network.start_lidar([*there, LIDARD, "run", "-c", str(first), "__name:=lidard_sensors"])
        with daemon(second):
            rospy.init_node("listener", disable_signals=True, anonymous=True)
            scans = Listener("around").messages
            wait_for(lambda: len(scans) > 30, 20, "merged scans on the second computer")
            starved, begin, count = Starved(), time.monotonic(), len(scans)
            time.sleep(3)  # measured time
            seconds, got = time.monotonic() - begin, len(scans) - count
            print(f"{got} merged scans in {seconds:.1f} s")
            expect(got > 25 * (seconds - starved.seconds()), f"{got} scans in {seconds:.1f} s, starved {starved.seconds():.2f} s")
            middle = scans[-1].ranges[len(scans[-1].ranges) // 2]
            expect(abs(middle - 6) < 0.1, f"the wall ahead is at {middle} m instead of 6")
            behind = scans[-1].ranges[0]
            expect(abs(behind - 7) < 0.1, f"the wall behind is at {behind} m instead of 7")
            expect(level("merged around") == "OK", str(item("merged around")))
    print("ok")


if __name__ == "__main__":
    main()
