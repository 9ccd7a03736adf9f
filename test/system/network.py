# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""A vehicle's network for a test: this process and its children are the host, in a network namespace of their own; the lidars
have another one, and veth pairs are the cables between. Where that is not permitted the test is skipped."""
import atexit
import contextlib
import ctypes
import json
import os
import pathlib
import socket
import struct
import subprocess
import sys
import time

from harness import (CHILDREN, HAS_OWN_NETWORK, LIBC, LIDARD_SIM, NEW_NETWORK, PAYLOAD, RECORD_HEAD, SKIP, make_capture, records,
                     scene_of, source_of, stamp_ns, write)


class Network:
    def __init__(self):
        self.name = f"lidard-test-{os.getpid()}"
        if not HAS_OWN_NETWORK:
            print("skipped: network namespaces are not permitted (run as root)")
            sys.exit(SKIP)
        made = subprocess.run(["ip", "netns", "add", self.name], capture_output=True, text=True)
        if made.returncode != 0:
            print("skipped: " + made.stderr)
            sys.exit(SKIP)
        atexit.register(subprocess.run, ["ip", "netns", "delete", self.name], check=False)
        self.own = os.open("/proc/self/ns/net", os.O_RDONLY)
        self.other = os.open(f"/run/netns/{self.name}", os.O_RDONLY)
        self.lidars("link", "set", "lo", "up")

    def host(self, *arguments):
        subprocess.run(["ip", *arguments], check=True)

    def lidars(self, *arguments):
        subprocess.run(["ip", "-n", self.name, *arguments], check=True)

    def plug(self, host="192.168.1.100/24", lidars=("192.168.1.201/24",), name="lidar0"):
        """A cable whose ends have these addresses; the interface of the host is new each time."""
        # Both ends are the lidars' first, so that the host sees its own one without an address for a moment only.
        self.lidars("link", "add", "dev-" + name, "type", "veth", "peer", "name", name)
        for address in lidars:
            self.lidars("address", "add", address, "dev", "dev-" + name)
        self.lidars("link", "set", "dev-" + name, "up")
        self.lidars("route", "append", "224.0.0.0/4", "dev", "dev-" + name)
        self.lidars("link", "set", name, "netns", str(os.getpid()))
        own = [f"link set {name} up", *([f"address add {host} dev {name}"] if host else [])]
        subprocess.run(["ip", "-batch", "-"], input="\n".join(own) + "\n", text=True, check=True)

    def unplug(self, name="lidar0"):
        self.host("link", "delete", name)

    @contextlib.contextmanager
    def among_lidars(self):
        """Sockets made and programs started meanwhile are the lidars'."""
        LIBC.setns(self.other, NEW_NETWORK)
        try:
            yield
        finally:
            LIBC.setns(self.own, NEW_NETWORK)

    def start_lidar(self, command):
        """A program among the lidars; it is ended with the test."""
        child = subprocess.Popen(["ip", "netns", "exec", self.name, *command], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        atexit.register(child.kill)
        CHILDREN.append(child)
        return child

    def start_sim(self, tmp, name, keys, seconds=600):
        """A simulated sensor of that name and keys of a scene, among the lidars."""
        scene = write(tmp / f"{name}.scene.yaml", scene_of({name: keys}, seconds=seconds))
        address = keys.split("from: '")[1].split(":")[0]
        # A sensor that sends datagrams sends them from its own address.
        own = [] if any(tcp in keys for tcp in ("hokuyo", "lms")) else [f"--source-map={address}={address}"]
        return self.start_lidar([LIDARD_SIM, "live", str(scene), *own])

    @staticmethod
    def lidar_talks(child):
        """True once it has a socket."""
        with contextlib.suppress(OSError):
            return any(os.readlink(fd).startswith("socket:") for fd in pathlib.Path(f"/proc/{child.pid}/fd").iterdir())
        return False

    @staticmethod
    def mac(interface):
        """Hardware address of an interface of the host."""
        shown = subprocess.run(["ip", "-json", "link", "show", interface], capture_output=True, text=True, check=True)
        return json.loads(shown.stdout)[0]["address"]

    def lidar(self, address, port=2368):
        """A UDP socket of a lidar with that address."""
        with self.among_lidars():
            sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        sender.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        sender.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 4)
        sender.setsockopt(socket.IPPROTO_IP, 15, 1)  # IP_FREEBIND: the address may come later
        sender.bind((address, port))
        return sender


class Vector(ctypes.Structure):
    _fields_ = [("base", ctypes.c_void_p), ("size", ctypes.c_size_t)]


class Message(ctypes.Structure):
    """struct mmsghdr of recvmmsg(2)."""
    _fields_ = [("name", ctypes.c_void_p), ("name_size", ctypes.c_uint32), ("vectors", ctypes.POINTER(Vector)),
                ("vector_count", ctypes.c_size_t), ("control", ctypes.c_void_p), ("control_size", ctypes.c_size_t),
                ("flags", ctypes.c_size_t), ("sent", ctypes.c_size_t)]


class Burst:
    """Datagrams to one place that a single system call sends."""

    def __init__(self, payloads, to):
        self.address = ctypes.create_string_buffer(
            struct.pack("=H", socket.AF_INET) + struct.pack("!H", to[1]) + socket.inet_aton(to[0]) + bytes(8), 16)
        self.buffers = [ctypes.create_string_buffer(p, len(p)) for p in payloads]
        self.vectors = [Vector(ctypes.addressof(b), len(b)) for b in self.buffers]
        self.messages = (Message * len(payloads))(*[
            Message(ctypes.addressof(self.address), 16, ctypes.pointer(v), 1, None, 0, 0, 0) for v in self.vectors])

    def send(self, sender):
        """How many of them were sent."""
        begin, size = 0, len(self.messages)
        while begin < size:
            sent = LIBC.sendmmsg(sender.fileno(), ctypes.byref(self.messages[begin]), size - begin, 0)
            if sent <= 0:
                break
            begin += sent
        return begin


def recorded(tmp, scene):
    """The datagrams of a scene: when each is due, s from the first, from which address, to which port, and its bytes."""
    datagrams = [(stamp_ns(record) / 1e9, source_of(record), struct.unpack_from("!H", record, RECORD_HEAD + 36)[0], record[PAYLOAD:])
                 for record in records(make_capture(tmp / "recorded", scene).read_bytes())]
    return [(t - datagrams[0][0], *rest) for t, *rest in datagrams]


def send_paced(datagrams, senders, to, change=lambda burst: burst, until=lambda: False):
    """Sends what is due at its own pace, from senders[address]. `change`: what becomes of those that are due together: some may
    be left out, doubled or exchanged. Returns when the last one was sent, in s of the host's clock, and how many were."""
    begin, place, sent, last = time.monotonic(), 0, 0, time.time()
    while place < len(datagrams) and not until():
        now, first = time.monotonic() - begin, place
        while place < len(datagrams) and datagrams[place][0] <= now:
            place += 1
        for _, source, port, payload in change(datagrams[first:place]):
            with contextlib.suppress(OSError):  # there may be no cable at this time
                senders[source].sendto(payload, (to, port))
                sent, last = sent + 1, time.time()
        time.sleep(0.002)
    return last, sent


def group_is_joined(group, interface):
    word = f"{struct.unpack('=I', socket.inet_aton(group))[0]:08X}"
    current = ""
    for line in pathlib.Path("/proc/net/igmp").read_text().splitlines():
        fields = line.split()
        if line[0].isdigit():
            current = fields[1]
        elif fields and fields[0] == word and current == interface:
            return True
    return False
