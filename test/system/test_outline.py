#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The vehicle's outline is on the topic footprint for everybody who comes, follows a reload, and is gone with the key; a bag has it
too."""
import signal
import socket

import rosbag
import rospy
from geometry_msgs.msg import PolygonStamped
from harness import ROOT, SCANNER_CONFIG, daemon, expect, free_port, run, wait_for, write
from ros_tools import ros_test

TRIANGLE = [[0.5, -1.0], [0.5, 1.0], [-4.25, 0.0]]
SQUARE = [[1.0, -1.0], [1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0]]


def corners(message):
    expect(message.header.frame_id == "rig", message.header.frame_id)
    expect(message.header.stamp.to_nsec() == 0, "holds at any time")
    expect(all(point.z == 0 for point in message.polygon.points), "on the ground")
    return [[point.x, point.y] for point in message.polygon.points]


def is_published():
    return "/footprint" in [name for name, _ in rospy.get_published_topics()]


def check_live(tmp):
    port = free_port(socket.SOCK_DGRAM)
    file = tmp / "vehicle.yaml"

    def change(outline):
        shape = f", footprint: {outline}" if outline else ""
        write(file, f"vehicle: {{base_frame: rig{shape}}}\n" + SCANNER_CONFIG.format(port=port))

    change(TRIANGLE)
    with daemon(file) as child:
        heard = []
        wait_for(is_published, 10, "the topic footprint")
        rospy.Subscriber("/footprint", PolygonStamped, heard.append)
        wait_for(lambda: heard, 10, "the outline")
        expect(corners(heard[0]) == TRIANGLE, str(heard[0]))
        change(SQUARE)
        child.send_signal(signal.SIGHUP)
        wait_for(lambda: corners(heard[-1]) == SQUARE, 10, "the outline after a reload")
        change(None)
        child.send_signal(signal.SIGHUP)
        wait_for(lambda: not is_published(), 10, "a vehicle without outline publishes none")


def check_bag(tmp):
    bag = tmp / "demo.bag"
    done = run("replay", "-c", ROOT / "config/demo.yaml", "--pcap", ROOT / "pcaps/demo.pcap", "--rate", "max", "--duration", "0.3",
               "--bag", bag)
    expect(bag.exists(), done.stderr)
    with rosbag.Bag(str(bag)) as messages:
        outlines = [message for _, message, _ in messages.read_messages("/footprint")]
    expect(len(outlines) == 1 and len(outlines[0].polygon.points) == 4, str(outlines))


def main():
    with ros_test() as (tmp, _):
        check_bag(tmp)
        check_live(tmp)
    print("ok")


if __name__ == "__main__":
    main()
