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


class InFlight(system.SystemTest):
    """`replan` beside a flight in real time."""

    DOMAIN = 133

    def start_flight(self, *arguments):
        """A flight that hovers when it is returned, and its folder."""
        mission = self.hovering_mission(hold_s=6)
        fly = self.start_command("fly", mission, "--rate", "realtime", "--domain", self.DOMAIN, "--out", "flight", "--quiet",
                                 *arguments)
        system.wait_until("the planner", lambda: (self.dir / "flight/log/simulator.log").exists(), 30)
        return fly

    def goal(self, name, position):
        return self.short_mission(f"{name}.yaml", changes={"name: short": f"name: {name}",
                                                           "by: [0.1, 0, 0.1]": f"position: {position}"})

    def replan(self, mission, *arguments, **options):
        done = self.run_command("replan", mission, "--domain", self.DOMAIN, "--json", *arguments, **options)
        return system.json.loads(done.stdout)

    def test_a_mission_that_is_asked_for_is_flown_and_judged(self):
        fly = self.start_flight("--stay", "6")
        refused = self.replan(self.goal("far", "[300, 0, 1.2]"), expect=2)
        self.assertTrue(refused["heard"], refused)
        self.assertIn("outside the map", refused["reason"])
        joined = self.replan(self.goal("near", "[0.2, 0.1, 1.2]"))
        self.assertTrue(joined["joined"])
        output = fly.communicate(timeout=60)
        self.assertEqual(fly.returncode, 0, output)
        flight = self.json("flight/flight.json")
        self.assertEqual(flight["verdict"], "flown", flight["reason"])
        self.assertTrue(any("near was flown from" in remark for remark in flight["remarks"]), flight["remarks"])
        last = self.json("flight/replans/1/trajectory.json")["knots"][-1]["p"]
        self.assertEqual([round(x, 6) for x in last], [0.2, 0.1, 1.2])
        self.assertLess(flight["judged"]["end_error_m"], 0.05)

    def test_a_plan_that_ends_after_the_flight_is_not_flown(self):
        fly = self.start_flight()
        mission = self.short_mission("late.yaml", changes={"by: [0.1, 0, 0.1], hold_s: 0.5":
                                                           "position: [0.2, 0.1, 1.2], hold_s: 60"})
        refused = self.replan(mission, expect=2)
        self.assertIn("after the flight does", refused["reason"])
        self.assertEqual(fly.wait(60), 0)
        self.assertFalse((self.dir / "flight/replans").exists())

    def test_mistakes_are_told_before_anybody_is_asked(self):
        mission = self.short_mission()
        self.assertIn("no planner listens", self.replan(mission, expect=2)["reason"])
        done = self.run_command("replan", "no_such_mission", "--domain", self.DOMAIN, expect=4)
        self.assertIn("no_such_mission", done.stderr)


if __name__ == "__main__":
    unittest.main()
