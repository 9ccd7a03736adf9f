#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""One line that tells how many tests ctest skipped, and why. Argument: what `ctest --output-junit` wrote."""
import collections
import os
import pathlib
import re
import sys
import xml.etree.ElementTree

NO_CAPTURES = "no real captures, set LIDARD_CAPTURES (test/CAPTURES.md)"


def reason_of(output, folder):
    """What a skipped test said: GoogleTest in the line after `file:line: Skipped`, a script behind `skipped:`."""
    if "LIDARD_CAPTURES" in output:
        return f"real captures that {folder} lacks (test/CAPTURES.md)" if folder else NO_CAPTURES
    said = re.search(r": Skipped\n+(?!\[)(.+)", output) or re.search(r"^skipped: *(.+)", output, re.MULTILINE)
    return said[1].strip() if said else "no reason told"


def summary(report, folder):
    """The line; empty if nothing was skipped."""
    reasons = collections.Counter()
    for case in xml.etree.ElementTree.fromstring(report).iter("testcase"):
        if case.find("skipped") is not None:
            reasons[reason_of(case.findtext("system-out") or "", folder)] += 1
    count = sum(reasons.values())
    if count == 0:
        return ""
    ranked = reasons.most_common()
    why = ranked[0][0] if len(ranked) == 1 else "; ".join(f"{n}: {reason}" for reason, n in ranked)
    return f"{count} test{'s' if count > 1 else ''} skipped: {why}"


def main():
    report = pathlib.Path(sys.argv[1])
    if report.exists():  # ctest -N writes none
        line = summary(report.read_text(errors="replace"), os.environ.get("LIDARD_CAPTURES", ""))
        if line:
            print(line)


if __name__ == "__main__":
    main()
