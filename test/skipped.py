#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""One line that tells how many tests were skipped, and why. Arguments: reports that ctest (--output-junit) or GoogleTest wrote."""
import collections
import os
import pathlib
import re
import sys
import xml.etree.ElementTree

NO_CAPTURES = "no real captures, set LIDARD_CAPTURES (test/CAPTURES.md)"


def reason_of(case, folder):
    """Why a test was skipped: GoogleTest has a message behind the place, a script says `skipped: REASON`."""
    text = case.find("skipped").get("message") + "\n" + (case.findtext("system-out") or "")
    if "LIDARD_CAPTURES" in text:
        return f"real captures that {folder} lacks (test/CAPTURES.md)" if folder else NO_CAPTURES
    said = re.search(r"^skipped: *(.+)", text, re.MULTILINE) or re.search(r"^\S+:\d+\n+(.+)", text)
    return said[1].strip() if said else "no reason given"


def summary(reports, folder):
    """The line; empty if nothing was skipped."""
    reasons = collections.Counter()
    for report in reports:
        for case in xml.etree.ElementTree.fromstring(report).iter("testcase"):
            if case.find("skipped") is not None:
                reasons[reason_of(case, folder)] += 1
    count = sum(reasons.values())
    if count == 0:
        return ""
    ranked = reasons.most_common()
    why = ranked[0][0] if len(ranked) == 1 else "; ".join(f"{n}: {reason}" for reason, n in ranked)
    return f"{count} test{'s' if count > 1 else ''} skipped: {why}"


def main():
    reports = [path.read_text(errors="replace") for path in map(pathlib.Path, sys.argv[1:]) if path.exists()]
    line = summary(reports, os.environ.get("LIDARD_CAPTURES", ""))
    if line:
        print(line)


if __name__ == "__main__":
    main()
