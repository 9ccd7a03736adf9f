#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""A bad hour: a TCP scanner is off, a cable flaps, and the machine has a load of 8. `lidard events` has at most 60 rows, and what
really happened is among them; the log grows by a few lines a minute; `lidard status` fits into 80 columns.

    test_noise.py [SECONDS]      default 45; on demand 3600
"""
import contextlib
import subprocess
import sys
import threading
import time

from harness import LIDARD, LIDARD_SIM, expect, folder, free_port, process, run, use_master_at, wait_for
from network import Network, ask, item

CONFIG = """\
sensors:
  away: {model: sick_lms1xx, ip_address: 192.168.1.12}
  near: {model: sick_lms1xx, ip_address: 192.168.1.11, pose: {xyz: [0, 1, 0.3]}}
  rear: {model: hokuyo_ust_10lx, ip_address: 192.168.1.10, pose: {xyz: [0, -1, 0.3]}}
  flapping: {model: sick_microscan3, ip_address: 192.168.2.21, listen_only: true, pose: {xyz: [0, 0, 0.3]}}
merged_scans:
  around: {laserscan_topics: [near, rear, flapping], destination_frame: base_link, range_max: 20}
"""
ROOM = """\
start: 2026-01-01T00:00:00Z
duration: 4000
objects:
  - wall: {from: [4, -30], to: [4, 30], z: [-5, 5]}
sensors:
"""
SCENES = {
    "near": "{model: sick_lms1xx, from: '192.168.1.11:2112', to: '192.168.1.100:40002'}",
    "rear": "{model: hokuyo_ust_10lx, from: '192.168.1.10:10940', to: '192.168.1.100:40001'}",
    "flapping": "{model: sick_microscan3, from: '192.168.2.21:6060', to: '192.168.2.100:6060'}",
}


def start(network, tmp, name):
    scene = tmp / f"{name}.yaml"
    scene.write_text(ROOM + f"  {name}: {SCENES[name]}\n")
    source = ["--source-map=192.168.2.21=192.168.2.21"] if name == "flapping" else []
    return network.start_lidar([LIDARD_SIM, "live", str(scene), *source])


def flap(network, stop):
    while not stop.wait(1.5):
        network.lidars("link", "set", "dev-lidar1", "down")
        stop.wait(1.5)
        network.lidars("link", "set", "dev-lidar1", "up")


def rows():
    return ask("events")["events"]


def check_rows(seconds):
    all_rows = rows()
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
    expect(any(row["first"] > ROWS_BEFORE["at"] for row in find("sensor rear", "ERROR", "silent")), "the real incident is a row of its own")


ROWS_BEFORE = {}


def main():
    seconds = int(sys.argv[1]) if len(sys.argv) > 1 else 45
    network = Network()
    use_master_at(free_port())
    stop = threading.Event()
    with folder() as tmp, contextlib.ExitStack() as stack:
        (tmp / "c.yaml").write_text(CONFIG)
        network.plug(lidars=["192.168.1.10/24", "192.168.1.11/24"])
        network.plug(host="192.168.2.100/24", lidars=["192.168.2.21/24"], name="lidar1")
        devices = {name: start(network, tmp, name) for name in SCENES}
        log = (tmp / "log").open("w")
        daemon = stack.enter_context(process([LIDARD, "run", "-c", tmp / "c.yaml"], stdout=log, stderr=subprocess.STDOUT))
        wait_for(lambda: (item("sensor rear") or {}).get("level") == "OK", 30, "scans")
        for _ in range(8):
            stack.enter_context(process(["sh", "-c", "while :; do :; done"]))
        thread = threading.Thread(target=flap, args=(network, stop), daemon=True)
        thread.start()
        begin, lines = time.monotonic(), len((tmp / "log").read_text().splitlines())
        time.sleep(seconds / 2)
        ROWS_BEFORE["at"] = ask("status")["at"]
        devices["rear"].kill()
        time.sleep(seconds / 2)
        check_rows(seconds)
        for line in run("status").stdout.splitlines():
            expect(len(line) <= 80, f"{len(line)} columns: {line}")
        stop.set()
        thread.join()
        expect(daemon.poll() is None, "the daemon lives")
        more = len((tmp / "log").read_text().splitlines()) - lines
        print(f"{more} lines of the log")
        limit = 40 + 10 * (time.monotonic() - begin) / 60
        expect(more <= limit, f"{more} lines, {limit:.0f} expected:\n" + (tmp / "log").read_text())
    print("ok")


if __name__ == "__main__":
    main()
