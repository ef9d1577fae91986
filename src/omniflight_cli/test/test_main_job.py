"""The main job: a nominal and a tethered flight of trajectory 2, compared, diagnosed, and the model flown again."""

import csv
import json
import re
import unittest

import system


class MainJob(system.SystemTest):
    def pair(self):
        """nominal/ and tethered/ as the demo flies them, in one process each."""
        self.run_command("plan", "trajectory_2", "--out", "plan", "--quiet")
        common = ("--plan", "plan", "--sensors", "laboratory", "--in-process")
        self.fly("trajectory_2", *common, "--seed", "1", out="nominal")
        tethered = self.fly("trajectory_2", *common, "--seed", "2", "--effects", "tether", out="tethered")
        self.assertIn("before the plan began", " ".join(tethered["remarks"]), "released with the tether, it sags")

    def diagnose(self, recording, *arguments):
        self.run_command("diagnose", recording, "--vehicle", "omnimorph", "--out", "diagnosis", "--quiet", *arguments,
                         expect=None, timeout=80)
        return self.json("diagnosis/diagnosis.json")

    def test_the_tether_costs_power_that_tracking_hides(self):
        self.pair()
        self.run_command("compare", "nominal/flight.mcap", "tethered/flight.mcap", "--vehicle", "omnimorph", "--out",
                         "compare", "--quiet")
        rows = {r["channel"]: r for r in self.json("compare/compare.json")["rows"]}
        print("\npower ratio", rows["mean power"]["ratio"])
        self.assertGreaterEqual(rows["mean power"]["ratio"], 1.5)
        self.assertLessEqual(rows["mean power"]["ratio"], 1.75)
        self.assertLess(rows["RMSE z"]["real"], 0.03)
        page = (self.dir / "compare/report.html").read_text()
        self.assertNotRegex(page, r"""(src|href)=["']https?://""")

    def test_the_tether_is_named_and_flown(self):
        self.pair()
        found = self.diagnose("tethered/flight.mcap", "--refly", "trajectory_2", "--plan", "plan")
        fit = found["fit"]
        for row in fit["closed_loop"]:
            print(f"\n{row['channel']}: ratio {row['simulated_after'] / row['real']:.3f}", end="")
        print("\npower:", fit["power"])
        print("named:", [(f["effect"], [(p["name"], p["value"]) for p in f["parameters"]]) for f in found["findings"]])
        vertical = [m for m in found["mismatch"] if m["channel"] == "Fz"]
        self.assertTrue(vertical, "the vertical force must differ")
        self.assertIn("height", vertical[0]["where"])
        page = (self.dir / "diagnosis/report.html").read_text()
        first = re.search(r"<h2>(.*?)</h2>", page).group(1)
        self.assertRegex(first, r"(?i)0\.\d\d kg too heavy")
        self.assertRegex(first, r"(?i)a cable of 0\.\d\d kg/m from \d\.\d\d m up")
        self.assertTrue(found["summary"].startswith(first), found["summary"])
        self.assertIn("not identifiable", page, "the length of a cable whose end never leaves the floor")
        length = [p for f in found["findings"] for p in f["parameters"] if p["name"] == "length"]
        self.assertEqual([p["identifiable"] for p in length], [False])
        # ambiguous: it names what this flight cannot tell apart
        self.assertIn(found["verdict"], ("explained", "ambiguous"))
        aliases = [a for f in found["findings"] for a in f["cannot_be_told_apart_from"]]
        self.assertEqual(found["verdict"] == "ambiguous", bool(aliases), aliases)
        self.assertLessEqual({"payload_mass", "hung_cable"}, {f["effect"] for f in found["findings"]})
        self.assertEqual(len(fit["closed_loop"]), 6)
        for row in fit["closed_loop"]:
            self.assertGreater(row["simulated_after"] / row["real"], 0.8, row)
            self.assertLess(row["simulated_after"] / row["real"], 1.25, row)
        z = fit["closed_loop"][2]
        self.assertLess(z["simulated_before"] / z["real"], 0.5, "before the update the simulation is blind to it")
        held = z["integral"]  # what the integrator carries shows it at once
        self.assertGreater(held["ratio_before"], 5)
        self.assertLess(abs(held["ratio_after"] - 1), 0.1)
        power = fit["power"]
        self.assertLess(abs(power["simulated_after_W"] / power["real_W"] - 1), 0.03)
        self.assertGreater(abs(power["simulated_before_W"] / power["real_W"] - 1), 0.2)

    def test_a_proposal_that_fits_nowhere_loses_nothing_of_the_diagnosis(self):
        # a light load, where thrust has been found weak before: only torques tell them apart
        (self.dir / "prior.json").write_text(json.dumps({
            "schema": "omniflight.diagnosis/1", "findings": [{"effect": "thrust_scale", "probability": 0.9}]}))
        (self.dir / "load.yaml").write_text(
            "schema: omniflight.model/1\neffects:\n  - {id: payload_mass, parameters: {mass: 0.1}}\n")
        self.run_command("plan", "trajectory_1", "--out", "plan", "--quiet")
        self.fly("trajectory_1", "--plan", "plan", "--sensors", "laboratory", "--in-process", "--effects", "load.yaml",
                 out="load")
        self.run_command("diagnose", "load/flight.mcap", "--vehicle", "omnimorph", "--out", "diagnosis", "--quiet",
                         "--test-bed", "nowhere", "--prior", "prior.json", timeout=80)
        found = self.json("diagnosis/diagnosis.json")
        self.assertEqual(found["verdict"], "ambiguous", "then no flight is proposed, and this test tells nothing")
        self.assertIn("no test bed map 'nowhere'", " ".join(found["left_out"]))
        self.assertEqual(found["next_flight"]["mission"], "")
        self.assertFalse((self.dir / "diagnosis/next_flight.yaml").exists())

    def test_a_nominal_flight_raises_no_alarm(self):
        # ideal sensors leave what arithmetic leaves; in a full roll rotors turn slower than telemetry reads
        for mission, sensors in (("trajectory_2", "laboratory"), ("trajectory_2", "ideal"), ("full_roll", "laboratory")):
            out = f"{mission}-{sensors}"
            self.fly(mission, "--sensors", sensors, "--in-process", out=out)
            found = self.diagnose(f"{out}/flight.mcap")
            self.assertEqual(found["verdict"], "nothing_missing", f"{out}: {found['summary']}")
            self.assertEqual(found["findings"], [], out)

    def test_a_flight_without_its_motors_is_judged_by_its_sensors(self):
        self.fly("trajectory_1", "--sensors", "laboratory", "--in-process", out="flown")
        self.run_command("export", "flown/flight.mcap", "--to", "csv", "--out", "flown.csv")
        rows = list(csv.reader((self.dir / "flown.csv").read_text().splitlines()))
        inertial = [i for i, name in enumerate(rows[0]) if name.startswith(("t_s", "acc_", "gyro_"))]
        with (self.dir / "imu.csv").open("w", newline="") as file:
            csv.writer(file).writerows([row[i] for i in inertial] for row in rows if any(row[i] for i in inertial[1:]))
        for arguments in ([], ["--check"]):
            self.run_command("diagnose", "imu.csv", "--vehicle", "omnimorph", "--out", "imu", "--quiet", *arguments,
                             expect=2)
            found = self.json("imu/diagnosis.json")
            self.assertEqual(found["verdict"], "unusable")
            self.assertEqual(found["findings"], [])
            self.assertEqual(found["intake"]["missing"][0]["signal"], "rotor_speed")
            noise = {x["signal"]: x["value"] for x in found["intake"]["sensors"] if x["quantity"].startswith("white")}
            self.assertLess(abs(noise["acc"] - 0.08), 0.01)


if __name__ == "__main__":
    unittest.main()
