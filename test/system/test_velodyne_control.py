#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The daemon sends nothing to a sensor's web interface unless asked, then only reads, and writes only what differs."""
import contextlib
import http.server
import json
import socket
import subprocess
import threading
import time
import urllib.parse

from harness import LIDARD, LIDARD_SIM, ROOT, Starved, expect, folder, free_port, process, use_master_at, wait_for

ADDRESS = "127.168.1.201"


class Sensor(http.server.ThreadingHTTPServer):
    """A VLP-16's web server on an address of the loopback."""
    daemon_threads = True

    def __init__(self):
        super().__init__((ADDRESS, 0), Answer)
        self.config = {"rpm": 600, "returns": "Strongest", "laser": "On", "fov": {"start": 0, "end": 359},
                       "host": {"addr": "255.255.255.255", "dport": 2368, "tport": 8308}}
        self.requests = []
        self.hang = threading.Event()
        self.lock = threading.Lock()

    def handle_error(self, request, client_address):
        """A daemon that ends cuts its request off."""

    def tree(self):
        status = {"gps": {"pps_state": "Absent", "position": ""}, "motor": {"state": "On", "rpm": self.config["rpm"]},
                  "laser": {"state": "On"}}
        return {"info": {"model": "VLP-16", "serial": "AG29999999"}, "config": self.config, "status": status}

    def seen(self, method=""):
        with self.lock:
            return [text for _, text in self.requests if text.startswith(method)]

    def times(self):
        with self.lock:
            return [when for when, _ in self.requests]


class Answer(http.server.BaseHTTPRequestHandler):
    """HTTP/1.0, as the class has it: the connection is closed after the answer."""

    def note(self, body=""):
        with self.server.lock:
            self.server.requests.append((time.monotonic(), f"{self.command} {self.path} {body}".strip()))
        if self.server.hang.is_set():
            time.sleep(60)

    def do_GET(self):
        self.note()
        tree = self.server.tree()
        content = {"/cgi/snapshot.hdl": tree, "/cgi/status.json": tree["status"]}
        self.send_response(200)
        self.end_headers()
        self.wfile.write(json.dumps(content[self.path]).encode())

    def do_POST(self):
        body = self.rfile.read(int(self.headers["Content-Length"])).decode()
        self.note(body)
        with self.server.lock:
            section = self.server.config
            for name in self.path.removeprefix("/cgi/setting").strip("/").split("/"):
                section = section[name] if name in section else section
            if self.path.startswith("/cgi/setting"):
                section.update({k: int(v) if v.isdigit() else v for k, v in urllib.parse.parse_qsl(body)})
        self.send_response(204)
        self.end_headers()

    def log_message(self, *_):
        pass


@contextlib.contextmanager
def sensor():
    server = Sensor()
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    yield server
    server.shutdown()
    server.server_close()


@contextlib.contextmanager
def daemon(tmp, server, control):
    """A running daemon: process, text of its log so far, its data port. Ends well within two seconds."""
    port = free_port(socket.SOCK_DGRAM)
    server.config["host"]["dport"] = port
    config = tmp / "control.yaml"
    line = f"    control: {{port: {server.server_address[1]}, {control}}}\n" if control is not None else ""
    config.write_text(f"sensors:\n  roof:\n    model: velodyne_vlp16\n    ip_address: {ADDRESS}\n    ip_port: {port}\n"
                      "    pose: {xyz: [0, 0, 2]}\n" + line)
    log = tmp / "log.txt"
    with log.open("w") as sink, process([LIDARD, "run", "-c", config], stdout=sink, stderr=subprocess.STDOUT) as child:
        wait_for(lambda: f"listening on port {port}" in log.read_text(), 20, "the daemon listens")
        yield child, log.read_text, port
        begin, starved = time.monotonic(), Starved()
        child.terminate()
        expect(child.wait(40) == 0, "SIGTERM ends the daemon with 0:\n" + log.read_text())
        took = time.monotonic() - begin
        expect(took < 3 + starved.seconds(), f"it took {took:.1f} s to end")


def nothing_by_default(tmp):
    for control in (None, "read: false", "allow_write: true"):
        with sensor() as server:
            with daemon(tmp, server, control):
                time.sleep(2.5)
            expect(server.seen() == [], f"control {control}: {server.seen()}")


def only_reading(tmp):
    """Reads at its pace, and notices that the data are not what the sensor reports."""
    with sensor() as server, daemon(tmp, server, "read: true") as (_, log, port):
        starved = Starved()
        server.config["host"]["addr"] = "127.0.0.99"
        send = f"while :; do '{LIDARD_SIM}' send '{ROOT}/pcaps/vlp16_dual.pcap' --to 127.0.0.1 --port-map=2368={port}; done"
        with process(["/bin/sh", "-c", send], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL):
            wait_for(lambda: "sends to 127.0.0.99, but its data arrive for 127.0.0.1" in log(), 40,
                     "the log tells the contradiction:\n" + log())
            wait_for(lambda: len(server.seen("GET")) >= 4, 30, f"it reads on: {server.seen()}")
        expect(len(server.seen("GET")) == len(server.seen()), f"only reads: {server.seen()}")
        times = server.times()
        shortest = min(b - a for a, b in zip(times, times[1:]))
        # A request that is noticed late is nearer to the next one.
        expect(shortest >= 1 - min(0.9, starved.seconds()), f"requests {shortest:.3f} s apart")


def rounds(server, count):
    wait_for(lambda: len(server.seen("GET /cgi/snapshot.hdl")) >= count, 40, f"{count} rounds of questions")


def agreeing(tmp):
    with sensor() as server:
        wanted = "allow_write: true, rpm: 600, returns: strongest, fov_start_deg: 0, fov_end_deg: 360"
        with daemon(tmp, server, wanted):
            rounds(server, 3)
        expect(server.seen("POST") == [], f"nothing differs, yet {server.seen('POST')}")


def differing(tmp):
    with sensor() as server:
        wanted = "allow_write: true, rpm: 1200, returns: strongest, fov_start_deg: 270, fov_end_deg: 360"
        with daemon(tmp, server, wanted) as (_, log, _port):
            rounds(server, 3)
            expect("wrote rpm: 600 -> 1200" in log(), "the log tells the change:\n" + log())
        posts = ["POST /cgi/setting rpm=1200", "POST /cgi/setting/fov start=270"]
        expect(server.seen("POST") == posts, f"{server.seen('POST')}")
        expect(server.config["rpm"] == 1200 and server.config["fov"] == {"start": 270, "end": 359}, f"{server.config}")


def hanging(tmp):
    with sensor() as server:
        server.hang.set()
        with daemon(tmp, server, "read: true"):
            wait_for(server.seen, 20, "a request")


def main():
    use_master_at(free_port())
    with folder() as tmp:
        nothing_by_default(tmp)
        only_reading(tmp)
        agreeing(tmp)
        differing(tmp)
        hanging(tmp)
    print("ok")


if __name__ == "__main__":
    main()
