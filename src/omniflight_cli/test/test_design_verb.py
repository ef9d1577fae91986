"""`omniflight design`: the sweep over the tilt, and what is told of vehicles that lean."""

import math
import unittest

import system

GRAVITY = 9.81  # m/s^2, as omniflight_core has it


class Design(system.SystemTest):
    def test_a_quadrotor_gets_thrust_to_weight_and_lean_instead_of_zeros(self):
        rotors, thrust, mass = 4, 2.5, 0.5
        done = self.run_command("design", "quadrotor_300g", "--f-max", str(thrust), "--mass", str(mass), "--out", "d")
        actuation = self.json("d/design.json")["actuation"]
        ratio = rotors * thrust / (mass * GRAVITY)
        self.assertAlmostEqual(actuation["thrust_to_weight"], ratio, delta=1e-6 * ratio)
        self.assertAlmostEqual(actuation["lean_deg"], math.degrees(math.acos(1 / actuation["thrust_to_weight"])), places=6)
        self.assertGreater(actuation["torque_at_hover_Nm"], 0)
        self.assertIn(f"thrust to weight {actuation['thrust_to_weight']:.2f}", done.stderr + done.stdout)
        self.assertIn("holds its height while it leans", (self.dir / "d/report.html").read_text())

    def test_the_power_of_hovering_is_mapped_over_attitude_and_tilt(self):
        done = self.run_command("design", "omnimorph", "--alpha", "30", "--hover-power", "--out", "d", timeout=120)
        power = self.json("d/design.json")["hover_power"]
        self.assertEqual([round(a, 9) for a in power["alpha_deg"]], [5 * k for k in range(13)])
        self.assertEqual([round(a, 9) for a in power["lean_deg"]], [15 * k for k in range(13)])
        # upright without tilt: eight times drag_ratio T sqrt(T/c_f) of an eighth of the weight
        thrust = 1.315 * GRAVITY / 8
        self.assertAlmostEqual(power["power_W"][0][0], 8 * 0.0165 * thrust * math.sqrt(thrust / 4.76e-6), delta=0.05)
        on_its_side = power["power_W"][6]
        self.assertIsNone(on_its_side[0], "without tilt there is no force aside")
        self.assertGreater(on_its_side[11], 1.5 * power["power_W"][0][0])
        self.assertTrue(power["half_carried"], "along a tilt axis four rotors give nothing aside")
        for line in power["half_carried"]:
            self.assertIn(line, done.stdout + done.stderr)
        self.assertIn("Power of hovering, the most expensive direction of each lean", (self.dir / "d/report.html").read_text())

    def test_the_map_of_survival_says_where_look_ahead_is_better(self):
        done = self.run_command("design", "omnimorph", "--survival", "--out", "map", timeout=300)
        survival = self.json("map/survival.json")
        cells = survival["cells"]
        self.assertEqual(len(cells), 144)
        for method, count in survival["survived"].items():
            self.assertEqual(sum(cell[method]["survived"] for cell in cells), count, method)
        for cell in cells:
            a, ahead, told = cell["case_a"], cell["look_ahead"], cell["look_ahead_told"]
            self.assertTrue(ahead["survived"] and told["survived"], cell)
            if a["survived"]:
                self.assertLess(told["power_W"], a["power_W"], cell)
        self.assertLess(survival["survived"]["case_a"], 100)
        page = (self.dir / "map/report.html").read_text()
        self.assertIn(f"Dynamic weights with look-ahead survive 144 of 144, case A {survival['survived']['case_a']}", page)
        self.assertIn(f"case B: survives {survival['survived']['case_b']} of 144", page)
        self.assertIn("look-ahead that is told the loss", done.stdout + done.stderr)
        for arguments, words in ((("omnimorph", "omnicopter"), "maps one vehicle"), (("quadrotor_300g",), "does not tilt"),
                                 (("omnimorph", "--alpha", "30"), "--alpha")):
            self.assertIn(words, self.run_command("design", *arguments, "--survival", expect=4).stderr)

    def test_two_designs_stand_beside_each_other_with_their_differences(self):
        alone = {}
        for name, alpha in (("omnimorph", "54.7356"), ("omnicopter", "0")):
            self.run_command("design", name, "--alpha", alpha, "--f-max", "5.95", "--mass", "1.595", "--out", name)
            alone[name] = self.json(f"{name}/design.json")["points"][0]
        done = self.run_command("design", "omnimorph", "omnicopter", "--alpha", "54.7356", "--f-max", "5.95", "--mass", "1.595",
                                "--out", "both")
        compared = self.json("both/comparison.json")
        figures = {f["figure"]: f for f in compared["figures"][0]}
        inradius = figures["force inradius"]
        for key, name in (("first", "omnimorph"), ("second", "omnicopter")):
            self.assertEqual(inradius[key], alone[name]["force_at_zero_torque"]["d_min_surface"])
            self.assertEqual(figures["mass limit"][key], alone[name]["mass_limit_kg"])
            self.assertEqual(figures["torque inradius"][key], alone[name]["torque_at_zero_force"]["d_min_surface"])
        self.assertAlmostEqual(inradius["difference"], inradius["second"] - inradius["first"], places=12)
        self.assertAlmostEqual(inradius["first"], 19.43, places=2)  # N, the thesis's 19.4
        self.assertLess(inradius["second"], inradius["first"], "drag torques of one hand take some of the omnicopter's")
        self.assertAlmostEqual(figures["tilt"]["first"], 54.7356, places=6)
        self.assertEqual([d["vehicle"] for d in compared["designs"]], ["omnimorph", "omnicopter"])
        page = (self.dir / "both/report.html").read_text()
        self.assertIn("omnimorph at 54.74 deg lifts 1.98 kg in every attitude, omnicopter lifts", page)
        for words in ("omnimorph at 54.74 deg", "omnicopter", "difference", "Forces at zero torque over the weight"):
            self.assertIn(words, page)
        self.assertIn("torque inradius in the worst attitude [Nm]", done.stdout + done.stderr)

    def test_designs_without_a_tilt_given_are_compared_at_their_best(self):
        self.run_command("design", "tilted_hexarotor", "quadrotor_1200g", "--out", "both")
        compared = self.json("both/comparison.json")
        self.assertEqual(len(compared["figures"]), 1)
        figures = {f["figure"]: f for f in compared["figures"][0]}
        self.assertEqual((figures["rank"]["first"], figures["rank"]["second"]), (6, 4))
        self.assertAlmostEqual(figures["force inradius"]["second"], 0, places=9, msg="along one axis only")
        self.assertNotIn("first", figures["hovers in every attitude from"], "neither does")
        done = self.run_command("design", "tilted_hexarotor", "quadrotor_1200g", "--hover-power", expect=4)
        self.assertIn("maps one vehicle", done.stderr)

    def test_the_sweep_is_dense_and_crosses_the_weight_at_the_marked_tilt(self):
        self.run_command("design", "omnimorph", "--alpha", "30", "--f-max", "5.95", "--mass", "1.595", "--out", "d")
        design = self.json("d/design.json")
        self.assertEqual(len(design["points"]), 1)
        self.assertEqual(len(design["sweep"]), 61)
        marked = design["smallest_omnidirectional_tilt_deg"]
        self.assertAlmostEqual(marked, 41.10, delta=0.01)
        for point in design["sweep"]:
            self.assertEqual(point["force_inradius_N"] >= 1.595 * GRAVITY, point["alpha_deg"] >= marked, point)
            self.assertAlmostEqual(point["mass_limit_kg"] * GRAVITY, point["force_inradius_N"], places=3)
        self.assertIn("hovers in every attitude from 41.10 deg on", (self.dir / "d/report.html").read_text())


if __name__ == "__main__":
    unittest.main()
