#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""urg_node and sick_safetyscanners_node with the parameters of the nodes they stand in for, on a real master: scans come on the
topics and in the frames of those nodes, and what has no effect is told."""
import os
import socket
import subprocess
import xmlrpc.client

import rospy
from harness import LIDARD, LIDARD_SIM, expect, folder, free_port, process, ros_master, use_master_at, wait_for
from sensor_msgs.msg import LaserScan

SCENE = """\
start: 2026-01-01T00:00:00Z
duration: 600
sensors:
  ust: {{model: hokuyo_ust_10lx, from: '192.168.0.10:{ust}', to: '127.0.0.1:40000'}}
  micro: {{model: sick_microscan3, from: '192.168.1.11:6060', to: '127.0.0.1:{micro}'}}
objects:
  - wall: {{from: [4, -3], to: [4, 3], z: [-1, 1]}}
"""


def start(tmp, port, executable, arguments, parameters, log):
    program = tmp / executable
    program.symlink_to(os.path.abspath(LIDARD))
    master = xmlrpc.client.ServerProxy(f"http://127.0.0.1:{port}")
    name = next(word[len("__name:="):] for word in arguments if word.startswith("__name:="))
    for key, value in parameters.items():
        expect(master.setParam("/test", f"/{name}/{key}", value)[0] == 1, "the master takes a parameter")
    return process([program, *arguments], stdout=log.open("w"), stderr=subprocess.STDOUT)


def main():
    ports = {"ust": free_port(), "micro": free_port(socket.SOCK_DGRAM), "master": free_port()}
    use_master_at(ports["master"])
    with folder() as tmp, ros_master(ports["master"]):
        (tmp / "scene.yaml").write_text(SCENE.format(**ports))
        rospy.init_node("listener", disable_signals=True, anonymous=True)
        urg, micro = [], []
        rospy.Subscriber("/scan", LaserScan, urg.append, queue_size=100)
        rospy.Subscriber("/left_scan", LaserScan, micro.append, queue_size=100)
        urg_log, micro_log = tmp / "urg.txt", tmp / "micro.txt"
        urg_parameters = {"ip_address": "127.168.0.10", "ip_port": ports["ust"], "frame_id": "nose", "angle_min": -1.5,
                          "angle_max": 1.5, "calibrate_time": False, "publish_intensity": True, "error_limit": 2,
                          "synchronize_time": True, "anglemin": 1}
        micro_parameters = {"sensor_ip": "127.168.1.11", "host_ip": "127.0.0.1", "host_udp_port": ports["micro"],
                            "frame_id": "left", "skip": 0, "angle_start": -1.0, "angle_end": 1.0}
        with process([LIDARD_SIM, "live", tmp / "scene.yaml"], stdout=subprocess.DEVNULL), \
                start(tmp, ports["master"], "urg_node", ["__name:=urg_node"], urg_parameters, urg_log) as first, \
                start(tmp, ports["master"], "sick_safetyscanners_node", ["__name:=left_scanner", "scan:=left_scan"],
                      micro_parameters, micro_log) as second:
            wait_for(lambda: len(urg) > 5 and len(micro) > 5, 40, "scans of both nodes come")
            for node in (first, second):
                node.terminate()
            expect([node.wait(5) for node in (first, second)] == [0, 0], "SIGTERM ends them with 0")
        told, also_told = urg_log.read_text(), micro_log.read_text()
    for scan, frame, limit in ((urg[-1], "nose", 1.5), (micro[-1], "left", 1.0)):
        expect(scan.header.frame_id == frame, f"frame {scan.header.frame_id}")
        expect(abs(scan.angle_min + limit) < 0.01 and abs(scan.angle_max - limit) < 0.01, f"{scan.angle_min}, {scan.angle_max}")
        ahead = scan.ranges[round(-scan.angle_min / scan.angle_increment)]
        expect(abs(ahead - 4) < 0.02, f"the wall stands {ahead} m ahead of {frame}")
        expect(len(scan.intensities) == len(scan.ranges), "intensities come with the ranges")
    for word in ("~synchronize_time (true) has no effect", "~error_limit (2)", "~anglemin is not known"):
        expect(word in told, f"'{word}' is not in\n{told}")
    expect(" info: parameter ~skip (0) has no effect" in also_told, also_told)


main()
