"""A prefix that was moved, and the Debian packages: unpacked into a root of their own and used from there."""

import os
import pathlib
import shutil
import subprocess
import unittest

import system
from test_find_package import PROGRAM, PROJECT

INSTALLED = pathlib.Path(os.environ.get("OMNIFLIGHT_BIN", system.ROOT / "install"))


class Prefix(system.SystemTest):
    def test_configs_are_found_beside_a_program_that_was_moved(self):
        moved = self.dir / "prefix/bin/omniflight"
        moved.parent.mkdir(parents=True)
        shutil.copy(system.COMMAND, moved)
        environment = {k: v for k, v in os.environ.items() if k != "OMNIFLIGHT_CONFIGS"}

        def vehicles(*names, shared=self.dir / "nothing"):
            return subprocess.run([moved, "vehicles", *names], cwd=self.dir, env={**environment, "XDG_DATA_DIRS": str(shared)}, text=True,
                                  capture_output=True, timeout=60)

        without = vehicles()
        self.assertEqual((without.returncode, without.stdout), (4, ""))
        self.assertIn("Set OMNIFLIGHT_CONFIGS", without.stderr)
        (self.dir / "data/omniflight").mkdir(parents=True)
        (self.dir / "data/omniflight/configs").symlink_to(system.CONFIGS)
        self.assertIn("data/omniflight/configs/vehicles/omnimorph", vehicles("omnimorph", shared=f"relative:{self.dir}/data").stdout)
        (self.dir / "prefix/share/omniflight").mkdir(parents=True)
        (self.dir / "prefix/share/omniflight/configs").symlink_to(system.CONFIGS)
        done = vehicles("crazyflie_brushless", shared=self.dir / "data")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("prefix/share/omniflight/configs/vehicles/crazyflie_brushless", done.stdout)


class Packages(system.SystemTest):
    def make_packages(self):
        subprocess.run([system.ROOT / "launch_scripts/package.sh", "--install", INSTALLED, "--out", self.dir / "packages"], check=True,
                       timeout=600)

    def test_long_three_users_in_clean_roots(self):
        if os.geteuid() != 0 or not shutil.which("debootstrap") or subprocess.run(["unshare", "--mount", "--net", "true"]).returncode != 0:
            self.skipTest("needs root, namespaces and debootstrap")
        if not (INSTALLED / "omniflight_python").is_dir():
            self.skipTest(f"nothing is installed in {INSTALLED}")
        self.make_packages()
        done = subprocess.run([system.ROOT / "launch_scripts/try_clean_roots.sh", "--packages", self.dir / "packages"], text=True,
                              capture_output=True, timeout=3000)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        for words in ("the packages work", "the Python package works", "the libraries work from CMake"):
            self.assertIn(words, done.stdout)

    def test_long_packages_work_where_they_are_unpacked(self):
        if not shutil.which("dpkg-shlibdeps"):
            self.skipTest("no dpkg-shlibdeps: apt-get install dpkg-dev")
        if not (INSTALLED / "omniflight_python").is_dir():
            self.skipTest(f"nothing is installed in {INSTALLED}")
        scripts, root = system.ROOT / "launch_scripts", self.dir / "root"
        self.make_packages()
        packages = {p.name.split("_")[0]: p for p in (self.dir / "packages").glob("*.deb")}
        self.assertLessEqual({"omniflight", "libomniflight-dev", "python3-omniflight"}, set(packages))
        for package in packages.values():
            subprocess.run(["dpkg-deb", "-x", package, root], check=True, timeout=120)
        for program in (root / "usr/bin").iterdir():
            self.assertNotIn(str(system.ROOT).encode(), program.read_bytes(), f"{program.name} knows where it was built")
        done = subprocess.run([scripts / "try_packages.sh", root], cwd=self.dir, text=True, capture_output=True, timeout=1800)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("the packages work", done.stdout)
        self.write("CMakeLists.txt", PROJECT.format(components="vehicle", version="0.2"))
        self.write("mine.cpp", PROGRAM)
        for step in (["cmake", "-G", "Ninja", "-S", ".", "-B", "build", f"-DCMAKE_PREFIX_PATH={root}/usr"], ["cmake", "--build", "build"],
                     ["build/mine"]):
            done = subprocess.run(step, cwd=self.dir, text=True, capture_output=True, timeout=300)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
