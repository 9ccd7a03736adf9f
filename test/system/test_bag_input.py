#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Recorded scans, clouds and packets are replayed out of a bag: into another bag without a ROS master, or into ROS."""
import rosbag
from harness import ROOT, expect, run, wait_for, write
from ros_tools import Listener, ros_test

DEMO = ROOT / "config" / "demo.yaml"
CAPTURE = ROOT / "pcaps" / "demo.pcap"
VEHICLE = "vehicle: {footprint: [[-4.0, -1.0], [0.0, -1.0], [0.0, 1.0], [-4.0, 1.0]]}\n"
MERGE = VEHICLE + """sensors:
  left: {topic: /front_left/scan}
  right: {topic: front_right/scan}
merged_scans:
  again:
    laserscan_topics: [left, right]
    beams: 1440
    range_min: 0.1
    range_max: 40
    also: {again_strict: strict, again_safety: safety}
"""


def scans(bag, topic):
    with rosbag.Bag(str(bag)) as messages:
        return {m.header.stamp: [repr(r) for r in m.ranges] for _, m, _ in messages.read_messages([topic])}


def replay(tmp, name, config, source, *more):
    out = tmp / f"{name}.bag"
    config = write(tmp / f"{name}.yaml", config)
    return run("replay", "-c", config, "--pcap", source, "--rate", "max", "--bag", out, *more), out


def merges_what_was_recorded(tmp, demo):
    """The same merged scans as from the packets; the poses come from the bag's tf."""
    result, out = replay(tmp, "again", MERGE, demo)
    expect(result.returncode == 0, result.stderr)
    for ours, theirs in (("again_strict", "/scan_strict"), ("again_safety", "/scan_safety")):
        before, again = scans(demo, theirs), scans(out, "/" + ours)
        both = before.keys() & again.keys()
        expect(len(both) >= 0.9 * len(before), f"{ours}: {len(both)} of {len(before)} instants")
        differ = sum(a != b for stamp in both for a, b in zip(before[stamp], again[stamp]))
        expect(differ <= 0.001 * 1440 * len(both), f"{ours}: {differ} beams differ")
        print(f"{ours}: {len(both)} scans, {differ} beams differ")


def decodes_packets(tmp, demo):
    """Packets of a Velodyne that its driver recorded make the clouds of the capture."""
    config = "sensors:\n  roof: {model: velodyne_vlp16, ip_address: 192.168.1.201, raw_topic: velodyne_packets}\n"
    result, raw = replay(tmp, "raw", config, CAPTURE)
    expect(result.returncode == 0, result.stderr)
    result, out = replay(tmp, "decoded", "sensors:\n  roof: {model: velodyne_vlp16, packet_topic: /velodyne_packets}\n", raw)
    expect(result.returncode == 0, result.stderr)
    widths = []
    for bag in (raw, out):
        with rosbag.Bag(str(bag)) as messages:
            widths.append([m.width for _, m, _ in messages.read_messages(["/roof/points"])])
    expect(widths[0] and widths[0][:-1] == widths[1][:len(widths[0]) - 1], f"{widths}")


def refuses(tmp, demo):
    result, _ = replay(tmp, "missing", MERGE.replace("/front_left/scan", "/nothing"), demo)
    expect(result.returncode == 1 and "no message on /nothing, the topic of sensor left" in result.stderr
           and "/front_left/scan (sensor_msgs/LaserScan" in result.stderr, result.stderr)
    result, _ = replay(tmp, "none", DEMO.read_text(), demo)
    expect(result.returncode == 1 and "no sensor of the configuration has a topic" in result.stderr, result.stderr)
    result, _ = replay(tmp, "late", MERGE, demo, "--start", "9")
    expect(result.returncode == 1 and "--start 9: the bag ends before" in result.stderr, result.stderr)
    result = run("replay", "-c", write(tmp / "looped.yaml", MERGE), "--pcap", demo, "--loop")
    expect(result.returncode == 1 and "--loop" in result.stderr, result.stderr)
    result = run("replay", "-c", DEMO, "--pcap", CAPTURE, "--loop", "--motion", tmp / "none.csv")
    expect(result.returncode == 1 and "none.csv: cannot be opened" in result.stderr, result.stderr)
    half = tmp / "half.bag"
    half.write_bytes(demo.read_bytes()[:1_000_000])
    result, _ = replay(tmp, "cut", MERGE, half)
    expect(result.returncode == 1 and "half.bag: " in result.stderr, result.stderr)
    expect("rosbag reindex" in result.stderr, result.stderr)
    other = write(tmp / "bag.pcap", "#ROSBAG V2.0\n" + 200 * "x")
    result = run("inspect", other)
    expect(result.returncode == 1 and "is a bag" in result.stderr, result.stderr)
    bad = tmp / "bad.bag"
    with rosbag.Bag(str(bad), "w") as messages, rosbag.Bag(str(demo)) as source:
        for topic, message, time in source.read_messages(["/front_left/scan", "/front_right/scan", "/tf_static"]):
            if topic == "/front_left/scan":
                message.angle_increment = float("nan")
            messages.write(topic, message, time)
    result, _ = replay(tmp, "bad_out", MERGE, bad)
    expect("of no use" in result.stdout, result.stdout + result.stderr)


def plays_a_damaged_bag_up_to_its_damage(tmp, demo):
    broken = tmp / "broken.bag"
    with rosbag.Bag(str(broken), "w") as messages, rosbag.Bag(str(demo)) as source:
        for topic, message, time in source.read_messages(["/front_left/scan", "/front_right/scan", "/tf_static"]):
            messages.write(topic, message, time)
    whole = broken.read_bytes()
    middle = len(whole) // 2
    broken.write_bytes(whole[:middle] + bytes(20_000) + whole[middle + 20_000:])
    result, out = replay(tmp, "broken_out", MERGE, broken)
    expect(result.returncode == 1 and "broken.bag: " in result.stderr and "up to there were played" in result.stderr, result.stderr)
    before, again = scans(demo, "/scan_strict"), scans(out, "/again_strict")
    expect(0.2 * len(before) < len(again) < 0.8 * len(before), f"{len(again)} of {len(before)} scans")
    expect("again_strict" in result.stdout, result.stdout)


def plays_into_ros(tmp, demo):
    """Nobody publishes tf: the poses are the bag's."""
    merged = Listener("/again_strict")
    result = run("replay", "-c", write(tmp / "ros.yaml", MERGE), "--pcap", demo, "--rate", "max", "--wait", "2")
    expect(result.returncode == 0, result.stderr)
    recorded = scans(demo, "/scan_strict")
    wait_for(lambda: len(merged.messages) >= 0.9 * len(recorded), 10, f"{len(merged.messages)} scans")
    same = [m for m in list(merged.messages) if recorded.get(m.header.stamp) == [repr(r) for r in m.ranges]]
    expect(len(same) >= 0.9 * len(recorded), f"{len(same)} of {len(recorded)} are as recorded")


def inspects(tmp, demo):
    result = run("inspect", demo)
    expect(result.returncode == 0 and "front_left_scan: {topic: /front_left/scan}" in result.stdout, result.stdout)
    expect("# /tf_static" in result.stdout, result.stdout)
    # What it prints is a configuration.
    result, _ = replay(tmp, "inspected", result.stdout, demo)
    expect(result.returncode == 0, result.stderr)


def main():
    with ros_test() as (tmp, _):
        demo = tmp / "demo.bag"
        result = run("replay", "-c", DEMO, "--pcap", CAPTURE, "--rate", "max", "--bag", demo)
        expect(result.returncode == 0, result.stderr)
        for check in (merges_what_was_recorded, decodes_packets, refuses, plays_a_damaged_bag_up_to_its_damage, plays_into_ros, inspects):
            check(tmp, demo)
    print("ok")


if __name__ == "__main__":
    main()
