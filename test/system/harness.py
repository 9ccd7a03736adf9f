# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""What the system tests share: the programs under test, a private ROS master, ports, a wait with a limit."""
import contextlib
import ctypes
import os
import pathlib
import signal
import socket
import subprocess
import sys
import tempfile
import time
import xmlrpc.client

LIDARD = os.environ["LIDARD"]
LIDARD_SIM = os.environ["LIDARD_SIM"]
ROOT = pathlib.Path(os.environ["LIDARD_SOURCE_DIR"])
SKIP = 77
# Machines that run tests are busy: limits that only end a hopeless wait are this much longer.
PATIENCE = 4
CHILDREN = []
LIBC = ctypes.CDLL(None, use_errno=True)
NEW_NETWORK = 0x40000000  # CLONE_NEWNET of sched.h
# Daemons of the tests are not to be found where one of this machine is asked.
os.environ["LIDARD_SOCKET"] = f"{tempfile.gettempdir()}/lidard-test-{os.getpid()}.control"

# A microScan3 before a wall, live for ten minutes, and the configuration that takes it; format() puts the port in.
SCANNER_SCENE = """\
start: 2026-01-01T00:00:00Z
duration: 600
sensors:
  front: {{model: sick_microscan3, from: '192.168.0.21:6060', to: '127.0.0.1:{port}', pose: {{xyz: [0, 0, 0.35]}}}}
objects:
  - wall: {{from: [8, -8], to: [8, 8], z: [-1, 2]}}
"""
SCANNER_CONFIG = "sensors: {{front: {{model: sick_microscan3, ip_address: 127.168.0.21, ip_port: {port}, listen_only: true}}}}\n"


def own_network():
    """Gives this process and its children a network namespace with a loopback of its own; False where that is not permitted."""
    if os.geteuid() != 0 or LIBC.unshare(NEW_NETWORK) != 0:
        return False
    return subprocess.run(["ip", "link", "set", "lo", "up"], check=False).returncode == 0


# Tests that run side by side share no port.
HAS_OWN_NETWORK = "LIDARD_TEST_HOST_NETWORK" not in os.environ and own_network()


def free_port(kind=socket.SOCK_STREAM):
    with socket.socket(socket.AF_INET, kind) as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def kernel_port_is_open(port):
    """True if somebody listens at this UDP port."""
    return any(f":{port:04X} " in line for line in pathlib.Path("/proc/net/udp").read_text().splitlines())


def wait_for(condition, limit, what):
    """The condition's first true value; fails the test after `limit` seconds on a quiet machine."""
    end = time.monotonic() + PATIENCE * limit
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.02)
    sys.exit(f"not within {PATIENCE * limit} s: {what}")


def expect(condition, text):
    if not condition:
        sys.exit(f"FAILED: {text}")


@contextlib.contextmanager
def folder():
    with tempfile.TemporaryDirectory(prefix="lidard-test-") as path:
        yield pathlib.Path(path)


def use_master_at(port):
    os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1",
                      ROS_LOG_DIR=tempfile.gettempdir() + "/lidard-test-ros-log")
    os.environ.pop("ROS_HOSTNAME", None)


def waited_for_processor(pid):
    """Seconds that the threads of a process were ready to run and waited for a processor, since they began."""
    total = 0
    for task in pathlib.Path(f"/proc/{pid}/task").glob("*/schedstat"):
        with contextlib.suppress(OSError, IndexError, ValueError):  # a thread that ends meanwhile
            total += int(task.read_text().split()[1]) / 1e9
    return total


def stolen():
    """Seconds that other guests of the same host took from our processors."""
    fields = pathlib.Path("/proc/stat").read_text().split("\n", 1)[0].split()
    return int(fields[8]) / os.sysconf("SC_CLK_TCK")


class Starved:
    """How long the processes of the test have waited for a processor since this was made: what is measured beside it may be
    late by as much. Zero on a machine with time to spare, so that limits are strict there."""

    def __init__(self):
        self.begin = self._now()
        self.stolen = stolen()

    @staticmethod
    def _now():
        return {pid: waited_for_processor(pid) for pid in [os.getpid(), *(c.pid for c in CHILDREN if c.poll() is None)]}

    def seconds(self):
        now = self._now()
        return sum(max(0, waited - self.begin.get(pid, 0)) for pid, waited in now.items()) + stolen() - self.stolen


def check_stream(name, stamps, period, seconds, starved):
    """Stamps of a sensor that measures once a `period`, taken for `seconds`: each a whole number of periods after the one
    before. What is missing between them was lost while processes of the test were starved for `starved` seconds."""
    expect(len(stamps) > 2, f"{name}: {len(stamps)} frames in {seconds:.1f} s")
    steps = [b - a for a, b in zip(stamps, stamps[1:])]
    for step in steps:
        expect(round(step / period) >= 1 and abs(step - round(step / period) * period) < 0.25 * period,
               f"{name}: stamps {step} s apart, one each {period} s")
    missing = sum(round(step / period) - 1 for step in steps)
    expect(missing * period <= starved, f"{name}: {missing} of {len(stamps) + missing} frames are missing, starved {starved:.3f} s")
    rate = len(stamps) * period / seconds
    expect(abs(rate - 1) < 0.2 + starved / seconds, f"{name}: {len(stamps)} frames in {seconds:.1f} s, one each {period} s")


@contextlib.contextmanager
def process(command, **options):
    """A child that is always ended."""
    child = subprocess.Popen([str(c) for c in command], **options)
    CHILDREN.append(child)
    try:
        yield child
    finally:
        if child.poll() is None:
            child.send_signal(signal.SIGCONT)
            child.terminate()
            try:
                child.wait(5 * PATIENCE)
            except subprocess.TimeoutExpired:
                child.kill()
                child.wait()


@contextlib.contextmanager
def ros_master(port):
    client = xmlrpc.client.ServerProxy(f"http://127.0.0.1:{port}")

    def answers():
        try:
            return client.getPid("/test")
        except OSError:
            return None

    with process(["/usr/bin/python3", "/usr/bin/rosmaster", "--core", "-p", port], stdout=subprocess.DEVNULL,
                 stderr=subprocess.DEVNULL) as master:
        wait_for(answers, 20, "the ROS master answers")
        yield master


def run(*arguments, timeout=120, **options):
    return subprocess.run([LIDARD, *map(str, arguments)], capture_output=True, text=True, timeout=timeout, **options)


def live_config(text, ports):
    """A configuration for captured sensors sent over loopback: a.b.c.d sends from 127.b.c.d to another port."""
    text = text.replace("192.168.", "127.168.")
    for old, new in ports.items():
        text = text.replace(f"ip_port: {old}", f"ip_port: {new}")
    return text
