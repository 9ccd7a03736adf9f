#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The running daemon takes the vehicle's motion from an odometry topic, or from turn rates and a speed, and says so;
when it stops coming, the scans go on and say that too."""
import subprocess
import threading

from harness import LIDARD, LIDARD_SIM, expect, folder, free_port, process, ros_master, use_master_at, wait_for

SCENE = """
start: 2026-01-01T00:00:00Z
duration: 60
seed: 1
sensors:
  left: {{model: sick_microscan3, from: '192.168.0.21:6060', to: '127.0.0.1:{port}'}}
objects:
  - wall: {{from: [4, -3], to: [4, 3], z: [-1, 1]}}
"""
CONFIG = """\
vehicle: {{{motion}}}
sensors:
  left: {{model: sick_microscan3, ip_address: 127.168.0.21, ip_port: {port}, pose: {{xyz: [0, 0, 0]}}}}
merged_scans:
  around: {{laserscan_topics: left, profile: strict}}
"""


def told(motion, publish, tmp, port):
    """What /diagnostics says of the merge while `publish` is called 50 times a second, and after it has stopped."""
    import rospy
    from diagnostic_msgs.msg import DiagnosticArray

    items, stop = {}, threading.Event()
    subscriber = rospy.Subscriber("/diagnostics", DiagnosticArray, lambda array: items.update(
        (status.name.split(": ")[-1], status) for status in array.status), queue_size=100)
    config = tmp / "live.yaml"
    config.write_text(CONFIG.format(motion=motion, port=port))

    def drive():
        while not stop.wait(0.02):
            publish(rospy.Time.now())

    def value():
        item = items.get("merged around")
        return dict((pair.key, pair.value) for pair in item.values).get("Motion", "") if item else ""

    thread = threading.Thread(target=drive)
    thread.start()
    try:
        with process([LIDARD, "run", "-c", config], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL):
            wait_for(lambda: value().startswith("deskewed"), 20, f"{motion}: deskewed scans; it says {value()!r}")
            wait_for(lambda: items["motion"].message == "poses come in", 5, f"{motion}: {items['motion'].message}")
            wait_for(lambda: items["merged around"].level in (0, b"\x00"), 5, "the merge is well")
            stop.set()
            wait_for(lambda: value().startswith("not deskewed"), 5, f"{motion}: poses stopped; it says {value()!r}")
            wait_for(lambda: "stood still" in items["merged around"].message, 5, "a warning")
    finally:
        stop.set()
        thread.join()
        subscriber.unregister()


def main():
    import rospy
    from geometry_msgs.msg import TwistStamped
    from nav_msgs.msg import Odometry
    from sensor_msgs.msg import Imu

    master, port = free_port(), free_port()
    use_master_at(master)
    with folder() as tmp, ros_master(master):
        rospy.init_node("vehicle", disable_signals=True, anonymous=True)
        (tmp / "scene.yaml").write_text(SCENE.format(port=port))
        odometry = rospy.Publisher("/odom", Odometry, queue_size=10)
        imu = rospy.Publisher("/imu", Imu, queue_size=10)
        speed = rospy.Publisher("/speed", TwistStamped, queue_size=10)

        def publish_pose(now):
            message = Odometry()
            message.header.stamp, message.header.frame_id, message.child_frame_id = now, "odom", "base_link"
            message.pose.pose.position.x = now.to_sec() % 100
            message.pose.pose.orientation.w = 1
            odometry.publish(message)

        def publish_rates(now):
            rates = Imu()
            rates.header.stamp, rates.header.frame_id = now, "base_link"
            rates.angular_velocity.z = 0.3
            imu.publish(rates)
            ahead = TwistStamped()
            ahead.header.stamp = now
            ahead.twist.linear.x = 1.5
            speed.publish(ahead)

        with process([LIDARD_SIM, "live", tmp / "scene.yaml"], stdout=subprocess.DEVNULL):
            told("odometry_topic: /odom", publish_pose, tmp, port)
            told("imu_topic: /imu, speed_topic: /speed", publish_rates, tmp, port)
    print("ok")


main()
