#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""One table of what lidard costs: `./test/run --bench [OUT.json [BEFORE.json]]` builds the benches and runs this.

    table.py BUILD [OUT.json [BEFORE.json]]

Each figure is the median of rounds, with the least and the most of them. Beside it stands what the same run measured as a
reference: memcpy of the same bytes, or the ancestor's chain of calls. OUT.json keeps the table; with the JSON of another commit
the table shows how many times as large each figure is now. Machines differ: compare runs of one machine, better in turn.
"""
import json
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile
import time

BUILD = pathlib.Path(sys.argv[1]).resolve()
ROOT = pathlib.Path(__file__).resolve().parents[2]
os.environ.update(LIDARD=str(BUILD / "lidard"), LIDARD_SIM=str(BUILD / "lidard-sim"), LIDARD_SOURCE_DIR=str(ROOT))
sys.path[:0] = [str(ROOT / "test/system"), str(ROOT / "test/bench")]
import harness
from live import live, start
from ros_tools import ros_test
from test_velodyne_rate import SCENE

ROUNDS = 5


def row(name, unit, rounds, reference="", factor=None):
    """`factor`: how many times the reference's time this takes."""
    return {"name": name, "unit": unit, "value": statistics.median(rounds), "least": min(rounds), "most": max(rounds),
            "reference": reference, "factor": factor}


def repetitions(program, filter_):
    """The rounds of each benchmark of a program, in their order."""
    said = subprocess.run([BUILD / program, f"--benchmark_filter={filter_}", f"--benchmark_repetitions={ROUNDS}", "--benchmark_format=json",
                           "--benchmark_enable_random_interleaving=true", "--benchmark_min_time=0.2"], stdout=subprocess.PIPE, check=True).stdout
    rounds = {}
    for run in json.loads(said)["benchmarks"]:
        if run["run_type"] == "iteration":
            harness.expect(not run.get("error_occurred"), f"{program}: {run['name']}: {run.get('error_message')}")
            rounds.setdefault(run["name"].removesuffix("/manual_time"), []).append(run)
    return rounds


def decoding():
    """Simulated packets against memcpy of the points; shipped and shared captures."""
    for name, runs in repetitions("bench_velodyne", "^velodyne_(vlp16|vlp32c|hdl32e|vls128)/(strongest|dual)(/manual_time)?$").items():
        yield row(f"decode {name}", "ns/point", [run["ns_point"] for run in runs], "memcpy", statistics.median(run["x_memcpy"] for run in runs))
    for name, runs in repetitions("bench_decode", "-memcpy").items():
        yield row(f"decode {name}", "ns/packet", [run.get("ns_per_packet", run["ns_per_point"]) for run in runs])


def against_ancestor(program, what):
    rounds = repetitions(program, ".")
    times = {name: [run["cpu_time"] / 1e3 for run in runs] for name, runs in rounds.items()}
    for name, all_ in times.items():
        frames = name.rpartition("/")[2] if what == "virtual" else ""
        base = next(times[one] for one in times if one.startswith("ancestor") and one.endswith(frames))
        yield row(f"{what} {name}", "us", all_, "ancestor", statistics.median(all_) / statistics.median(base))


def live_rows():
    with ros_test() as (tmp, _):
        capture = harness.make_capture(tmp / "vls128", SCENE)
        for name, listen in (("nobody", False), ("one subscriber", True)):
            runs = [live(tmp, capture, listen) for _ in range(3)]
            yield row(f"live VLS-128 dual, {name}", "us/packet", [cost for cost, _ in runs])
            yield row(f"live VLS-128 dual, {name}: lost", "packets", [lost for _, lost in runs])
        starts = [start(tmp) for _ in range(9)]
        yield row("exec to READY", "ms", [ready for ready, _ in starts])
        yield row("libraries of lidard run", "", [libraries for _, libraries in starts])


def system_rows():
    """Figures that system tests print."""
    said = subprocess.run(["/usr/bin/python3", ROOT / "test/system/test_planes_first.py", "20"], stdout=subprocess.PIPE, text=True, check=False).stdout
    latencies = re.findall(r"^(\S+) +\d+ frames.* p50 ([\d.]+), p99 ([\d.]+)", said, re.M)
    harness.expect(latencies, f"test_planes_first prints no latencies: {said}")
    for topic, p50, p99 in latencies:
        yield row(f"beside two VLS-128: {topic} p50", "ms", [float(p50)])
        yield row(f"beside two VLS-128: {topic} p99", "ms", [float(p99)])
    said = subprocess.run(["/usr/bin/python3", ROOT / "test/system/test_memory.py"], stdout=subprocess.PIPE, text=True, check=False).stdout
    peaks = re.findall(r"^(eight lidars|two VLS-128).*at most ([\d.]+) MB", said, re.M)
    harness.expect(len(peaks) == 2, f"test_memory prints no figures: {said}")
    for what, peak in peaks:
        yield row(f"memory: {what}", "MB", [float(peak)])


def replaying():
    rounds = []
    with tempfile.TemporaryDirectory() as tmp:
        for i in range(ROUNDS):
            begin = time.monotonic()
            subprocess.run([BUILD / "lidard", "replay", "-c", ROOT / "config/demo.yaml", "--pcap", ROOT / "pcaps/demo.pcap", "--rate", "max", "--bag",
                            f"{tmp}/{i}.bag"], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            rounds.append(time.monotonic() - begin)
    yield row("replay of the demo's 2 s to a bag", "s", rounds)


def main():
    before = {}
    if len(sys.argv) > 3:
        before = {one["name"]: one["value"] for one in json.loads(pathlib.Path(sys.argv[3]).read_text())["rows"]}
    print(f"{'':58} {'median':>9} {'least':>9} {'most':>9} {'unit':10} {'x reference':20} {'x before' if before else ''}")
    rows = []
    for kind in (decoding(), against_ancestor("bench_merge", "merge"), against_ancestor("bench_virtual", "virtual"), replaying(), live_rows(),
                 system_rows()):
        for one in kind:
            rows.append(one)
            factor = f"{one['factor']:.3f} {one['reference']}" if one["factor"] else ""
            than = f"{one['value'] / before[one['name']]:.2f}" if before.get(one["name"]) else ""
            print(f"{one['name']:58} {one['value']:9.2f} {one['least']:9.2f} {one['most']:9.2f} {one['unit']:10} {factor:20} {than}", flush=True)
    if len(sys.argv) > 2:
        commit = subprocess.run(["git", "-C", ROOT, "describe", "--always", "--dirty"], stdout=subprocess.PIPE, text=True, check=False).stdout.strip()
        pathlib.Path(sys.argv[2]).write_text(json.dumps({"commit": commit, "rows": rows}, indent=1) + "\n")


if __name__ == "__main__":
    main()
