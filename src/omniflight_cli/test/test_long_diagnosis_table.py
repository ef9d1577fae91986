"""What `diagnose` says of flights that `fly` wrote: every plant, every sensor set, with and without a load. Prints a table.

It holds the diagnosis to answering each of them with a verdict of its own contract, to no alarm on most of the nominal
flights, and to seeing most of the loads; what it names is shown beside what was flown. launch_scripts/diagnosis_table.sh runs
it; OMNIFLIGHT_ONLY=simulator,ideal,tether bounds plants, sensors and worlds, OMNIFLIGHT_KEEP names a folder that recordings and
diagnoses are kept in.
"""

import os
import pathlib
import shutil
import time
import unittest

import system

PROOF = system.PROGRAMS.parent.parent / "omniflight_proof" / "bin"
SENSORS = ("ideal", "laboratory", "degraded")
# what is flown: the effects that a diagnosis is to name, the model file of the simulator's physics, the world of MuJoCo
WORLDS = {
    "nominal": (set(), None, None),
    "tether": ({"payload_mass", "hung_cable"}, "tether", "tether"),
    "payload": ({"payload_mass"}, "payload", "payload"),
    "cable": ({"hung_cable"}, "cable", "cable"),
}
VERDICTS = {"nothing_missing", "explained", "ambiguous", "unexplained", "unusable", "unfinished"}
MISSION = "trajectory_2"  # pauses on three heights tell a constant load from one that grows


def asked(values):
    """Those of the values that OMNIFLIGHT_ONLY names; all when it names none of them."""
    only = set(filter(None, os.environ.get("OMNIFLIGHT_ONLY", "").split(",")))
    return [value for value in values if value in only] or list(values)


class DiagnosisTable(system.SystemTest):
    def diagnose(self, plant, world, sensors):
        """(verdict of the flight, verdict of the diagnosis, {effect: probability}, seconds of the diagnosis) of one flight."""
        out = f"{plant}-{world}-{sensors}"
        _, model, proof = WORLDS[world]
        loaded = ("--proof", proof) if plant == "mujoco" else ("--effects", model)
        self.run_command("fly", MISSION, "--plan", "plan", "--plant", plant, "--sensors", sensors, "--out", out, "--quiet",
                         *(loaded if loaded[1] else ()), timeout=600, expect=None)
        flown = self.json(f"{out}/flight.json")["verdict"]
        begin = time.monotonic()
        done = self.run_command("diagnose", f"{out}/flight.mcap", "--vehicle", "omnimorph", "--out", f"{out}/diagnosis",
                                "--quiet", timeout=900, expect=None)
        self.assertIn(done.returncode, (0, 2), f"{out}: {done.stderr}")
        answer = self.json(f"{out}/diagnosis/diagnosis.json")
        self.assertIn(answer["verdict"], VERDICTS)
        if keep := os.environ.get("OMNIFLIGHT_KEEP"):
            shutil.copytree(self.dir / out, pathlib.Path(keep) / out, ignore=shutil.ignore_patterns("boards"), dirs_exist_ok=True)
        (self.dir / out / "flight.mcap").unlink()
        found = {finding["effect"]: finding["probability"] for finding in answer["findings"]}
        return flown, answer["verdict"], found, time.monotonic() - begin

    def table(self, plant):
        if plant not in asked(("simulator", "emulator", "mujoco")):
            self.skipTest(f"OMNIFLIGHT_ONLY names no {plant}")
        self.run_command("plan", MISSION, "--out", "plan", "--quiet")
        nominal = silent = loads = seen = named = 0
        print("\n| plant | sensors | world | flight | diagnosis | found | s |\n|---|---|---|---|---|---|---|", flush=True)
        for world in asked(WORLDS):
            wanted = WORLDS[world][0]
            for sensors in asked(SENSORS):
                flown, verdict, found, seconds = self.diagnose(plant, world, sensors)
                shown = ", ".join(f"{effect} {p:.2f}" for effect, p in sorted(found.items(), key=lambda x: -x[1]))
                print(f"| {plant} | {sensors} | {world} | {flown} | {verdict} | {shown} | {seconds:.0f} |", flush=True)
                if wanted:
                    loads += 1
                    seen += verdict not in ("nothing_missing", "unusable", "unfinished")
                    named += wanted == set(found)
                else:
                    nominal += 1
                    silent += verdict == "nothing_missing"
        print(f"diagnosed {nominal + loads} flights of {plant}: {silent} of {nominal} nominal ones without an alarm, "
              f"{seen} of {loads} loads seen, {named} of them named exactly")
        self.assertGreater(nominal + loads, 0)
        self.assertGreaterEqual(silent, nominal / 2)
        self.assertGreaterEqual(seen, loads / 2)

    def test_long_simulator(self):
        self.table("simulator")

    def test_long_emulator(self):
        self.table("emulator")

    @unittest.skipUnless((PROOF / "omniflight_mujoco_plant").exists(), "built without MuJoCo (Debian: libmujoco-dev)")
    def test_long_mujoco(self):
        self.table("mujoco")


if __name__ == "__main__":
    unittest.main()
