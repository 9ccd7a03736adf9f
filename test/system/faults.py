# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The rows of the fault table, which test_fault_table.py does one after the other."""
import collections

# What is done, the item, its level, what the first sentence contains, and after how many seconds it is there at the latest.
# The figure of silence is that of the promise; /diagnostics come at once when a level changes, status and events ten times a second.
Fault = collections.namedtuple("Fault", "key what item level text seconds")
CABLE = [
    Fault("taken", "another program has the port", "port 2413", "ERROR", "port 2413 is in use by another program; find it with `ss -lunp 'sport = :2413'` (it is ", 2),
    Fault("absent", "nothing was ever received", "sensor absent", "ERROR", "nothing received from 192.168.1.40 to port 2414", 3),
    Fault("other", "another model sends", "sensor other", "ERROR", "this is a VLP-32C, not a VLP-16; set model: velodyne_vlp32c", 3),
    Fault("shared", "two lidars send into one entry", "sensor shared", "ERROR", "192.168.1.206 and 192.168.1.207 both send to port 2410", 4),
    Fault("twins", "two lidars have one address", "sensor twins", "ERROR", "two devices have the address 192.168.1.210 (VLP-16 and another VLP-16)", 3),
    Fault("unlike", "two lidars of different models have one address", "sensor unlike", "ERROR",
          "two devices have the address 192.168.1.211 (VLP-16 and VLP-32C); give one of them another IP address", 3),
    Fault("misnamed", "the packets come from another address", "sensor misnamed", "ERROR",
          "but there are packets from 192.168.1.208 -> port 2411", 3),
    Fault("dirty", "a scanner's window is dirty", "sensor dirty", "WARN", "the scanner's window is dirty; clean it", 3),
    Fault("group", "no interface for the multicast group", "port 2415", "WARN", "239.1.2.3", 2),
    Fault("no_odometry", "nobody publishes the odometry", "motion", "WARN", "no pose of the vehicle yet, so scans are not deskewed; see that odometry is published", 4),
    Fault("odometry_ends", "the odometry ends", "motion", "WARN", "older than the newest scan, which is not deskewed; does odometry still come", 2),
    Fault("refused", "a TCP device refuses", "sensor right", "WARN", "refuses the connection", 1),
    Fault("silent", "a UDP lidar falls silent", "sensor front", "WARN", "silent: nothing received from 192.168.1.21 to port 6060", 1),
    Fault("half_open", "a TCP device loses its power", "sensor left", "WARN", "silent: nothing received from 192.168.1.10:10940", 1),
    Fault("cut", "the link is down", "sensor cut", "WARN", "lidar1 (192.168.2.100/24) has no link", 2.2),
    Fault("off", "the interface is switched off", "sensor off", "WARN", "lidar2 (192.168.3.100/24) is switched off", 1),
    Fault("bare", "no address in the lidar's network", "sensor bare", "WARN",
          "no interface of this host has an address in the network of 192.168.4.201", 1),
    Fault("lossy", "2 % of the packets are lost on the way", "sensor lossy", "WARN", "of packets lost", 8),
    Fault("lossier", "10 % of the packets are lost on the way", "sensor lossier", "WARN", "of packets lost", 4),
    Fault("lossier", "the same a while later", "sensor lossier", "ERROR", "of packets lost", 10),
    Fault("broken", "packets are corrupted", "sensor broken", "WARN", "of packets rejected", 4),
    Fault("stranger", "a sender that is not configured", "unknown senders", "WARN", "192.168.1.66 -> port 2368", 2),
    Fault("elsewhere", "the lidar sends to another port", "sensor elsewhere", "ERROR", "does the sensor send to another port than 2412", 6),
    Fault("stopped", "the host does not fetch the packets", "port 2368", "WARN", "packets were lost in the kernel's receive buffer in the last 10 s: this computer was too busy to fetch them", 2),
    Fault("stopped", "the same for all sensors", "computer", "WARN", "s passed before what came was read, so outputs were late", 2),
]
MIDDLEWARE = [
    Fault("wrong_type", "a source has another type", "odd input", "ERROR", "topic /odd carries sensor_msgs/Imu; expected sensor_msgs/LaserScan", 3),
    Fault("nobody", "nobody publishes a source", "lone input", "WARN", "nobody publishes /lone; start its driver", 4),
    Fault("unusable", "messages of a source are unusable", "bad input", "WARN", "unusable messages: ", 3),
    Fault("ahead", "the clock of a source's node is an hour ahead", "sensor ahead", "WARN", "s ahead of this computer's clock", 4),
    Fault("no_pose", "no pose for a merged scan", "merged astray", "ERROR", "publish it on tf or configure the pose", 3),
    Fault("mount", "a mount is wrong", "merged bent", "WARN", "do not agree on where surfaces are; correct a mount", 15),
    Fault("far_mount", "a mount is wrong by 8 degrees", "merged far_off", "WARN", "do not agree on where surfaces are; correct a mount", 15),
    Fault("astray", "a mount is wrong by a quarter of a turn", "merged astray_mount", "WARN", "of what left sees where their fields of view overlap; check the pose", 15),
    Fault("full_disk", "the state cannot be written at the start", "configuration", "WARN", "the configuration cannot be kept for a start with a wrong file: ", 3),
    Fault("no_cloud", "no cloud for a virtual scan", "virtual levels", "ERROR", "no output for more than 3 s", 4),
    Fault("no_source", "a source of a merged scan is gone", "merged around", "ERROR", "publishing without ", 1),
    Fault("slow", "a subscriber stands still", "topic full/points", "WARN", "a subscriber of full/points is too slow and loses messages", 20),
    Fault("box", "the black box cannot be written", "black box", "WARN", "the black box cannot be written: ", 2),
    Fault("key", "an unknown key at a reload", "configuration", "ERROR", "unknown key", 2),
    Fault("calibration", "a calibration file is missing at a reload", "configuration", "ERROR", "nowhere.yaml", 2),
    Fault("clock", "the host's clock is set", "clock", "WARN", "the host's clock was set by +1.5", 1.5),
    Fault("shutdown", "somebody shuts the ROS node down", "ROS", "WARN", "shut down from outside; look for a node of the same name", 2),
    Fault("hung", "the ROS master hangs", "ROS", "WARN", "the master does not answer; check roscore", 4),
    Fault("away", "the ROS master ends", "ROS", "WARN", "the master does not answer; check roscore", 3),
]
# What items say at some time while they are well.
WELL = {"computer": "reads what comes in time", "clock": "the host's clock runs evenly", "configuration": "as in ",
        "lone input": "waiting for the first message"}
# Sentences before which another one may stand: a loss is a WARN before it is an ERROR; before a connection to the master is
# there, tf is missing for that reason; the kernel reports that a link is down up to 1 s later (linkwatch), so that "silent" may come
# without the cause at first.
MAY_BE_SECOND = ("lossier", "no_pose", "cut")
NOT_TESTED = {
    "a receive buffer that is too small": "root's sockets get what they ask for",
    "a device whose settings differ or whose password is wrong": "test/drivers/velodyne/web and test/drivers/sick/cola read what is noted",
    "a firewall that drops": "test_network_silence.py, where nft is installed",
    "a thread that stands still": "test_watchdog.py",
    "no calibration file at the start": "exit status 78, no daemon that could be asked: test_reload.py",
}
