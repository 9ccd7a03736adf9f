#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Two safety scanners, two picoScans and a multiScan, whose datagrams are large, send to one UDP port; each is told by its
sender, and a sixth that nobody configured is named on /diagnostics. The same live and in replay."""
import subprocess

import rosbag
from harness import LIDARD, LIDARD_SIM, expect, folder, free_port, process, ros_master, run, use_master_at, wait_for

SCENE = """\
start: 2026-01-01T00:00:00Z
duration: {duration}
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
  left: {{model: sick_microscan3, ip_address: {net}.168.0.21, ip_port: {port}}}
  right: {{model: sick_microscan3, ip_address: {net}.168.0.22, ip_port: {port}}}
  front: {{model: sick_picoscan150, ip_address: {net}.168.0.31, ip_port: {port}, listen_only: true}}
  back: {{model: sick_picoscan150, ip_address: {net}.168.0.32, ip_port: {port}, listen_only: true}}
  dome: {{model: sick_multiscan136, ip_address: {net}.168.0.33, ip_port: {port}, listen_only: true}}
"""
SERIALS = {"left": "21", "right": "22", "front": "31", "back": "32", "dome": "33"}
PERIODS = {"left": 0.03, "right": 0.03, "front": 0.05, "back": 0.05, "dome": 0.05}
TOPICS = {name: f"/{name}/points" if name == "dome" else f"/{name}/scan" for name in SERIALS}


def check_items(items, net):
    """The newest status of each name: every sensor is itself, loses nothing, and the stranger is named."""
    for name, serial in SERIALS.items():
        item = items[f"sensor {name}"]
        values = {pair.key: pair.value for pair in item.values}
        expect(item.hardware_id == serial, f"{name} has serial {item.hardware_id}, not {serial}")
        expect(values["Lost packets"] == "0" and values["Incomplete telegrams"] == "0", f"{name}: {values}")
        expect(values["Rejected"] in ("0", "none", ""), f"{name}: rejected {values['Rejected']}")
    text = "\n".join(f"{item.name} {item.message} {[(v.key, v.value) for v in item.values]}" for item in items.values())
    expect(f"{net}.168.0.99" in text, f"the stranger is not named in\n{text}")


def replay(tmp):
    (tmp / "scene.yaml").write_text(SCENE.format(port=6060, duration=2))
    (tmp / "replay.yaml").write_text(CONFIG.format(port=6060, net=192))
    subprocess.run([LIDARD_SIM, "make", tmp / "scene.yaml", "-o", tmp / "four", "--no-truth"], check=True, stdout=subprocess.DEVNULL)
    done = run("replay", "-c", tmp / "replay.yaml", "--pcap", tmp / "four.pcap", "--rate", "max", "--bag", tmp / "four.bag")
    expect(done.returncode == 0, done.stderr)
    counts, items = {}, {}
    with rosbag.Bag(str(tmp / "four.bag")) as bag:
        for topic, message, _ in bag.read_messages():
            counts[topic] = counts.get(topic, 0) + 1
            if topic == "/diagnostics":
                items.update((status.name.split(": ")[-1], status) for status in message.status)
    for name, period in PERIODS.items():
        expected = 2 / period
        expect(abs(counts.get(TOPICS[name], 0) - expected) <= 2, f"{counts.get(TOPICS[name])} frames of {name}")
    check_items(items, 192)


def live(tmp):
    import rospy
    from diagnostic_msgs.msg import DiagnosticArray
    from sensor_msgs.msg import LaserScan, PointCloud2

    master, port = free_port(), free_port()
    use_master_at(master)
    (tmp / "live_scene.yaml").write_text(SCENE.format(port=port, duration=60))
    (tmp / "live.yaml").write_text(CONFIG.format(port=port, net=127))
    with ros_master(master):
        rospy.init_node("listener", disable_signals=True, anonymous=True)
        got, items = {name: [] for name in SERIALS}, {}
        for name, scans in got.items():
            rospy.Subscriber(TOPICS[name], PointCloud2 if name == "dome" else LaserScan, scans.append, queue_size=1000)
        rospy.Subscriber("/diagnostics", DiagnosticArray,
                         lambda array: items.update((status.name.split(": ")[-1], status) for status in array.status), queue_size=100)
        with process([LIDARD, "run", "-c", tmp / "live.yaml"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL):
            wait_for(lambda: "sensor left" in items, 20, "diagnostics")
            with process([LIDARD_SIM, "live", tmp / "live_scene.yaml"], stdout=subprocess.DEVNULL):
                wait_for(lambda: all(len(scans) > 60 for scans in got.values()), 30, "frames of all five")
                wait_for(lambda: items["sensor left"].hardware_id == "21", 5, "a status with the serial number")
                # The kernel drops most of a stranger's packets unseen; a few of them are enough.
                wait_for(lambda: any("127.168.0.99" in item.message + str(item.values) for item in list(items.values())), 30,
                         "a status that names the stranger")
                check_items(items, 127)
    expect(all(cloud.width * cloud.height > 100 for cloud in got.pop("dome")), "clouds have points")
    for name, scans in got.items():
        expect({len(scan.ranges) for scan in scans} == {len(scans[0].ranges)}, f"{name}: the number of beams changes")


def main():
    with folder() as tmp:
        replay(tmp)
        live(tmp)
    print("ok")


if __name__ == "__main__":
    main()
