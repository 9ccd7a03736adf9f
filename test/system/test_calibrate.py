#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""lidard calibrate: mounts that are configured wrong are found from a capture of the parked vehicle, places on the vehicle and time offsets from one of
a drive with its odometry, and what these show nothing of is refused."""
import json
import math
import re

import rosbag
import rospy
import yaml
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from tf2_msgs.msg import TFMessage

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
        scene["objects"], scene["vehicle"]["start"] = objects, {"xy": [-2, 0.5], "yaw_deg": 0}
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


def check_multi_plane(tmp):
    """The ground and the walls by lidars of other rings, upright and upside down."""
    for model, roll in (("velodyne_vls128", 0), ("velodyne_hdl64e_s1", 0), ("velodyne_vlp32c", 180), ("velodyne_hdl64e_s3", 180)):
        scene, config = yaml.safe_load(parked()), yaml.safe_load((ROOT / "config/demo.yaml").read_text())
        scene["duration"] = 0.7
        del scene["sensors"]["roof"]["options"], scene["sensors"]["roof"]["clock_offset"]
        scene["sensors"]["roof"] |= {"model": model, "noise": 0.01, "pose": {"xyz": [0.03, 0.05, 2.04], "rpy_deg": [roll + 0.8, -1.2, 3.5]}}
        roof = {"model": model, "ip_address": "192.168.1.201", "pose": {"xyz": [0, 0, 1.8], "rpy_deg": [roll, 0, 0]}}
        (tmp / "rings.yaml").write_text(yaml.safe_dump({"sensors": config["sensors"] | {"roof": roof}}))
        done = run("calibrate", "-c", tmp / "rings.yaml", make_capture(tmp / f"{model}_{roll}", yaml.safe_dump(scene)), "--json")
        found = json.loads(done.stdout)["sensors"]["roof"]
        if model == "velodyne_hdl64e_s3":
            # Upside down it looks 2 degrees down and sees walls alone.
            expect(found["deviation"]["z"] is None and found["after"]["xyz"][2] == 1.8, f"{model}: {found}")
            continue
        for got, want in zip(found["after"]["xyz"] + found["after"]["rpy_deg"], (0.03, 0.05, 2.04, roll + 0.8, -1.2, 3.5)):
            expect(abs(math.remainder(got - want, 360)) < 0.01, f"{model}: {found}")


PLANAR = ((ROOT / "config/demo.yaml").read_text().replace("model: velodyne_vlp16", "topic: /roof")
          .replace("    ip_address: 192.168.1.201\n    ip_port: 2368\n", ""))


def walls(*lines):
    return [{"wall": {"from": a, "to": b, "z": [0, 3], "reflectivity": 0.6}} for a, b in lines]


def check_refused(tmp):
    room = make_capture(tmp / "room", parked(walls(([-9, -6], [9, -6]), ([9, -6], [9, 6]), ([9, 6], [-9, 6]), ([-9, 6], [-9, -6]))))
    (tmp / "planar.yaml").write_text(PLANAR)
    done = run("calibrate", "-c", tmp / "planar.yaml", room, "-o", tmp / "none.yaml")
    expect(done.returncode == 1 and "nothing was determined" in done.stderr, f"{done.returncode} {done.stdout} {done.stderr}")
    expect("not determined" in done.stdout and not (tmp / "none.yaml").exists(), done.stdout)


def check_corridor(tmp):
    """Along a corridor x stays as configured, and y and yaw are found, from packets and from a bag."""
    capture = make_capture(tmp / "corridor", parked(walls(*(([-100, y], [100, y]) for y in (-4, 4)))))
    (tmp / "planar.yaml").write_text(PLANAR)
    run("replay", "-c", tmp / "planar.yaml", capture, "--rate", "max", "--bag", tmp / "corridor.bag")
    topics = "".join(f"  {name}: {{topic: {name}/scan, pose: {{xyz: [0, {y}, 0.35], rpy_deg: [0, 0, {45 * y}]}}}}\n" for name, y in (("front_left", 1), ("front_right", -1)))
    (tmp / "topics.yaml").write_text("sensors:\n" + topics)
    for config, source in (("planar.yaml", capture), ("topics.yaml", tmp / "corridor.bag")):
        done = run("calibrate", "-c", tmp / config, source, "-o", tmp / "new.yaml")
        expect(done.returncode == 0 and re.search(r"front_right: not determined: a shift along \(-?1.00, -?0.00\); kept as configured there", done.stdout), done.stdout + done.stderr)
        pose = yaml.safe_load((tmp / "new.yaml").read_text())["sensors"]["front_right"]["pose"]
        expect(abs(pose["xyz"][0]) < 0.001 and abs(pose["xyz"][1] + 1.03) < 0.003 and abs(pose["rpy_deg"][2] + 43.2) < 0.03, f"{config}: {pose}")


def check_forms(tmp, capture):
    """Poses in block style are written in place, and one that an anchor gives to another sensor is not."""
    config = PLANAR.replace("{xyz: [0.0, -1.0, 0.35], rpy_deg: [0, 0, -45]}", "\n      xyz:   # by tape\n      - 0.0\n      - -1.0   # to the right\n      - 0.35\n      rpy_deg: [0, 0, -45]")
    expect("by tape" in config, config)
    (tmp / "block.yaml").write_text(config)
    done = run("calibrate", "-c", tmp / "block.yaml", capture, "-o", tmp / "new.yaml")
    expect(done.returncode == 0, done.stderr)
    new = (tmp / "new.yaml").read_text()
    expect_pose(yaml.safe_load(new)["sensors"]["front_right"]["pose"], "front_right")
    pairs = list(zip(config.splitlines(), new.splitlines()))
    expect(len(new.splitlines()) == len(pairs) and sum(a != b for a, b in pairs) == 3 and "   # to the right" in new, new)
    (tmp / "anchor.yaml").write_text(config.replace("  front_right:", "  front_right: &right").replace("  roof:\n", "  spare:\n    <<: *right\n    ip_address: 192.168.0.23\n    frame_id: spare_laser\n  roof:\n", 1))
    done = run("calibrate", "-c", tmp / "anchor.yaml", capture, "-o", tmp / "none.yaml")
    expect(done.returncode == 78 and "sensors.spare shares its mount with another sensor by an anchor; expected its own: time_offset: 0, pose: {xyz: [0, -1, 0.35], rpy_deg: [0, 0, -45]}" in done.stderr, done.stderr)
    expect(not (tmp / "none.yaml").exists(), "written in spite of the anchor")


def check_moving(tmp):
    """A capture of a drive without its odometry is refused, one of a vehicle that somebody passes is not."""
    (tmp / "planar.yaml").write_text(PLANAR)
    scene = yaml.safe_load(parked())
    scene["duration"] = 6.0
    scene["vehicle"]["path"] = [{"duration": 2.5, "speed": 0, "yaw_rate_deg": 0}, {"duration": 2, "speed": 0.5, "yaw_rate_deg": 10}, {"duration": 2, "speed": 0, "yaw_rate_deg": 0}]
    for config in ("planar.yaml", ROOT / "config/demo.yaml"):
        done = run("calibrate", "-c", tmp / config, make_capture(tmp / "moving", yaml.safe_dump(scene)), "-o", tmp / "none.yaml")
        seen = re.search(r"the vehicle moves in this capture: front_left sees it go at least ([\d.]+) m and turn by ([\d.]+) deg from ([\d.]+) s on; record while it stands, or give its odometry with --motion", done.stderr)
        expect(done.returncode == 1 and seen and not (tmp / "none.yaml").exists(), done.stderr)
        way, turn, time = (float(number) for number in seen.groups())
        expect(0.85 < way < 1.1 and abs(turn - 20) < 1 and 2.4 < time < 3.6, done.stderr)


def check_another_grid(tmp, capture):
    """A scanner whose beams are changed within a recording: what is left out is told, and the rest is used."""
    run("replay", "-c", ROOT / "config/demo.yaml", capture, "--rate", "max", "--bag", tmp / "grid.bag")
    scans = {name: [] for name in ("front_left", "front_right")}
    with rosbag.Bag(str(tmp / "grid.bag")) as bag:
        for topic, message, stamp in bag.read_messages([f"/{name}/scan" for name in scans]):
            scans[topic.split("/")[1]].append((message, stamp))
    left_out = 0
    with rosbag.Bag(str(tmp / "changed.bag"), "w") as bag:
        for name, messages in scans.items():
            for i, (message, stamp) in enumerate(messages):
                if name == "front_right" and i >= len(messages) * 2 // 3:
                    message.ranges, message.intensities, message.angle_increment = message.ranges[::2], message.intensities[::2], 2 * message.angle_increment
                    left_out += 1
                bag.write(f"/{name}/scan", message, stamp)
    sensors = "".join(f"  {name}: {{topic: {name}/scan, pose: {{xyz: [0, {y}, 0.35], rpy_deg: [0, 0, {45 * y}]}}}}\n" for name, y in (("front_left", 1), ("front_right", -1)))
    (tmp / "grid.yaml").write_text("sensors:\n" + sensors)
    done = run("calibrate", "-c", tmp / "grid.yaml", "--bag", tmp / "changed.bag", "--json")
    found = json.loads(done.stdout)["sensors"]
    whole = len(scans["front_right"])
    expect([one["frames_left_out"] for one in found.values()] == [0, left_out] and found["front_right"]["frames"] == whole - left_out > 0, done.stdout)
    expect_pose(found["front_right"]["after"], "front_right")
    text = run("calibrate", "-c", tmp / "grid.yaml", "--bag", tmp / "changed.bag").stdout
    lines = [line for line in text.splitlines() if "left out" in line]
    expect(len(lines) == 1 and lines[0].startswith("front_right: ") and f"{left_out} of {whole} scans of the stop are left out" in lines[0], text)


# How late the scanners' datagrams are, us, which their stamps then are, too; and where they are on the vehicle.
LATE = {"front_left": 12000, "front_right": 5000, "roof": 20}
ON_VEHICLE = {**KNOCKED, "front_left": ([0.03, 0.98, 0.35], [0, 0, 46.1])}
CONSTANT = [{"duration": 25, "speed": 1.0, "yaw_rate_deg": 25}]
STRAIGHT = [{"duration": 20, "speed": 0.6, "yaw_rate_deg": 0}]


def winding(seconds):
    """Curves to both sides, with a turn rate that swings by 0.5 rad/s."""
    rate = [0.25 * (1 if t < 5 * seconds else -1) + 0.5 * math.sin(0.1 * t) for t in range(10 * seconds)]
    return [{"duration": 0.1, "speed": 1.2, "yaw_rate_deg": math.degrees(w)} for w in rate]


def driving(legs, stop=0, sensors=("front_left", "front_right")):
    """The scene of the demo without what moves, with ranges and odometry that are noisy."""
    scene = yaml.safe_load((ROOT / "pcaps/demo.scene.yaml").read_text())
    legs = [{"duration": stop, "speed": 0, "yaw_rate_deg": 0}] * (stop > 0) + legs
    scene["start"] = "2026-01-01T00:17:23.456Z"
    scene["duration"] = sum(leg["duration"] for leg in legs)
    scene["vehicle"] |= {"path": legs, "start": {"xy": [-5, -5], "yaw_deg": 10}, "odometry": {"scale": 1.01, "noise": 0.002, "turn_noise_deg": 0.1}}
    scene["objects"] = [one for one in scene["objects"] if "waypoints" not in str(one) and "velocity" not in str(one)]
    scene["sensors"] = {name: scene["sensors"][name] for name in sensors}
    for name, sensor in scene["sensors"].items():
        xyz, rpy_deg = ON_VEHICLE[name]
        sensor |= {"pose": {"xyz": xyz, "rpy_deg": rpy_deg}, "noise": 0.01, "latency_us": LATE[name], "range_offset": 0.01 if name == "front_left" else 0}
    return yaml.safe_dump(scene)


def write_bag(path, table, with_tf):
    """The odometry of a table as tf or as messages of a topic."""
    with rosbag.Bag(str(path), "w") as bag:
        for row in table.read_text().splitlines()[1:]:
            stamp, x, y, yaw = (float(number) for number in row.split(","))
            time = rospy.Time.from_sec(stamp)
            message = TransformStamped() if with_tf else Odometry()
            message.header.stamp, message.header.frame_id, message.child_frame_id = time, "odom", "base_link"
            at, turn = (message.transform.translation, message.transform.rotation) if with_tf else (message.pose.pose.position, message.pose.pose.orientation)
            at.x, at.y, turn.z, turn.w = x, y, math.sin(yaw / 2), math.cos(yaw / 2)
            bag.write("/tf" if with_tf else "/odom", TFMessage([message]) if with_tf else message, time)


def expect_on_vehicle(sensor, name):
    (x, y, _), (*_, yaw) = ON_VEHICLE[name]
    after, deviation = sensor["after"], sensor["deviation"]
    errors = {"x": after["xyz"][0] - x, "y": after["xyz"][1] - y, "yaw_deg": math.remainder(after["rpy_deg"][2] - yaw, 360),
              "time_offset": after["time_offset"] + LATE[name] * 1e-6}
    print(f"{name}: " + ", ".join(f"{key} {error:.5f} +- {deviation[key]:.5f}" for key, error in errors.items()))
    limits = {"x": 0.005, "y": 0.005, "yaw_deg": 0.05, "time_offset": 0.002}
    for key, error in errors.items():
        expect(abs(error) < limits[key] and abs(error) < 3.5 * deviation[key], f"{name}: {key} is {error} off, +- {deviation[key]}")


def calibrate_drive(tmp, capture, motion, more="", arguments=()):
    config = (ROOT / "config/demo.yaml").read_text().replace("vehicle:\n", "vehicle:\n" + more, 1)
    (tmp / "drive.yaml").write_text(config)
    (tmp / "driven.yaml").unlink(missing_ok=True)
    return config, run("calibrate", "-c", tmp / "drive.yaml", capture, "--motion", motion, "-o", tmp / "driven.yaml", *arguments)


def check_drive(tmp):
    capture = make_capture(tmp / "drive", driving(winding(50), stop=4, sensors=LATE))
    table = tmp / "drive.odometry.csv"
    config, done = calibrate_drive(tmp, capture, table, arguments=("--json", "--picture", tmp / "drive.svg"))
    expect(done.returncode == 0, done.stderr)
    found = json.loads(done.stdout)
    for name in LATE:
        expect_on_vehicle(found["sensors"][name], name)
    scale = found["odometry"]
    expect(abs(scale["scale"] - 1 / 1.01) < 3.5 * scale["scale_deviation"] < 0.01, f"scale of the odometry: {scale}")
    new = (tmp / "driven.yaml").read_text()
    kept = [line for line in new.splitlines() if "time_offset:" not in line]
    before = config.splitlines()
    expect(len(kept) == len(before) and all(a == b or "pose:" in a for a, b in zip(before, kept)), new)
    for name, sensor in yaml.safe_load(new)["sensors"].items():
        expect(abs(sensor["time_offset"] - found["sensors"][name]["after"]["time_offset"]) < 1e-5, new)
    expect(run("check", tmp / "driven.yaml").returncode == 0, "the new file is no configuration")
    picture = (tmp / "drive.svg").read_text()
    expect("front_left" in picture and "moved " in picture, "the picture names no sensor")
    for name, more in (("odom", "  odometry_topic: /odom\n"), ("tf", "  odometry_frame: odom\n")):
        write_bag(tmp / f"{name}.bag", table, name == "tf")
        _, done = calibrate_drive(tmp, capture, tmp / f"{name}.bag", more, ("--json",))
        expect(done.returncode == 0, done.stderr)
        for sensor, value in json.loads(done.stdout)["sensors"].items():
            for a, b in zip(value["after"]["xyz"], found["sensors"][sensor]["after"]["xyz"]):
                expect(abs(a - b) < 2e-4, f"{name}: {sensor}: {value['after']}, by the table {found['sensors'][sensor]['after']}")


def check_topics(tmp, capture, yaws):
    """The same from the messages of a bag alone."""
    done = run("replay", "-c", ROOT / "config/demo.yaml", capture, "--rate", "max", "--bag", tmp / "messages.bag")
    expect((tmp / "messages.bag").exists(), done.stderr)
    sensors = "".join(f"  {name}: {{topic: {name}/scan, pose: {{xyz: [0, {y}, 0.35], rpy_deg: [0, 0, {45 * y}]}}}}\n" for name, y in (("front_left", 1), ("front_right", -1)))
    (tmp / "topics.yaml").write_text("sensors:\n" + sensors)
    done = run("calibrate", "-c", tmp / "topics.yaml", "--bag", tmp / "messages.bag", "--motion", tmp / "straight.odometry.csv", "--json")
    expect(done.returncode == 0, done.stderr)
    for found, yaw in zip(json.loads(done.stdout)["sensors"].values(), yaws):
        expect(abs(found["after"]["rpy_deg"][2] - yaw) < 0.01, f"{found}, from packets {yaw}")
    done = run("calibrate", "-c", tmp / "topics.yaml")
    expect(done.returncode == 2 and "a capture or --bag is required" in done.stderr, done.stderr)


def check_drives_that_show_little(tmp):
    capture = make_capture(tmp / "circle", driving(CONSTANT))
    _, done = calibrate_drive(tmp, capture, tmp / "circle.odometry.csv")
    expect(done.returncode == 1 and not (tmp / "driven.yaml").exists(), done.stdout + done.stderr)
    expect("x, y, yaw, time offset in base_frame: not determined" in done.stdout and "changing turn rate" in done.stdout, done.stdout)
    capture = make_capture(tmp / "straight", driving(STRAIGHT))
    _, done = calibrate_drive(tmp, capture, tmp / "straight.odometry.csv", arguments=("--picture", tmp / "straight.png"))
    expect(done.returncode == 0 and "x, y, time offset in base_frame: not determined" in done.stdout and "drive curves" in done.stdout, done.stdout)
    sensors = {name: yaml.safe_load((tmp / "driven.yaml").read_text())["sensors"][name] for name in ("front_left", "front_right")}
    for name, y in (("front_left", 1.0), ("front_right", -1.0)):
        pose = sensors[name]["pose"]
        expect(pose["xyz"] == [0, y, 0.35] and "time_offset" not in sensors[name], f"{name}: {sensors[name]}")
        expect(abs(pose["rpy_deg"][2] - ON_VEHICLE[name][1][2]) < 0.15, f"{name}: {pose}")
    check_topics(tmp, capture, [sensors[name]["pose"]["rpy_deg"][2] for name in sensors])
    for motion, words in ((tmp / "missing.csv", "cannot be opened"), (ROOT / "config/demo.yaml", "expected a bag"), (tmp / "text.csv", ":2: 'far away'; expected stamp,x,y,yaw")):
        (tmp / "text.csv").write_text("stamp,x,y,yaw\nfar away\n")
        _, done = calibrate_drive(tmp, capture, motion)
        expect(done.returncode == 1 and words in done.stderr, f"{motion}: {done.stderr}")
    _, done = calibrate_drive(tmp, capture, tmp / "straight.odometry.csv", arguments=("--picture", "x.gif"))
    expect(done.returncode == 2 and "neither a .png nor a .svg" in done.stderr, done.stderr)


def check_watch(tmp):
    """A mount that somebody knocks while the daemon runs is reported: how far, since when, and what to do."""
    begin = 1767226643.456
    parked = [{"duration": 15, "speed": 0, "yaw_rate_deg": 0}]
    turned, shifted = r"front_right by yaw \+0\.[45]\d+ deg", r"y \+0\.0[23]\d m"
    (tmp / "watch.yaml").write_text((ROOT / "config/demo.yaml").read_text().replace("vehicle:\n", "vehicle:\n  odometry_frame: odom\n", 1))
    for name, legs, knock, words in (("turned", parked, {"rpy_deg": [0, 0, 0.5]}, turned), ("shifted", parked, {"xyz": [0, 0.03, 0]}, shifted),
                                     ("turned_on_the_way", winding(15), {"rpy_deg": [0, 0, 0.5]}, turned), ("shifted_on_the_way", winding(15), {"xyz": [0, 0.03, 0]}, shifted)):
        scene = yaml.safe_load(driving(legs))
        for sensor, x, y, yaw in (("front_left", 0, 1, 45), ("front_right", 0, -1, -45)):
            scene["sensors"][sensor] |= {"pose": {"xyz": [x, y, 0.35], "rpy_deg": [0, 0, yaw]}, "range_offset": 0, "latency_us": 20}
        scene["sensors"]["front_right"]["knocked"] = {"at": 4, **knock}
        capture = make_capture(tmp / name, yaml.safe_dump(scene | {"start": "2026-01-01T00:17:23.456Z"}))
        done = run("replay", "-c", tmp / "watch.yaml", capture, "--motion", tmp / f"{name}.odometry.csv", "--rate", "max", "--bag", tmp / f"{name}.bag")
        messages = []
        with rosbag.Bag(str(tmp / f"{name}.bag")) as bag:
            for _, message, _ in bag.read_messages(["/diagnostics"]):
                messages += [(message.header.stamp.to_sec() - begin, one.message) for one in message.status if "do not agree on where" in one.message]
        expect(messages and 4 < messages[0][0] < 14, f"{name}: knocked after 4 s: {messages[:1]} {done.stderr}")
        last = messages[-1][1]
        expect(re.search(words, last) and re.search(r"since 00:17:(2[789]|3[0-7]) UTC; `lidard calibrate", last), f"{name}: {last}")


def main():
    with folder() as tmp:
        check_watch(tmp)
        check_drive(tmp)
        check_drives_that_show_little(tmp)
        capture = make_capture(tmp / "parked", parked())
        check_found(tmp, capture)
        check_forms(tmp, capture)
        check_moving(tmp)
        check_corridor(tmp)
        check_refused(tmp)
        check_multi_plane(tmp)
        check_another_grid(tmp, capture)
        done = run("calibrate", "-c", ROOT / "config/demo.yaml", capture, "--reference", "nobody")
        expect(done.returncode == 1 and "--reference nobody" in done.stderr, done.stderr)
        done = run("calibrate", "-c", tmp / "missing.yaml", capture)
        expect(done.returncode == 78, done.stderr)


if __name__ == "__main__":
    main()
