#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""SIGHUP puts a changed configuration in force: sensors, outputs and subscribers that it does not concern lose nothing, what is
new comes, what is gone goes. A wrong file changes nothing and is reported with its line; a start with a wrong file applies the last
configuration that was good, where a service manager gives a folder to keep it in."""
import collections
import contextlib
import os
import re
import signal
import socket
import time

import rosgraph
import rospy
from harness import (ask, daemon, descriptors, expect, figure, free_port, item, kernel_port_is_open, level, run, scene_of, sim, thread_names,
                     wait_for, write)
from ros_tools import Listener, ros_test
from sensor_msgs.msg import LaserScan, PointCloud2
from tf2_msgs.msg import TFMessage

SENSORS = {"left": "model: sick_microscan3, from: '192.168.0.21:6060', to: '127.0.0.1:{scanners}'",
           "right": "model: sick_microscan3, from: '192.168.0.22:6060', to: '127.0.0.1:{scanners}'",
           "roof": "model: velodyne_vlp16, from: '192.168.1.201:2368', to: '127.0.0.1:{roof}'"}
LEFT = "  left: {{model: sick_microscan3, ip_address: 127.168.0.21, ip_port: {scanners}, listen_only: true, pose: {{xyz: [1, 1, 0.3]}}}}\n"
RIGHT = "  right: {{model: sick_microscan3, ip_address: 127.168.0.22, ip_port: {scanners}, listen_only: true, pose: {{xyz: [1, -1, 0.3]}}}}\n"
ROOF = "  roof: {{model: velodyne_vlp16, ip_address: 127.168.1.201, ip_port: {roof}, pose: {{xyz: [0, 0, 2]}}}}\n"
VIRTUAL = "virtual_scans:\n  levels: {{cloud_topic: roof, virtual_laser_scan: [low{more}], poses: {{low: {{xyz: [0, 0, 0.4]}}{pose}}}, beams: 720}}\n"
MERGED = ("merged_scans:\n  around: {{laserscan_topics: [left, right], range_max: 30}}\n"
          "  mixed: {{laserscan_topics: [left, low], range_max: 30}}\n")


FULL = "sensors:\n" + LEFT + ROOF + RIGHT + MERGED + VIRTUAL
HIGH = {"more": ", high", "pose": ", high: {xyz: [0, 0, 1.5]}"}
TOPICS = {"left/scan": LaserScan, "roof/points": PointCloud2, "low": LaserScan, "high": LaserScan, "right/scan": LaserScan,
          "around": LaserScan, "mixed": LaserScan}


class Vehicle:
    """A configuration that changes, and what comes of it."""

    def __init__(self, tmp):
        self.file = tmp / "vehicle.yaml"
        self.ports = {name: free_port(socket.SOCK_DGRAM) for name in ("scanners", "roof")}
        self.scene = write(tmp / "scene.yaml", scene_of({name: keys.format(**self.ports) for name, keys in SENSORS.items()}))
        self.change("sensors:\n" + LEFT + ROOF + VIRTUAL)

    def change(self, text, more="", pose=""):
        write(self.file, text.format(**self.ports, more=more, pose=pose))

    def listen(self):
        self.listeners = {topic: Listener("/" + topic, kind) for topic, kind in TOPICS.items()}

    def count(self, topic):
        return len(self.listeners[topic].messages)

    def reload(self, child):
        reloads = lambda: int(figure("configuration", "Reloads"))
        before, begin = reloads(), time.monotonic()
        child.send_signal(signal.SIGHUP)
        wait_for(lambda: reloads() == before + 1, 10, "the configuration is read again")
        print(f"reloaded within {time.monotonic() - begin:.2f} s: {item('configuration')['message']}")

    def expect_no_loss(self, *topics):
        for topic in topics:
            stamps = self.listeners[topic].stamps()
            gaps = [b - a for a, b in zip(stamps, stamps[1:])]
            usual = sorted(gaps)[len(gaps) // 2]
            print(f"{topic}: {len(gaps)} messages, steps {min(gaps) * 1000:.1f} to {max(gaps) * 1000:.1f} ms")
            expect(max(gaps) < 1.6 * usual, f"{topic}: a step of {max(gaps) * 1000:.1f} ms, usually {usual * 1000:.1f} ms")


def losses(sensor):
    return {key: value for key, value in item(f"sensor {sensor}")["values"].items() if "ost" in key}


def published_topics():
    return [name for name, _ in rosgraph.Master("/test").getSystemState()[0]]


def expect_merged_with_virtual(vehicle):
    count = vehicle.count("mixed")
    wait_for(lambda: vehicle.count("mixed") > count + 10, 10, "a planar scan and a virtual one are merged")
    wait_for(lambda: item("merged mixed")["values"]["Source low"].startswith("ok"), 5, f"both are used: {item('merged mixed')}")
    wait_for(lambda: item("virtual scans to merge")["message"] == "all are handed over", 15, "all are handed over")


def check_changes(vehicle, child):
    vehicle.change(FULL, **HIGH)
    vehicle.reload(child)
    wait_for(lambda: vehicle.count("right/scan") > 10 and vehicle.count("around") > 10 and vehicle.count("high") > 5, 10, "what is new comes")
    expect_merged_with_virtual(vehicle)
    vehicle.reload(child)  # nothing has changed
    time.sleep(1)  # a loss would show
    vehicle.change("sensors:\n" + ROOF + LEFT + VIRTUAL)
    vehicle.reload(child)
    wait_for(lambda: item("merged around") is None and item("sensor right") is None, 5, "what is gone is not reported")
    wait_for(lambda: "/around" not in published_topics(), 5, f"no topic: {published_topics()}")
    count = vehicle.count("around")
    time.sleep(1)  # a message would come
    expect(vehicle.count("around") == count, "a merged scan that is gone is published")
    vehicle.change(FULL)
    vehicle.reload(child)
    wait_for(lambda: vehicle.count("around") > count + 10, 10, "the merged scan is back")
    expect_merged_with_virtual(vehicle)


def check_bad_file(vehicle, child):
    good = vehicle.file.read_text()
    write(vehicle.file, good.replace("beams: 720", "beans: 720"))
    line = [i for i, text in enumerate(vehicle.file.read_text().splitlines(), 1) if "beans" in text][0]
    vehicle.reload(child)
    state = item("configuration")
    expect(state["level"] == "ERROR" and re.search(rf"vehicle.yaml:{line}:\d+: unknown key .*beans", state["message"]), str(state))
    expect(re.search(rf"vehicle.yaml:{line}:\d+: unknown key", child.said()), "the log names the line")
    expect(any(event["source"] == "configuration" and event["level"] == "ERROR" for event in ask("events")["events"]), "an event")
    vehicle.file.unlink()
    vehicle.reload(child)
    expect(level("configuration") == "ERROR", "a missing file is an error")
    write(vehicle.file, good)
    vehicle.reload(child)
    expect(level("configuration") == "OK", str(item("configuration")))


def check_hung_master(vehicle, child, master):
    master.send_signal(signal.SIGSTOP)
    time.sleep(1)  # calls of the daemon hang
    vehicle.change(FULL, **HIGH)
    vehicle.reload(child)
    master.send_signal(signal.SIGCONT)
    count = vehicle.count("high")
    wait_for(lambda: vehicle.count("high") > count + 5, 10, "what was new while the master hung comes")


def check_leftovers(vehicle, child, before):
    for _ in range(10):
        vehicle.reload(child)
    # Connections of roscpp that end do so soon.
    wait_for(lambda: descriptors(child.pid) <= before + 5, 5, f"no socket is left of former configurations: {before} descriptors before, "
             f"{descriptors(child.pid)} after")
    # Three of roscpp's and five of ours; those of former workers end soon.
    wait_for(lambda: len(thread_names(child.pid)) == 8, 5, f"no thread is left: {thread_names(child.pid)}")
    print(f"lost: left {losses('left')}, roof {losses('roof')}")


def check_start_with_bad_file(vehicle, tmp):
    state = tmp / "state"
    state.mkdir()
    environment = dict(os.environ, STATE_DIRECTORY=str(state))
    good = vehicle.file.read_text()
    with daemon(vehicle.file, env=environment):
        wait_for(lambda: (state / "last-good" / "vehicle.yaml" / "lidard.yaml").exists(), 10, "the configuration is kept")
    write(vehicle.file, "sensors: [")
    done = run("run", "-c", vehicle.file)
    expect(done.returncode == 78, f"without a folder of state a wrong file is refused: {done.returncode}")
    with daemon(vehicle.file, env=environment) as child:
        wait_for(lambda: level("sensor left") == "OK", 10, "the last good one is in force")
        state = item("configuration")
        expect(state["level"] == "ERROR" and "vehicle.yaml:1:" in state["message"], str(state))
        print(f"started with a wrong file: {state['message']}")
        expect("vehicle.yaml:1:" in child.said(), "the log says so")
        write(vehicle.file, good)
        vehicle.reload(child)
        expect(level("configuration") == "OK", str(item("configuration")))


def main():
    with ros_test() as (tmp, master), contextlib.ExitStack() as stack:
        vehicle = Vehicle(tmp)
        stack.enter_context(sim(vehicle.scene))
        with daemon(vehicle.file) as child:
            wait_for(lambda: all(kernel_port_is_open(port) for port in vehicle.ports.values()), 10, "the daemon listens")
            vehicle.listen()
            frames = collections.defaultdict(int)
            rospy.Subscriber("/tf_static", TFMessage, lambda m: frames.update({t.child_frame_id: len(m.transforms) for t in m.transforms}))
            wait_for(lambda: vehicle.count("low") > 10 and vehicle.count("left/scan") > 10, 20, "scans")
            before = descriptors(child.pid)
            check_changes(vehicle, child)
            check_bad_file(vehicle, child)
            check_hung_master(vehicle, child, master)
            vehicle.expect_no_loss("left/scan", "low", "roof/points")
            expect(frames["high"] > 0 and frames["right"] > 0, f"/tf_static has what is new: {dict(frames)}")
            check_leftovers(vehicle, child, before)
        check_start_with_bad_file(vehicle, tmp)
    print("ok")


if __name__ == "__main__":
    main()
