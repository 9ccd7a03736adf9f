#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Clouds that nobody subscribes to are not made, but counted; the first subscriber gets the next revolution, and it is whole."""
import socket
import struct
import time

from harness import Starved, ask, daemon, expect, figure, free_port, kernel_port_is_open, scene_of, sim, wait_for, write
from ros_tools import Listener, ros_test
from sensor_msgs.msg import PointCloud2

SCENE = {"roof": "model: velodyne_vlp16, from: '192.168.1.201:{port}', to: '127.0.0.1:{port}'"}
ROOM = "box: {center: [1.3, -0.7, 0.4], size: [17, 12, 6.5], reflectivity: 0.5}"
CONFIG = "sensors:\n  roof: {{model: velodyne_vlp16, ip_address: 127.168.1.201, ip_port: {port}}}\n"


def topic():
    return next((one for one in (ask("status") or {"topics": []})["topics"] if one["topic"] == "roof/points"), {"frames": 0, "rate_hz": 0})


def duration(cloud):
    """Seconds from the stamp of a cloud to its last point."""
    return struct.unpack_from("<f", cloud.data, len(cloud.data) - 4)[0]


def subscribe():
    """A subscriber's first cloud, and how long it waited for that since it was connected."""
    listener, starved = Listener("roof/points", PointCloud2), Starved()
    wait_for(lambda: listener.subscriber.get_num_connections() > 0, 20, "the subscriber is connected")
    connected = time.time()
    wait_for(lambda: len(listener.messages) >= 5, 20, "clouds come")
    first, waited = listener.messages[0], starved.seconds()
    listener.close()
    # The revolution at hand when the subscriber came, at most 0.1 s, is not made any more.
    begins = first.header.stamp.to_sec() - connected
    expect(-0.15 - waited < begins < 0.2 + waited, f"the first cloud begins {begins:.3f} s after the connection, starved {waited:.3f} s")
    sizes = [cloud.width for cloud in listener.messages]
    expect(min(sizes) > 0.98 * max(sizes), f"points of the clouds: {sizes}")
    expect(abs(duration(first) - 0.1) < 0.002, f"the first cloud lasts {duration(first):.4f} s")


def main():
    port = free_port(socket.SOCK_DGRAM)
    with ros_test() as (tmp, _):
        scene = write(tmp / "scene.yaml", scene_of({name: keys.format(port=port) for name, keys in SCENE.items()}, ROOM))
        with daemon(write(tmp / "live.yaml", CONFIG.format(port=port))):
            wait_for(lambda: kernel_port_is_open(port), 20, "the daemon listens")
            with sim(scene):
                wait_for(lambda: topic()["frames"] > 20, 20, "revolutions are counted")
                for _ in range(2):
                    expect(abs(topic()["rate_hz"] - 10) < 1, f"nobody subscribes: {topic()}")
                    expect(float(figure("sensor roof", "Beams with a return (%)")) > 95, "the beams are judged")
                    subscribe()
                    frames = topic()["frames"]
                    wait_for(lambda: topic()["frames"] > frames + 15, 20, "revolutions are counted again")
    print("ok")


if __name__ == "__main__":
    main()
