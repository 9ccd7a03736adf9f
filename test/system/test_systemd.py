#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The installed units under a real systemd: a container whose disk is this machine's with a layer above that is thrown away. Data
come with everything the unit forbids, a daemon that is killed or hangs is back, and stopping is quick."""
import contextlib
import datetime
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

from harness import LIDARD, LIDARD_SIM, ROOT, SCANNER_CONFIG, SCANNER_SCENE, SKIP, expect, process, wait_for, write

PORT = 6060
MASTER = "http://127.0.0.1:11311"
WRONG = "sensors: {front: {model: sick_microscan4}}\n"
SUBSCRIBER = """
import sys, threading, time, rospy
from sensor_msgs.msg import LaserScan
got = threading.Event()
rospy.init_node("listener", anonymous=True, disable_signals=True)
rospy.Subscriber(sys.argv[1], LaserScan, lambda scan: got.set(), queue_size=1)
begin = time.monotonic()
print("seconds", time.monotonic() - begin if got.wait(float(sys.argv[2])) else "none", flush=True)
import os; os._exit(0)
"""


class Vehicle:
    """A computer that runs systemd; its disk is the folder `below` with a layer above that is thrown away."""

    def __init__(self, folder, below="/"):
        self.root = folder / "root"
        self.below = below
        self.layers = [folder / name for name in ("upper", "work")]
        for path in (self.root, *self.layers):
            path.mkdir()
        self.pid = None

    def mount(self):
        upper, work = self.layers
        return subprocess.run(["mount", "-t", "overlay", "overlay", "-o", f"lowerdir={self.below},upperdir={upper},workdir={work}", self.root],
                              capture_output=True, text=True, check=False)

    def inside(self, *command, timeout=60, **options):
        """Runs a command in the container."""
        return subprocess.run(["nsenter", "-t", str(self.pid), "-m", "-u", "-i", "-n", "-p", "--", *map(str, command)],
                              capture_output=True, text=True, timeout=timeout, check=False, **options)

    def systemctl(self, *arguments):
        return self.inside("systemctl", *arguments)

    def prop(self, unit, name):
        return self.systemctl("show", "-P", name, unit).stdout.strip()

    def find_init(self, nspawn):
        children = pathlib.Path(f"/proc/{nspawn.pid}/task/{nspawn.pid}/children").read_text().split()
        for pid in children:
            if "systemd" in pathlib.Path(f"/proc/{pid}/comm").read_text():
                self.pid = int(pid)
                state = self.systemctl("is-system-running").stdout.strip()
                return state in ("running", "degraded")
        return False


def needs():
    """What keeps this test from running here, if anything."""
    if os.geteuid() != 0:
        return "not root"
    for program in ("systemd-nspawn", "nsenter"):
        if not shutil.which(program):
            return f"no {program}"
    return None


@contextlib.contextmanager
def mounted(folder, below="/"):
    vehicle = Vehicle(folder, below)
    done = vehicle.mount()
    if done.returncode != 0:
        print("skipped: no overlay:", done.stderr.strip())
        sys.exit(SKIP)
    try:
        quiet = vehicle.root / "etc/systemd/system"
        # Whatever else this machine would start is no part of the test.
        (quiet / "default.target").unlink(missing_ok=True)
        (quiet / "default.target").symlink_to("/lib/systemd/system/basic.target")
        (vehicle.root / "etc/machine-id").write_text("")
        yield vehicle
    finally:
        subprocess.run(["umount", "--lazy", vehicle.root], check=False)


@contextlib.contextmanager
def booted(vehicle):
    with process(["systemd-nspawn", "--quiet", "--directory", vehicle.root, "--boot", "--register=no", "--keep-unit",
                  "--private-network", "--console=pipe", "--kill-signal=SIGRTMIN+3", "--capability=CAP_IPC_LOCK"], stdin=subprocess.DEVNULL,
                 stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as nspawn:
        deadline = time.monotonic() + 60
        while not vehicle.find_init(nspawn):
            if nspawn.poll() is not None or time.monotonic() > deadline:
                print("skipped: systemd does not start in a container here")
                sys.exit(SKIP)
            time.sleep(0.2)
        yield vehicle
        vehicle.systemctl("poweroff")
        nspawn.wait(60)


def install(vehicle):
    done = subprocess.run(["cmake", "--install", str(pathlib.Path(LIDARD).parent), "--prefix", "/usr"],
                          env={**os.environ, "DESTDIR": str(vehicle.root)}, capture_output=True, text=True, check=False)
    expect(done.returncode == 0, done.stdout + done.stderr)
    shutil.copy(LIDARD_SIM, vehicle.root / "usr/bin/lidard-sim")


def prepare(root):
    """Configurations, a scene, and what plays the lidar and the ROS master."""
    (root / "etc/lidard").mkdir(exist_ok=True)
    text = SCANNER_CONFIG.format(port=PORT)
    write(root / "etc/lidard/lidard.yaml", text)
    write(root / "etc/lidard/rear.yaml", text.replace(str(PORT), str(PORT + 1)).replace("front", "rear"))
    write(root / "etc/lidard/broken.yaml", WRONG)
    (root / "etc/default").mkdir(exist_ok=True)
    (root / "etc/default/lidard").write_text(f"ROS_MASTER_URI={MASTER}\nROS_IP=127.0.0.1\n")
    (root / "etc/scene.yaml").write_text(SCANNER_SCENE.format(port=PORT))
    (root / "etc/listener.py").write_text(SUBSCRIBER)


def start_world(vehicle, scene="/etc/scene.yaml"):
    vehicle.systemctl("reset-failed")
    environment = ["--setenv=ROS_IP=127.0.0.1", "--setenv=ROS_LOG_DIR=/tmp/ros"]
    vehicle.inside("systemd-run", "--unit=lidar", "lidard-sim", "live", scene)
    vehicle.inside("systemd-run", "--unit=master", *environment, "/usr/bin/python3", "/usr/bin/rosmaster", "--core", "-p", "11311")


def seconds_to_data(vehicle, topic="/front/scan", limit=20):
    done = vehicle.inside("env", f"ROS_MASTER_URI={MASTER}", "ROS_IP=127.0.0.1", "ROS_LOG_DIR=/tmp/ros", "/usr/bin/python3",
                          "/etc/listener.py", topic, limit, timeout=limit + 30)
    found = re.search(r"seconds (\S+)", done.stdout)
    expect(found and found.group(1) != "none", f"no scan on {topic}: {done.stdout}{done.stderr}\n{journal(vehicle)}")
    return float(found.group(1))


def journal(vehicle, unit="lidard"):
    return vehicle.inside("journalctl", "--no-pager", "-n", "60", "-u", unit).stdout


def main_pid(vehicle, unit="lidard"):
    return int(vehicle.prop(unit, "MainPID"))


def check_security(vehicle):
    """P27, and that the template is no weaker."""
    for unit in ("lidard.service", "lidard@.service"):
        done = vehicle.inside("systemd-analyze", "security", "--offline=yes", "--threshold=11", "--json=short",
                              f"/usr/lib/systemd/system/{unit}")
        expect(done.returncode == 0, f"{unit} exposes more than 1.1: {done.stdout}{done.stderr}")
    stricter = vehicle.inside("systemd-analyze", "security", "--offline=yes", "--threshold=5", "/usr/lib/systemd/system/lidard.service")
    expect(stricter.returncode != 0, "the limit is one that can be missed")


def check_data(vehicle):
    """The unit comes up and scans come out, with everything that it forbids."""
    begin = time.monotonic()
    done = vehicle.systemctl("start", "lidard")
    ready = time.monotonic() - begin
    expect(done.returncode == 0, done.stderr + journal(vehicle))
    seconds_to_data(vehicle)
    print(f"READY {ready:.2f} s after systemctl start; {vehicle.prop('lidard', 'StatusText')}")
    expect(vehicle.prop("lidard", "ActiveState") == "active", journal(vehicle))


def check_privileges(vehicle):
    """P28: not root, no capability, nothing to write to but its own folders."""
    pid = main_pid(vehicle)
    status = dict(line.split(":\t", 1) for line in vehicle.inside("cat", f"/proc/{pid}/status").stdout.splitlines() if ":\t" in line)
    expect(status["Uid"].split()[0] != "0", f"runs as root: {status['Uid']}")
    for kind in ("CapEff", "CapPrm", "CapBnd", "CapAmb"):
        expect(int(status[kind], 16) == 0, f"{kind} is {status[kind]}")
    expect(status["NoNewPrivs"] == "1" and status["Seccomp"] == "2", "no filter of system calls")
    user = status["Uid"].split()[0]
    found = vehicle.inside("nsenter", "-t", pid, "-m", "--", "setpriv", "--reuid", user, "--regid", user, "--clear-groups", "find", "/",
                           "/run", "/dev", "-xdev", "-type", "d", "-writable", "-print",
                           timeout=120).stdout.split()
    folders = {"/run/lidard", "/var/lib/private/lidard", "/var/lib/lidard", "/tmp", "/var/tmp", "/dev/shm", "/dev/mqueue"}
    expect(not set(found) - folders, f"can be written to: {sorted(set(found) - folders)}")


def check_sockets(vehicle):
    """P29: what `lidard check --ports` prints: the sensor's port, and roscpp's."""
    said = vehicle.inside("lidard", "check", "--ports", "/etc/lidard/lidard.yaml").stdout
    expect(re.findall(r"^listens +udp (\d+)", said, re.MULTILINE) == [str(PORT)], said)
    expect("tcp, two free ports" in said and "udp, one free port" in said, said)
    pid = main_pid(vehicle)
    listed = vehicle.inside("ss", "-H", "-lntup").stdout
    ours = [line.split() for line in listed.splitlines() if f"pid={pid}," in line]
    udp = [f[4].rpartition(":")[2] for f in ours if f[0] == "udp"]
    expect(str(PORT) in udp and len(udp) == 2, f"UDP ports: {udp}")
    expect(len([f for f in ours if f[0] == "tcp"]) == 2, listed)


def check_kill(vehicle):
    """P17: from SIGKILL to data."""
    before = main_pid(vehicle)
    begin = time.monotonic()
    vehicle.systemctl("kill", "--signal=KILL", "lidard")
    wait_for(lambda: main_pid(vehicle) not in (0, before), 5, "a new process")
    back = time.monotonic() - begin
    seconds_to_data(vehicle)
    print(f"a new process {back:.2f} s after SIGKILL")


def check_hang(vehicle):
    """P18 with systemd's own watchdog: a process that stands still is replaced."""
    before = main_pid(vehicle)
    begin = time.monotonic()
    vehicle.inside("kill", "-STOP", before)
    wait_for(lambda: main_pid(vehicle) not in (0, before), 10, f"a new process after the watchdog\n{journal(vehicle)}")
    print(f"a new process {time.monotonic() - begin:.2f} s after it stood still")
    expect("watchdog" in journal(vehicle).lower(), journal(vehicle))
    seconds_to_data(vehicle)
    history = status(vehicle)["history"]
    print(history)
    restarts = vehicle.prop("lidard", "NRestarts")
    # Restarts are known where the bus of the system answers; a bare container has none.
    killed = re.fullmatch(rf"(?:restarted {restarts} times? by systemd, )?last killed by its watchdog at (\S+)Z", history)
    expect(killed, f"{history!r}, NRestarts is {restarts}")
    at = datetime.datetime.fromisoformat(killed[1] + "+00:00").timestamp()
    expect(abs(at - time.time()) < 120, f"the watchdog fired at {killed[1]}")
    expect(history in vehicle.inside(*STATUS).stdout, "`lidard status` prints it")


def check_instances(vehicle):
    """A second daemon beside the first, with a configuration and a ROS node of its own."""
    done = vehicle.systemctl("start", "lidard@rear")
    expect(done.returncode == 0, done.stderr + journal(vehicle, "lidard@rear"))
    wait_for(lambda: "/lidard_rear'" in nodes(vehicle), 10, "the node lidard_rear")
    expect(vehicle.prop("lidard", "ActiveState") == "active", "the first goes on")
    vehicle.systemctl("stop", "lidard@rear")


def nodes(vehicle):
    script = "import rosgraph; s = rosgraph.Master('/t').getSystemState(); print(sorted({n for k in s for _, l in k for n in l}))"
    return vehicle.inside("env", f"ROS_MASTER_URI={MASTER}", "/usr/bin/python3", "-c", script).stdout


def check_bad_configuration(vehicle):
    """It fails once, loudly, and is not tried again."""
    done = vehicle.systemctl("start", "lidard@broken")
    expect(done.returncode != 0, "a wrong configuration was accepted")
    time.sleep(1)  # a second try would come
    expect(vehicle.prop("lidard@broken", "NRestarts") == "0", "tried again")
    expect(vehicle.prop("lidard@broken", "ExecMainStatus") == "78", vehicle.prop("lidard@broken", "ExecMainStatus"))
    expect("broken.yaml:1" in journal(vehicle, "lidard@broken"), journal(vehicle, "lidard@broken"))


STATUS = ("env", "-u", "LIDARD_SOCKET", "XDG_RUNTIME_DIR=/run/user/0", "lidard", "status")


def status(vehicle):
    done = vehicle.inside(*STATUS, "--json")
    expect(done.stdout, f"`lidard status`: {done.stderr}")
    return json.loads(done.stdout)


def configuration_item(vehicle):
    return {item["name"]: item for item in status(vehicle)["items"]}["configuration"]


def check_reload(vehicle):
    """P19: a changed file, a wrong file, and a start with a wrong file."""
    file = vehicle.root / "etc/lidard/lidard.yaml"
    good, process = file.read_text(), main_pid(vehicle)

    def reload(text):
        file.write_text(text)
        done = vehicle.systemctl("reload", "lidard")
        expect(done.returncode == 0, done.stderr + journal(vehicle))

    reload(good + "merged_scans: {around: {laserscan_topics: [front], destination_frame: front, range_max: 20}}\n")
    seconds_to_data(vehicle, "/around")
    reload(WRONG)
    wait_for(lambda: configuration_item(vehicle)["level"] == "ERROR", 5, "the wrong file is reported")
    expect("lidard.yaml:1:" in journal(vehicle), journal(vehicle))
    expect(main_pid(vehicle) == process, "the same process goes on")
    seconds_to_data(vehicle)
    vehicle.systemctl("restart", "lidard")
    seconds_to_data(vehicle, "/around")
    item = configuration_item(vehicle)
    expect(item["level"] == "ERROR" and "the last good configuration is in force" in item["message"], str(item))
    print(f"started with a wrong file: {item['message']}")
    reload(good)
    wait_for(lambda: configuration_item(vehicle)["level"] == "OK", 5, "the right file is in force")


def check_real_time(vehicle):
    """The drop-in of lidard(8), on the processors that this machine has."""
    page = (ROOT / "daemon/lidard.8").read_text()
    section = page[page.index(".SH REAL TIME"):]
    text = section[section.index(".nf\n") + 4:section.index(".fi\n")].replace("\\-", "-").replace("CPUAffinity=2 3", "CPUAffinity=0")
    drop_in = vehicle.root / "etc/systemd/system/lidard.service.d/real_time.conf"
    drop_in.parent.mkdir()
    drop_in.write_text(text)
    vehicle.systemctl("daemon-reload")
    vehicle.systemctl("restart", "lidard")
    seconds_to_data(vehicle)
    # Numbers of processes are those of the container; threads inherit the policy.
    policies = vehicle.inside("chrt", "--all-tasks", "--pid", main_pid(vehicle)).stdout
    expect("SCHED_FIFO" in policies, policies or journal(vehicle))
    own = [line for line in policies.splitlines() if "policy" in line]
    expect(len(own) > 5 and all("SCHED_FIFO" in line for line in own), policies)
    status = vehicle.inside("cat", f"/proc/{main_pid(vehicle)}/status").stdout
    locked = next(line for line in status.splitlines() if line.startswith("VmLck"))
    # Where this machine's own root may not raise the limit, systemd's cannot either.
    may_lock = subprocess.run(["prlimit", "--memlock=unlimited:unlimited", "true"], capture_output=True, check=False).returncode == 0
    if may_lock:
        expect(int(locked.split()[1]) > 20000, locked + journal(vehicle))
    else:
        print("not tested: locked memory, whose limit may not be raised here")
        expect("LIDARD_LOCK_MEMORY=1, but" in journal(vehicle), "the log says that memory is not locked")
    expect("Cpus_allowed_list:\t0\n" in status, status)
    print(f"real time: {len(own)} threads SCHED_FIFO, {locked}")
    drop_in.unlink()
    vehicle.systemctl("daemon-reload")
    vehicle.systemctl("restart", "lidard")
    seconds_to_data(vehicle)


def check_stop(vehicle):
    """P20."""
    begin = time.monotonic()
    done = vehicle.systemctl("stop", "lidard")
    seconds = time.monotonic() - begin
    expect(done.returncode == 0 and vehicle.prop("lidard", "Result") == "success", journal(vehicle))
    expect("/lidard'" not in nodes(vehicle), f"still registered: {nodes(vehicle)}")
    print(f"stopped in {seconds:.2f} s")


def main():
    missing = needs()
    if missing:
        print("skipped:", missing)
        sys.exit(SKIP)
    with tempfile.TemporaryDirectory(prefix="lidard-systemd-", ignore_cleanup_errors=True) as path, \
            mounted(pathlib.Path(path)) as vehicle:
        install(vehicle)
        prepare(vehicle.root)
        with booted(vehicle):
            check(vehicle)


def check(vehicle):
    start_world(vehicle)
    check_security(vehicle)
    check_data(vehicle)
    check_privileges(vehicle)
    check_sockets(vehicle)
    check_kill(vehicle)
    check_hang(vehicle)
    check_instances(vehicle)
    check_bad_configuration(vehicle)
    check_reload(vehicle)
    check_real_time(vehicle)
    check_stop(vehicle)


if __name__ == "__main__":
    main()
