#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The manual page and the completion know every command and option that `lidard --help` knows, and no other. lidard.yaml(5) has the
keys that `lidard keys --man` prints; groff finds nothing wrong in either page."""
import json
import os
import pathlib
import re
import subprocess
import sys

LIDARD = os.environ["LIDARD"]
ROOT = pathlib.Path(os.environ["LIDARD_SOURCE_DIR"])
PAGE = ROOT / "daemon/lidard.8"
CONFIGURATION = ROOT / "daemon/lidard.yaml.5"


def output(*command, **environment):
    done = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **environment}, check=False)
    return done.returncode, done.stdout, done.stderr


def help_of(*command):
    code, text, _ = output(LIDARD, *command, "--help")
    assert code == 0 and text, f"lidard {' '.join(command)} --help: exit {code}"
    return text


def commands():
    """Names below `Subcommands:`, each indented by two blanks."""
    listed = help_of().split("Subcommands:", 1)[1]
    return re.findall(r"^  ([a-z]+)\s", listed, re.MULTILINE)


def options(text):
    return set(re.findall(r"(?<![\w-])--[a-z][a-z-]*", text))


def page_sections(text):
    """Text of each command in the page's COMMANDS, by name."""
    body = text.split("\nCOMMANDS\n", 1)[1].split("\nCONFIGURATION\n", 1)[0]
    parts = re.split(r"^ {7}([a-z]+)(?= |$)", body, flags=re.MULTILINE)
    return dict(zip(parts[1::2], parts[2::2]))


def completed(*words):
    """What bash offers for the last word of a line of `lidard`."""
    script = 'source "$1"; shift; COMP_WORDS=(lidard "$@"); COMP_CWORD=$#; _lidard lidard "${!#}" "${COMP_WORDS[-2]}"; printf "%s\\n" "${COMPREPLY[@]}"'
    path = f"{pathlib.Path(LIDARD).parent}:{os.environ['PATH']}"
    return set(output("bash", "-c", script, "bash", str(ROOT / "daemon/completion.bash"), *words, PATH=path)[1].split())


def main():
    code, text, warnings = output("man", "--warnings", "-l", str(PAGE), MANWIDTH="300", LC_ALL="C.UTF-8", MANPAGER="cat")
    text = re.sub(".\b", "", text)
    assert code == 0 and not warnings, f"man: exit {code}, {warnings}"
    described = page_sections(text)
    known = commands()
    assert known and set(described) == set(known), f"page has {sorted(described)}, --help has {sorted(known)}"
    name, synopsis = (text.split(f"\n{part}\n", 1)[1].split("\n\n", 1 if part == "NAME" else 2) for part in ("NAME", "SYNOPSIS"))
    vendors = {model["vendor"] for model in json.loads(output(LIDARD, "models", "--json")[1])}
    assert vendors and all(vendor in name[0] for vendor in vendors), f"{vendors} are not all in {name[0]}"
    listed = set(re.findall(r"[a-z]+", " ".join(synopsis[:2])))
    assert set(known) <= listed, f"the synopsis lacks {set(known) - listed}"
    general = options(text.split("\nCOMMANDS\n", 1)[0])
    assert set(known) <= completed(""), f"completion lacks {set(known) - completed('')}"
    assert completed("decode", "--calibration-model", "") == {"ros_drivers", "exact", "veloview"}
    assert "velodyne_vlp16" in completed("decode", "--model", "")
    for command in known:
        real = options(help_of(command))
        missing = real - options(described[command]) - general
        invented = options(described[command]) - real
        assert not missing and not invented, f"{command}: page lacks {missing}, invents {invented}"
        offered = completed(command, "--")
        assert offered == real, f"{command}: completion lacks {real - offered}, invents {offered - real}"
    code, _, warnings = output("man", "--warnings", "-l", str(CONFIGURATION), LC_ALL="C.UTF-8", MANPAGER="cat")
    assert code == 0 and not warnings, f"man: exit {code}, {warnings}"
    for part in ("RELOAD", "SIGNALS", "ENVIRONMENT", "FILES", "TROUBLESHOOTING", "REAL TIME"):
        assert f"\n{part}\n" in text, f"the page lacks {part}"
    print(f"{len(known)} commands agree")


if __name__ == "__main__":
    try:
        main()
    except AssertionError as error:
        sys.exit(f"FAILED: {error}")
