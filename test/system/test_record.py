#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""`lidard record` writes what the configured sensors send, over UDP and TCP, and nothing else."""
import json
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import threading
import time

LIDARD = os.environ["LIDARD"]
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
    assert len(got) == 7000


def main():
    with tempfile.TemporaryDirectory() as folder:
        config, capture = pathlib.Path(folder, "vehicle.yaml"), pathlib.Path(folder, "out.pcap")
        config.write_text(CONFIG)
        recorder = subprocess.Popen([LIDARD, "record", "-c", config, "-o", capture, "--interface", "lo"],
                                    stderr=subprocess.PIPE, text=True)
        try:
            if code := record(recorder, capture):
                return code
        finally:
            recorder.kill()
            recorder.wait()
        return without_configuration(capture)


def without_configuration(capture):
    """What comes to the usual ports, and nothing else."""
    recorder = subprocess.Popen([LIDARD, "record", "-o", capture, "--interface", "lo", "--duration", "4"], stderr=subprocess.PIPE, text=True)
    first = recorder.stderr.readline()
    assert "recording to" in first, first
    time.sleep(0.3)
    sensor = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sensor.bind(("127.0.0.2", 0))
    for port in (2368, 8308, 6060, 42368):
        for _ in range(10):
            sensor.sendto(bytes(1206), ("127.0.0.1", port))
    _, rest = recorder.communicate(timeout=40)
    assert recorder.returncode == 0, rest
    said = json.loads(subprocess.run([LIDARD, "inspect", "--json", capture], capture_output=True, check=True).stdout)
    ports = {f["port"]: f["packets"] for f in said["unknown"] + said["sensors"] if f["sender"] == "127.0.0.2"}
    assert ports == {2368: 10, 8308: 10, 6060: 10}, ports
    return 0


def record(recorder, capture):
    first = recorder.stderr.readline()
    if "CAP_NET_RAW" in first:
        recorder.wait()
        assert recorder.returncode == 1, recorder.returncode
        print("skipped: recording needs CAP_NET_RAW")
        return 77
    assert "recording to" in first, first
    time.sleep(0.3)
    traffic()
    time.sleep(2)  # until the kernel has handed over what it gathered, on a busy machine too
    recorder.terminate()
    _, rest = recorder.communicate(timeout=40)
    assert recorder.returncode == 0, rest
    assert "packets, 0 lost by the kernel" in rest, rest
    said = json.loads(subprocess.run([LIDARD, "inspect", "--json", capture], capture_output=True, check=True).stdout)
    flows = {(f["transport"], f["sender"], f["port"]): f for f in said["unknown"] + said["sensors"]}
    assert flows[("udp", "127.0.0.2", 42368)]["packets"] == 100, flows
    assert flows[("tcp", "127.0.0.3", DEVICE_PORT)]["bytes"] == 7000, flows
    assert not any(sender == "127.0.0.9" for _, sender, _ in flows), flows
    assert said["captures"][0]["tcp_missing"] == 0, said["captures"]
    wrong = subprocess.run([LIDARD, "record", "-c", "/no/such.yaml", "-o", "/dev/null"], capture_output=True, check=False)
    assert wrong.returncode == 78, wrong
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main())
    except AssertionError as error:
        sys.exit(f"FAILED: {error}")
