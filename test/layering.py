#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Every room may include only what it may know; no files include each other in a circle; headers of core and drivers stay light; code uses the words of the field.

Debian installs ROS, PCL and the rest under /usr/include, so a wrong include compiles without a murmur.
"""
import pathlib
import re
import sys

# Room: rooms that it may include. It may also include what those may include, and nothing else of ours. A room stands
# below those that use it, so that no include can run upwards or in a circle.
ROOMS = {
    "core/base": [],
    "core/frames": ["core/base"],
    "core/motion": ["core/frames"],
    "core/evidence": ["core/motion"],
    "core/merge": ["core/evidence"],
    "core/virtual": ["core/evidence"],
    "core/mounts": ["core/evidence"],
    "drivers": ["core/merge", "core/virtual", "core/mounts"],
    "drivers/net": ["drivers"],
    "drivers/capture": ["drivers"],
    "drivers/velodyne/web": ["drivers"],
    "drivers/velodyne": ["drivers/velodyne/web"],
    "drivers/hokuyo": ["drivers"],
    "drivers/sick/cola": ["drivers"],
    "drivers/sick/safety": ["drivers"],
    "drivers/sick/compact": ["drivers/sick/cola"],
    "drivers/registry": ["drivers/velodyne", "drivers/hokuyo", "drivers/sick/safety", "drivers/sick/compact"],
    "daemon/yaml": ["drivers"],
    "daemon/config": ["daemon/yaml", "drivers/registry", "drivers/net", "drivers/capture"],
    "daemon/log": [],
    "daemon/pipeline": ["daemon/config", "daemon/log"],
    "daemon/health": ["daemon/pipeline"],
    "daemon/live": ["daemon/health"],
    "daemon/files": ["daemon/health"],
    "daemon/offline": ["daemon/files"],
    "daemon/python": ["daemon/offline"],
    "daemon/ros/master": ["daemon/live"],
    "daemon/ros/messages": ["daemon/health"],
    "daemon/ros/velodyne": ["daemon/ros/messages"],
    "daemon/ros/sick": ["daemon/ros/messages"],
    "daemon/ros/out": ["daemon/ros/master", "daemon/ros/velodyne", "daemon/ros/sick"],
    "daemon/ros/in": ["daemon/ros/master", "daemon/ros/velodyne", "daemon/offline"],
    "daemon/ros": ["daemon/ros/out", "daemon/ros/in"],
    "daemon/commands": ["daemon/ros", "daemon/offline"],
    "daemon/dropin": ["daemon/commands"],
    "daemon": ["daemon/dropin"],
    "test/sim/world": ["drivers"],
    "test/sim/devices": ["test/sim/world", "drivers/hokuyo", "drivers/sick/compact"],
    "test/skeleton": ["drivers"],
    "test/sim/servers": ["test/sim/devices", "drivers/registry", "drivers/net", "drivers/capture"],
}
# The rooms of one vendor's protocols. The daemon knows families by drivers/*.h and the registry; only a room that carries a
# vendor's messages includes that vendor's headers.
VENDORS = re.compile(r"drivers/(velodyne|hokuyo|sick)/")
VENDOR_OF = {"daemon/ros/velodyne": "drivers/velodyne/", "daemon/ros/sick": "drivers/sick/"}
# Where rooms are; below test/ only the simulator and the skeleton of a driver are made of them. Their tests, which stand
# beside what they test, may use everything.
FOLDERS = ("core", "drivers", "daemon", "test/sim", "test/skeleton")
TESTS = re.compile(r"test/.*(_test\.cpp|_testing\.h)$")

# Lines of pages that hold more than a room: how to write a driver, and the ways through the code.
LONG_PAGES = {"drivers": 70, "daemon": 90}

ROS = r"ros/|rosbag/|tf2|tf2_ros/|\w+_msgs/|dynamic_reconfigure/|XmlRpc"
FILES_AND_SOCKETS = r"boost/asio|boost/beast|pcap|sys/socket|netinet/|arpa/|fstream$|filesystem$"
THREADS_AND_CLOCKS = r"thread$|mutex$|condition_variable$|future$"
FORBIDDEN = {
    "core": "|".join([ROS, FILES_AND_SOCKETS, THREADS_AND_CLOCKS, r"yaml-cpp|spdlog"]),
    "drivers": "|".join([ROS, THREADS_AND_CLOCKS, r"yaml-cpp|spdlog|pcl/"]),
    "daemon": r"test/",
    "daemon/pipeline": "|".join([ROS, r"boost/asio|boost/beast|sys/socket|netinet/|arpa/|yaml-cpp", THREADS_AND_CLOCKS]),
}
ONLY_IN = {"yaml-cpp": ["daemon/yaml", "daemon/config"], "pybind11/": ["daemon/python"], ROS: [room for room in ROOMS if room.startswith("daemon/ros")] + ["daemon/dropin", "daemon/commands"]}
HEAVY_IN_HEADERS = "|".join([ROS, r"pcl/|spdlog"])
# Words that names and comments do not use, and what they say instead; a text in quotes may have them.
WORDS = {
    "told|tells?|telling": "report, log, show",
    "lament|misfit|doubt(s|ed|ful)?": "error, rejection, warning",
    "wish(es)?": "request",
    "strangers?": "unknown senders",
    "links_": "connections_",
    "outlets?_?": "router",
    "DriverOutput|ChangeableOutput": "FrameReceiver, Reconfigurable",
    "SeenPlace|DiscoverPlace|ParameterReader": "Surroundings, DiscoverTarget, Translation",
    "overlap_": "mount_check_",
    "lying_(product|packets)|grist": "wrong product, packets",
    "connection_(trouble|hint)": "TcpState, ConnectionStatus",
    "veils?(?!_filter)": "mixed pixel",
    "take_\\w+": "accept, apply, parse, read",
    "lest|whoever|somebody": "the noun",
}
# Words that have a meaning in some rooms alone: the others, and what they say instead.
ROOM_WORDS = {
    ("core/frames", "core/mounts", "drivers/sick", "daemon/commands", "daemon/dropin", "daemon/files", "daemon/live", "daemon/offline", "daemon/ros"): {
        r"\bplaces?_?\b|\bis_placed\b|\bplace_of\b": "index, position, pose, viewpoint, to transform",
    },
}
IDIOMS = re.compile(r"\bin (its )?place\b|\btakes? place\b", re.I)
QUOTED = re.compile(r"""R"\((.|\n)*?\)"|"(\\.|[^"\\\n])*"|'\\?[^\n]'""")
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')


def reach(room):
    """The rooms that `room` may include; a circle of rooms ends in an error."""
    found, waiting = set(), list(ROOMS[room])
    while waiting:
        other = waiting.pop()
        if other == room:
            sys.exit(f"the table of rooms runs in a circle through {room}")
        if other not in found:
            found.add(other)
            waiting += ROOMS[other]
    return found


def rules_for(room, is_header):
    layer = room.split("/")[0]
    rules = [FORBIDDEN[name] for name in {layer, room} if name in FORBIDDEN]
    if is_header and layer != "daemon":
        rules.append(HEAVY_IN_HEADERS)
    rules += [what for what, rooms in ONLY_IN.items() if room not in rooms and layer != "test"]
    return "|".join(rules)


def faults_of(path, name, room):
    rule = rules_for(room, path.suffix == ".h")
    allowed = reach(room) | {room}
    for number, line in enumerate(path.read_text().splitlines(), 1):
        found = INCLUDE.match(line)
        target = found.group(1) if found else ""
        ours = target.split("/")[0] in ("core", "drivers", "daemon", "test")
        foreign = room.startswith("daemon") and VENDORS.match(target) and not target.startswith(VENDOR_OF.get(room, "-"))
        if foreign or (ours and target.rpartition("/")[0] not in allowed):
            yield f"{name}:{number}: {room}/ must not include {target}"
        elif not ours and found and rule and re.match(rule, target):
            yield f"{name}:{number}: {room}/ must not include {target}"
        if room.startswith("core/") and re.search(r"(system|steady)_clock::now|gettimeofday|clock_gettime", line):
            yield f"{name}:{number}: core/ has no clock"


def words_of(path, name, room):
    words = dict(WORDS)
    for rooms, more in ROOM_WORDS.items():
        words.update(more if room.startswith(rooms) else {})
    text = IDIOMS.sub("", QUOTED.sub(lambda quoted: "\n" * quoted.group().count("\n"), path.read_text()))
    for number, line in enumerate(text.splitlines(), 1):
        for word, instead in words.items():
            if found := re.search(rf"(?<![a-z])({word})(?![a-z])", line, re.I):
                yield f"{name}:{number}: '{found.group(1)}' is no word of ours; say {instead}"


def violations(root):
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            name = path.relative_to(root)
            if path.suffix not in (".h", ".hpp", ".cpp") or TESTS.search(str(name)):
                continue
            room = str(name.parent)
            if room not in ROOMS:
                yield f"{name}: {room}/ is no room; its row in test/layering.py is missing"
                continue
            yield from faults_of(path, name, room)
            if room.split("/")[0] != "test":
                yield from words_of(path, name, room)


def reached(start, uses):
    """All that `start` leads to in `uses`."""
    found, waiting = set(), [start]
    while waiting:
        for other in uses.get(waiting.pop(), set()) - found:
            found.add(other)
            waiting.append(other)
    return found


def circles(root):
    """The groups of files of one folder that lead back to themselves through the others; a .h and its .cpp count as one."""
    uses = {}
    for folder in ("core", "drivers", "daemon", "test"):
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in (".h", ".cpp"):
                continue
            unit = str(path.relative_to(root)).rpartition(".")[0]
            for found in filter(None, map(INCLUDE.match, path.read_text().splitlines())):
                other = found.group(1).rpartition(".")[0]
                if other != unit and other.rpartition("/")[0] == unit.rpartition("/")[0]:
                    uses.setdefault(unit, set()).add(other)
    ends = {unit: reached(unit, uses) for unit in uses}
    groups = {tuple(sorted(other for other in ends[unit] if unit in ends.get(other, ()))) for unit in uses if unit in ends[unit]}
    for first, *others in sorted(groups):
        yield f"{first} {' '.join(unit.rpartition('/')[2] for unit in others)}: include each other in a circle; what they share belongs into a file of its own"


def missing_pages(root):
    for room in ROOMS:
        page = root / room / "README.md"
        lines = page.read_text().splitlines() if page.exists() else []
        longest = LONG_PAGES.get(room, 30)
        if not 3 <= len(lines) <= longest:
            yield f"{room}/README.md: has {len(lines)} lines; this page has 3 to {longest}"


def main():
    root = pathlib.Path(sys.argv[1])
    checked = sum(1 for folder in FOLDERS for _ in (root / folder).rglob("*.cpp"))
    if checked == 0:
        sys.exit(f"no source file found below {root}")
    found = list(violations(root)) + list(circles(root)) + list(missing_pages(root))
    print("\n".join(found) or f"{checked} source files keep to their rooms")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
