# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Where test/mutate builds and runs: a private copy of the source tree with a build folder of its own."""
import collections
import fcntl
import hashlib
import json
import os
import pathlib
import re
import resource
import shlex
import shutil
import signal
import subprocess
import threading

LAYERS = ("core", "drivers", "daemon", "test/sim")
MEMORY = 8 << 30  # bytes that a process may hold: a fault can make a loop that allocates
TEST = re.compile(r"^\s*(?:TYPED_)?TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)\)", re.MULTILINE)
Outcome = collections.namedtuple("Outcome", "state test")  # equivalent, refused, noticed, survived
Stage = collections.namedtuple("Stage", "program filter seconds")


class BuildFailed(Exception):
    pass


class Processes:
    """What runs now, so that all of it can be ended."""

    def __init__(self):
        self.lock, self.running, self.ended = threading.Lock(), set(), False

    def run(self, command, cwd, limit=None, environment=None):
        """(exit code, output); the code is None after `limit` seconds of the processor, or ten times as long."""
        with self.lock:
            if self.ended:
                raise KeyboardInterrupt
            process = subprocess.Popen(command, cwd=cwd, env=environment, stdin=subprocess.DEVNULL,
                                       stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                       preexec_fn=lambda: set_apart(limit))
            self.running.add(process)
        try:
            output, _ = process.communicate(timeout=limit and 10 * limit)
            code = None if process.returncode == -signal.SIGXCPU else process.returncode
            return code, output.decode(errors="replace")
        except subprocess.TimeoutExpired:
            self.kill(process)
            output, _ = process.communicate()
            return None, output.decode(errors="replace")
        finally:
            with self.lock:
                self.running.discard(process)

    @staticmethod
    def kill(process):
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass

    def end(self):
        with self.lock:
            self.ended = True
            for process in self.running:
                self.kill(process)


def set_apart(limit):
    """A group of its own, to be killed as a whole; no session, which Linux would give a share of the processor.

    The limit counts the processor's seconds: a busy machine is no fault that a test has noticed."""
    os.setpgrp()
    if limit:
        resource.setrlimit(resource.RLIMIT_CPU, (int(limit) + 1, int(limit) + 2))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))


def layer_of(name):
    for layer in LAYERS:
        if name.startswith(layer + "/"):
            return layer
    raise BuildFailed(f"{name} is in none of the layers {', '.join(LAYERS)}")


def program_of(layer):
    return "test_" + layer.split("/")[-1]


def copy_tree(root, copy):
    """Makes `copy` hold the files of `root`; those that are the same keep their times: they are not built anew."""
    wanted = set()
    for folder, folders, files in os.walk(root):
        top = pathlib.Path(folder) == root
        folders[:] = [f for f in folders if f not in (".git", "__pycache__") and not (top and f.startswith("build"))]
        for name in files:
            source = pathlib.Path(folder, name)
            if name == ".git" or not source.is_file():
                continue
            target = copy / source.relative_to(root)
            wanted.add(target)
            if target.exists() and target.read_bytes() == source.read_bytes():
                continue
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target)
            shutil.copymode(source, target)
    for folder, folders, files in os.walk(copy):
        if pathlib.Path(folder) == copy:
            folders[:] = [f for f in folders if f != "build"]
        for name in files:
            if pathlib.Path(folder, name) not in wanted and name != "lock":
                pathlib.Path(folder, name).unlink()


class Bench:
    def __init__(self, root, work, options, jobs):
        self.root, self.work, self.build, self.jobs = root, work, work / "build", jobs
        self.processes = Processes()
        self.options, self.commands, self.links, self.clean, self.tests = options, {}, {}, {}, {}
        self.modules = {}  # how they are linked
        work.mkdir(parents=True, exist_ok=True)
        self.lock = open(work / "lock", "w")
        try:
            fcntl.flock(self.lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise BuildFailed(f"{work} is used by another run; name another folder with --work") from None

    def checked(self, command, what):
        code, output = self.processes.run(command, self.build)
        if code != 0:
            raise BuildFailed(f"{what} failed:\n{output[-3000:]}")
        return output

    def prepare(self, targets):
        copy_tree(self.root, self.work)
        shutil.rmtree(self.build / "faults", ignore_errors=True)
        self.build.mkdir(exist_ok=True)
        link = ["-DCMAKE_EXE_LINKER_FLAGS=-fuse-ld=lld"] if shutil.which("ld.lld") else []
        self.checked(["cmake", "-S", "..", "-B", ".", "-G", "Ninja", "-DLIDARD_WERROR=ON", "-DLIDARD_UNITY=OFF", *link, *self.options],
                     "cmake")
        self.checked(["ninja", f"-j{self.jobs}", *targets], "the build of " + ", ".join(targets))
        for entry in json.loads((self.build / "compile_commands.json").read_text()):
            path = pathlib.Path(entry["file"])
            if path.is_relative_to(self.work):
                self.commands[str(path.relative_to(self.work))] = shlex.split(entry["command"])
        for target in targets:
            self.links[target] = self.link_command(target)
        for module in self.build.glob("*.so"):
            self.modules[module.name] = self.link_command(module.name)

    def link_command(self, target):
        last = self.checked(["ninja", "-t", "commands", target], "ninja").strip().splitlines()[-1]
        for part in re.split(r"&&", last):
            words = shlex.split(part)
            if "-o" in words and words[words.index("-o") + 1] == target:
                return words
        raise BuildFailed(f"ninja names no link command for {target}")

    def tests_of(self, program, sources):
        """The names of the tests in some sources, as the built program lists them."""
        if program not in self.tests:
            listed = self.checked([f"./{program}", "--gtest_list_tests"], program)
            names, suite = [], ""
            for line in listed.splitlines():
                word = line.split("#")[0].rstrip()
                if word.endswith(".") and not line.startswith(" "):
                    suite = word
                elif line.startswith("  "):
                    names.append(suite + word.strip())
            self.tests[program] = names
        wanted = {pair for source in sources for pair in TEST.findall(source.read_text())}
        return [name for name in self.tests[program] if plain_name(name) in wanted]

    def seconds_of(self, program):
        """How long each test takes, from one run without a fault; tests that fail then are missing."""
        digest = hashlib.sha256((self.build / program).read_bytes()).hexdigest()
        kept = self.build / f"{program}.seconds.json"
        if kept.exists():
            known = json.loads(kept.read_text())
            if known["program"] == digest:
                return known["seconds"]
        report = self.build / f"{program}.report.json"
        report.unlink(missing_ok=True)
        self.processes.run([f"./{program}", f"--gtest_output=json:{report}"], self.build)
        if not report.exists():
            raise BuildFailed(f"{program} did not end without any fault")
        seconds = {}
        for suite in json.loads(report.read_text())["testsuites"]:
            for test in suite["testsuite"]:
                if "failures" not in test:
                    seconds[f"{suite['name']}.{test['name']}"] = float(test["time"].rstrip("s"))
        kept.write_text(json.dumps({"program": digest, "seconds": seconds}))
        return seconds

    def stages_for(self, name, above):
        """The tests for a file, nearest first: those that include its header or mirror it, its room's, the rest."""
        layer = layer_of(name)
        program, path = program_of(layer), pathlib.Path(name)
        header = re.compile(rf'^#include "{re.escape(str(path.with_suffix(".h")))}"', re.MULTILINE)
        folder = "test/" + layer.split("/")[-1]
        tests = [p for p in (self.work / folder).rglob("*_test.cpp")]
        room = self.work / folder / path.parent.relative_to(layer)
        near = [p for p in tests if p.stem == path.stem + "_test" or header.search(p.read_text())]
        parts = [self.tests_of(program, near), self.tests_of(program, [p for p in tests if p.parent == room])]
        parts.append(self.tests_of(program, []) or self.tests[program])
        known, done, stages = self.seconds_of(program), set(), []
        for part in parts:
            part = [test for test in part if test in known and test not in done]
            done |= set(part)
            if part:
                # The quick ones first: most faults are noticed by them.
                stages.append(Stage(program, part, sum(known[test] for test in part)))
        for other in above:
            known = self.seconds_of(other)
            stages.append(Stage(other, sorted(known), sum(known.values())))
        return stages

    def objects_for(self, name):
        """The sources that must be compiled anew for a file: itself, or who includes the header."""
        if name.endswith(".cpp"):
            return [name]
        layer = layer_of(name)
        listed = self.checked(["ninja", "-t", "deps"], "ninja")
        users, target = [], ""
        for line in listed.splitlines():
            if line and not line.startswith(" "):
                target = line.split(":")[0]
            elif line.strip().endswith("/" + name):
                users.append(re.sub(r"^CMakeFiles/\w+\.dir/|\.o$", "", target))
        directly = f'#include "{name}"'
        return [u for u in dict.fromkeys(users) if u in self.commands and
                (u.startswith(layer + "/") or u.startswith("test/" + layer.split("/")[-1] + "/") and
                 directly in (self.work / u).read_text())]

    def compile(self, source, folder, changed):
        """The object of `source` in `folder`, with the changed file in place; None: does not compile."""
        words = [w for w in self.commands[source] if w not in ("-Werror", "-g")]
        output = folder / (source + ".o")
        output.parent.mkdir(parents=True, exist_ok=True)
        mine = changed if changed.name == pathlib.Path(source).name else self.work / source
        words[words.index("-o") + 1] = str(output)
        words[-1] = str(mine)
        launcher = next(i for i, word in enumerate(words) if not word.endswith("ccache"))
        words[launcher + 1:launcher + 1] = [f"-I{folder}", "-w", "-g0"]
        code, _ = self.processes.run(words, self.build, 300)
        return output if code == 0 else None

    def unchanged(self, source):
        if source not in self.clean:
            folder = self.build / "clean"
            output = self.compile(source, folder, self.work / source)
            if not output:
                raise BuildFailed(f"{source} does not compile without any fault")
            self.clean[source] = output.read_bytes()
        return self.clean[source]

    def compile_fault(self, source, fault):
        """(folder, objects) of a fault, or an Outcome: refused by the compiler, equivalent."""
        text = source.text[:fault.begin] + fault.text + source.text[fault.end:]
        folder = self.build / "faults" / hashlib.sha256((fault.file + text).encode()).hexdigest()[:16]
        changed = folder / fault.file
        changed.parent.mkdir(parents=True, exist_ok=True)
        changed.write_text(text)
        objects, same = [], True
        for each in self.objects_for(fault.file):
            output = self.compile(each, folder, changed)
            if not output:
                shutil.rmtree(folder)
                return Outcome("refused", "")
            same = same and output.read_bytes() == self.unchanged(each)
            objects.append(output)
        if same:
            shutil.rmtree(folder)
            return Outcome("equivalent", "")
        return folder, objects

    def link(self, program, folder, objects):
        changed = {str(o.relative_to(folder)): str(o) for o in objects}
        of_modules = set()
        for module, usual in self.modules.items():  # which a program loads from its own folder
            words = [changed.get(source_of(word), word) for word in usual]
            of_modules |= changed.keys() & set(map(source_of, usual))
            (folder / module).unlink(missing_ok=True)
            if words == usual:
                (folder / module).symlink_to(self.build / module)
            else:
                words[words.index("-o") + 1] = str(folder / module)
                self.run_linker(module, words)
        objects = [o for o in objects if str(o.relative_to(folder)) not in of_modules]
        words = list(self.links[program])
        words[words.index("-o") + 1] = str(folder / program)
        # The changed objects come first: then nobody looks into the library for them. Test sources have others.
        tests = {str(o.relative_to(folder)) for o in objects if o.relative_to(folder).parts[0] == "test"}
        words = [w for w in words if source_of(w) not in tests]
        compiler = next(i for i, word in enumerate(words) if not word.endswith("ccache"))
        words[compiler + 1:compiler + 1] = [*map(str, objects), "-Wl,-s"]
        self.run_linker(program, words)

    def run_linker(self, product, words):
        code, output = self.processes.run(words, self.build, 300)
        if code != 0:
            raise BuildFailed(f"{product} does not link with a fault:\n{output[-2000:]}")

    def try_fault(self, folder, objects, stages, scripts):
        """Runs the stages until a test fails."""
        linked = set()
        try:
            for stage in stages:
                if stage.program not in linked:
                    self.link(stage.program, folder, objects)
                    linked.add(stage.program)
                failed = self.run_tests(folder / stage.program, stage)
                if failed:
                    return Outcome("noticed", failed)
            for program in ("lidard", "lidard-sim") if scripts else ():
                self.link(program, folder, objects)
            for script in scripts:
                if not self.run_script(script, folder):
                    return Outcome("noticed", "system." + pathlib.Path(script).stem)
            return Outcome("survived", "")
        finally:
            shutil.rmtree(folder, ignore_errors=True)

    def run_tests(self, program, stage):
        limit = 20 + 6 * stage.seconds
        # Filters are long: not on the command line.
        environment = dict(os.environ, GTEST_FILTER=":".join(stage.filter), GTEST_FAIL_FAST="1", GTEST_COLOR="no")
        code, output = self.processes.run([program], self.build, limit, environment)
        if code == 0:
            return None
        failed = re.search(r"^\[  FAILED  \] ([\w./]+)", output, re.MULTILINE)
        if failed and code is not None:
            return failed[1]
        started = re.findall(r"^\[ RUN      \] ([\w./]+)", output, re.MULTILINE)
        return (started[-1] if started else program.name) + (" (time limit)" if code is None else " (crash)")

    def run_script(self, script, folder):
        environment = dict(os.environ, LIDARD=str(folder / "lidard"), LIDARD_SIM=str(folder / "lidard-sim"),
                           LIDARD_CLOCK_SHIM=str(self.build / "libclock_shim.so"), LIDARD_SOURCE_DIR=str(self.work))
        code, _ = self.processes.run(["/usr/bin/python3", script], self.build, 300, environment)
        return code in (0, 77)

    def nearest_scripts(self, name, count):
        """The system tests that speak most of the words of a file's name."""
        words = [w for w in re.split(r"[/_.]", name) if len(w) > 4 and w not in LAYERS]
        rated = []
        for script in sorted((self.work / "test/system").glob("test_*.py")):
            text = script.read_text().lower()
            rated.append((-sum(min(text.count(word), 20) for word in words), str(script)))
        return [script for _, script in sorted(rated)[:count]]


def source_of(word):
    """The object of a linker's command without its target's folder: path/name.cpp.o; None: no object."""
    return word.split(".dir/", 1)[-1] if word.startswith("CMakeFiles/") else None


def plain_name(name):
    """(suite, test) of a test's name without its parameters and the prefix of its instance."""
    parts = name.split(".")
    suite, test = parts[0].split("/"), parts[1].split("/")
    return (suite[1] if len(suite) > 1 and not suite[1].isdigit() else suite[0], test[0])
