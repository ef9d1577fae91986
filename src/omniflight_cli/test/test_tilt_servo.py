"""A tilt servo whose lag and play the vehicle file tells: flown by both plants, no finding, and more than told is one."""

import unittest

import system

PROOF = system.PROGRAMS.parent.parent / "omniflight_proof" / "bin"
SERVO = ("--set", "tilt.time_constant_s=0.08", "--set", "tilt.backlash_deg=0.5")


class ToldServo(system.SystemTest):
    def flown(self, *arguments, out):
        flight = self.fly("tilt_sweep", *arguments, "--sensors", "laboratory", "--seed", "4", "--in-process", out=out,
                          timeout=300)
        self.assertEqual(flight["verdict"], "flown")

    def diagnosed(self, flight, *vehicle):
        out = f"{flight}_{len(vehicle)}"
        self.run_command("diagnose", f"{flight}/flight.mcap", "--vehicle", "omnimorph", *vehicle, "--out", out,
                         timeout=600, expect=None)
        return self.json(f"{out}/diagnosis.json")

    def lag(self, found):
        said = {f["effect"]: f for f in found["findings"]}
        self.assertIn("tilt_servo_lag", said, found["summary"])
        value, = (p["value"] for p in said["tilt_servo_lag"]["parameters"] if p["name"] == "time_constant")
        return value

    def test_a_told_lag_and_play_are_nothing_missing_and_untold_are_found(self):
        self.flown(*SERVO, out="told")
        told = self.diagnosed("told", *SERVO)
        self.assertEqual(told["verdict"], "nothing_missing", told["summary"])
        self.assertGreater(self.lag(self.diagnosed("told")), 0.06)

    def test_a_hidden_lag_beside_a_told_one_is_found_as_the_difference(self):
        effects = self.write("late.yaml", "schema: omniflight.model/1\neffects:\n"
                                          "  - {id: tilt_servo_lag, parameters: {time_constant: 0.08, backlash: 0}}\n")
        self.flown(*SERVO, "--effects", effects, out="late")
        found = self.diagnosed("late", *SERVO)
        self.assertAlmostEqual(self.lag(found), 0.08, delta=0.02)
        self.assertIn("later than the vehicle file says", found["summary"])

    @unittest.skipUnless((PROOF / "omniflight_mujoco_plant").exists(), "built without MuJoCo (Debian: libmujoco-dev)")
    def test_the_second_plant_flies_it_as_well(self):
        self.flown(*SERVO, "--plant", "mujoco", out="second")
        told = self.diagnosed("second", *SERVO)
        self.assertEqual(told["verdict"], "nothing_missing", told["summary"])
        self.assertGreater(self.lag(self.diagnosed("second")), 0.06)


if __name__ == "__main__":
    unittest.main()
