#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""inspect on every capture there is: the right models, or others beside them among which the right one is; the printed
configuration passes check and replays what it promises."""
import json
import os
import pathlib
import re
import subprocess

from harness import ROOT, expect, folder, run

CAPTURES = os.environ.get("LIDARD_CAPTURES", "")
NOTHING = []
VLP16 = ["velodyne_vlp16"]
UNKNOWN = None  # in a new report: anything goes but a crash or silence
# What was recorded, by its publisher (MANIFEST.md of the captures); a folder or file name, the longest that fits counts.
RECORDED = {
    "bags": NOTHING,
    "burst": VLP16,
    "burst/hdl64e_s1": ["velodyne_hdl64e_s1"],
    "odd": VLP16,  # relatives of velodyne/vlp16_2014_says_hdl32.pcap
    "odd/bad_magic.pcap": NOTHING,
    "odd/empty.pcap": NOTHING,
    "odd/ouster_sdk": NOTHING,
    "odd/pcapng_suite": NOTHING,
    "odd/sick_lls_udp5009_office_noise.pcapng": NOTHING,
    "odd/zero.pcap": NOTHING,
    "reports/01-window-over-pi": ["sick_nav31x"],
    "reports/04-capture-without-arrival-times": ["sick_lms1xx"],
    "reports/11-position-only": NOTHING,
    "reports/12-identity-by-sRI0": ["sick_tim5xx"],
    "reports/14-dist2-only": ["sick_lms1xx"],
    "reports/20-tim310-592": ["sick_tim5xx"],  # a TiM310, which has no row of its own
    "sick/lms111_": ["sick_lms1xx"],
    "sick/lms511_": ["sick_lms5xx"],
    "sick/lms5xx_": ["sick_lms5xx"],
    "sick/microscan3_": ["sick_microscan3"],
    "sick/mrs1": ["sick_mrs1000"],
    "sick/multiscan_": ["sick_multiscan136"],
    "sick/picoscan150_": ["sick_picoscan150"],
    "sick/rms1xxx_": NOTHING,
    "sick/tim5": ["sick_tim5xx"],
    "sick/tim7": ["sick_tim7xxs"],  # both are of a TiM781S
    "velodyne/hdl32e": ["velodyne_hdl32e"],
    "velodyne/hdl64e_s1": ["velodyne_hdl64e_s1"],
    "velodyne/vlp16": VLP16,
    "velodyne/vlp16_position_only": NOTHING,  # telemetry alone
    "velodyne/vlp32c": ["velodyne_vlp32c"],
    "velodyne/vls128": ["velodyne_vls128"],
}


def simulated(path):
    """The models of the scene that the capture was made from."""
    scene = path.with_name(path.stem + ".scene.yaml").read_text()
    return re.findall(r"^\s+model: (\S+)", scene, re.MULTILINE)


def recorded(path):
    name = str(path.relative_to(CAPTURES))
    fitting = [known for known in RECORDED if name.startswith(known)]
    if not fitting and name.startswith("reports/"):
        return UNKNOWN
    expect(fitting, f"{name}: nobody says what it holds; add it to RECORDED")
    return RECORDED[max(fitting, key=len)]


def named(sensor):
    """The model reported, the others beside it, and those that the remark names."""
    return [sensor["model"], *sensor["others"], *re.findall(r"[a-z]+_[a-z0-9_]+", sensor.get("remark", ""))]


def check_capture(path, models, tmp):
    """What is wrong with it, in a word; None if nothing is."""
    result = run("inspect", path, "--json", timeout=60)
    if models is UNKNOWN:
        said = run("inspect", path, timeout=60)
        is_sane = said.returncode in (0, 1) and (said.stdout + said.stderr).strip()
        return None if is_sane else f"ended with {said.returncode} and says: {said.stderr}"
    found = json.loads(result.stdout)
    sensors = found["sensors"]
    if len(sensors) != len(models):
        return f"{len(sensors)} sensors, {len(models)} expected"
    for sensor in sensors:
        if not set(named(sensor)) & set(models):
            return f"{sensor['model']} instead of {models}, others {sensor['others']}"
    if not sensors:
        return None
    config = tmp / "found.yaml"
    text = run("inspect", path, timeout=60).stdout
    for sensor in sensors:
        for other in sensor["others"]:
            if f"    # model: {other}" not in text:
                return f"{other} is no comment of the configuration"
    config.write_text(text)
    checked = run("check", config)
    if checked.returncode != 0:
        return "check refuses the configuration: " + checked.stderr
    (tmp / "found.bag").unlink(missing_ok=True)
    replayed = run("replay", "-c", config, "--pcap", path, "--rate", "max", "--bag", tmp / "found.bag", timeout=60)
    if not all(sensor["frames"] > 0 for sensor in sensors):
        return None
    # A capture that ends inside its last record gives what came before it; one that is damaged ends with 1.
    broken = any(capture["error"] for capture in found["captures"])
    damaged = result.returncode != 0
    if replayed.returncode != (1 if damaged else 0):
        return f"replay ended with {replayed.returncode}: {replayed.stderr}"
    if broken and "what came before it was used" not in replayed.stderr:
        return f"replay does not say what it used: {replayed.stderr}"
    return None


def captures():
    for path in sorted((ROOT / "pcaps").glob("*.pcap")):
        yield path, simulated(path)
    if CAPTURES:
        for path in sorted(p for p in pathlib.Path(CAPTURES).rglob("*") if p.suffix in (".pcap", ".pcapng")):
            yield path, recorded(path)


def main():
    count, wrong = 0, []
    with folder() as tmp:
        for path, models in captures():
            count += 1
            try:
                problem = check_capture(path, models, tmp)
            except subprocess.TimeoutExpired as hung:
                problem = f"{hung.cmd[1]} does not end"
            if problem:
                wrong.append(f"{path.name}: {problem}")
    print(f"{count} captures")
    expect(not wrong, "\n".join([f"{len(wrong)} of {count}", *wrong]))


main()
