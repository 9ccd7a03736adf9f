#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The names of all tests are words: no index and no bytes of a parameter. Arguments: GoogleTest programs."""
import re
import subprocess
import sys


def names_of(program):
    """As GoogleTest lists them: a suite in a line, its tests indented below it; behind # the value of a parameter."""
    listed = subprocess.run([program, "--gtest_list_tests"], capture_output=True, text=True, check=True).stdout
    suite = ""
    for line in listed.splitlines():
        name = line.split("#")[0].strip()
        if not line.startswith(" "):
            suite = name
        else:
            yield suite + name


def main():
    names = [name for program in sys.argv[1:] for name in names_of(program)]
    if len(names) < 100:
        sys.exit(f"the programs know only {len(names)} tests")
    wrong = [name for name in names if not re.fullmatch(r"([A-Za-z_]\w*/)?[A-Za-z_]\w*(/[A-Za-z_]\w*)?\.\w+(/[A-Za-z_]\w*)?", name)]
    print("\n".join(wrong) or f"{len(names)} names are words")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
