# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""What the system tests share: the programs under test, a private ROS master, ports, a wait with a limit."""
import atexit
import contextlib
import ctypes
import datetime
import json
import mmap
import os
import pathlib
import re
import shutil
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time
import xmlrpc.client

LIDARD = os.environ["LIDARD"]
LIDARD_SIM = os.environ["LIDARD_SIM"]
ROOT = pathlib.Path(os.environ["LIDARD_SOURCE_DIR"])
SKIP = 77
# Machines that run tests are busy: limits that only end a hopeless wait are this much longer.
PATIENCE = 4
# Bytes before the first record of a pcap file, before the packet of a record, before the payload of a UDP record.
FILE_HEAD, RECORD_HEAD, PAYLOAD = 24, 16, 16 + 14 + 20 + 8
CHILDREN = []
LIBC = ctypes.CDLL(None, use_errno=True)
NEW_NETWORK = 0x40000000  # CLONE_NEWNET of sched.h
# Daemons of the tests are not to be found where one of this machine is asked.
os.environ["LIDARD_SOCKET"] = f"{tempfile.gettempdir()}/lidard-test-{os.getpid()}.control"
# Nor do daemons of tests side by side, whose masters may have one port, keep each other's node name.
os.environ["XDG_RUNTIME_DIR"] = tempfile.mkdtemp(prefix="lidard-test-run-")
atexit.register(shutil.rmtree, os.environ["XDG_RUNTIME_DIR"], ignore_errors=True)

WALL = "wall: {from: [4, -30], to: [4, 30], z: [-5, 5]}"


def scene_of(sensors, *objects, seconds=600):
    """A scene: keys of its sensors by their names, and objects, which are a wall 4 m ahead if none are given."""
    lines = ["start: 2026-01-01T00:00:00Z", f"duration: {seconds}", "objects:", *(f"  - {one}" for one in objects or [WALL]), "sensors:"]
    return "\n".join([*lines, *(f"  {name}: {{{keys}}}" for name, keys in sensors.items())]) + "\n"


# A microScan3 before a wall, live for ten minutes, and the configuration that receives it; format() puts the port in.
SCANNER_SCENE = """\
start: 2026-01-01T00:00:00Z
duration: 600
sensors:
  front: {{model: sick_microscan3, from: '192.168.0.21:6060', to: '127.0.0.1:{port}', pose: {{xyz: [0, 0, 0.35]}}}}
objects:
  - wall: {{from: [8, -8], to: [8, 8], z: [-1, 2]}}
"""
SCANNER_CONFIG = "sensors: {{front: {{model: sick_microscan3, ip_address: 127.168.0.21, ip_port: {port}, listen_only: true}}}}\n"


def own_network():
    """Gives this process and its children a network namespace with a loopback of its own; False where that is not permitted."""
    if os.geteuid() != 0 or LIBC.unshare(NEW_NETWORK) != 0:
        return False
    return subprocess.run(["ip", "link", "set", "lo", "up"], check=False).returncode == 0


# Tests that run side by side share no port.
HAS_OWN_NETWORK = "LIDARD_TEST_HOST_NETWORK" not in os.environ and own_network()


def free_port(kind=socket.SOCK_STREAM):
    """A port of the loopback that nobody uses."""
    with socket.socket(socket.AF_INET, kind) as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def kernel_port_is_open(port):
    """True if somebody listens at this UDP port."""
    return any(f":{port:04X} " in line for line in pathlib.Path("/proc/net/udp").read_text().splitlines())


def wait_for(condition, limit, what):
    """The condition's first true value; fails the test after `limit` seconds on a quiet machine."""
    end = time.monotonic() + PATIENCE * limit
    while time.monotonic() < end:
        value = condition()
        if value:
            return value
        time.sleep(0.02)
    sys.exit(f"not within {PATIENCE * limit} s: {what}")


def expect(condition, text):
    if not condition:
        sys.exit(f"FAILED: {text}")


def write(path, text):
    path.write_text(text)
    return path


@contextlib.contextmanager
def folder():
    with tempfile.TemporaryDirectory(prefix="lidard-test-") as path:
        yield pathlib.Path(path)


def use_master_at(port):
    os.environ.update(ROS_MASTER_URI=f"http://127.0.0.1:{port}", ROS_IP="127.0.0.1",
                      ROS_LOG_DIR=tempfile.gettempdir() + "/lidard-test-ros-log")
    os.environ.pop("ROS_HOSTNAME", None)


def waited_for_processor(pid):
    """Seconds that the threads of a process were ready to run and waited for a processor, since they began."""
    total = 0
    for task in pathlib.Path(f"/proc/{pid}/task").glob("*/schedstat"):
        with contextlib.suppress(OSError, IndexError, ValueError):  # a thread that ends meanwhile
            total += int(task.read_text().split()[1]) / 1e9
    return total


def stolen():
    """Seconds that other guests of the same host took from our processors."""
    fields = pathlib.Path("/proc/stat").read_text().split("\n", 1)[0].split()
    return int(fields[8]) / os.sysconf("SC_CLK_TCK")


class Starved:
    """How long the processes of the test, or those of `processes`, have waited for a processor since this was made: what is
    measured beside it may be late by as much. Zero on a machine with time to spare, so that limits are strict there."""

    def __init__(self, processes=None):
        self.processes = processes
        self.begin = self._now()
        self.stolen = stolen()

    def _now(self):
        own, processes = ([os.getpid()], CHILDREN) if self.processes is None else ([], self.processes)
        return {pid: waited_for_processor(pid) for pid in [*own, *(c.pid for c in processes if c.poll() is None)]}

    def add(self, seconds):
        """Adds another delay that the machine caused."""
        self.stolen -= seconds

    def seconds(self):
        now = self._now()
        return sum(max(0, waited - self.begin.get(pid, 0)) for pid, waited in now.items()) + stolen() - self.stolen


def check_stream(name, stamps, period, seconds, starved):
    """Stamps of a sensor that measures once a `period`, received for `seconds`: each a whole number of periods after the one
    before. What is missing between them was lost while processes of the test were starved for `starved` seconds."""
    expect(len(stamps) > 2, f"{name}: {len(stamps)} frames in {seconds:.1f} s")
    steps = [b - a for a, b in zip(stamps, stamps[1:])]
    for step in steps:
        expect(round(step / period) >= 1 and abs(step - round(step / period) * period) < 0.25 * period,
               f"{name}: stamps {step} s apart, one each {period} s")
    missing = sum(round(step / period) - 1 for step in steps)
    expect(missing * period <= starved, f"{name}: {missing} of {len(stamps) + missing} frames are missing, starved {starved:.3f} s")
    rate = len(stamps) * period / seconds
    expect(abs(rate - 1) < 0.2 + starved / seconds, f"{name}: {len(stamps)} frames in {seconds:.1f} s, one each {period} s")


@contextlib.contextmanager
def process(command, **options):
    """A child that is always ended."""
    child = subprocess.Popen([str(c) for c in command], **options)
    CHILDREN.append(child)
    try:
        yield child
    finally:
        if child.poll() is None:
            child.send_signal(signal.SIGCONT)
            child.terminate()
            try:
                child.wait(5 * PATIENCE)
            except subprocess.TimeoutExpired:
                child.kill()
                child.wait()


@contextlib.contextmanager
def logged(command, log, **options):
    """A program whose output goes to the file `log`; said() is the output so far."""
    with log.open("w") as sink, process(command, stdout=sink, stderr=subprocess.STDOUT, **options) as child:
        child.said = log.read_text
        yield child


def daemon(config, *arguments, **options):
    """`lidard run`; its log lies beside the configuration."""
    return logged([LIDARD, "run", "-c", config, *arguments], config.with_suffix(".log"), **options)


def expect_end(child, stop, limit=20):
    """The program ends with 0 after the signal; returns the seconds that it took."""
    begin = time.monotonic()
    child.send_signal(stop)
    expect(child.wait(limit * PATIENCE) == 0, f"{stop.name} ends it with 0, not {child.returncode}")
    return time.monotonic() - begin


def named_program(tmp, name):
    """The executable below another name, as rosrun would start it."""
    program = tmp / name
    program.symlink_to(os.path.abspath(LIDARD))
    return program


def sim(scene):
    """`lidard-sim live`."""
    return process([LIDARD_SIM, "live", scene], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def make_capture(path, scene):
    """What the sensors of a scene send, in a file."""
    made = subprocess.run([LIDARD_SIM, "make", write(path.with_suffix(".scene.yaml"), scene), "-o", path, "--no-truth"],
                          capture_output=True, text=True)
    expect(made.returncode == 0, made.stderr)
    return path.with_suffix(".pcap")


def send(capture, *options, timeout=300):
    """Sends a capture over loopback at its own pace; what lidard-sim reports."""
    sent = subprocess.run([LIDARD_SIM, "send", capture, "--to", "127.0.0.1", *options], capture_output=True, text=True, timeout=timeout)
    expect(sent.returncode == 0, sent.stderr)
    return sent.stdout


def send_for_ever(capture, ports):
    options = " ".join(f"--port-map={old}={new}" for old, new in ports.items())
    return process(["/bin/sh", "-c", f"while :; do '{LIDARD_SIM}' send '{capture}' --to 127.0.0.1 {options}; done"],
                   stdout=subprocess.DEVNULL, start_new_session=True)


def records(data):
    """The records of a pcap file of the simulator."""
    at = FILE_HEAD
    while at < len(data):
        end = at + RECORD_HEAD + struct.unpack_from("<I", data, at + 8)[0]
        yield data[at:end]
        at = end


def stamp_ns(record):
    seconds, fraction = struct.unpack_from("<II", record)
    return seconds * 1_000_000_000 + fraction  # captures of the simulator count ns


def source_of(record):
    return socket.inet_ntoa(record[RECORD_HEAD + 26:RECORD_HEAD + 30])


class Clock:
    """The clock of the host, moved by `seconds`, as a program sees it that is started with environment()."""

    def __init__(self, path):
        self.path = path
        path.write_bytes(bytes(8))
        self.file = path.open("r+b")
        self.memory = mmap.mmap(self.file.fileno(), 8)
        self.seconds = 0

    def environment(self):
        return {**os.environ, "LD_PRELOAD": os.environ["LIDARD_CLOCK_SHIM"], "LIDARD_TEST_CLOCK": str(self.path)}

    def set_by(self, step):
        self.seconds += step
        self.memory[:] = struct.pack("<q", round(self.seconds * 1e9))


def kilobytes(pid, key):
    """A figure of /proc/PID/status: VmRSS, VmHWM, VmLck."""
    return int(re.search(rf"{key}:\s+(\d+) kB", pathlib.Path(f"/proc/{pid}/status").read_text())[1])


def descriptors(pid):
    return len(list(pathlib.Path(f"/proc/{pid}/fd").iterdir()))


def thread_names(pid):
    return sorted((task / "comm").read_text().strip() for task in pathlib.Path(f"/proc/{pid}/task").iterdir())


def ask(word):
    """What the daemon answers at its runtime socket; None while there is none."""
    try:
        with socket.socket(socket.AF_UNIX) as s:
            s.connect(os.environ["LIDARD_SOCKET"])
            s.sendall(word.encode() + b"\n")
            answer = b"".join(iter(lambda: s.recv(65536), b""))
        return json.loads(answer)
    except OSError:
        return None


def item(name):
    status = ask("status")
    return next((one for one in status["items"] if one["name"] == name), None) if status else None


def figure(name, key):
    return item(name)["values"][key]


def events_of(source, since=0):
    """(time, level, sentence) of the events of a source, from that time on, in s of the host's clock."""
    answer = ask("events") or {"events": []}
    times = [(datetime.datetime.fromisoformat(e["at"].replace("Z", "+00:00")).timestamp(), e["level"], e["text"])
             for e in answer["events"] if e["source"] == source]
    return [one for one in times if one[0] >= since]


def first_event(source, since, level, limit=10, text=""):
    """When the first one of that level came."""
    return wait_for(lambda: next((e for e in events_of(source, since) if e[1] == level and text in e[2]), None), limit,
                    f"{source} becomes {level} {text}: {events_of(source)}")


def level(name):
    return (item(name) or {}).get("level")


def well(*names, limit=20):
    """Waits until these items are OK."""
    ill = lambda: [f"{name}: {(item(name) or {}).get('message')}" for name in names if level(name) != "OK"]
    wait_for(lambda: not ill(), limit, Now(lambda: f"all is well: {ill()}"))


class Now:
    """A text that is made when it is shown."""

    def __init__(self, text):
        self.text = text

    def __str__(self):
        return self.text()


@contextlib.contextmanager
def ros_master(port):
    client = xmlrpc.client.ServerProxy(f"http://127.0.0.1:{port}")

    def answers():
        try:
            return client.getPid("/test")
        except OSError:
            return None

    with process(["/usr/bin/python3", "/usr/bin/rosmaster", "--core", "-p", port], stdout=subprocess.DEVNULL,
                 stderr=subprocess.DEVNULL) as master:
        wait_for(answers, 20, "the ROS master answers")
        master.port = port
        yield master


def run(*arguments, timeout=120, **options):
    return subprocess.run([LIDARD, *map(str, arguments)], capture_output=True, text=True, timeout=timeout, **options)


def live_config(text, ports):
    """A configuration for captured sensors sent over loopback: a.b.c.d sends from 127.b.c.d to another port."""
    text = text.replace("192.168.", "127.168.")
    for old, new in ports.items():
        text = text.replace(f"ip_port: {old}", f"ip_port: {new}")
    return text
