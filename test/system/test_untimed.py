#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""A capture without arrival times: inspect, decode and replay give the intervals of the devices' clocks at their pace, and say so."""
import json
import struct
import time

import rosbag
from harness import FILE_HEAD, ROOT, expect, folder, records, run

SENTENCE = "has no arrival times; stamps follow the sensors' clocks and are not comparable between sensors"
DEMO = ROOT / "pcaps/demo.pcap"
EMPTY_TIMES = {
    "one time": lambda s, us, n: (1_600_000_000, 0),
    "none": lambda s, us, n: (0, 0),
    "whole seconds": lambda s, us, n: (s, 0),
    "counted up": lambda s, us, n: (1_600_000_000, n),
}


def retimed(source, path, made):
    """The capture with other arrival times, made of seconds, us and the number of the record."""
    data = source.read_bytes()
    out, at, number = [data[:FILE_HEAD]], FILE_HEAD, 0
    while at < len(data):
        s, us, captured, length = struct.unpack_from("<IIII", data, at)
        out.append(struct.pack("<IIII", *made(s, us, number), captured, length) + data[at + 16:at + 16 + captured])
        at += 16 + captured
        number += 1
    path.write_bytes(b"".join(out))
    return path


def inspected(capture):
    result = run("inspect", "--json", capture)
    expect(result.returncode == 0, result.stderr)
    return json.loads(result.stdout)["sensors"]


def stamps(capture, bag):
    """Stamps of the sensors' own frames, s, by topic; and the standard error."""
    result = run("replay", "-c", ROOT / "config/demo.yaml", "--pcap", capture, "--rate", "max", "--bag", bag)
    expect(result.returncode == 0, result.stderr)
    topics = {}
    with rosbag.Bag(str(bag)) as messages:
        for topic, message, _ in messages.read_messages():
            if topic.count("/") >= 1 and message._type in ("sensor_msgs/LaserScan", "sensor_msgs/PointCloud2"):
                topics.setdefault(topic, []).append(message.header.stamp.to_sec())
    return topics, result.stderr


def main():
    with folder() as tmp:
        truth = inspected(DEMO)
        expect(not any("arrival times" in text for sensor in truth for text in sensor["warnings"]), truth)
        wanted, _ = stamps(DEMO, tmp / "truth.bag")
        for name, made in EMPTY_TIMES.items():
            flat = retimed(DEMO, tmp / "flat.pcap", made)
            for sensor, right in zip(inspected(flat), truth):
                expect(sensor["name"] == right["name"], name)
                for key in ("frame_rate_hz", "duration_s", "rate_hz"):
                    expect(abs(sensor[key] / right[key] - 1) < 0.05, f"{name}: {key} {sensor[key]} of {right[key]}")
                expect(any(SENTENCE in text for text in sensor["warnings"]), f"{name}: {sensor['warnings']}")
            got, said = stamps(flat, tmp / f"{name.replace(' ', '_')}.bag")
            expect(said.count(SENTENCE) == len(truth), said)
            for topic in (t for t in wanted if t.split("/")[-1] in ("scan", "points")):
                expect(len(got[topic]) == len(wanted[topic]), f"{name}: {topic} {len(got[topic])} of {len(wanted[topic])}")
                pairs = zip(zip(got[topic], got[topic][1:]), zip(wanted[topic], wanted[topic][1:]))
                worst = max(abs((b - a) - (d - c)) for (a, b), (c, d) in pairs)
                expect(worst < 2e-3, f"{name}: {topic} {worst}")
        result = run("decode", flat, "--source", "192.168.1.201", "--format", "json", "-o", tmp / "frames.json")
        expect(result.returncode == 0 and SENTENCE in result.stderr, result.stderr)
        lasts = max(sensor["duration_s"] for sensor in truth)
        begin = time.monotonic()
        result = run("replay", "-c", ROOT / "config/demo.yaml", "--pcap", flat, "--bag", tmp / "paced.bag")
        expect(0.7 * lasts < time.monotonic() - begin, f"{lasts} s took {time.monotonic() - begin:.1f} s")
    print("ok")


if __name__ == "__main__":
    main()
