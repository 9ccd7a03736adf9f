#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The fault table: for each fault the first sentence that an operator sees, the same on /diagnostics, in `lidard status` and in
`lidard events`, and within how many seconds. A real daemon, a real ROS master, lidars behind cables of their own."""
import collections
import contextlib
import json
import os
import pathlib
import re
import signal
import socket
import subprocess
import sys
import threading
import time
import xmlrpc.client

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from faults import CABLE, MAY_BE_SECOND, MIDDLEWARE, NOT_TESTED
from harness import LIDARD, LIDARD_SIM, Starved, expect, folder, free_port, process, ros_master, run, use_master_at, wait_for
from network import Network, ask, recorded
from sensor_msgs.msg import Imu, LaserScan

HOST = "192.168.1.100"
VLP16 = "start: 2026-01-01T00:00:00Z\nduration: {seconds}\nobjects:\n  - wall: {{from: [4, -30], to: [4, 30], z: [-5, 5]}}\nsensors:\n" \
        "  roof: {{model: velodyne_{model}, from: '192.168.1.201:2368', to: '192.168.1.100:2368'}}\n"


def plain(text):
    """A sentence without its figures, which change while it stays the same."""
    return re.sub(r"[0-9]+", "", text)


class Watch:
    """When which sentence was first seen where. A sentence counts once more after another one of its item."""

    def __init__(self):
        self.seen = collections.defaultdict(list)  # (place, item) -> [(time, level, sentence)]
        self.events, self.ended = set(), threading.Event()
        rospy.Subscriber("/diagnostics", DiagnosticArray, self.diagnostics, queue_size=100)
        self.thread = threading.Thread(target=self.poll, daemon=True)
        self.thread.start()

    def note(self, place, name, level, text):
        known = self.seen[place, name]
        if not known or (known[-1][1], plain(known[-1][2])) != (level, plain(text)):
            known.append((time.monotonic(), level, text))

    def diagnostics(self, array):
        for status in array.status:
            self.note("/diagnostics", status.name.split(": ", 1)[-1], ("OK", "WARN", "ERROR", "STALE")[status.level], status.message)

    def poll(self):
        while not self.ended.wait(0.1):
            for one in (ask("status") or {"items": []})["items"]:
                self.note("status", one["name"], one["level"], one["message"])
            events = (ask("events") or {"events": []})["events"]
            for event in events:
                if (key := (event["source"], event["level"], event["at"])) not in self.events:
                    self.note("events", event["source"], event["level"], event["text"])
                    self.events.add(key)

    def first(self, place, fault, since):
        """The first sentence of that level since the fault; where that is another one, the right one if it came later."""
        told = [one for one in list(self.seen[place, fault.item]) if one[0] >= since and one[1] == fault.level]
        return next((one for one in told if fault.text in one[2]), told[0] if told else None)

    def before(self, place, fault, since, then):
        """What was told of the item between the fault and its sentence, and is no good news."""
        return [one[2] for one in list(self.seen[place, fault.item]) if since <= one[0] < then and one[1] != "OK"]

    def end(self):
        self.ended.set()
        self.thread.join()


PLACES = ("/diagnostics", "status", "events")


class Table:
    """Does faults and prints what was seen of them."""

    def __init__(self, watch):
        self.watch, self.failures, self.rows = watch, [], 0

    def check(self, faults, begun):
        """`begun`: by key of the fault, when it began and what was starved since."""
        for fault in faults:
            since, starved = begun[fault.key]
            end = time.monotonic() + 10 + max(0, since + fault.seconds - time.monotonic())
            seen = lambda: [self.watch.first(place, fault, since) for place in PLACES]
            while not all(one and fault.text in one[2] for one in seen()) and time.monotonic() < end:
                time.sleep(0.05)
            self.judge(fault, since, seen(), starved.seconds())

    def judge(self, fault, since, seen, starved):
        self.rows += 1
        times = [f"{one[0] - since:5.2f}" if one else "    -" for one in seen]
        for place, one in zip(PLACES, seen):
            other = self.watch.before(place, fault, since, one[0]) if one else []
            if other and fault.key not in MAY_BE_SECOND and starved < 0.3:
                self.failures.append(f"{fault.what}: {place} says first: {other}")
        sentence = next((one[2] for one in seen if one), "nothing")
        print(f"{self.rows:2} {fault.what:45} {' '.join(times)} s (<= {fault.seconds}, starved {starved:.2f})  {fault.item}: {fault.level}: {sentence}")
        for place, one in zip(PLACES, seen):
            if one is None or fault.text not in one[2]:
                self.failures.append(f"{fault.what}: {place} says {one and one[2]!r} instead of {fault.text!r}")
            elif one[0] - since > fault.seconds + 0.15 + starved:  # 0.1 s is the period of this test's own questions
                self.failures.append(f"{fault.what}: {place} after {one[0] - since:.2f} s instead of {fault.seconds}, starved {starved:.2f}")


def began():
    return time.monotonic(), Starved()


class Lidars(threading.Thread):
    """Sends recorded packets at their pace from as many addresses as are wanted."""

    def __init__(self, network, packets, strange):
        super().__init__(daemon=True)
        self.network, self.packets, self.strange, self.streams, self.ended = network, packets, strange, {}, threading.Event()

    def add(self, address, port, to=HOST, change=lambda payload, number: payload, strange=False):
        self.streams[address] = [self.network.lidar(address), (to, port), change, self.strange if strange else self.packets]

    def run(self):
        begin, place = time.monotonic(), 0
        while not self.ended.wait(0.004) and place < len(self.packets):
            first, now = place, time.monotonic() - begin
            while place < len(self.packets) and self.packets[place][0] <= now:
                place += 1
            for sender, to, change, packets in list(self.streams.values()):
                for number in range(first, place):
                    payload = change(packets[number % len(packets)][3], number)
                    with contextlib.suppress(OSError):  # no cable
                        if payload:
                            sender.sendto(payload, to)


CABLE_CONFIG = """\
vehicle: {odometry_topic: /odom}
sensors:
  front: {model: sick_microscan3, ip_address: 192.168.1.21, listen_only: true}
  left: {model: hokuyo_ust_10lx, ip_address: 192.168.1.10}
  right: {model: sick_lms1xx, ip_address: 192.168.1.11}
  dirty: {model: hokuyo_uam_05lp, ip_address: 192.168.1.12}
  cut: {model: velodyne_vlp16, ip_address: 192.168.2.201}
  off: {model: velodyne_vlp16, ip_address: 192.168.3.201}
  bare: {model: velodyne_vlp16, ip_address: 192.168.4.201}
  lossy: {model: velodyne_vlp16, ip_address: 192.168.1.202}
  lossier: {model: velodyne_vlp16, ip_address: 192.168.1.203}
  broken: {model: velodyne_vlp16, ip_address: 192.168.1.204}
  other: {model: velodyne_vlp16, ip_address: 192.168.1.205}
  shared: {model: velodyne_vlp16, ip_port: 2410}
  misnamed: {model: velodyne_vlp16, ip_address: 192.168.1.30, ip_port: 2411}
  elsewhere: {model: velodyne_vlp16, ip_address: 192.168.1.209, ip_port: 2412}
  taken: {model: velodyne_vlp16, ip_address: 192.168.1.41, ip_port: 2413}
  absent: {model: velodyne_vlp16, ip_address: 192.168.1.40, ip_port: 2414}
  group: {model: velodyne_vlp16, ip_address: 192.168.1.42, ip_port: 2415, multicast_group: 239.1.2.3, interface: nothere0}
"""
DEVICES = {
    "front": ("sick_microscan3", "192.168.1.21:6060", HOST + ":6060", ""),
    "left": ("hokuyo_ust_10lx", "192.168.1.10:10940", HOST + ":40001", ""),
    "right": ("sick_lms1xx", "192.168.1.11:2112", HOST + ":40002", ""),
    "dirty": ("hokuyo_uam_05lp", "192.168.1.12:10940", HOST + ":40003", ", options: {contaminated: true}"),
}


def start_device(network, tmp, name):
    model, source, to, more = DEVICES[name]
    scene = tmp / f"{name}.yaml"
    scene.write_text("start: 2026-01-01T00:00:00Z\nduration: 300\nobjects:\n  - wall: {from: [4, -30], to: [4, 30], z: [-5, 5]}\n"
                     f"sensors:\n  {name}: {{model: {model}, from: '{source}', to: '{to}'{more}}}\n")
    address = source.split(":")[0]
    return network.start_lidar([LIDARD_SIM, "live", str(scene)] + ([f"--source-map={address}={address}"] if name == "front" else []))


def level(name):
    status = ask("status") or {"items": []}
    return next((one["level"] for one in status["items"] if one["name"] == name), None)


def well(*names):
    wait_for(lambda: all(level("sensor " + name) == "OK" for name in names), 15, f"{names} are well: {[level('sensor ' + n) for n in names]}")


@contextlib.contextmanager
def daemon(tmp, name, **environment):
    file = tmp / f"{name}.log"
    with file.open("w") as log, process([LIDARD, "run", "-c", tmp / f"{name}.yaml"], stdout=log, stderr=subprocess.STDOUT,
                                        env={**os.environ, **environment}) as child:
        try:
            yield child
        finally:
            ended = child.poll()
            if ended is not None:
                print(f"the daemon ended with {ended}:\n" + "".join(file.read_text().splitlines(True)[-40:]))


def plug_cables(network):
    network.plug(host=HOST + "/24", lidars=["192.168.1.21/24", "192.168.1.11/24", "192.168.1.12/24", "192.168.1.10/24"]
                 + [f"192.168.1.{n}/24" for n in (66, 202, 203, 204, 205, 206, 207, 208, 209)])
    for n in (1, 2, 3):
        network.plug(host=f"192.168.{n + 1}.100/24", lidars=[f"192.168.{n + 1}.201/24"], name=f"lidar{n}")


def corrupt(payload, number):
    return payload if number % 5 else payload[:400]


def faults_of_cables(network, tmp, watch, table):
    plug_cables(network)
    (tmp / "cable.yaml").write_text(CABLE_CONFIG)
    lidars = Lidars(network, recorded(tmp, VLP16.format(seconds=60, model="vlp16")), recorded(tmp, VLP16.format(seconds=2, model="vlp32c")))
    for address, port, to in (("192.168.2.201", 2368, "192.168.2.100"), ("192.168.3.201", 2368, "192.168.3.100"),
                              ("192.168.4.201", 2368, "192.168.4.100"), ("192.168.1.202", 2368, HOST), ("192.168.1.203", 2368, HOST),
                              ("192.168.1.204", 2368, HOST), ("192.168.1.206", 2410, HOST), ("192.168.1.207", 2410, HOST), ("192.168.1.208", 2411, HOST)):
        lidars.add(address, port, to)
    lidars.add("192.168.1.205", 2368, strange=True)
    devices = {name: start_device(network, tmp, name) for name in DEVICES}
    wait_for(lambda: all(network.lidar_talks(child) for child in devices.values()), 10, "the devices talk")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other_program:
        other_program.bind(("0.0.0.0", 2413))
        lidars.start()
        start = began()
        with daemon(tmp, "cable") as child:
            present = [f for f in CABLE if f.key in ("taken", "absent", "other", "shared", "misnamed", "dirty", "group", "no_odometry")]
            table.check(present, {f.key: start for f in present})
            check_commands(watch, "sensor other")
            well("front", "left", "right", "cut", "off", "bare", "lossy", "lossier", "broken")
            time.sleep(7)  # one second without frames is a tenth of 10 s: silence is told before
            cut_off(network, lidars, devices, table)
            spoil(lidars, table)
            time.sleep(1)
            stop(child, table)
            lidars.ended.set()


def cut_off(network, lidars, devices, table):
    begun = {}
    for key in ("cut", "off", "bare", "silent", "refused", "half_open"):
        begun[key] = began()
        if key == "cut":
            network.lidars("link", "set", "dev-lidar1", "down")
        elif key == "off":
            network.host("link", "set", "lidar2", "down")
        elif key == "bare":
            network.host("address", "delete", "192.168.4.100/24", "dev", "lidar3")
        elif key == "half_open":
            network.lidars("address", "delete", "192.168.1.10/24", "dev", "dev-lidar0")
        else:
            devices["front" if key == "silent" else "right"].kill()
    table.check([f for f in CABLE if f.key in begun], begun)


def spoil(lidars, table):
    begin = began()
    for address, change in (("192.168.1.202", lambda p, n: p if n % 50 else None), ("192.168.1.203", lambda p, n: p if n % 10 else None),
                            ("192.168.1.204", corrupt)):
        lidars.streams[address][2] = change
    lidars.add("192.168.1.66", 2368)
    lidars.add("192.168.1.209", 2499)
    keys = ("lossy", "lossier", "broken", "stranger", "elsewhere")
    table.check([f for f in CABLE if f.key in keys], {key: begin for key in keys})


def stop(child, table):
    child.send_signal(signal.SIGSTOP)
    time.sleep(2.5)
    child.send_signal(signal.SIGCONT)
    table.check([f for f in CABLE if f.key == "stopped"], {"stopped": began()})


MIDDLEWARE_CONFIG = """\
sensors:
  left: {{model: sick_microscan3, ip_address: 127.168.0.21, ip_port: {ms3}, listen_only: true, pose: {{xyz: [0, 1, 0.3]}}}}
  right: {{model: sick_microscan3, ip_address: 127.168.0.22, ip_port: {ms3}, listen_only: true, pose: {{xyz: [0, -1, 0.3]}}}}
  crooked: {{model: sick_microscan3, ip_address: 127.168.0.23, ip_port: {ms3}, listen_only: true, pose: {{xyz: [0, 0, 0.3], rpy_deg: [0, 0, 1]}}}}
  roof: {{model: velodyne_vlp16, ip_address: 127.168.1.201, ip_port: {roof}, pose: {{xyz: [0, 0, 2]}}}}
  full: {{model: velodyne_vlp16, ip_address: 127.168.1.202, ip_port: {roof}, pose: {{xyz: [0, 0, 2]}}}}
  odd: {{topic: /odd, pose: {{xyz: [0, 0, 0.3]}}}}
  bad: {{topic: /bad, pose: {{xyz: [0, 0, 0.3]}}}}
  lone: {{topic: /lone, pose: {{xyz: [0, 0, 0.3]}}}}
merged_scans:
  around: {{laserscan_topics: [left, right]}}
  bent: {{laserscan_topics: [left, crooked], profile: strict, range_max: 24}}
  astray: {{laserscan_topics: [left, odd, bad, lone], destination_frame: nowhere}}
virtual_scans:
  levels: {{cloud_topic: roof, virtual_laser_scan: [low], poses: {{low: {{xyz: [0, 0, 0.4]}}}}, beams: 720}}
blackbox: {{seconds: 5, on_error: false, path: {tmp}/file/box}}
"""
ROOM = """\
start: 2026-01-01T00:00:00Z
duration: 300
objects:
  - wall: {from: [6, -7], to: [6, 8], z: [-1, 4]}
  - wall: {from: [-6, 7], to: [8, 7], z: [-1, 4]}
sensors:
"""


def start_sim(stack, tmp, name, ports, sensors):
    (tmp / f"{name}.yaml").write_text(ROOM + "".join(line.format(**ports) for line in sensors))
    return stack.enter_context(process([LIDARD_SIM, "live", tmp / f"{name}.yaml"], stdout=subprocess.DEVNULL))


def publish_oddly(stop_it):
    """A topic of another type than expected, and scans that cannot be right."""
    odd = rospy.Publisher("/odd", Imu, queue_size=1)
    bad = rospy.Publisher("/bad", LaserScan, queue_size=1)
    while not stop_it.wait(0.1):
        odd.publish(Imu())
        bad.publish(LaserScan(angle_increment=0, ranges=[1.0] * 5))


def set_clock(tmp, step):
    file = tmp / "clock"
    with file.open("r+b" if file.exists() else "wb") as clock:  # the daemon has it mapped: SIGBUS where it is shorter for a moment
        clock.write(int(step * 1e9).to_bytes(8, "little", signed=True))


def faults_of_middleware(tmp, watch, table, stack, master_port, master):
    ports = {"ms3": free_port(socket.SOCK_DGRAM), "roof": free_port(socket.SOCK_DGRAM)}
    (tmp / "file").write_text("no folder")
    good = MIDDLEWARE_CONFIG.format(tmp=tmp, **ports)
    (tmp / "ros.yaml").write_text(good)
    set_clock(tmp, 0)
    start_sim(stack, tmp, "always", ports, [
        "  left: {{model: sick_microscan3, from: '192.168.0.21:6060', to: '127.0.0.1:{ms3}', pose: {{xyz: [0, 1, 0.3]}}}}\n",
        "  crooked: {{model: sick_microscan3, from: '192.168.0.23:6060', to: '127.0.0.1:{ms3}', pose: {{xyz: [0, 0, 0.3]}}}}\n",
        "  full: {{model: velodyne_vlp16, from: '192.168.1.202:2368', to: '127.0.0.1:{roof}', pose: {{xyz: [0, 0, 2]}}}}\n"])
    mortal = start_sim(stack, tmp, "mortal", ports, [
        "  right: {{model: sick_microscan3, from: '192.168.0.22:6060', to: '127.0.0.1:{ms3}', pose: {{xyz: [0, -1, 0.3]}}}}\n",
        "  roof: {{model: velodyne_vlp16, from: '192.168.1.201:2368', to: '127.0.0.1:{roof}', pose: {{xyz: [0, 0, 2]}}}}\n"])
    stop_it = threading.Event()
    threading.Thread(target=publish_oddly, args=(stop_it,), daemon=True).start()
    slow = stack.enter_context(process(["/usr/bin/python3", "-c", "import rospy; from sensor_msgs.msg import PointCloud2\n"
                                        "rospy.init_node('slow', anonymous=True)\n"
                                        "rospy.Subscriber('/full/points', PointCloud2, lambda m: None, queue_size=1)\nrospy.spin()"]))
    shim = {"LD_PRELOAD": os.environ["LIDARD_CLOCK_SHIM"], "LIDARD_TEST_CLOCK": str(tmp / "clock")}

    def fault(key, do):
        begin = began()
        do()
        table.check([f for f in MIDDLEWARE if f.key == key], {key: begin})

    def reload(text):
        (tmp / "ros.yaml").write_text(text)
        child.send_signal(signal.SIGHUP)

    start = began()
    with daemon(tmp, "ros", **shim) as child:
        present = [f for f in MIDDLEWARE if f.key in ("wrong_type", "nobody", "unusable", "no_pose", "mount")]
        table.check(present, {f.key: start for f in present})
        check_commands(watch, "odd input")
        well("left", "right", "roof", "full")
        wait_for(lambda: int(next(i for i in ask("status")["items"] if i["name"] == "ROS")["values"]["Subscribers"]) > 0, 10, "a subscriber")
        slow.send_signal(signal.SIGSTOP)
        standing = began()
        mortal.kill()
        gone = began()
        table.check([f for f in MIDDLEWARE if f.key in ("no_cloud", "no_source")], {"no_cloud": gone, "no_source": gone})
        fault("box", lambda: run("dump"))
        fault("key", lambda: reload(good.replace("beams: 720", "beans: 720")))
        reload(good)
        wait_for(lambda: level("configuration") == "OK", 5, "the good configuration")
        fault("calibration", lambda: reload(good.replace("ip_port: %d, pose: {xyz: [0, 0, 2]}" % ports["roof"],
                                                         "ip_port: %d, calibration: nowhere.yaml, pose: {xyz: [0, 0, 2]}" % ports["roof"], 1)))
        reload(good)
        fault("clock", lambda: set_clock(tmp, 1.5))
        table.check([f for f in MIDDLEWARE if f.key == "slow"], {"slow": standing})
        fault_of_master(fault, master, master_port)
    stop_it.set()


def fault_of_master(fault, master, port):
    uri = xmlrpc.client.ServerProxy(f"http://127.0.0.1:{port}").lookupNode("/test", "/lidard")[2]
    fault("shutdown", lambda: xmlrpc.client.ServerProxy(uri).shutdown("/test", "a test"))
    time.sleep(1)
    wait_for(lambda: level("ROS") is not None, 10, "ROS")
    fault("hung", lambda: master.send_signal(signal.SIGSTOP))
    master.send_signal(signal.SIGCONT)
    wait_for(lambda: (ask("status") and "does not answer" not in next(i["message"] for i in ask("status")["items"] if i["name"] == "ROS")), 10,
             "the master answers")
    time.sleep(1)
    fault("away", lambda: (master.kill(), master.wait()))


def check_commands(watch, item):
    """The commands say of an item what was read from their socket."""
    status, events = (json.loads(run(word, "--json").stdout) for word in ("status", "events"))
    said = {one["name"]: one for one in status["items"]}[item]
    told = [event for event in events["events"] if event["source"] == item][-1]
    for place, level_now, text in (("status", said["level"], said["message"]), ("events", told["level"], told["text"])):
        known = [(one[1], plain(one[2])) for one in watch.seen[place, item]]
        expect((level_now, plain(text)) in known, f"lidard {place} says {level_now} {text}, read before: {known}")


def main():
    network = Network()
    master_port = free_port()
    use_master_at(master_port)
    print(f"seconds until it is on {', in '.join(PLACES)}")
    with folder() as tmp, contextlib.ExitStack() as stack:
        master = stack.enter_context(ros_master(master_port))
        rospy.init_node("listener", disable_signals=True, anonymous=True)
        watch = Watch()
        table = Table(watch)
        faults_of_cables(network, tmp, watch, table)
        faults_of_middleware(tmp, watch, table, stack, master_port, master)
        watch.end()
    for what, why in NOT_TESTED.items():
        print(f"not tested: {what}: {why}")
    expect(not table.failures, "\n  ".join(["", *table.failures]))
    print(f"{table.rows} faults, ok")


if __name__ == "__main__":
    main()
