#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The allowances of the harness for a busy machine excuse what a busy machine does, and nothing else."""
import contextlib
import os
import subprocess
import time

from harness import Starved, check_stream, expect, process, waited_for_processor

PERIOD = 0.025


def passes(stamps, seconds, starved):
    with contextlib.suppress(SystemExit):
        check_stream("it", stamps, PERIOD, seconds, starved)
        return True
    return False


def streams():
    whole = [1000 + PERIOD * i for i in range(160)]
    expect(passes(whole, 4, 0), "a whole stream")
    expect(passes([t + 0.004 * (i % 2) for i, t in enumerate(whole)], 4, 0), "stamps that tremble")
    one_lost = whole[:50] + whole[51:]
    expect(not passes(one_lost, 4, 0), "a lost frame on a quiet machine")
    expect(passes(one_lost, 4, 0.03), "a frame lost while starved")
    expect(not passes(whole[:50] + whole[60:], 4, 0.03), "more frames lost than starving explains")
    expect(not passes(whole[::2], 4, 0.1), "half the rate")
    expect(not passes(whole, 8, 0.1), "half the rate by the clock of the host")
    expect(not passes(whole[:50] + [t + 0.4 * PERIOD for t in whole[50:]], 4, 1), "a step of the clock")
    expect(not passes(whole[:50] + whole[49:], 4, 1), "a stamp that comes twice")


def starving():
    """Two that want one processor wait for each other about half of the time; one that sleeps waits for nobody."""
    spin = ["/bin/sh", "-c", "while :; do :; done"]
    one = str(min(os.sched_getaffinity(0)))
    with process(["/usr/bin/sleep", "60"]) as idle, process(["/usr/bin/taskset", "-c", one, *spin]) as first, \
            process(["/usr/bin/taskset", "-c", one, *spin], stdout=subprocess.DEVNULL) as second:
        starved, of_idle = Starved(), Starved([idle])
        before = [waited_for_processor(child.pid) for child in (idle, first, second)]
        time.sleep(2)
        waited = [waited_for_processor(child.pid) - b for child, b in zip((idle, first, second), before)]
        total, alone = starved.seconds(), of_idle.seconds()
    print(f"waited in 2 s: asleep {waited[0]:.3f} s, two on one processor {waited[1]:.2f} and {waited[2]:.2f} s")
    expect(waited[0] < 0.05, "who sleeps does not starve")
    expect(alone < total - 1, f"{alone:.2f} s of the one that sleeps alone, {total:.2f} s of all")
    expect(waited[1] + waited[2] > 1 and total >= waited[1] + waited[2] - 0.1, f"two on one processor starve, {total:.2f} s")


def main():
    streams()
    starving()
    print("ok")


if __name__ == "__main__":
    main()
