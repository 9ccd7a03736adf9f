#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The daemon sends nothing to a sensor's web interface unless a setting is wanted, writes only what differs, reads it back, and is
quiet then. The dialogue itself is tested without sockets (WebDialogue.*)."""
import contextlib
import http.server
import json
import signal
import socket
import threading
import time

from harness import (ROOT, Starved, expect, expect_end, folder, free_port, send_for_ever, use_master_at, wait_for, write)
from harness import daemon as started_daemon

ADDRESS = "127.168.1.201"


class Answer(http.server.BaseHTTPRequestHandler):
    """HTTP/1.0, as the class has it: the connection is closed after the answer."""

    def answer(self, code, body=""):
        self.server.seen.append(f"{self.command} {self.path} {body}".strip())
        if self.server.hangs:
            time.sleep(60)
        self.send_response(code)
        self.end_headers()

    def do_GET(self):
        self.answer(200)
        self.wfile.write(json.dumps({"info": {"model": "VLP-16", "serial": "AG29999999"}, "config": self.server.config}).encode())

    def do_POST(self):
        body = self.rfile.read(int(self.headers["Content-Length"])).decode()
        name, value = body.split("=")
        (self.server.config["fov"] if self.path.endswith("/fov") else self.server.config)[name] = int(value)
        self.answer(204, body)

    def log_message(self, *_):
        pass


@contextlib.contextmanager
def daemon(tmp, control, hangs=False):
    """A VLP-16's web server, and the log of a running daemon, which ends well within three seconds."""
    port = free_port(socket.SOCK_DGRAM)
    server = http.server.ThreadingHTTPServer((ADDRESS, 0), Answer)
    server.daemon_threads, server.handle_error = True, lambda *_: None  # a daemon that ends cuts its request off
    server.seen, server.hangs = [], hangs
    server.config = {"rpm": 600, "returns": "Strongest", "laser": "On", "fov": {"start": 0, "end": 359},
                     "host": {"addr": "127.0.0.99", "dport": port, "tport": 8308}}
    threading.Thread(target=server.serve_forever, daemon=True).start()
    line = f", control: {{port: {server.server_address[1]}, {control}}}" if control is not None else ""
    config = f"sensors: {{roof: {{model: velodyne_vlp16, ip_address: {ADDRESS}, ip_port: {port}, pose: {{xyz: [0, 0, 2]}}{line}}}}}\n"
    with started_daemon(write(tmp / "control.yaml", config)) as child:
        wait_for(lambda: f"listening on port {port}" in child.said(), 20, "the daemon listens")
        yield server, child.said, port
        starved = Starved()
        took = expect_end(child, signal.SIGTERM)
        expect(took < 3 + starved.seconds(), f"it took {took:.1f} s to end")
    server.shutdown()
    server.server_close()


def comparisons(server, count):
    wait_for(lambda: server.seen.count("GET /cgi/snapshot.hdl") == count, 40, f"{count} comparisons: {server.seen}")


def main():
    use_master_at(free_port())
    with folder() as tmp:
        for control in (None, "allow_write: true"):
            with daemon(tmp, control) as (server, _, _port):
                time.sleep(2.5)  # what must not come may come
            expect(server.seen == [], f"control {control}: {server.seen}")
        wanted = "allow_write: true, rpm: 1200, returns: strongest, fov_start_deg: 270, fov_end_deg: 360"
        with daemon(tmp, wanted) as (server, log, port):
            with send_for_ever(ROOT / "pcaps/vlp16_dual.pcap", {2368: port}):
                comparisons(server, 2)
                expect("writes rpm: 600 -> 1200" in log(), "the log shows the change:\n" + log())
                time.sleep(12)  # a comparison that must not come may come
            expect(server.seen == ["GET /cgi/snapshot.hdl", "POST /cgi/setting rpm=1200", "POST /cgi/setting/fov start=270",
                                   "GET /cgi/snapshot.hdl"], f"{server.seen}")
            server.config["rpm"] = 600  # as after a restart
            with send_for_ever(ROOT / "pcaps/vlp16_dual.pcap", {2368: port}):
                wait_for(lambda: server.config["rpm"] == 1200, 40, f"the setting is written again: {server.seen}")
        expect(server.config["rpm"] == 1200 and server.config["fov"] == {"start": 270, "end": 359}, f"{server.config}")
        with daemon(tmp, wanted, hangs=True) as (server, _, _port):
            wait_for(lambda: server.seen, 20, "a request")
    print("ok")


if __name__ == "__main__":
    main()
