#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The names that ctest shows are words: no index and no bytes of a parameter. Arguments: ctest and the build folder."""
import re
import subprocess
import sys


def main():
    ctest, build = sys.argv[1:]
    shown = subprocess.run([ctest, "-N"], cwd=build, capture_output=True, text=True, check=True).stdout
    names = re.findall(r"^ *Test +#\d+: (.*)$", shown, re.MULTILINE)
    if len(names) < 100:
        sys.exit(f"ctest knows only {len(names)} tests")
    wrong = [name for name in names if not re.fullmatch(r"[A-Za-z_][\w.]*(/[A-Za-z_]\w*)*(\.\w+(/[A-Za-z_]\w*)*)?", name)]
    print("\n".join(wrong) or f"{len(names)} names are words")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
