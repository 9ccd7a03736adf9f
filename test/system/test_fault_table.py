#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The fault table: for each fault the first sentence that an operator sees, the same on /diagnostics, in `lidard status` and in
`lidard events`, and within how many seconds. A real daemon, a real ROS master, lidars behind cables of their own."""
import collections
import contextlib
import json
import re
import shutil
import signal
import socket
import threading
import time
import xmlrpc.client

import rospy
from faults import CABLE, MAY_BE_SECOND, MIDDLEWARE, NOT_TESTED, WELL
from harness import (Clock, Starved, ask, daemon, expect, figure, free_port, item, level, process, run, scene_of, sim, wait_for, well,
                     write)
from nav_msgs.msg import Odometry
from network import Network, recorded
from ros_tools import Diagnostics, Talker, ros_test, wall_scan
from sensor_msgs.msg import Imu, LaserScan

HOST = "192.168.1.100"


def roof(model, seconds):
    return scene_of({"roof": f"model: velodyne_{model}, from: '192.168.1.201:2368', to: '{HOST}:2368'"}, seconds=seconds)


def plain(text):
    """A sentence without its figures, which change while it stays the same."""
    return re.sub(r"[0-9]+", "", text)


class Watch:
    """When which sentence was first seen where. A sentence counts once more after another one of its item."""

    def __init__(self):
        self.seen = collections.defaultdict(list)  # (place, item) -> [(time, level, sentence)]
        self.events, self.ended = set(), threading.Event()
        Diagnostics(lambda name, status: self.note("/diagnostics", name, ("OK", "WARN", "ERROR", "STALE")[status.level], status.message))
        self.thread = threading.Thread(target=self.poll, daemon=True)
        self.thread.start()

    def note(self, place, name, level, text):
        known = self.seen[place, name]
        if not known or (known[-1][1], plain(known[-1][2])) != (level, plain(text)):
            known.append((time.monotonic(), level, text))

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
        seen = [one for one in list(self.seen[place, fault.item]) if one[0] >= since and one[1] == fault.level]
        return next((one for one in seen if fault.text in one[2]), seen[0] if seen else None)

    def before(self, place, fault, since, then):
        """What was said of the item between the fault and its sentence, and is no good news."""
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
        """`begun`: by key of the fault, when it began and what was starved since; the other faults have their turn later."""
        for fault in (one for one in faults if one.key in begun):
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


def begin(do):
    """Does a fault. It begins while `do` runs: a change of the network may wait for seconds for those of other tests."""
    since, starved = began()
    do()
    starved.add(time.monotonic() - since)
    return since, starved


class Lidars(threading.Thread):
    """Sends recorded packets at their pace from as many addresses as are wanted."""

    def __init__(self, network, packets, strange):
        super().__init__(daemon=True)
        self.network, self.packets, self.strange, self.streams, self.ended = network, packets, strange, {}, threading.Event()

    def add(self, address, port, to=HOST, change=lambda payload, number: payload, strange=False):
        key = address if address not in self.streams else address + " again"
        self.streams[key] = [self.network.lidar(address, 2368 if key == address else 2369), (to, port), change, self.strange if strange else self.packets]

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
  twins: {model: velodyne_vlp16, ip_address: 192.168.1.210}
  unlike: {model: velodyne_vlp16, ip_address: 192.168.1.211}
  misnamed: {model: velodyne_vlp16, ip_address: 192.168.1.30, ip_port: 2411}
  elsewhere: {model: velodyne_vlp16, ip_address: 192.168.1.209, ip_port: 2412}
  taken: {model: velodyne_vlp16, ip_address: 192.168.1.41, ip_port: 2413}
  absent: {model: velodyne_vlp16, ip_address: 192.168.1.40, ip_port: 2414}
  group: {model: velodyne_vlp16, ip_address: 192.168.1.42, ip_port: 2415, multicast_group: 239.1.2.3, interface: nothere0}
"""
DEVICES = {
    "front": f"model: sick_microscan3, from: '192.168.1.21:6060', to: '{HOST}:6060'",
    "left": f"model: hokuyo_ust_10lx, from: '192.168.1.10:10940', to: '{HOST}:40001'",
    "right": f"model: sick_lms1xx, from: '192.168.1.11:2112', to: '{HOST}:40002'",
    "dirty": f"model: hokuyo_uam_05lp, from: '192.168.1.12:10940', to: '{HOST}:40003', options: {{contaminated: true}}",
}


@contextlib.contextmanager
def tested(config, **options):
    """A daemon; the end of its log is shown if it ends by itself."""
    with daemon(config, **options) as child:
        try:
            yield child
        finally:
            if child.poll() is not None:
                print(f"the daemon ended with {child.poll()}:\n" + "".join(child.said().splitlines(True)[-40:]))


def plug_cables(network):
    network.plug(host=HOST + "/24", lidars=["192.168.1.21/24", "192.168.1.11/24", "192.168.1.12/24", "192.168.1.10/24"]
                 + [f"192.168.1.{n}/24" for n in (66, 202, 203, 204, 205, 206, 207, 208, 209, 210, 211)])
    for n in (1, 2, 3):
        network.plug(host=f"192.168.{n + 1}.100/24", lidars=[f"192.168.{n + 1}.201/24"], name=f"lidar{n}")


def half_a_minute_later(payload, number):
    """The packet as of a lidar with another clock, at the same angle."""
    return payload[:1200] + ((int.from_bytes(payload[1200:1204], "little") + 30_000_000) % 3_600_000_000).to_bytes(4, "little") + payload[1204:]


def corrupt(payload, number):
    return payload if number % 5 else payload[:400]


def faults_of_cables(network, tmp, watch, table):
    plug_cables(network)
    config = write(tmp / "cable.yaml", CABLE_CONFIG)
    lidars = Lidars(network, recorded(tmp, roof("vlp16", 60)), recorded(tmp, roof("vlp32c", 2)))
    for address, port, to in (("192.168.2.201", 2368, "192.168.2.100"), ("192.168.3.201", 2368, "192.168.3.100"),
                              ("192.168.4.201", 2368, "192.168.4.100"), ("192.168.1.202", 2368, HOST), ("192.168.1.203", 2368, HOST),
                              ("192.168.1.204", 2368, HOST), ("192.168.1.206", 2410, HOST), ("192.168.1.207", 2410, HOST), ("192.168.1.208", 2411, HOST)):
        lidars.add(address, port, to)
    lidars.add("192.168.1.205", 2368, strange=True)
    for address in ("192.168.1.210", "192.168.1.211"):
        lidars.add(address, 2368)
    lidars.add("192.168.1.210", 2368, change=half_a_minute_later)
    lidars.add("192.168.1.211", 2368, strange=True)
    devices = {name: network.start_sim(tmp, name, keys) for name, keys in DEVICES.items()}
    wait_for(lambda: all(network.lidar_talks(child) for child in devices.values()), 10, "the devices talk")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other_program:
        other_program.bind(("0.0.0.0", 2413))
        lidars.start()
        start = began()
        with tested(config) as child:
            table.check(CABLE, dict.fromkeys(("taken", "absent", "twins", "unlike", "other", "shared", "misnamed", "dirty", "group", "no_odometry"), start))
            check_commands(watch, "sensor other")
            odometry_ends(table)
            well(*(f"sensor {name}" for name in ("front", "left", "right", "cut", "off", "bare", "lossy", "lossier", "broken")))
            time.sleep(7)  # one second without frames is a tenth of 10 s: silence is reported before
            cut_off(network, lidars, devices, table)
            spoil(lidars, table)
            time.sleep(1)  # so that packets of all wait
            stop(child, table)
            lidars.ended.set()


def odometry_ends(table):
    odometry = Odometry(child_frame_id="base_link")
    odometry.header.frame_id, odometry.pose.pose.orientation.w = "odom", 1
    talker = Talker("/odom", odometry, 50)
    wait_for(lambda: item("motion")["message"] == "poses come in", 10, "poses come in")
    table.check(CABLE, {"odometry_ends": begin(talker.close)})


def cut_off(network, lidars, devices, table):
    faults = {
        "cut": lambda: network.lidars("link", "set", "dev-lidar1", "down"),
        "off": lambda: network.host("link", "set", "lidar2", "down"),
        "bare": lambda: network.host("address", "delete", "192.168.4.100/24", "dev", "lidar3"),
        "silent": devices["front"].kill,
        "refused": devices["right"].kill,
        "half_open": lambda: network.lidars("address", "delete", "192.168.1.10/24", "dev", "dev-lidar0"),
    }
    table.check(CABLE, {key: begin(do) for key, do in faults.items()})


def spoil(lidars, table):
    start = began()
    for address, change in (("192.168.1.202", lambda p, n: p if n % 50 else None), ("192.168.1.203", lambda p, n: p if n % 10 else None),
                            ("192.168.1.204", corrupt)):
        lidars.streams[address][2] = change
    lidars.add("192.168.1.66", 2368)
    lidars.add("192.168.1.209", 2499)
    table.check(CABLE, dict.fromkeys(("lossy", "lossier", "broken", "stranger", "elsewhere"), start))


def stop(child, table):
    child.send_signal(signal.SIGSTOP)
    time.sleep(2.5)  # the buffer holds half a second
    child.send_signal(signal.SIGCONT)
    table.check(CABLE, {"stopped": began()})


MIDDLEWARE_CONFIG = """\
sensors:
  left: {{model: sick_microscan3, ip_address: 127.168.0.21, ip_port: {ms3}, listen_only: true, pose: {{xyz: [0, 1, 0.3]}}}}
  right: {{model: sick_microscan3, ip_address: 127.168.0.22, ip_port: {ms3}, listen_only: true, pose: {{xyz: [0, -1, 0.3]}}}}
  crooked: {{model: sick_microscan3, ip_address: 127.168.0.23, ip_port: {ms3}, listen_only: true, pose: {{xyz: [0, 0, 0.3], rpy_deg: [0, 0, 1]}}}}
  far: {{model: sick_microscan3, ip_address: 127.168.0.24, ip_port: {ms3}, listen_only: true, pose: {{xyz: [0, 0, 0.3], rpy_deg: [0, 0, 8]}}}}
  reversed: {{model: sick_microscan3, ip_address: 127.168.0.25, ip_port: {ms3}, listen_only: true, pose: {{xyz: [0, 0, 0.3], rpy_deg: [0, 0, 90]}}}}
  roof: {{model: velodyne_vlp16, ip_address: 127.168.1.201, ip_port: {roof}, pose: {{xyz: [0, 0, 2]}}}}
  full: {{model: velodyne_vlp16, ip_address: 127.168.1.202, ip_port: {roof}, pose: {{xyz: [0, 0, 2]}}}}
  odd: {{topic: /odd, pose: {{xyz: [0, 0, 0.3]}}}}
  bad: {{topic: /bad, pose: {{xyz: [0, 0, 0.3]}}}}
  lone: {{topic: /lone, pose: {{xyz: [0, 0, 0.3]}}}}
  ahead: {{topic: /ahead, pose: {{xyz: [0, 0, 0.3]}}}}
merged_scans:
  around: {{laserscan_topics: [left, right]}}
  bent: {{laserscan_topics: [left, crooked], profile: strict, range_max: 24}}
  far_off: {{laserscan_topics: [left, far], profile: strict, range_max: 24}}
  astray_mount: {{laserscan_topics: [left, reversed], profile: strict, range_max: 24}}
  astray: {{laserscan_topics: [left, odd, bad, lone, ahead], destination_frame: nowhere}}
virtual_scans:
  levels: {{cloud_topic: roof, virtual_laser_scan: [low], poses: {{low: {{xyz: [0, 0, 0.4]}}}}, beams: 720}}
blackbox: {{seconds: 5, path: {tmp}/file/box}}
"""
ROOM = ("wall: {from: [6, -7], to: [6, 8], z: [-1, 4]}", "wall: {from: [-6, 7], to: [8, 7], z: [-1, 4]}")
# Sensors that send always, and those that end.
ALWAYS = {"left": "model: sick_microscan3, from: '192.168.0.21:6060', to: '127.0.0.1:{ms3}', pose: {{xyz: [0, 1, 0.3]}}",
          "crooked": "model: sick_microscan3, from: '192.168.0.23:6060', to: '127.0.0.1:{ms3}', pose: {{xyz: [0, 0, 0.3]}}",
          "far": "model: sick_microscan3, from: '192.168.0.24:6060', to: '127.0.0.1:{ms3}', pose: {{xyz: [0, 0, 0.3]}}",
          "reversed": "model: sick_microscan3, from: '192.168.0.25:6060', to: '127.0.0.1:{ms3}', pose: {{xyz: [0, 0, 0.3]}}",
          "full": "model: velodyne_vlp16, from: '192.168.1.202:2368', to: '127.0.0.1:{roof}', pose: {{xyz: [0, 0, 2]}}"}
MORTAL = {"right": "model: sick_microscan3, from: '192.168.0.22:6060', to: '127.0.0.1:{ms3}', pose: {{xyz: [0, -1, 0.3]}}",
          "roof": "model: velodyne_vlp16, from: '192.168.1.201:2368', to: '127.0.0.1:{roof}', pose: {{xyz: [0, 0, 2]}}"}
SLOW_SUBSCRIBER = """
import rospy
from sensor_msgs.msg import PointCloud2
rospy.init_node('slow', anonymous=True)
rospy.Subscriber('/full/points', PointCloud2, lambda m: None, queue_size=1)
rospy.spin()"""


def start_sim(stack, tmp, name, sensors, ports):
    scene = scene_of({sensor: keys.format(**ports) for sensor, keys in sensors.items()}, *ROOM, seconds=300)
    return stack.enter_context(sim(write(tmp / f"{name}.yaml", scene)))


def publish_oddly(stop_it):
    """A topic of another type than expected, scans that cannot be right, and scans of a computer with another clock."""
    odd = rospy.Publisher("/odd", Imu, queue_size=1)
    bad = rospy.Publisher("/bad", LaserScan, queue_size=1)
    ahead = Talker("/ahead", wall_scan("ahead", [4.0] * 300), offset=3600)
    while not stop_it.wait(0.1):
        odd.publish(Imu())
        bad.publish(LaserScan(angle_increment=0, ranges=[1.0] * 5))
    ahead.close()


def faults_of_middleware(tmp, watch, table, master):
    ports = {"ms3": free_port(socket.SOCK_DGRAM), "roof": free_port(socket.SOCK_DGRAM)}
    good = MIDDLEWARE_CONFIG.format(tmp=tmp, **ports)
    config, clock = write(tmp / "ros.yaml", good), Clock(tmp / "clock")

    def fault(key, do):
        table.check(MIDDLEWARE, {key: begin(do)})

    def no_folder():
        shutil.rmtree(tmp / "file")
        (tmp / "file").write_text("no folder")
        run("dump")

    def reload(text):
        write(config, text)
        child.send_signal(signal.SIGHUP)

    with contextlib.ExitStack() as stack:
        start_sim(stack, tmp, "always", ALWAYS, ports)
        mortal = start_sim(stack, tmp, "mortal", MORTAL, ports)
        stop_it = threading.Event()
        threading.Thread(target=publish_oddly, args=(stop_it,), daemon=True).start()
        stack.callback(stop_it.set)
        slow = stack.enter_context(process(["/usr/bin/python3", "-c", SLOW_SUBSCRIBER]))
        start = began()
        (tmp / "state").write_text("no folder")  # nothing can be written there, as on a full disk
        child = stack.enter_context(tested(config, env=dict(clock.environment(), STATE_DIRECTORY=str(tmp / "state"))))
        table.check(MIDDLEWARE, dict.fromkeys(("wrong_type", "nobody", "unusable", "ahead", "no_pose", "mount", "far_mount", "astray", "full_disk"), start))
        check_commands(watch, "odd input")
        for name, text in WELL.items():
            expect(any(text in one[2] for one in watch.seen["status", name]), f"{name} never says {text}: {watch.seen['status', name]}")
        (tmp / "state").unlink()
        wait_for(lambda: level("configuration") == "OK", 15, "the configuration is kept once there is room")
        well("sensor left", "sensor right", "sensor roof", "sensor full")
        wait_for(lambda: int(figure("ROS", "Subscribers")) > 0, 10, "a subscriber")
        slow.send_signal(signal.SIGSTOP)
        standing = began()
        mortal.kill()
        table.check(MIDDLEWARE, dict.fromkeys(("no_cloud", "no_source"), began()))
        fault("box", no_folder)
        fault("key", lambda: reload(good.replace("beams: 720", "beans: 720")))
        reload(good)
        wait_for(lambda: level("configuration") == "OK", 5, "the good configuration")
        fault("calibration", lambda: reload(good.replace("ip_port: %d, pose: {xyz: [0, 0, 2]}" % ports["roof"],
                                                         "ip_port: %d, calibration: nowhere.yaml, pose: {xyz: [0, 0, 2]}" % ports["roof"], 1)))
        reload(good)
        fault("clock", lambda: clock.set_by(1.5))
        table.check(MIDDLEWARE, {"slow": standing})
        fault_of_master(fault, master)


def fault_of_master(fault, master):
    uri = xmlrpc.client.ServerProxy(f"http://127.0.0.1:{master.port}").lookupNode("/test", "/lidard")[2]
    fault("shutdown", lambda: xmlrpc.client.ServerProxy(uri).shutdown("/test", "a test"))
    time.sleep(1)  # it starts again
    wait_for(lambda: level("ROS") is not None, 10, "ROS")
    fault("hung", lambda: master.send_signal(signal.SIGSTOP))
    master.send_signal(signal.SIGCONT)
    wait_for(lambda: item("ROS") and "does not answer" not in item("ROS")["message"], 10, "the master answers")
    time.sleep(1)  # so that the next fault is one of its own
    fault("away", lambda: (master.kill(), master.wait()))


def check_commands(watch, name):
    """The commands say of an item what was read from their socket."""
    status, events = (json.loads(run(word, "--json").stdout) for word in ("status", "events"))
    said = {one["name"]: one for one in status["items"]}[name]
    newest = [event for event in events["events"] if event["source"] == name][-1]
    for place, level_now, text in (("status", said["level"], said["message"]), ("events", newest["level"], newest["text"])):
        known = [(one[1], plain(one[2])) for one in watch.seen[place, name]]
        expect((level_now, plain(text)) in known, f"lidard {place} says {level_now} {text}, read before: {known}")


def main():
    network = Network()
    print(f"seconds until it is on {', '.join(PLACES)}")
    with ros_test() as (tmp, master):
        watch = Watch()
        table = Table(watch)
        faults_of_cables(network, tmp, watch, table)
        faults_of_middleware(tmp, watch, table, master)
        watch.end()
    for what, why in NOT_TESTED.items():
        print(f"not tested: {what}: {why}")
    expect(not table.failures, "\n  ".join(["", *table.failures]))
    print(f"{table.rows} faults, ok")


if __name__ == "__main__":
    main()
