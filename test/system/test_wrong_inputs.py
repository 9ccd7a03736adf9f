#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Wrong commands, options, configurations, captures and environments: each answer names place, problem and remedy, and none ends
with exit 0 and nothing."""
import os
import pty
import shutil
import signal
import subprocess

from harness import (LIDARD, ROOT, daemon, expect, expect_end, folder, free_port, process, ros_master, run, use_master_at, wait_for,
                     write)

DEMO, DEMO_CONFIG = ROOT / "pcaps/demo.pcap", ROOT / "config/demo.yaml"
VLP = "sensors:\n  roof: {model: velodyne_vlp16, ip_address: 192.168.1.201}\n"

# The command line; exit code; place, problem, remedy.
COMMANDS = [
    ([], 2, ("lidard: no command", "--help")),
    (["chek", DEMO_CONFIG], 2, ("lidard: no command chek", "did you mean check?")),
    (["snapshoot"], 2, ("lidard", "no command snapshoot", "did you mean snapshot?")),
    (["--verzion"], 2, ("lidard", "no option --verzion", "--help")),
    (["help", "chek"], 2, ("lidard", "chek", "did you mean check?")),
    (["check", "--prots", DEMO_CONFIG], 2, ("check:", "no option --prots", "did you mean --ports?")),
    (["decode", DEMO, "--fromat", "csv"], 2, ("decode:", "no option --fromat", "did you mean --format?")),
    (["run", "--confg", DEMO_CONFIG], 2, ("run:", "no option --confg", "did you mean --config?")),
    (["check"], 2, ("check:", "is required", "lidard check --help")),
    (["check", DEMO_CONFIG, "b"], 2, ("check:", "not expected: b", "lidard check --help")),
    (["import", "--tabels"], 2, ("import:", "no option --tabels", "did you mean --tables?")),
    (["decode", DEMO, "--format", "xls"], 2, ("decode:", "xls", "csv")),
    (["replay", "-c", DEMO_CONFIG], 2, ("--pcap",)),
    (["decode", DEMO, "--model", "velodyne_vlp16", "-o", "/nowhere/no/dir.csv"], 1, ("/nowhere/no/dir.csv",)),
    (["decode", DEMO], 1, ("--source",)),
    (["run", "-c", "/nowhere/x.yaml"], 78, ("/nowhere/x.yaml", "No such file", "expected a readable YAML file")),
    (["import", "/nowhere/x.launch"], 78, ("/nowhere/x.launch", "cannot be read", "expected a launch file")),
    (["status", "--socket", "/nowhere/control"], 1, ("/nowhere/control", "no daemon answers", "start it")),
]

# The configuration; place, problem, remedy.
CONFIGURATIONS = [
    ("sensors:\n  roof: {modell: velodyne_vlp16}\n", (":2:10", "unknown key sensors.roof.modell", "expected model")),
    ("sensors:\n  roof: {model: velodyne_vlp16, cut_angle: 90}\n", (":2:", "cut_angle is 90", "cut_angle_deg")),
    ("sensors:\n  a: {model: sick_tim7xx, ip_address: 192.168.0.1, angle_min: -6.5}\n", (":2:", "angle_min is -6.5", "angle_min_deg")),
    ("sensors:\n  roof: {model: velodyne_vlp16, pose: {xyz: [0, 0, 1], rpy: [0, 0, 6.9]}}\n", (":2:", "rpy[2] is 6.9", "rpy_deg")),
    (VLP + "merged_scans:\n  m: {laserscan_topics: [rof]}\n", (":4:", "rof", "expected")),
    ("sensors:\n  roof: {<<: velodyne, model: velodyne_vlp16}\n", (":2:", "merges what is no mapping", "an alias of a mapping")),
    ("sensors:\n  roof: {<<: *nobody}\n", (":2:", "not YAML", "expected")),
    (VLP + "---\nsensors: {}\n", (":3:1", "second YAML document", "one document per file")),
]


def refused(what, result, code, words):
    text = result.stdout + result.stderr
    expect(result.returncode == code, f"{what}: exit {result.returncode}, expected {code}\n{text}")
    for word in words:
        expect(word in text, f"{what}: '{word}' is not in the answer:\n{text}")
    expect(len(text.splitlines()) < 20 and "terminate called" not in text, f"{what}: one clear message\n{text}")


def commands(_):
    for line, code, words in COMMANDS:
        refused(f"lidard {' '.join(map(str, line))}", run(*line), code, words)
    return len(COMMANDS)


def configurations(tmp):
    file = tmp / "wrong.yaml"
    for text, words in CONFIGURATIONS:
        file.write_text(text)
        refused(repr(text), run("check", file), 78, (str(file) + words[0], *words[1:]))
    for command in (["run", "-c", file], ["replay", "-c", file, "--pcap", DEMO, "--bag", tmp / "x.bag"]):
        refused(command[0], run(*command), 78, (f"{file}:3:1",))  # the last one of the list
    return len(CONFIGURATIONS) + 2


def without_modules(tmp):
    """A program that was installed without the package lidard-pcl."""
    alone, config = tmp / "lidard", tmp / "outliers.yaml"
    shutil.copy(LIDARD, alone)
    config.write_text("sensors:\n  roof: {model: velodyne_vlp16, filter: {outlier_radius: 0.5}}\n")
    done = subprocess.run([alone, "check", config], capture_output=True, text=True, timeout=30, check=False)
    refused("outlier_radius", done, 78, (":2:", "outlier_radius cannot be applied", "lidard-pcl"))
    return 1


def captures(tmp):
    cases = [(None, ("none.pcap", "cannot be opened: No such file", "check the path")),
             (b"", ("c.pcap", "is empty", "record it again")),
             (b"this is no capture, but long enough to be taken for one", ("c.pcap", "unknown file format", "tcpdump -w")),
             (DEMO.read_bytes()[:24], ("c.pcap", "no packet", ""))]
    for content, words in cases:
        file = tmp / ("none.pcap" if content is None else "c.pcap")
        if content is not None:
            file.write_bytes(content)
        for command in ("inspect", "decode"):
            refused(f"{command} {content!r:.40}", run(command, file), 1, words)
    return 2 * len(cases)


def bag_that_exists(tmp):
    """A replay without a configuration replays what `inspect` finds; a bag that is there stays."""
    bag = tmp / "found.bag"
    done = run("replay", DEMO, "--rate", "max", "--bag", bag)
    expect(done.returncode == 0 and "velodyne_vlp16/points" in done.stdout, f"{done}")
    before = bag.read_bytes()
    again = run("replay", DEMO, "--rate", "max", "--bag", bag)
    expect(again.returncode == 1 and "found.bag is there already" in again.stderr and "another file" in again.stderr, f"{again}")
    expect(bag.read_bytes() == before, "the bag was touched")
    nothing = tmp / "nothing.pcap"
    nothing.write_bytes(DEMO.read_bytes()[:24])
    refused("replay", run("replay", nothing, "--bag", tmp / "y.bag"), 1, ("nothing.pcap", "holds no packet"))
    return 2


def environment(tmp):
    config = write(tmp / "fine.yaml", f"sensors:\n  roof: {{model: velodyne_vlp16, ip_port: {free_port()}, telemetry_port: 0}}\n")
    done = run("run", "-c", config, env={**os.environ, "ROS_MASTER_URI": "localhost:11311"}, timeout=20)
    refused("ROS_MASTER_URI", done, 2, ("ROS_MASTER_URI", "localhost:11311", "http://host:port"))
    port = free_port()
    use_master_at(port)
    wrong = [("ROS_IP", "203.0.113.9", "no interface of this host has"), ("ROS_HOSTNAME", "no-such-host.invalid", "no name server resolves")]
    with ros_master(port):
        for variable, value, what in wrong:
            own = {**os.environ, variable: value, "NO_COLOR": "1"}
            with daemon(config, env=own) as child:
                wait_for(lambda: "ROS master found" in child.said(), 30, "it starts nevertheless:\n" + child.said())
                expect_end(child, signal.SIGTERM, 10)
            for word in ("warning:", variable, value, what, "cannot reach what is published here"):
                expect(word in child.said(), f"'{word}' is not in\n{child.said()}")
    return 1 + len(wrong)


def said_on_a_terminal(config, **environment):
    """What `lidard run` writes to a terminal until it waits for the master."""
    ours, its = pty.openpty()
    with process([LIDARD, "run", "-c", config], stderr=its, env={**os.environ, **environment}) as child:
        os.close(its)
        text = b""
        while b"ROS master" not in text:
            text += os.read(ours, 4096)
        child.terminate()
        child.wait(10)
    os.close(ours)
    return text


def colours(tmp):
    config = tmp / "fine.yaml"
    environment = {"ROS_MASTER_URI": f"http://127.0.0.1:{free_port()}", "TERM": "xterm"}
    expect(b"\x1b[" in said_on_a_terminal(config, **environment, NO_COLOR=""), "a terminal has colours")
    expect(b"\x1b[" not in said_on_a_terminal(config, **environment, NO_COLOR="1"), "NO_COLOR removes them")


def what_works(tmp):
    expect("Validates a configuration" in run("help", "check").stdout, "help CMD is CMD --help")
    expect("Subcommands:" in run("help").stdout, "help alone lists the commands")
    shared = tmp / "shared.yaml"
    shared.write_text("sensors:\n  left: &scanner {model: sick_microscan3, ip_address: 192.168.0.1, time_offset: 0.001, frame_id: l}\n"
                      "  right: {<<: *scanner, ip_address: 192.168.0.2, frame_id: r}\n"
                      "  rear: {<<: [{time_offset: 0.5}, *scanner], ip_address: 192.168.0.3, frame_id: b}\n")
    printed = run("check", shared)
    expect(printed.returncode == 0, printed.stderr)
    offsets = [line.split()[1] for line in printed.stdout.splitlines() if "time_offset" in line]
    expect(offsets == ["0.001", "0.001", "0.5"], f"merged keys count, the nearer ones more: {offsets}")
    expect(printed.stdout.count("model: sick_microscan3") == 3, printed.stdout)


with folder() as tmp:
    tried = sum(step(tmp) for step in (commands, configurations, without_modules, captures, bag_that_exists, environment))
    colours(tmp)
    what_works(tmp)
    expect(tried >= 40, f"{tried} wrong inputs")
    print(f"{tried} wrong inputs, each answered")
