#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""A vehicle's day in short: eight lidars over a cable, and again and again bursts of losses, duplicates and exchanged packets, a cable
that is unplugged, a ROS master that is restarted, reloads of the configuration and steps of the host's clock. Memory and
descriptors do not grow, also with a black box, every lost packet is counted, every fault is an event once.

    test_soak.py [SECONDS]     default 30; 1800 for a release; with LIDARD, LIDARD_SIM, LIDARD_SOURCE_DIR and LIDARD_CLOCK_SHIM set
                               as ctest does
"""
import collections
import signal
import sys
import threading
import time

from harness import (Clock, Now, Starved, ask, daemon, descriptors, events_of, expect, figure, folder, free_port, item, kilobytes, ros_master,
                     scene_of, use_master_at, wait_for, well)
from network import Network, recorded
import test_network_silence as lidars

MORE = {"rear": ("velodyne_vlp16", "192.168.1.202", 2369), "side": ("velodyne_hdl32e", "192.168.1.203", 2370),
        "back": ("sick_microscan3", "192.168.1.22", 6061), "low": ("sick_microscan3", "192.168.1.23", 6062)}
CONFIG = lidars.CONFIG + "".join(
    f"  {name}: {{model: {model}, ip_address: {address}, ip_port: {port}{'' if 'velodyne' in model else ', listen_only: true'}}}\n"
    for name, (model, address, port) in MORE.items())
CONFIG = CONFIG.replace("}\n", ", pose: {xyz: [0, 0, 1]}}\n") + """\
merged_scans:
  around: {laserscan_topics: [front, back, low], range_max: 30}
blackbox: {seconds: 4, megabytes: 8}
"""
OTHER = "virtual_scans:\n  levels: {cloud_topic: rear, virtual_laser_scan: [rear], range_max: 30}\n"
LOST = {"bursts": 20, "every": 500}
# kB of resident memory beyond those of a warm daemon; a short run ends before the heap has found its size.
LARGEST_GROWTH, SHORT_GROWTH = 1024, 4096


class Roof:
    """The VLP-16 whose packets somebody else spoils on their way; knows what it did not send."""

    def __init__(self, network, tmp):
        scene = scene_of({"roof": lidars.SCENES["roof"]}, seconds=20)
        self.payloads = [payload for _, _, port, payload in recorded(tmp, scene) if port == 2368]
        self.period = 1 / 753.5
        self.sender, self.stop = network.lidar(lidars.ADDRESSES["roof"]), threading.Event()
        self.lost, self.sent, self.spoil, self.us = 0, 0, False, 0
        self.thread = threading.Thread(target=self.run, daemon=True)

    def stamped(self, number):
        """The payload of packet `number`. Stamps go on where the recording begins again."""
        count = len(self.payloads)
        payload = bytearray(self.payloads[number % count])
        if number % count == 0 and number > 0:
            self.us += int(1e6 * self.period)
        elif number > 0:
            before = int.from_bytes(self.payloads[(number - 1) % count][1200:1204], "little")
            self.us += (int.from_bytes(payload[1200:1204], "little") - before) % 3_600_000_000
        payload[1200:1204] = (self.us % 3_600_000_000).to_bytes(4, "little")
        return payload

    def run(self):
        due, number, held = time.monotonic(), 0, None
        while not self.stop.is_set():
            now = time.monotonic()
            if now < due:
                time.sleep(min(0.004, due - now))
                continue
            due += self.period
            payload = self.stamped(number)
            number += 1
            place = number % LOST["every"] if self.spoil else None
            if place is not None and place < LOST["bursts"]:
                self.lost += 1
                continue
            if place == 250:
                held = bytes(payload)  # comes after the next one
                continue
            self.send(payload)
            if held:
                self.send(held)
                held = None
            if place == 400:
                self.send(payload)

    def send(self, payload):
        try:
            self.sender.sendto(payload, ("192.168.1.100", 2368))
            self.sent += 1
        except OSError:
            pass  # there is no cable


class Vehicle:
    def __init__(self, network, tmp):
        self.network, self.tmp, self.port = network, tmp, free_port()
        self.file = tmp / "c.yaml"
        self.file.write_text(CONFIG)
        lidars.SCENES.update({name: f"model: {model}, from: '{address}:{2368 if 'velodyne' in model else 6060}', to: '192.168.1.100:{port}'"
                              for name, (model, address, port) in MORE.items()})
        lidars.ADDRESSES.update({name: address for name, (_, address, _) in MORE.items()})
        self.plug()
        self.clock = Clock(tmp / "clock")
        self.faults = {"master": 0, "cable": 0, "reload": 0, "clock": 0}

    def plug(self):
        self.network.plug(lidars=[address + "/24" for address in lidars.ADDRESSES.values()])

    def start_lidars(self, seconds):
        for name, keys in lidars.SCENES.items():
            if name != "roof":
                self.network.start_sim(self.tmp, name, keys, seconds)

    def all_well(self, limit=30):
        def ill():
            status = ask("status")
            return [f"{one['name']}: {one['message']}" for one in status["items"]
                    if one["level"] == "ERROR" or (one["level"] == "WARN" and one["name"].startswith("link"))] if status else ["no answer"]
        wait_for(lambda: not ill(), limit, Now(lambda: f"all is well again: {ill()}"))


def all_events(source):
    """How often a source's state came to each level so far. Repeats share a row, so the order of rows is not that of time."""
    answer = ask("events")
    expect(answer["forgotten"] == 0, f"{answer['forgotten']} events are forgotten")
    levels = collections.Counter()
    for event in answer["events"]:
        if event["source"] == source:
            levels[event["level"]] += event["count"]
    return levels


def resources(child):
    return kilobytes(child.pid, "VmRSS"), descriptors(child.pid)


def one_round(vehicle, child, roof, number):
    """One of each fault, and time between them in which all is well again."""
    roof.spoil = True
    time.sleep(4)  # six bursts
    roof.spoil = False
    vehicle.faults["clock"] += 1
    vehicle.clock.set_by((-1) ** number * (1.013 if number % 3 else 3600))
    time.sleep(1)  # two faults, not one
    vehicle.network.unplug()
    time.sleep(4)  # silence becomes an ERROR after 3 s
    vehicle.plug()
    vehicle.faults["cable"] += 1
    vehicle.all_well()
    vehicle.file.write_text(CONFIG + (OTHER if number % 2 == 0 else ""))
    child.send_signal(signal.SIGHUP)
    vehicle.faults["reload"] += 1
    wait_for(lambda: int(figure("configuration", "Reloads")) == vehicle.faults["reload"], 10, "the reload")
    vehicle.all_well()


class Counts:
    """What the daemon counts of the roof, and the events, since this was made."""

    def __init__(self, roof):
        self.roof, self.spoiled = roof, roof.lost
        self.lost, self.drops, self.events = int(figure("sensor roof", "Lost packets")), int(figure("port 2368", "Kernel drops")), all_events("sensor roof")

    def read(self):
        """Packets left out, counted as lost and dropped by the kernel since then, and events."""
        return (self.roof.lost - self.spoiled, int(figure("sensor roof", "Lost packets")) - self.lost,
                int(figure("port 2368", "Kernel drops")) - self.drops, all_events("sensor roof") - self.events)


def main():
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 30
    network = Network()
    with folder() as tmp:
        vehicle = Vehicle(network, tmp)
        use_master_at(vehicle.port)
        roof, starved = Roof(network, tmp), Starved()
        with daemon(vehicle.file, env=dict(vehicle.clock.environment(), STATE_DIRECTORY=str(tmp / "state"))) as child:
            vehicle.start_lidars(seconds + 600)
            roof.thread.start()
            begin, rounds, warm = time.monotonic(), 0, None
            # Every second round has virtual scans: compared is what is alike.
            while time.monotonic() - begin < seconds or rounds < 4 or rounds % 2:
                with ros_master(vehicle.port):
                    vehicle.faults["master"] += 1
                    well("ROS")
                    vehicle.all_well()
                    counts = Counts(roof)
                    one_round(vehicle, child, roof, rounds)
                    left_out, counted, dropped, events = counts.read()
                rounds += 1
                now = resources(child)
                # The heap finds its size within the first fifth of the time.
                if rounds % 2 == 0 and (warm is None or time.monotonic() - begin < seconds / 5):
                    warm = now
                print(f"round {rounds} after {time.monotonic() - begin:.0f} s: {now[0]} kB, {now[1]} descriptors, left out {left_out}, counted "
                      f"{counted}, dropped by the kernel {dropped}; events of the roof {dict(events)}", flush=True)
                # What the cable did not carry is counted too; nothing that was left out is forgotten.
                expect(counted >= left_out, f"{left_out} packets were left out, {counted} counted")
                expect(events["ERROR"] == 1, f"the unplugged cable is one ERROR of the roof: {events}; {events_of('sensor roof')}")
            check_end(vehicle, child, warm, LARGEST_GROWTH if seconds >= 600 else SHORT_GROWTH)
            roof.stop.set()
        print(f"starved for {starved.seconds():.1f} s; ok")


def check_end(vehicle, child, warm, most):
    rss, open_files = resources(child)
    print(f"grown by {rss - warm[0]} kB and {open_files - warm[1]} descriptors since it was warm; faults {vehicle.faults}")
    expect(rss - warm[0] <= most, f"memory grows: {warm[0]} kB, then {rss}, by more than {most} kB")
    expect(open_files - warm[1] <= 2, f"descriptors: {warm[1]}, then {open_files}")
    steps = all_events("clock")["WARN"]
    expect(steps == vehicle.faults["clock"], f"{vehicle.faults['clock']} steps of the clock, {steps} events")
    expect(item("clock")["values"]["Steps"] == str(vehicle.faults["clock"]), str(item("clock")))
    expect(child.poll() is None, "the daemon lives")


if __name__ == "__main__":
    main()
