#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""python_speed.py BUILD CAPTURE... [--size MB]: points per second of processor time of the Python package on captures looped to
`size`, beside the target plain_decode of the build where it is there, and velodyne_decoder where it can be imported; medians of 5
processes in turn, and peaks of memory."""
import argparse
import os
import pathlib
import statistics
import struct
import subprocess
import sys
import tempfile

RUNS = 5
BEGIN = "import sys, time, resource; capture = sys.argv[1]; n = 0; "
END = "\ntook = time.process_time() - begin; print(n, took, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000)"
READERS = {
    "lidard": BEGIN + "import lidard; begin = time.process_time()\nfor frame in lidard.open(capture): n += frame.points.size" + END,
    "velodyne_decoder": BEGIN + "import velodyne_decoder as vd; begin = time.process_time()\nfor _, points in vd.read_pcap(capture, as_pcl_structs=True): n += len(points)" + END,
}


def looped(capture, size, path):
    """The records again and again; both clocks, that of the capture and that of each data packet, go on."""
    data = capture.read_bytes()
    order = "<" if data[:4] in (b"\xd4\xc3\xb2\xa1", b"\x4d\x3c\xb2\xa1") else ">"
    records, at = [], 24
    while at < len(data):
        end = at + 16 + struct.unpack_from(order + "I", data, at + 8)[0]
        records.append(data[at:end])
        at = end
    spans = struct.unpack_from(order + "II", records[0]), struct.unpack_from(order + "II", records[-1])
    unit = 1000 if data[:4] in (b"\x4d\x3c\xb2\xa1", b"\xa1\xb2\x3c\x4d") else 1
    us = [seconds * 1_000_000 + fraction // unit for seconds, fraction in spans]
    turn_us = us[1] - us[0] + (us[1] - us[0]) // (len(records) - 1)
    with path.open("wb") as out:
        out.write(data[:24])
        for turn in range(size // len(data) + 1):
            for record in records:
                again = bytearray(record)
                seconds, fraction = struct.unpack_from(order + "II", again)
                now = seconds * 1_000_000 + fraction // unit + turn * turn_us
                struct.pack_into(order + "II", again, 0, now // 1_000_000, now % 1_000_000 * unit)
                if len(again) == 16 + 42 + 1206:
                    device = struct.unpack_from("<I", again, len(again) - 6)[0]
                    struct.pack_into("<I", again, len(again) - 6, (device + turn * turn_us) % 3_600_000_000)
                out.write(again)


def measure(command, environment):
    if command[0] != sys.executable and not command[0].exists():
        return None
    done = subprocess.run(list(map(str, command)), env=environment, capture_output=True, text=True, check=False)
    return [float(part) for part in done.stdout.split()] if done.returncode == 0 else None


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("captures", type=pathlib.Path, nargs="+")
    parser.add_argument("--size", type=int, default=200)
    options = parser.parse_args()
    environment = {**os.environ, "PYTHONPATH": f"{options.build / 'python'}:{os.environ.get('PYTHONPATH', '')}"}
    for capture in options.captures:
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "looped.pcap"
            looped(capture, options.size * 1_000_000, path)
            commands = {name: [sys.executable, "-c", code, path] for name, code in READERS.items()}
            sys.path.insert(0, str(options.build / "python"))
            import lidard
            model, = {one["model"] for one in lidard.open(capture).sensors.values()}
            commands["plain C++"] = [options.build / "plain_decode", model, path]
            results = {name: [] for name in commands}
            for _ in range(RUNS):
                for name, command in commands.items():
                    results[name].append(measure(command, environment))
            for name, runs in results.items():
                if None in runs:
                    print(f"{capture.name}  {name}: does not run")
                    continue
                speed = statistics.median(points / took / 1e6 for points, took, _ in runs)
                print(f"{capture.name}  {name}: {runs[0][0]:.0f} points, {speed:.1f} M points/s, {max(r[2] for r in runs):.0f} MB")


if __name__ == "__main__":
    main()
