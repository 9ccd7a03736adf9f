#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""`lidard status`, `events` and `metrics` ask a running daemon without ROS: what its sensors do, at which rate and how soon it comes
out, and what changed, each change once at its time."""
import datetime
import json
import os
import re
import time

from harness import SCANNER_CONFIG, SCANNER_SCENE, daemon, expect, folder, free_port, ros_master, run, sim, use_master_at, wait_for, write


def ask(word, code=0):
    done = run(word, "--json")
    expect(done.returncode == code, f"{word}: exit {done.returncode}: {done.stderr}")
    return json.loads(done.stdout)


def items(status):
    return {item["name"]: item for item in status["items"]}


def events_of(source):
    return [(event["level"], event["text"]) for event in ask("events")["events"] if event["source"] == source]


def check_without_daemon(tmp):
    done = run("status")
    expect(done.returncode == 1 and str(tmp / "control") in done.stderr and "no daemon answers" in done.stderr, done.stderr)


def check_well(status):
    expect(re.match(r"\d+\.\d+", status["version"]) and status["node"] == "/lidard", f"{status['version']} {status['node']}")
    expect(items(status)["sensor front"]["level"] == "OK", str(items(status)["sensor front"]))
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


def check_silence(scene, silent_since):
    """The sensor ends: WARN, then ERROR, each once; then it is back."""
    wait_for(lambda: ("ERROR" in [level for level, _ in events_of("sensor front")]), 10, "an event for the silent sensor")
    time.sleep(2)  # a second one would come
    known = events_of("sensor front")
    expect([level for level, _ in known].count("ERROR") == 1, f"reported more than once: {known}")
    first = next(event for event in ask("events")["events"] if event["source"] == "sensor front")
    at = datetime.datetime.fromisoformat(first["at"].replace("Z", "+00:00")).timestamp()
    print(f"silence is an event {at - silent_since:.2f} s after it began: {first['text']}")
    expect(-0.1 < at - silent_since < 5, f"an event {at - silent_since:.2f} s after the silence began")
    for form in ((), ("--json",)):
        expect(run("status", *form).returncode == 1, "exit 1 while something is in error")
    with sim(scene):
        wait_for(lambda: events_of("sensor front")[-1][0] == "OK", 10, "the event that it is back")
        levels = [level for level, _ in events_of("sensor front")]
        expect(levels.count("OK") == 1, f"{levels}")


def main():
    port, master = free_port(), free_port()
    use_master_at(master)
    with folder() as tmp, ros_master(master):
        os.environ["LIDARD_SOCKET"] = str(tmp / "control")
        scene, config = write(tmp / "scene.yaml", SCANNER_SCENE.format(port=port)), write(tmp / "live.yaml", SCANNER_CONFIG.format(port=port))
        check_without_daemon(tmp)
        with daemon(config):
            with sim(scene) as simulator:
                wait_for(lambda: (tmp / "control").exists() and run("status").returncode == 0
                         and ask("status")["topics"][0]["frames"] > 60, 30, "scans")
                check_well(ask("status"))
                check_texts()
                simulator.kill()
                silent_since = time.time()
            check_silence(scene, silent_since)
        expect(not (tmp / "control").exists(), "the socket stays behind")
    print("ok")


if __name__ == "__main__":
    main()
