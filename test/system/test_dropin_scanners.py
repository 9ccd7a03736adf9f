#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""urg_node and sick_safetyscanners_node with the parameters of the nodes they stand in for, on a real master: scans come on the
topics and in the frames of those nodes, and what has no effect is told."""
import signal
import socket

import genpy.dynamic
import rospy
from harness import expect, expect_end, free_port, logged, named_program, sim, wait_for, write
from ros_tools import Listener, ros_test, set_parameters

SCENE = """\
start: 2026-01-01T00:00:00Z
duration: 600
sensors:
  ust: {{model: hokuyo_ust_10lx, from: '192.168.0.10:{ust}', to: '127.0.0.1:40000'}}
  micro: {{model: sick_microscan3, from: '192.168.1.11:6060', to: '127.0.0.1:{micro}', options: {{protective_field: 6.0}}}}
objects:
  - wall: {{from: [4, -3], to: [4, 0], z: [-1, 1]}}
  - wall: {{from: [4, 0], to: [4, 3], z: [-1, 1], reflectivity: 1.5}}
"""


def start(tmp, port, executable, name, parameters, *arguments):
    set_parameters(port, "/" + name, parameters)
    return logged([named_program(tmp, executable), f"__name:={name}", *arguments], tmp / f"{name}.txt")


def understood(message, kind, md5):
    """A message of a type that nobody here has, by the definition that its sender tells."""
    header = message._connection_header
    expect(header["type"] == kind and header["md5sum"] == md5, f"{header}")
    made = genpy.dynamic.generate_dynamic(kind, header["message_definition"])[kind]
    expect(made._md5sum == md5, f"the definition of {kind} has the MD5 {made._md5sum}")
    return made().deserialize(message._buff)


def check_typed(extended, paths):
    """What sick_safetyscanners publishes beside the scan; the MD5 are those of its .msg files."""
    scan = understood(extended, "sick_safetyscanners/ExtendedLaserScanMsg", "ebb40b28432208d7bfa749af849de1ab")
    beams = len(scan.laser_scan.ranges)
    expect(scan.laser_scan.header.frame_id == "left" and beams > 200, f"{scan.laser_scan.header}")
    expect([len(flags) for flags in (scan.reflektor_status, scan.reflektor_median, scan.intrusion)] == [beams] * 3, "a flag per beam")
    angles = [scan.laser_scan.angle_min + i * scan.laser_scan.angle_increment for i in range(beams)]
    expected = [0 < angle < 0.6435 for angle in angles]
    wrong = [angle for angle, seen, flag in zip(angles, expected, scan.reflektor_status) if seen != flag]
    expect(len(wrong) <= 2, f"the left half of the wall is a reflector, not so at {wrong}")
    expect(sum(scan.reflektor_median) == 1 and not any(scan.intrusion), f"{sum(scan.reflektor_median)} reflectors")
    expect(abs(angles[scan.reflektor_median.index(True)] - 0.32) < 0.02, "the middle of the reflector")
    told = understood(paths, "sick_safetyscanners/OutputPathsMsg", "10ce675a2a87077eb6fb8c168c348972")
    expect(len(told.status) == len(told.is_safe) == len(told.is_valid) == 20, f"{told}")
    expect(told.active_monitoring_case == 1, f"{told}")


def main():
    ports = {"ust": free_port(), "micro": free_port(socket.SOCK_DGRAM)}
    with ros_test() as (tmp, master):
        urg, micro = Listener("/scan").messages, Listener("/left_scan").messages
        extended, paths = (Listener(topic, rospy.AnyMsg).messages for topic in ("/extended_laser_scan", "/output_paths"))
        urg_parameters = {"ip_address": "127.168.0.10", "ip_port": ports["ust"], "frame_id": "nose", "angle_min": -1.5,
                          "angle_max": 1.5, "calibrate_time": False, "publish_intensity": True, "error_limit": 2,
                          "synchronize_time": True, "anglemin": 1}
        micro_parameters = {"sensor_ip": "127.168.1.11", "host_ip": "127.0.0.1", "host_udp_port": ports["micro"],
                            "frame_id": "left", "skip": 0, "angle_start": -1.0, "angle_end": 1.0}
        with sim(write(tmp / "scene.yaml", SCENE.format(**ports))), \
                start(tmp, master.port, "urg_node", "urg_node", urg_parameters) as first, \
                start(tmp, master.port, "sick_safetyscanners_node", "left_scanner", micro_parameters, "scan:=left_scan") as second:
            wait_for(lambda: len(urg) > 5 and len(micro) > 5 and len(extended) > 5 and len(paths) > 5, 40, "scans of both nodes come")
            for node in (first, second):
                expect_end(node, signal.SIGTERM, 5)
        told, also_told = first.said(), second.said()
    check_typed(extended[-1], paths[-1])
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
