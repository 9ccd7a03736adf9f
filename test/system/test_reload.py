#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""SIGHUP puts a changed configuration in force: sensors, outputs and subscribers that it does not concern lose nothing, what is
new comes, what is gone goes. A wrong file changes nothing and is told with its line; a start with a wrong file takes the last
configuration that was good, where a service manager gives a folder to keep it in."""
import collections
import contextlib
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import time

import rosgraph
import rospy
from harness import (LIDARD, LIDARD_SIM, expect, folder, free_port, kernel_port_is_open, process, ros_master, run,
                     use_master_at, wait_for)
from sensor_msgs.msg import LaserScan, PointCloud2
from tf2_msgs.msg import TFMessage

SCENE = """start: 2026-01-01T00:00:00Z
duration: 300
objects:
  - wall: {{from: [4, -30], to: [4, 30], z: [-5, 5]}}
sensors:
  left: {{model: sick_microscan3, from: '192.168.0.21:6060', to: '127.0.0.1:{scanners}'}}
  right: {{model: sick_microscan3, from: '192.168.0.22:6060', to: '127.0.0.1:{scanners}'}}
  roof: {{model: velodyne_vlp16, from: '192.168.1.201:2368', to: '127.0.0.1:{roof}'}}
"""
LEFT = "  left: {{model: sick_microscan3, ip_address: 127.168.0.21, ip_port: {scanners}, listen_only: true, pose: {{xyz: [1, 1, 0.3]}}}}\n"
RIGHT = "  right: {{model: sick_microscan3, ip_address: 127.168.0.22, ip_port: {scanners}, listen_only: true, pose: {{xyz: [1, -1, 0.3]}}}}\n"
ROOF = "  roof: {{model: velodyne_vlp16, ip_address: 127.168.1.201, ip_port: {roof}, pose: {{xyz: [0, 0, 2]}}}}\n"
VIRTUAL = "virtual_scans:\n  levels: {{cloud_topic: roof, virtual_laser_scan: [low{more}], poses: {{low: {{xyz: [0, 0, 0.4]}}{pose}}}, beams: 720}}\n"
MERGED = "merged_scans:\n  around: {{laserscan_topics: [left, right], range_max: 30}}\n"


class Vehicle:
    def __init__(self, tmp):
        self.tmp, self.file = tmp, tmp / "vehicle.yaml"
        self.ports = {name: free_port(socket.SOCK_DGRAM) for name in ("scanners", "roof")}
        (tmp / "scene.yaml").write_text(SCENE.format(**self.ports))

    def write(self, text, **more):
        self.file.write_text(text.format(**self.ports, **more))

    def status(self):
        answer = run("status", "--json").stdout
        return json.loads(answer) if answer else {"items": []}

    def item(self, name):
        return {item["name"]: item for item in self.status()["items"]}.get(name)

    def reloads(self):
        return int(dict(self.item("configuration")["values"])["Reloads"])

    def reload(self, daemon):
        before = self.reloads()
        begin = time.monotonic()
        daemon.send_signal(signal.SIGHUP)
        wait_for(lambda: self.reloads() == before + 1, 10, "the configuration is read again")
        print(f"reloaded within {time.monotonic() - begin:.2f} s: {self.item('configuration')['message']}")


class Counter:
    """Messages of a topic, and the longest step between their stamps."""

    def __init__(self, topic, kind):
        self.stamps = []
        self.connections = set()
        self.subscriber = rospy.Subscriber(topic, kind, self.take, queue_size=1000)

    def take(self, message):
        self.stamps.append(message.header.stamp.to_sec())
        self.connections.add(message._connection_header.get("callerid", ""))

    def gaps(self, begin=0):
        return [b - a for a, b in zip(self.stamps[begin:], self.stamps[begin + 1:])]


def expect_no_loss(counters, names):
    for name in names:
        gaps = counters[name].gaps()
        usual = sorted(gaps)[len(gaps) // 2]
        print(f"{name}: {len(gaps)} messages, steps {min(gaps) * 1000:.1f} to {max(gaps) * 1000:.1f} ms")
        expect(max(gaps) < 1.6 * usual, f"{name}: a step of {max(gaps) * 1000:.1f} ms, usually {usual * 1000:.1f} ms")


def losses(vehicle, sensor):
    values = vehicle.item(f"sensor {sensor}")["values"]
    return {key: values[key] for key in values if "ost" in key}


def check_changes(vehicle, daemon, counters):
    full = "sensors:\n" + LEFT + ROOF + RIGHT + MERGED + VIRTUAL
    vehicle.write("sensors:\n" + LEFT + ROOF + RIGHT + MERGED + VIRTUAL, more=", high", pose=", high: {xyz: [0, 0, 1.5]}")
    vehicle.reload(daemon)
    wait_for(lambda: len(counters["right/scan"].stamps) > 10 and len(counters["around"].stamps) > 10 and
             len(counters["high"].stamps) > 5, 10, "what is new comes")
    vehicle.reload(daemon)  # nothing has changed
    time.sleep(1)
    vehicle.write("sensors:\n" + ROOF + LEFT + VIRTUAL, more="", pose="")
    vehicle.reload(daemon)
    wait_for(lambda: vehicle.item("merged around") is None and vehicle.item("sensor right") is None, 5, "what is gone is not told of")
    topics = [name for name, _ in rosgraph.Master("/test").getSystemState()[0]]
    wait_for(lambda: "/around" not in [name for name, _ in rosgraph.Master("/test").getSystemState()[0]], 5, f"no topic: {topics}")
    count = len(counters["around"].stamps)
    time.sleep(1)
    expect(len(counters["around"].stamps) == count, "a merged scan that is gone is published")
    vehicle.write(full, more="", pose="")
    vehicle.reload(daemon)
    wait_for(lambda: len(counters["around"].stamps) > count + 10, 10, "the merged scan is back")


def check_bad_file(vehicle, daemon, log):
    good = vehicle.file.read_text()
    vehicle.file.write_text(good.replace("beams: 720", "beans: 720"))
    line = [i for i, text in enumerate(vehicle.file.read_text().splitlines(), 1) if "beans" in text][0]
    vehicle.reload(daemon)
    item = vehicle.item("configuration")
    expect(item["level"] == "ERROR" and re.search(rf"vehicle.yaml:{line}:\d+: unknown key .*beans", item["message"]), str(item))
    expect(re.search(rf"vehicle.yaml:{line}:\d+: unknown key", log.read_text()), "the log names the line")
    events = json.loads(run("events", "--json").stdout)["events"]
    expect(any(event["source"] == "configuration" and event["level"] == "ERROR" for event in events), "an event")
    vehicle.file.unlink()
    vehicle.reload(daemon)
    expect(vehicle.item("configuration")["level"] == "ERROR", "a missing file is an error")
    vehicle.file.write_text(good)
    vehicle.reload(daemon)
    expect(vehicle.item("configuration")["level"] == "OK", str(vehicle.item("configuration")))


def check_start_with_bad_file(vehicle, tmp, sim):
    state = tmp / "state"
    state.mkdir()
    environment = dict(os.environ, STATE_DIRECTORY=str(state))
    good = vehicle.file.read_text()
    command = [LIDARD, "run", "-c", vehicle.file]
    with process(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL):
        wait_for(lambda: (state / "last-good" / "vehicle.yaml" / "lidard.yaml").exists(), 10, "the configuration is kept")
    vehicle.file.write_text("sensors: [")
    done = run("run", "-c", vehicle.file)
    expect(done.returncode == 78, f"without a folder of state a wrong file is refused: {done.returncode}")
    with (tmp / "bad.txt").open("w") as sink, process(command, env=environment, stdout=sink, stderr=subprocess.STDOUT) as daemon:
        wait_for(lambda: vehicle.item("sensor left") and vehicle.item("sensor left")["level"] == "OK", 10, "the last good one is in force")
        item = vehicle.item("configuration")
        expect(item["level"] == "ERROR" and "vehicle.yaml:1:" in item["message"], str(item))
        print(f"started with a wrong file: {item['message']}")
        expect("vehicle.yaml:1:" in (tmp / "bad.txt").read_text(), "the log says so")
        vehicle.file.write_text(good)
        vehicle.reload(daemon)
        expect(vehicle.item("configuration")["level"] == "OK", str(vehicle.item("configuration")))


def main():
    master = free_port()
    use_master_at(master)
    with folder() as tmp, contextlib.ExitStack() as stack:
        os.environ["LIDARD_SOCKET"] = str(tmp / "control")
        vehicle = Vehicle(tmp)
        vehicle.write("sensors:\n" + LEFT + ROOF + VIRTUAL, more="", pose="")
        master_process = stack.enter_context(ros_master(master))
        sim = stack.enter_context(process([LIDARD_SIM, "live", tmp / "scene.yaml"], stdout=subprocess.DEVNULL))
        log = tmp / "log.txt"
        sink = stack.enter_context(log.open("w"))
        with process([LIDARD, "run", "-c", vehicle.file], stdout=sink, stderr=subprocess.STDOUT) as daemon:
            wait_for(lambda: all(kernel_port_is_open(port) for port in vehicle.ports.values()), 10, "the daemon listens")
            rospy.init_node("listener", disable_signals=True)
            counters = {topic: Counter("/" + topic, kind) for topic, kind in
                        [("left/scan", LaserScan), ("roof/points", PointCloud2), ("low", LaserScan), ("high", LaserScan),
                         ("right/scan", LaserScan), ("around", LaserScan)]}
            frames = collections.defaultdict(int)
            rospy.Subscriber("/tf_static", TFMessage, lambda m: frames.update({t.child_frame_id: len(m.transforms) for t in m.transforms}))
            wait_for(lambda: len(counters["low"].stamps) > 10 and len(counters["left/scan"].stamps) > 10, 20, "scans")
            descriptors = len(list(pathlib.Path(f"/proc/{daemon.pid}/fd").iterdir()))
            check_changes(vehicle, daemon, counters)
            check_bad_file(vehicle, daemon, log)
            master_process.send_signal(signal.SIGSTOP)
            time.sleep(1)
            vehicle.write("sensors:\n" + LEFT + ROOF + RIGHT + MERGED + VIRTUAL, more=", high", pose=", high: {xyz: [0, 0, 1.5]}")
            vehicle.reload(daemon)
            master_process.send_signal(signal.SIGCONT)
            count = len(counters["high"].stamps)
            wait_for(lambda: len(counters["high"].stamps) > count + 5, 10, "what was new while the master hung comes")
            expect_no_loss(counters, ("left/scan", "low"))
            expect_no_loss(counters, ("roof/points",))
            expect(frames["high"] > 0 and frames["right"] > 0, f"/tf_static has what is new: {dict(frames)}")
            for _ in range(10):
                vehicle.reload(daemon)
            now = len(list(pathlib.Path(f"/proc/{daemon.pid}/fd").iterdir()))
            print(f"{descriptors} descriptors before, {now} after")
            expect(now <= descriptors + 4, "sockets are left of former configurations")
            # Three of roscpp's and six of ours; those of former lanes end soon.
            threads = lambda: sorted((task / "comm").read_text().strip() for task in pathlib.Path(f"/proc/{daemon.pid}/task").iterdir())
            wait_for(lambda: len(threads()) == 9, 5, f"no thread is left: {threads()}")
            print(f"lost: left {losses(vehicle, 'left')}, roof {losses(vehicle, 'roof')}")
        check_start_with_bad_file(vehicle, tmp, sim)
    print("ok")


if __name__ == "__main__":
    main()
