"""Flights on a secured bus: who has keys flies, stops and looks; who has none hears and says nothing."""

import os
import shutil
import signal
import subprocess
import time
import unittest

import system

BAD_INPUT = 4
NO_RESULT = 2


class SecureFlight(system.SystemTest):
    def make_keys(self):
        self.run_command("keys", "--out", "keys", "--quiet")
        return self.dir / "keys"

    def start_boards(self, *arguments, domain):
        """A flight through emulated boards that has begun: its process."""
        fly = self.start_command("fly", self.hovering_mission(), "--plant", "emulator", "--out", "flight", "--domain", domain,
                                 "-p", f"emulator.line_log={self.dir / 'line.txt'}", *arguments)
        log = self.dir / "line.txt"
        system.wait_until("commands on the line",
                          lambda: log.exists() and log.stat().st_size > 20_000 or fly.poll() is not None, 40)
        if fly.poll() is not None:
            self.fail("the flight ended early: " + "".join(fly.communicate()))
        return fly

    def heard_without_keys(self, domain):
        """Messages that a recorder in clear text gets in two seconds."""
        file = self.dir / "overheard.mcap"
        recorder = subprocess.Popen([system.PROGRAMS / "omniflight_recorder", "--domain", str(domain), "--loopback",
                                     system.CONFIGS / "cyclonedds_loopback.xml", "-p", f"file:={file}"],
                                    stderr=subprocess.PIPE, text=True)
        self.addCleanup(recorder.kill)
        time.sleep(2)
        recorder.send_signal(signal.SIGTERM)
        said = recorder.communicate(timeout=20)[1]
        self.assertEqual(recorder.returncode, 0, said)
        info = system.json.loads(self.run_command("info", file, "--json", expect=None).stdout)
        return [s for s in info.get("signals", []) if "rotor" in str(s) or "position" in str(s)]

    def test_a_secured_run_is_stopped_by_those_who_have_its_keys(self):
        domain = 131
        keys = self.make_keys()
        fly = self.start_boards("--secure", keys, domain=domain)
        self.assertEqual(self.heard_without_keys(domain), [])
        heard = system.json.loads(self.run_command("topic", "list", "--domain", domain, "--for-s", 2, "--json").stdout)
        spoken = {t["topic"]: t["messages"] for t in heard}
        self.assertGreater(spoken["/omniflight/tick"], 10)
        self.assertGreater(spoken["/omniflight/command"], 10)
        others = self.dir / "others"
        self.run_command("keys", "--out", others, "--quiet")
        done = self.run_command("estop", "--domain", domain, "--secure", others, expect=NO_RESULT)
        self.assertIn(f"the run is secured by the keys in {keys}", done.stdout)
        self.assertIsNone(fly.poll(), "it flies on")
        done = self.run_command("estop", "--domain", domain)  # the keys are those of the run
        self.assertIn("emergency_stop", done.stdout)
        output = fly.communicate(timeout=30)
        self.assertEqual(fly.returncode, NO_RESULT, output)
        self.assertIn("emergency_stop", self.json("flight/flight.json")["reason"])

    def test_long_a_run_in_clear_text_is_overheard_and_deaf_to_keys(self):
        domain = 132
        fly = self.start_boards(domain=domain)
        self.assertNotEqual(self.heard_without_keys(domain), [])
        done = self.run_command("estop", "--domain", domain, "--secure", self.make_keys(), expect=NO_RESULT)
        self.assertIn("this program is secured", done.stdout)
        self.run_command("estop", "--domain", domain)
        fly.communicate(timeout=30)

    def test_lockstep_is_flown_as_in_clear_text(self):
        keys = self.make_keys()
        mission = self.short_mission()
        plain = self.fly(mission, "--sensors", "laboratory", out="plain")
        secured = self.fly(mission, "--sensors", "laboratory", "--secure", keys, out="secured", timeout=200)
        alone = self.fly(mission, "--sensors", "laboratory", "--secure", keys, "--in-process", out="alone")
        print("\nlockstep: {:.1f} s in clear text, {:.1f} s secured".format(plain["wall_s"], secured["wall_s"]))
        self.assertEqual(secured["verdict"], "flown")
        self.assertEqual(secured["metrics"], plain["metrics"])
        self.assertEqual(alone["metrics"], plain["metrics"])

    def test_keys_are_asked_for_before_anything_is_written(self):
        keys = self.make_keys()
        self.assertEqual(os.stat(keys / "gateway/key.pem").st_mode & 0o777, 0o600)
        self.assertIn("never overwritten", self.run_command("keys", "--out", "keys", expect=BAD_INPUT).stderr)
        self.assertIn("--out", self.run_command("keys", expect=BAD_INPUT).stderr)
        for spoil, words in ((lambda: os.chmod(keys / "allocator/key.pem", 0o644), "others can read (mode 0644)"),
                             (lambda: shutil.rmtree(keys / "allocator"), "no keys of the role 'allocator'"),
                             (lambda: shutil.rmtree(keys), "keys: cannot be read")):
            spoil()
            done = self.run_command("fly", self.short_mission(), "--secure", keys, "--out", "flight", expect=BAD_INPUT)
            self.assertIn(words, done.stderr)
            self.assertFalse((self.dir / "flight").exists())

    def test_a_component_with_keys_needs_the_bus_that_they_go_with(self):
        done = subprocess.run([system.PROGRAMS / "omniflight_planner", "--secure", self.make_keys(), "--domain", "133"],
                              text=True, capture_output=True, timeout=20)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("before use_loopback", done.stderr)


if __name__ == "__main__":
    unittest.main()
