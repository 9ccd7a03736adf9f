#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""What a launch file or a parameter file asks for, as JSON for `lidard import`.

roslaunch itself resolves arguments, conditions, includes and names. Where it is not installed PlainLaunch does, which
knows all of these but $(eval ...) and what names a file of a package that is nowhere near. Nothing is started: a
<param command="..."> and a <rosparam command="dump"> would run a program or write a file, so they are left out and told.
"""
import json
import os
import re
import sys
import xml.etree.ElementTree

remarks = []


def remark(text):
    if text not in remarks:
        remarks.append(text)


def not_run(name, command):
    remark(f"parameter {name} is what a program prints, which was not run: {command}")


def not_found(package):
    remark(f"package {package} is neither installed nor beside the file: files of it were not read")


DUMP = 'a <rosparam command="dump"> was left out'


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
            remark(DUMP)
            return None
        return load_rosparam(self, context, ros_config, cmd, *rest, **more)

    roslaunch.loader.Loader.param_value = without_commands
    roslaunch.loader.Loader.load_rosparam = without_dumps
    # Without roscore.xml, which brings nodes and parameters of the master.
    roslaunch.config.load_roscore = lambda *_, **__: None
    return roslaunch.config.load_config_default([(path, arguments)], None, assign_machines=False), rosgraph.names


class PlainLaunch:
    """Reads launch files as https://wiki.ros.org/roslaunch/XML describes them."""

    def __init__(self, path, arguments):
        self.path, self.nodes, self.parameters, self.depth = path, [], {}, 0
        given = dict(word.split(":=", 1) for word in arguments)
        self.read(path, "/", {}, given, [])

    def read(self, path, space, args, given, remaps):
        if self.depth == 50:
            raise ValueError(f"{path} is included 50 files deep; does it include itself?")
        root = xml.etree.ElementTree.parse(path).getroot()
        self.depth += 1
        self.walk(root, {"folder": os.path.dirname(os.path.abspath(path)), "space": space, "args": args, "given": given,
                         "remaps": remaps, "node": ""})
        self.depth -= 1

    def substitute(self, text, scope):
        def value(match):
            kind, _, rest = match.group(1).strip().partition(" ")
            name, _, otherwise = rest.strip().partition(" ")
            if kind == "arg":
                if name not in scope["args"]:
                    raise ValueError(f"requires the '{name}' arg to be set: {name}:=VALUE")
                return scope["args"][name]
            if kind == "find":
                near = package_near(os.path.dirname(os.path.abspath(self.path)), name)
                if near is None:
                    not_found(name)
                return near or f"/package-not-found/{name}"
            if kind == "dirname":
                return scope["folder"]
            if kind == "anon":
                return name
            if kind in ("env", "optenv") and (kind == "optenv" or name in os.environ):
                return os.environ.get(name, otherwise)
            raise ValueError(f"$({match.group(1)}) is resolved by roslaunch alone; apt install python3-roslaunch")

        return re.sub(r"\$\(([^()]*)\)", value, text)

    def attribute(self, element, name, scope, otherwise=None):
        return self.substitute(element.attrib[name], scope) if name in element.attrib else otherwise

    def is_wanted(self, element, scope):
        def flag(name, otherwise):
            text = self.attribute(element, name, scope, otherwise).strip().lower()
            if text not in ("true", "false", "1", "0"):
                raise ValueError(f"{name}=\"{text}\" is neither true nor false")
            return text in ("true", "1")

        return flag("if", "true") and not flag("unless", "false")

    def walk(self, parent, scope):
        for element in parent:
            handle = getattr(self, f"do_{element.tag}", None) if isinstance(element.tag, str) else None
            if handle and self.is_wanted(element, scope):
                handle(element, scope)

    @staticmethod
    def below(space, name):
        return name if name.startswith("/") else f"{space.rstrip('/')}/{name}"

    def inner(self, element, scope, **more):
        space = self.below(scope["space"], self.attribute(element, "ns", scope, "")).rstrip("/") + "/"
        return {**scope, "space": space, "remaps": list(scope["remaps"]), **more}

    def do_arg(self, element, scope):
        name = self.attribute(element, "name", scope)
        fixed, preset = self.attribute(element, "value", scope), self.attribute(element, "default", scope)
        value = fixed if fixed is not None else scope["given"].get(name, preset)
        if value is not None:
            scope["args"][name] = value

    def do_group(self, element, scope):
        self.walk(element, self.inner(element, scope, args=dict(scope["args"])))

    def do_include(self, element, scope):
        path = self.attribute(element, "file", scope)
        given = dict(scope["args"]) if self.attribute(element, "pass_all_args", scope, "false") == "true" else {}
        for arg in element.findall("arg"):
            if self.is_wanted(arg, scope):
                value = self.attribute(arg, "value", scope, self.attribute(arg, "default", scope))
                given[self.attribute(arg, "name", scope)] = value
        inner = self.inner(element, scope)
        self.read(path, inner["space"], {}, given, inner["remaps"])

    def do_remap(self, element, scope):
        scope["remaps"].append((self.attribute(element, "from", scope), self.attribute(element, "to", scope)))

    def do_node(self, element, scope):
        inner = self.inner(element, scope)
        name = self.attribute(element, "name", scope)
        inner["node"] = self.below(inner["space"], name)
        self.walk(element, inner)
        self.nodes.append((inner["node"], self.attribute(element, "pkg", scope), self.attribute(element, "type", scope),
                           inner["space"], self.attribute(element, "args", scope, ""), inner["remaps"]))

    def full_name(self, name, scope):
        return self.below(scope["node"] or scope["space"], name.lstrip("~"))

    def do_param(self, element, scope):
        name = self.full_name(self.attribute(element, "name", scope), scope)
        if "command" in element.attrib:
            not_run(name, element.attrib["command"])
            self.parameters[name] = ""
        elif "textfile" in element.attrib or "binfile" in element.attrib:
            remark(f"parameter {name} is the content of a file, which was not read")
        else:
            self.parameters[name] = typed(self.attribute(element, "value", scope, ""), element.attrib.get("type", "auto"))

    def do_rosparam(self, element, scope):
        import yaml

        command = self.attribute(element, "command", scope, "load")
        if command != "load":
            if command == "dump":
                remark(DUMP)
            return
        text, path = element.text or "", self.attribute(element, "file", scope)
        if path is not None:
            with open(path, encoding="utf-8-sig") as file:
                text = file.read()
        if self.attribute(element, "subst_value", scope, "false") == "true":
            text = self.substitute(text, scope)
        content, name = yaml.safe_load(text), self.attribute(element, "param", scope)
        space = self.inner(element, {**scope, "space": scope["node"] or scope["space"]})["space"]
        if name is not None:
            content = {name: content}
        for key, value in (content or {}).items():
            self.parameters[self.below(space, str(key).lstrip("~"))] = value


def typed(text, kind):
    """A value as roslaunch stores it."""
    for reader in {"auto": (int, float), "int": (int,), "double": (float,)}.get(kind, ()):
        try:
            return reader(text)
        except ValueError:
            pass
    if kind in ("auto", "bool", "boolean") and text.strip().lower() in ("true", "false"):
        return text.strip().lower() == "true"
    return text


def resolved_name(name, node, space):
    if name.startswith("~"):
        return node + "/" + name[1:].lstrip("/")
    return PlainLaunch.below(space, name)


def nodes_of(path, arguments):
    """(name, package, type, namespace, arguments, remaps) of each node, and all parameters."""
    try:
        import roslaunch  # noqa: F401
    except ImportError:
        plain = PlainLaunch(path, arguments)
        remark("read without roslaunch, which is not installed")
        return plain.nodes, plain.parameters
    config, names = load_quietly(path, arguments)
    nodes = [(names.ns_join(node.namespace, node.name), node.package, node.type, node.namespace, node.args or "",
              list(node.remap_args)) for node in config.nodes]
    return nodes, {key: parameter.value for key, parameter in config.params.items()}


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
        answer = {"missing": f"parameter files are read with Python's yaml, and {missing}; apt install python3-yaml"}
    except Exception as trouble:  # whatever roslaunch and its files may raise is an answer for a person
        answer = {"error": " ".join(str(trouble).split()), "remarks": remarks}
    json.dump(answer, sys.stdout)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2:])
