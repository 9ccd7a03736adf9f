# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""A vehicle's network for a test: this process and its children are the host, in a network namespace of their own; the lidars
have another one, and veth pairs are the cables between. Where that is not permitted the test is skipped."""
import atexit
import contextlib
import ctypes
import datetime
import json
import os
import pathlib
import socket
import struct
import subprocess
import sys
import time

from harness import CHILDREN, HAS_OWN_NETWORK, LIBC, LIDARD_SIM, NEW_NETWORK, SKIP, expect, wait_for

ETHERNET_IP_UDP = 14 + 20 + 8
FILE_HEAD, RECORD_HEAD = 24, 16


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
        self.host("link", "add", name, "type", "veth", "peer", "name", "dev-" + name, "netns", self.name)
        for address in lidars:
            self.lidars("address", "add", address, "dev", "dev-" + name)
        self.lidars("link", "set", "dev-" + name, "up")
        self.lidars("route", "append", "224.0.0.0/4", "dev", "dev-" + name)
        self.host("link", "set", name, "up")
        if host:
            self.host("address", "add", host, "dev", name)

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
    (tmp / "recorded.yaml").write_text(scene)
    made = subprocess.run([LIDARD_SIM, "make", str(tmp / "recorded.yaml"), "-o", str(tmp / "recorded"), "--no-truth"], capture_output=True, text=True)
    expect(made.returncode == 0, made.stderr)
    data, at, datagrams = (tmp / "recorded.pcap").read_bytes(), FILE_HEAD, []
    unit = 1e-9 if struct.unpack_from("<I", data)[0] == 0xA1B23C4D else 1e-6
    while at < len(data):
        s, fraction, size = struct.unpack_from("<III", data, at)
        packet = data[at + RECORD_HEAD:at + RECORD_HEAD + size]
        at += RECORD_HEAD + size
        datagrams.append((s + fraction * unit, socket.inet_ntoa(packet[26:30]), struct.unpack_from("!H", packet, 36)[0],
                          packet[ETHERNET_IP_UDP:]))
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


def ask(word):
    """What the daemon answers at its runtime socket; None while there is none."""
    try:
        with socket.socket(socket.AF_UNIX) as s:
            s.connect(os.environ["LIDARD_SOCKET"])
            s.sendall(word.encode() + b"\n")
            answer = b"".join(iter(lambda: s.recv(65536), b""))
        return json.loads(answer)
    except OSError:
        return None


def item(name):
    status = ask("status")
    return next((one for one in status["items"] if one["name"] == name), None) if status else None


def figure(name, key):
    return item(name)["values"][key]


def events_of(source, since=0):
    """(time, level, sentence) of the events of a source, from that time on, in s of the host's clock."""
    answer = ask("events") or {"events": []}
    times = [(datetime.datetime.fromisoformat(e["at"].replace("Z", "+00:00")).timestamp(), e["level"], e["text"])
             for e in answer["events"] if e["source"] == source]
    return [one for one in times if one[0] >= since]


def first_event(source, since, level, limit=10, text=""):
    """When the first one of that level came."""
    return wait_for(lambda: next((e for e in events_of(source, since) if e[1] == level and text in e[2]), None), limit,
                    f"{source} becomes {level} {text}: {events_of(source)}")


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
