# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""What the system tests share: the programs under test, a private ROS master, ports, a wait with a limit."""
import contextlib
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


def free_port(kind=socket.SOCK_STREAM):
    with socket.socket(socket.AF_INET, kind) as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def kernel_port_is_open(port):
    """True if somebody listens at this UDP port."""
    return any(f":{port:04X} " in line for line in pathlib.Path("/proc/net/udp").read_text().splitlines())


def wait_for(condition, limit, what):
    """The condition's first true value; fails the test after `limit` seconds."""
    end = time.monotonic() + limit
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.02)
    sys.exit(f"not within {limit} s: {what}")


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


@contextlib.contextmanager
def process(command, **options):
    """A child that is always ended."""
    child = subprocess.Popen([str(c) for c in command], **options)
    try:
        yield child
    finally:
        if child.poll() is None:
            child.send_signal(signal.SIGCONT)
            child.terminate()
            try:
                child.wait(5)
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
