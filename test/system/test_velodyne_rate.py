#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""A VLS-128 with two returns, live over loopback at its 18 091 packets per second: no packet is lost.

    test_velodyne_rate.py [SECONDS]      default 5; with LIDARD, LIDARD_SIM and LIDARD_SOURCE_DIR set as ctest does

Runs with nobody listening on ROS and with a subscriber to the clouds, and prints the daemon's use of processor time.
"""
import collections
import os
import pathlib
import re
import signal
import socket
import sys
import time

import rospy
from harness import (daemon, expect, expect_end, free_port, kernel_port_is_open, make_capture, scene_of, send, wait_for,
                     waited_for_processor, write)
from ros_tools import ros_test

SCENE = scene_of(
    {"roof": "model: velodyne_vls128, from: '192.168.1.201:2368', to: '192.168.1.77:2368', divergence_mrad: 3, options: {return_mode: dual}"},
    "box: {center: [1.3, -0.7, 0.4], size: [17, 12, 6.5], rpy_deg: [4, -3, 12], reflectivity: 0.5}",
    "cylinder: {center: [2.5, 1.1, 0], radius: 0.1, height: 4, reflectivity: 0.9}", seconds=1)
CONFIG = "sensors:\n  roof: {{model: velodyne_vls128, ip_address: 127.168.1.201, ip_port: {port}}}\n"


def cpu_seconds(pid):
    """User and system time of a process so far."""
    fields = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    tick = os.sysconf("SC_CLK_TCK")
    return int(fields[11]) / tick, int(fields[12]) / tick


def kernel_drops(port):
    """Packets that the kernel threw away for want of room at this UDP port."""
    for line in pathlib.Path("/proc/net/udp").read_text().splitlines()[1:]:
        fields = line.split()
        if fields[1].endswith(f":{port:04X}"):
            return int(fields[-1])
    return 0


def counts(log, sent_by):
    """Packets sent, received, counted as lost; clouds; how late the sender was."""
    found = re.search(r"roof \(velodyne_vls128\): (\d+) packets, (\d+) frames, (\d+) lost, rejected (.*)", log)
    expect(found and found.group(4) == "0", log)
    packets, frames, lost = (int(n) for n in found.group(1, 2, 3))
    return int(re.search(r": (\d+) packets", sent_by).group(1)), packets, lost, frames, re.search(r"latest packet: (.*) behind", sent_by).group(1)


def stream(name, capture, seconds, listen, tmp):
    port = free_port(socket.SOCK_DGRAM)
    clouds = collections.Counter()
    subscriber = rospy.Subscriber("/roof/points", rospy.AnyMsg, lambda message: clouds.update(n=1, bytes=len(message._buff)),
                                  queue_size=20, buff_size=1 << 24) if listen else None
    with daemon(write(tmp / f"{name}.yaml", CONFIG.format(port=port))) as child:
        wait_for(lambda: kernel_port_is_open(port), 20, "the daemon listens")
        if listen:
            wait_for(lambda: subscriber.get_num_connections() > 0, 20, "the subscriber is connected")
        time.sleep(0.5)  # its start is not measured
        before = cpu_seconds(child.pid)
        begin, waited = time.monotonic(), waited_for_processor(child.pid)
        sent_by = send(capture, f"--port-map=2368={port}", f"--repeat={seconds}", timeout=seconds + 60)
        elapsed = time.monotonic() - begin
        time.sleep(0.5)  # the last packets are read
        user, system = (b - a for a, b in zip(before, cpu_seconds(child.pid)))
        drops, starved = kernel_drops(port), waited_for_processor(child.pid) - waited
        expect_end(child, signal.SIGTERM)
    if subscriber:
        subscriber.unregister()
    sent, packets, lost, frames, late = counts(child.said(), sent_by)
    print(f"{name}: {sent} packets in {elapsed:.1f} s ({sent / elapsed:.0f}/s, at most {late} late), {packets} received, "
          f"{lost} lost, {drops} dropped by the kernel, {frames} clouds; lidard used {100 * (user + system) / elapsed:.1f} % "
          f"of a core ({100 * user / elapsed:.1f} user, {100 * system / elapsed:.1f} system)"
          + (f"; subscriber got {clouds['n']} clouds, {clouds['bytes'] / elapsed / 1e6:.0f} MB/s" if listen else ""))
    if starved > 0.2 * elapsed:
        # What the kernel cannot keep while others have the processors is lost, and has to be counted.
        print(f"{name}: the daemon waited {starved:.1f} s of {elapsed:.1f} s for a processor")
        expect(packets + drops == sent and (lost > 0) == (drops > 0), f"{sent} sent, {packets} received, {drops} dropped, {lost} lost")
        return
    expect(packets == sent and lost == 0 and drops == 0, f"packets were lost, starved {starved:.2f} s; log:\n{child.said()}")
    expect(frames >= 10 * seconds - 2, f"{frames} clouds in {seconds} s at 10 turns per second")


def main():
    seconds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    with ros_test() as (tmp, _):
        capture = make_capture(tmp / "vls128", SCENE)
        stream("nobody listens", capture, seconds, False, tmp)
        stream("a subscriber", capture, seconds, True, tmp)
    print("ok")


if __name__ == "__main__":
    main()
