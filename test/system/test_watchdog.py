#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""`lidard run` feeds systemd's watchdog while its threads move. One thread alone is stopped with ptrace: no WATCHDOG=1 within 2 s
and /diagnostics says ERROR. A ROS master that hangs, at the start too, does not stop the feeding."""
import contextlib
import ctypes
import os
import pathlib
import signal
import socket
import subprocess
import threading
import time
import xmlrpc.client

import rosgraph
from harness import (LIBC, LIDARD_SIM, SCANNER_SCENE, daemon, expect, free_port, make_capture, process, sim, wait_for, write)
from ros_tools import Diagnostics, Listener, ros_test

LIMIT = 2.0  # WatchdogSec of config/lidard.service.in
PTRACE_SEIZE, PTRACE_INTERRUPT, PTRACE_DETACH, WALL = 0x4206, 0x4207, 17, 0x40000000
LIBC.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]
CONFIG = """\
sensors:
  front: {{model: sick_microscan3, ip_address: 127.168.0.21, ip_port: {port}, listen_only: true}}
  roof: {{model: velodyne_vlp16, ip_port: {roof}}}
"""


def ptrace(request, thread):
    if LIBC.ptrace(request, thread, None, None) != 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))


@contextlib.contextmanager
def stopped(thread):
    """Stops one thread; the others of its process go on."""
    ptrace(PTRACE_SEIZE, thread)
    ptrace(PTRACE_INTERRUPT, thread)
    os.waitpid(thread, WALL)
    try:
        yield
    finally:
        ptrace(PTRACE_DETACH, thread)


class Manager:
    """Receives what systemd would receive."""

    def __init__(self, path):
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.socket.bind(str(path))
        self.path, self.fed, self.ready = path, [], 0
        threading.Thread(target=self._read, daemon=True).start()

    def _read(self):
        while True:
            text = self.socket.recv(4096)
            self.ready += b"READY=1" in text
            if b"WATCHDOG=1" in text:
                self.fed.append(time.monotonic())

    def environment(self):
        return dict(os.environ, NOTIFY_SOCKET=str(self.path), WATCHDOG_USEC=str(int(LIMIT * 1e6)))

    def listen(self, seconds):
        """The times of WATCHDOG=1 within the next seconds."""
        begin = time.monotonic()
        time.sleep(seconds)
        return [t for t in self.fed if t >= begin]

    def expect_fed(self, seconds, when):
        begin = time.monotonic()
        times = [begin, *self.listen(seconds), time.monotonic()]
        gap = max(b - a for a, b in zip(times, times[1:]))
        print(f"{when}: {len(times) - 2} times fed in {seconds} s, longest gap {gap:.2f} s")
        expect(gap < LIMIT, f"{when}: not fed for {gap:.2f} s")


def thread_of(child, name):
    """The id of the thread of that name; of the daemon's first thread, which receives, without a name."""
    if name is None:
        return child.pid
    for task in pathlib.Path(f"/proc/{child.pid}/task").iterdir():
        if (task / "comm").read_text().strip() == name:
            return int(task.name)
    return None


THREADS = (None, "lidard-clouds", "lidard-master", "lidard-ros", "lidard-callback")


def check_states(name, diagnostics):
    """What /diagnostics says while that thread stands."""
    if name is None:
        wait_for(lambda: diagnostics.level("sensor front") == 2, 3, "the sensor's state is an ERROR")
        text = diagnostics.message("sensor front")
        expect("no report from the sensor thread for" in text, text)
        print(f"sensor front: {text}")
    if name == "lidard-clouds":
        wait_for(lambda: "no report from the sensor thread for" in diagnostics.message("sensor roof"), 3, "the clouds' state is old")
        expect(diagnostics.level("sensor front") == 0, "the planar scanner is well")
    if name == "lidard-ros":
        wait_for(lambda: diagnostics.level("ROS") == 2, 3, "the state of ROS is an ERROR")
        expect("the thread that publishes has stood still for" in diagnostics.message("ROS"), diagnostics.message("ROS"))
        print(f"ROS: {diagnostics.message('ROS')}")


def stop_each(child, manager, diagnostics):
    for name in THREADS:
        thread = wait_for(lambda name=name: thread_of(child, name), 5, f"a thread {name}")
        with stopped(thread):
            # What the thread did before it was stopped may still be reported.
            manager.listen(0.3)
            fed = manager.listen(LIMIT + 0.2)
            expect(not fed, f"fed {len(fed)} times although {name or 'the sensor thread'} stands")
            check_states(name, diagnostics)
        print(f"{name or 'the sensor thread'} stood: not fed")
        manager.expect_fed(3, "after it")
        # What was lost meanwhile is reported for 10 s.
        wait_for(lambda: diagnostics.level("sensor front") == 0 and diagnostics.level("ROS") == 0, 20,
                 f"all is well again after {name}: {diagnostics.message('sensor front')}, {diagnostics.message('ROS')}")


def starve(child, manager, tmp, port):
    """The daemon shares one processor with eight others, and everything waits for it: what it has to catch up never ends."""
    capture = make_capture(tmp / "backlog", SCANNER_SCENE.format(port=port).replace("duration: 600", "duration: 20"))
    send = [LIDARD_SIM, "send", capture, "--to", "127.0.0.1", "--rate", "max", "--repeat", "100000"]
    tasks = lambda: [int(task.name) for task in pathlib.Path(f"/proc/{child.pid}/task").iterdir()]
    with contextlib.ExitStack() as stack:
        for _ in range(8):
            stack.enter_context(process(["taskset", "-c", "0", "sh", "-c", "while :; do :; done"]))
        for task in tasks():
            os.sched_setaffinity(task, {0})
        stack.enter_context(process(send, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
        manager.expect_fed(10, "a starved machine with a backlog")
        for task in tasks():
            os.sched_setaffinity(task, range(os.cpu_count()))
    expect(child.poll() is None, "the daemon lives")


def hang_master(child, manager, master, scans):
    own = rosgraph.Master("/test").lookupNode("/lidard")
    master.send_signal(signal.SIGSTOP)
    manager.expect_fed(6, "the master hangs")
    # roscpp's own threads wait for the master then.
    threading.Thread(target=lambda: xmlrpc.client.ServerProxy(own).shutdown("/intruder", "go away"), daemon=True).start()
    manager.expect_fed(6, "shut down from outside while the master hangs")
    master.send_signal(signal.SIGCONT)
    count = len(scans)
    wait_for(lambda: len(scans) > count + 10 or child.poll() is not None, 30, "scans again")
    expect(child.poll() is None, "the daemon lives")


def start_while_master_hangs(config, manager, master):
    master.send_signal(signal.SIGSTOP)
    with daemon(config, env=manager.environment()) as child:
        wait_for(lambda: manager.ready == 2, 10, "READY=1")
        manager.expect_fed(5, "started while the master hangs")
        master.send_signal(signal.SIGCONT)
        manager.expect_fed(5, "the master goes on")
        expect(thread_of(child, "roscpp") is not None, "the daemon has come to ROS")


def main():
    port = free_port(socket.SOCK_DGRAM)
    with ros_test() as (tmp, master):
        config = write(tmp / "live.yaml", CONFIG.format(port=port, roof=free_port(socket.SOCK_DGRAM)))
        diagnostics, scans = Diagnostics(), Listener("/front/scan").messages
        manager = Manager(tmp / "notify")
        with daemon(config, env=manager.environment()) as child, sim(write(tmp / "scene.yaml", SCANNER_SCENE.format(port=port))):
            wait_for(lambda: manager.ready == 1, 10, "READY=1")
            wait_for(lambda: len(scans) > 20 and diagnostics.level("sensor front") == 0, 20, "scans")
            manager.expect_fed(3, "all is well")
            stop_each(child, manager, diagnostics)
            starve(child, manager, tmp, port)
            hang_master(child, manager, master, scans)
        print(child.said())
        start_while_master_hangs(config, manager, master)
    print("ok")


if __name__ == "__main__":
    main()
