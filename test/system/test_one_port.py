#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Two safety scanners, two picoScans and a multiScan, whose datagrams are large, send to one UDP port; each is known by its
sender, and a sixth that nobody configured is named on /diagnostics."""
from harness import daemon, expect, free_port, sim, wait_for, write
from ros_tools import Diagnostics, Listener, ros_test
from sensor_msgs.msg import LaserScan, PointCloud2

SCENE = """\
start: 2026-01-01T00:00:00Z
duration: 60
sensors:
  left: {{model: sick_microscan3, from: '192.168.0.21:6060', to: '127.0.0.1:{port}', options: {{serial: 21}}}}
  right: {{model: sick_microscan3, from: '192.168.0.22:6060', to: '127.0.0.1:{port}', phase_ms: 11, options: {{serial: 22}}}}
  front: {{model: sick_picoscan150, from: '192.168.0.31:2115', to: '127.0.0.1:{port}', options: {{serial: 31, resolution_deg: 1}}}}
  back: {{model: sick_picoscan150, from: '192.168.0.32:2115', to: '127.0.0.1:{port}', phase_ms: 7,
    options: {{serial: 32, resolution_deg: 1}}}}
  dome: {{model: sick_multiscan136, from: '192.168.0.33:2115', to: '127.0.0.1:{port}', options: {{serial: 33}}}}
  stranger: {{model: sick_microscan3, from: '192.168.0.99:6060', to: '127.0.0.1:{port}', options: {{serial: 99}}}}
objects:
  - wall: {{from: [4, -3], to: [4, 3], z: [-1, 1]}}
"""
CONFIG = """\
sensors:
  left: {{model: sick_microscan3, ip_address: 127.168.0.21, ip_port: {port}}}
  right: {{model: sick_microscan3, ip_address: 127.168.0.22, ip_port: {port}}}
  front: {{model: sick_picoscan150, ip_address: 127.168.0.31, ip_port: {port}, listen_only: true}}
  back: {{model: sick_picoscan150, ip_address: 127.168.0.32, ip_port: {port}, listen_only: true}}
  dome: {{model: sick_multiscan136, ip_address: 127.168.0.33, ip_port: {port}, listen_only: true}}
"""
SERIALS = {"left": "21", "right": "22", "front": "31", "back": "32", "dome": "33"}
TOPICS = {name: f"/{name}/points" if name == "dome" else f"/{name}/scan" for name in SERIALS}


def check_items(items):
    """The newest status of each name: every sensor is itself, loses nothing, and the stranger is named."""
    for name, serial in SERIALS.items():
        item = items[f"sensor {name}"]
        values = {pair.key: pair.value for pair in item.values}
        expect(item.hardware_id == serial, f"{name} has serial {item.hardware_id}, not {serial}")
        expect(values["Lost packets"] == "0" and values["Incomplete telegrams"] == "0", f"{name}: {values}")
        expect(values["Rejected"] in ("0", "none", ""), f"{name}: rejected {values['Rejected']}")
    text = "\n".join(f"{item.name} {item.message} {[(v.key, v.value) for v in item.values]}" for item in items.values())
    expect("127.168.0.99" in text, f"the stranger is not named in\n{text}")


def live(tmp):
    port = free_port()
    scene = write(tmp / "live_scene.yaml", SCENE.format(port=port))
    got = {name: Listener(TOPICS[name], PointCloud2 if name == "dome" else LaserScan) for name in SERIALS}
    items = Diagnostics().items
    with daemon(write(tmp / "live.yaml", CONFIG.format(port=port))):
        wait_for(lambda: "sensor left" in items, 20, "diagnostics")
        with sim(scene):
            wait_for(lambda: all(len(one.messages) > 60 for one in got.values()), 30, "frames of all five")
            wait_for(lambda: items["sensor left"].hardware_id == "21", 5, "a status with the serial number")
            # The kernel drops most of a stranger's packets unseen; a few of them are enough.
            wait_for(lambda: any("127.168.0.99" in item.message + str(item.values) for item in list(items.values())), 30,
                     "a status that names the stranger")
            check_items(items)
    expect(all(cloud.width * cloud.height > 100 for cloud in got.pop("dome").messages), "clouds have points")
    for name, one in got.items():
        expect(len({len(scan.ranges) for scan in one.messages}) == 1, f"{name}: the number of beams changes")


def main():
    with ros_test() as (tmp, _):
        live(tmp)
    print("ok")


if __name__ == "__main__":
    main()
