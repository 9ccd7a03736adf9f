#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""What a launch file or a parameter file asks for, as JSON for `lidard import`.

roslaunch itself resolves arguments, conditions, includes and names. Nothing is started: a <param command="..."> and a
<rosparam command="dump"> would run a program or write a file, so they are left out and reported.
"""
import json
import os
import re
import sys

remarks = []


def remark(text):
    if text not in remarks:
        remarks.append(text)


def not_run(name, command):
    remark(f"parameter {name} is what a program prints, which was not run: {command}")


def not_found(package):
    remark(f"package {package} is neither installed nor beside the file: files of it were not read")


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
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{name}/")
        else:
            yield prefix + str(name), as_text(value)


def load_quietly(path, arguments):
    import rosgraph.names
    import roslaunch.config
    import roslaunch.loader
    import roslaunch.substitution_args
    import rospkg

    class Packages(rospkg.RosPack):
        def get_path(self, name):
            near = package_near(os.path.dirname(os.path.abspath(path)), name)
            if near is not None:
                return near
            try:
                return super().get_path(name)
            except rospkg.ResourceNotFound:
                not_found(name)
                return f"/package-not-found/{name}"

    roslaunch.substitution_args._rospack = Packages()
    param_value = roslaunch.loader.Loader.param_value

    def without_commands(self, verbose, name, ptype, value, textfile, binfile, command):
        if command is not None:
            not_run(name, command)
            return ""
        return param_value(self, verbose, name, ptype, value, textfile, binfile, command)

    load_rosparam = roslaunch.loader.Loader.load_rosparam

    def without_dumps(self, context, ros_config, cmd, *rest, **more):
        if cmd == "dump":
            remark('a <rosparam command="dump"> was left out')
            return None
        return load_rosparam(self, context, ros_config, cmd, *rest, **more)

    roslaunch.loader.Loader.param_value = without_commands
    roslaunch.loader.Loader.load_rosparam = without_dumps
    # Without roscore.xml, which brings nodes and parameters of the master.
    roslaunch.config.load_roscore = lambda *_, **__: None
    return roslaunch.config.load_config_default([(path, arguments)], None, assign_machines=False), rosgraph.names


def nodes_of(path, arguments):
    """(name, package, type, namespace, arguments, remaps) of each node, and all parameters."""
    config, names = load_quietly(path, arguments)
    nodes = [(names.ns_join(node.namespace, node.name), node.package, node.type, node.namespace, node.args or "",
              list(node.remap_args)) for node in config.nodes]
    return nodes, {key: parameter.value for key, parameter in config.params.items()}


def resolved_name(name, node, space):
    if name.startswith("~"):
        return node + "/" + name[1:].lstrip("/")
    return name if name.startswith("/") else f"{space.rstrip('/')}/{name}"


def nodes_of_launch(path, arguments):
    nodes, parameters = nodes_of(path, arguments)
    for full, package, kind, space, args, remaps in nodes:
        words = args.split()
        if package == "nodelet" and words and words[0] in ("load", "standalone") and len(words) > 1:
            package, _, kind = words[1].partition("/")
            remaps += [word.split(":=", 1) for word in words[2:] if ":=" in word]
        own = {}
        for word in words:
            if word.startswith("_") and ":=" in word and not word.startswith("__"):
                name, value = word[1:].split(":=", 1)
                own[name] = value
        own = {**{key[len(full) + 1:]: value for key, value in parameters.items() if key.startswith(full + "/")}, **own}
        yield {"name": full, "package": package, "type": kind, "arguments": words, "namespace": space,
               "remaps": {resolved_name(a, full, space): resolved_name(b, full, space) for a, b in remaps},
               "parameters": dict(flat(own))}


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
            yield {"name": name or "/lidar", "package": "", "type": "", "arguments": [], "namespace": "/",
                   "remaps": {}, "parameters": dict(flat(own))}
        else:
            for key, value in inner.items():
                yield from walk(value, name + "/" + str(key).strip("/"))

    yield from walk(content, "")


def main(path, arguments):
    try:
        if path.endswith((".yaml", ".yml")):
            nodes = list(nodes_of_parameters(path))
        else:
            nodes = list(nodes_of_launch(path, arguments))
        answer = {"nodes": nodes, "remarks": remarks}
    except ImportError as missing:
        answer = {"missing": "a launch file is read with roslaunch, a parameter file with Python's yaml, and "
                             f"{missing}; apt install python3-roslaunch python3-yaml"}
    except Exception as trouble:  # whatever roslaunch and its files may raise is an answer for a person
        answer = {"error": " ".join(str(trouble).split()), "remarks": remarks}
    json.dump(answer, sys.stdout)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
