#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Without a master the daemon receives and says so; when the master appears it publishes; SIGTERM ends it cleanly."""
import socket
import subprocess
import time

import rospy
from harness import (LIDARD, LIDARD_SIM, ROOT, expect, folder, free_port, live_config, process, ros_master, use_master_at,
                     wait_for)
from sensor_msgs.msg import LaserScan


def main():
    port = free_port()
    use_master_at(port)
    udp = {p: free_port(socket.SOCK_DGRAM) for p in (2368, 6060)}
    with folder() as tmp:
        config = tmp / "live.yaml"
        config.write_text(live_config((ROOT / "config/demo.yaml").read_text(), udp))
        log = tmp / "log.txt"
        ports = [f"--port-map={old}={new}" for old, new in udp.items()]
        with log.open("w") as sink, process([LIDARD, "run", "-c", config], stdout=sink, stderr=subprocess.STDOUT) as daemon:
            wait_for(lambda: "master" in log.read_text(), 10, "the log says that there is no master")
            # Sends the drive again and again while the master is still missing, then present.
            with process(["/bin/sh", "-c", f"while :; do '{LIDARD_SIM}' send '{ROOT}/pcaps/demo.pcap' --to 127.0.0.1 "
                          + " ".join(ports) + "; done"], stdout=subprocess.DEVNULL, start_new_session=True):
                time.sleep(2)
                expect(daemon.poll() is None, "the daemon lives without a master:\n" + log.read_text())
                with ros_master(port):
                    appeared = time.monotonic()
                    rospy.init_node("listener", disable_signals=True, anonymous=True)
                    got = []
                    rospy.Subscriber("/scan_multi", LaserScan, got.append, queue_size=100)
                    wait_for(lambda: len(got) > 5, 10, "scans arrive after the master appeared:\n" + log.read_text())
                    print(f"first scans {time.monotonic() - appeared:.1f} s after the master")
                    daemon.terminate()
                    expect(daemon.wait(20) == 0, "SIGTERM ends it with 0")
    print("ok")


if __name__ == "__main__":
    main()
