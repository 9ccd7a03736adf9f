#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The recipe of a truck with two roof lidars: a merged cloud with every return of both, and a virtual scan without the shadow of
the mast, which each lidar alone has."""
import collections
import re
import struct

import rosbag
from harness import LIDARD_SIM, ROOT, expect, folder, run, write
import subprocess

MAST = "    - cylinder: {center: [0, 0, 1.7], radius: 0.15, height: 3.4}\n"
SCENE = """\
start: 2026-01-01T00:17:23Z
duration: 1.0
ground: {z: 0}
vehicle:
  start: {xy: [-12, 0], yaw_deg: 0}
  path: [{duration: 1.0, speed: 0, yaw_rate_deg: 0}]
  body:
MAST_HERE
sensors:
  roof: {model: velodyne_vlp16, pose: {xyz: [0.5, 1.0, 2.8], rpy_deg: [0, 5, 0]}, from: '192.168.1.201:2368', to: '255.255.255.255:2368'}
  roof_rear: {model: velodyne_vlp16, pose: {xyz: [-0.5, -1.0, 2.8], rpy_deg: [0, 5, 180]}, from: '192.168.1.202:2368', to: '255.255.255.255:2368', phase_ms: 13}
objects:
  - wall: {from: [-60, -40], to: [60, -40], z: [0, 6]}
  - wall: {from: [60, -40], to: [60, 40], z: [0, 6]}
  - wall: {from: [60, 40], to: [-60, 40], z: [0, 6]}
  - wall: {from: [-60, 40], to: [-60, -40], z: [0, 6]}
  - box: {center: [-2, 6, 1.75], size: [2, 2, 3.5], reflectivity: 0.5}
""".replace("MAST_HERE\n", MAST)


def recipe():
    page = (ROOT / "config/doc/recipes.md").read_text()
    return re.search(r"## Truck with two roof lidars.*?```yaml\n(.*?)```", page, re.S)[1]


def replayed(tmp, name, config):
    bag = tmp / f"{name}.bag"
    result = run("replay", "-c", write(tmp / f"{name}.yaml", config), tmp / "truck.pcap", "--rate", "max", "--bag", bag)
    expect(result.returncode == 0, f"{name}: {result.stdout}{result.stderr}")
    messages = collections.defaultdict(list)
    with rosbag.Bag(str(bag)) as content:
        for topic, message, _ in content.read_messages():
            messages[topic].append(message)
    return messages


def check_clouds(messages):
    merged = messages["/around"]
    expect(len(merged) >= 8, f"{len(merged)} merged clouds")
    fields = [(f.name, f.offset, f.datatype) for f in merged[0].fields]
    expect(fields == [("x", 0, 7), ("y", 4, 7), ("z", 8, 7), ("intensity", 12, 7), ("ring", 16, 4), ("time", 18, 7), ("sensor", 22, 4)],
           f"{fields}")
    # Each merged cloud holds a whole revolution of each lidar.
    sizes = {topic: {m.width * m.height for m in messages[topic]} for topic in ("/roof/points", "/roof_rear/points")}
    for cloud in merged:
        expect(cloud.header.frame_id == "base_link" and cloud.point_step == 24, cloud.header)
        sensors = collections.Counter(struct.unpack_from("<H", cloud.data, at + 22)[0] for at in range(0, len(cloud.data), 24))
        expect(set(sensors) == {0, 1}, f"{sensors}")
        expect(sensors[0] in sizes["/roof/points"] and sensors[1] in sizes["/roof_rear/points"], f"{sensors} of {sizes}")


def free_beams(messages):
    """Indices of the beams that are free in all virtual scans but the first."""
    scans = messages["/hood"][1:]
    expect(len(scans) >= 7, f"{len(scans)} virtual scans")
    return set.intersection(*({i for i, r in enumerate(scan.ranges) if r == float("inf")} for scan in scans))


def main():
    with folder() as tmp:
        write(tmp / "truck.scene.yaml", SCENE)
        made = subprocess.run([LIDARD_SIM, "make", tmp / "truck.scene.yaml", "-o", tmp / "truck", "--no-truth"], check=False,
                              capture_output=True, text=True)
        expect(made.returncode == 0, made.stderr)
        config = recipe()
        check = run("check", write(tmp / "check.yaml", config))
        expect(check.returncode == 0 and not check.stderr, check.stderr)
        both = replayed(tmp, "both", config)
        check_clouds(both)
        free = free_beams(both)
        alone = {name: free_beams(replayed(tmp, name, config.replace("sources: [roof, roof_rear]", f"sources: [{name}]")))
                 for name in ("roof", "roof_rear")}
        print(f"free beams of 1440: {len(free)} of both, " + ", ".join(f"{len(beams)} of {name}" for name, beams in alone.items()))
        for name, beams in alone.items():
            expect(beams <= free, f"{name} alone proves {len(beams - free)} beams free that both do not")
            expect(len(beams) < len(free) - 30, f"the mast hides nothing from {name}")
        picture = tmp / "picture.svg"
        drawn = run("snapshot", "-c", tmp / "both.yaml", "--pcap", tmp / "truck.pcap", "-o", picture)
        expect(drawn.returncode == 0 and "merged cloud" in picture.read_text(), drawn.stderr)
    print("ok")


if __name__ == "__main__":
    main()
