#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""lidard calibrate: mounts that are configured wrong are found from a capture of the parked vehicle, and places that show nothing are refused."""
import json
import math

import yaml

from harness import ROOT, expect, folder, make_capture, run

# Where the sensors of the demo vehicle really are; config/demo.yaml has them as a tape measure gave them.
KNOCKED = {"front_left": ([0, 1, 0.35], [0, 0, 45]), "front_right": ([0.04, -1.03, 0.35], [0, 0, -43.2]),
           "roof": ([0.03, 0.05, 2.04], [0.8, -1.2, 3.5])}
FAR = {"front_right": "{xyz: [0.4, -1.2, 0.35], rpy_deg: [0, 0, -60]}", "roof": "{xyz: [-0.3, 0.2, 2.1], rpy_deg: [2, 3, -14]}"}


def parked(objects=None):
    """The scene of the demo, standing, with knocked mounts; `objects` in place of its own."""
    scene = yaml.safe_load((ROOT / "pcaps/demo.scene.yaml").read_text())
    scene["start"] = "2026-01-01T00:17:23.456Z"
    scene["vehicle"]["path"] = [{"duration": 2.0, "speed": 0, "yaw_rate_deg": 0}]
    for name, (xyz, rpy_deg) in KNOCKED.items():
        scene["sensors"][name]["pose"] = {"xyz": xyz, "rpy_deg": rpy_deg}
    if objects is not None:
        scene["objects"] = objects
    return yaml.safe_dump(scene)


def expect_pose(got, name):
    xyz, rpy_deg = KNOCKED[name]
    for i in range(3):
        expect(abs(got["xyz"][i] - xyz[i]) < 0.003, f"{name}: {got} is not {KNOCKED[name]}")
        expect(abs(math.remainder(got["rpy_deg"][i] - rpy_deg[i], 360)) < 0.03, f"{name}: {got} is not {KNOCKED[name]}")


def check_found(tmp, capture):
    text = (ROOT / "config/demo.yaml").read_text()
    far = text
    for name, pose in FAR.items():
        at = far.index("pose:", far.index(f"  {name}:"))
        far = far[:at] + "pose: " + pose + far[far.index("}", at) + 1:]
    for file, content in (("near.yaml", text), ("far.yaml", far)):
        (tmp / file).write_text(content)
        done = run("calibrate", "-c", tmp / file, capture, "-o", tmp / "new.yaml", "--json")
        expect(done.returncode == 0, done.stderr)
        sensors = json.loads(done.stdout)["sensors"]
        expect(sensors["front_left"]["verdict"] == "reference", done.stdout)
        for name in KNOCKED:
            expect_pose(sensors[name]["after"], name)
        new = (tmp / "new.yaml").read_text()
        for name, sensor in yaml.safe_load(new)["sensors"].items():
            expect_pose({"rpy_deg": [0, 0, 0], **sensor["pose"]}, name)
        before, after = content.splitlines(), new.splitlines()
        changed = [i for i, line in enumerate(before) if line != after[i]]
        expect(len(before) == len(after) and len(changed) == 2 and all("pose:" in before[i] for i in changed), new)
        expect(run("check", tmp / "new.yaml").returncode == 0, "the new file is no configuration")
    table = run("calibrate", "-c", tmp / "far.yaml", capture).stdout
    expect("front_left: the reference" in table and "shared surfaces" in table, table)


def check_refused(tmp):
    walls = [{"wall": {"from": [-100, y], "to": [100, y], "z": [0, 3], "reflectivity": 0.6}} for y in (-4, 4)]
    corridor = make_capture(tmp / "corridor", parked(walls))
    (tmp / "planar.yaml").write_text((ROOT / "config/demo.yaml").read_text().replace("model: velodyne_vlp16", "topic: /roof")
                                     .replace("    ip_address: 192.168.1.201\n    ip_port: 2368\n", ""))
    done = run("calibrate", "-c", tmp / "planar.yaml", corridor, "-o", tmp / "none.yaml")
    expect(done.returncode == 1 and "nothing was determined" in done.stderr, f"{done.returncode} {done.stdout} {done.stderr}")
    expect("not determined" in done.stdout and not (tmp / "none.yaml").exists(), done.stdout)


def main():
    with folder() as tmp:
        capture = make_capture(tmp / "parked", parked())
        check_found(tmp, capture)
        check_refused(tmp)
        done = run("calibrate", "-c", ROOT / "config/demo.yaml", capture, "--reference", "nobody")
        expect(done.returncode == 1 and "--reference nobody" in done.stderr, done.stderr)
        done = run("calibrate", "-c", tmp / "missing.yaml", capture)
        expect(done.returncode == 78, done.stderr)


if __name__ == "__main__":
    main()
