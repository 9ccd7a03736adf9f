#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Two daemons of one node name: the first stays and publishes, the second ends with exit 1 and names the remedy; also where both
have waited for the master and register at the same time. A call of `shutdown` from elsewhere does not end a daemon, and the name
of one that was killed is free at once."""
import contextlib
import os
import signal
import socket
import subprocess
import threading
import time
import xmlrpc.client
import xmlrpc.server

import rospy
from harness import (LIDARD, LIDARD_SIM, SCANNER_CONFIG, SCANNER_SCENE, Starved, expect, folder, free_port, process, ros_master,
                     run, use_master_at, wait_for)
from sensor_msgs.msg import LaserScan



class Vehicle:
    def __init__(self, tmp):
        self.tmp, self.count, self.port = tmp, 0, free_port(socket.SOCK_DGRAM)
        self.config = tmp / "first.yaml"
        self.config.write_text(SCANNER_CONFIG.format(port=self.port))
        # The second one listens to another port, where nothing comes: whose scans they are is plain.
        self.other = tmp / "second.yaml"
        self.other.write_text(SCANNER_CONFIG.format(port=free_port(socket.SOCK_DGRAM)))
        (tmp / "scene.yaml").write_text(SCANNER_SCENE.format(port=self.port))

    @contextlib.contextmanager
    def daemon(self, config):
        """A daemon and its log."""
        self.count += 1
        log = self.tmp / f"log{self.count}.txt"
        with log.open("w") as sink, process([LIDARD, "run", "-c", config], stdout=sink, stderr=subprocess.STDOUT) as daemon:
            yield daemon, log


def pid_at(master):
    """The process that has the name now; None while there is none."""
    try:
        code, _, uri = master.lookupNode("/test", "/lidard")
        return xmlrpc.client.ServerProxy(uri).getPid("/test")[2] if code == 1 else None
    except OSError:
        return None


def second_leaves(vehicle, master, scans):
    with vehicle.daemon(vehicle.config) as (a, log):
        wait_for(lambda: len(scans) > 20, 20, "scans of the first")
        with vehicle.daemon(vehicle.other) as (b, second_log):
            begin = time.monotonic()
            wait_for(lambda: b.poll() is not None, 15, "the second ends")
            print(f"second started: it ended after {time.monotonic() - begin:.1f} s")
            expect(b.returncode == 1, f"the second ends with {b.returncode}")
        text = second_log.read_text()
        expect("/lidard" in text and "__name:=" in text, f"it names the name and the remedy:\n{text}")
        print(next(line for line in text.splitlines() if "__name:=" in line))
        before = len(scans)
        wait_for(lambda: len(scans) > before + 20, 5, "the first publishes on")
        expect(a.poll() is None and pid_at(master) == a.pid, "the first has the name")
        expect("shut down from outside" not in log.read_text(), "the first was left alone:\n" + log.read_text())
        replay = run("replay", "-c", vehicle.config, "--pcap", os.environ["LIDARD_SOURCE_DIR"] + "/pcaps/demo.pcap", "--wait", "0")
        expect(replay.returncode == 1 and "__name:=" in replay.stderr, f"a replay of the same name is refused:\n{replay.stderr}")
        foreign_call(master, a, scans)
        os.kill(a.pid, signal.SIGKILL)
        a.wait()
    killed = time.monotonic()
    with vehicle.daemon(vehicle.config) as (c, _):
        before = len(scans)
        wait_for(lambda: len(scans) > before, 10, "scans of a third, after the first was killed")
        print(f"after a kill: scans again {time.monotonic() - killed:.1f} s later")
        expect(pid_at(master) == c.pid, "it has the name")


def foreign_call(master, daemon, scans):
    """P16: publishing again within 1 s; from the third call in 10 s on the daemon steps aside for a while, and ten seconds later all
    is forgotten."""
    uri = master.lookupNode("/test", "/lidard")[2]
    for call in range(5):
        if call == 4:
            time.sleep(11)
        starved, began = Starved(), time.monotonic()
        xmlrpc.client.ServerProxy(uri).shutdown("/intruder", "go away")
        wait_for(lambda: master.lookupNode("/test", "/lidard")[2] not in ("", uri), 20, "it registers again")
        uri = master.lookupNode("/test", "/lidard")[2]
        before = len(scans)
        wait_for(lambda: len(scans) > before, 5, "it publishes again")
        took = time.monotonic() - began
        print(f"call {call + 1} of shutdown: scans again after {took:.2f} s")
        expect(call in (2, 3) or took <= 1 + starved.seconds(), f"scans again after {took:.2f} s, starved {starved.seconds():.3f} s")
    expect(daemon.poll() is None, "the daemon lives after four calls of shutdown")


def both_wait(vehicle, master_port):
    """Who of both comes first to a master that appears is chance; the other one leaves."""
    with vehicle.daemon(vehicle.config) as (a, log_a), vehicle.daemon(vehicle.other) as (b, log_b):
        time.sleep(2)
        with ros_master(master_port):
            begin = time.monotonic()
            wait_for(lambda: a.poll() is not None or b.poll() is not None, 30, "one of both ends")
            (gone, log), stays = ((a, log_a), b) if a.poll() is not None else ((b, log_b), a)
            print(f"both waited for the master: one ended after {time.monotonic() - begin:.1f} s")
            expect(gone.returncode == 1 and "__name:=" in log.read_text(), f"it ends with 1:\n{log.read_text()}")
            with xmlrpc.client.ServerProxy(f"http://127.0.0.1:{master_port}") as master:
                wait_for(lambda: pid_at(master) == stays.pid, 10, "the other one has the name")
            time.sleep(3)
            expect(stays.poll() is None, "and lives on")


def port_owner_wins(vehicle, master_port):
    """Both have the same ports: the one that opened them gets the name too, though both have waited for the master."""
    for _ in range(2):
        with vehicle.daemon(vehicle.config) as (a, log_a):
            wait_for(lambda: "listening on port" in log_a.read_text(), 10, "the first has the port")
            with vehicle.daemon(vehicle.config) as (b, log_b):
                wait_for(lambda: f"process {a.pid}" in log_b.read_text(), 10, "the second knows who has the port")
                time.sleep(1)
                with ros_master(master_port):
                    wait_for(lambda: b.poll() is not None, 30, "the second ends")
                    expect(b.returncode == 1 and "__name:=" in log_b.read_text(), f"it ends with 1:\n{log_b.read_text()}")
                    with xmlrpc.client.ServerProxy(f"http://127.0.0.1:{master_port}") as master:
                        expect(pid_at(master) == a.pid and a.poll() is None, "the owner of the port has the name")
                    expect("shut down from outside" not in log_a.read_text(), "and was left alone:\n" + log_a.read_text())
    print("both waited for the master with the same ports: the one that has them stays")


class Rival:
    """Speaks as a daemon of the same name that started `age_s` before now; takes the name back at each shutdown, `times` at most."""

    def __init__(self, age_s, times):
        self.left, self.started = times, int((time.time() - age_s) * 1e9)
        self.server = xmlrpc.server.SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False)
        self.server.register_function(lambda name: [1, name, str(self.started)], "lidard_started")
        self.server.register_function(self.shutdown, "shutdown")
        self.server.register_function(lambda name: [1, "", 0], "getPid")
        self.uri = f"http://127.0.0.1:{self.server.server_address[1]}/"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def take(self):
        with xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"]) as master:
            master.registerPublisher("/lidard", "/rival", "std_msgs/String", self.uri)
        self.left -= 1

    def shutdown(self, *_):
        if self.left > 0:
            threading.Timer(0.2, self.take).start()
        return [1, "", 0]


def rival(vehicle, master, age_s, stays):
    with vehicle.daemon(vehicle.config) as (daemon, log):
        wait_for(lambda: "publishing as /lidard" in log.read_text(), 10, "the daemon has the name")
        time.sleep(0.5)
        begin, other = time.monotonic(), Rival(age_s, 3 if stays else 9)
        other.take()
        if stays:
            wait_for(lambda: other.left == 0 and pid_at(master) == daemon.pid, 20, f"the daemon has the name again:\n{log.read_text()}")
            time.sleep(2)
            expect(daemon.poll() is None, "the first daemon stays")
        else:
            wait_for(lambda: daemon.poll() is not None, 20, f"the daemon ends:\n{log.read_text()}")
            expect(daemon.returncode == 1 and "__name:=" in log.read_text(), f"with 1:\n{log.read_text()}")
        times = log.read_text().count("shut down from outside")
        print(f"a rival that started {age_s} s ago threw it out {times} times: it {'stayed' if stays else 'left'} "
              f"after {time.monotonic() - begin:.1f} s")
        # A take-over while a daemon still registers is one with the next.
        expect(times in (2, 3) if stays else times == 3, "three takeovers:\n" + log.read_text())


def main():
    master_port = free_port()
    use_master_at(master_port)
    with folder() as tmp:
        vehicle = Vehicle(tmp)
        sim = process([LIDARD_SIM, "live", tmp / "scene.yaml"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        with sim:
            scans = []
            with ros_master(master_port), xmlrpc.client.ServerProxy(f"http://127.0.0.1:{master_port}") as master:
                rospy.init_node("listener", disable_signals=True, anonymous=True)
                rospy.Subscriber("/front/scan", LaserScan, scans.append, queue_size=100)
                second_leaves(vehicle, master, scans)
                rival(vehicle, master, -100, stays=True)
                rival(vehicle, master, 100, stays=False)
            both_wait(vehicle, master_port)
            port_owner_wins(vehicle, master_port)
    print("ok")


if __name__ == "__main__":
    main()
