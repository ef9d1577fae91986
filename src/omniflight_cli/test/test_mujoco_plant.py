"""The second plant: flies like any, agrees with the simulator where nothing is hidden, refuses what is not its own."""

import json
import os
import subprocess
import unittest

import system

PROOF = system.PROGRAMS.parent.parent / "omniflight_proof" / "bin"


@unittest.skipUnless((PROOF / "omniflight_mujoco_plant").exists(), "built without MuJoCo (Debian: libmujoco-dev)")
class MujocoPlant(system.SystemTest):
    def digest(self, recording):
        text = subprocess.run([os.environ["OMNIFLIGHT_MCAP_DIGEST"], str(self.dir / recording)], check=True, text=True,
                              capture_output=True).stdout
        return {line.split()[0]: line.split()[1:] for line in text.splitlines() if "/component_state" not in line}

    def test_flies_a_mission_and_repeats_to_the_bit(self):
        mission = self.short_mission()
        first = self.fly(mission, "--plant", "mujoco", "--sensors", "laboratory", "--seed", "5", out="first")
        self.assertEqual((first["plant"], first["verdict"]), ("mujoco", "flown"))
        self.fly(mission, "--plant", "mujoco", "--sensors", "laboratory", "--seed", "5", "--in-process", out="second")
        self.assertEqual(self.digest("first/flight.mcap"), self.digest("second/flight.mcap"))
        self.fly(mission, "--plant", "mujoco", "--sensors", "laboratory", "--seed", "6", out="other")
        self.assertNotEqual(self.digest("first/flight.mcap"), self.digest("other/flight.mcap"))

    def test_a_world_changes_the_flight(self):
        world = self.write("heavy.yaml", "schema: omniflight.proof_world/1\nbody: {payload_kg: 0.2}\n")
        mission = self.short_mission()
        nominal = self.fly(mission, "--plant", "mujoco", out="nominal")
        heavy = self.fly(mission, "--plant", "mujoco", "--proof", world, out="heavy")
        ratio = heavy["metrics"]["power_W"] / nominal["metrics"]["power_W"]
        self.assertAlmostEqual(ratio, ((1.315 + 0.2) / 1.315) ** 1.5, delta=0.02)

    def test_the_shipped_worlds_are_flown_over_the_bus_and_their_physics_shows(self):
        mission = self.short_mission()
        nominal = self.fly(mission, "--plant", "mujoco", "--sensors", "laboratory", "--monitor", out="nominal")
        self.assertEqual(nominal["monitor"]["worst"], "OK", nominal["monitor"])
        for world in ("cable", "laboratory"):
            flown = self.fly(mission, "--plant", "mujoco", "--proof", world, "--sensors", "laboratory", "--monitor", out=world)
            self.assertEqual(flown["verdict"], "flown")
            self.assertGreater(flown["metrics"]["power_W"], 1.05 * nominal["metrics"]["power_W"], world)
            wrench, = (c for c in flown["monitor"]["checks"] if c["name"] == "wrench balance")
            self.assertIn(wrench["worst"], ("WARN", "ERROR"), world)
            self.assertIn("force_z -", wrench["message"], world)

    def test_refuses_what_is_not_its_own(self):
        mission = self.short_mission()
        bad = self.write("bad.yaml", "schema: omniflight.proof_world/1\ncabel: {}\n")
        for arguments, words in (
                (("--plant", "mujoco", "--proof", bad), ("bad.yaml:2", "cabel")),
                (("--plant", "mujoco", "--proof", "nowhere"), ("nowhere", "configs/proof_worlds")),
                (("--plant", "mujoco", "--effects", "tether"), ("--effects", "--proof")),
                (("--proof", "cable"), ("--proof", "--plant mujoco"))):
            done = self.run_command("fly", mission, "--out", "bad", *arguments, expect=4)
            for word in words:
                self.assertIn(word, done.stderr, arguments)

    def crosscheck(self, mission):
        """Both worlds on one mission; the limits are those of the issue that asked for the second world."""
        done = subprocess.run([PROOF / "omniflight_proof_crosscheck", "--program", system.COMMAND, "--missions", mission,
                               "--no-cable", "--json", "--out", "check"], cwd=self.dir, text=True, capture_output=True,
                              timeout=85)
        self.assertEqual(done.returncode, 0, done.stderr)
        flight, = json.loads(done.stdout)["flights"]
        print(f"\n{mission}: {flight}")
        self.assertLess(flight["position_rmse_m"], 1e-3)
        self.assertLess(flight["attitude_rmse_deg"], 0.1)
        self.assertLess(abs(flight["power_mujoco_W"] / flight["power_simulator_W"] - 1), 0.005)
        self.assertGreater(flight["duration_s"], 20)
        self.assertGreater(flight["position_rmse_m"], 0, "two worlds never agree to the bit")
        self.assertTrue((self.dir / "check" / "report.html").stat().st_size > 10000)

    def test_the_cable_weighs_its_law_and_the_report_shows_its_hysteresis(self):
        # the shipped cable with half the links, which takes a sixth of the time
        shipped = (system.CONFIGS / "proof_worlds" / "cable.yaml").read_text()
        self.assertIn("links: 32", shipped)
        cable = self.write("cable.yaml", shipped.replace("links: 32", "links: 16"))
        done = subprocess.run([PROOF / "omniflight_proof_crosscheck", "--no-flights", "--cable", cable, "--json", "--out",
                               "check"], cwd=self.dir, text=True, capture_output=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        check = json.loads(done.stdout)
        self.assertEqual(check["flights"], [])
        rests = check["hung_mass"]
        self.assertEqual([(r["height_m"], r["direction"]) for r in rests],
                         [(h, "down") for h in (1.6, 1.3, 1.0, 0.7, 0.5)] + [(h, "up") for h in (0.7, 1.0, 1.3, 1.6)])
        for rest in rests:
            # what is above the floor, of a cable of 1.28 m fixed 0.12 m below the body
            law = 0.15 * min(1.28, rest["height_m"] - 0.12)
            self.assertAlmostEqual(rest["law_kg"], law, places=9)
            self.assertLess(abs(rest["mass_kg"] / law - 1), 0.05, rest)
        self.assertGreater(check["hysteresis"], 0.005, "links that rub on a floor do not go down as they go up")
        self.assertLess(check["hysteresis"], 0.15)
        page = (self.dir / "check" / "report.html").read_text()
        for words in ("Hung mass over height", "going down", "going up", f"{100 * check['hysteresis']:.1f} %"):
            self.assertIn(words, page)

    def test_long_torques_of_a_vehicle_that_rocks_are_those_of_its_rotors(self):
        # half a step between gyro and rotors would be 0.6 mN m; such flights are what a diagnosis proposes. Means over 25 ms
        # pass more of the noise of gyros than a low pass of 15 Hz did
        for sensors, most in (("ideal", 1.5e-4), ("laboratory", 1.3e-3)):
            self.fly(self.rocking_mission(), "--plant", "mujoco", "--sensors", sensors, out=sensors)
            self.run_command("diagnose", f"{sensors}/flight.mcap", "--vehicle", "omnimorph", "--out", "d", "--quiet",
                             "--only", "payload_mass,com_offset,inertia_error", timeout=80)
            found = self.json("d/diagnosis.json")
            self.assertEqual(found["verdict"], "nothing_missing", found["summary"])
            rms = {c["channel"]: c["rms_before"] for c in found["fit"]["in_sample"]}
            print(f"\n{sensors}: torque unexplained {1e3 * rms['Mx']:.3f}, {1e3 * rms['My']:.3f} mN m")
            self.assertLess(max(rms["Mx"], rms["My"]), most)

    def rocking_mission(self):
        turns = [f"  - {{by: [0, 0, 0], attitude: {{rpy_deg: [{', '.join(str(28 * (-1) ** k * (axis == i)) for i in range(3))}]}},"
                 " hold_s: 0}" for axis in range(3) for k in range(16)]
        return self.write("rocking.yaml", "\n".join((
            "schema: omniflight.mission/1", "name: rocking", "vehicle: omnimorph", "test_bed: pyramid", "alpha_deg: 43",
            "clearance_m: 0.08", "seed: 1", "budget_ms: 2000",
            "limits: {speed_mps: 0.4, acceleration_mps2: 0.5, rate_dps: 212, angular_acceleration_dps2: 1320,"
            " rotor_headroom: 0.1}",
            "start: {position: [0, 0, 1], attitude: {rpy_deg: [0, 0, 0]}, hold_s: 3}", "waypoints:", *turns, "")))

    def test_long_agrees_with_the_simulator_on_trajectory_1(self):
        self.crosscheck("trajectory_1")

    def test_agrees_with_the_simulator_on_trajectory_2(self):
        self.crosscheck("trajectory_2")

    def test_long_agrees_with_the_simulator_on_a_full_roll(self):
        self.crosscheck("full_roll")


if __name__ == "__main__":
    unittest.main()
