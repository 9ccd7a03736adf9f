#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Interfaces and addresses that come, go and are made anew under a running daemon: it starts with nothing present, and data come at
most 2 s after what they need is there; multicast groups are joined again at most 1 s after the address is there, however often the
interface is made anew."""
import contextlib
import os
import socket
import threading
import time

from harness import Starved, daemon, expect, figure, folder, free_port, item, level, scene_of, use_master_at, wait_for, write
from network import Network, group_is_joined, recorded

CONFIG = """\
sensors:
  roof: {model: velodyne_vlp16, ip_address: 192.168.1.201}
  mast: {model: velodyne_vlp16, ip_address: 192.168.1.202, ip_port: 2369, multicast_group: 239.0.0.10, interface: lidar0}
  rear: {model: velodyne_vlp16, ip_address: 192.168.1.203, ip_port: 2370, multicast_group: 239.0.0.11, interface: 192.168.1.100}
"""
LIDARS = ("192.168.1.201/24", "192.168.1.202/24", "192.168.1.203/24")
TARGETS = {"roof": ("192.168.1.201", ("192.168.1.100", 2368)), "mast": ("192.168.1.202", ("239.0.0.10", 2369)),
           "rear": ("192.168.1.203", ("239.0.0.11", 2370))}
GROUPS = ("239.0.0.10", "239.0.0.11")
SCENE = scene_of({"roof": "model: velodyne_vlp16, from: '192.168.1.201:2368', to: '192.168.1.100:2368'"}, seconds=1)


class Lidars(threading.Thread):
    """Three lidars that send for ever, whether there is a cable or not."""

    def __init__(self, network, tmp):
        super().__init__(daemon=True)
        self.payloads = [payload for _, _, _, payload in recorded(tmp, SCENE)]
        self.sockets = {name: network.lidar(address) for name, (address, _) in TARGETS.items()}
        self.start()

    def run(self):
        while True:
            for payload in self.payloads:
                for name, sender in self.sockets.items():
                    with contextlib.suppress(OSError):
                        sender.sendto(payload, TARGETS[name][1])
                time.sleep(0.005)


def packets(name):
    return int(figure("sensor " + name, "Packets"))


def data_after(since, what, limit=2.0, starved=None):
    """Each of the three sends data again; how long after `since`."""
    starved = starved or Starved()
    before = {name: packets(name) for name in TARGETS}
    took = {}
    wait_for(lambda: all(took.get(n) or (packets(n) > before[n] and took.setdefault(n, time.monotonic() - since)) for n in TARGETS),
             10, f"data of all three {what}: {took}, " + "; ".join(item("sensor " + n)["message"] for n in TARGETS))
    print(f"{what}: data after " + ", ".join(f"{n} {t:.2f} s" for n, t in took.items()))
    expect(max(took.values()) <= limit + starved.seconds(), f"{what}: data later than {limit} s: {took}, starved {starved.seconds():.3f} s")


def groups_after(since, what, limit=1.0):
    starved = Starved()
    wait_for(lambda: all(group_is_joined(group, "lidar0") for group in GROUPS), 10, f"the groups are joined {what}")
    took = time.monotonic() - since
    print(f"{what}: groups joined after {took:.2f} s")
    expect(took <= limit + starved.seconds(), f"{what}: groups joined after {took:.2f} s, starved {starved.seconds():.3f} s")


@contextlib.contextmanager
def daemon_that_starts_with_nothing(tmp):
    """P11: no interface, no address, no lidar, no master."""
    ready = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    ready.bind(str(tmp / "notify"))
    ready.settimeout(60)
    starved, begin = Starved(), time.monotonic()
    with daemon(write(tmp / "c.yaml", CONFIG), env=dict(os.environ, NOTIFY_SOCKET=str(tmp / "notify"))) as child:
        expect(b"READY=1" in ready.recv(4096), "the first word is READY=1")
        took = time.monotonic() - begin
        print(f"ready with nothing present after {took:.3f} s")
        expect(took <= 0.5 + starved.seconds(), f"ready after {took:.3f} s, starved {starved.seconds():.3f} s")
        wait_for(lambda: level("sensor roof") == "ERROR", 5, "without anything the sensors are errors")
        yield child


def address(network, change):
    network.host("address", change, "192.168.1.100/24", "dev", "lidar0")
    return time.monotonic()


def groups_and_data(since, what):
    groups_after(since, what)
    data_after(since, what)


def main():
    network = Network()
    use_master_at(free_port())
    with folder() as tmp:
        Lidars(network, tmp)
        with daemon_that_starts_with_nothing(tmp) as child:
            network.plug(host=None, lidars=LIDARS)
            time.sleep(0.5)  # an interface without an address
            groups_and_data(address(network, "add"), "the interface came")
            for pause in (0.2, 3, 8):  # a timer with back-off would be late after the long one
                network.unplug()
                time.sleep(pause)
                network.plug(host=None, lidars=LIDARS)
                time.sleep(0.3)  # an interface without an address
                groups_and_data(address(network, "add"), f"the interface was made anew after {pause} s")
            address(network, "delete")
            time.sleep(2)  # silence
            data_after(address(network, "add"), "the address came back")
            network.host("link", "set", "lidar0", "down")
            time.sleep(2)  # silence
            network.host("link", "set", "lidar0", "up")
            data_after(time.monotonic(), "the link came back")
            # Memberships of interfaces that are gone count: net.ipv4.igmp_max_memberships is 20.
            for _ in range(25):
                network.unplug()
                network.plug(lidars=LIDARS)
                time.sleep(0.1)  # the daemon joins
            groups_and_data(time.monotonic(), "the interface was made anew 25 times")
            expect(child.poll() is None, "the daemon lives")
    print("ok")


if __name__ == "__main__":
    main()
