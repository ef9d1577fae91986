"""Words that mean nothing here are refused with what was meant; a killed proof leaves no worker."""

import os
import pathlib
import re
import signal
import unittest

import system


class Suggestions(system.SystemTest):
    def refused(self, arguments, *words):
        done = self.run_command(*arguments, expect=4)
        for word in words:
            self.assertIn(word, done.stderr)
        self.assertEqual(sorted(p.name for p in self.dir.iterdir()), ["short.yaml"])

    def test_what_was_meant(self):
        mission = self.short_mission()
        out = ("--out", "x")
        self.refused(("fyl", mission), "'fyl'", "Did you mean 'omniflight fly'")
        self.refused(("fly", mission, "--wieghts", "case_a", *out), "--wieghts", "Did you mean '--weights'")
        self.refused(("fly", mission, "-p", "controler.kp=[1, 1, 1]", *out), "Did you mean 'controller.kp'")
        self.refused(("fly", mission, "-p", "gateway.ramp_s=1", *out), "no component 'gateway'")
        self.refused(("fly", mission, "-p", "recorder.file=y.mcap", *out), "decided by the flight")
        self.refused(("plan", mission, "trajectory_1", *out), "plans one mission", "trajectory_1")
        self.refused(("plan", "verfy", "x", *out), "Did you mean 'plan verify")
        self.refused(("design", "omnimorph", "--f-max", "0", *out), "f-max", "more than 0")
        self.refused(("fly", mission, "--plant", "emulator", "--rate", "max", *out), "--rate", "real time")
        self.refused(("fly", mission, "--devices", "/dev/ttyUSB0", *out), "--devices", "--plant hardware")
        self.refused(("fly", mission, "--set", "mas=1.4", *out), "mas")


def descendants(pid):
    found, left = [], [pid]
    while left:
        for child in system.children_of(left.pop()):
            found.append(child)
            left.append(child)
    return found


class KilledProof(system.SystemTest):
    def test_no_worker_outlives_it(self):
        if not (system.PROGRAMS.parent.parent / "omniflight_proof/bin/omniflight_proof_campaign").exists():
            self.skipTest("omniflight_proof is not built")
        proof = self.start_command("prove", "--cases", "2", "--nulls", "0", "--salt", "a-salt-for-tests", "--jobs", "2", "--no-second",
                                   "--no-baselines", "--ablations", "0", "--allow-unsealed")
        workers = system.wait_until("the workers of the proof", lambda: len(descendants(proof.pid)) >= 2 and
                                    descendants(proof.pid) or proof.poll() is not None, 60)
        self.assertIsNone(proof.poll(), "the proof ended before it could be killed")
        folder = next(p for p in (self.dir / "runs").iterdir() if p.suffix != ".seal")
        self.assertRegex(folder.name, r"^proof-\d{8}-\d{6}$")
        second = self.run_command("prove", "--cases", "2", "--nulls", "0", "--out", folder, expect=4)
        self.assertIn(f"in use by another run (process {proof.pid})", second.stderr)
        self.assertIn("--out", self.run_command("prove", "--reveal", f"{folder}.seal", expect=4).stderr)
        os.kill(proof.pid, signal.SIGKILL)
        proof.wait(timeout=5)
        system.wait_until("the workers to end", lambda: not any(map(system.alive, workers)), 10)


if __name__ == "__main__":
    unittest.main()
