#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""A capture sent over loopback at its own pace gives a real subscriber the messages of the offline replay, none lost."""
import collections
import re
import socket
import sys
import time

import rosbag
import roslib.message
from harness import ROOT, SKIP, Starved, daemon, expect, free_port, live_config, make_capture, run, send, wait_for, write
from ros_tools import Listener, ros_test

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
    config = write(tmp / f"{name}.yaml", config_text)
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

    live = write(tmp / f"{name}_live.yaml", live_config(config_text, ports))
    for _ in range(ATTEMPTS):
        received, starved, log = run_live(name, live, capture, ports, types, expected)
        differences = [f"{name} {topic}: {text}" for topic, messages in expected.items()
                       if (text := difference(received[topic], messages))]
        if not differences:
            print(f"{name}: " + ", ".join(f"{t} {len(m)}" for t, m in sorted(expected.items())))
            return
        print(f"starved {starved:.3f} s: {differences}", flush=True)
        # A daemon that waits for a processor publishes without a scan that comes late, and drops a frame that is not sent
        # before the next ones come.
        expect(starved > 0.1, "; log:\n".join([*differences, log]))
    print(f"{name}: processes of the test waited for a processor in each of {ATTEMPTS} runs")
    sys.exit(SKIP)


def run_live(name, live, capture, ports, types, expected):
    """What subscribers received of the capture sent to a daemon, by topic, how long processes of the test were starved, and the log."""
    listeners = {topic: Listener(topic, kind) for topic, kind in types.items()}
    with daemon(live) as child:
        wait_for(lambda: all(one.subscriber.get_num_connections() > 0 for one in listeners.values()), 20, f"{name}: subscribers are connected")
        starved = Starved()
        send(capture, *(f"--port-map={old}={new}" for old, new in ports.items()))
        end = time.monotonic() + 10
        while any(len(listeners[t].messages) < len(expected[t]) for t in expected) and time.monotonic() < end:
            time.sleep(0.02)
        starved = starved.seconds()
    for one in listeners.values():
        one.close()
    return {topic: [content(message) for message in one.messages] for topic, one in listeners.items()}, starved, child.said()


def main():
    with ros_test() as (tmp, _):
        udp = {p: free_port(socket.SOCK_DGRAM) for p in (2368, 6060)}
        compare("demo", (ROOT / "config/demo.yaml").read_text(), ROOT / "pcaps/demo.pcap", udp, tmp)
        # 1507 packets per second, for five seconds.
        scene = (ROOT / "pcaps/vlp16_dual.scene.yaml").read_text()
        capture = make_capture(tmp / "dual_5s", re.sub(r"^duration: .*$", "duration: 5.0", scene, flags=re.M))
        dual = "sensors:\n  roof: {model: velodyne_vlp16, ip_address: 192.168.1.201, ip_port: 2368, pose: {xyz: [0, 0, 2]}}\n"
        compare("dual", dual, capture, udp, tmp)
    print("ok")


if __name__ == "__main__":
    main()
