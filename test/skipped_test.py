#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The line of skipped.py is right for reports of the kinds that ctest 3.25 and GoogleTest 1.12 write."""
from skipped import NO_CAPTURES, summary

PASSED = '<testcase name="t"><system-out>skipped: no</system-out></testcase>'


def gtest(reason):
    message = f"../test/a_test.cpp:145&#x0A;{reason}"
    return f'<testcase name="t" result="skipped"><skipped message="{message}"><![CDATA[../test/a_test.cpp:145\n{reason}]]></skipped></testcase>'


def script(output):
    return f'<testcase name="t" status="notrun"><skipped message="SKIP_RETURN_CODE=77"/><system-out>{output}</system-out></testcase>'


def report(*cases):
    return f'<?xml version="1.0"?><testsuites><testsuite tests="{len(cases)}">{"".join(cases)}</testsuite></testsuites>'


def expect(line, expected):
    assert line == expected, f"{line!r}, expected {expected!r}"


def main():
    capture = gtest("real capture a.pcap not found: set LIDARD_CAPTURES (see test/CAPTURES.md)")
    network = script("skipped: recording needs CAP_NET_RAW\n")
    expect(summary([], ""), "")
    expect(summary([report(), report(PASSED)], ""), "")
    expect(summary([report(capture)], ""), f"1 test skipped: {NO_CAPTURES}")
    expect(summary([report(capture), report(PASSED, capture)], ""), f"2 tests skipped: {NO_CAPTURES}")
    expect(summary([report(capture, capture), report(network)], ""),
           f"3 tests skipped: 2: {NO_CAPTURES}; 1: recording needs CAP_NET_RAW")
    expect(summary([report(capture)], "/data"), "1 test skipped: real captures that /data lacks (test/CAPTURES.md)")
    expect(summary([report(gtest("needs CAP_NET_ADMIN"))], ""), "1 test skipped: needs CAP_NET_ADMIN")
    expect(summary([report(script(""))], ""), "1 test skipped: no reason given")
    print("ok")


if __name__ == "__main__":
    main()
