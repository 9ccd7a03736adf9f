#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""One bad datagram costs at most one frame: into each shipped capture of UDP sensors a spoiled copy of a datagram is put, at two
places, and all frames but one stay as they are, to the last digit. Under which reason it is counted is not checked. Where a
tenth of the datagrams is lost, each return that is left is one that was measured, at its time."""
import collections
import hashlib
import pathlib
import random
import struct

from harness import FILE_HEAD, PAYLOAD, RECORD_HEAD, ROOT, expect, folder, records, run, source_of

IP, UDP = 14, 34


def is_datagram(record):
    packet = record[RECORD_HEAD:]
    return packet[12:14] == b"\x08\x00" and packet[IP + 9] == 17 and struct.unpack_from("!H", packet, IP + 6)[0] & 0x3FFF == 0


def inverted(record):
    return record[:PAYLOAD - 2] + b"\0\0" + bytes(255 - byte for byte in record[PAYLOAD:])


def cut(record):
    """Half of the payload, with lengths that say so."""
    packet = bytearray(record[RECORD_HEAD:])
    size = (len(packet) - UDP - 8) // 2
    packet = packet[:UDP + 8 + size]
    struct.pack_into("!H", packet, IP + 2, len(packet) - IP)
    struct.pack_into("!HH", packet, UDP + 4, 8 + size, 0)
    return record[:8] + struct.pack("<II", len(packet), len(packet)) + bytes(packet)


def rows(capture, model, port):
    """Of each row the frame and all columns but the one that counts packets, by their names."""
    result = run("decode", capture, "--model", model, "--port", port, "--format", "csv")
    expect(result.returncode == 0, f"{capture}: {result.stderr}")
    head, *lines = (line.split(",") for line in result.stdout.splitlines())
    return [dict(zip(head, values), packet="") for values in lines]


def digests(all_rows):
    """By frame."""
    found = collections.defaultdict(hashlib.sha256)
    for row in all_rows:
        found[row["frame"]].update(repr(row).encode())
    return {frame: digest.hexdigest() for frame, digest in found.items()}


def returns(all_rows):
    """The times, ns, at which a laser or beam measured a range and an intensity. Azimuths are interpolated to the next packet."""
    names = ("laser", "return", "beam", "echo", "distance_m", "range_m", "intensity")
    found = collections.defaultdict(list)
    for row in all_rows:
        if row.get("status", "hit") == "hit":
            found[tuple(row.get(name) for name in names)].append(int(row["stamp_ns"]))
    return found


def invented(left, whole):
    """Returns that nobody measured at their time. A VLS-128 pauses between packets: how long is seen where both came."""
    return [(*one, time) for one, times in left.items() for time in times
            if not any(abs(time - measured) < 50_000 for measured in whole.get(one, ()))]


def model_of(scene):
    """The only model of a scene."""
    models = {line.split("model:")[1].split(",")[0].strip(" }") for line in scene.read_text().splitlines() if "model:" in line}
    return models.pop() if len(models) == 1 else None


def port_of(record):
    return struct.unpack_from("!H", record, RECORD_HEAD + UDP + 2)[0]


class Capture:
    """A shipped capture: its records, the sensor's port, and which records are the datagrams to it."""

    def __init__(self, path):
        self.name, self.path, self.model = path.name, path, model_of(pathlib.Path(str(path).replace(".pcap", ".scene.yaml")))
        data = path.read_bytes()
        self.head, self.records = data[:FILE_HEAD], list(records(data))
        datagrams = [i for i, record in enumerate(self.records) if is_datagram(record)]
        self.is_fit = self.model and len({source_of(self.records[i]) for i in datagrams}) == 1 and len(datagrams) >= 100
        if self.is_fit:
            self.port = collections.Counter(port_of(self.records[i]) for i in datagrams).most_common(1)[0][0]
            self.sent = [i for i in datagrams if port_of(self.records[i]) == self.port]

    def rows_with(self, file, changed):
        file.write_bytes(self.head + b"".join(changed))
        return rows(file, self.model, self.port)


def spoil_one(capture, whole, file):
    """How many were tried."""
    before = digests(whole)
    for spoil, place in ((inverted, 0.4), (cut, 0.7)):
        at = capture.sent[int(place * len(capture.sent))]
        after = digests(capture.rows_with(file, [*capture.records[:at + 1], spoil(capture.records[at]), *capture.records[at + 1:]]))
        changed = [frame for frame in before if after.get(frame) != before[frame]]
        expect(len(after) == len(before) and len(changed) <= 1, f"{capture.name}, {spoil.__name__}: frames {changed} differ")
    return 2


def lose_a_tenth(capture, whole, file):
    """How many returns are left."""
    dice, sent = random.Random(7), set(capture.sent)
    left = returns(capture.rows_with(file, [record for i, record in enumerate(capture.records) if i not in sent or dice.random() > 0.1]))
    wrong = invented(left, returns(whole))
    expect(not wrong, f"{capture.name}: {len(wrong)} returns that were not measured, e.g. {wrong[:1]}")
    count = sum(map(len, left.values()))
    expect(count > len(whole) / 3, f"{capture.name}: only {count} of {len(whole)} rows are left")
    return count


def main():
    tried = kept = 0
    with folder() as tmp:
        for path in sorted((ROOT / "pcaps").glob("*.pcap")):
            capture = Capture(path)
            if capture.is_fit:
                whole = rows(path, capture.model, capture.port)
                tried += spoil_one(capture, whole, tmp / "bad.pcap")
                kept += lose_a_tenth(capture, whole, tmp / "bad.pcap")
    print(f"P3: {tried} bad datagrams, none of which changed more than one frame")
    print(f"P6: without a tenth of the datagrams {kept} returns, all of them as measured")
    expect(tried >= 20, f"only {tried} were tried")


if __name__ == "__main__":
    main()
