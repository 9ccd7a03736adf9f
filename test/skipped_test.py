#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The line of skipped.py is right for reports of the kind that ctest 3.25 writes."""
from skipped import NO_CAPTURES, summary

CASE = '<testcase name="{name}" status="{status}">{skipped}<system-out>{output}</system-out></testcase>'
SKIPPED = '<skipped message="SKIP_REGULAR_EXPRESSION_MATCHED"/>'


def gtest(reason):
    return f"[ RUN      ] A.B\n../test/a_test.cpp:145: Skipped\n{reason}\n[  SKIPPED ] A.B (0 ms)\n"


def report(*cases):
    text = "".join(CASE.format(name=f"t{i}", status="notrun" if skipped else "run", skipped=SKIPPED if skipped else "",
                               output=output) for i, (skipped, output) in enumerate(cases))
    return f'<?xml version="1.0"?><testsuite tests="{len(cases)}">{text}</testsuite>'


def expect(line, expected):
    assert line == expected, f"{line!r}, expected {expected!r}"


def main():
    capture = (True, gtest("real capture a.pcap not found: set LIDARD_CAPTURES (see test/CAPTURES.md)"))
    # A test that passed has skipped nothing, whatever it says.
    passed = (False, gtest("real capture a.pcap not found: set LIDARD_CAPTURES (see test/CAPTURES.md)"))
    script = (True, "skipped: recording needs CAP_NET_RAW\n")
    expect(summary(report(), ""), "")
    expect(summary(report(passed), ""), "")
    expect(summary(report(capture), ""), f"1 test skipped: {NO_CAPTURES}")
    expect(summary(report(capture, passed, capture), ""), f"2 tests skipped: {NO_CAPTURES}")
    expect(summary(report(capture, script, capture), ""),
           f"3 tests skipped: 2: {NO_CAPTURES}; 1: recording needs CAP_NET_RAW")
    expect(summary(report(capture), "/data"), "1 test skipped: real captures that /data lacks (test/CAPTURES.md)")
    expect(summary(report((True, gtest("needs CAP_NET_ADMIN"))), ""), "1 test skipped: needs CAP_NET_ADMIN")
    expect(summary(report((True, "[  SKIPPED ] A.B (0 ms)\n")), ""), "1 test skipped: no reason told")
    print("ok")


if __name__ == "__main__":
    main()
