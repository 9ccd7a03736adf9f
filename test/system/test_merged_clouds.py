#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The recipe of a truck with two roof lidars: a merged cloud with every return of both, and a virtual scan without the shadow of
the mast, which each lidar alone has. Live: a merged cloud with a planar scanner, which merged scans get too, is built for its
subscriber alone."""
import collections
import re
import socket
import struct
import subprocess

import rosbag
import rospy
from harness import (LIDARD_SIM, ROOT, ask, daemon, expect, free_port, item, kernel_port_is_open, make_capture, process, run, wait_for, well,
                     write)
from ros_tools import ros_test
from sensor_msgs.msg import PointCloud2

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


FRONT = "  front: {{model: sick_microscan3, pose: {{xyz: [1.5, 0, 0.4]}}, from: '192.168.0.21:6060', to: '192.168.0.100:{}'}}\n"
LIVE = """\
sensors:
  roof: {{model: velodyne_vlp16, ip_address: 127.168.1.201, ip_port: {roof}, pose: {{xyz: [0.5, 1.0, 2.8]}}}}
  roof_rear: {{model: velodyne_vlp16, ip_address: 127.168.1.202, ip_port: {roof_rear}, pose: {{xyz: [-0.5, -1.0, 2.8]}}}}
  front: {{model: sick_microscan3, ip_address: 127.168.0.21, ip_port: {front}, listen_only: true, pose: {{xyz: [1.5, 0, 0.4]}}}}
merged_scans:
  planes: {{laserscan_topics: [front]}}
merged_clouds:
  around: {{sources: [roof, roof_rear, front], lost_after: 2}}
"""


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
        sensors = sensors_in(cloud)
        expect(set(sensors) == {0, 1}, f"{sensors}")
        expect(sensors[0] in sizes["/roof/points"] and sensors[1] in sizes["/roof_rear/points"], f"{sensors} of {sizes}")


def sensors_in(cloud):
    return collections.Counter(struct.unpack_from("<H", cloud.data, at + 22)[0] for at in range(0, len(cloud.data), 24))


def live(tmp):
    ports = {name: free_port(socket.SOCK_DGRAM) for name in ("roof", "roof_rear", "front")}
    scene = SCENE.replace("objects:", FRONT.format(ports["front"]) + "objects:")
    for host, name in ((201, "roof"), (202, "roof_rear")):
        scene = scene.replace(f"from: '192.168.1.{host}:2368', to: '255.255.255.255:2368'", f"from: '192.168.1.{host}:2368', to: '192.168.0.100:{ports[name]}'")
    capture = make_capture(tmp / "live", scene)
    with daemon(write(tmp / "live.yaml", LIVE.format(**ports))):
        wait_for(lambda: all(kernel_port_is_open(port) for port in ports.values()), 30, "the daemon listens")
        with process([LIDARD_SIM, "send", "--to", "127.0.0.1", "--repeat", 120, capture], stdout=subprocess.DEVNULL):
            well("merged cloud around", "merged planes")
            wait_for(lambda: item("merged cloud around")["message"].startswith("not built: nobody subscribes"), 10, "nobody subscribes")
            clouds = []
            rospy.Subscriber("/around", PointCloud2, clouds.append, buff_size=1 << 24)
            wait_for(lambda: len(clouds) >= 5, 10, "merged clouds come")
            wait_for(lambda: any(set(sensors_in(cloud)) == {0, 1, 2} for cloud in clouds[-5:]), 10, "one with returns of all three")
            topics = {topic["topic"]: topic for topic in ask("status")["topics"]}
            expect(topics["planes"]["frames"] > 20, f"the scanner is merged with others too: {topics['planes']}")
            print(f"live: {len(clouds)} merged clouds, latency p50 {topics['around']['latency_ms']['p50']:.1f} ms")


def free_beams(messages):
    """Indices of the beams that are free in all virtual scans but the first."""
    scans = messages["/hood"][1:]
    expect(len(scans) >= 7, f"{len(scans)} virtual scans")
    return set.intersection(*({i for i, r in enumerate(scan.ranges) if r == float("inf")} for scan in scans))


def main():
    with ros_test() as (tmp, _):
        make_capture(tmp / "truck", SCENE)
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
        live(tmp)
    print("ok")


if __name__ == "__main__":
    main()
