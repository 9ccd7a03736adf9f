#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""What a launch file or a parameter file asks for, as JSON for `lidard import`.

roslaunch itself resolves arguments, conditions, includes and names. Nothing is started: a <param command="..."> and a
<rosparam command="dump"> would run a program or write a file, so they are left out and reported. Of programs only xacro is
run, which computes a robot's description. Its fixed joints are what robot_state_publisher publishes as static transforms.
"""
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from xml.etree import ElementTree

MISSING = "/package-not-found/"
changes, remarks = {}, {}  # each text once, in order


def printed_by(name, command, path):
    """What the command of a parameter prints: xacro and cat compute and read alone, other programs are not run."""
    words = shlex.split(command)
    program = os.path.basename(words[0]) if words else ""
    words[:1] = [shutil.which("xacro") if program in ("xacro", "xacro.py") else program]
    if program != "cat" and (not words[0] or words[0] == program):
        how = "; install xacro for the poses of its joints" if "xacro" in program else ""
        changes.setdefault(f"parameter {name} is what a program prints, which was not run: {command}{how}")
        return ""
    # xacro finds packages by itself: that of the file too, which need not be installed.
    while path != "/" and not os.path.exists(os.path.join(path, "package.xml")):
        path = os.path.dirname(path)
    packages = os.pathsep.join([path, os.environ.get("ROS_PACKAGE_PATH", "")][path == "/":])
    run = subprocess.run(words, capture_output=True, check=False, text=True, env={**os.environ, "ROS_PACKAGE_PATH": packages})
    if run.returncode != 0:
        changes.setdefault(f"parameter {name} was not computed: {run.stderr.strip()}")
    return run.stdout


def own_launch_file(path):
    """Debian has no velodyne_pointcloud: lidard's launch file of the same name and arguments stands in."""
    here, name = os.path.dirname(os.path.realpath(__file__)), os.path.basename(path)
    for own in (os.path.join(here, "launch", name), os.path.join(here, "../../share/lidard/launch", name)):
        if path.startswith(MISSING + "velodyne_pointcloud/launch/") and os.path.exists(own):
            remarks.setdefault(f"velodyne_pointcloud is not installed: lidard's {name} was read in its place")
            return own
    return path


def package_at(folder, name):
    try:
        with open(os.path.join(folder, "package.xml"), encoding="utf-8") as file:
            return re.search(r"<name>\s*%s\s*</name>" % re.escape(name), file.read()) is not None
    except OSError:
        return False


def package_near(folder, name):
    """A package that the file belongs to, or one that lies beside it, as in a clone of its repository."""
    for _ in range(5):
        for candidate in (folder, os.path.join(folder, name)):
            if package_at(candidate, name):
                return candidate
        folder = os.path.dirname(folder)
    return None


def as_text(value):
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return " ".join(as_text(one) for one in value)
    if isinstance(value, dict):
        return json.dumps(value, default=str)
    return "" if value is None else str(value)


def flat(parameters, prefix=""):
    for name, value in parameters.items():
        if isinstance(value, list) and any(isinstance(one, dict) for one in value):
            value = dict(enumerate(value))
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{name}/")
        else:
            yield prefix + str(name), as_text(value)


def load_quietly(path, arguments):
    import rosgraph.names
    import roslaunch.config
    import roslaunch.loader
    import roslaunch.substitution_args
    import roslaunch.xmlloader
    import rospkg

    class Packages(rospkg.RosPack):
        def get_path(self, name):
            near = package_near(os.path.dirname(os.path.abspath(path)), name)
            if near is not None:
                return near
            try:
                return super().get_path(name)
            except rospkg.ResourceNotFound:
                return MISSING + name

    roslaunch.substitution_args._rospack = Packages()
    param_value = roslaunch.loader.Loader.param_value

    def without_commands(self, verbose, name, ptype, value, textfile, binfile, command):
        if command is not None:
            return printed_by(name, command, os.path.dirname(os.path.abspath(path)))
        return param_value(self, verbose, name, ptype, value, textfile, binfile, command)

    load_rosparam = roslaunch.loader.Loader.load_rosparam

    def without_dumps(self, context, ros_config, cmd, *rest, **more):
        if cmd == "dump":
            remarks.setdefault('a <rosparam command="dump"> was left out')
            return None
        return load_rosparam(self, context, ros_config, cmd, *rest, **more)

    parse_launch = roslaunch.xmlloader.XmlLoader._parse_launch
    roslaunch.xmlloader.XmlLoader._parse_launch = lambda self, name, verbose: parse_launch(self, own_launch_file(name), verbose)
    roslaunch.loader.Loader.param_value = without_commands
    roslaunch.loader.Loader.load_rosparam = without_dumps
    # Without roscore.xml, which brings nodes and parameters of the master.
    roslaunch.config.load_roscore = lambda *_, **__: None
    return roslaunch.config.load_config_default([(path, arguments)], None, assign_machines=False), rosgraph.names


def node(name, parameters, package="", kind="", arguments=(), space="/", remaps=None):
    return {"name": name, "package": package, "type": kind, "arguments": list(arguments), "namespace": space,
            "remaps": remaps or {}, "parameters": dict(flat(parameters))}


def fixed_joints(name, description):
    try:
        for joint in ElementTree.fromstring(description).findall("joint[@type='fixed']"):
            origin = joint.find("origin")
            values = {} if origin is None else origin.attrib
            roll, pitch, yaw = values.get("rpy", "0 0 0").split()
            frames = [joint.find(end).attrib["link"] for end in ("parent", "child")]
            yield node(f"{name}, joint {joint.get('name')}", {}, "robot_state_publisher", "static_transform_publisher",
                       [*values.get("xyz", "0 0 0").split(), yaw, pitch, roll, *frames])
    except (ElementTree.ParseError, AttributeError, KeyError, ValueError) as trouble:
        changes.setdefault(f"parameter {name} is no complete description of a robot ({trouble}): its poses stay with tf")


def resolved_name(name, node, space):
    if name.startswith("~"):
        return node + "/" + name[1:].lstrip("/")
    return name if name.startswith("/") else f"{space.rstrip('/')}/{name}"


def nodes_of_launch(path, arguments):
    config, names = load_quietly(path, arguments)
    parameters = {key: parameter.value for key, parameter in config.params.items()}
    for one in config.nodes:
        full, space = names.ns_join(one.namespace, one.name), one.namespace
        package, kind, words, remaps = one.package, one.type, (one.args or "").split(), list(one.remap_args)
        if package == "nodelet" and words and words[0] in ("load", "standalone") and len(words) > 1:
            package, _, kind = words[1].partition("/")
            remaps += [word.split(":=", 1) for word in words[2:] if ":=" in word]
        own = {key[len(full) + 1:]: value for key, value in parameters.items() if key.startswith(full + "/")}
        own.update(word[1:].split(":=", 1) for word in words if re.match("_[^_].*:=", word))
        for missing in set(re.findall(MISSING + r"([^/\s]+)", str(own))) - {"velodyne_pointcloud"}:
            changes.setdefault(f"{full}: package {missing}, of which it has a file, is neither installed nor beside the file")
        yield node(full, own, package, kind, words, space,
                   {resolved_name(a, full, space): resolved_name(b, full, space) for a, b in remaps})
    for key, value in parameters.items():
        if key.endswith("robot_description") and isinstance(value, str) and value.strip():
            yield from fixed_joints(key, value)


def nodes_of_parameters(path):
    """Each mapping that holds values is the parameters of a node; ROS 2 has them below ros__parameters."""
    import yaml

    with open(path, encoding="utf-8-sig") as file:
        content = yaml.safe_load(file)
    if not isinstance(content, dict):
        raise ValueError(f"{path}: holds no parameters")

    def walk(mapping, name):
        mapping = mapping.get("ros__parameters", mapping)
        inner = {key: value for key, value in mapping.items() if isinstance(value, dict)}
        own = {key: value for key, value in mapping.items() if key not in inner}
        if own:
            own.update(inner)
            yield node(name or "/lidar", own)
        else:
            for key, value in inner.items():
                yield from walk(value, (name + "/" + str(key).strip("/*")).rstrip("/"))

    yield from walk(content, "")


def reason(path, trouble):
    text = " ".join(str(trouble).split())
    missing = re.search(MISSING + r"([^/'\s]+)/?([^'\]\s]*)", text)
    if missing:
        return (f"package {missing[1]} is neither installed nor beside the file, which reads {missing[2].rstrip(':') or 'files of it'}; "
                "install it, or add a clone of it to ROS_PACKAGE_PATH")
    with open(path, encoding="utf-8", errors="replace") as file:
        if path.endswith(".py") or re.search(r"<node[^>]*\sexec\s*=", file.read()):
            return "is a launch file of ROS 2; expected one of ROS 1, or the YAML file of parameters that it loads"
    return text


def main(path, arguments):
    try:
        if path.endswith((".yaml", ".yml")):
            nodes = list(nodes_of_parameters(path))
        else:
            nodes = list(nodes_of_launch(path, arguments))
        answer = {"nodes": nodes, "changes": list(changes), "remarks": list(remarks)}
    except ImportError as missing:
        answer = {"missing": "a launch file is read with roslaunch, a parameter file with Python's yaml, and "
                             f"{missing}; apt install python3-roslaunch python3-yaml"}
    except Exception as trouble:  # whatever roslaunch and its files may raise is an answer for a person
        answer = {"error": reason(path, trouble)}
    json.dump(answer, sys.stdout)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
