#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The daemon has six threads beside those of roscpp, however many sensors, topics, transforms and dynamic_reconfigure servers it
has to do with: before the master comes, with it, after the node was shut down from outside, and with a master that was restarted."""
import pathlib
import socket
import subprocess
import time
import xmlrpc.client

import rosgraph
import rospy
from harness import LIDARD, LIDARD_SIM, SCANNER_SCENE, expect, folder, free_port, process, ros_master, use_master_at, wait_for
from laser_tools import Listener, Talker, static_transforms, transform, wall_scan
from nav_msgs.msg import Odometry

CONFIG = """\
vehicle: {{odometry_topic: /odom}}
sensors:
  front: {{model: sick_microscan3, ip_address: 127.168.0.21, ip_port: {port}, listen_only: true, pose: {{xyz: [0, 0, 0]}}}}
  dialogue: {{model: sick_lms1xx, ip_address: 127.168.0.22, pose: {{xyz: [0, 0, 0]}}}}
  packets: {{model: velodyne_vlp16, packet_topic: /velodyne_packets, pose: {{xyz: [0, 0, 1]}}}}
  a: {{topic: /a}}
  b: {{topic: /b}}
  c: {{topic: /c}}
  d: {{topic: /d}}
merged_scans:
  ab: {{laserscan_topics: [a, b, front]}}
  cd: {{laserscan_topics: [c, d]}}
virtual_scans:
  levels: {{cloud_topic: packets, virtual_laser_scan: [low], poses: {{low: {{xyz: [0, 0, 0.5]}}}}}}
"""
OURS = [pathlib.Path(LIDARD).name[:15], "lidard-clouds", "lidard-master", "lidard-ros", "lidard-roscloud"]
CALLBACKS = ["lidard-callback"]
ROSCPP = ["roscpp-callback", "roscpp-sockets", "roscpp-xmlrpc"]


def names_of(daemon):
    return sorted((task / "comm").read_text().strip() for task in pathlib.Path(f"/proc/{daemon.pid}/task").iterdir())


def expect_threads(daemon, names, when):
    wait_for(lambda: names_of(daemon) == sorted(names), 10, f"{when}: the threads {sorted(names)}, not {names_of(daemon)}")
    time.sleep(2)
    expect(names_of(daemon) == sorted(names), f"{when}: {names_of(daemon)}")
    print(f"{when}: {', '.join(names_of(daemon))}")


def main():
    port, udp = free_port(), free_port(socket.SOCK_DGRAM)
    use_master_at(port)
    with folder() as tmp:
        (tmp / "live.yaml").write_text(CONFIG.format(port=udp))
        (tmp / "scene.yaml").write_text(SCANNER_SCENE.format(port=udp))
        log = tmp / "log.txt"
        with log.open("w") as sink, process([LIDARD, "run", "-c", tmp / "live.yaml"], stdout=sink, stderr=subprocess.STDOUT) as daemon, \
                process([LIDARD_SIM, "live", tmp / "scene.yaml"], stdout=subprocess.DEVNULL):
            wait_for(lambda: "no ROS master" in log.read_text(), 20, "it waits for the master")
            expect_threads(daemon, OURS, "without a master")
            with ros_master(port):
                rospy.init_node("listener", disable_signals=True, anonymous=True)
                scans = Listener("/ab")
                tf = static_transforms([transform("base_link", f"{name}_laser", (0, 0, 0)) for name in "abcd"])
                talkers = [Talker(f"/{name}", wall_scan(f"{name}_laser", [3.0] * 200)) for name in "abcd"]
                pose = Odometry(child_frame_id="base_link")
                pose.pose.pose.orientation.w = 1
                talkers.append(Talker("/odom", pose, 50))
                wait_for(lambda: len(scans.messages) > 20, 20, "merged scans:\n" + log.read_text())
                expect_threads(daemon, OURS + CALLBACKS + ROSCPP, "with everything at work")
                server = xmlrpc.client.ServerProxy(rosgraph.Master("/test").lookupNode("/lidard"))
                server.shutdown("/intruder", "go away")
                wait_for(lambda: "starting again" in log.read_text(), 10, "it was shut down")
                seen = len(scans.messages)
                wait_for(lambda: len(scans.messages) > seen + 20, 20, "merged scans again:\n" + log.read_text())
                expect_threads(daemon, OURS + CALLBACKS + ROSCPP, "after it was shut down from outside")
            with ros_master(port):
                wait_for(lambda: "registered again" in log.read_text(), 20, "it registers again")
                expect_threads(daemon, OURS + CALLBACKS + ROSCPP, "after the master was restarted")
            for talker in talkers:
                talker.running = False
            tf.unregister()
            daemon.terminate()
            expect(daemon.wait(20) == 0, "SIGTERM ends it with 0")
    print("ok")


if __name__ == "__main__":
    main()
