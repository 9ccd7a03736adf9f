#!/usr/bin/env python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Figures of recorded SICK scanners that tests expect, read from the captures by a decoder that shares nothing
with the program's:

    python3 test/support/sick_figures.py $LIDARD_CAPTURES/sick
"""
import struct
import sys
import zlib
from collections import Counter
from pathlib import Path


def payloads(path):
    """(is_udp, source port, payload) of each IPv4 packet of a pcap file; fragments are put together."""
    data = path.read_bytes()
    parts = {}
    at = 24
    while at + 16 <= len(data):
        size = struct.unpack_from("<I", data, at + 8)[0]
        ip = data[at + 16 + 14:at + 16 + size]
        at += 16 + size
        place = struct.unpack_from(">H", ip, 6)[0]
        body = ip[(ip[0] & 15) * 4:struct.unpack_from(">H", ip, 2)[0]]
        if place & 0x3FFF:
            whole = parts.setdefault((ip[4:6], ip[12:20]), {})
            whole[(place & 0x1FFF) * 8] = body
            whole[-1] = whole.get(-1, 0) or (0 if place & 0x2000 else (place & 0x1FFF) * 8 + len(body))
            if whole[-1] != sum(len(b) for offset, b in whole.items() if offset >= 0):
                continue
            body = b"".join(whole[offset] for offset in sorted(whole) if offset >= 0)
        port = struct.unpack_from(">H", body)[0]
        yield ip[9] == 17, port, body[8:] if ip[9] == 17 else body[(body[12] >> 4) * 4:]


def microscan3(folder):
    instances, whole = {}, []
    for _, _, datagram in payloads(folder / "microscan3_398.pcap"):
        total, number, offset = struct.unpack_from("<III", datagram, 8)
        parts = instances.setdefault(number, {})
        parts[offset] = datagram[24:]
        if sum(map(len, parts.values())) == total:
            whole.append(b"".join(parts[o] for o in sorted(parts)))
    crc, status, weak, bright, hits, range_sum, reflectivity_sum = 0, Counter(), Counter(), Counter(), 0, 0, 0
    for scan in whole:
        block = struct.unpack_from("<H", scan, 40)[0]
        beams = scan[block + 4:block + 4 + 4 * struct.unpack_from("<I", scan, block)[0]]
        crc = zlib.crc32(beams, crc)
        for distance, reflectivity, flags in struct.iter_unpack("<HBB", beams):
            status[flags] += 1
            reflectivity_sum += reflectivity
            if flags & 2:
                continue
            kind = weak if reflectivity < 20 else bright if reflectivity >= 30 else Counter()
            kind.update({"all": 1, "bit 6": flags >> 6 & 1, "bit 7": flags >> 7})
            hits += distance >= 100
            range_sum += distance if distance >= 100 else 0
    sequence = [struct.unpack_from("<I", scan, 16)[0] for scan in whole]
    print(f"microscan3: {len(whole)} scans, {sum(status.values())} beams, CRC-32 of all beams {crc:#010x}")
    print("  flags", {hex(f): n for f, n in sorted(status.items())}, "weak", dict(weak), "bright", dict(bright))
    print(f"  at 100 mm and beyond {hits}, their sum {range_sum} mm, sum of reflectivities {reflectivity_sum}")
    print(f"  missing between {sequence[-1] - sequence[0] + 1 - len(whole)}, begun and not ended "
          f"{len(instances) - len(whole)}")


def mrs1000(folder):
    stream = b"".join(p for udp, port, p in payloads(folder / "mrs1000_test01.pcap") if not udp and port == 2112)
    hits, telegrams, at = Counter(), 0, 0
    while at + 9 <= len(stream):
        size = struct.unpack_from(">I", stream, at + 4)[0]
        telegram = stream[at + 8:at + 8 + size]
        at += 9 + size
        if not telegram.startswith(b"sSN LMDscandata "):
            continue
        telegrams += 1
        channel = 52 + 6 * struct.unpack_from(">H", telegram, 52)[0] + 2
        count, channel = struct.unpack_from(">H", telegram, channel)[0], channel + 2
        for _ in range(count):
            values = struct.unpack_from(">H", telegram, channel + 19)[0]
            raw = struct.unpack_from(f">{values}H", telegram, channel + 21)
            hits[telegram[channel:channel + 5].decode()] += sum(v > 15 for v in raw)
            channel += 21 + 2 * values
    print(f"mrs1000: {telegrams} telegrams, distances", {k: n for k, n in hits.items() if k.startswith("DIST")})


def picoscan150(folder):
    hits, starts = Counter(), {}
    for _, _, telegram in payloads(folder / "picoscan150_compact_frag.pcap"):
        segment, frame, _, _, beams, echoes = struct.unpack_from("<QQIIII", telegram, 32)
        starts[(frame, segment)] = struct.unpack_from("<Q", telegram, 64)[0]
        for beam in range(beams):
            for echo in range(echoes):
                hits[echo] += struct.unpack_from("<H", telegram, 104 + beam * (4 * echoes + 3) + 4 * echo)[0] >= 50
    inside = sorted(starts[(f, s)] - starts[(f, s - 1)] for f, s in starts if s > 1 and (f, s - 1) in starts)
    print(f"picoscan150: distances {dict(hits)}, median from segment to segment "
          f"{inside[len(inside) // 2]} us, {inside[len(inside) // 2] / 240:.3f} us per beam")


def lms5xx(folder):
    for name in ("lms5xx_colaa_scale2_25m.pcap", "lms5xx_colaa_100hz.pcap"):
        stream = b"".join(p for udp, port, p in payloads(folder / name) if not udp and port == 2111)
        hits = []
        for text in stream.split(b"\x03")[:-1]:
            words = text.split(b" ")
            at = words.index(b"DIST1")
            scale = struct.unpack(">f", bytes.fromhex(words[at + 1].decode()))[0]
            raw = [int(w, 16) for w in words[at + 6:at + 6 + int(words[at + 5], 16)]]
            hits += [scale * v for v in raw if v > 15]
        print(f"{name}: {len(hits)} distances, {sum(h > 50000 for h in hits)} beyond 50 m, sum {sum(hits):.0f} mm")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    for figures in (microscan3, mrs1000, picoscan150, lms5xx):
        figures(Path(sys.argv[1]))
