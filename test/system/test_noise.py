#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""A bad hour: a TCP scanner is off, a cable flaps, and the machine has a load of 8. `lidard events` has at most 60 rows, and what
really happened is among them; the log grows by a few lines a minute; `lidard status` fits into 80 columns.

    test_noise.py [SECONDS]      default 45; on demand 3600
"""
import contextlib
import sys
import threading
import time

from harness import ask, daemon, expect, folder, free_port, process, run, use_master_at, well, write
from network import Network

CONFIG = """\
sensors:
  away: {model: sick_lms1xx, ip_address: 192.168.1.12}
  near: {model: sick_lms1xx, ip_address: 192.168.1.11, pose: {xyz: [0, 1, 0.3]}}
  rear: {model: hokuyo_ust_10lx, ip_address: 192.168.1.10, pose: {xyz: [0, -1, 0.3]}}
  flapping: {model: sick_microscan3, ip_address: 192.168.2.21, listen_only: true, pose: {xyz: [0, 0, 0.3]}}
merged_scans:
  around: {laserscan_topics: [near, rear, flapping], destination_frame: base_link, range_max: 20}
"""
SCENES = {
    "near": "model: sick_lms1xx, from: '192.168.1.11:2112', to: '192.168.1.100:40002'",
    "rear": "model: hokuyo_ust_10lx, from: '192.168.1.10:10940', to: '192.168.1.100:40001'",
    "flapping": "model: sick_microscan3, from: '192.168.2.21:6060', to: '192.168.2.100:6060'",
}


def flap(network, stop):
    while not stop.wait(1.5):
        network.lidars("link", "set", "dev-lidar1", "down")
        stop.wait(1.5)
        network.lidars("link", "set", "dev-lidar1", "up")


def check_rows(seconds, middle):
    all_rows = ask("events")["events"]
    print(run("events").stdout)
    print(f"{len(all_rows)} rows of {sum(row['count'] for row in all_rows)} changes in {seconds} s")
    expect(len(all_rows) <= 60, f"{len(all_rows)} rows")
    expect(ask("events")["forgotten"] == 0, "nothing is forgotten")

    def find(source, level, text=""):
        found = [row for row in all_rows if row["source"] == source and row["level"] == level and text in row["text"]]
        expect(found, f"no row {source} {level} {text}")
        return found

    find("sensor away", "ERROR", "192.168.1.12:2112 does not answer")
    sentences = {row["text"] for row in all_rows if row["source"] == "link away"}
    expect(len(sentences) == 1, f"one cause, one sentence: {sentences}")
    flaps = max(row["count"] for row in find("sensor flapping", "WARN", "has no link"))
    expect(flaps >= min(seconds, 500) / 6, f"the cable is said to have been pulled {flaps} times")
    # The scanner that lost its power in the middle.
    expect(any(row["first"] > middle for row in find("sensor rear", "ERROR", "silent")), "the real incident is a row of its own")


def main():
    seconds = int(sys.argv[1]) if len(sys.argv) > 1 else 45
    network = Network()
    use_master_at(free_port())
    stop = threading.Event()
    with folder() as tmp, contextlib.ExitStack() as stack:
        network.plug(lidars=["192.168.1.10/24", "192.168.1.11/24"])
        network.plug(host="192.168.2.100/24", lidars=["192.168.2.21/24"], name="lidar1")
        devices = {name: network.start_sim(tmp, name, keys, 4000) for name, keys in SCENES.items()}
        child = stack.enter_context(daemon(write(tmp / "c.yaml", CONFIG)))
        well("sensor rear", limit=30)
        for _ in range(8):
            stack.enter_context(process(["sh", "-c", "while :; do :; done"]))
        thread = threading.Thread(target=flap, args=(network, stop), daemon=True)
        thread.start()
        begin, lines = time.monotonic(), len(child.said().splitlines())
        time.sleep(seconds / 2)
        middle = ask("status")["at"]
        devices["rear"].kill()
        time.sleep(seconds / 2)
        check_rows(seconds, middle)
        for line in run("status").stdout.splitlines():
            expect(len(line) <= 80, f"{len(line)} columns: {line}")
        stop.set()
        thread.join()
        expect(child.poll() is None, "the daemon lives")
        more = len(child.said().splitlines()) - lines
        print(f"{more} lines of the log")
        limit = 40 + 10 * (time.monotonic() - begin) / 60
        expect(more <= limit, f"{more} lines, {limit:.0f} expected:\n" + child.said())
    print("ok")


if __name__ == "__main__":
    main()
