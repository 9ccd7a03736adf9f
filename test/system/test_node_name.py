#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Two daemons of one node name: the first stays and publishes, the second ends with exit 1 and names the remedy; also where there
is no master yet, and where the other node is on another computer. A call of `shutdown` from elsewhere does not end a daemon, nor
does a node that takes its name once, and the name of one that was killed is free at once."""
import os
import signal
import socket
import subprocess
import threading
import time
import xmlrpc.client
import xmlrpc.server

import rospy
from harness import (ROOT, SCANNER_CONFIG, SCANNER_SCENE, Starved, daemon, expect, folder, free_port, process, ros_master, run, sim,
                     use_master_at, wait_for, write)
from sensor_msgs.msg import LaserScan

class Vehicle:
    def __init__(self, tmp):
        self.tmp, self.count, port = tmp, 0, free_port(socket.SOCK_DGRAM)
        self.config = SCANNER_CONFIG.format(port=port)
        # The second one listens to another port, where nothing comes: whose scans they are is plain.
        self.other = SCANNER_CONFIG.format(port=free_port(socket.SOCK_DGRAM))
        self.scene = write(tmp / "scene.yaml", SCANNER_SCENE.format(port=port))

    def daemon(self, config):
        self.count += 1
        return daemon(write(self.tmp / f"vehicle{self.count}.yaml", config))


def pid_at(master):
    """The process that has the name now; None while there is none."""
    try:
        code, _, uri = master.lookupNode("/test", "/lidard")
        return xmlrpc.client.ServerProxy(uri).getPid("/test")[2] if code == 1 else None
    except OSError:
        return None


def second_leaves(vehicle, master, scans):
    with vehicle.daemon(vehicle.config) as a:
        wait_for(lambda: len(scans) > 20, 20, "scans of the first")
        with vehicle.daemon(vehicle.other) as b:
            begin = time.monotonic()
            wait_for(lambda: b.poll() is not None, 15, "the second ends")
            print(f"second started: it ended after {time.monotonic() - begin:.1f} s")
            expect(b.returncode == 1, f"the second ends with {b.returncode}")
        text = b.said()
        expect("/lidard" in text and "__name:=" in text, f"it names the name and the remedy:\n{text}")
        print(next(line for line in text.splitlines() if "__name:=" in line))
        before = len(scans)
        wait_for(lambda: len(scans) > before + 20, 5, "the first publishes on")
        expect(a.poll() is None and pid_at(master) == a.pid, "the first has the name")
        expect("shut down from outside" not in a.said(), "the first was left alone:\n" + a.said())
        replay = run("replay", "-c", write(vehicle.tmp / "replay.yaml", vehicle.config), "--pcap", ROOT / "pcaps/demo.pcap", "--wait", "0")
        expect(replay.returncode == 1 and "__name:=" in replay.stderr, f"a replay of the same name is refused:\n{replay.stderr}")
        foreign_call(master, a, scans)
        os.kill(a.pid, signal.SIGKILL)
        a.wait()
    killed = time.monotonic()
    with vehicle.daemon(vehicle.config) as c:
        before = len(scans)
        wait_for(lambda: len(scans) > before, 10, "scans of a third, after the first was killed")
        print(f"after a kill: scans again {time.monotonic() - killed:.1f} s later")
        expect(pid_at(master) == c.pid, "it has the name")


def foreign_call(master, child, scans):
    """P16: publishing again within 1 s; from the third call in 10 s on the daemon waits for up to a second first, and ten seconds
    later all is forgotten."""
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
    expect(child.poll() is None, "the daemon lives after four calls of shutdown")


# Another user of the computer: takes the address and each file that could be the lock, as far as permitted.
BLOCKER = """\
import fcntl, pathlib, socket, sys, time
taken = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
taken.bind("\\0lidard/lidard@" + sys.argv[2])
kept, below = [], pathlib.Path(sys.argv[1])
for path in [*below.rglob("*"), below / "lidard/node%2Flidard.lock"]:
    try:
        kept.append(path.open("a" if not path.exists() else "r"))
        fcntl.flock(kept[-1], fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        pass
print("blocks", len(kept), flush=True)
time.sleep(600)
"""


def local_user(vehicle):
    """A user without rights does not keep the daemon from its name."""
    if os.geteuid() != 0:
        return
    os.chmod(os.environ["XDG_RUNTIME_DIR"], 0o755)
    blocker = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", "/usr/bin/python3", "-c", BLOCKER,
               os.environ["XDG_RUNTIME_DIR"], os.environ["ROS_MASTER_URI"]]
    for _ in range(2):  # the second time the file is there already
        with process(blocker, stdout=subprocess.PIPE, text=True) as other, vehicle.daemon(vehicle.config) as child:
            expect(other.stdout.readline() == "blocks 0\n", "another user opened a file of the runtime folder")
            wait_for(lambda: "publishing as /lidard" in child.said(), 10, f"the daemon has its name:\n{child.said()}")
            expect(child.poll() is None and "another" not in child.said(), child.said())
    print("another user of the computer cannot take the name")


def both_wait(vehicle, master_port):
    """The first one stays also where there is no master yet, and keeps its port."""
    with vehicle.daemon(vehicle.config) as a:
        wait_for(lambda: "listening on port" in a.said(), 10, "the first has the port")
        with vehicle.daemon(vehicle.config) as b:
            begin = time.monotonic()
            wait_for(lambda: b.poll() is not None, 30, "the second ends")
            print(f"both waited for the master: the second ended after {time.monotonic() - begin:.1f} s")
            expect(b.returncode == 1 and "__name:=" in b.said(), f"it ends with 1:\n{b.said()}")
        with ros_master(master_port), xmlrpc.client.ServerProxy(f"http://127.0.0.1:{master_port}") as master:
            wait_for(lambda: pid_at(master) == a.pid, 10, "the first has the name")
            expect(a.poll() is None and "shut down from outside" not in a.said(), "and was left alone:\n" + a.said())


class Rival:
    """A node of the same name, as another computer may have it; takes the name back at each shutdown, `times` at most."""

    def __init__(self, times):
        self.left, self.gone = times, False
        self.server = xmlrpc.server.SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False)
        self.server.register_function(self.shutdown, "shutdown")
        self.server.register_function(lambda name: [1, "", 0], "getPid")
        self.uri = f"http://127.0.0.1:{self.server.server_address[1]}/"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def take(self):
        if self.gone:
            return
        with xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"]) as master:
            master.registerPublisher("/lidard", "/rival", "std_msgs/String", self.uri)
        self.left -= 1

    def shutdown(self, *_):
        if self.left > 0:
            threading.Timer(0.2, self.take).start()
        return [1, "", 0]

    def leave(self):
        self.gone = True
        time.sleep(0.5)
        with xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"]) as master:
            master.unregisterPublisher("/lidard", "/rival", self.uri)
        self.server.shutdown()
        self.server.server_close()


def rival(vehicle, master, times, stays):
    with vehicle.daemon(vehicle.config) as child:
        wait_for(lambda: "publishing as /lidard" in child.said(), 10, "the daemon has the name")
        time.sleep(0.5)
        begin, other = time.monotonic(), Rival(times)
        other.take()
        if stays:
            wait_for(lambda: other.left == 0 and pid_at(master) == child.pid, 20, f"the daemon has the name again:\n{child.said()}")
            time.sleep(2)
            expect(child.poll() is None, "the daemon stays")
        else:
            wait_for(lambda: child.poll() is not None, 20, f"the daemon ends:\n{child.said()}")
            expect(child.returncode == 1 and "__name:=" in child.said(), f"with 1:\n{child.said()}")
        print(f"a node that took the name {times - other.left} times: the daemon {'stayed' if stays else 'left'} "
              f"after {time.monotonic() - begin:.1f} s, {child.said().count('shut down from outside')} times shut down")
        other.leave()


def elsewhere(vehicle):
    """A node of another computer that has the name when the daemon starts: the daemon is refused until the node is gone."""
    other = Rival(1)
    other.take()
    with vehicle.daemon(vehicle.config) as child:
        wait_for(lambda: child.poll() is not None, 20, "the daemon ends")
        expect(child.returncode == 1, f"with {child.returncode}")
        expect("__name:=" in child.said() and other.uri in child.said(), f"it names the node and the remedy:\n{child.said()}")
        expect("publishing as" not in child.said(), "it never took the name")
    other.leave()
    with vehicle.daemon(vehicle.config) as child:
        wait_for(lambda: "publishing as /lidard" in child.said(), 10, "the name of a node that is gone is free")
    print("a node that answers elsewhere keeps the name")


def main():
    master_port = free_port()
    use_master_at(master_port)
    with folder() as tmp:
        vehicle, scans = Vehicle(tmp), []
        with sim(vehicle.scene):
            with ros_master(master_port), xmlrpc.client.ServerProxy(f"http://127.0.0.1:{master_port}") as master:
                rospy.init_node("listener", disable_signals=True, anonymous=True)
                rospy.Subscriber("/front/scan", LaserScan, scans.append, queue_size=100)
                second_leaves(vehicle, master, scans)
                rival(vehicle, master, 1, stays=True)
                rival(vehicle, master, 9, stays=False)
                elsewhere(vehicle)
                local_user(vehicle)
            both_wait(vehicle, master_port)
    print("ok")


if __name__ == "__main__":
    main()
