#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""dynamic_reconfigure's own client against the running daemon while data flow: values take effect live, what cannot be is
refused with its reason and the values in force, and a master that was restarted knows the servers again."""
import math
import signal
import subprocess
import time
import xmlrpc.client

import dynamic_reconfigure.client
from harness import daemon, expect, expect_end, logged, named_program, ros_master, wait_for, write
from ros_tools import (Diagnostics, Listener, Talker, check_consistent, ros_test, set_parameters, static_transforms, transform,
                       wall_scan)

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
        wait_for(lambda: self.updates, 10, f"{name} has values")

    def ask(self, **values):
        """The values in force after a request, which are published too."""
        count = len(self.updates)
        answer = self.client.update_configuration(values)
        wait_for(lambda: len(self.updates) > count, 5, "an update is published")
        for name, value in self.updates[-1].items():
            expect(name == "groups" or answer[name] == value, f"{name}: answered {answer[name]}, published {value}")
        return answer


def expect_state(diagnostics, text, level, values=None):
    """Waits until the item of the merged scan says so; in all its values those given."""
    name = "reconfigure around"
    wait_for(lambda: text in diagnostics.message(name) and diagnostics.level(name) == level
             and (values or {}).items() <= diagnostics.values(name).items(), 5, f"{name} says {text} {values}, not {diagnostics.items.get(name)}")


def check_values(server, scans):
    newest = lambda: scans.messages[-1]
    expect(len(newest().ranges) == 301, f"{len(newest().ranges)} beams")

    expect(server.ask(range_max=4.0)["range_max"] == 4.0, "accepted")
    wait_for(lambda: newest().range_max == 4.0, 5, "range_max takes effect")
    expect(all(r <= 4 or math.isinf(r) for r in newest().ranges), "no range beyond it")
    server.ask(range_max=20.0, min_height=0.25)
    wait_for(lambda: any(4 < r < 6 for r in newest().ranges) and not any(2 < r < 4 for r in newest().ranges), 5,
             "only the scanner above the height is left")
    server.ask(min_height=-10000, unobserved="minus_inf", empty="nan")
    wait_for(lambda: any(2 < r < 4 for r in newest().ranges) and any(math.isnan(r) for r in newest().ranges), 5, "both again")


def check_beams(server, scans, diagnostics):
    began, newest = time.monotonic(), lambda: scans.messages[-1]
    server.ask(angle_increment=0.02)
    wait_for(lambda: len(newest().ranges) == 151, AGAIN, "another number of beams")
    check_consistent(newest())
    expect_state(diagnostics, "in force", 0, {"Changes of the number of beams": "1", "Beams": "151"})
    wait_for(lambda: len(scans.since(began)) > 60, AGAIN, "scans keep coming")
    sizes = [len(m.ranges) for m in scans.since(began)]
    expect(sizes == sorted(sizes, reverse=True), "the size changes once")


def check_refusals(server, scans, diagnostics):
    for wanted, reason in (({"angle_max": -1.6}, "expected angle_min < angle_max"), ({"angle_increment": 0.0}, "above 0"),
                           ({"range_min": 30.0}, "expected range_min < range_max"),
                           ({"min_height": 3.0, "max_height": 2.0}, "expected min_height < max_height")):
        answer = server.ask(**wanted)
        expect(answer["angle_max"] == 1.5 and answer["angle_increment"] == 0.02 and answer["range_min"] == 0, f"in force: {answer}")
        expect_state(diagnostics, reason, 1, {"Beams": "151"})
    expect_state(diagnostics, "change refused, the values before stay: ", 1, {"Changes refused": "4"})
    expect(len(scans.messages[-1].ranges) == 151, "as before")


def check_daemon(port, scans, diagnostics):
    server = Changes("/lidard/around")
    values = server.updates[-1]
    expect(ANCESTOR | {"profile", "min_height", "max_height", "empty", "unobserved"} <= set(values), f"items: {sorted(values)}")
    expect(values["angle_increment"] == 0.01 and values["profile"] == "flatten", f"values of the configuration: {values}")
    check_values(server, scans)
    check_beams(server, scans, diagnostics)
    check_refusals(server, scans, diagnostics)
    server.ask(profile="strict")
    wait_for(lambda: any(math.isfinite(r) for r in scans.messages[-1].ranges), 5, "profile strict")
    expect_state(diagnostics, "in force", 0)
    stored = lambda: xmlrpc.client.ServerProxy(f"http://127.0.0.1:{port}").getParam("/test", "/lidard/around")[2]
    wait_for(lambda: stored()["angle_increment"] == 0.02 and stored()["profile"] == "strict", 5, "the parameter server knows")


def check_dropin(tmp, port):
    set_parameters(port, "/ns/merger", {"laserscan_topics": "/left /right", "destination_frame": "base_link",
                                        "angle_min": -1.0, "time_increment": 0.0001})
    scans = Listener("/scan_multi")
    tf = static_transforms([transform("base_link", f"{side}_laser", (0, 0, 0)) for side in ("left", "right")])
    with logged([named_program(tmp, "laserscan_multi_merger"), "__ns:=/ns", "__name:=merger"], tmp / "merger.log"):
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


def check_master_again(port, child):
    wait_for(lambda: "registered again" in child.said(), 15, "the daemon registers again:\n" + child.said())
    master = xmlrpc.client.ServerProxy(f"http://127.0.0.1:{port}")
    code, message, _ = master.lookupService("/test", "/lidard/around/set_parameters")
    expect(code == 1, message)
    wait_for(lambda: master.hasParam("/test", "/lidard/around/range_max")[2], 5, "parameters are stored again")
    published = dict(master.getTopicTypes("/test")[2])
    expect(published.get("/lidard/around/parameter_updates") == "dynamic_reconfigure/Config", f"{published}")


def main():
    with ros_test() as (tmp, master):
        with daemon(write(tmp / "live.yaml", CONFIG)) as child:
            talkers = [Talker("/left", wall_scan("left_laser", [3.0] * 200)), Talker("/right", wall_scan("right_laser", [5.0] * 250))]
            scans, diagnostics = Listener("/around"), Diagnostics()
            wait_for(lambda: len(scans.messages) > 5, 20, "scans:\n" + child.said())
            check_daemon(master.port, scans, diagnostics)
            check_dropin(tmp, master.port)
            master.terminate()
            master.wait()
            with ros_master(master.port):
                check_master_again(master.port, child)
            expect_end(child, signal.SIGTERM, 5)
        for talker in talkers:
            talker.running = False
    print("ok")


if __name__ == "__main__":
    main()
