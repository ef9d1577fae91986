"""Input that cannot be used: the right exit code, a message that names file, field and next step, nothing written."""

import random
import unittest

import system

BAD_INPUT, NO_RESULT = 4, 2


class Refused(system.SystemTest):
    def refused(self, arguments, code, *words):
        done = self.run_command(*arguments, "--out", "refused", expect=code)
        for word in words:
            self.assertIn(word, done.stderr)
        self.assertEqual(len(done.stderr.strip().splitlines()), 1, "more than one sentence: " + done.stderr)
        self.assertFalse((self.dir / "refused").exists(), "something was written")

    def mission(self, old, new):
        return self.short_mission("bad.yaml", changes={old: new})


class Missions(Refused):
    def test_unknown_key(self):
        self.refused(("fly", self.mission("seed: 1", "sead: 1")), BAD_INPUT, "bad.yaml:7", "sead", "Did you mean 'seed'")

    def test_start_inside_the_frame(self):
        bad = self.mission("[0, 0, 1.3]", "[0.75, -0.75, 1.5]")
        self.refused(("fly", bad), BAD_INPUT, "bad.yaml:10", "start", "frame beam", "Move the waypoint")
        self.refused(("plan", bad), BAD_INPUT, "bad.yaml:10", "start", "frame beam", "Move the waypoint")

    def test_goal_outside_the_map(self):
        self.refused(("fly", self.mission("by: [0.1, 0, 0.1]", "position: [0, 0, 40]")), BAD_INPUT, "bad.yaml:12",
                     "waypoints[0]", "outside the map", "Move the waypoint")

    def test_unreachable_goal(self):
        # out between the beams: with 0.47 m to spare the vehicle does not fit through
        bad = self.short_mission("bad.yaml", changes={"by: [0.1, 0, 0.1]": "position: [0, -2.5, 1.3]",
                                                      "clearance_m: 0.08": "clearance_m: 0.47"})
        self.refused(("fly", bad), NO_RESULT, "bad.yaml:12", "waypoints[0]", "no path", "less clearance_m")

    def test_alpha_out_of_range(self):
        self.refused(("fly", self.mission("alpha_deg: 30", "alpha_deg: 75")), BAD_INPUT, "bad.yaml", "alpha_deg", "75",
                     "Choose an angle within the range")
        self.refused(("fly", self.mission("alpha_deg: 30", "alpha_deg: 200")), BAD_INPUT, "bad.yaml:5", "alpha_deg",
                     "200")
        self.refused(("design", "omnimorph", "--alpha", "500"), BAD_INPUT, "500", "Choose a tilt")

    def test_number_that_is_none(self):
        for value in (".nan", ".inf", "fast"):
            self.refused(("fly", self.mission("speed_mps: 0.3", f"speed_mps: {value}")), BAD_INPUT, "bad.yaml:9",
                         "speed_mps")

    def test_unknown_mission(self):
        self.refused(("fly", "trajectory_9"), BAD_INPUT, "trajectory_9")


class Plans(Refused):
    def on_map(self, content):
        """A mission on a map beside it, with this content."""
        (self.dir / "own.bt").write_bytes(content)
        return self.mission("test_bed: pyramid", "test_bed: own.bt")

    def test_maps(self):
        pyramid = (system.CONFIGS / "test_beds/pyramid.bt").read_bytes()
        self.run_command("plan", self.on_map(pyramid), "--out", "planned", "--quiet")
        self.refused(("plan", self.on_map(pyramid[:len(pyramid) // 2])), BAD_INPUT, "own.bt")
        self.refused(("plan", self.on_map(b"")), BAD_INPUT, "own.bt")
        (self.dir / "own.bt").unlink()
        self.refused(("plan", self.dir / "bad.yaml"), BAD_INPUT, "test_bed", "own.bt", "Give a .bt or .ot file")

    def test_a_tether_that_is_too_short(self):
        bad = self.mission("seed: 1", "seed: 1\ntether: {anchor: [0, 0, 0.6], length_m: 0.5}")
        self.refused(("plan", bad), BAD_INPUT, "start", "tether_too_short", "0.5", "Give a longer tether")

    def test_no_time(self):
        self.refused(("plan", self.short_mission("bad.yaml"), "--budget-ms", 0), BAD_INPUT, "--budget-ms", "must be more than 0")
        self.refused(("plan", self.short_mission("bad.yaml"), "--budget-ms", -1), BAD_INPUT, "--budget-ms")

    def test_a_goal_that_is_walled_in(self):
        walls = ", ".join(f"{{name: wall {k}, kind: box, center: [{x}, {y}, 1.5], size: [{a}, {b}, 3.5]}}"
                          for k, (x, y, a, b) in enumerate(((0, -1.6, 2.4, 0.1), (0, -3.4, 2.4, 0.1), (-1.2, -2.5, 0.1, 2), (1.2, -2.5, 0.1, 2))))
        bad = self.short_mission("bad.yaml", changes={"by: [0.1, 0, 0.1]": "position: [0, -2.5, 1.3]",
                                                      "seed: 1": f"seed: 1\nkeep_in: {{min: [-3.6, -3.6, -0.1], max: [3.6, 3.6, 3]}}\nkeep_out: [{walls}]"})
        self.refused(("plan", bad), 3, "proven_impossible", "waypoints[0]", "open the test bed")


class Vehicles(Refused):
    def test_without_inertia(self):
        text = (system.CONFIGS / "vehicles/crazyflie_brushless/crazyflie_brushless.yaml").read_text()
        lines = [line for line in text.splitlines() if not line.startswith(("inertia:", "urdf:"))]
        self.assertLess(len(lines), len(text.splitlines()))
        vehicle = self.write("light.yaml", "\n".join(lines))
        self.refused(("design", vehicle), BAD_INPUT, "light.yaml", "inertia", "Add the key inertia")
        mission = self.mission("vehicle: omnimorph", f"vehicle: {vehicle}")
        self.refused(("fly", mission), BAD_INPUT, "light.yaml", "inertia", "Add the key inertia")

    def test_negative_mass(self):
        self.refused(("fly", self.short_mission(), "--set", "mass=-1"), BAD_INPUT, "mass", "-1 kg", "Correct the value")
        self.refused(("design", "omnimorph", "--mass", "-1"), BAD_INPUT, "mass", "must be more than 0", "--help")
        self.refused(("design", "omnimorph", "--mass", "0"), BAD_INPUT, "mass", "must be more than 0", "--help")


class Models(Refused):
    def test_unknown_effect(self):
        model = self.write("model.yaml", "schema: omniflight.model/1\neffects:\n  - id: hung_cabel\n    parameters: {}\n")
        self.refused(("fly", self.short_mission(), "--effects", model), BAD_INPUT, "model.yaml:3", "hung_cabel",
                     "Did you mean 'hung_cable'")

    def test_unknown_file(self):
        self.refused(("fly", self.short_mission(), "--effects", "tetherr"), BAD_INPUT, "tetherr", "Did you mean 'tether'")

    def test_unknown_component_parameter(self):
        done = self.run_command("fly", self.short_mission(), "--param", "controller.kpp=3", "--out", "flight",
                                expect=BAD_INPUT)
        for word in ("omniflight_controller", "unknown parameter 'kpp'", "Known are", "kp"):
            self.assertIn(word, done.stderr)


class Weights(Refused):
    def test_neither_name_nor_file(self):
        self.refused(("fly", self.short_mission(), "--weights", "case_c"), BAD_INPUT, "case_c", "--weights", "dynamic")
        self.refused(("fly", self.short_mission(), "--weights", "dynamic"), BAD_INPUT, "25 1/s2", "has 12", "case_a")
        self.refused(("fly", self.short_mission(), "--weights", "dynamic", "-p", "controller.kp=[30, 30, 20]"), BAD_INPUT, "has 20")
        self.run_command("fly", self.short_mission(), "--weights", "dynamic", "--tilt", "search", "--in-process", "-p",
                         "controller.kp=[50, 50, 50]", "-p", "controller.kv=[10, 10, 10]", "--out", "stiff")

    def test_unknown_key(self):
        weights = self.write("weights.yaml", "schema: omniflight.weights/1\nbase: case_b\nw_imput: 1e-6\n")
        self.refused(("fly", self.short_mission(), "--weights", weights), BAD_INPUT, "weights.yaml:3", "w_imput",
                     "Did you mean 'w_input'")

    def test_a_file_is_flown(self):
        weights = self.write("weights.yaml", "schema: omniflight.weights/1\nbase: case_b\nw_input: 1e-6\n")
        self.fly(self.short_mission(), "--weights", weights, "--in-process")
        self.assertRegex((self.dir / "flight/params.yaml").read_text(), r"w_input: 9\.99\d*e-07|w_input: 1e-06")


class Domains(Refused):
    def test_a_second_run_in_the_same_domain(self):
        first = self.start_command("fly", self.short_mission(), "--rate", "realtime", "--domain", "190", "--out", "first")
        system.wait_until("the first flight", lambda: (self.dir / "first/flight.mcap").exists(), 30)
        self.refused(("fly", "short.yaml", "--domain", "190"), BAD_INPUT, "domain 190 is in use by another run", "domain",
                     "choose another domain")
        first.communicate(timeout=60)
        self.assertEqual(first.returncode, 0)
        self.assertEqual(self.json("first/flight.json")["verdict"], "flown")


class Recordings(Refused):
    def test_foreign(self):
        foreign = self.dir / "foreign.mcap"
        foreign.write_bytes(random.Random(1).randbytes(5000))
        self.run_command("info", foreign, expect=BAD_INPUT)
        for verb in (("compare", foreign, foreign), ("diagnose", foreign)):
            self.refused((*verb, "--vehicle", "omnimorph"), BAD_INPUT, "foreign.mcap", "Known formats")

    def test_truncated(self):
        self.fly(self.short_mission(), "--in-process")
        whole = (self.dir / "flight/flight.mcap").read_bytes()
        (self.dir / "start.mcap").write_bytes(whole[:12])
        self.refused(("diagnose", "start.mcap", "--vehicle", "omnimorph"), BAD_INPUT, "start.mcap", "record again")
        (self.dir / "second.mcap").write_bytes(whole[:100000])
        self.refused(("diagnose", "second.mcap", "--vehicle", "omnimorph"), BAD_INPUT, "second.mcap",
                     "Give a longer recording")
        info = self.run_command("info", "second.mcap")
        self.assertRegex(info.stdout, r"ends without its summary: \d+ messages were recovered")
        complete = self.run_command("info", "flight/flight.mcap")
        self.assertNotIn("without its summary", complete.stdout)


if __name__ == "__main__":
    unittest.main()
