"""The vehicle that flies is the one that was planned for; what cannot hover or move as asked is refused before."""

import unittest

import system


class PlanAndVehicle(system.SystemTest):
    def refused(self, *arguments, words, out="refused"):
        done = self.run_command(*arguments, "--out", out, expect=4)
        for word in words:
            self.assertIn(word, done.stderr)
        self.assertFalse((self.dir / out).exists(), "something was written")

    def test_a_heavier_vehicle_does_not_fly_on_the_certificate_of_a_lighter_one(self):
        mission = self.short_mission()
        self.run_command("plan", mission, "--out", "light")
        heavy = ("--set", "mass=1.595")
        self.refused("fly", mission, "--plan", "light", *heavy, words=("1.315 kg", "1.595 kg", "Plan again"))
        self.refused("fly", mission, "--plan", "light", "--vehicle", "omnimorph@table_4_1", words=("kg", "Plan again"))
        self.run_command("plan", mission, *heavy, "--out", "heavy")
        certificate = self.json("heavy/certificate.json")
        self.assertEqual(certificate["vehicle"]["mass_kg"], 1.595)
        self.assertEqual(certificate["vehicle"]["set"], ["mass=1.595"])
        self.run_command("plan", "verify", "heavy")
        self.fly(mission, "--plan", "heavy", *heavy, "--in-process", out="flown")
        self.fly(mission, *heavy, "--in-process", out="planned_again")
        self.assertEqual(self.json("planned_again/plan/certificate.json")["vehicle"]["mass_kg"], 1.595)

    def test_what_a_flight_measured_is_a_margin_of_the_next_plan(self):
        mission = self.short_mission()
        measured = self.fly(mission, "--in-process", "--sensors", "laboratory", out="first")["metrics"]
        worst = max(measured[whose]["worst_position_m"] for whose in ("measured", "true"))
        self.run_command("plan", mission, "--tube", "first/flight.json", "--out", "kept")
        tube = self.json("kept/certificate.json")["tube"]
        self.assertAlmostEqual(tube["position_m"], worst)
        self.assertTrue(tube["in_margin"])
        self.assertGreater(tube["margin_m"], worst)
        self.run_command("plan", "verify", "kept")
        again = self.fly(mission, "--plan", "kept", "--in-process", "--sensors", "laboratory", out="again")
        self.assertEqual(again["judged"]["position_bound_m"], max(0.08, worst))
        self.refused("plan", mission, "--tube", "kept/certificate.json", words=("certificate.json", "omniflight.flight/1"))

    def test_a_planner_is_chosen_by_name(self):
        mission = self.short_mission()
        self.run_command("plan", mission, "--planner", "bitstar", "--out", "named")
        self.assertEqual(self.json("named/certificate.json")["planner"], "bitstar")
        self.run_command("plan", "verify", "named")
        self.refused("plan", mission, "--planner", "dijkstra", words=("dijkstra", "rrtstar"))

    def test_a_plan_is_not_flown_under_another_missions_name(self):
        self.run_command("plan", "trajectory_1", "--out", "one")
        self.refused("fly", self.short_mission(), "--plan", "one", words=("'trajectory_1'", "'short'", "--plan"))

    def test_what_cannot_hover_is_refused_before_take_off(self):
        mission = self.short_mission()
        self.refused("fly", mission, "--set", "mass=1400", words=("hover", "1400"))
        self.refused("fly", mission, "-p", "allocator.alpha_deg=90", words=("allocator.alpha_deg", "hover"))

    def test_a_plain_quadrotor_leans_sideways_and_climbs(self):
        self.run_command("new", "vehicle", "plain", "--out", ".")
        plain = f"vehicle: {self.dir}/configs/vehicles/plain/plain.yaml"
        aside = self.short_mission(changes={"vehicle: omnimorph": plain})  # alpha_deg does not apply to it
        self.run_command("plan", aside, "--out", "aside")
        certificate = self.json("aside/certificate.json")
        self.assertTrue(certificate["attitude"]["from_acceleration"])
        self.assertIn("does not tilt", certificate["reason"])
        self.run_command("plan", "verify", "aside")
        up = self.short_mission("up.yaml", changes={"vehicle: omnimorph": plain,
                                                    "alpha_deg: 30": "alpha_deg: 0", "[0.1, 0, 0.1]": "[0, 0, 0.1]"})
        self.run_command("plan", up, "--out", "up")


if __name__ == "__main__":
    unittest.main()
