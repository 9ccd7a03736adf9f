#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""`lidard record` writes what the configured sensors send, over UDP and TCP, and nothing else."""
import json
import socket
import subprocess
import sys
import threading
import time

from harness import LIDARD, SKIP, expect, folder, process, run, write

DEVICE_PORT = 42112

CONFIG = f"""
sensors:
  roof: {{model: velodyne_vlp16, ip_address: 127.0.0.2, ip_port: 42368}}
  front: {{model: hokuyo_ust_10lx, ip_address: 127.0.0.3, ip_port: {DEVICE_PORT}}}
"""


def serve(listener):
    client, _ = listener.accept()
    client.recv(100)
    client.sendall(b"answer\n" * 1000)
    client.close()


def traffic():
    """100 datagrams of the sensor, 50 of another, and a conversation over TCP."""
    sensor, other = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
    sensor.bind(("127.0.0.2", 0))
    other.bind(("127.0.0.9", 0))
    for i in range(100):
        sensor.sendto(bytes(1206), ("127.0.0.1", 42368))
        if i % 2:
            other.sendto(bytes(1206), ("127.0.0.1", 42368))
    listener = socket.socket()
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    listener.bind(("127.0.0.3", DEVICE_PORT))
    listener.listen(1)
    server = threading.Thread(target=serve, args=(listener,))
    server.start()
    client = socket.create_connection(("127.0.0.3", DEVICE_PORT))
    client.sendall(b"question\n")
    got = b""
    while part := client.recv(65536):
        got += part
    server.join()
    expect(len(got) == 7000, f"{len(got)} bytes")


def recording(*arguments):
    return process([LIDARD, "record", *arguments, "--interface", "lo"], stderr=subprocess.PIPE, text=True)


def begin(recorder):
    first = recorder.stderr.readline()
    if "CAP_NET_RAW" in first:
        expect(recorder.wait() == 1, f"{recorder.returncode}")
        print("skipped: recording needs CAP_NET_RAW")
        sys.exit(SKIP)
    expect("recording to" in first, first)
    time.sleep(0.3)


def recorded(recorder, capture):
    """What the recorder says at its end, and what inspect finds."""
    _, said = recorder.communicate(timeout=40)
    expect(recorder.returncode == 0, said)
    return said, json.loads(run("inspect", "--json", capture).stdout)


def with_configuration(tmp, capture):
    with recording("-c", write(tmp / "vehicle.yaml", CONFIG), "-o", capture) as recorder:
        begin(recorder)
        traffic()
        time.sleep(2)  # until the kernel has handed over what it gathered, on a busy machine too
        recorder.terminate()
        said, found = recorded(recorder, capture)
    expect("packets, 0 lost by the kernel" in said, said)
    flows = {(f["transport"], f["sender"], f["port"]): f for f in found["unknown"] + found["sensors"]}
    expect(flows[("udp", "127.0.0.2", 42368)]["packets"] == 100, flows)
    expect(flows[("tcp", "127.0.0.3", DEVICE_PORT)]["bytes"] == 7000, flows)
    expect(not any(sender == "127.0.0.9" for _, sender, _ in flows), flows)
    expect(found["captures"][0]["tcp_missing"] == 0, found["captures"])


def without_configuration(capture):
    """What comes to the usual ports, and nothing else."""
    with recording("-o", capture, "--duration", "4") as recorder:
        begin(recorder)
        sensor = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        sensor.bind(("127.0.0.2", 0))
        for port in (2368, 8308, 6060, 42368):
            for _ in range(10):
                sensor.sendto(bytes(1206), ("127.0.0.1", port))
        _, found = recorded(recorder, capture)
    ports = {f["port"]: f["packets"] for f in found["unknown"] + found["sensors"] if f["sender"] == "127.0.0.2"}
    expect(ports == {2368: 10, 8308: 10, 6060: 10}, ports)


with folder() as tmp:
    with_configuration(tmp, tmp / "out.pcap")
    without_configuration(tmp / "out.pcap")
