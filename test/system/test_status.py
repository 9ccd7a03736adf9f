#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""`lidard status` and `metrics` ask a running daemon without ROS: what its sensors do, at which rate and how soon it comes out."""
import json
import os
import re

from harness import SCANNER_CONFIG, SCANNER_SCENE, daemon, expect, folder, free_port, ros_master, run, sim, use_master_at, wait_for, write


def status_now():
    done = run("status", "--json")
    expect(done.returncode == 0, f"exit {done.returncode}: {done.stderr}")
    return json.loads(done.stdout)


def check_well(status):
    expect(re.match(r"\d+\.\d+", status["version"]) and status["node"] == "/lidard", f"{status['version']} {status['node']}")
    front = next(item for item in status["items"] if item["name"] == "sensor front")
    expect(front["level"] == "OK", f"{front}")
    scan = next(topic for topic in status["topics"] if topic["topic"] == "front/scan")
    expect(abs(scan["rate_hz"] - 1 / 0.03) < 1.5, f"{scan}")
    expect(0 < scan["gap_ms"]["min"] <= 31 and scan["gap_ms"]["max"] >= 29, f"{scan}")
    latency = scan["latency_ms"]
    expect(0 < latency["p50"] <= latency["p99"] <= latency["max"] < 1000, f"{scan}")
    print(f"front/scan: {scan['rate_hz']:.1f}/s, published {latency['p50']:.2f} ms after the last packet, p99 {latency['p99']:.2f} ms")


def check_texts():
    text = run("status").stdout
    for part in ("lidard ", "sensor front", "front/scan", "LATENCY"):
        expect(part in text, f"{part!r} is not in:\n{text}")
    metrics = run("metrics").stdout
    expect('lidard_health{item="sensor front"} 0' in metrics, metrics)
    expect(re.search(r'lidard_latency_seconds\{topic="front/scan",quantile="0.99"\} [0-9.e-]+\n', metrics), metrics)
    for line in metrics.splitlines():
        expect(re.fullmatch(r'# (TYPE|HELP) .*|[a-z_]+(\{.*\})? [0-9.e+-]+', line), f"not as Prometheus reads it: {line}")


def main():
    port, master = free_port(), free_port()
    use_master_at(master)
    with folder() as tmp, ros_master(master):
        os.environ["LIDARD_SOCKET"] = str(tmp / "control")
        scene, config = write(tmp / "scene.yaml", SCANNER_SCENE.format(port=port)), write(tmp / "live.yaml", SCANNER_CONFIG.format(port=port))
        with daemon(config):
            with sim(scene):
                wait_for(lambda: (tmp / "control").exists() and run("status").returncode == 0
                         and status_now()["topics"][0]["frames"] > 60, 30, "scans")
                check_well(status_now())
                check_texts()
        expect(not (tmp / "control").exists(), "the socket stays behind")
    print("ok")


if __name__ == "__main__":
    main()
