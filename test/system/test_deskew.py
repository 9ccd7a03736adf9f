#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""A vehicle that swings through a room: simulated packets, tf of 50 Hz in a bag, replay to a bag. The merged scan must
show the room as it is from the vehicle at its stamp; without motion it is far off, and says so."""
import math

import rosbag
import rospy
from geometry_msgs.msg import TransformStamped
from harness import LIDARD, expect, logged, make_capture, run, wait_for, write
from nav_msgs.msg import Odometry
from ros_tools import Listener, ros_test
from rosgraph_msgs.msg import Clock
from tf2_msgs.msg import TFMessage

START = 1767226643.456  # 2026-01-01T00:17:23.456Z
DURATION = 6.0
LEG = 0.02  # s of constant speed and yaw rate
HALF = (9.0, 7.0)  # m, the room

SCENE = """
start: 2026-01-01T00:17:23.456Z
duration: {duration}
seed: 3
vehicle:
  start: {{xy: [-1.0, -2.0], yaw_deg: 15}}
  path:
{legs}
sensors:
  front_left: {{model: sick_microscan3, pose: {{xyz: [0, 1, 0.35], rpy_deg: [0, 0, 45]}}, from: "192.168.0.21:6060", to: "192.168.0.100:6060", phase_ms: 0}}
  front_right: {{model: sick_microscan3, pose: {{xyz: [0, -1, 0.35], rpy_deg: [0, 0, -45]}}, from: "192.168.0.22:6060", to: "192.168.0.100:6060", phase_ms: 15}}
objects:
  - wall: {{from: [-9, -7], to: [9, -7], z: [0, 3]}}
  - wall: {{from: [9, -7], to: [9, 7], z: [0, 3]}}
  - wall: {{from: [9, 7], to: [-9, 7], z: [0, 3]}}
  - wall: {{from: [-9, 7], to: [-9, -7], z: [0, 3]}}
"""

CONFIG = """
vehicle:
  footprint: [[-4.0, -0.9], [-0.1, -0.9], [-0.1, 0.9], [-4.0, 0.9]]
{motion}
sensors:
  front_left: {{model: sick_microscan3, ip_address: 192.168.0.21, ip_port: 6060, pose: {{xyz: [0, 1, 0.35], rpy_deg: [0, 0, 45]}}}}
  front_right: {{model: sick_microscan3, ip_address: 192.168.0.22, ip_port: 6060, pose: {{xyz: [0, -1, 0.35], rpy_deg: [0, 0, -45]}}}}
merged_scans:
  scan: {{laserscan_topics: [front_left, front_right], profile: strict, range_noise: 0.005, range_max: 25}}
"""


def speed(t):
    return 1.5 + 0.7 * math.sin(2.1 * t)


def yaw_rate(t):
    return 1.2 * math.sin(1.9 * t + 0.4)


class Way:
    """Arcs of LEG s; the same that the scene drives."""

    def __init__(self):
        self.places = [(-1.0, -2.0, math.radians(15))]
        self.legs = []
        for i in range(int(DURATION / LEG) + 1):
            t = (i + 0.5) * LEG
            self.legs.append((speed(t) * 0.6, yaw_rate(t)))
            self.places.append(self.drive(self.places[-1], self.legs[-1], LEG))

    @staticmethod
    def drive(place, leg, t):
        x, y, yaw = place
        v, w = leg
        turned = w * t
        chord = v * t * (math.sin(turned / 2) / (turned / 2) if abs(turned) > 1e-9 else 1)
        return x + chord * math.cos(yaw + turned / 2), y + chord * math.sin(yaw + turned / 2), yaw + turned

    def at(self, t):
        i = min(max(int(t / LEG), 0), len(self.legs) - 1)
        return self.drive(self.places[i], self.legs[i], t - i * LEG)


def true_range(place, angle):
    x, y, yaw = place
    c, s = math.cos(yaw + angle), math.sin(yaw + angle)
    best = math.inf
    for at, d, half in ((x, c, HALF[0]), (y, s, HALF[1])):
        if abs(d) > 1e-12:
            best = min(best, ((half if d > 0 else -half) - at) / d)
    return best


def transforms(way, until):
    for i in range(int(until * 50) + 1):
        x, y, yaw = way.at(i / 50)
        pose = TransformStamped()
        pose.header.stamp = rospy.Time.from_sec(START) + rospy.Duration.from_sec(i / 50)
        pose.header.frame_id, pose.child_frame_id = "odom", "base_link"
        pose.transform.translation.x, pose.transform.translation.y = x, y
        pose.transform.rotation.z, pose.transform.rotation.w = math.sin(yaw / 2), math.cos(yaw / 2)
        yield TFMessage([pose])


def odometry(stamp, way):
    x, y, yaw = way.at((stamp - rospy.Time.from_sec(START)).to_sec())
    pose = Odometry()
    pose.header.stamp, pose.header.frame_id, pose.child_frame_id = stamp, "odom", "base_link"
    pose.pose.pose.position.x, pose.pose.pose.position.y = x, y
    pose.pose.pose.orientation.z, pose.pose.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    return pose


def write_motion(path, way, until, with_tf):
    with rosbag.Bag(str(path), "w") as bag:
        for message in transforms(way, until):
            stamp = message.transforms[0].header.stamp
            if with_tf:
                bag.write("/tf", message, stamp)
            else:
                bag.write("/odom", odometry(stamp, way), stamp)


def errors(tmp, way, motion, motion_bag):
    config, out = write(tmp / "config.yaml", CONFIG.format(motion=motion)), tmp / "out.bag"
    extra = ["--motion", motion_bag] if motion_bag else []
    out.unlink(missing_ok=True)
    result = run("replay", "-c", config, "--pcap", tmp / "drive.pcap", "--rate", "max", "--bag", out, *extra)
    expect(result.returncode == 0, result.stderr)
    scans, health = [], set()
    with rosbag.Bag(str(out)) as bag:
        for topic, message, _ in bag.read_messages():
            if message._type == "sensor_msgs/LaserScan" and topic.strip("/") == "scan":
                scans.append(message)
            if message._type == "diagnostic_msgs/DiagnosticArray":
                for status in message.status:
                    if status.name.endswith("merged scan") and message.header.stamp.to_sec() - START > 1:
                        health.add(status.message)
    return (*judge(way, scans), health)


def judge(way, scans):
    """Root mean square and 99th percentile of the ranges' errors up to 10 m, and the share of silent beams."""
    off, silent, beams = [], 0, 0
    for message in scans:
        t = message.header.stamp.to_sec() - START
        if not 0.5 < t < DURATION - 0.3:
            continue
        expect(message.time_increment == 0, "beams of one instant have a time between them")
        place = way.at(t)
        for i, r in enumerate(message.ranges):
            true = true_range(place, message.angle_min + i * message.angle_increment)
            beams += 1
            silent += math.isnan(r)
            if math.isfinite(r) and true <= 10:
                off.append(abs(r - true))
    expect(len(off) > 100000, f"only {len(off)} beams to judge")
    off.sort()
    rms = math.sqrt(sum(e * e for e in off) / len(off))
    return rms, off[int(0.99 * len(off))], silent / beams


def live(tmp, way):
    """The same with tf of a ROS master, then with odometry that follows the clock; a subscriber receives the scans."""
    scans = Listener("/scan").messages
    tf = rospy.Publisher("/tf", TFMessage, queue_size=1000)
    odom = rospy.Publisher("/odom", Odometry, queue_size=1000)
    waiting = [odometry(message.transforms[0].header.stamp, way) for message in transforms(way, DURATION)]

    def drive(clock):
        # A little ahead, so that no scan waits for it.
        while waiting and waiting[0].header.stamp <= clock.clock + rospy.Duration.from_sec(0.2):
            odom.publish(waiting.pop(0))

    rospy.Subscriber("/clock", Clock, drive, queue_size=1000)
    for name, publisher, messages, extra in (("odometry_frame: odom", tf, transforms(way, DURATION), []),
                                             ("odometry_topic: /odom", odom, [], ["--clock"])):
        scans.clear()
        config = write(tmp / "live.yaml", CONFIG.format(motion="  " + name))
        command = [LIDARD, "replay", "-c", config, "--pcap", tmp / "drive.pcap", "--wait", "4", *extra]
        with logged(command, tmp / "log") as child:
            wait_for(lambda publisher=publisher: publisher.get_num_connections() > 0, 20, f"a subscriber for {name}")
            for count, message in enumerate(messages):
                publisher.publish(message)
                if count % 20 == 19:
                    rospy.sleep(0.05)  # tf2's listener keeps 100 messages that wait
            child.wait(timeout=60)
        wait_for(lambda: len(scans) > 150, 5, "merged scans")
        rms, p99, silent = judge(way, scans)
        print(f"live, {name}: rms {rms * 1000:.2f} mm, p99 {p99 * 1000:.2f} mm, {silent:.1%} NaN")
        expect(rms <= 0.001 and p99 <= 0.003, f"live, {name}: rms {rms * 1000:.2f} mm, p99 {p99 * 1000:.2f} mm")


def picture(tmp, motion, motion_bag):
    """The snapshot at 3 s; its text without the names."""
    config, out = write(tmp / "config.yaml", CONFIG.format(motion=motion)), tmp / "out.svg"
    extra = ["--motion", motion_bag] if motion_bag else []
    result = run("snapshot", "-c", config, "--pcap", tmp / "drive.pcap", "--at", 3, "-o", out, *extra)
    expect(result.returncode == 0, result.stderr)
    return out.read_text()


def check_pictures(tmp):
    plain = picture(tmp, "", None)
    by_tf = picture(tmp, "  odometry_frame: odom", tmp / "tf.bag")
    expect(plain == picture(tmp, "", None), "the same picture twice")
    expect(plain != by_tf, "a snapshot with --motion shows what one without it shows")
    expect(plain != picture(tmp, "  odometry_topic: /odom", tmp / "odom.bag"), "the same with odometry from a topic")
    missing = run("snapshot", "-c", tmp / "config.yaml", "--pcap", tmp / "drive.pcap", "-o", tmp / "x.svg", "--motion", tmp / "no.bag")
    expect(missing.returncode == 1 and "no.bag" in missing.stderr, f"a bag that is not there: {missing.stderr}")


def main():
    way = Way()
    with ros_test() as (tmp, _):
        legs = "\n".join(
            f"    - {{duration: {LEG}, speed: {v!r}, yaw_rate_deg: {math.degrees(w)!r}}}" for v, w in way.legs)
        make_capture(tmp / "drive", SCENE.format(duration=DURATION, legs=legs))
        write_motion(tmp / "tf.bag", way, DURATION, True)
        write_motion(tmp / "odom.bag", way, DURATION, False)
        table = "".join(f"{START + i / 50:.6f},{x!r},{y!r},{yaw!r}\n" for i in range(int(DURATION * 50) + 1) for x, y, yaw in [way.at(i / 50)])
        write(tmp / "table.csv", "stamp,x,y,yaw\n" + table)
        for name, motion, file in (("tf", "  odometry_frame: odom", "tf.bag"), ("odom", "  odometry_topic: /odom", "odom.bag"),
                                   ("table as tf", "  odometry_frame: odom", "table.csv"), ("table", "  odometry_topic: /odom", "table.csv")):
            rms, p99, silent, health = errors(tmp, way, motion, tmp / file)
            print(f"{name}: rms {rms * 1000:.2f} mm, p99 {p99 * 1000:.2f} mm, {silent:.1%} NaN, {health}")
            expect(rms <= 0.001 and p99 <= 0.003, f"{name}: rms {rms * 1000:.2f} mm, p99 {p99 * 1000:.2f} mm")
            expect(health == {"publishing"}, f"{name}: {health}")
        check_pictures(tmp)
        rms, p99, silent, health = errors(tmp, way, "", None)
        print(f"without: rms {rms * 1000:.2f} mm, p99 {p99 * 1000:.2f} mm, {silent:.1%} NaN")
        expect(rms > 0.01, "without motion the scan is as good: nothing was tested")
        write_motion(tmp / "short.bag", way, 2.0, True)
        *_, health = errors(tmp, way, "  odometry_frame: odom", tmp / "short.bag")
        expect(any("as if the vehicle stood still" in one for one in health), f"poses that stop: {health}")
        live(tmp, way)


main()
