"""Plans that begin in flight, from a state of another plan: certified and verified; without one the old plan is kept."""

import unittest

import system


class Replanning(system.SystemTest):
    def setUp(self):
        super().setUp()
        self.run_command("plan", "trajectory_2", "--out", "old")
        self.knots = self.json("old/trajectory.json")["knots"]
        speed = [sum(v * v for v in k["v"]) for k in self.knots]
        self.at = max(range(len(speed)), key=speed.__getitem__)
        self.next = self.write("next.yaml", """schema: omniflight.mission/1
name: elsewhere
vehicle: omnimorph
test_bed: pyramid
alpha_deg: search
clearance_m: 0.05
budget_ms: 50000
start: {position: [0, 0, 1]}
waypoints:
  - {position: [0.3, 0.2, 1.2], hold_s: 0.5}
""")

    def test_a_new_goal_in_flight_joins_the_old_plan(self):
        knot = self.knots[self.at]
        before = {p.name: p.read_bytes() for p in (self.dir / "old").iterdir()}
        self.run_command("plan", self.next, "--from", f"old@{knot['t']}", "--out", "new")
        first = self.json("new/trajectory.json")["knots"][0]
        for key in ("p", "v", "a", "w", "dw"):
            for mine, theirs in zip(first[key], knot[key]):
                self.assertAlmostEqual(mine, theirs, places=9)
        self.assertGreater(max(map(abs, first["v"])), 0.05)
        certificate = self.json("new/certificate.json")
        self.assertEqual(certificate["verdict"], "certified")
        self.assertIn("j", certificate["from"])
        self.assertIn("verified", self.run_command("plan", "verify", "new").stdout)
        self.assertEqual(before, {p.name: p.read_bytes() for p in (self.dir / "old").iterdir()})
        done = self.run_command("fly", self.next, "--plan", "new", "--out", "flight", expect=4)
        self.assertIn("begins in flight", done.stderr)

    def test_without_a_plan_the_reason_is_told_and_the_old_one_is_kept(self):
        before = {p.name: p.read_bytes() for p in (self.dir / "old").iterdir()}
        far = self.write("far.yaml", self.next.read_text().replace("[0.3, 0.2, 1.2]", "[300, 0, 1.2]"))
        t = self.knots[self.at]["t"]
        for arguments, code, word in (((far, "--from", f"old@{t}"), 4, "outside the map"),
                                      ((self.next, "--from", "old@1e9"), 4, "outside of the trajectory"),
                                      ((self.next, "--from", "old"), 4, "FOLDER@TIME"),
                                      ((self.next, "--from", "nothing@1"), 4, "nothing")):
            done = self.run_command("plan", *arguments, "--out", "none", expect=code)
            self.assertIn(word, done.stderr)
        self.assertFalse((self.dir / "none").exists())
        self.assertEqual(before, {p.name: p.read_bytes() for p in (self.dir / "old").iterdir()})


if __name__ == "__main__":
    unittest.main()
