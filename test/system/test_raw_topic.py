#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""raw_topic on a real master: `rosbag record` keeps it, and whoever has no velodyne_msgs reads the bag by the definition in it.
`replay --bag` writes the same packets."""
import signal
import subprocess

import genpy.dynamic
import rosbag
import rosgraph
from harness import PAYLOAD, expect, expect_end, make_capture, process, records, run, scene_of, stamp_ns, wait_for, write
from ros_tools import ros_test

SCENE = scene_of({"roof": "model: velodyne_vlp16, from: '192.168.1.201:2368', to: '192.168.1.77:2368'"},
                 "box: {center: [1.3, -0.7, 0.4], size: [17, 12, 6.5], reflectivity: 0.5}", seconds=6)
SENDER = "sensors: {roof: {model: velodyne_vlp16, clock: arrival, raw_topic: velodyne_packets}}\n"
# velodyne_msgs/VelodyneScan as ros-drivers/velodyne 1.7.0 has it.
MD5 = "50804fc9533a0e579e6322c04ae70566"


def packets_of(capture):
    """The UDP payloads of 1206 bytes of a pcap file, with the time of each in ns."""
    return [(stamp_ns(record), record[PAYLOAD:]) for record in records(capture.read_bytes()) if len(record) == PAYLOAD + 1206]


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


def check_replay(tmp, sender, capture, captured):
    done = run("replay", "-c", sender, "--pcap", capture, "--bag", tmp / "written.bag")
    expect(done.returncode == 0, done.stderr)
    count, _ = check_bag(tmp / "written.bag", captured)
    expect(count == len(captured), f"the bag holds {count} of {len(captured)} packets")
    print(f"replay --bag: {count} packets")


def check_recorded(bag, captured):
    count, numbers = check_bag(bag, captured)
    expect(count > 0.8 * len(captured), f"recorded {count} of {len(captured)} packets")
    expect(numbers == list(range(numbers[0], numbers[0] + len(numbers))), f"roscpp numbers the messages: {numbers}")
    print(f"recorded {count} of {len(captured)} packets")


def main():
    with ros_test() as (tmp, _):
        sender, capture = write(tmp / "sender.yaml", SENDER), make_capture(tmp / "drive", SCENE)
        captured = packets_of(capture)
        check_replay(tmp, sender, capture, captured)
        record = ["/usr/lib/rosbag/record", "-O", tmp / "recorded.bag", "/velodyne_packets"]
        with process(record, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as recorder:
            wait_for(lambda: "/velodyne_packets" in dict(rosgraph.Master("/test").getSystemState()[1]), 20, "the recorder subscribes")
            sent = run("replay", "-c", sender, "--pcap", capture, "--rate", "1", "--wait", "2")
            expect(sent.returncode == 0, sent.stderr)
            expect_end(recorder, signal.SIGINT)
        check_recorded(tmp / "recorded.bag", captured)
    print("ok")


if __name__ == "__main__":
    main()
