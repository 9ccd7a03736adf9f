#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Outputs that never come are reported, by replay and decode, with the reason and exit 1; outputs that come have their rate."""
import re

from harness import FILE_HEAD, PAYLOAD, ROOT, expect, folder, records, run, source_of, write

DEMO = ROOT / "pcaps/demo.pcap"
FRONT = "front_left: {model: sick_microscan3, ip_address: 192.168.0.21, pose: {xyz: [0, 1, 0.35]}}"
UNPLACED = "front_left: {model: sick_microscan3, ip_address: 192.168.0.21}"
RIGHT = "front_right: {model: sick_microscan3, ip_address: 192.168.0.22, pose: {xyz: [0, -1, 0.35]}}"
AWAY = "front_right: {model: sick_microscan3, ip_address: 192.168.0.99, pose: {xyz: [0, -1, 0.35]}}"
ROOF = "roof: {model: velodyne_vlp16, ip_address: 192.168.1.201, pose: {xyz: [0, 0, 2]}}"
REAR = "rear: {topic: /rear/scan, pose: {xyz: [-1, 0, 0.3]}}"
BOTH = "merged_scans:\n  both: {laserscan_topics: [front_left, front_right], also: {careful: safety}}\n"


def config(tmp, *sensors, outputs=""):
    return write(tmp / "config.yaml", "sensors:\n" + "".join(f"  {sensor}\n" for sensor in sensors) + outputs)


def rows(text):
    """The table of outputs: messages, rate and remark by name."""
    table = text.split("\noutput ", 1)[-1].splitlines()[1:]
    found = [re.fullmatch(r"(\S+|standard output) +(\d+) +(-|\d+\.\d)(?:  (.+))?", line) for line in table]
    return {row[1]: (int(row[2]), row[3], row[4] or "") for row in found if row}


def replay(tmp, path, capture=DEMO, *options):
    (tmp / "out.bag").unlink(missing_ok=True)
    result = run("replay", "-c", path, "--pcap", capture, "--rate", "max", "--bag", tmp / "out.bag", *options)
    return result.returncode, rows(result.stdout), result.stdout + result.stderr


def expect_none(replayed, name, *words):
    code, table, text = replayed
    expect(code == 1, f"exit {code}, expected 1:\n{text}")
    expect(name in table, f"{name} is not in the table:\n{text}")
    messages, _, remark = table[name]
    expect(messages == 0 and remark.startswith("none: ") and all(word in remark for word in words), f"{name}: {words}\n{text}")


def first_packets(capture, count, sender):
    """The bytes of a capture with only so many packets of a sender."""
    data = capture.read_bytes()
    kept = [record for record in records(data) if source_of(record) == sender][:count]
    expect(len(kept) == count, f"{capture} has only {len(kept)} packets of {sender}")
    return data[:FILE_HEAD] + b"".join(kept)


def all_well(tmp):
    code, table, text = replay(tmp, config(tmp, FRONT, RIGHT, ROOF, outputs=BOTH))
    expect(code == 0, text)
    scans = table["front_left/scan"]
    # The scene's scanners measure every 30 ms (pcaps/demo.scene.yaml), the VLP-16 turns 10 times per second.
    expect(scans[0] > 50 and scans[1] == "33.3" and not scans[2], f"{scans}")
    expect(table["both"][:2] == table["careful"][:2] == scans[:2], f"{table}")
    expect(table["roof/points"][1] == "10.0", f"{table}")
    untold = re.search(r"not sent by the devices: (.*)", text)
    expect(untold and {"roof/fix", "roof/time_reference"} <= set(untold[1].split(", ")), text)


def reasons(tmp):
    expect_none(replay(tmp, config(tmp, UNPLACED, RIGHT, outputs="merged_scans: {one: {laserscan_topics: front_left}}\n")),
                "one", "pose of front_left", "configure it")
    expect_none(replay(tmp, config(tmp, FRONT, AWAY)), "front_right/scan", "nothing received from 192.168.0.99 to port 6060",
                "192.168.0.22", "correct ip_address?")
    expect_none(replay(tmp, config(tmp, AWAY, outputs="merged_scans: {one: {laserscan_topics: front_right}}\n")),
                "one", "no input", "front_right: nothing received from 192.168.0.99")
    expect_none(replay(tmp, config(tmp, FRONT, REAR, outputs="merged_scans: {one: {laserscan_topics: rear}}\n")), "one",
                "no input", "rear: ", "/rear/scan")
    frames = "virtual_scans: {levels: {cloud_topic: roof, virtual_laser_scan: [low, high], poses: {low: {xyz: [0, 0, 1]}}}}\n"
    replayed = replay(tmp, config(tmp, ROOF, outputs=frames))
    expect_none(replayed, "high", "pose of high")
    expect(replayed[1]["low"][0] > 10, f"the other frame comes: {replayed}")
    wrong = ROOF.replace("vlp16", "vls128")
    expect_none(replay(tmp, config(tmp, wrong)), "roof/points", "this is a VLP-16", "not a VLS-128")
    expect_none(replay(tmp, config(tmp, ROOF), DEMO, "--duration", "0.04"), "roof/points", "only about 0.4 of a frame")


def without_a_source(tmp):
    """An output that comes without one of its sources is reported, but no failure."""
    code, table, text = replay(tmp, config(tmp, FRONT, REAR, outputs="merged_scans: {one: {laserscan_topics: [front_left, rear]}}\n"))
    expect(code == 0 and table["one"][0] > 50, text)
    expect("publishing without rear; " in table["one"][2] and "; rear: nothing received" in table["one"][2] and "none" not in table["one"][2], f"{table}")


def without_returns(capture):
    """The packets of a VLP-16 with every distance 0."""
    data = bytearray(capture)
    for packet in range(FILE_HEAD, len(data), PAYLOAD + 1206):
        for block in range(12):
            begin = packet + PAYLOAD + 100 * block + 4
            for channel in range(32):
                data[begin + 3 * channel:begin + 3 * channel + 2] = b"\0\0"
    return bytes(data)


def decoding(tmp):
    capture, out = tmp / "few.pcap", tmp / "out.csv"
    capture.write_bytes(first_packets(DEMO, 30, "192.168.1.201"))
    few = run("decode", capture, "-o", out)
    expect(few.returncode == 0 and "only about 0.4 of a frame: 30 packets in 0.0" in few.stderr, f"{few}")
    expect(out.read_text().count("\n") > 1000, "what there is is written")
    empty = tmp / "empty.pcap"
    empty.write_bytes(without_returns(capture.read_bytes()))
    none = run("decode", empty, "-o", out)
    expect(none.returncode == 1 and ", 0 returns" in none.stderr and out.read_text().count("\n") == 1, f"{none}")
    expect_none(replay(tmp, config(tmp, ROOF), capture), "roof/points", "only about 0.4 of a frame: 30 packets")
    whole = run("decode", DEMO, "--source", "192.168.1.201", "--frame", "3", "-o", out)
    expect(whole.returncode == 0 and rows("\n" + whole.stderr)[str(out)][0] == 1, f"{whole}")
    beyond = run("decode", DEMO, "--source", "192.168.1.201", "--frame", "21", "-o", out)
    expect(beyond.returncode == 1 and "--frame 21 is beyond the end: the capture holds 21 frames, counted from 0" in beyond.stderr,
           f"{beyond}")
    last = run("decode", DEMO, "--source", "192.168.1.201", "--frame", "20", "-o", out)
    expect(last.returncode == 0, f"{last}")


def main():
    with folder() as tmp:
        all_well(tmp)
        reasons(tmp)
        without_a_source(tmp)
        decoding(tmp)
    print("ok")


if __name__ == "__main__":
    main()
