#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The Python package gives what decode and replay give of every capture, outlives its readers, serves threads, and says
what is wrong as the command line does."""
import collections
import copy
import gc
import itertools
import json
import os
import pathlib
import pickle
import re
import struct
import subprocess
import sys
import threading
import warnings

from harness import FILE_HEAD, LIDARD, ROOT, SKIP, expect, folder, records, run, source_of

MODULE = pathlib.Path(os.environ.get("LIDARD_PYTHON", ""))
if not any(MODULE.glob("lidard/*.so")):
    print("skipped: the module was not built")
    sys.exit(SKIP)
sys.path.insert(0, str(MODULE))
import lidard  # noqa: E402
import numpy as np  # noqa: E402

DEMO, VLP16 = ROOT / "pcaps/demo.pcap", ROOT / "pcaps/vlp16_dual.pcap"
STATUS = ["hit", "none", "near", "invalid"]


def frames_of(*arguments, **options):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return list(lidard.open(*arguments, **options))


def raises(kind, words, call, *arguments, **options):
    try:
        call(*arguments, **options)
    except kind as error:
        expect(words in str(error) and type(error) is kind, f"{error!r} instead of {words}")
    else:
        expect(False, f"no {kind.__name__}: {words}")


def check_cloud(frame, said):
    names, rows = said["columns"], np.array(said["rows"], dtype=float).reshape(-1, len(said["columns"]))
    column = dict(zip(names, rows.T))
    points = frame.points
    same = points.size == len(rows) and frame.complete == said["complete"]
    same = same and all(np.array_equal(column[name].astype(np.float32), value) for name, value in (
        ("ring", points["ring"]), ("intensity", points["intensity"]), ("return", frame.echo),
        ("packet", frame.columns["packet"][frame.column])))
    same = same and np.allclose(rows[:, [names.index(f"{axis}_m") for axis in "xyz"]], frame.xyz, rtol=0, atol=6e-6)
    stamps = np.array([row[names.index("stamp_ns")] - said["stamp_ns"] for row in said["rows"]], dtype=float)
    return same and np.allclose(stamps, points["time"] * 1e9, rtol=0, atol=2e7)  # the clock settles within the first frame


def check_scan(frame, said):
    beam, echo = (np.array([row[i] for row in said["rows"]], dtype=int) for i in (0, 1))
    ranges = np.array([np.nan if row[3] is None else row[3] for row in said["rows"]])
    got = frame.echo_ranges[echo, beam].astype(float)
    same = np.allclose(np.where(np.isfinite(got), got, np.nan), ranges, rtol=0, atol=6e-5, equal_nan=True)
    same = same and np.allclose(frame.angles[beam], [row[2] for row in said["rows"]], rtol=0, atol=1e-6)
    same = same and [STATUS[i] for i in frame.echo_statuses[echo, beam]] == [row[6] for row in said["rows"]]
    shown = np.zeros(len(beam)) if frame.echo_intensities is None else frame.echo_intensities[echo, beam]
    return same and np.array_equal(shown, np.array([row[4] for row in said["rows"]], dtype=np.float32))


def equals_decode(capture):
    """The frames of each sensor of a capture; the number of them."""
    found = json.loads(subprocess.run([LIDARD, "inspect", "--json", capture], capture_output=True, check=False).stdout)["sensors"]
    if not found:
        raises(ValueError, capture.name, lidard.open, capture)
        return 0
    frames = frames_of(capture)
    count = 0
    for sensor in found:
        done = subprocess.run([LIDARD, "decode", capture, "--source", sensor["sender"], "--port", str(sensor["port"]), "--clock", "smooth",
                               "--format", "json", "-o", "-"], capture_output=True, text=True, check=False)
        own = [frame for frame in frames if frame.sensor == sensor["name"]]
        lines = done.stdout.splitlines()
        expect(len(own) == len(lines), f"{capture}: {sensor['name']}: {len(own)} frames, decode {len(lines)}: {done.stderr}")
        for number, (frame, said) in enumerate(zip(own, map(json.loads, lines))):
            check = check_cloud if isinstance(frame, lidard.Cloud) else check_scan
            expect(frame.stamp_ns == said["stamp_ns"] and check(frame, said), f"{capture}: {frame} differs from frame {number}")
        count += len(own)
    expect(count == len(frames), f"{capture}: {len(frames)} frames, decode {count}")
    return count


def equals_replay(tmp, config, capture, *motion):
    import rosbag
    bag = tmp / f"{config.stem}.bag"
    said = subprocess.run([LIDARD, "replay", "-c", config, capture, "--rate", "max", "--bag", bag, *(["--motion", motion[0]] if motion else [])],
                          capture_output=True, text=True, check=False)
    waiting, count, missing = {}, 0, ""
    for topic, message, _ in rosbag.Bag(str(bag)).read_messages():
        if message._type in ("sensor_msgs/LaserScan", "sensor_msgs/PointCloud2"):
            waiting.setdefault(topic.lstrip("/"), []).append(message)
    reader = lidard.replay(config, capture, *motion)
    while True:
        try:
            frame = next(reader, None)
        except ValueError as error:
            missing = str(error)
        if frame is None or missing:
            break
        if frame.topic not in waiting:
            expect(isinstance(frame, lidard.Scan) and frame.echoes > 1, f"{frame} is not in the bag")
            continue
        message = waiting[frame.topic].pop(0)
        same = frame.stamp_ns == message.header.stamp.to_nsec() and frame.frame_id == message.header.frame_id
        if isinstance(frame, lidard.Cloud):
            same = same and frame.points.tobytes() == message.data and frame.points.shape[-1] == message.width
        else:
            same = same and np.array_equal(frame.ranges, np.float32(message.ranges), equal_nan=True)
            same = same and np.array_equal([] if frame.intensities is None else frame.intensities, np.float32(message.intensities))
        expect(same, f"{frame} differs from the bag")
        count += 1
    expect(not any(waiting.values()), "frames of the bag that Python lacks")
    expect((said.returncode != 0) == bool(missing) and all(f"none: {line.split(': ', 1)[1]}" in said.stdout for line in missing.splitlines()),
           f"{missing!r} instead of {said.stdout}{said.stderr}")
    return count


def memory_and_threads():
    first = next(lidard.open(VLP16))
    before = first.points.copy(), first.columns.copy()
    expect(len(frames_of(VLP16)) > 2, "frames")  # whose memory is used again
    gc.collect()
    expect(np.array_equal(first.points, before[0]) and np.array_equal(first.columns, before[1]), "arrays outlive their reader")
    for other in (pickle.loads(pickle.dumps(first)), copy.deepcopy(first), copy.copy(first)):
        expect(np.array_equal(other.points, first.points) and other.stamp_ns == first.stamp_ns, "copies are equal")
    stamp, points = first
    expect(stamp == first.stamp and points is first.points, "unpacks")
    for reader in (lidard.open(DEMO), lidard.replay(ROOT / "config/demo.yaml", DEMO)):
        lists = [], [], []

        def work(mine):
            for frame in reader:
                mine.append((frame.sensor, frame.topic, frame.stamp_ns))
                reader.sensors
        threads = [threading.Thread(target=work, args=(mine,)) for mine in lists]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        alone = lidard.open(DEMO) if not lists[0] or not lists[0][0][1] else lidard.replay(ROOT / "config/demo.yaml", DEMO)
        expect(sorted(itertools.chain(*lists)) == sorted((f.sensor, f.topic, f.stamp_ns) for f in alone), "threads share the frames")
    with lidard.open(DEMO) as reader:
        next(reader)
    expect(next(reader, None) is None, "a closed reader has ended")


def errors(tmp):
    raises(FileNotFoundError, "nowhere.pcap", lidard.open, tmp / "nowhere.pcap")
    raises(FileNotFoundError, "nowhere.pcap", lidard.inspect, [DEMO, tmp / "nowhere.pcap"])
    raises(FileNotFoundError, "nowhere.yaml", lidard.replay, tmp / "nowhere.yaml", DEMO)
    raises(FileNotFoundError, "nowhere.csv", lidard.replay, ROOT / "config/demo.yaml", DEMO, tmp / "nowhere.csv")
    for option, value in (("model", "hokuyo_ust_10lx"), ("model", "vlp16"), ("source", "10.9.9.9")):
        said = run("decode", VLP16, f"--{option}", value, "-o", tmp / "nothing.csv").stderr.strip()
        raises(ValueError, said, lidard.open, VLP16, **{option: value})
    raises(ValueError, "is not an address", lidard.open, VLP16, source="here")
    raises(ValueError, "bags need ROS", lidard.replay, ROOT / "config/demo.yaml", tmp / "a.bag")
    raises(ValueError, ":1:1: ", lidard.check, "wrong: 1\n")
    raises(ValueError, "no topic nothing in the configuration; expected one of ", lidard.replay, ROOT / "config/demo.yaml", DEMO, topics=["nothing"])
    config = "sensors: {a: {model: velodyne_vlp16, ip_address: 10.0.0.1}}\n"
    raises(ValueError, "a/points: ", lambda: list(lidard.replay(config, VLP16)))
    cut = tmp / "cut.pcap"
    cut.write_bytes(VLP16.read_bytes()[:-700])
    said = subprocess.run([LIDARD, "decode", cut, "-o", tmp / "cut.csv"], capture_output=True, text=True, check=False).stderr
    with warnings.catch_warnings(record=True) as shown:
        warnings.simplefilter("always")
        list(lidard.open(cut))
    expect([str(one.message) for one in shown] == [said.splitlines()[0]] and shown[0].filename == __file__, f"{shown} instead of {said}")


def live():
    """A driver that is fed gives the complete frames of the capture; the last one at its end."""
    data, at, driver, frames = VLP16.read_bytes(), FILE_HEAD, lidard.Driver("velodyne_vlp16"), []
    unit = 1 if struct.unpack_from("<I", data)[0] == 0xA1B23C4D else 1000
    while at < len(data):
        seconds, fraction, size = struct.unpack_from("<III", data, at)
        frames += driver.feed(data[at + 16 + 42:at + 16 + size], seconds * 1_000_000_000 + fraction * unit)
        at += 16 + size
    frames += driver.finish()
    expect([(f.stamp_ns, f.points.tobytes()) for f in frames] == [(f.stamp_ns, f.points.tobytes()) for f in frames_of(VLP16)], "live")
    expect(driver.state["data_packets"] > 0, f"{driver.state}")


def manual(tmp):
    """Each block of the page runs."""
    for name in ("pcaps", "config"):
        (tmp / name).symlink_to(ROOT / name)
    for block in re.findall(r"^```python\n(.*?)^```", (ROOT / "config/doc/python.md").read_text(), re.S | re.M):
        done = subprocess.run([sys.executable, "-c", block], cwd=tmp, env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path[:1])},
                              capture_output=True, text=True, check=False)
        expect(done.returncode == 0, f"{block}{done.stderr}")
    expect((tmp / "cloud.png").stat().st_size > 10_000, "the picture of the page")
    expect((tmp / "cloud.pcd").stat().st_size > 100_000, "the PCD file of the page")


def later_sensor(tmp):
    """A sensor that begins to send after the begin of the capture, which is surveyed first."""
    now, later = [], []
    for record in records(DEMO.read_bytes()):
        is_late = source_of(record) == "192.168.1.201"
        (later if is_late else now).append(struct.pack("<I", struct.unpack_from("<I", record)[0] + 60 * is_late) + record[4:])
    capture = tmp / "later.pcap"
    capture.write_bytes(DEMO.read_bytes()[:FILE_HEAD] + b"".join(now + later))
    counts = [collections.Counter((f.sensor, str(f).split(",")[1]) for f in frames_of(one)) for one in (capture, DEMO)]
    expect(counts[0] == counts[1], f"{counts[0]} instead of {counts[1]}")


def main():
    captures = sorted((ROOT / "pcaps").glob("*.pcap"))
    if "LIDARD_CAPTURES" in os.environ:
        captures += sorted(path for path in pathlib.Path(os.environ["LIDARD_CAPTURES"]).rglob("*.pcap*") if path.is_file())
    stdout = os.dup(1)
    with folder() as tmp:
        os.dup2(os.open(tmp / "stdout", os.O_CREAT | os.O_WRONLY), 1)
        count = sum(map(equals_decode, captures))
        driving = tmp / "driving.yaml"
        driving.write_text((ROOT / "config/demo.yaml").read_text().replace("vehicle:\n", "vehicle:\n  odometry_frame: odom\n")
                           .replace("  roof:\n", "  roof:\n    filter: {outlier_radius: 0.5, outlier_neighbours: 3}\n"))
        table = tmp / "motion.csv"
        begin = next(lidard.open(DEMO)).stamp - 1
        table.write_text("stamp,x,y,yaw\n" + "".join(f"{begin + i / 50:.6f},{i / 10},{i / 50},{i / 200}\n" for i in range(500)))
        replayed = sum(equals_replay(tmp, *of) for of in ((ROOT / "config/demo.yaml", DEMO), (ROOT / "config/truck.yaml", DEMO),
                                                          (driving, DEMO, table)))
        memory_and_threads()
        errors(tmp)
        live()
        later_sensor(tmp)
        manual(tmp)
        questioned = tmp / "questioned.yaml"
        questioned.write_text("sensors: {roof: {model: velodyne_vlp16, ip_port: 80, pose: {xyz: [0, 0, -1]}}}\n")
        said = run("check", questioned).stderr.splitlines()
        expect(len(said) >= 2 and lidard.check(questioned)["warnings"] == said, f"check: {said}")
        expect(lidard.models() == json.loads(run("models", "--json").stdout), "models")
        expect(lidard.inspect(DEMO) == json.loads(run("inspect", "--json", DEMO).stdout), "inspect")
        expect(lidard.check(ROOT / "config/demo.yaml")["outputs"][0]["free_percent"] > 0, "check")
        sys.stdout.flush()
        os.dup2(stdout, 1)
        expect((tmp / "stdout").read_bytes() == b"", "nothing goes to standard output")
    libraries = subprocess.run(["ldd", lidard._lidard.__file__], capture_output=True, text=True, check=True).stdout
    expect("ros" not in libraries.replace("libpros", ""), libraries)
    print(f"{count} frames of {len(captures)} captures equal decode's, {replayed} equal those of replay")


main()
