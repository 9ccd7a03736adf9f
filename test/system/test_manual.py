#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""README and manual say what is true: each command in them is run, each configuration is checked, each link leads somewhere.

Commands stand in blocks marked sh, one page's in one folder, in their order; configurations in blocks marked yaml."""
import os
import pathlib
import re
import shlex
import subprocess

from harness import LIDARD, LIDARD_SIM, ROOT, ask, daemon, expect, folder, free_port, ros_master, scene_of, sim, use_master_at, wait_for, write

PICTURES = ROOT / "config/doc/pictures"
PAGES = [ROOT / "README.md", *sorted((ROOT / "config/doc").glob("*.md")), PICTURES / "README.md"]
# Begin of a command: why this test does not run it.
NOT_RUN = {
    "./daemon/demo": "test_demo.py runs what it calls; it would build",
    "./test/run": "this test is a part of it",
    "./config/install-packages": "test/package runs it",
    "sudo editor": "for people; test/package edits the file",
    "cmake": "the build of which this test is a part",
    "sudo cmake --install": "test_install.py installs into a folder",
    "sudo systemctl": "test_systemd.py starts the unit",
    "sudo apt ": "test/package installs it",
    "roslaunch": "test_demo_launch.py starts it",
    "lidard-sim live": "goes on for ever; this test runs one",
    "lidard run": "goes on for ever; this test runs one",
    "sed ": "of the configuration that the package installs",
}
# A vehicle whose sensors are those of lidard-sim on this host.
VEHICLE = """\
sensors:
  front_left: {{model: sick_microscan3, ip_address: 127.168.0.21, ip_port: {port}, listen_only: true, pose: {{xyz: [0, 0, 0.3]}}}}
"""
SENSORS = {"front_left": "model: sick_microscan3, from: '192.168.0.21:6060', to: '127.0.0.1:{port}'"}


def blocks(page, kind):
    return re.findall(rf"^```{kind}\n(.*?)^```", page.read_text(), re.S | re.M)


def check_links(page):
    text = page.read_text()
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", text):
        expect((page.parent / target).exists(), f"{page.name}: nothing is at {target}")
    for path in re.findall(r"`((?:config|daemon|drivers|test|pcaps)/[\w./-]+)`", text):
        expect((ROOT / path).exists(), f"{page.name}: nothing is at {path}")


def check_configuration(page, text, tmp):
    file = tmp / "block.yaml"
    file.write_text(text)
    done = subprocess.run([LIDARD, "check", file], capture_output=True, text=True)
    expect(done.returncode == 0, f"{page.name}: {done.stderr}in\n{text}")
    known = ("another node must publish", "roof is blind")  # the pages say both
    doubts = [line for line in done.stderr.splitlines() if not any(words in line for words in known)]
    expect(not doubts, f"{page.name}: {doubts} in\n{text}")


def run_command(page, line, tmp, environment):
    command = line.split("  #")[0].strip()
    if not command or any(command.startswith(begin) for begin in NOT_RUN):
        return 0
    command = command.replace("sudo ", "").replace("/etc/lidard/lidard.yaml", str(tmp / "lidard.yaml"))
    done = subprocess.run(command, shell=True, cwd=tmp, env=environment, capture_output=True, text=True, timeout=120)
    print(f"{page.name}: {command}: exit {done.returncode}")
    # `discover` says honestly that nobody answers here.
    nobody = command == "lidard discover" and "nothing answered" in done.stderr
    expect(done.returncode == 0 or nobody, f"{page.name}: {command}\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    for option in ("-o", "--bag"):
        words = shlex.split(command)
        if option in words and words[0] == "lidard":
            made = tmp / words[words.index(option) + 1]
            expect(made.exists() and (made.is_dir() or made.stat().st_size > 100), f"{page.name}: {command} made nothing")
    return 1


def check_pictures(tmp, environment):
    """Each picture is what its command makes now, and shows what the list of pictures names."""
    named = dict(re.findall(r"^- `(\w+\.png)`: (.*)$", (PICTURES / "README.md").read_text(), re.M))
    stored = {file.name for file in PICTURES.glob("*.png")}
    expect(set(named) == stored == {file.name for file in tmp.glob("*.png")}, f"pictures {stored}, named {set(named)}")
    for command in re.findall(r"^lidard (?:snapshot|calibrate) .*$", (PICTURES / "README.md").read_text(), re.M):
        name = command.split()[-1]
        # Letters look otherwise where the fonts are others.
        if pathlib.Path("/etc/debian_version").read_text().startswith("12"):
            expect((tmp / name).read_bytes() == (PICTURES / name).read_bytes(), f"{name} is not what `{command}` draws now")
        subprocess.run(command.replace(".png", ".svg"), shell=True, cwd=tmp, env=environment, check=True)
        shown = re.search(r"<desc>(.*?)</desc>", (tmp / name).with_suffix(".svg").read_text(), re.S).group(1)
        missing = [word for word in re.findall(r"`([^`]+)`", named[name]) if not re.search(rf"\b{word}\b", shown)]
        expect(not missing, f"{name} shows no {missing}, but\n{shown}")


def check_page(page, home, vehicle):
    """How many commands were run and configurations checked."""
    check_links(page)
    configurations = blocks(page, "yaml")
    for text in configurations:
        check_configuration(page, text, home)
    with folder() as tmp:
        write(tmp / "lidard.yaml", vehicle)
        for name in ("pcaps", "config", "test"):
            (tmp / name).symlink_to(ROOT / name)
        (tmp / "bin").mkdir()
        for program in (LIDARD, LIDARD_SIM):
            (tmp / "bin" / pathlib.Path(program).name).symlink_to(program)
        environment = dict(os.environ, PATH=f"{tmp}/bin:" + os.environ["PATH"])
        commands = sum(run_command(page, line, tmp, environment) for text in blocks(page, "sh") for line in text.splitlines())
        if page.parent == PICTURES:
            check_pictures(tmp, environment)
    return commands, len(configurations)


def main():
    port, master = free_port(), free_port()
    use_master_at(master)
    with folder() as home, ros_master(master):
        vehicle = VEHICLE.format(port=port)
        scene = write(home / "scene.yaml", scene_of({name: keys.format(port=port) for name, keys in SENSORS.items()}))
        with sim(scene), daemon(write(home / "live.yaml", vehicle)):
            wait_for(lambda: ask("status") and subprocess.run([LIDARD, "status"], capture_output=True, check=False).returncode == 0, 20,
                     "lidard status")
            commands, configurations = map(sum, zip(*(check_page(page, home, vehicle) for page in PAGES)))
    print(f"{len(PAGES)} pages, {commands} commands, {configurations} configurations")
    expect(commands >= 10 and configurations >= 10, "too few commands or configurations were found: are the blocks marked?")
    lines = (ROOT / "README.md").read_text().count("\n")
    expect(lines <= 150, f"README.md has {lines} lines instead of 150 at most")


if __name__ == "__main__":
    main()
