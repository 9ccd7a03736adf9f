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
import subprocess
import sys
import time

import rospy
from harness import (LIDARD, LIDARD_SIM, expect, folder, free_port, kernel_port_is_open, process, ros_master,
                     use_master_at, wait_for, waited_for_processor)

SCENE = """start: 2026-01-01T00:00:00Z
duration: 1.0
objects:
  - box: {center: [1.3, -0.7, 0.4], size: [17, 12, 6.5], rpy_deg: [4, -3, 12], reflectivity: 0.5}
  - cylinder: {center: [2.5, 1.1, 0], radius: 0.1, height: 4, reflectivity: 0.9}
sensors:
  roof: {model: velodyne_vls128, from: '192.168.1.201:2368', to: '192.168.1.77:2368', divergence_mrad: 3, options: {return_mode: dual}}
"""
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


def stream(name, capture, seconds, listen, tmp):
    port = free_port(socket.SOCK_DGRAM)
    config = tmp / f"{name}.yaml"
    config.write_text(CONFIG.format(port=port))
    log_path = tmp / f"{name}.log"
    clouds = collections.Counter()

    def count(message):
        clouds["n"] += 1
        clouds["bytes"] += len(message._buff)

    subscriber = rospy.Subscriber("/roof/points", rospy.AnyMsg, count, queue_size=20, buff_size=1 << 24) if listen else None
    with log_path.open("w") as log, process([LIDARD, "run", "-c", config], stdout=log, stderr=subprocess.STDOUT) as daemon:
        wait_for(lambda: kernel_port_is_open(port), 20, "the daemon listens")
        if listen:
            wait_for(lambda: subscriber.get_num_connections() > 0, 20, "the subscriber is connected")
        time.sleep(0.5)
        user, system = cpu_seconds(daemon.pid)
        begin, waited = time.monotonic(), waited_for_processor(daemon.pid)
        sender = subprocess.run([LIDARD_SIM, "send", str(capture), "--to", "127.0.0.1", f"--port-map=2368={port}",
                                 f"--repeat={seconds}"], capture_output=True, text=True, timeout=seconds + 60)
        elapsed = time.monotonic() - begin
        expect(sender.returncode == 0, sender.stderr)
        time.sleep(0.5)
        user, system = (b - a for a, b in zip((user, system), cpu_seconds(daemon.pid)))
        drops = kernel_drops(port)
        starved = waited_for_processor(daemon.pid) - waited
        daemon.send_signal(signal.SIGTERM)
        daemon.wait(20)
    if subscriber:
        subscriber.unregister()
    text = log_path.read_text()
    sent = int(re.search(r": (\d+) packets", sender.stdout).group(1))
    found = re.search(r"roof \(velodyne_vls128\): (\d+) packets, (\d+) frames, (\d+) lost, rejected (.*)", text)
    expect(found, text)
    packets, frames, lost = (int(n) for n in found.group(1, 2, 3))
    late = re.search(r"latest packet: (.*) behind", sender.stdout).group(1)
    print(f"{name}: {sent} packets in {elapsed:.1f} s ({sent / elapsed:.0f}/s, at most {late} late), {packets} received, "
          f"{lost} lost, {drops} dropped by the kernel, {frames} clouds; lidard used {100 * (user + system) / elapsed:.1f} % "
          f"of a core ({100 * user / elapsed:.1f} user, {100 * system / elapsed:.1f} system)"
          + (f"; subscriber got {clouds['n']} clouds, {clouds['bytes'] / elapsed / 1e6:.0f} MB/s" if listen else ""))
    expect(found.group(4) == "0", text)
    if starved > 0.2 * elapsed:
        # What the kernel cannot keep while others have the processors is lost, and has to be counted.
        print(f"{name}: the daemon waited {starved:.1f} s of {elapsed:.1f} s for a processor")
        expect(packets + drops == sent and (lost > 0) == (drops > 0), f"{sent} sent, {packets} received, {drops} dropped, {lost} lost")
        return
    expect(packets == sent and lost == 0 and drops == 0, f"packets were lost, starved {starved:.2f} s; log:\n{text}")
    expect(frames >= 10 * seconds - 2, f"{frames} clouds in {seconds} s at 10 turns per second")


def main():
    seconds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    master = free_port()
    use_master_at(master)
    with folder() as tmp, ros_master(master):
        rospy.init_node("listener", disable_signals=True, anonymous=True)
        scene = tmp / "scene.yaml"
        scene.write_text(SCENE)
        subprocess.run([LIDARD_SIM, "make", scene, "-o", tmp / "vls128", "--no-truth"], check=True, capture_output=True)
        capture = tmp / "vls128.pcap"
        stream("nobody listens", capture, seconds, False, tmp)
        stream("a subscriber", capture, seconds, True, tmp)
    print("ok")


if __name__ == "__main__":
    main()
