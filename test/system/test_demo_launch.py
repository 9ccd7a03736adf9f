#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""`roslaunch lidard demo.launch`: the installed demo in a real rviz, whose window has pixels in the colour of each display.
LIDARD_PICTURE=file.png keeps what it showed. rviz draws with the processor alone here (llvmpipe)."""
import array
import collections
import importlib.util
import os
import pathlib
import shutil
import signal
import struct
import subprocess
import sys
import time
import zlib

import yaml
from harness import LIDARD, ROOT, SKIP, expect, folder, free_port, process, use_master_at

BUILD = pathlib.Path(LIDARD).parent
SIZE = (1400, 900)
LIMIT = 240  # s that a starved machine may take
# The marker of the free area is half transparent before the grey background.
FREE_AREA = (20, 91, 53)
# What must be seen of each display at least.
PIXELS = 25


def read_screen(path):
    """The pixels of Xvfb's screen, 0x00RRGGBB each (XWDFile.h: head of 25 words, colours of 12 bytes, lines)."""
    data = path.read_bytes()
    head = struct.unpack(">25I", data[:100])
    size, width, height, line, colours = head[0], head[4], head[5], head[12], head[19]
    begin = size + 12 * colours
    expect(head[11] == 32 and line == 4 * width, f"a screen of {head[11]} bits")
    pixels = array.array("I", data[begin:begin + line * height])
    if head[7] == 1:
        pixels.byteswap()
    return width, pixels


def save_png(path, width, pixels):
    rows = b"".join(b"\0" + b"".join(struct.pack(">I", p)[1:] for p in pixels[i:i + width]) for i in range(0, len(pixels), width))

    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    head = struct.pack(">IIBBBBB", width, len(pixels) // width, 8, 2, 0, 0, 0)
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def colours_of_displays():
    """Name and colour of each display that shows a topic."""
    displays = yaml.safe_load((ROOT / "config/lidard.rviz").read_text())["Visualization Manager"]["Displays"]
    colours = {d["Name"]: tuple(int(c) for c in d["Color"].split(";")) for d in displays if "Topic" in d and d["Enabled"]}
    return {**colours, "Free area": FREE_AREA}


def count(width, pixels, colours):
    """How many pixels of the view, which is right of the panels, have the colour of each display."""
    found, view = collections.Counter(), collections.Counter()
    for begin in range(width * SIZE[1] // 10, len(pixels), width):
        view.update(pixels[begin + width * 3 // 10:begin + width])
    for value, number in view.items():
        seen = (value >> 16 & 255, value >> 8 & 255, value & 255)
        for name, colour in colours.items():
            if max(abs(a - b) for a, b in zip(seen, colour)) <= 40:
                found[name] += number
    return found


def start_screen(tmp):
    reader, writer = os.pipe()
    screen = process(["Xvfb", "-displayfd", writer, "-screen", "0", f"{SIZE[0]}x{SIZE[1]}x24", "-fbdir", tmp, "-nolisten", "tcp"],
                     pass_fds=[writer], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return screen, reader, writer


def watch(launch, screen_file, colours):
    """The pixels of each display once all are seen, or when time is up."""
    begin = time.monotonic()
    found, width, pixels = {}, 0, []
    while time.monotonic() - begin < LIMIT and launch.poll() is None:
        time.sleep(1)
        width, pixels = read_screen(screen_file)
        found = count(width, pixels, colours)
        if all(found[name] >= PIXELS for name in colours):
            break
    if "LIDARD_PICTURE" in os.environ:
        save_png(pathlib.Path(os.environ["LIDARD_PICTURE"]), width, pixels)
    return found, time.monotonic() - begin


def main():
    for program in ("rviz", "Xvfb", "roslaunch"):
        if not shutil.which(program):
            print(f"skipped: {program} is not installed")
            sys.exit(SKIP)
    if not importlib.util.find_spec("visualization_msgs"):
        print("skipped: python3-visualization-msgs is not installed")
        sys.exit(SKIP)
    with folder() as tmp:
        prefix = tmp / "prefix"
        subprocess.run(["cmake", "--install", str(BUILD), "--prefix", str(prefix), "--component", "lidard"], check=True,
                       stdout=subprocess.DEVNULL, env={k: v for k, v in os.environ.items() if k != "DESTDIR"})
        port = free_port()
        use_master_at(port)
        screen, reader, writer = start_screen(tmp)
        with screen:
            os.close(writer)
            display = os.read(reader, 16).decode().strip()
            os.environ.update(DISPLAY=f":{display}", HOME=str(tmp), LIBGL_ALWAYS_SOFTWARE="1", QT_X11_NO_MITSHM="1",
                              ROS_PACKAGE_PATH=f"{prefix}/share:/usr/share", ROS_LOG_DIR=str(tmp / "log"))
            log = open(tmp / "launch.log", "wb")
            with process(["roslaunch", "-p", port, "lidard", "demo.launch"], stdout=log, stderr=log) as launch:
                colours = colours_of_displays()
                found, seconds = watch(launch, tmp / "Xvfb_screen0", colours)
                missing = [name for name in colours if found.get(name, 0) < PIXELS]
                expect(not missing, f"not seen: {missing}; {dict(found)}\n{(tmp / 'launch.log').read_text()[-3000:]}")
                print(f"after {seconds:.0f} s: {dict(found)}")
                launch.send_signal(signal.SIGINT)
                launch.wait(60)


if __name__ == "__main__":
    main()
