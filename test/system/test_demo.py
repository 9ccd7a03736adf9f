#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""daemon/demo of a tree that is built: a line per step with its usual time, the rest in a file that is named, in under a minute; it
says what it is and what to do next."""
import os
import pathlib
import re
import subprocess
import time

from harness import LIDARD, ROOT, Starved, expect

LIMIT = 60  # s


def main():
    build = pathlib.Path(LIDARD).parent
    starved, begin = Starved(), time.monotonic()
    done = subprocess.run([ROOT / "daemon/demo"], env={**os.environ, "LIDARD_BUILD_DIR": str(build)}, stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, timeout=280)
    seconds = time.monotonic() - begin
    said = done.stdout
    expect(done.returncode == 0, said)
    # The steps run in processes that have ended: on a busy machine each second of processor lasts several.
    patience = LIMIT * max(1.0, os.getloadavg()[0] / os.cpu_count()) + starved.seconds()
    expect(seconds < patience, f"{seconds:.0f} s, at most {patience:.0f}")
    expect("a simulated drive" in said.splitlines()[0], said)
    steps = re.findall(r"^(\d)/4 .*\(.*(?:s|min)\b.*\)(?: \.\.\. \d+ s)?$", said, re.MULTILINE)
    expect(steps == ["1", "2", "3", "4"], said)
    expect(re.search(r"^  /footprint .* 1 messages +once$", said, re.MULTILINE), said)
    unasked = re.findall(r"/(?:system_state|output_paths|intrusion|beam_status) ", said)
    expect(not unasked, f"the configuration asks for no states of the scanners, but there are {unasked}\n{said}")
    for topic in ("front_left/scan", "roof/points", "scan_multi", "scan_strict", "chest"):
        found = re.search(rf"^  /{topic} .* (\d+) messages +[\d.]+ Hz$", said, re.MULTILINE)
        expect(found and int(found.group(1)) > 10, f"{topic}\n{said}")
    expect("\nNext:\n" in said and len(said.splitlines()) <= 50, said)
    log = pathlib.Path(re.search(r"All output: (\S+)", said).group(1))
    expect("packets" in log.read_text(), f"{log} holds no output of the replay")
    picture = pathlib.Path(re.search(r"a picture .*: (\S+)", said).group(1))
    expect(picture.stat().st_mtime > time.time() - seconds - 5, "the picture is not of this run")
    print(f"{seconds:.1f} s")


if __name__ == "__main__":
    main()
