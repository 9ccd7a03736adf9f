#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""dynamic_reconfigure's own client against the running daemon while data flow: values take effect live, what cannot be is
refused with its reason and the values in force, and a master that was restarted knows the servers again."""
import math
import os
import subprocess
import time
import xmlrpc.client

import dynamic_reconfigure.client
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from harness import LIDARD, expect, folder, free_port, process, ros_master, use_master_at, wait_for
from laser_tools import Listener, Talker, check_consistent, set_parameters, static_transforms, transform, wall_scan

CONFIG = """\
vehicle: {base_frame: base_link}
sensors:
  left: {topic: /left, pose: {xyz: [0, 0, 0]}, frame_id: left_laser}
  right: {topic: /right, pose: {xyz: [0, 0, 0.5]}, frame_id: right_laser}
merged_scans:
  around: {laserscan_topics: [left, right], destination_frame: base_link, angle_min: -1.5, angle_max: 1.5,
    angle_increment: 0.01, range_max: 20, scan_destination_topic: /around}
"""
# With another number of beams a topic is advertised anew. rospy, if it comes back too early, doubles its pauses up to 32 s.
AGAIN = 15
ANCESTOR = {"angle_min", "angle_max", "angle_increment", "time_increment", "scan_time", "range_min", "range_max"}


class Changes:
    """A client, and what the server published."""

    def __init__(self, name):
        self.updates = []
        self.client = dynamic_reconfigure.client.Client(name, timeout=20, config_callback=self.updates.append)
        wait_for(lambda: self.updates, 10, f"{name} tells its values")

    def ask(self, **values):
        """The values in force after a request, which are published too."""
        count = len(self.updates)
        answer = self.client.update_configuration(values)
        wait_for(lambda: len(self.updates) > count, 5, "an update is published")
        for name, value in self.updates[-1].items():
            expect(name == "groups" or answer[name] == value, f"{name}: answered {answer[name]}, published {value}")
        return answer


class Diagnostics:
    def __init__(self):
        self.items = {}
        self.subscriber = rospy.Subscriber("/diagnostics", DiagnosticArray, self._take)

    def _take(self, array):
        self.items.update((s.name.split(": ", 1)[-1], s) for s in array.status)

    def wait(self, name, text, level, values=None):
        """Until a status says so; in all its values those given."""
        def says():
            item = self.items.get(name)
            known = {pair.key: pair.value for pair in item.values} if item else {}
            return item and text in item.message and item.level == level and dict(known, **(values or {})) == known
        wait_for(says, 5, f"{name} says {text} {values}, not {self.items.get(name)}")


def check_daemon(port, scans, diagnostics):
    server = Changes("/lidard/around")
    values = server.updates[-1]
    expect(ANCESTOR | {"profile", "min_height", "max_height", "empty", "unobserved"} <= set(values), f"items: {sorted(values)}")
    expect(values["angle_increment"] == 0.01 and values["profile"] == "flatten", f"values of the configuration: {values}")
    newest = lambda: scans.messages[-1]
    expect(len(newest().ranges) == 301, f"{len(newest().ranges)} beams")

    expect(server.ask(range_max=4.0)["range_max"] == 4.0, "taken")
    wait_for(lambda: newest().range_max == 4.0, 5, "range_max takes effect")
    expect(all(r <= 4 or math.isinf(r) for r in newest().ranges), "no range beyond it")
    server.ask(range_max=20.0, min_height=0.25)
    wait_for(lambda: any(4 < r < 6 for r in newest().ranges) and not any(2 < r < 4 for r in newest().ranges), 5,
             "only the scanner above the height is left")
    server.ask(min_height=-10000, unobserved="minus_inf", empty="nan")
    wait_for(lambda: any(2 < r < 4 for r in newest().ranges) and any(math.isnan(r) for r in newest().ranges), 5, "both again")

    began = time.monotonic()
    server.ask(angle_increment=0.02)
    wait_for(lambda: len(newest().ranges) == 151, AGAIN, "another number of beams")
    check_consistent(newest())
    diagnostics.wait("reconfigure around", "in force", 0, {"Changes of the number of beams": "1", "Beams": "151"})
    wait_for(lambda: len(scans.since(began)) > 60, AGAIN, "scans keep coming")
    sizes = [len(m.ranges) for m in scans.since(began)]
    expect(sizes == sorted(sizes, reverse=True), "the size changes once")

    for wanted, reason in (({"angle_max": -1.6}, "expected angle_min < angle_max"), ({"angle_increment": 0.0}, "above 0"),
                           ({"range_min": 30.0}, "expected range_min < range_max"),
                           ({"min_height": 3.0, "max_height": 2.0}, "expected min_height < max_height")):
        answer = server.ask(**wanted)
        expect(answer["angle_max"] == 1.5 and answer["angle_increment"] == 0.02 and answer["range_min"] == 0, f"in force: {answer}")
        diagnostics.wait("reconfigure around", reason, 1, {"Beams": "151"})
    diagnostics.wait("reconfigure around", reason, 1, {"Changes refused": "4"})
    expect(len(newest().ranges) == 151, "as before")
    server.ask(profile="strict")
    wait_for(lambda: len([r for r in newest().ranges if math.isfinite(r)]) > 0, 5, "profile strict")
    diagnostics.wait("reconfigure around", "in force", 0)
    stored = lambda: xmlrpc.client.ServerProxy(f"http://127.0.0.1:{port}").getParam("/test", "/lidard/around")[2]
    wait_for(lambda: stored()["angle_increment"] == 0.02 and stored()["profile"] == "strict", 5, "the parameter server knows")
    return server


def check_dropin(tmp, port):
    program = tmp / "laserscan_multi_merger"
    program.symlink_to(os.path.abspath(LIDARD))
    set_parameters(port, "/ns/merger", {"laserscan_topics": "/left /right", "destination_frame": "base_link",
                                        "angle_min": -1.0, "time_increment": 0.0001})
    scans = Listener("/scan_multi")
    tf = static_transforms([transform("base_link", f"{side}_laser", (0, 0, 0)) for side in ("left", "right")])
    with process([program, "__ns:=/ns", "__name:=merger"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL):
        server = Changes("/ns/merger")
        expect(set(server.updates[-1]) - {"groups"} == ANCESTOR, f"items: {sorted(server.updates[-1])}")
        descriptions = {d["name"]: d for d in server.client.get_parameter_descriptions()}
        expect(descriptions["range_max"]["max"] == 1000 and abs(descriptions["angle_min"]["min"] + math.pi) < 1e-9, "limits")
        wait_for(lambda: len(scans.messages) > 5, 15, "scans")
        expect(abs(scans.messages[-1].time_increment - 0.0001) < 1e-9, "time_increment of a parameter")
        expect(server.ask(angle_min=-9.0)["angle_min"] == -math.pi, "brought into its limits")
        wait_for(lambda: abs(scans.messages[-1].angle_min + math.pi) < 1e-6, AGAIN, "angle_min takes effect")
        command = subprocess.run(["/usr/bin/python3", "-c", "from dynamic_reconfigure.client import Client; import rospy; "
                                  "rospy.init_node('dynparam'); Client('/ns/merger', timeout=10).update_configuration("
                                  "{'range_max': '7'})"], timeout=60, check=False)
        expect(command.returncode == 0, "dynparam set")
        wait_for(lambda: scans.messages[-1].range_max == 7, AGAIN, "range_max takes effect, set as text")
    tf.unregister()


def check_master_again(port, log):
    wait_for(lambda: "registered again" in log.read_text(), 15, "the daemon registers again:\n" + log.read_text())
    master = xmlrpc.client.ServerProxy(f"http://127.0.0.1:{port}")
    code, message, _ = master.lookupService("/test", "/lidard/around/set_parameters")
    expect(code == 1, message)
    wait_for(lambda: master.hasParam("/test", "/lidard/around/range_max")[2], 5, "parameters are stored again")
    published = dict(master.getTopicTypes("/test")[2])
    expect(published.get("/lidard/around/parameter_updates") == "dynamic_reconfigure/Config", f"{published}")


def main():
    port = free_port()
    use_master_at(port)
    with folder() as tmp:
        config, log = tmp / "live.yaml", tmp / "log.txt"
        config.write_text(CONFIG)
        with log.open("w") as sink, process([LIDARD, "run", "-c", config], stdout=sink, stderr=subprocess.STDOUT) as daemon:
            with ros_master(port):
                rospy.init_node("listener", disable_signals=True, anonymous=True)
                talkers = [Talker("/left", wall_scan("left_laser", [3.0] * 200)), Talker("/right", wall_scan("right_laser", [5.0] * 250))]
                scans, diagnostics = Listener("/around"), Diagnostics()
                wait_for(lambda: len(scans.messages) > 5, 20, "scans:\n" + log.read_text())
                check_daemon(port, scans, diagnostics)
                check_dropin(tmp, port)
            with ros_master(port):
                check_master_again(port, log)
            daemon.terminate()
            expect(daemon.wait(5) == 0, "SIGTERM ends it with 0")
        for talker in talkers:
            talker.running = False
    print("ok")


if __name__ == "__main__":
    main()
