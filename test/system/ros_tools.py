# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""What the tests with ROS share: a master, listeners, diagnostics; scanners and poses that other nodes publish, and what
ira_laser_tools would make of them, computed anew."""
import contextlib
import math
import signal
import struct
import threading
import time
import xmlrpc.client

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from harness import Starved, expect, expect_end, folder, free_port, ros_master, use_master_at
from sensor_msgs.msg import LaserScan, PointCloud2, PointField
from tf2_msgs.msg import TFMessage


@contextlib.contextmanager
def ros_test():
    """A folder and a ROS master; this test is a node."""
    port = free_port()
    use_master_at(port)
    with folder() as tmp, ros_master(port) as master:
        rospy.init_node("listener", disable_signals=True, anonymous=True)
        yield tmp, master


class Diagnostics:
    """The newest status of each item by its name, without the name of the node."""

    def __init__(self, use=lambda name, status: None):
        """`use` is called with each status that comes."""
        self.items, self.use = {}, use
        self.subscriber = rospy.Subscriber("/diagnostics", DiagnosticArray, self._keep, queue_size=100)

    def _keep(self, array):
        for status in array.status:
            name = status.name.split(": ", 1)[-1]
            self.items[name] = status
            self.use(name, status)

    def level(self, name):
        return self.items[name].level if name in self.items else None

    def message(self, name):
        return self.items[name].message if name in self.items else ""

    def values(self, name):
        return {pair.key: pair.value for pair in self.items[name].values} if name in self.items else {}

    def close(self):
        self.subscriber.unregister()


def expect_quick_end(node):
    """Ctrl-C ends a node within a second."""
    starved = Starved()
    seconds = expect_end(node, signal.SIGINT)
    expect(seconds < 1 + starved.seconds(), f"Ctrl-C took {seconds:.2f} s")


def set_parameters(port, node, parameters):
    master = xmlrpc.client.ServerProxy(f"http://127.0.0.1:{port}")
    for name, value in parameters.items():
        code, message, _ = master.setParam("/test", f"{node}/{name}", value)
        expect(code == 1, message)


def quaternion(roll, pitch, yaw):
    cr, sr, cp, sp, cy, sy = (f(a / 2) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    return (sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy, cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy)


def transform(parent, child, xyz, rpy=(0, 0, 0)):
    t = TransformStamped()
    t.header.frame_id, t.child_frame_id, t.header.stamp = parent, child, rospy.Time.now()
    t.transform.translation.x, t.transform.translation.y, t.transform.translation.z = xyz
    r = t.transform.rotation
    r.x, r.y, r.z, r.w = quaternion(*rpy)
    return t


def static_transforms(transforms):
    publisher = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
    publisher.publish(TFMessage(transforms))
    return publisher


def wall_scan(frame, ranges, increment=0.01):
    """Beams from -pi/2 on."""
    scan = LaserScan()
    scan.header.frame_id = frame
    scan.angle_min, scan.angle_increment = -math.pi / 2, increment
    scan.angle_max = scan.angle_min + (len(ranges) - 1) * increment
    scan.scan_time, scan.range_min, scan.range_max = 0.05, 0.1, 30.0
    scan.ranges = ranges
    return scan


class Talker:
    """A node's scanner: publishes a message at a rate until it is closed."""

    def __init__(self, topic, message, rate=20.0, offset=0.0):
        self.publisher = rospy.Publisher(topic, type(message), queue_size=5)
        self.message, self.period, self.offset, self.running = message, 1 / rate, rospy.Duration(offset), True
        self.thread = threading.Thread(target=self._talk, daemon=True)
        self.thread.start()

    def _talk(self):
        while self.running:
            self.message.header.stamp = rospy.Time.now() + self.offset
            self.publisher.publish(self.message)
            time.sleep(self.period)

    def close(self):
        self.running = False
        self.thread.join()
        self.publisher.unregister()


class Listener:
    """Keeps what comes on a topic, with the time of its arrival."""

    def __init__(self, topic, kind=LaserScan, **options):
        self.messages, self.times = [], []
        self.subscriber = rospy.Subscriber(topic, kind, self._keep, **{"queue_size": 1000, **options})

    def _keep(self, message):
        self.times.append(time.monotonic())
        self.messages.append(message)

    def stamps(self):
        return [message.header.stamp.to_sec() for message in list(self.messages)]

    def since(self, moment):
        return [m for m, t in zip(list(self.messages), list(self.times)) if t > moment]

    def close(self):
        self.subscriber.unregister()


def cloud_of(points, frame):
    cloud = PointCloud2(height=1, width=len(points), point_step=12, row_step=12 * len(points), is_dense=True)
    cloud.header.frame_id = frame
    cloud.fields = [PointField(name, 4 * i, PointField.FLOAT32, 1) for i, name in enumerate("xyz")]
    cloud.data = b"".join(struct.pack("<fff", *point) for point in points)
    return cloud


def place(points, xyz, rpy=(0, 0, 0)):
    """Points of a frame in its parent."""
    x, y, z, w = quaternion(*rpy)
    rows = ((1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
            (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
            (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)))
    return [tuple(sum(row[i] * p[i] for i in range(3)) + t for row, t in zip(rows, xyz)) for p in points]


def scan_points(scan):
    return [(r * math.cos(a), r * math.sin(a), 0.0)
            for r, a in ((r, scan.angle_min + i * scan.angle_increment) for i, r in enumerate(scan.ranges))
            if math.isfinite(r) and scan.range_min <= r <= scan.range_max]


def nearest_per_beam(points, angle_min, angle_max, angle_increment, range_min, range_max):
    """The nearest point of each beam, rounded to the nearest beam; range_max + 1 where there is none."""
    beams = round((angle_max - angle_min) / angle_increment) + 1
    ranges = [range_max + 1] * beams
    for x, y, _ in points:
        r, beam = math.hypot(x, y), round((math.atan2(y, x) - angle_min) / angle_increment)
        if range_min <= r <= range_max and 0 <= beam < beams:
            ranges[beam] = min(ranges[beam], r)
    return ranges


def wrong_beams(scan, expected):
    """Beams that do not agree to the millimetre. A point at the very edge between two beams may lie in either: up to four do."""
    wrong = [i for i, (a, b) in enumerate(zip(scan.ranges, expected)) if not abs(a - b) < 1e-3]
    edges = [i for i in wrong
             if any(0 <= j < len(expected) and abs(scan.ranges[i] - expected[j]) < 1e-3 for j in (i - 1, i + 1))]
    return [] if len(wrong) == len(edges) and len(wrong) <= 4 else wrong


def expect_same(scan, expected, what):
    expect(len(scan.ranges) == len(expected), f"{what}: {len(scan.ranges)} beams, expected {len(expected)}")
    wrong = wrong_beams(scan, expected)
    expect(not wrong, f"{what}: beams {wrong[:10]} differ, e.g. {[(scan.ranges[i], expected[i]) for i in wrong[:3]]}")


def check_consistent(scan):
    n = len(scan.ranges)
    expect(abs(scan.angle_max - scan.angle_min - (n - 1) * scan.angle_increment) < 1e-4, f"{n} beams do not fit the angles")
    expect(scan.intensities in ([], ()) or len(scan.intensities) == n, "intensities")
