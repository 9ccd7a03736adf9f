#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Nothing but faults for LIDARD_FAULT_MINUTES (3): one or two at a time, drawn at random (LIDARD_FAULT_SEED=N: another draw), some of them twice. No
output that is wrong (old, stamped back, ranges that are not the scene's) stands beside items that are OK, and each round ends well."""
import contextlib
import math
import os
import random
import signal
import socket
import threading
import time

import rospy
from harness import LIDARD_SIM, Clock, Now, Starved, ask, daemon, expect, scene_of, wait_for, write
from network import Network
from ros_tools import ros_test
from sensor_msgs.msg import LaserScan
from test_fault_table import HOST, ROOM, half_a_minute_later

LIDARS = {"left": ("sick_microscan3", "192.168.1.21", 6060, "[0, 1, 0.3]"), "right": ("sick_microscan3", "192.168.1.22", 6060, "[0, -1, 0.3]"),
          "roof": ("velodyne_vlp16", "192.168.1.201", 2368, "[0, 0, 2]"), "back": ("sick_lms1xx", "192.168.1.11", 2112, "[0, 0, 0.3]")}
CONFIG = "sensors:\n" + "".join(f"  {name}: {{model: {model}, ip_address: {address}, ip_port: {port}, listen_only: {'true' if 'micro' in model else 'false'}, "
                                f"pose: {{xyz: {xyz}}}}}\n".replace("listen_only: false, ", "") for name, (model, address, port, xyz) in LIDARS.items()) + """\
merged_scans: {around: {laserscan_topics: [left, right], profile: strict, range_max: 24}}
virtual_scans: {levels: {cloud_topic: roof, virtual_laser_scan: [high], profile: strict, poses: {high: {xyz: [0, 0, 1.9]}}, range_max: 24}}
"""
# By topic, the items of which one says so while its messages are wrong, besides those of the computer.
ITEMS = {"around": ("merged around", "sensor left", "sensor right"), "high": ("virtual levels", "sensor roof"), "back/scan": ("sensor back",)}
OF_THE_COMPUTER = ("clock", "computer", "port", "ROS")


def late(waiting, payload):
    """Datagrams come 0.4 s later."""
    waiting.append((time.monotonic() + 0.4, payload))
    return [waiting.pop(0)[1] for at, _ in list(waiting) if at <= time.monotonic()]


SPOILS = {
    "falls silent": lambda p, _: [],
    "loses 2 %": lambda p, _: [p] * (random.random() > 0.02),
    "loses 10 %": lambda p, _: [p] * (random.random() > 0.1),
    "is corrupted": lambda p, _: [p if random.random() > 0.2 else p[:400]],
    "comes twice": lambda p, _: [p, p],
    "comes late": lambda p, waiting: late(waiting, p),
    "has a twin": lambda p, _: [p, half_a_minute_later(p, 0)],
}


def start(network, tmp, name, spoiled):
    """A simulated lidar; its datagrams, if that is what it sends, go over the cable as spoiled[name] makes them."""
    model, address, port, xyz = LIDARS[name]
    with network.among_lidars():
        inlet = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    inlet.bind(("127.0.0.1", 0))
    router = network.lidar(address, port)

    def carry():
        waiting = []
        while True:
            payload = inlet.recv(65536)
            for one in SPOILS[spoiled[name]](payload, waiting) if spoiled.get(name) else [payload]:
                with contextlib.suppress(OSError):  # no cable
                    router.sendto(one, (HOST, port))
    threading.Thread(target=carry, daemon=True).start()
    to = f"{HOST}:40001" if name == "back" else f"127.0.0.1:{inlet.getsockname()[1]}"
    scene = scene_of({name: f"model: {model}, from: '{address}:{port}', to: '{to}', pose: {{xyz: {xyz}}}"}, *ROOM, seconds=90_000)
    return network.start_lidar([LIDARD_SIM, "live", str(write(tmp / f"{name}.yaml", scene))])


class Watch:
    """Wrong messages since the last look, and when which items were not OK."""

    def __init__(self, clock):
        self.clock, self.wrong, self.ill, self.truth, self.last = clock, [], [], {}, {}
        self.subscribers = [rospy.Subscriber("/" + topic, LaserScan, self.scan, topic, queue_size=100) for topic in ITEMS]
        threading.Thread(target=self.poll, daemon=True).start()

    def scan(self, message, topic):
        stamp = message.header.stamp.to_sec()
        age, last = time.time() + self.clock.seconds - stamp, self.last.get(topic, 0)
        seen = [(a, b) for a, b in zip(message.ranges, self.truth.setdefault(topic, message.ranges)) if not math.isnan(a + b)]
        off = sum(a != b and not abs(a - b) < 0.15 for a, b in seen)
        self.last[topic] = stamp
        for is_wrong, why in ((not -0.02 < age < 1, f"{age:.2f} s old"), (0 <= last - stamp < 1, f"stamped back by {last - stamp:.3f} s"),
                              (off > 0.05 * len(message.ranges), f"{off} of {len(seen)} ranges are not those of the scene")):
            if is_wrong:
                self.wrong.append((time.monotonic(), topic, why))

    def poll(self):
        while True:
            self.ill.append((time.monotonic(), {one["name"] for one in (ask("status") or {"items": []})["items"] if one["level"] != "OK"}))
            time.sleep(0.1)

    def unnoticed(self, patience):
        """How many messages were wrong, and those beside which no item of theirs said so."""
        wrong, self.wrong = self.wrong, []
        return len(wrong), [(topic, why) for at, topic, why in wrong if not any(
                    at - 0.5 < t < at + patience and any(name in ITEMS[topic] or name.startswith(OF_THE_COMPUTER) for name in names) for t, names in self.ill)]


def faults_of(network, spoiled, clock, file, child, master, back):
    """What is done, and what ends it."""
    reload = lambda text: lambda: (write(file, text), child.send_signal(signal.SIGHUP))
    stopped = lambda process: (lambda: process.send_signal(signal.SIGSTOP), lambda: process.send_signal(signal.SIGCONT))
    link = lambda state: lambda: network.host("link", "set", "lidar0", state)
    turned = lambda deg: CONFIG.replace("[0, -1, 0.3]", f"[0, -1, 0.3], rpy_deg: [0, 0, {deg}]")
    faults = {f"{name} {how}": (lambda name=name, how=how: spoiled.update({name: how}), lambda name=name: spoiled.pop(name, None))
              for name in ("left", "right", "roof") for how in SPOILS if name == "roof" or how != "has a twin"}
    faults.update({f"right is turned by {deg} deg": (reload(turned(deg)), reload(CONFIG)) for deg in (2, 8, 90)})
    faults.update({f"clock set by {step} s": (lambda step=step: clock.set_by(step), lambda step=step: clock.set_by(-step)) for step in (1.5, -600)})
    return {**faults, "unknown key": (reload(CONFIG + "nonsense: 1\n"), reload(CONFIG)), "no link": (link("down"), link("up")),
            "back hangs": stopped(back), "daemon stopped": stopped(child), "master hangs": stopped(master)}


def one_round(faults, number, draw):
    names = draw.sample(sorted(faults), 1 + number % 2)
    for _ in range(draw.choice((1, 1, 2))):
        for name in names:
            faults[name][0]()
            time.sleep(draw.uniform(0, 2))
        time.sleep(18 if "turned" in str(names) else draw.uniform(1, 7))
        for name in reversed(names):
            faults[name][1]()
        time.sleep(draw.uniform(0.5, 2))
    return " and ".join(names)


def main():
    minutes, seed = float(os.environ.get("LIDARD_FAULT_MINUTES", 3)), int(os.environ.get("LIDARD_FAULT_SEED", 1795788667))
    print(f"LIDARD_FAULT_SEED={seed}", flush=True)
    network, draw, spoiled, failures, rounds = Network(), random.Random(seed), {}, [], 0
    with ros_test() as (tmp, master):
        clock, file = Clock(tmp / "clock"), write(tmp / "c.yaml", CONFIG)
        network.plug(host=HOST + "/24", lidars=[f"{address}/24" for _, address, _, _ in LIDARS.values()])
        sims = {name: start(network, tmp, name, spoiled) for name in LIDARS}
        with daemon(file, env=clock.environment()) as child:
            nothing = {"items": [{"name": "lidard", "level": "", "message": "does not answer"}]}
            ill = lambda: [f"{one['name']}: {one['message']}" for one in (ask("status") or nothing)["items"] if one["level"] != "OK"]
            wait_for(lambda: not ill(), 20, Now(lambda: f"all is well: {ill()}"))
            watch, end = Watch(clock), time.monotonic() + 60 * minutes
            faults = faults_of(network, spoiled, clock, file, child, master, sims["back"])
            while time.monotonic() < end:
                rounds, starved = rounds + 1, Starved()
                names = one_round(faults, rounds, draw)
                wait_for(lambda: not ill(), 20, Now(lambda: f"all is well after {names}: {ill()}"))
                time.sleep(4)
                wrong, unnoticed = watch.unnoticed(16 if "turned" in names else 4 + starved.seconds() / 10)
                print(f"{rounds} {names}: {wrong} wrong, {len(unnoticed)} unnoticed {unnoticed[:3]}, starved {starved.seconds():.1f}", flush=True)
                failures += [(names, *one) for one in unnoticed[:1]]
                expect(child.poll() is None, f"the daemon ended: {child.said()[-2000:]}")
    expect(not failures, "\n  ".join(["", *map(str, failures)]))
    print(f"{rounds} rounds, ok")


main()
