"""The launch scripts, end to end with a short mission: every component a process that the script starts by itself."""

import os
import subprocess
import unittest

import system


class LaunchScripts(system.SystemTest):
    def launch(self, script, domain, **environment):
        mission = self.short_mission()
        done = subprocess.run([str(system.ROOT / "launch_scripts" / script), str(mission), str(self.dir / "flight")],
                              text=True, capture_output=True, timeout=80,
                              env=dict(os.environ, OMNIFLIGHT_DOMAIN=str(domain), **environment))
        text = done.stdout + done.stderr
        for log in sorted((self.dir / "flight/log").glob("*.log")):
            text += f"--- {log.name}\n{log.read_text()}"
        self.assertEqual(done.returncode, 0, text)
        for name in ("recorder", "planner", "allocator", "controller"):
            self.assertIn(f"starting {name}", done.stdout)
            self.assertIn("shut down", (self.dir / f"flight/log/{name}.log").read_text(), name)
        info = system.json.loads(self.run_command("info", "flight/flight.mcap", "--json").stdout)
        self.assertFalse([n for n in info["notes"] if "without its summary" in n], info["notes"])
        return {s["name"]: s for s in info["signals"]}, info

    def test_simulated(self):
        signals, info = self.launch("simulated_flight.sh", 201)
        self.assertGreater(info["duration_s"], 7)
        self.assertGreater(signals["truth_position"]["samples"], 3000)

    def test_tethered(self):
        signals, info = self.launch("tethered_flight.sh", 202)
        self.assertGreater(info["duration_s"], 7)
        self.assertGreater(signals["rotor_speed"]["samples"], 1000)
        self.assertTrue((self.dir / "flight/log/emulator.log").exists())

    def test_two_scripts_share_no_parameters_by_copy(self):
        scripts = [set((system.ROOT / "launch_scripts" / name).read_text().splitlines())
                   for name in ("simulated_flight.sh", "tethered_flight.sh")]
        common = [line for line in scripts[0] & scripts[1] if ":" in line and not line.startswith(("#", "source"))]
        self.assertEqual(common, [])


if __name__ == "__main__":
    unittest.main()
