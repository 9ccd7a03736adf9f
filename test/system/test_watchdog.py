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
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from harness import (LIDARD, LIDARD_SIM, SCANNER_CONFIG, SCANNER_SCENE, expect, folder, free_port, process, ros_master,
                     use_master_at, wait_for)
from sensor_msgs.msg import LaserScan

LIMIT = 2.0  # WatchdogSec of config/lidard.service.in
PTRACE_SEIZE, PTRACE_INTERRUPT, PTRACE_DETACH, WALL = 0x4206, 0x4207, 17, 0x40000000
libc = ctypes.CDLL(None, use_errno=True)
libc.ptrace.argtypes = [ctypes.c_long, ctypes.c_long, ctypes.c_void_p, ctypes.c_void_p]


def ptrace(request, thread):
    if libc.ptrace(request, thread, None, None) != 0:
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
    """Hears what systemd would hear."""

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


def thread_of(daemon, name):
    """The id of the thread of that name; of the daemon's first thread, which receives, without a name."""
    if name is None:
        return daemon.pid
    for task in pathlib.Path(f"/proc/{daemon.pid}/task").iterdir():
        if (task / "comm").read_text().strip() == name:
            return int(task.name)
    return None


def items_of(states):
    return {status.name.split(": ")[-1]: status for status in states}


def stop_each(daemon, manager, newest):
    for name in (None, "lidard-clouds", "lidard-master", "lidard-ros", "lidard-roscloud", "lidard-callback", "roscpp-sockets", "roscpp-xmlrpc", "roscpp-callback"):
        thread = wait_for(lambda name=name: thread_of(daemon, name), 5, f"a thread {name}")
        with stopped(thread):
            # What the thread did before it was stopped may still be told.
            manager.listen(0.3)
            fed = manager.listen(LIMIT + 0.2)
            expect(not fed, f"fed {len(fed)} times although {name or 'the sensor thread'} stands")
            if name is None:
                wait_for(lambda: newest["sensor front"].level == 2, 3, "the sensor's state is an ERROR")
                expect("no report from the sensor thread for" in newest["sensor front"].message, newest["sensor front"].message)
                print(f"sensor front: {newest['sensor front'].message}")
            if name == "lidard-clouds":
                wait_for(lambda: "no report from the sensor thread for" in newest["sensor roof"].message, 3, "the clouds' state is old")
                expect(newest["sensor front"].level == 0, "the lane of planes is well")
            if name in ("lidard-ros", "lidard-roscloud"):
                wait_for(lambda: newest["ROS"].level == 2, 3, "the state of ROS is an ERROR")
                print(f"ROS: {newest['ROS'].message}")
        print(f"{name or 'the sensor thread'} stood: not fed")
        manager.expect_fed(3, "after it")
        # What was lost meanwhile is told for 10 s.
        wait_for(lambda: newest["sensor front"].level == 0 and newest["ROS"].level == 0, 20,
                 f"all is well again after {name}: {newest['sensor front'].message}, {newest['ROS'].message}")


def starve(daemon, manager, tmp, port):
    """The daemon shares one processor with eight others, and everything waits for it: what it has to catch up never ends."""
    scene = tmp / "backlog.yaml"
    scene.write_text(SCANNER_SCENE.format(port=port).replace("duration: 600", "duration: 20"))
    subprocess.run([LIDARD_SIM, "make", str(scene), "-o", str(tmp / "backlog"), "--no-truth"], check=True, capture_output=True)
    send = [LIDARD_SIM, "send", tmp / "backlog.pcap", "--to", "127.0.0.1", "--rate", "max", "--repeat", "100000"]
    with contextlib.ExitStack() as stack:
        for _ in range(8):
            stack.enter_context(process(["taskset", "-c", "0", "sh", "-c", "while :; do :; done"]))
        for task in pathlib.Path(f"/proc/{daemon.pid}/task").iterdir():
            os.sched_setaffinity(int(task.name), {0})
        stack.enter_context(process(send, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
        manager.expect_fed(10, "a starved machine with a backlog")
        for task in pathlib.Path(f"/proc/{daemon.pid}/task").iterdir():
            os.sched_setaffinity(int(task.name), range(os.cpu_count()))
    expect(daemon.poll() is None, "the daemon lives")


def main():
    master_port, port = free_port(), free_port(socket.SOCK_DGRAM)
    use_master_at(master_port)
    with folder() as tmp, ros_master(master_port) as master:
        roof = f"  roof: {{model: velodyne_vlp16, ip_port: {free_port(socket.SOCK_DGRAM)}}}\n"
        config = SCANNER_CONFIG.format(port=port).replace("sensors: {front: ", "sensors:\n  front: ").replace("}}", "}")
        (tmp / "live.yaml").write_text(config + roof)
        (tmp / "scene.yaml").write_text(SCANNER_SCENE.format(port=port))
        rospy.init_node("listener", disable_signals=True, anonymous=True)
        newest, scans = {}, []
        rospy.Subscriber("/diagnostics", DiagnosticArray, lambda array: newest.update(items_of(array.status)), queue_size=100)
        rospy.Subscriber("/front/scan", LaserScan, scans.append, queue_size=100)
        manager, log = Manager(tmp / "notify"), tmp / "log.txt"
        run = [LIDARD, "run", "-c", tmp / "live.yaml"]
        sim = [LIDARD_SIM, "live", tmp / "scene.yaml"]
        with log.open("w") as sink, process(run, env=manager.environment(), stdout=sink, stderr=subprocess.STDOUT) as daemon, \
                process(sim, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL):
            wait_for(lambda: manager.ready == 1, 10, "READY=1")
            wait_for(lambda: len(scans) > 20 and newest.get("sensor front") and newest["sensor front"].level == 0, 20, "scans")
            manager.expect_fed(3, "all is well")
            stop_each(daemon, manager, newest)
            starve(daemon, manager, tmp, port)
            own = rosgraph.Master("/test").lookupNode("/lidard")
            master.send_signal(signal.SIGSTOP)
            manager.expect_fed(6, "the master hangs")
            # roscpp's own threads wait for the master then.
            threading.Thread(target=lambda: xmlrpc.client.ServerProxy(own).shutdown("/intruder", "go away"), daemon=True).start()
            manager.expect_fed(6, "shut down from outside while the master hangs")
            master.send_signal(signal.SIGCONT)
            count = len(scans)
            wait_for(lambda: len(scans) > count + 10 or daemon.poll() is not None, 30, "scans again")
            expect(daemon.poll() is None, "the daemon lives")
        print(log.read_text())
        master.send_signal(signal.SIGSTOP)
        with process(run, env=manager.environment(), stderr=subprocess.DEVNULL) as daemon:
            wait_for(lambda: manager.ready == 2, 10, "READY=1")
            manager.expect_fed(5, "started while the master hangs")
            master.send_signal(signal.SIGCONT)
            manager.expect_fed(5, "the master goes on")
            expect(thread_of(daemon, "roscpp-sockets") is not None, "the daemon has come to ROS")
    print("ok")


if __name__ == "__main__":
    main()
