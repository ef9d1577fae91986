"""The libraries from outside: one find_package, one program."""

import os
import pathlib
import subprocess
import unittest

import system

PROJECT = """cmake_minimum_required(VERSION 3.22)
project(mine LANGUAGES CXX)
find_package(omniflight {version} REQUIRED COMPONENTS {components})
add_executable(mine mine.cpp)
target_link_libraries(mine PRIVATE omniflight::vehicle)
target_compile_features(mine PRIVATE cxx_std_20)
"""
PROGRAM = """#include <cstdio>
#include <omniflight_vehicle/vehicle.hpp>
int main() {
  const auto v = omniflight::vehicle::load_vehicle("omnimorph");
  std::puts(v ? v->name.c_str() : v.error().text().c_str());
  return v ? 0 : 1;
}
"""


class FindPackage(system.SystemTest):
    def setUp(self):
        super().setUp()
        self.prefix = pathlib.Path(os.environ.get("OMNIFLIGHT_BIN", ROOT_INSTALL)) / "omniflight_cmake"
        if not self.prefix.is_dir():
            self.skipTest(f"nothing is installed in {self.prefix}")

    def configure(self, components="vehicle", version="0.2"):
        self.write("CMakeLists.txt", PROJECT.format(components=components, version=version))
        self.write("mine.cpp", PROGRAM)
        return subprocess.run(["cmake", "-G", "Ninja", "-S", ".", "-B", "build", f"-DCMAKE_PREFIX_PATH={self.prefix}"],
                              cwd=self.dir, text=True, capture_output=True, timeout=60)

    def test_a_program_of_ones_own(self):
        done = self.configure()
        self.assertEqual(done.returncode, 0, done.stderr)
        done = subprocess.run(["cmake", "--build", "build"], cwd=self.dir, text=True, capture_output=True, timeout=120)
        self.assertEqual(done.returncode, 0, done.stdout)
        done = subprocess.run(["build/mine"], cwd=self.dir, text=True, capture_output=True, timeout=10)
        self.assertEqual((done.returncode, done.stdout), (0, "omnimorph\n"))

    def test_the_example_of_the_package(self):
        example = self.prefix.parent / "omniflight_allocation/share/omniflight_allocation/examples/hover"
        for step in (["cmake", "-G", "Ninja", "-S", example, "-B", "build", f"-DCMAKE_PREFIX_PATH={self.prefix}"],
                     ["cmake", "--build", "build"], ["build/hover", "omnimorph"]):
            done = subprocess.run(step, cwd=self.dir, text=True, capture_output=True, timeout=120)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        rows = [line.split(":") for line in done.stdout.splitlines()]
        self.assertEqual([tilt for tilt, _ in rows], [f"tilt {degrees:2} deg" for degrees in range(0, 61, 10)])
        watts = [float(cost.split(" W")[0]) for _, cost in rows if " W" in cost]
        self.assertEqual(watts, sorted(watts), "the more the rotors lean, the more upright hover costs")
        self.assertGreater(len(watts), 3)

    def test_what_is_not_there_is_named(self):
        self.assertIn("no component 'vehicel'", " ".join(self.configure(components="vehicel").stderr.split()))
        self.assertIn("omniflight", self.configure(version="9.0").stderr)


ROOT_INSTALL = system.ROOT / "install"

if __name__ == "__main__":
    unittest.main()
