#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Lidars that lose their power and come back, over UDP and TCP, also without a word (half-open connections): silence is a WARN
within 1 s and an ERROR within 3 s of the last packet, and all is well at most 2 s after the device talks again. What is wrong with
this host's network is named with the remedy: firewall, receiver, reverse path filter; the fault table has link, address and port."""
import contextlib
import json
import re
import shutil
import socket
import struct
import subprocess
import threading
import time

from harness import Starved, ask, expect, first_event, folder, free_port, item, use_master_at, wait_for, well, write
from harness import daemon as started_daemon
from network import Network

CONFIG = """\
sensors:
  roof: {model: velodyne_vlp16, ip_address: 192.168.1.201}
  front: {model: sick_microscan3, ip_address: 192.168.1.21, listen_only: true}
  left: {model: hokuyo_ust_10lx, ip_address: 192.168.1.10}
  right: {model: sick_lms1xx, ip_address: 192.168.1.11}
"""
SCENES = {
    "roof": "model: velodyne_vlp16, from: '192.168.1.201:2368', to: '192.168.1.100:2368'",
    "front": "model: sick_microscan3, from: '192.168.1.21:6060', to: '192.168.1.100:6060'",
    "left": "model: hokuyo_ust_10lx, from: '192.168.1.10:10940', to: '192.168.1.100:40001'",
    "right": "model: sick_lms1xx, from: '192.168.1.11:2112', to: '192.168.1.100:40002'",
}
ADDRESSES = {"roof": "192.168.1.201", "front": "192.168.1.21", "left": "192.168.1.10", "right": "192.168.1.11"}


class Device:
    """A lidar of the simulator; it can lose its power."""

    def __init__(self, network, tmp, name):
        self.network, self.tmp, self.name, self.child = network, tmp, name, None

    def on(self):
        self.child = self.network.start_sim(self.tmp, self.name, SCENES[self.name])

    def talks(self):
        """When it talks, in s of the host's clock."""
        wait_for(lambda: self.network.lidar_talks(self.child), 10, f"{self.name} starts")
        return time.time()

    def off(self):
        self.child.kill()
        self.child.wait()

    def power_cut(self):
        """No FIN, no RST: whoever has a connection to it learns nothing."""
        self.network.lidars("address", "delete", ADDRESSES[self.name] + "/24", "dev", "dev-lidar0")
        self.off()

    def power(self):
        self.network.lidars("address", "add", ADDRESSES[self.name] + "/24", "dev", "dev-lidar0")


def frames(name):
    return int(item("sensor " + name)["values"]["Frames"])


def check(what, seconds, limit, starved):
    waited = starved.seconds()
    print(f"{what}: {seconds:.2f} s")
    expect(seconds <= limit + waited, f"{what}: {seconds:.2f} s instead of {limit}, starved {waited:.3f} s")


def fell_silent(name, since, starved, how):
    """`since`: when it sent the last packet, at the latest, in s of the host's clock."""
    source = "sensor " + name
    check(f"{name} {how}: WARN", first_event(source, since, "WARN")[0] - since, 1, starved)
    check(f"{name} {how}: ERROR", first_event(source, since, "ERROR")[0] - since, 3, starved)


def came_back(name, on, since, starved, how):
    """`on`: when it got its power, `since`: when it talked, at the latest."""
    before = frames(name)
    wait_for(lambda: frames(name) > before, 10, f"frames of {name}")
    check(f"{name} {how}: frames again", time.time() - since, 2, starved)
    check(f"{name} {how}: OK again", first_event("sensor " + name, on, "OK")[0] - since, 2, starved)


def silence(device, pause, how):
    name = device.name
    well("sensor " + name)
    starved, since = Starved(), time.time()
    device.off()
    fell_silent(name, since, starved, how)
    time.sleep(max(0, pause - (time.time() - since)))
    starved, on = Starved(), time.time()
    device.on()
    # The simulator needs its time to start, a device as well: counted is from where it talks.
    came_back(name, on, device.talks(), starved, how)


def asks_for_connection(raw, address):
    """A packet came that asks this address for a TCP connection: SYN alone of the flags that the first packets have."""
    with contextlib.suppress(BlockingIOError):
        while True:
            frame = raw.recv(2048)
            if frame[23] == socket.IPPROTO_TCP and frame[30:34] == socket.inet_aton(address) and frame[47] & 0x12 == 0x02:
                return True
    return False


def half_open(device):
    """The connection is found dead and the next one tried at most 2 s after the last sign of the device."""
    starved, name = Starved(), device.name
    with device.network.among_lidars():
        raw = socket.socket(socket.AF_PACKET, socket.SOCK_RAW | socket.SOCK_NONBLOCK)
    with raw:
        raw.bind(("dev-lidar0", 0x0800))
        device.power_cut()
        since = time.time()
        wait_for(lambda: asks_for_connection(raw, ADDRESSES[name]), 10, f"{name}: the next attempt to connect")
    check(f"{name} half-open: next attempt to connect", time.time() - since, 2, starved)
    fell_silent(name, since, starved, "half-open")
    time.sleep(2)  # without power
    starved, on = Starved(), time.time()
    device.power()
    device.on()
    came_back(name, on, device.talks(), starved, "half-open")


def dead_cable(device, pause):
    """The device keeps its power, and accepts no second client: for the device the connection stands as long as it waits."""
    name, address = device.name, ADDRESSES[device.name]
    nobody = ("lladdr", "02:00:00:00:00:99", "nud", "permanent")
    well("sensor " + name)
    device.network.host("neighbour", "replace", address, "dev", "lidar0", *nobody)
    device.network.lidars("neighbour", "replace", "192.168.1.100", "dev", "dev-lidar0", *nobody)
    time.sleep(pause)
    starved, since, before = Starved(), time.time(), frames(name)
    device.network.host("neighbour", "delete", address, "dev", "lidar0")
    device.network.lidars("neighbour", "delete", "192.168.1.100", "dev", "dev-lidar0")
    wait_for(lambda: frames(name) > before, 20, f"frames of {name}")
    check(f"{name} after {pause} s of a dead cable: frames again", time.time() - since, 3, starved)


def says(name, text, what, limit=5):
    """What /diagnostics says of the silent sensor contains the text within `limit` s."""
    starved, begin = Starved(), time.monotonic()
    wait_for(lambda: item("sensor " + name), limit, f"the first report of {name}")
    wait_for(lambda: text in item("sensor " + name)["message"], limit, f"{what}: {item('sensor ' + name)['message']}")
    check(f"{what} is named", time.monotonic() - begin, limit, starved)
    print("    " + item("sensor " + name)["message"])


def host_causes(network, roof):
    network.lidars("route", "replace", "default", "dev", "dev-lidar0")
    well("sensor roof")
    roof.off()
    say_what_comes_instead(network)


def flood(network, address, to):
    """Somebody sends what a VLP-16 sends to another place, until the test ends."""
    sender, stop = network.lidar(address, 4000), threading.Event()

    def run():
        while not stop.wait(0.005):
            for _ in range(4):
                with contextlib.suppress(OSError):
                    sender.sendto(b"x" * 1206, to)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    return lambda: (stop.set(), thread.join(), sender.close())


def firewall(network):
    """A rule that drops the lidar's packets. There are scanners over TCP in the configuration."""
    if not shutil.which("nft"):
        print("    no nft here: a firewall is not tried")
        return
    for command in ("add table ip test", "add chain ip test in { type filter hook input priority 0 ; }", "add rule ip test in udp dport 2368 drop"):
        subprocess.run(["nft", command], check=True)
    end = flood(network, "192.168.1.201", ("192.168.1.100", 2368))
    says("roof", "but none from 192.168.1.201 to port 2368; does it send elsewhere, or does a firewall drop them?", "a firewall", 12)
    end()
    subprocess.run(["nft", "delete table ip test"], check=True)


def say_what_comes_instead(network):
    firewall(network)
    says("roof", "next to nothing comes in at lidar0", "that nothing comes in", 12)
    # A neighbour's address with this host's hardware: the packets come in and are for nobody.
    network.lidars("neigh", "replace", "192.168.1.77", "lladdr", network.mac("lidar0"), "dev", "dev-lidar0")
    end = flood(network, "192.168.1.201", ("192.168.1.77", 2368))
    says("roof", "come in for an address that this host does not have; does the sensor send elsewhere?", "packets for somebody else", 12)
    end()
    network.plug(host="10.1.1.1/24", lidars=("10.1.1.2/24",), name="lidar1")
    for name in ("all", "lidar1"):
        with open(f"/proc/sys/net/ipv4/conf/{name}/rp_filter", "w") as file:
            file.write("1")
    network.lidars("address", "add", "192.168.1.201/24", "dev", "dev-lidar1")
    network.lidars("route", "add", "192.168.1.100/32", "dev", "dev-lidar1")
    network.lidars("neigh", "replace", "192.168.1.100", "lladdr", network.mac("lidar1"), "dev", "dev-lidar1")
    end = flood(network, "192.168.1.201", ("192.168.1.100", 2368))
    says("roof", "the reverse path filter of this host drops", "the reverse path filter", 12)
    end()


def two_devices(network):
    """Two devices with one address ask for this host's, each with its own hardware address."""
    with network.among_lidars():
        raw = socket.socket(socket.AF_PACKET, socket.SOCK_RAW)
    raw.bind(("dev-lidar0", 0x0806))
    for number in (1, 2, 1, 2):
        mac = bytes((2, 0, 0, 0, 0, number))
        request = struct.pack("!HHBBH", 1, 0x0800, 6, 4, 1) + mac + socket.inet_aton("192.168.1.201") + bytes(6) + socket.inet_aton("192.168.1.100")
        raw.send(b"\xff" * 6 + mac + b"\x08\x06" + request)
        time.sleep(1.6)  # the kernel accepts no other hardware address within a second
    wait_for(lambda: item("address 192.168.1.201"), 5, "the address of two devices is an item")
    message = item("address 192.168.1.201")["message"]
    print("    " + message)
    # The lidars' own interface has the address too, and the kernel may ask it meanwhile.
    own = json.loads(subprocess.run(["ip", "-n", network.name, "-json", "link", "show", "dev-lidar0"], capture_output=True, text=True, check=True).stdout)
    named = set(re.findall(r"[0-9a-f]{2}(?::[0-9a-f]{2}){5}", message))
    expect(len(named) == 2 and named <= {"02:00:00:00:00:01", "02:00:00:00:00:02", own[0]["address"]} and
           "give one of them another IP address" in message, message)


@contextlib.contextmanager
def daemon(tmp):
    with started_daemon(write(tmp / "c.yaml", CONFIG)) as child:
        wait_for(lambda: ask("status"), 20, "the daemon answers")
        yield child


def main():
    network = Network()
    use_master_at(free_port())
    with folder() as tmp:
        network.plug(lidars=[a + "/24" for a in ADDRESSES.values()])
        lidars = [Device(network, tmp, name) for name in SCENES]
        with daemon(tmp) as child:
            for device in lidars:
                device.on()
                well("sensor " + device.name)
                time.sleep(1)  # in the first second silence says nothing
                silence(device, 6, "silent for 6 s")
                if device.name == "front":
                    silence(device, 60, "silent for 60 s")
                if device.name in ("left", "right"):
                    well("sensor " + device.name)
                    half_open(device)
                    dead_cable(device, 10)
                    dead_cable(device, 25)
                device.off()
            roof = lidars[0]
            roof.on()
            two_devices(network)
            host_causes(network, roof)
            expect(child.poll() is None, "the daemon lives")
    print("ok")


if __name__ == "__main__":
    main()
