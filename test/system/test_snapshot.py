#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""lidard snapshot: what is drawn stands where it was measured, and what cannot be drawn is said in one sentence."""
import re
import struct
import subprocess
import xml.etree.ElementTree
import zlib

from harness import LIDARD_SIM, ROOT, expect, folder, run

# A vehicle with a scanner on each front corner between walls; a box stands 2 m ahead.
SCENE = """
start: 2026-01-01T00:00:00Z
duration: 0.6
seed: 1
sensors:
  left:
    model: sick_microscan3
    pose: {xyz: [0, 1, 0.35], rpy_deg: [0, 0, 45]}
    from: 192.168.0.21:6060
    to: 192.168.0.100:6060
    phase_ms: 0
  right:
    model: sick_microscan3
    pose: {xyz: [0, -1, 0.35], rpy_deg: [0, 0, -45]}
    from: 192.168.0.22:6060
    to: 192.168.0.100:6060
    phase_ms: 15
vehicle:
  start: {xy: [0, 0]}
  body:
    - box: {center: [-2.05, 0, 0.9], size: [3.9, 1.8, 1.4], reflectivity: 0.35}
objects:
  - wall: {from: [-20, -12], to: [20, -12], z: [0, 3], reflectivity: 0.6}
  - wall: {from: [20, -12], to: [20, 12], z: [0, 3], reflectivity: 0.6}
  - wall: {from: [20, 12], to: [-20, 12], z: [0, 3], reflectivity: 0.6}
  - wall: {from: [-20, 12], to: [-20, -12], z: [0, 3], reflectivity: 0.6}
  - box: {center: [2.5, 0, 0.5], size: [1, 1, 1], reflectivity: 0.6}
"""
CONFIG = """
vehicle:
  footprint: [[-4.0, -1.0], [0.1, -1.0], [0.1, 1.0], [-4.0, 1.0]]
sensors:
  left: {model: sick_microscan3, ip_address: 192.168.0.21, pose: {xyz: [0, 1, 0.35], rpy_deg: [0, 0, 45]}}
  right: {model: sick_microscan3, ip_address: 192.168.0.22, pose: {xyz: [0, -1, 0.35], rpy_deg: [0, 0, -45]}}
merged_scans:
  around:
    laserscan_topics: [left, right]
    destination_frame: base_link
    profile: strict
    range_max: 30
    beams: 1440
"""


class Png:
    """Just enough of PNG to look at pixels: 8 bits per channel, RGB."""

    def __init__(self, data):
        expect(data[:8] == b"\x89PNG\r\n\x1a\n", "PNG signature")
        self.width, self.height, depth, kind = struct.unpack(">IIBB", data[16:26])
        expect((depth, kind) == (8, 2), f"depth {depth}, colour type {kind}")
        packed, at = b"", 8
        while at < len(data):
            length, name = struct.unpack(">I4s", data[at:at + 8])
            packed += data[at + 8:at + 8 + length] if name == b"IDAT" else b""
            at += length + 12
        self.rows = self.unfilter(zlib.decompress(packed))

    def unfilter(self, raw):
        step = self.width * 3
        rows, above = [], bytearray(step)
        for y in range(self.height):
            kind, *line = raw[y * (step + 1):(y + 1) * (step + 1)]
            row = bytearray(line)
            for i in range(step):
                a, b = row[i - 3] if i >= 3 else 0, above[i]
                c = above[i - 3] if i >= 3 else 0
                nearest = min((abs(b - c), 0, a), (abs(a - c), 1, b), (abs(a + b - 2 * c), 2, c))[2]
                row[i] = (row[i] + (0, a, b, (a + b) // 2, nearest)[kind]) & 255
            rows.append(row)
            above = row
        return rows

    def around(self, x, y, reach=2):
        return [tuple(self.rows[v][3 * u:3 * u + 3]) for v in range(y - reach, y + reach + 1) for u in range(x - reach, x + reach + 1)]


# The picture's field, and the colours of its roles.
LEFT, TOP, WIDTH, HEIGHT = 20, 76, 872, 872
BLUE, ORANGE, BLACK, FREE, UNKNOWN = (0, 115, 179), (214, 94, 0), (0, 0, 0), (219, 242, 227), (232, 227, 222)


def has(pixels, color):
    return any(max(abs(a - b) for a, b in zip(pixel, color)) < 14 for pixel in pixels)


def check_pixels(picture, half):
    scale = WIDTH / (2 * half)

    def at(ahead, left, reach=2):
        return picture.around(round(LEFT + WIDTH / 2 - left * scale), round(TOP + HEIGHT / 2 - ahead * scale), reach)

    expect((picture.width, picture.height) == (1192, 968), f"{picture.width} x {picture.height} pixels")
    for name, left, color in (("left", 0.5, BLUE), ("right", -0.5, ORANGE)):
        expect(has(at(2.5, left), color), f"the {name} scanner's returns on its side of the box 2 m ahead")
    expect(has(at(2.0, 0.2), BLACK), "the merged scan on the box")
    for left, color in ((11.99, BLUE), (-11.99, ORANGE)):
        expect(has(at(-6.0, left), color), f"the wall at {left} m")
    expect(has(at(1.0, 0.15, 0), FREE) and has(at(5.3, 6.1, 0), FREE), "free before the box and beside it")
    expect(has(at(-9.0, 0.0, 4), UNKNOWN), "nobody sees behind the vehicle")
    expect(not has(at(-9.0, 0.0, 4), FREE), "free behind the vehicle")
    expect(not has(at(4.0, 0.0, 1), FREE), "free behind the box")


def check_errors(tmp, capture):
    config = tmp / "v.yaml"
    cases = [
        (["-c", config, "--pcap", tmp / "none.pcap", "-o", tmp / "a.png"], 1, "none.pcap"),
        (["-c", tmp / "none.yaml", "--pcap", capture, "-o", tmp / "a.png"], 78, "none.yaml"),
        (["-c", config, "--pcap", capture, "-o", tmp / "no" / "a.png"], 1, "cannot be opened for writing"),
        (["-c", config, "--pcap", capture], 2, "output"),
        (["-o", tmp / "a.png"], 2, "a capture is required, or a configuration"),
        (["-c", config, "--areas", "nope", "-o", tmp / "a.png"], 1, "'nope'"),
    ]
    for arguments, code, words in cases:
        result = run("snapshot", *arguments)
        expect(result.returncode == code, f"{arguments}: exit {result.returncode}, {result.stderr}")
        expect(re.search(words, result.stderr), f"{arguments}: {result.stderr}")
        expect(not (tmp / "a.png").exists(), f"{arguments}: a picture was begun")


def check_without_capture(tmp):
    """The field of view of each scanner, and what the merged scan can see of an empty field."""
    config = tmp / "field.yaml"
    config.write_text(CONFIG.replace("[0.1, ", "[0.0, "))
    for end in ("png", "svg"):
        result = run("snapshot", "-c", config, "--range", "13", "-o", tmp / f"field.{end}")
        expect(result.returncode == 0 and not result.stderr, result.stderr)
    picture, scale = Png((tmp / "field.png").read_bytes()), WIDTH / 26

    def at(ahead, left, reach):
        return picture.around(round(LEFT + WIDTH / 2 - left * scale), round(TOP + HEIGHT / 2 - ahead * scale), reach)

    expect(has(at(5.3, 6.1, 0), FREE) and has(at(5.3, -6.1, 0), FREE), "free ahead")
    expect(has(at(-9.0, 0.0, 4), UNKNOWN) and not has(at(-9.0, 0.0, 4), FREE), "nobody sees behind the vehicle")
    # The left scanner looks 45 degrees to the left, and 137.5 degrees to either side of that.
    expect(has(at(-9.0, 0.61, 3), BLUE) and has(at(-9.0, -0.61, 3), ORANGE), "the ends of the fields of view")
    words = "".join(xml.etree.ElementTree.parse(tmp / "field.svg").getroot().itertext())
    for name in ("around", "+inf in an empty field", "fields of view", "the vehicle itself stands in the way"):
        expect(name in words, f"{name} is not in the SVG")


def main():
    with folder() as tmp:
        check_without_capture(tmp)
        (tmp / "v.scene.yaml").write_text(SCENE)
        (tmp / "v.yaml").write_text(CONFIG)
        subprocess.run([LIDARD_SIM, "make", tmp / "v.scene.yaml", "-o", tmp / "v"], check=True, stdout=subprocess.DEVNULL)
        for name in ("a", "b"):
            result = run("snapshot", "-c", tmp / "v.yaml", "--pcap", tmp / "v.pcap", "--range", "13", "-o", tmp / f"{name}.png")
            expect(result.returncode == 0, result.stderr)
        expect((tmp / "a.png").read_bytes() == (tmp / "b.png").read_bytes(), "two pictures of one moment differ")
        check_pixels(Png((tmp / "a.png").read_bytes()), 13)
        (tmp / "a.png").unlink()
        check_errors(tmp, tmp / "v.pcap")
        svg = tmp / "demo.svg"
        result = run("snapshot", "-c", ROOT / "config/demo.yaml", "--pcap", ROOT / "pcaps/demo.pcap", "-o", svg)
        expect(result.returncode == 0 and not result.stderr, result.stderr)
        words = "".join(xml.etree.ElementTree.parse(svg).getroot().itertext())
        for name in ("front_left", "front_right", "roof", "scan_multi", "bumper", "chest", "2026-01-01"):
            expect(name in words, f"{name} is not in the SVG")
        expect(svg.stat().st_size < 1_500_000, f"the SVG has {svg.stat().st_size} bytes")
    print("ok")


if __name__ == "__main__":
    main()
