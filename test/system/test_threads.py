#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The daemon has five threads beside those of roscpp, however many sensors, topics, transforms and dynamic_reconfigure servers it
has to do with: before the master comes, with it, after the node was shut down from outside, and with a master that was restarted."""
import pathlib
import signal
import socket
import time
import xmlrpc.client

import rosgraph
import rospy
from harness import (LIDARD, SCANNER_SCENE, daemon, expect, expect_end, folder, free_port, ros_master, sim, thread_names, use_master_at,
                     wait_for, write)
from nav_msgs.msg import Odometry
from ros_tools import Listener, Talker, static_transforms, transform, wall_scan

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
OURS = [pathlib.Path(LIDARD).name[:15], "lidard-clouds", "lidard-master", "lidard-ros"]
CALLBACKS = ["lidard-callback"]
ROSCPP = 3 * ["roscpp"]


def expect_threads(child, names, when):
    wait_for(lambda: thread_names(child.pid) == sorted(names), 10, f"{when}: the threads {sorted(names)}, not {thread_names(child.pid)}")
    time.sleep(2)  # and so it stays
    expect(thread_names(child.pid) == sorted(names), f"{when}: {thread_names(child.pid)}")
    print(f"{when}: {', '.join(thread_names(child.pid))}")


def check_with_master(child, scans, appeared):
    wait_for(lambda: scans.messages, 10, "merged scans:\n" + child.said())
    print(f"first scans {time.monotonic() - appeared:.1f} s after the master")
    wait_for(lambda: len(scans.messages) > 20, 10, "merged scans:\n" + child.said())
    expect_threads(child, OURS + CALLBACKS + ROSCPP, "with everything at work")
    xmlrpc.client.ServerProxy(rosgraph.Master("/test").lookupNode("/lidard")).shutdown("/intruder", "go away")
    wait_for(lambda: "starting again" in child.said(), 10, "it was shut down")
    seen = len(scans.messages)
    wait_for(lambda: len(scans.messages) > seen + 20, 20, "merged scans again:\n" + child.said())
    expect_threads(child, OURS + CALLBACKS + ROSCPP, "after it was shut down from outside")


def main():
    port, udp = free_port(), free_port(socket.SOCK_DGRAM)
    use_master_at(port)
    with folder() as tmp:
        config, scene = write(tmp / "live.yaml", CONFIG.format(port=udp)), write(tmp / "scene.yaml", SCANNER_SCENE.format(port=udp))
        with daemon(config) as child, sim(scene):
            wait_for(lambda: "no ROS master" in child.said(), 10, "the log says that there is no master")
            expect_threads(child, OURS, "without a master")
            with ros_master(port):
                appeared = time.monotonic()
                rospy.init_node("listener", disable_signals=True, anonymous=True)
                tf = static_transforms([transform("base_link", f"{name}_laser", (0, 0, 0)) for name in "abcd"])
                talkers = [Talker(f"/{name}", wall_scan(f"{name}_laser", [3.0] * 200)) for name in "abcd"]
                pose = Odometry(child_frame_id="base_link")
                pose.pose.pose.orientation.w = 1
                talkers.append(Talker("/odom", pose, 50))
                check_with_master(child, Listener("/ab"), appeared)
            with ros_master(port):
                wait_for(lambda: "registered again" in child.said(), 20, "it registers again")
                expect_threads(child, OURS + CALLBACKS + ROSCPP, "after the master was restarted")
            for talker in talkers:
                talker.running = False
            tf.unregister()
            expect_end(child, signal.SIGTERM)
    print("ok")


if __name__ == "__main__":
    main()
