#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""lidard decode: what came before the cut of a capture is used. Of a big capture memory stays that of a
frame, and progress is for a terminal alone. Captures come packed and through pipes too."""
import gzip
import lzma
import multiprocessing
import os
import pty
import re
import struct
import subprocess
import sys
import time

from harness import FILE_HEAD, LIDARD, PAYLOAD, ROOT, expect, folder, make_capture, run

DEMO = ROOT / "pcaps/demo.pcap"
MEGABYTE = 1_000_000


def grown(path, size):
    """A second of a simulated VLS-128 again and again, the clocks going on, until the file has `size` bytes."""
    scene = (ROOT / "pcaps/vls128_a.scene.yaml").read_text()
    data = make_capture(path.with_name("second"), re.sub("duration: .*", "duration: 1", scene)).read_bytes()
    record = PAYLOAD + 1206
    expect((len(data) - FILE_HEAD) % record == 0, "one kind of packet")
    with open(path, "wb") as out:
        out.write(data[:FILE_HEAD])
        for turn in range(size // len(data) + 1):
            again = bytearray(data[FILE_HEAD:])
            for at in range(0, len(again), record):
                seconds, fraction = struct.unpack_from("<II", again, at)
                struct.pack_into("<I", again, at, seconds + turn)
                device = struct.unpack_from("<I", again, at + record - 6)[0]
                struct.pack_into("<I", again, at + record - 6, (device + 1_000_000 * turn) % 3_600_000_000)
            out.write(again)


def peak_of(*arguments, out):
    """Megabytes that a command needed at most, and the seconds it took."""
    begin = time.monotonic()
    child = subprocess.Popen([LIDARD, *map(str, arguments)], stdout=out, stderr=subprocess.PIPE, text=True)
    said = child.stderr.read()
    _, status, used = os.wait4(child.pid, 0)
    expect(status == 0, said)
    return used.ru_maxrss * 1024 / MEGABYTE, time.monotonic() - begin, said


def big_captures(tmp):
    maker = multiprocessing.get_context("fork").Process(target=grown, args=(tmp / "big.pcap", 120 * MEGABYTE))
    maker.start()
    maker.join()
    expect(maker.exitcode == 0, "the big capture")
    with open(os.devnull, "wb") as nowhere:
        megabytes, took, said = peak_of("decode", tmp / "big.pcap", "--format", "pcd", "-o", tmp / "big.pcd", out=nowhere)
        returns = int(said.split(" frames, ")[1].split()[0])
        expect(megabytes < 100, f"{megabytes:.0f} MB of memory for PCD")
        expect(returns > 20_000_000 and (tmp / "big.pcd").stat().st_size == 256 + 22 * returns, "every return is in the file")
        print(f"pcd: {returns / took / 1e6:.1f} M points/s, {megabytes:.0f} MB")
        (tmp / "big.pcd").unlink()
        expect("% " not in said and "left" not in said, f"progress without a terminal: {said}")
        megabytes, took, _ = peak_of("decode", tmp / "big.pcap", out=nowhere)
        expect(megabytes < 100, f"{megabytes:.0f} MB of memory for CSV")
        print(f"csv: {returns / took / 1e6:.1f} M points/s, {megabytes:.0f} MB")


def progress_on_a_terminal(tmp):
    terminal, other_end = pty.openpty()
    child = subprocess.Popen([LIDARD, "decode", tmp / "big.pcap", "-o", os.devnull], stderr=other_end)
    os.close(other_end)
    said = b""
    try:
        while part := os.read(terminal, 4096):
            said += part
    except OSError:
        pass  # the other end is closed
    expect(child.wait() == 0, said)
    expect(b" M returns/s" in said and b" s left\x1b[K" in said and b"\r" in said, f"no progress line: {said[:300]}")


def packed_and_piped(tmp):
    plain = DEMO.read_bytes()
    wanted = run("decode", DEMO, "--port", "2368").stdout
    (tmp / "demo.pcap.gz").write_bytes(gzip.compress(plain, 1))
    expect(run("decode", tmp / "demo.pcap.gz", "--port", "2368").stdout == wanted, "demo.pcap.gz holds something else")
    result = run("inspect", tmp / "demo.pcap.gz")
    expect(result.returncode == 0 and "velodyne_vlp16" in result.stdout, result.stderr)
    (tmp / "demo.pcap.xz").write_bytes(lzma.compress(plain, preset=0))
    result = run("inspect", tmp / "demo.pcap.xz")
    expect(result.returncode == 1 and "is packed with xz" in result.stderr and "use `xz -d` first" in result.stderr, result.stderr)
    (tmp / "cut.gz").write_bytes((tmp / "demo.pcap.gz").read_bytes()[:200_000])
    result = run("decode", tmp / "cut.gz", "--port", "2368", "-o", os.devnull)
    expect(result.returncode == 1 and "the gzip file was cut off, at byte 200000" in result.stderr, result.stderr)
    for source in (plain, gzip.compress(plain, 1)):
        for command in (["decode", "-", "--port", "2368"], ["inspect", "-"], ["snapshot", "-", "-o", str(tmp / "p.png")],
                        ["replay", "-c", str(ROOT / "config/demo.yaml"), "-", "--rate", "max", "--bag", str(tmp / "b.bag")]):
            (tmp / "b.bag").unlink(missing_ok=True)
            result = subprocess.run([LIDARD, *command], input=source, capture_output=True)
            expect(result.returncode == 0, f"{command}: {result.stderr}")
            if command[0] == "decode":
                expect(result.stdout.decode() == wanted, "standard input holds something else")
    result = subprocess.run([LIDARD, "inspect", "-"], stdin=subprocess.DEVNULL, capture_output=True, text=True)
    expect(result.returncode == 1 and "standard input: is neither a file nor a pipe" in result.stderr, result.stderr)


def cut_capture(tmp):
    cut = tmp / "cut.pcap"
    cut.write_bytes(DEMO.read_bytes()[:1_000_000])
    result = run("decode", cut, "--model", "velodyne_vlp16", "-o", tmp / "cut.csv")
    expect(result.returncode == 0, f"exit {result.returncode} where a last record alone is not whole")
    expect("cut.pcap: " in result.stderr and "what came before it was used" in result.stderr, result.stderr)
    expect((tmp / "cut.csv").read_text().count("\n") > 100_000, "what came before the cut is written")


def main():
    with folder() as tmp:
        # First: a child's peak of memory counts what its parent had before.
        big_captures(tmp)
        progress_on_a_terminal(tmp)
        packed_and_piped(tmp)
        cut_capture(tmp)
    print("ok")


if __name__ == "__main__":
    sys.exit(main())
