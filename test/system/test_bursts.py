#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Velodynes live over loopback with bursts of 20 to 75 lost packets after every 200, as a loose plug makes them: the daemon
stays alive and counts every lost packet.

    test_bursts.py [RUNS SECONDS]      default 3 and 2; on demand 25 and 12; with LIDARD, LIDARD_SIM and LIDARD_SOURCE_DIR
                                       set as ctest does

Two runs at a time.
"""
import concurrent.futures
import os
import pathlib
import random
import re
import signal
import socket
import sys

from harness import (FILE_HEAD, daemon, expect, expect_end, folder, free_port, kernel_port_is_open, make_capture, records, run, scene_of,
                     send, use_master_at, wait_for, write)

CONFIG = "sensors:\n  roof: {{model: {model}, ip_address: 127.168.1.201, ip_port: {port}}}\n"
MODELS = ("velodyne_vlp16", "velodyne_vls128", "velodyne_hdl32e")


def lose_bursts(capture, out, seed):
    """Writes what arrives; returns how many packets that is, and how many are missing between them."""
    rng = random.Random(seed)
    sent = lost = pending = 0
    left = 200
    with out.open("wb") as file:
        file.write(capture.read_bytes()[:FILE_HEAD])
        for record in records(capture.read_bytes()):
            if left == 0:
                left = 200 + rng.randint(20, 75)
            left -= 1
            if left >= 200:
                pending += 1
                continue
            lost, pending, sent = lost + pending, 0, sent + 1
            file.write(record)
    return sent, lost


def is_read(port):
    """True if nothing waits at this UDP port."""
    lines = [line.split() for line in pathlib.Path("/proc/net/udp").read_text().splitlines()]
    return all(fields[4].endswith(":00000000") for fields in lines if fields[1].endswith(f":{port:04X}"))


def live(tmp, captures, number):
    model = MODELS[number % len(MODELS)]
    port, arriving = free_port(socket.SOCK_DGRAM), tmp / f"{number}.pcap"
    sent, lost = lose_bursts(captures[model], arriving, number)
    with daemon(write(tmp / f"{number}.yaml", CONFIG.format(model=model, port=port))) as child:
        wait_for(lambda: kernel_port_is_open(port), 30, "the daemon listens")
        send(arriving, f"--port-map=2368={port}")
        wait_for(lambda: child.poll() is not None or is_read(port), 30, f"run {number}: the daemon reads what came")
        expect(child.poll() is None, f"run {number}: the daemon ended by itself")
        expect_end(child, signal.SIGTERM, 30)
    arriving.unlink()
    log = child.said()
    found = re.search(r"roof \(\w+\): (\d+) packets, (\d+) frames, (\d+) lost, rejected (.*)", log)
    expect(found, log)
    packets, frames, counted = (int(n) for n in found.group(1, 2, 3))
    print(f"run {number} {model}: {sent} packets sent, {packets} received, {lost} left out, {counted} counted as lost, {frames} clouds",
          flush=True)
    # What a busy machine's kernel threw away is lost, too.
    expect(counted == lost + sent - packets, f"run {number} of {model}: {counted} counted as lost; log:\n{log}")
    expect(found.group(4) == "0" and frames > 0, log)


def recordings(tmp):
    """Two captures on which decode, inspect and replay once hung for ever; run() ends them after two minutes."""
    captures = pathlib.Path(os.environ.get("LIDARD_CAPTURES", "/nowhere"), "burst")
    for capture in sorted(captures.glob("burst_*.pcap")):
        decoded = run("decode", capture, "--format", "csv", "-o", tmp / "out.csv")
        expect(decoded.returncode == 0 and ", rejected 0, lost " in decoded.stderr, decoded.stderr)
        inspected = run("inspect", capture)
        expect(inspected.returncode == 0 and "model: velodyne_vlp16" in inspected.stdout, inspected.stdout + inspected.stderr)
        config = tmp / "inspected.yaml"
        config.write_text(inspected.stdout)
        (tmp / "out.bag").unlink(missing_ok=True)
        replayed = run("replay", "-c", config, "--pcap", capture, "--rate", "max", "--bag", tmp / "out.bag")
        expect(replayed.returncode == 0, replayed.stderr)
        print(f"{capture.name}: decoded, inspected, replayed")


def main():
    runs, seconds = (int(a) for a in sys.argv[1:3]) if len(sys.argv) > 2 else (3, 2)
    use_master_at(free_port())  # nobody is there
    with folder() as tmp:
        recordings(tmp)
    with folder() as tmp, concurrent.futures.ThreadPoolExecutor(2) as pool:
        captures = {model: make_capture(tmp / model, scene_of(
            {"roof": f"model: {model}, from: '192.168.1.201:2368', to: '192.168.1.77:2368'"}, seconds=seconds)) for model in MODELS}
        for done in [pool.submit(live, tmp, captures, number) for number in range(runs)]:
            done.result()
    print("ok")


if __name__ == "__main__":
    main()
