"""Figures of vehicle files that a tool computes are those that the tool computes."""

import json
import re
import subprocess
import sys
import unittest

import system

TOOLS = system.ROOT / "src/omniflight_vehicle/tools"
KEYS = ("mass:", "inertia:", "center_of_mass:", "  - {position:")


def vehicle_file(name):
    return system.CONFIGS / "vehicles" / name / (name + ".yaml")


class VehicleLayouts(unittest.TestCase):
    def tool(self, name, *arguments):
        done = subprocess.run([sys.executable, "-B", TOOLS / name, *arguments], text=True, capture_output=True, timeout=120)
        if "No module named 'numpy'" in done.stderr:
            self.skipTest("numpy is not installed")
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_files_hold_what_the_tool_computes(self):
        names = self.tool("vehicle_layouts.py", "--list").split()
        self.assertGreaterEqual(len(names), 4)
        for name in names:
            with self.subTest(vehicle=name):
                written = [re.sub(r"\s+#.*", "", line) for line in vehicle_file(name).read_text().splitlines()
                           if line.startswith(KEYS)]
                computed = [line for line in self.tool("vehicle_layouts.py", name).splitlines() if line.startswith(KEYS)]
                self.assertEqual(written, computed)

    def test_the_seven_rotor_layout_fulfils_its_criterion(self):
        m = json.loads(self.tool("seven_rotor_design.py", "--check", vehicle_file("o7_plus")))
        self.assertEqual(m["rank"], 6)
        self.assertLess(m["unbalance"], 1e-5, "equal thrusts give no wrench, as far as six digits tell")
        self.assertLess(m["condition"], 1.11)
        self.assertGreater(m["least_distance"], 2 * 0.1143, "m, two radii of a rotor")


if __name__ == "__main__":
    unittest.main()
