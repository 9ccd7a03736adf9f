#!/usr/bin/python3
# SPDX-FileCopyrightText: 2026 the lidard authors
# SPDX-License-Identifier: BSD-3-Clause
"""The Debian packages of this build, without debug symbols, and the libraries that other programs decode with. `test/package`
installs them on a bare Debian."""
import collections
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest

BUILD = pathlib.Path(os.environ["LIDARD"]).parent
SOURCE = pathlib.Path(os.environ["LIDARD_SOURCE_DIR"])
CAPTURE = SOURCE / "pcaps/vlp16_dual.pcap"
LARGEST = 5_000_000


def run(*command, **options):
    done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False,
                          **options)
    return done.returncode, done.stdout


def must_run(*command, **options):
    code, text = run(*command, **options)
    if code != 0:
        raise RuntimeError(f"{command}: exit {code}\n{text}")
    return text


class Packages(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="lidard-package-"))
        must_run("cpack", "-G", "DEB", "-B", cls.folder, "-D", "CPACK_DEBIAN_DEBUGINFO_PACKAGE=OFF", "-D", "CPACK_STRIP_FILES=ON",
                 cwd=BUILD)
        cls.files = {path.name.split("_")[0]: path for path in cls.folder.glob("*.deb")}

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def unpacked(self, package):
        target = self.folder / f"{package}.d"
        if not target.exists():
            must_run("dpkg-deb", "-R", self.files[package], target)
        return target

    def depends(self, package):
        fields = must_run("dpkg-deb", "-f", self.files[package], "Depends")
        return {part.split()[0] for part in fields.split(",")}

    def test_there_is_a_package_for_the_vehicle_and_one_for_each_extra(self):
        self.assertEqual(set(self.files), {"lidard", "lidard-pcl", "lidard-sim", "liblidard-dev", "python3-lidard"})
        self.assertLess(self.files["lidard"].stat().st_size, LARGEST)

    @unittest.skipUnless(run("unshare", "--mount", "true")[0] == 0, "no right to hide a tool in a namespace")
    def test_packages_that_would_depend_on_nothing_are_not_made(self):
        hide = """mount -t tmpfs none "$3" && cd "$3" && mkdir upper work
                  mount -t overlay -o "lowerdir=/usr/bin,upperdir=$3/upper,workdir=$3/work" none /usr/bin
                  rm "/usr/bin/$0" && cd "$1" && exec cpack -G DEB -B "$2" """
        for missing in ("dpkg-shlibdeps", "file"):
            with self.subTest(missing), tempfile.TemporaryDirectory(prefix="lidard-tools-") as folder:
                packages, layers = pathlib.Path(folder, "packages"), pathlib.Path(folder, "layers")
                layers.mkdir()
                code, text = run("unshare", "--mount", "sh", "-ec", hide, missing, BUILD, packages, layers)
                self.assertNotEqual(code, 0)
                self.assertIn(f"{missing} is missing", text)
                self.assertFalse(list(packages.glob("*.deb")))

    def test_the_package_for_the_vehicle_is_whole(self):
        root = self.unpacked("lidard")
        for name in ("usr/bin/lidard", "usr/lib/lidard/velodyne_node", "usr/lib/lidard/free_area",
                     "usr/lib/lidard/read_launch.py", "usr/lib/systemd/system/lidard.service",
                     "usr/lib/systemd/system/lidard@.service", "usr/lib/sysctl.d/60-lidard.conf", "usr/share/man/man8/lidard.8.gz",
                     "usr/share/man/man5/lidard.yaml.5.gz", "usr/share/bash-completion/completions/lidard",
                     "usr/share/zsh/vendor-completions/_lidard", "usr/share/lidard/launch/demo.launch",
                     "usr/share/lidard/rviz/lidard.rviz", "usr/share/lidard/config/demo.yaml", "usr/share/lidard/pcaps/demo.pcap",
                     "usr/share/lidard/package.xml", "usr/share/doc/lidard/copyright", "usr/share/doc/lidard/README.md",
                     "usr/share/doc/lidard/config/KEYS.md", "usr/share/doc/lidard/config/doc/pictures/demo.png"):
            self.assertTrue((root / name).exists(), name)
        self.assertEqual((root / "DEBIAN/conffiles").read_text().split(), ["/etc/default/lidard", "/etc/lidard/lidard.yaml"])

    def test_the_manual_is_whole_and_its_links_lead_to_installed_pages(self):
        folder = self.unpacked("lidard") / "usr/share/doc/lidard"
        pages = [folder / "README.md", *(folder / "config/doc").glob("*.md")]
        self.assertEqual({page.name for page in pages[1:]}, {page.name for page in (SOURCE / "config/doc").glob("*.md")})
        for page in pages:
            for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text()):
                self.assertTrue((page.parent / target).exists(), f"{page.name}: nothing is at {target}")

    def test_the_installed_size_is_what_is_installed(self):
        for package, file in self.files.items():
            said = int(must_run("dpkg-deb", "-f", file, "Installed-Size"))
            root = self.unpacked(package)
            paths = [path for path in root.rglob("*") if path.relative_to(root).parts[0] != "DEBIAN"]
            files = [path for path in paths if path.is_symlink() or path.is_file()]
            # deb-substvars(5): files and links in KiB, each rounded up, and 1 KiB for anything else.
            size = sum((path.lstat().st_size + 1023) // 1024 for path in files) + len(paths) - len(files)
            self.assertEqual(said, size, package)
            self.assertEqual(root.stat().st_mode & 0o777, 0o755, "the root of the package")

    def test_programs_are_stripped(self):
        for package, name in (("lidard", "usr/bin/lidard"), ("lidard", "usr/lib/lidard/modules/lidard_bags.so"),
                              ("lidard", "usr/lib/lidard/modules/lidard_pictures.so"), ("lidard-sim", "usr/bin/lidard-sim"),
                              ("lidard-pcl", "usr/lib/lidard/modules/lidard_pcl.so"),
                              ("lidard-pcl", "usr/lib/lidard/modules/lidard_outliers.so")):
            self.assertNotIn(".symtab", must_run("readelf", "-SW", self.unpacked(package) / name))

    def test_programs_depend_on_their_libraries(self):
        # Without dpkg-shlibdeps a package has no such line, and installs where nothing of it runs.
        for package in ("lidard", "lidard-pcl", "lidard-sim", "python3-lidard"):
            said = must_run("dpkg", "-I", self.files[package])
            self.assertRegex(said, r"\n Depends: .*\blibc6 \(>= ", package)
        self.assertTrue([name for name in self.depends("lidard") if name.startswith("libroscpp")])

    def test_a_vehicle_needs_neither_pcl_nor_headers(self):
        heavy = [name for name in self.depends("lidard") if re.search(r"pcl|vtk|boost|-dev$|python|rviz", name)]
        self.assertEqual(heavy, [])
        self.assertIn("libpcl-io", " ".join(self.depends("lidard-pcl")))
        self.assertFalse([name for name in self.depends("lidard-sim") if name.startswith("libros")])

    def test_the_python_package_needs_no_ros_and_reads_where_it_is_installed(self):
        self.assertFalse([name for name in self.depends("python3-lidard") if re.search(r"libros|tf2", name)])
        folder = self.unpacked("python3-lidard") / "usr/lib/python3/dist-packages"
        said = must_run("/usr/bin/python3", "-I", "-c", f"import sys; sys.path.insert(0, '{folder}'); import lidard; "
                        f"print(lidard.__file__, sum(1 for _ in lidard.open('{CAPTURE}')) > 2)")
        self.assertEqual(said.split(), [f"{folder}/lidard/__init__.py", "True"])

    def test_the_configuration_listens_to_nothing_until_it_is_edited(self):
        file = self.unpacked("lidard") / "etc/lidard/lidard.yaml"
        code, text = run(os.environ["LIDARD"], "run", "-c", file)
        self.assertEqual(code, 78)
        self.assertRegex(text, r"lidard\.yaml:1:1: the file has no sensors; expected sensors: with at least one entry")
        edited = self.folder / "edited.yaml"
        edited.write_text(re.sub(r"^#(?=sensors:| +\w+:)", "", file.read_text(), flags=re.MULTILINE))
        must_run(os.environ["LIDARD"], "check", edited)

    def test_maintainer_scripts_are_shell_scripts(self):
        for name in ("postinst", "prerm", "postrm"):
            must_run("sh", "-n", self.unpacked("lidard") / "DEBIAN" / name)

    def test_lintian_finds_nothing_beyond_the_documented_overrides(self):
        if not shutil.which("lintian"):
            self.skipTest("lintian is not installed")
        said = must_run("lintian", "--allow-root", "--fail-on", "error,warning", *self.files.values())
        self.assertEqual(re.findall(r"^[EW]: .*$", said, re.MULTILINE), [])


class Library(unittest.TestCase):
    def test_the_example_decodes_a_capture_from_an_install_prefix(self):
        with tempfile.TemporaryDirectory(prefix="lidard-library-") as folder:
            folder = pathlib.Path(folder)
            must_run("cmake", "--install", BUILD, "--prefix", folder / "prefix", "--component", "dev",
                     env={key: value for key, value in os.environ.items() if key != "DESTDIR"})
            example = folder / "prefix/share/doc/liblidard-dev/examples"
            self.assertLessEqual(len((example / "decode_capture.cpp").read_text().splitlines()), 35)
            must_run("cmake", "-S", example, "-B", folder / "build", f"-DCMAKE_PREFIX_PATH={folder / 'prefix'}")
            flags = must_run("cmake", "--build", folder / "build", "--verbose")
            self.assertNotIn("-Werror", flags)
            said = must_run(folder / "build/decode_capture", "velodyne_vlp16", CAPTURE)
            code, why = run(folder / "build/decode_capture", "velodyne_vlp16", folder / "absent.pcap")
            self.assertEqual(code, 1, why)
            self.assertRegex(why, r"^.*absent\.pcap: cannot be opened: No such file or directory; .*\n$")
            clouds = [(int(float(t) * 1000 + 0.5), int(n)) for t, n in re.findall(r"^(\S+) cloud, (\d+) points$", said, re.MULTILINE)]
            self.assertEqual(clouds, self.clouds_of_decode(folder / "points.csv"))
            self.assertTrue(clouds)

    def test_headers_do_not_take_the_folders_of_a_program_for_theirs(self):
        with tempfile.TemporaryDirectory(prefix="lidard-headers-") as folder:
            folder = pathlib.Path(folder)
            must_run("cmake", "--install", BUILD, "--prefix", folder / "prefix", "--component", "dev",
                     env={key: value for key, value in os.environ.items() if key != "DESTDIR"})
            headers = folder / "prefix/include/lidard"
            self.assertEqual([path.name for path in (folder / "prefix/include").iterdir()], ["lidard"])
            names = sorted(str(path.relative_to(headers)) for path in headers.rglob("*.h"))
            self.assertEqual(names, sorted(str(path.relative_to(SOURCE)) for room in ("core", "drivers") for path in (SOURCE / room).rglob("*.h")))
            # A program that has files of the same names.
            for name in names:
                own = folder / "own" / name
                own.parent.mkdir(parents=True, exist_ok=True)
                own.write_text("#error a header of the program\n")
            (folder / "all.cpp").write_text("".join(f"#include <lidard/{name}>\n" for name in names))
            eigen = must_run("pkg-config", "--cflags", "eigen3").split()
            must_run("g++", "-std=c++17", "-fsyntax-only", f"-I{folder / 'own'}", f"-I{folder / 'prefix/include'}", *eigen, folder / "all.cpp")

    def clouds_of_decode(self, path):
        """(ms, points) of each whole revolution that `lidard decode` writes."""
        must_run(os.environ["LIDARD"], "decode", CAPTURE, "--clock", "smooth", "--format", "csv", "-o", path)
        points, first = collections.Counter(), {}
        with open(path) as rows:
            header = next(rows).strip().split(",")
            frame, stamp = header.index("frame"), header.index("stamp_ns")
            for row in rows:
                fields = row.split(",")
                points[fields[frame]] += 1
                first.setdefault(fields[frame], int(fields[stamp]))
        whole = list(points)[1:-1]
        return [((first[name] + 500_000) // 1_000_000, points[name]) for name in whole]


if __name__ == "__main__":
    unittest.main(verbosity=2)
