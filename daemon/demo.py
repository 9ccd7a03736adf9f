#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Plays a capture through a configuration into a private ROS master and prints what each topic carries."""
import collections
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import xmlrpc.client


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def start_master(port, log):
    master = subprocess.Popen(["/usr/bin/python3", "/usr/bin/rosmaster", "--core", "-p", str(port)],
                              stdout=log, stderr=log, start_new_session=True)
    client = xmlrpc.client.ServerProxy(f"http://127.0.0.1:{port}")
    for _ in range(200):
        try:
            client.getPid("/demo")
            return master
        except OSError:
            time.sleep(0.05)
    raise SystemExit("the ROS master did not start")


# Topics of a GPS receiver that the demo's roof lidar does not have.
MAY_BE_SILENT = ("sensor_msgs/NavSatFix", "sensor_msgs/TimeReference")


class Listener:
    """Counts the messages of every topic, whatever their type."""

    def __init__(self):
        import rospy
        self.rospy = rospy
        self.lock = threading.Lock()
        self.counts = collections.Counter()
        self.stamps = collections.defaultdict(list)
        self.types = {}
        rospy.init_node("lidard_demo", disable_signals=True, anonymous=True)

    def subscribe(self, topic, kind):
        self.types[topic] = kind
        self.rospy.Subscriber(topic, self.rospy.AnyMsg, lambda message: self.count(topic), queue_size=1000)

    def count(self, topic):
        with self.lock:
            self.counts[topic] += 1
            self.stamps[topic].append(time.monotonic())

    def table(self):
        with self.lock:
            for topic in sorted(self.types):
                times = self.stamps[topic]
                span = times[-1] - times[0] if len(times) > 1 else 0
                rate = f"{(len(times) - 1) / span:6.1f} Hz" if span > 0 else "   once" if times else "  none in this capture"
                yield f"  {topic:<24} {self.types[topic]:<32} {len(times):5d} messages  {rate}", bool(times) or self.types[topic] in MAY_BE_SILENT


def main():
    lidard, config, capture, log_file = sys.argv[1:5]
    port = free_port()
    os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1")
    os.environ.pop("ROS_HOSTNAME", None)
    children = []

    def stop_children():
        for child in reversed(children):
            if child.poll() is None:
                child.send_signal(signal.SIGTERM)
        for child in children:
            try:
                child.wait(5)
            except subprocess.TimeoutExpired:
                child.kill()
                child.wait()

    def interrupted(number, frame):
        raise KeyboardInterrupt

    signal.signal(signal.SIGTERM, interrupted)
    with tempfile.TemporaryDirectory() as folder:
        os.environ["ROS_LOG_DIR"] = folder
        try:
            with open(os.path.join(folder, "master.log"), "wb") as log:
                children.append(start_master(port, log))
            listener = Listener()
            # The topics are advertised before the first frame; --wait gives the listener time to connect to them.
            with open(log_file, "ab") as log:
                player = subprocess.Popen([lidard, "replay", "-c", config, "--pcap", capture, "--wait", "2"], stdout=log, stderr=log)
            children.append(player)
            known = set()
            master = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])
            while player.poll() is None:
                for topic, kind in master.getPublishedTopics("/demo", "")[2]:
                    if topic not in known and not topic.startswith("/rosout"):
                        known.add(topic)
                        listener.subscribe(topic, kind)
                time.sleep(0.1)
            time.sleep(0.3)
            rows = list(listener.table())
            print("what lidard published (simulated):")
            for text, _ in rows:
                print(text)
            picture = os.path.join(os.path.dirname(lidard), "demo.png")
            drawn = subprocess.run([lidard, "snapshot", "-c", config, "--pcap", capture, "-o", picture], check=False)
            if drawn.returncode == 0:
                print(f"a picture of what the vehicle sees: {picture}")
            silent = [text for text, heard in rows if not heard]
            code = player.returncode or drawn.returncode or (1 if silent or not rows else 0)
            print(f"demo failed; see {log_file}" if code else "demo done")
            listener.rospy.signal_shutdown("done")
        finally:
            stop_children()
    sys.exit(code)


if __name__ == "__main__":
    main()
