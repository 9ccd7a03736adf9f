#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""replay --bag: the same bytes each time; every example configuration gives scans that every consumer accepts."""
import hashlib
import math
import re

import rosbag
from harness import ROOT, expect, folder, run

# Each example and the capture it is shown on.
EXAMPLES = {
    "demo.yaml": "demo.pcap",
    "velodyne_vlp16.yaml": "vlp16_dual.pcap",
    "sick_microscan3.yaml": "demo.pcap",
    "hokuyo_ust_10lx.yaml": "hokuyo_ust_10lx.pcap",
    "sick_lms1xx.yaml": "sick_lms111.pcap",
    "sick_picoscan150.yaml": "picoscan150.pcap",
    "two_safety_scanners.yaml": "demo.pcap",
    "truck.yaml": "demo.pcap",
}
# Two of its sensors are topics of other nodes, which no capture has: an output never comes, exit 1.
WITH_TOPICS = ("truck.yaml",)


def karto_count(scan):
    """The number of readings slam_toolbox (noetic) expects: laser_utils.cpp and Karto.h."""
    span = scan.angle_max - scan.angle_min
    full = abs(span - 2 * math.pi) < scan.angle_increment - 1e-7 * 2 * math.pi
    return round(span / scan.angle_increment) + (0 if full else 1)


def check_scan(topic, scan, counts):
    expect(len(scan.ranges) == karto_count(scan), f"{topic}: {len(scan.ranges)} beams, Karto expects {karto_count(scan)}")
    expect(counts.setdefault(topic, len(scan.ranges)) == len(scan.ranges), f"{topic}: the number of beams changed")
    expect(len(scan.intensities) in (0, len(scan.ranges)), f"{topic}: intensities")
    expect(not scan.header.frame_id.startswith("/"), f"{topic}: frame_id")
    expect(0 <= scan.range_min < scan.range_max, f"{topic}: range limits")
    for r in scan.ranges:
        expect(not math.isfinite(r) or scan.range_min <= r <= scan.range_max, f"{topic}: range {r}")


def check_example(config, capture, tmp):
    digests = set()
    for n in (1, 2):
        bag = tmp / f"{config}.{n}.bag"
        result = run("replay", "-c", ROOT / "config" / config, "--pcap", ROOT / "pcaps" / capture, "--rate", "max", "--bag", bag)
        expect(result.returncode == (1 if config in WITH_TOPICS else 0), f"{config}: {result.stderr}")
        digests.add(hashlib.sha256(bag.read_bytes()).hexdigest())
    expect(len(digests) == 1, f"{config}: two replays gave different bags")
    counts, stamps = {}, {}
    with rosbag.Bag(str(bag)) as messages:
        for topic, message, _ in messages.read_messages():
            if message._type == "sensor_msgs/LaserScan":
                check_scan(topic, message, counts)
            if message._type in ("sensor_msgs/LaserScan", "sensor_msgs/PointCloud2"):
                stamp = message.header.stamp.to_nsec()
                expect(stamp > stamps.get(topic, 0), f"{config} {topic}: stamps do not increase")
                stamps[topic] = stamp
    expect(stamps, f"{config}: the bag is empty")
    return stamps


def blind_zone_recipe(tmp):
    """A bumper below a roof lidar is never free in its own virtual scan, and is in the merged scan of the manual's recipe."""
    page = (ROOT / "config/doc/recipes.md").read_text()
    recipe = re.search(r"## Roof lidar and planar scanners.*?```yaml\n(.*?)```", page, re.S)[1]
    (tmp / "recipe.yaml").write_text(recipe)
    bag = tmp / "recipe.bag"
    check = run("check", tmp / "recipe.yaml")
    expect(check.returncode == 0 and not check.stderr, check.stderr)
    result = run("replay", "-c", tmp / "recipe.yaml", ROOT / "pcaps/demo.pcap", "--rate", "max", "--bag", bag)
    expect(result.returncode == 0, result.stderr)
    free, beams = {}, {}
    with rosbag.Bag(str(bag)) as messages:
        for topic, scan, _ in messages.read_messages(topics=["/bumper", "/obstacles"]):
            free[topic] = free.get(topic, 0) + sum(r == math.inf for r in scan.ranges)
            beams[topic] = beams.get(topic, 0) + len(scan.ranges)
    print(f"free beams: {free} of {beams}")
    expect(free["/bumper"] == 0, "the lidar is blind there")
    expect(free["/obstacles"] > 0.1 * beams["/obstacles"], "the scanners see free ways")


def main():
    examples = {p.name for p in (ROOT / "config").glob("*.yaml")}
    expect(examples == set(EXAMPLES), f"examples {examples} and the list here differ")
    with folder() as tmp:
        for config, capture in EXAMPLES.items():
            topics = check_example(config, capture, tmp)
            if config == "demo.yaml":
                expect({"/scan_multi", "/merged_cloud", "/bumper", "/chest", "/roof/points"} <= set(topics), f"{topics}")
        blind_zone_recipe(tmp)
        part = tmp / "part.bag"
        run("replay", "-c", ROOT / "config/demo.yaml", "--pcap", ROOT / "pcaps/demo.pcap", "--rate", "max", "--start", "0.5",
            "--duration", "1.0", "--bag", part)
        with rosbag.Bag(str(part)) as bag:
            length = bag.get_end_time() - bag.get_start_time()
        expect(0.9 < length < 1.0, f"--start 0.5 --duration 1.0 gave {length} s")
    print("ok")


if __name__ == "__main__":
    main()
