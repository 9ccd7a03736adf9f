#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Every mistake is answered with one clear message and the right exit code."""
import json
import socket
import subprocess

from harness import LIDARD, ROOT, expect, folder, free_port, process, run, use_master_at, wait_for

DEMO_CONFIG = ROOT / "config/demo.yaml"
DEMO = ROOT / "pcaps/demo.pcap"


def expect_refusal(result, code, *words):
    text = result.stdout + result.stderr
    expect(result.returncode == code, f"exit {result.returncode}, expected {code}: {result.args}\n{text}")
    for word in words:
        expect(word in text, f"'{word}' is not in the answer to {result.args}:\n{text}")
    expect("terminate called" not in text, f"crashed: {result.args}\n{text}")


def usage_mistakes(tmp):
    expect_refusal(run(), 2)
    expect_refusal(run("fly"), 2)
    expect_refusal(run("replay", "-c", DEMO_CONFIG), 2, "--pcap")
    expect_refusal(run("decode", DEMO, "--format", "xls"), 2, "csv")
    expect_refusal(run("decode", DEMO, "--model", "velodyne_vlp61"), 2, "velodyne_vlp16")
    expect_refusal(run("decode", DEMO, "--source", "300.1.1.1"), 2, "300.1.1.1")
    expect_refusal(run("replay", "-c", DEMO_CONFIG, "--pcap", DEMO, "--rate", "fast"), 2, "fast", "max")
    expect_refusal(run("replay", "-c", DEMO_CONFIG, "--pcap", DEMO, "--loop", "--bag", tmp / "x.bag"), 2, "--loop")


def configuration_mistakes(tmp):
    bad = tmp / "bad.yaml"
    bad.write_text("sensors:\n  roof:\n    modell: velodyne_vlp16\n")
    expect_refusal(run("check", bad), 78, f"{bad}:3:5", "modell", "model")
    expect_refusal(run("run", "-c", bad), 78, f"{bad}:3:5")
    expect_refusal(run("replay", "-c", bad, "--pcap", DEMO, "--bag", tmp / "x.bag"), 78, f"{bad}:3:5")
    expect_refusal(run("check", tmp / "none.yaml"), 78, "none.yaml")
    bad.write_text("sensors:\n  roof: {model: velodyne_vlp61}\n")
    expect_refusal(run("check", bad), 78, f"{bad}:2:", "velodyne_vlp61", "velodyne_vlp16")


def broken_files(tmp):
    expect_refusal(run("decode", tmp / "none.pcap"), 1, "none.pcap")
    text = tmp / "text.pcap"
    text.write_text("this is no capture at all, but long enough to be read as one")
    expect_refusal(run("decode", text), 1, "text.pcap")
    expect_refusal(run("decode", DEMO, "--model", "velodyne_vlp16", "-o", tmp / "no/such/dir.csv"), 1, "no/such/dir.csv")
    cut = tmp / "cut.pcap"
    cut.write_bytes(DEMO.read_bytes()[:1_000_000])
    result = run("decode", cut, "--model", "velodyne_vlp16", "-o", tmp / "cut.csv")
    expect(result.returncode == 0, f"exit {result.returncode} where a last record alone is not whole")
    expect("cut.pcap: " in result.stderr and "what came before it was used" in result.stderr, result.stderr)
    expect((tmp / "cut.csv").read_text().count("\n") > 100_000, "what came before the cut is written")


def without_a_configuration(tmp):
    """What `inspect` finds is replayed; a bag that is there stays."""
    bag = tmp / "found.bag"
    done = run("replay", DEMO, "--rate", "max", "--bag", bag)
    expect(done.returncode == 0 and "velodyne_vlp16/points" in done.stdout, f"{done}")
    before = bag.read_bytes()
    expect_refusal(run("replay", DEMO, "--rate", "max", "--bag", bag), 1, "found.bag is there already", "another file")
    expect(bag.read_bytes() == before, "the bag was touched")
    nothing = tmp / "nothing.pcap"
    nothing.write_bytes(DEMO.read_bytes()[:24])
    expect_refusal(run("replay", nothing, "--bag", tmp / "y.bag"), 1, "nothing.pcap", "holds no packet")


def decoding(tmp):
    expect_refusal(run("decode", DEMO), 1, "--source")
    for extension in ("csv", "json", "pcd"):
        out = tmp / f"o.{extension}"
        result = run("decode", DEMO, "--model", "velodyne_vlp16", "--format", extension, "-o", out)
        expect(result.returncode == 0, result.stderr)
    header = "frame,packet,block,laser,ring,return,stamp_ns,azimuth_deg,distance_m,x_m,y_m,z_m,intensity\n"
    lines = (tmp / "o.csv").read_text().splitlines(keepends=True)
    expect(lines[0] == header, f"header {lines[0]}")
    frames = [json.loads(line) for line in (tmp / "o.json").open()]
    expect(sum(len(f["rows"]) for f in frames) == len(lines) - 1, "JSON and CSV hold the same returns")
    expect(b"DATA binary_compressed" in (tmp / "o.pcd").read_bytes()[:500], "PCD is binary_compressed")
    expect(f"POINTS {len(lines) - 1}".encode() in (tmp / "o.pcd").read_bytes()[:500], "PCD holds the same returns")
    planar = run("decode", DEMO, "--source", "192.168.0.21")
    expect(planar.stdout.startswith("frame,beam,echo,angle_rad,range_m,intensity,stamp_ns,status\n"), "planar header")


def port_in_use(tmp):
    """The daemon says who has the port, goes on, and receives once it is free."""
    port = free_port(socket.SOCK_DGRAM)
    use_master_at(free_port())
    config = tmp / "port.yaml"
    config.write_text(f"sensors:\n  roof: {{model: velodyne_vlp16, ip_port: {port}, pose: {{xyz: [0, 0, 2]}}}}\n")
    log = tmp / "log.txt"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("0.0.0.0", port))
        with log.open("w") as sink, process([LIDARD, "run", "-c", config], stdout=sink, stderr=subprocess.STDOUT) as daemon:
            wait_for(lambda: f"port {port} is in use" in log.read_text(), 10, "the log says that the port is in use")
            expect(daemon.poll() is None, "the daemon goes on")
            other.close()
            wait_for(lambda: f"listening on port {port}" in log.read_text(), 10, "the daemon takes the port when it is free")
            daemon.terminate()
            expect(daemon.wait(20) == 0, "SIGTERM ends it with 0")


def main():
    with folder() as tmp:
        usage_mistakes(tmp)
        configuration_mistakes(tmp)
        broken_files(tmp)
        without_a_configuration(tmp)
        decoding(tmp)
        port_in_use(tmp)
    print("ok")


if __name__ == "__main__":
    main()
