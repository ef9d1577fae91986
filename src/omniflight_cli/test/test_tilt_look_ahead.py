"""`fly --tilt lookahead`: the tilt over the whole plan, found before it is flown."""

import re
import unittest

import system


class LookAhead(system.SystemTest):
    def test_a_full_roll_takes_less_power_than_at_one_tilt(self):
        self.run_command("plan", "full_roll", "--out", "plan")
        common = ("--plan", "plan", "--in-process", "--sensors", "ideal")
        fixed = self.fly("full_roll", *common, out="fixed")
        ahead = self.fly("full_roll", *common, "--tilt", "lookahead", out="ahead")
        self.assertEqual(ahead["verdict"], "flown")
        self.assertLess(ahead["metrics"]["power_W"], 0.9 * fixed["metrics"]["power_W"])
        text = (self.dir / "ahead/tilt.yaml").read_text()
        period = float(re.search(r"period_s: (\S+)", text)[1])
        tilts = [float(x) for x in re.search(r"alpha_deg: \[(.*)\]", text, re.S)[1].split(",")]
        self.assertGreater(max(tilts), 45, "upside down and on its side it has to tilt")
        self.assertLess(min(tilts), 10, "level it has not")
        for a, b in zip(tilts, tilts[1:]):
            self.assertLessEqual(abs(b - a), 30 * period + 1e-6, "deg: the servo does 30 deg/s")

    def test_what_cannot_follow_a_tilt_is_refused(self):
        for arguments, words in ((("trajectory_1", "--plant", "emulator"), "boards of the emulator"),
                                 (("sideways",), "leans into the motion"),
                                 (("sideways", "--vehicle", "tilted_hexarotor"), "does not tilt"),
                                 (("full_roll", "-p", "allocator.alpha_deg=50"), "contradict"),
                                 (("full_roll", "--tilt-reserve", "2"), "tilt-reserve"),
                                 (("full_roll", "-p", "allocator.tilt_schedule=tilt.yaml"), "tilt_schedule")):
            with self.subTest(arguments=arguments):
                done = self.run_command("fly", *arguments, "--tilt", "lookahead", "--out", "x", expect=4)
                self.assertIn(words, done.stderr)

    def test_long_the_campaign_of_survival_ends_as_expected(self):
        self.run_command("campaign", system.CONFIGS / "campaigns/tilt_survival.yaml", "--out", "many", "--quiet",
                         expect=None, timeout=300)
        campaign = self.json("many/campaign.json")
        flights = {(f["effect"], f["variant"]): f for f in campaign["flights"]}
        survived = lambda key: flights[key]["verdict"] in ("flown", "flown_badly")
        for rate in (10, 30):
            for effect in ("none", "tilt_mismatch"):
                self.assertTrue(survived((effect, f"look_ahead_{rate}")), (effect, rate))
        self.assertTrue(survived(("tilt_mismatch", "case_a_30")))
        for variant in ("case_b_30", "case_a_10", "case_b_10", "dynamic_10"):
            self.assertFalse(survived(("tilt_mismatch", variant)), variant)


if __name__ == "__main__":
    unittest.main()
