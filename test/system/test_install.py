#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""Installs into a temporary prefix, as any user may, and checks what lies there."""
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree

import rospkg
import yaml

BUILD = pathlib.Path(os.environ["LIDARD"]).parent
SOURCE = pathlib.Path(os.environ["LIDARD_SOURCE_DIR"])


def install(prefix, destdir=None):
    environment = dict(os.environ)
    environment.pop("DESTDIR", None)
    if destdir:
        environment["DESTDIR"] = str(destdir)
    done = subprocess.run(["cmake", "--install", str(BUILD), "--prefix", str(prefix)], env=environment,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(done.stdout)


class Installation(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="lidard-install-"))
        cls.prefix = cls.folder / "prefix"
        install(cls.prefix)

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def text(self, name):
        return (self.prefix / name).read_text()

    def test_the_program_lies_where_ros_and_people_look_for_it(self):
        self.assertTrue(os.access(self.prefix / "bin/lidard", os.X_OK))
        for name in ("lidard", "velodyne_node", "laserscan_multi_merger", "laserscan_virtualizer",
                     "sick_safetyscanners_node", "urg_node"):
            for folder in ("lib/lidard", "share/lidard"):
                link = self.prefix / folder / name
                self.assertTrue(link.is_symlink())
                self.assertEqual(link.resolve(), (self.prefix / "bin/lidard").resolve())

    def test_ros_finds_the_package(self):
        packages = rospkg.RosPack(ros_paths=[str(self.prefix / "share")])
        self.assertEqual(packages.get_path("lidard"), str(self.prefix / "share/lidard"))
        self.assertEqual(packages.get_manifest("lidard").license, "BSD-3-Clause")

    def test_the_launch_file_names_what_is_installed(self):
        launch = xml.etree.ElementTree.parse(self.prefix / "share/lidard/launch/lidard.launch")
        node = launch.find("node")
        self.assertEqual((node.get("pkg"), node.get("type")), ("lidard", "lidard"))
        self.assertTrue(node.get("args").startswith("run -c "))
        text = self.text("share/lidard/launch/lidard.launch")
        for name in ("config/demo.yaml", "rviz/lidard.rviz"):
            self.assertIn("$(find lidard)/" + name, text)
            self.assertTrue((self.prefix / "share/lidard" / name).exists(), name)

    def test_the_launch_files_of_velodynes_start_what_is_installed(self):
        for name in ("VLP16_points", "VLP-32C_points", "32e_points", "VLS128_points", "64e_S3"):
            node = xml.etree.ElementTree.parse(self.prefix / f"share/lidard/launch/{name}.launch").find("node")
            self.assertEqual((node.get("pkg"), node.get("type")), ("lidard", "velodyne_node"))

    def test_the_launch_files_of_ira_laser_tools_start_what_is_installed(self):
        for name in ("laserscan_multi_merger", "laserscan_virtualizer"):
            node = xml.etree.ElementTree.parse(self.prefix / f"share/lidard/launch/{name}.launch").find("node")
            self.assertEqual((node.get("pkg"), node.get("type")), ("lidard", name))
            self.assertTrue(os.access(self.prefix / "lib/lidard" / name, os.X_OK))

    def test_roslaunch_finds_the_executables(self):
        environment = {**os.environ, "ROS_PACKAGE_PATH": f"{self.prefix}/share"}
        for name in ("laserscan_multi_merger", "laserscan_virtualizer"):
            done = subprocess.run(["/usr/bin/python3", "-c", "import sys, roslib.packages; print(*roslib.packages.find_node('lidard', "
                                   "sys.argv[1]))", name], env=environment, stdout=subprocess.PIPE, text=True, check=True)
            self.assertEqual(done.stdout.split(), [f"{self.prefix}/share/lidard/{name}"])

    def test_the_rviz_file_shows_topics_of_the_demo_vehicle(self):
        rviz = yaml.safe_load(self.text("share/lidard/rviz/lidard.rviz"))
        displays = [d for d in rviz["Visualization Manager"]["Displays"] if "Topic" in d]
        topics = {d["Topic"] for d in displays if d["Enabled"]}
        self.assertEqual({d["Topic"] for d in displays if not d["Enabled"]}, {"/around"})  # the manual's merged cloud
        demo = yaml.safe_load(self.text("share/lidard/config/demo.yaml"))
        frames = {f for group in demo["virtual_scans"].values() for f in group["virtual_laser_scan"]}
        names = set(demo["sensors"]) | set(demo["merged_scans"]) | frames
        names |= {name for merged in demo["merged_scans"].values() for name in merged["also"]}
        for topic in topics:
            self.assertIn(topic.strip("/").split("/")[0], names | {"footprint"})

    def test_systemd_accepts_the_unit(self):
        for name, instance in (("lidard.service", ""), ("lidard@.service", "rear")):
            unit = self.prefix / "lib/systemd/system" / name
            self.assertEqual([line for line in unit.read_text().splitlines() if "@" in line and "SystemCallFilter" not in line], [])
            done = subprocess.run(["systemd-analyze", "verify", "--man=no", str(unit).replace("@", "@" + instance)],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
            complaints = [line for line in done.stdout.splitlines() if "lidard" in line]
            self.assertEqual(complaints, [])
            self.assertEqual(done.returncode, 0, done.stdout)

    def test_several_daemons_are_told_apart(self):
        lines = self.text("lib/systemd/system/lidard@.service").splitlines()
        self.assertIn(f"ExecStart={self.prefix}/bin/lidard run -c {self.prefix}/etc/lidard/%i.yaml __name:=lidard_%i", lines)
        self.assertIn("RuntimeDirectory=lidard-%i", lines)

    def test_the_environment_is_a_sample_that_sets_nothing(self):
        lines = self.text("etc/default/lidard").splitlines()
        self.assertEqual([line for line in lines if line and not line.startswith("#")], [])
        self.assertIn(f"EnvironmentFile=-{self.prefix}/etc/default/lidard", self.text("lib/systemd/system/lidard.service").splitlines())

    def test_the_unit_runs_the_installed_program_with_the_installed_configuration(self):
        lines = self.text("lib/systemd/system/lidard.service").splitlines()
        self.assertIn(f"ExecStart={self.prefix}/bin/lidard run -c {self.prefix}/etc/lidard/lidard.yaml", lines)
        for line in ("Type=notify", "DynamicUser=yes", "Environment=ROS_LOG_DIR=%t/lidard",
                     "RestartPreventExitStatus=2 78"):
            self.assertIn(line, lines)
        done = subprocess.run([self.prefix / "bin/lidard", "check", self.prefix / "etc/lidard/lidard.yaml"],
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
        self.assertEqual(done.returncode, 78, done.stdout)
        self.assertIn("lidard.yaml:1:1: the file has no sensors; expected sensors: with at least one entry", done.stdout)

    def test_the_receive_buffer_may_grow(self):
        self.assertIn("net.core.rmem_max=16777216", self.text("lib/sysctl.d/60-lidard.conf").splitlines())

    def test_documentation_that_exists_is_installed(self):
        for source, installed in (("daemon/lidard.8", "share/man/man8/lidard.8"),
                                  ("daemon/lidard.yaml.5", "share/man/man5/lidard.yaml.5"),
                                  ("daemon/completion.bash", "share/bash-completion/completions/lidard"),
                                  ("daemon/completion.zsh", "share/zsh/vendor-completions/_lidard"),
                                  ("test/sim/lidard-sim.1", "share/man/man1/lidard-sim.1")):
            self.assertEqual((SOURCE / source).exists(), (self.prefix / installed).exists(), source)

    def test_zsh_completes_the_commands_and_options_that_the_help_names(self):
        if not shutil.which("zsh"):
            self.skipTest("zsh is not installed")
        script = """
            functions[complete]="$(<$1)"
            _describe() { print -l -- "${(@)${(@P)2}%%:*}" }
            compadd() { [[ $1 == -a ]] && print -l -- "${(@P)2}" || print -l -- "${@:#--}" }
            PREFIX=$2; shift 2; words=("$@" ""); CURRENT=${#words}
            complete
        """

        def offered(prefix, *words):
            path = f"{self.prefix}/bin:{os.environ['PATH']}"
            done = subprocess.run(["zsh", "-fc", script, "zsh", self.prefix / "share/zsh/vendor-completions/_lidard", prefix, *words],
                                  env={**os.environ, "PATH": path}, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
            return set(done.stdout.split())

        self.assertLessEqual({"run", "replay", "snapshot", "discover", "status"}, offered("", "lidard"))
        self.assertLessEqual({"--pcap", "--loop", "--bag", "--config"}, offered("--", "lidard", "replay"))
        self.assertIn("velodyne_vlp16", offered("", "lidard", "decode", "--model"))
        self.assertEqual({"height", "intensity"}, offered("", "lidard", "snapshot", "--color"))

    def test_a_configuration_that_was_edited_stays(self):
        other = self.folder / "other"
        install(other)
        config = other / "etc/lidard/lidard.yaml"
        config.write_text("# mine\n")
        install(other)
        self.assertEqual(config.read_text(), "# mine\n")

    def test_the_system_prefix_keeps_its_configuration_in_etc(self):
        stage = self.folder / "stage"
        install("/usr", stage)
        self.assertTrue((stage / "etc/lidard/lidard.yaml").exists())
        self.assertTrue((stage / "usr/bin/lidard").exists())
        self.assertTrue((stage / "usr/lib/lidard/laserscan_multi_merger").is_symlink())
        self.assertFalse((stage / "usr/share/lidard/laserscan_multi_merger").is_symlink(), "rosrun would find two")
        unit = (stage / "usr/lib/systemd/system/lidard.service").read_text()
        self.assertIn("ExecStart=/usr/bin/lidard run -c /etc/lidard/lidard.yaml", unit)


if __name__ == "__main__":
    unittest.main(verbosity=2)
