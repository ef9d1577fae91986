"""The launch scripts, end to end with a short mission: every component a process that the script starts by itself."""

import importlib.util
import os
import subprocess
import sys
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

    def test_every_ablation_of_the_script_is_one_of_the_command(self):
        spec = importlib.util.spec_from_file_location("ablations", system.ROOT / "launch_scripts/ablations.py")
        script = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(script)
        text = self.run_command("diagnose", "--help").stdout
        for ablation in script.IDS:
            self.assertIn(f"{ablation}:", text)

    def test_long_ablations_of_three_flights(self):
        done = subprocess.run([sys.executable, str(system.ROOT / "launch_scripts/ablations.py"), "--out", "a", "--cases", "2", "--nulls", "1",
                               "--longest", "15", "--bin", os.environ.get("OMNIFLIGHT_BIN", str(system.ROOT / "build/testing/install")), "no-occurrence", "no-instruments"],
                              cwd=self.dir, text=True, capture_output=True, timeout=900)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("3 synthetic flights", done.stdout)
        for ablation in ("whole", "no-occurrence", "no-instruments"):
            self.assertIn(f"| {ablation} |", done.stdout)
        again = subprocess.run([sys.executable, str(system.ROOT / "launch_scripts/resolution.py"), "a"], cwd=self.dir, text=True, capture_output=True)
        self.assertIn("rivals are both wrong", again.stdout, again.stderr)


if __name__ == "__main__":
    unittest.main()
