#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""velodyne_node with parameters of ros-drivers/velodyne on a real master: clouds and scans come, live and of a capture."""
import math
import signal
import socket
import struct
import subprocess
import xml.etree.ElementTree

import dynamic_reconfigure.client
import rospy
from harness import ROOT, expect, expect_end, folder, free_port, logged, named_program, ros_master, send_for_ever, use_master_at, wait_for
from ros_tools import set_parameters
from sensor_msgs.msg import LaserScan, PointCloud2

DEMO = str(ROOT / "pcaps/demo.pcap")
# Of a capture that is played again and again.
PLAYED = {"pcap": DEMO, "port": 2368, "repeat_delay": 0.1}


class Topics:
    """What comes on the two topics of the drop-in, below a namespace."""

    def __init__(self, namespace=""):
        self.clouds, self.scans = [], []
        rospy.Subscriber(f"{namespace}/velodyne_points", PointCloud2, self.clouds.append, queue_size=100)
        rospy.Subscriber(f"{namespace}/scan", LaserScan, self.scans.append, queue_size=100)
        self.packets = []
        rospy.Subscriber(f"{namespace}/velodyne_packets", rospy.AnyMsg, self.packets.append, queue_size=100)


def check_cloud(cloud):
    expect(cloud.header.frame_id == "roof", f"frame {cloud.header.frame_id}")
    layout = [(f.name, f.offset, f.datatype, f.count) for f in cloud.fields]
    expect(layout == [("x", 0, 7, 1), ("y", 4, 7, 1), ("z", 8, 7, 1), ("intensity", 12, 7, 1), ("ring", 16, 4, 1),
                      ("time", 18, 7, 1)] and cloud.point_step == 22, f"layout of velodyne_points: {layout}")
    times, ranges = [], []
    for point in range(cloud.width * cloud.height):
        x, y, z, _, ring, time = struct.unpack_from("<ffffHf", cloud.data, point * 22)
        times.append(time)
        ranges.append(math.sqrt(x * x + y * y + z * z))
        expect(0 <= ring < 16, f"ring {ring}")
    expect(max(times) == 0 and -0.11 < min(times) < -0.09, f"times {min(times)} to {max(times)}: stamp is the last firing")
    expect(min(ranges) > 0.99 and max(ranges) < 20.01, f"ranges {min(ranges)} to {max(ranges)}")


def check_scan(scan):
    expect(scan.header.frame_id == "roof", f"frame {scan.header.frame_id}")
    n = len(scan.ranges)
    expect(n == round(2 * math.pi / 0.007), f"{n} beams")
    expect(abs(scan.angle_max - scan.angle_min - (n - 1) * scan.angle_increment) < 1e-4, "angles agree with their number")
    expect(0.09 < scan.scan_time < 0.11 and abs(scan.time_increment * n - scan.scan_time) < 1e-4,
           f"true times: {scan.scan_time} s, {n} times {scan.time_increment} s")
    hits = [r for r in scan.ranges if math.isfinite(r)]
    expect(len(hits) > 100, f"{len(hits)} of {n} beams hit")


def check_launch_files():
    """Each sets only parameters that velodyne_node knows: the node complains of others."""
    names = set()
    for launch in sorted((ROOT / "config/velodyne").glob("*.launch")):
        tree = xml.etree.ElementTree.parse(launch)
        expect(tree.find("node").get("type") == "velodyne_node", f"{launch.name} starts velodyne_node")
        arguments = {arg.get("name"): arg.get("default") for arg in tree.findall("arg")}
        expect(arguments.get("publish_packets") == "true", f"{launch.name}: publish_packets := {arguments.get('publish_packets')}")
        for param in tree.findall("node/param"):
            value = param.get("value")
            used = value[len("$(arg "):-1] if value.startswith("$(arg ") else None
            expect(used is None or used in arguments, f"{launch.name}: {value}")
            names.add((param.get("name"), arguments[used] if used else value))
    return names


def farthest(cloud):
    points = (struct.unpack_from("<fff", cloud.data, i * 22) for i in range(cloud.width * cloud.height))
    return max(math.hypot(*point) for point in points if math.isfinite(point[0]))


def reconfigure(program, port, parameters, tmp):
    """The items of velodyne_pointcloud's nodes, while the capture plays: not a revolution is lost."""
    topics = Topics("/live")
    set_parameters(port, "/live/velodyne", {**parameters, **PLAYED})
    with logged([program, "__name:=velodyne", "__ns:=/live"], tmp / "live.txt") as node:
        wait_for(lambda: len(topics.clouds) > 3, 30, "clouds come:\n" + node.said())
        expect(farthest(topics.clouds[-1]) > 9, "a wall stands farther away than 9 m")
        server = dynamic_reconfigure.client.Client("/live/velodyne", timeout=20)
        items = server.get_configuration()
        expect(items["max_range"] == 130 and items["organize_cloud"] is False, f"values in force: {items}")
        changed = server.update_configuration({"max_range": 8.0, "organize_cloud": True})
        expect(changed["max_range"] == 8 and changed["organize_cloud"] is True, f"accepted: {changed}")
        wait_for(lambda: topics.clouds[-1].height > 1 and farthest(topics.clouds[-1]) <= 8.01, 10, "8 m, and organised")
        wait_for(lambda: rospy.get_param("/live/velodyne/max_range") == 8, 10, "the parameter server knows it")
        refused = server.update_configuration({"min_range": 9.0})
        expect(refused["min_range"] == 1 and refused["max_range"] == 8, f"what cannot be changes nothing: {refused}")
        expect("max_range is not above min_range" in node.said(), node.said())
        server.close()


PARAMETERS = {"model": "VLP16", "frame_id": "roof", "rpm": 600.0, "min_range": 1.0, "max_range": 130.0, "laserscan_ring": -1,
              "laserscan_resolution": 0.007, "cut_angle": -0.01, "timestamp_first_packet": False, "device_ip": "", "pcap": "",
              "calibration": ""}


def live(program, port, data, tmp):
    topics = Topics()
    set_parameters(port, "/velodyne", {**PARAMETERS, "port": data})
    with logged([program, "__name:=velodyne", "_max_range:=20.0"], tmp / "log.txt") as node:
        wait_for(lambda: "ROS master found" in node.said(), 20, "it starts:\n" + node.said())
        with send_for_ever(DEMO, {2368: data, 6060: free_port(socket.SOCK_DGRAM)}):
            wait_for(lambda: len(topics.clouds) > 3 and len(topics.scans) > 3, 30, "velodyne_points and scan come:\n" + node.said())
        complaints = [line for line in node.said().splitlines() if "no effect" in line and " info: " not in line]
        expect(not complaints, "what stands at its default is no warning:\n" + "\n".join(complaints))
        expect_end(node, signal.SIGTERM, 5)
    for cloud in topics.clouds[:3]:
        check_cloud(cloud)
    for scan in topics.scans[:3]:
        check_scan(scan)
    expect(len(topics.packets) > 3, "packets come to whoever subscribes, as from velodyne_driver")


def played(program, port, tmp):
    topics = Topics("/car")
    set_parameters(port, "/car/velodyne", {**PARAMETERS, **PLAYED, "max_range": 20.0})
    with logged([program, "__name:=velodyne", "__ns:=/car"], tmp / "car.txt") as node:
        wait_for(lambda: len(topics.clouds) > 6 and len(topics.scans) > 6 and len(topics.packets) > 6, 30,
                 "the capture is played again and again:\n" + node.said())
    kinds = {packets._connection_header["type"] for packets in topics.packets}
    expect(kinds == {"velodyne_msgs/VelodyneScan"}, f"velodyne_packets: {kinds}")
    age = rospy.Time.now().to_sec() - topics.clouds[-1].header.stamp.to_sec()
    expect(0 <= age < 20, f"stamps are of now, {age} s old")


def refusals(program, port):
    set_parameters(port, "/checked", {"model": "VLP16", "pcap": "/nowhere.pcap",
                                      **{n: v for n, v in check_launch_files() if n not in ("pcap", "model")}})
    done = subprocess.run([program, "__name:=checked"], capture_output=True, text=True, timeout=20, check=False)
    expect(done.returncode == 1 and "/nowhere.pcap" in done.stderr, f"a missing capture: {done}")
    expect("not known" not in done.stdout + done.stderr, f"launch files set known parameters: {done}")
    set_parameters(port, "/wrong", {"model": "VLP17"})
    done = subprocess.run([program, "__name:=wrong"], capture_output=True, text=True, timeout=20, check=False)
    expect(done.returncode == 78 and "expected one of VLP16" in done.stderr, f"a wrong model: {done}")


def main():
    port, data = free_port(), free_port(socket.SOCK_DGRAM)
    use_master_at(port)
    with folder() as tmp:
        program = named_program(tmp, "velodyne_node")
        code = subprocess.run([program, "nonsense"], capture_output=True, text=True, check=False)
        expect(code.returncode == 2 and "neither a parameter" in code.stderr, f"usage: {code}")
        with logged([program, "__name:=velodyne", "_max_range:=20.0"], tmp / "log.txt") as node:
            wait_for(lambda: "waiting for the ROS master" in node.said(), 10, "it waits for the master")
        with ros_master(port):
            rospy.init_node("listener", disable_signals=True, anonymous=True)
            live(program, port, data, tmp)
            reconfigure(program, port, {**PARAMETERS, "port": data}, tmp)
            played(program, port, tmp)
            refusals(program, port)
    print("ok")


if __name__ == "__main__":
    main()
