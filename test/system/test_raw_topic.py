#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""raw_topic on a real master: a second lidard decodes the very same clouds from it, `rosbag record` keeps it, and whoever has no
velodyne_msgs reads the bag by the definition in it. `replay --bag` writes the same packets."""
import os
import pathlib
import signal
import struct
import subprocess

import genpy.dynamic
import rosbag
import rospy
from harness import LIDARD, LIDARD_SIM, expect, folder, free_port, process, ros_master, run, use_master_at, wait_for
from sensor_msgs.msg import PointCloud2

SCENE = """\
start: 2026-01-01T00:00:00Z
duration: 6
sensors:
  roof: {model: velodyne_vlp16, from: '192.168.1.201:2368', to: '192.168.1.77:2368'}
objects:
  - box: {center: [1.3, -0.7, 0.4], size: [17, 12, 6.5], reflectivity: 0.5}
"""
SENDER = "sensors: {roof: {model: velodyne_vlp16, clock: arrival, points_topic: direct, raw_topic: velodyne_packets}}\n"
READER = "sensors: {roof: {model: velodyne_vlp16, clock: arrival, packet_topic: velodyne_packets, points_topic: decoded}}\n"
# velodyne_msgs/VelodyneScan as ros-drivers/velodyne 1.7.0 has it.
MD5 = "50804fc9533a0e579e6322c04ae70566"


def packets_of(capture):
    """The UDP payloads of 1206 bytes of a pcap file, with the time of each in ns."""
    data = pathlib.Path(capture).read_bytes()
    magic = struct.unpack_from("<I", data)[0]
    unit = 1 if magic == 0xa1b23c4d else 1000
    at, packets = 24, []
    while at < len(data):
        seconds, fraction, length, _ = struct.unpack_from("<IIII", data, at)
        frame = data[at + 16:at + 16 + length]
        at += 16 + length
        if len(frame) == 42 + 1206:
            packets.append((seconds * 10**9 + fraction * unit, frame[42:]))
    return packets


def check_bag(path, captured):
    """The packets of a bag are some of the captured ones in their order, without gaps; returns how many."""
    with rosbag.Bag(str(path)) as bag:
        connection = [c for c in bag._get_connections() if c.topic == "/velodyne_packets"][0]
        expect(connection.datatype == "velodyne_msgs/VelodyneScan" and connection.md5sum == MD5, f"{connection.datatype}")
        made = genpy.dynamic.generate_dynamic(connection.datatype, connection.msg_def)["velodyne_msgs/VelodyneScan"]
        expect(made._md5sum == MD5, f"the definition in the bag has the MD5 {made._md5sum}")
        scans = [message for _, message, _ in bag.read_messages("/velodyne_packets")]
    packets = [(p.stamp.to_nsec(), bytes(p.data)) for scan in scans for p in scan.packets]
    expect(packets and packets[0] in captured, "the first packet was captured")
    begin = captured.index(packets[0])
    expect(packets == captured[begin:begin + len(packets)], "all packets from there on, with their times")
    for scan in scans:
        expect(scan.header.frame_id == "roof" and scan.header.stamp == scan.packets[0].stamp, "frame_stamp: first")
    return len(packets), [scan.header.seq for scan in scans]


def main():
    port = free_port()
    use_master_at(port)
    with folder() as tmp, ros_master(port):
        (tmp / "scene.yaml").write_text(SCENE)
        (tmp / "sender.yaml").write_text(SENDER)
        (tmp / "reader.yaml").write_text(READER)
        made = subprocess.run([LIDARD_SIM, "make", tmp / "scene.yaml", "-o", tmp / "drive"], capture_output=True, text=True, check=False)
        expect(made.returncode == 0, made.stderr)
        captured = packets_of(tmp / "drive.pcap")
        done = run("replay", "-c", tmp / "sender.yaml", "--pcap", tmp / "drive.pcap", "--bag", tmp / "written.bag")
        expect(done.returncode == 0, done.stderr)
        count, _ = check_bag(tmp / "written.bag", captured)
        expect(count == len(captured), f"the bag holds {count} of {len(captured)} packets")
        print(f"replay --bag: {count} packets")

        rospy.init_node("listener", disable_signals=True, anonymous=True)
        direct, decoded = [], []
        rospy.Subscriber("/direct", PointCloud2, direct.append, queue_size=1000, buff_size=1 << 24)
        rospy.Subscriber("/decoded", PointCloud2, decoded.append, queue_size=1000, buff_size=1 << 24)
        log = tmp / "log.txt"
        environment = {**os.environ, "LIDARD_SOCKET": str(tmp / "reader.socket")}
        record = ["/usr/lib/rosbag/record", "-O", str(tmp / "recorded.bag"), "/velodyne_packets"]
        with log.open("w") as sink, process([LIDARD, "run", "-c", tmp / "reader.yaml", "__name:=reader"], stdout=sink,
                                            stderr=subprocess.STDOUT, env=environment), \
                process(record, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as recorder:
            wait_for(lambda: "ROS master found" in log.read_text(), 20, "the reader starts:\n" + log.read_text())
            sent = run("replay", "-c", tmp / "sender.yaml", "--pcap", tmp / "drive.pcap", "--rate", "1", "--wait", "2")
            expect(sent.returncode == 0, sent.stderr)
            wait_for(lambda: len(decoded) > 45, 20, f"{len(direct)} direct and {len(decoded)} decoded clouds:\n" + log.read_text())
            recorder.send_signal(signal.SIGINT)
            expect(recorder.wait(20) == 0, "rosbag record ends well")
        count, numbers = check_bag(tmp / "recorded.bag", captured)
        expect(count > 0.8 * len(captured), f"recorded {count} of {len(captured)} packets")
        expect(numbers == list(range(numbers[0], numbers[0] + len(numbers))), f"roscpp numbers the messages: {numbers}")
        by_stamp = {cloud.header.stamp: cloud for cloud in direct}
        compared = [(cloud, by_stamp[cloud.header.stamp]) for cloud in decoded if cloud.header.stamp in by_stamp]
        expect(len(compared) > 40, f"{len(compared)} of {len(decoded)} decoded clouds have the stamp of one of {len(direct)} direct ones")
        for here, there in compared:
            expect(here.data == there.data and here.width == there.width, f"the cloud of {here.header.stamp} differs")
        print(f"{len(compared)} clouds of {len(decoded)} are the same; recorded {count} of {len(captured)} packets")
    print("ok")


if __name__ == "__main__":
    main()
