#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The running daemon gets the vehicle's motion from an odometry topic, or from turn rates and a speed, and says so;
when it stops coming, the scans go on and say that too."""
import threading

import rospy
from geometry_msgs.msg import TwistStamped
from harness import daemon, free_port, scene_of, sim, wait_for, write
from nav_msgs.msg import Odometry
from ros_tools import Diagnostics, ros_test
from sensor_msgs.msg import Imu

CONFIG = """\
vehicle: {{{motion}}}
sensors:
  left: {{model: sick_microscan3, ip_address: 127.168.0.21, ip_port: {port}, pose: {{xyz: [0, 0, 0]}}}}
merged_scans:
  around: {{laserscan_topics: left, profile: strict}}
"""


def check(motion, publish, tmp, port):
    """What /diagnostics says of the merge while `publish` is called 50 times a second, and after it has stopped."""
    diagnostics, stop = Diagnostics(), threading.Event()

    def drive():
        while not stop.wait(0.02):
            publish(rospy.Time.now())

    value = lambda: diagnostics.values("merged around").get("Motion", "")
    thread = threading.Thread(target=drive)
    thread.start()
    try:
        with daemon(write(tmp / "live.yaml", CONFIG.format(motion=motion, port=port))):
            wait_for(lambda: value().startswith("deskewed"), 20, f"{motion}: deskewed scans; it says {value()!r}")
            wait_for(lambda: diagnostics.message("motion") == "poses come in", 5, f"{motion}: {diagnostics.message('motion')}")
            wait_for(lambda: diagnostics.level("merged around") == 0, 5, "the merge is well")
            stop.set()
            wait_for(lambda: value().startswith("not deskewed"), 5, f"{motion}: poses stopped; it says {value()!r}")
            wait_for(lambda: "stood still" in diagnostics.message("merged around"), 5, "a warning")
    finally:
        stop.set()
        thread.join()
        diagnostics.close()


def main():
    port = free_port()
    with ros_test() as (tmp, _):
        odometry = rospy.Publisher("/odom", Odometry, queue_size=10)
        imu = rospy.Publisher("/imu", Imu, queue_size=10)
        speed = rospy.Publisher("/speed", TwistStamped, queue_size=10)

        def publish_pose(now):
            message = Odometry(child_frame_id="base_link")
            message.header.stamp, message.header.frame_id = now, "odom"
            message.pose.pose.position.x = now.to_sec() % 100
            message.pose.pose.orientation.w = 1
            odometry.publish(message)

        def publish_rates(now):
            rates, ahead = Imu(), TwistStamped()
            rates.header.stamp, rates.header.frame_id, rates.angular_velocity.z = now, "base_link", 0.3
            imu.publish(rates)
            ahead.header.stamp, ahead.twist.linear.x = now, 1.5
            speed.publish(ahead)

        scene = scene_of({"left": f"model: sick_microscan3, from: '192.168.0.21:6060', to: '127.0.0.1:{port}'"})
        with sim(write(tmp / "scene.yaml", scene)):
            check("odometry_topic: /odom", publish_pose, tmp, port)
            check("imu_topic: /imu, speed_topic: /speed", publish_rates, tmp, port)
    print("ok")


if __name__ == "__main__":
    main()
