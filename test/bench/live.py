#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""What a live VLS-128 with two returns costs, and how fast the daemon starts; of several programs in turn, since a machine that
others use gives other figures from minute to minute.

    LIDARD_SIM=... LIDARD_SOURCE_DIR=... live.py ROUNDS LIDARD...

Prints for each program the processor time per packet (µs; median, least and most of the rounds) without and with a subscriber, the
packets lost, the time from exec to READY (ms; the same) and the libraries that are mapped then.
"""
import os
import pathlib
import re
import signal
import socket
import statistics
import sys
import time

os.environ.setdefault("LIDARD", sys.argv[2] if len(sys.argv) > 2 else "")
sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "system"))
import harness
import rospy
from ros_tools import ros_test
from test_velodyne_rate import CONFIG, SCENE, counts, cpu_seconds

SECONDS = 4


def live(tmp, capture, listen):
    """µs of processor time per packet, and packets lost."""
    port = harness.free_port(socket.SOCK_DGRAM)
    subscriber = rospy.Subscriber("/roof/points", rospy.AnyMsg, lambda _: None, queue_size=20, buff_size=1 << 24) if listen else None
    with harness.daemon(harness.write(tmp / "live.yaml", CONFIG.format(port=port))) as child:
        harness.wait_for(lambda: harness.kernel_port_is_open(port), 20, "the daemon listens")
        if listen:
            harness.wait_for(lambda: subscriber.get_num_connections() > 0, 20, "the subscriber is connected")
        time.sleep(0.5)
        before = sum(cpu_seconds(child.pid))
        sent_by = harness.send(capture, f"--port-map=2368={port}", f"--repeat={SECONDS}")
        time.sleep(0.3)
        used = sum(cpu_seconds(child.pid)) - before
        harness.expect_end(child, signal.SIGTERM)
        _, packets, lost, _, _ = counts(child.said(), sent_by)
    if subscriber:
        subscriber.unregister()
    return 1e6 * used / packets, lost


def start(tmp):
    """ms from exec to READY, and libraries mapped."""
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as notify:
        path = tmp / "notify"
        path.unlink(missing_ok=True)
        notify.bind(str(path))
        config = harness.write(tmp / "start.yaml", CONFIG.format(port=harness.free_port(socket.SOCK_DGRAM)))
        begin = time.monotonic()
        with harness.daemon(config, env={**os.environ, "NOTIFY_SOCKET": str(path)}) as child:
            while b"READY=1" not in notify.recv(4096):
                pass
            took = time.monotonic() - begin
            maps = pathlib.Path(f"/proc/{child.pid}/maps").read_text()
            return 1e3 * took, len(set(re.findall(r"/\S+\.so[.\d]*\S*$", maps, re.MULTILINE)))


def main():
    rounds, programs = int(sys.argv[1]), sys.argv[2:]
    figures = {program: {"nobody": [], "subscriber": [], "READY": []} for program in programs}
    lost, libraries = dict.fromkeys(programs, 0), {}
    with ros_test() as (tmp, _):
        capture = harness.make_capture(tmp / "vls128", SCENE)
        for _ in range(rounds):
            for program in programs:
                harness.LIDARD = program
                for name, listen in (("nobody", False), ("subscriber", True)):
                    cost, missing = live(tmp, capture, listen)
                    figures[program][name].append(cost)
                    lost[program] += missing
                for _ in range(5):
                    ready, libraries[program] = start(tmp)
                    figures[program]["READY"].append(ready)
    for program, kinds in figures.items():
        text = ", ".join(f"{name} {statistics.median(all_):.1f} ({min(all_):.1f} ... {max(all_):.1f})" for name, all_ in kinds.items())
        print(f"{program}: {text}; {lost[program]} lost, {libraries[program]} libraries")


if __name__ == "__main__":
    main()
