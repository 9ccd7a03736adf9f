#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""A capture sent over loopback at its own pace gives a real subscriber the messages of the offline replay, none lost."""
import collections
import re
import socket
import subprocess
import sys
import threading
import time

import rosbag
import roslib.message
import rospy
from harness import (LIDARD, LIDARD_SIM, ROOT, SKIP, Starved, expect, folder, free_port, live_config, process, ros_master, run,
                     use_master_at, wait_for)

# Runs on a busy machine before the test gives up.
ATTEMPTS = 6


def content(message):
    """A message without its stamps (the live host's clock) and sequence number."""
    fields = [message._type, message.header.frame_id]
    if message._type == "sensor_msgs/LaserScan":
        fields += [message.angle_min, message.angle_max, message.angle_increment, message.time_increment,
                   [repr(r) for r in message.ranges], list(message.intensities)]
    else:
        fields += [message.width, message.point_step, bytes(message.data)]
    return fields


def difference(live, replayed):
    """What makes the live messages others than the replayed ones; None where they are the same in the same order."""
    if len(live) != len(replayed):
        return f"{len(live)} live, {len(replayed)} replayed"
    return next((f"message {n} differs" for n, (one, other) in enumerate(zip(live, replayed)) if one != other), None)


def compare(name, config_text, capture, ports, tmp):
    config = tmp / f"{name}.yaml"
    config.write_text(config_text)
    bag = tmp / f"{name}.bag"
    result = run("replay", "-c", config, "--pcap", capture, "--rate", "max", "--bag", bag)
    expect(result.returncode == 0, result.stderr)
    expected = collections.defaultdict(list)
    types = {}
    with rosbag.Bag(str(bag)) as messages:
        for topic, message, _ in messages.read_messages():
            if message._type in ("sensor_msgs/LaserScan", "sensor_msgs/PointCloud2"):
                expected[topic].append(content(message))
                types[topic] = roslib.message.get_message_class(message._type)

    live = tmp / f"{name}_live.yaml"
    live.write_text(live_config(config_text, ports))
    for _ in range(ATTEMPTS):
        received, starved = run_live(name, live, capture, ports, types, expected, tmp)
        differences = [f"{name} {topic}: {text}" for topic, messages in expected.items()
                       if (text := difference(received[topic], messages))]
        if not differences:
            print(f"{name}: " + ", ".join(f"{t} {len(m)}" for t, m in sorted(expected.items())))
            return
        print(f"starved {starved:.3f} s: {differences}", flush=True)
        # A daemon that waits for a processor publishes without a scan that comes late, and drops a frame that is not sent
        # before the next ones come.
        expect(starved > 0.1, "; log:\n".join([*differences, (tmp / f"{name}.log").read_text()]))
    print(f"{name}: processes of the test waited for a processor in each of {ATTEMPTS} runs")
    sys.exit(SKIP)


def run_live(name, live, capture, ports, types, expected, tmp):
    """What subscribers received of the capture sent to a daemon, by topic, and for how long processes of the test were starved."""
    received = collections.defaultdict(list)
    lock = threading.Lock()

    def take(message, topic):
        with lock:
            received[topic].append(content(message))

    subscribers = [rospy.Subscriber(topic, kind, take, callback_args=topic, queue_size=1000) for topic, kind in types.items()]
    log = (tmp / f"{name}.log").open("w")
    with process([LIDARD, "run", "-c", live], stdout=log, stderr=subprocess.STDOUT):
        wait_for(lambda: all(s.get_num_connections() > 0 for s in subscribers), 20, f"{name}: subscribers are connected")
        starved = Starved()
        port_options = [f"--port-map={old}={new}" for old, new in ports.items()]
        sender = subprocess.run([LIDARD_SIM, "send", str(capture), "--to", "127.0.0.1", *port_options], capture_output=True,
                                text=True, timeout=120)
        expect(sender.returncode == 0, sender.stderr)

        def complete():
            with lock:
                return all(len(received[t]) >= len(expected[t]) for t in expected)

        end = time.monotonic() + 10
        while not complete() and time.monotonic() < end:
            time.sleep(0.02)
        starved = starved.seconds()
    for s in subscribers:
        s.unregister()
    return received, starved


def main():
    port = free_port()
    use_master_at(port)
    with folder() as tmp, ros_master(port):
        rospy.init_node("listener", disable_signals=True, anonymous=True)
        udp = {p: free_port(socket.SOCK_DGRAM) for p in (2368, 6060)}
        compare("demo", (ROOT / "config/demo.yaml").read_text(), ROOT / "pcaps/demo.pcap", udp, tmp)
        # 1507 packets per second, for five seconds.
        scene = (ROOT / "pcaps/vlp16_dual.scene.yaml").read_text()
        long_scene = tmp / "dual.scene.yaml"
        long_scene.write_text(re.sub(r"^duration: .*$", "duration: 5.0", scene, flags=re.M))
        subprocess.run([LIDARD_SIM, "make", long_scene, "-o", tmp / "dual_5s"], check=True, capture_output=True)
        dual = "sensors:\n  roof: {model: velodyne_vlp16, ip_address: 192.168.1.201, ip_port: 2368, pose: {xyz: [0, 0, 2]}}\n"
        compare("dual", dual, tmp / "dual_5s.pcap", udp, tmp)
    print("ok")


if __name__ == "__main__":
    main()
