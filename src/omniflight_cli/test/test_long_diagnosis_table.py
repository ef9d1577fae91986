"""What `diagnose` says of flights that `fly` wrote: every plant, every sensor set, with and without a load. Prints a table.

It holds the diagnosis to answering each of them with a verdict of its own contract, and to no alarm on most of the nominal
flights; what it names is shown beside what was flown. OMNIFLIGHT_ONLY=simulator,ideal bounds plants and sensors.
"""

import os
import time
import unittest

import system

# what is flown, and the effects that a diagnosis is to name
WORLDS = {"nominal": set(), "tether": {"payload_mass", "hung_cable"}, "payload": {"payload_mass"}, "cable world": {"hung_cable"}}
FLOWN_AS = {
    ("simulator", "nominal"): (), ("simulator", "tether"): ("--effects", "tether"),
    ("simulator", "payload"): ("--effects", "light_load"),
    ("emulator", "nominal"): (), ("emulator", "tether"): ("--effects", "tether"),
    ("emulator", "payload"): ("--effects", "light_load"),
    ("mujoco", "nominal"): (), ("mujoco", "cable world"): ("--proof", "cable"),
}
VERDICTS = {"nothing_missing", "explained", "ambiguous", "unexplained", "unusable", "unfinished"}


class DiagnosisTable(system.SystemTest):
    def diagnose(self, plant, world, sensors, arguments):
        """(verdict, {effect: probability}, seconds) of one flight."""
        out = f"{plant}-{world}-{sensors}".replace(" ", "_")
        self.run_command("fly", "trajectory_2" if plant != "emulator" else "trajectory_1", "--plant", plant, "--sensors", sensors,
                         "--out", out, "--quiet", *arguments, timeout=300, expect=None)
        recording = self.dir / out / "flight.mcap"
        self.assertTrue(recording.is_file(), out)
        begin = time.monotonic()
        done = self.run_command("diagnose", recording, "--vehicle", "omnimorph", "--out", f"{out}/diagnosis", "--quiet",
                                timeout=900, expect=None)
        self.assertIn(done.returncode, (0, 2), f"{out}: {done.stderr}")
        answer = self.json(f"{out}/diagnosis/diagnosis.json")
        self.assertIn(answer["verdict"], VERDICTS)
        return (answer["verdict"], {f["effect"]: f["probability"] for f in answer["findings"]}, time.monotonic() - begin)

    def test_long_every_plant_sensor_and_load(self):
        only = set(filter(None, os.environ.get("OMNIFLIGHT_ONLY", "").split(",")))
        rows, silent, nominal, named, loaded = [], 0, 0, 0, 0
        print("\n| plant | sensors | flown | verdict | found | s |\n|---|---|---|---|---|---|")
        for (plant, world), arguments in FLOWN_AS.items():
            for sensors in ("ideal", "laboratory", "degraded"):
                if only and not {plant, sensors} <= only:
                    continue
                verdict, found, seconds = self.diagnose(plant, world, sensors, arguments)
                shown = ", ".join(f"{effect} {p:.2f}" for effect, p in sorted(found.items(), key=lambda x: -x[1]))
                print(f"| {plant} | {sensors} | {world} | {verdict} | {shown} | {seconds:.0f} |", flush=True)
                rows.append(world)
                wanted = WORLDS[world]
                if wanted:
                    loaded += 1
                    named += wanted <= set(found)
                else:
                    nominal += 1
                    silent += verdict == "nothing_missing"
        print(f"diagnosed {len(rows)} flights: {silent} of {nominal} nominal ones without an alarm, "
              f"{named} of {loaded} loads named whole")
        self.assertGreater(len(rows), 0)
        self.assertGreaterEqual(silent, nominal / 2)


if __name__ == "__main__":
    unittest.main()
