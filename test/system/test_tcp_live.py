#!/usr/bin/python3
"""SICK scanners of both dialects and Hokuyos that wait on loopback, `lidard run` and subscribers: scans at the sensors' rates, and
again after the sensors were away; /diagnostics says in words what one that refuses answers."""
import signal
import time

from harness import Starved, ask, check_stream, daemon, expect, free_port, scene_of, sim, wait_for, write
from ros_tools import Diagnostics, Listener, ros_test
from sensor_msgs.msg import LaserScan, PointCloud2

# Keys of the scene, s of a period, beams of a scan; 0: it sends clouds.
SENSORS = {
    "lms": ("model: sick_lms1xx, from: '192.168.0.10:{port}', to: '127.0.0.1:40000', jitter_us: 5000, options: {{clock_ppm: 100}}", 0.02, 541),
    "tim": ("model: sick_tim5xx, from: '192.168.0.11:{port}', to: '127.0.0.1:40001', options: {{dialect: a}}", 1 / 15, 811),
    "mrs": ("model: sick_mrs1000, from: '192.168.0.12:{port}', to: '127.0.0.1:40002'", 0.08, 0),
    "ust": ("model: hokuyo_ust_10lx, from: '192.168.0.13:{port}', to: '127.0.0.1:40003', options: {{clock_ppm: 100}}", 0.025, 1081),
    "uam": ("model: hokuyo_uam_05lp, from: '192.168.0.14:{port}', to: '127.0.0.1:40004'", 0.03, 1081),
}
REFUSES = "model: hokuyo_ust_10lx, from: '192.168.0.15:{port}', to: '127.0.0.1:40005', options: {{boot: 100000}}"


def entry_of(name, keys):
    model, address = keys.split(",")[:2]
    host, port = address.split("'")[1].split(":")
    return f"  {name}: {{{model}, ip_address: {host.replace('192', '127')}, ip_port: {port}}}\n"


def check(name, scans, seconds, starved):
    _, period, beams = SENSORS[name]
    check_stream(name, [scan.header.stamp.to_sec() for scan in scans], period, seconds, starved)
    expect(abs(scans[-1].header.stamp.to_sec() - time.time()) < 60, f"{name}: stamps are of today")
    for scan in scans if beams else []:
        expect(len(scan.ranges) == beams, f"{name}: {len(scan.ranges)} beams")
        ahead = scan.ranges[round(-scan.angle_min / scan.angle_increment)]
        expect(abs(ahead - 4) < 0.002, f"{name}: wall at {ahead} m")


def check_rates(got):
    begin = {name: len(listener.messages) for name, listener in got.items()}
    started, starved = time.monotonic(), Starved()
    time.sleep(4)  # measured time
    seconds = time.monotonic() - started
    scans = {name: listener.messages[begin[name]:] for name, listener in got.items()}
    starved = starved.seconds()
    for name in SENSORS:
        check(name, scans[name], seconds, starved)


def stand_still(child, lms):
    """What comes while the daemon stands for half a second is published afterwards: TCP loses nothing."""
    begin, started, starved = len(lms.messages), time.monotonic(), Starved()
    for _ in range(3):
        child.send_signal(signal.SIGSTOP)
        time.sleep(0.5)
        child.send_signal(signal.SIGCONT)
        time.sleep(1.5)  # it catches up
    check("lms", lms.messages[begin:], time.monotonic() - started, starved.seconds())
    dropped = {topic["topic"]: topic["dropped"] for topic in ask("status")["topics"]}
    expect(dropped["lms/scan"] == 0, f"dropped on their way: {dropped}")
    print("lms: no scan is missing after three stops of 0.5 s")


def main():
    sensors = {name: keys.format(port=free_port()) for name, (keys, _, _) in SENSORS.items()}
    sensors["slow"] = REFUSES.format(port=free_port())
    with ros_test() as (tmp, _):
        scene = write(tmp / "scene.yaml", scene_of(sensors))
        config = write(tmp / "live.yaml", "sensors:\n" + "".join(entry_of(name, keys) for name, keys in sensors.items()))
        got = {name: Listener(f"/{name}/scan" if beams else f"/{name}/points", LaserScan if beams else PointCloud2)
               for name, (_, _, beams) in SENSORS.items()}
        diagnostics = Diagnostics()
        with daemon(config) as child:
            with sim(scene):
                wait_for(lambda: all(len(one.messages) > 10 for one in got.values()), 30, "frames of all:\n" + child.said())
                check_rates(got)
                text = diagnostics.message("sensor slow")
                expect(diagnostics.level("sensor slow") and "status 10: " in text and ";" in text, f"the refusal in words: {text}")
                expect(diagnostics.message("sensor ust") == "receiving", diagnostics.message("sensor ust"))
                stand_still(child, got["lms"])
            time.sleep(2)  # the sensors are away
            begin = {name: len(one.messages) for name, one in got.items()}
            with sim(scene):
                back = time.monotonic()
                wait_for(lambda: all(len(one.messages) > begin[name] + 5 for name, one in got.items()), 10,
                         "frames after the sensors were away:\n" + child.said())
                print(f"frames again {time.monotonic() - back:.1f} s after the sensors were back")
    print("ok")


if __name__ == "__main__":
    main()
