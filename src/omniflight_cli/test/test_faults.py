"""`fly --faults`: what breaks on a schedule is flown and recorded, and a schedule that makes no sense is refused."""

import csv
import shutil

import system

SCHEDULE = "schema: omniflight.faults/1\nfaults:\n  - {%s}\n"


class Faults(system.SystemTest):
    def schedule(self, fault):
        return self.write("faults.yaml", SCHEDULE % fault)

    def error(self, flight, axis):
        return flight["metrics"]["true"]["position_rmse_m"][axis]

    def column(self, recording, name):
        """[(time, value)] of one column of a recording."""
        self.run_command("export", recording, "--to", "csv", "--out", "flight.csv", "--quiet")
        with open(self.dir / "flight.csv", newline="") as file:
            return [(float(row["t_s"]), float(row[name])) for row in csv.DictReader(file) if row[name]]

    def test_a_gust_pushes_along_its_axis_and_no_other(self):
        common = ("--in-process", "--sensors", "ideal")
        calm = self.fly("trajectory_1", *common, out="calm")
        gust = self.fly("trajectory_1", *common, "--faults", self.schedule("at_s: 6, kind: gust, for_s: 1, force_N: [3, 0, 0]"))
        self.assertEqual(gust["verdict"], "flown")
        self.assertGreater(self.error(gust, "x"), 5 * self.error(calm, "x"))
        self.assertAlmostEqual(self.error(gust, "y"), self.error(calm, "y"), delta=1e-5)

    def test_a_rotor_without_power_stops_and_comes_back(self):
        # it falls into the frame while the rotor is without power (the plant knows no contacts), and recovers
        flight = self.fly("trajectory_1", "--in-process", "--sensors", "ideal", "--faults", "rotor_loss",
                          "-p", "allocator.drop_lost_rotors=false", expect=2)
        self.assertEqual(flight["verdict"], "lost")
        self.assertIn("into the obstacles", flight["reason"])
        self.assertTrue(flight["complete"])
        self.assertLess(flight["judged"]["end_error_m"], 0.1)
        speed = self.column("flight/flight.mcap", "rotor3_radps")
        start = speed[0][0]
        mean = lambda a, b: sum(abs(w) for t, w in speed if a <= t - start < b) / sum(a <= t - start < b for t, _ in speed)
        self.assertLess(mean(7, 8), 0.05 * mean(5, 6), "powerless from 6 s on, its speed decays within a second")
        self.assertGreater(mean(9, 10), 0.5 * mean(5, 6), "power is back after 8 s")

    def test_a_lost_rotor_is_left_out_and_the_others_fly_on(self):
        lost = self.schedule("at_s: 6, kind: rotor_loss, rotor: 3")  # for good
        flight = self.fly("trajectory_1", "--in-process", "--sensors", "laboratory", "--faults", lost)
        self.assertEqual(flight["verdict"], "flown")
        log = "".join(p.read_text() for p in (self.dir / "flight/log").iterdir())
        self.assertIn("rotor 3 does not turn as commanded and is left out; the others need ", log)
        thrust = self.column("flight/flight.mcap", "u3_N")
        start = thrust[0][0]
        self.assertTrue(all(u == 0 for t, u in thrust if t - start > 6.5))
        self.assertTrue(any(abs(u) > 0.5 for t, u in thrust if t - start < 6))

    def test_an_upper_rotor_that_dies_in_motion_does_not_turn_the_vehicle_over(self):
        # an instant at which the others used to keep the vehicle in its place, and turned it by 112 deg about z meanwhile
        lost = self.schedule("at_s: 10.592, kind: rotor_loss, rotor: 1")
        flight = self.fly("trajectory_1", "--in-process", "--sensors", "laboratory", "--faults", lost)
        self.assertEqual(flight["verdict"], "flown", flight["reason"])
        self.assertLess(flight["metrics"]["true"]["worst_position_m"], 0.1)
        self.assertLess(max(flight["metrics"]["true"]["attitude_rmse_deg"].values()), 2)

    def test_a_coaxial_octorotor_flies_on_and_a_hexarotor_cannot(self):
        lost = self.schedule("at_s: 6, kind: rotor_loss, rotor: 3")
        flight = self.fly("sideways", "--vehicle", "coaxial_x8", "--in-process", "--faults", lost, out="eight")
        self.assertEqual(flight["verdict"], "flown")
        self.fly("sideways", "--vehicle", "hexarotor_2300g", "--in-process", "--faults", lost, out="six", expect=2)
        log = "".join(p.read_text() for p in (self.dir / "six/log").iterdir())
        self.assertIn("failsafe ramp_down: rotors_lost", log)

    def test_a_quadrotor_without_a_rotor_says_so_and_ends_by_the_ladder(self):
        flight = self.fly("sideways", "--in-process", "--faults",
                          self.schedule("at_s: 6, kind: rotor_loss, rotor: 1"), expect=2)
        self.assertNotEqual(flight["verdict"], "flown")
        log = "".join(p.read_text() for p in (self.dir / "flight/log").iterdir())
        self.assertIn("rotor 1 does not turn as commanded and is left out; the others cannot hold", log)
        self.assertIn("failsafe ramp_down: rotors_lost", log)

    def test_a_descent_ends_at_the_ground_of_the_test_bed(self):
        beds = system.CONFIGS / "test_beds"
        shutil.copy(beds / "pyramid.bt", self.dir / "bed.bt")
        text = (beds / "pyramid.yaml").read_text()
        self.assertIn("ground_z: 0.0 ", text)
        self.write("bed.yaml", text.replace("ground_z: 0.0 ", "ground_z: 0.9 "))  # above the counter of the map
        mission = self.short_mission(changes={"test_bed: pyramid": "test_bed: bed.bt"})
        flight = self.fly(mission, "--in-process", "--sensors", "laboratory", "--faults",
                          self.schedule("at_s: 4.5, kind: sensor_loss, sensor: mocap, for_s: 60"), expect=2)
        self.assertIn("failsafe ended the flight", flight["reason"])
        heights = [z for _, z in self.column("flight/flight.mcap", "ref_pz_m")]
        self.assertAlmostEqual(min(heights), 1.0, delta=0.05, msg="0.1 m above it count as landed")
        self.assertIn("ends at the ground of the test bed, 0.90 m", self.failsafe_words())

    def failsafe_words(self):
        """Lines of the failsafe in the logs of the flight."""
        log = "\n".join(p.read_text() for p in sorted((self.dir / "flight/log").iterdir()))
        return "\n".join(line for line in log.splitlines() if "failsafe" in line)

    def test_a_descent_ends_on_what_is_below_the_vehicle(self):
        # below the start of the mission the shipped map has a counter whose top is at 0.58 m, its voxels' at 0.6 m
        self.fly(self.short_mission(), "--in-process", "--sensors", "laboratory", "--faults",
                 self.schedule("at_s: 4.5, kind: sensor_loss, sensor: mocap, for_s: 60"), expect=2)
        lowest = min(z for _, z in self.column("flight/flight.mcap", "ref_pz_m"))
        # at a tilt of 30 deg the vehicle's lowest points are 0.125 m + 0.1016 m sin(30 deg) below its origin
        contact = 0.6 + 0.125 + 0.0508
        self.assertGreater(lowest, contact)
        # 0.05 m above contact count as landed, spheres stick out of the discs by 0.03 m, the vehicle is a little ahead
        self.assertLess(lowest, contact + 0.12)
        words = self.failsafe_words()
        for action in ("descend", "ramp_down"):
            self.assertRegex(words, f"failsafe {action}: pose_lost; ends on what the map has at 0.60 m, the body origin at 0.8")

    def test_what_cannot_break_is_refused(self):
        for fault, where in (("at_s: 6, kind: rotor_loss, rotor: 9", "rotor"), ("at_s: 6, kind: gremlin", "kind"),
                             ("at_s: -1, kind: rotor_loss, rotor: 1", "at_s")):
            done = self.run_command("fly", "trajectory_1", "--faults", self.schedule(fault), "--out", "x", expect=4)
            self.assertIn("faults.yaml", done.stderr)
            self.assertIn(where, done.stderr)
        done = self.run_command("fly", "trajectory_1", "--plant", "emulator", "--faults", "rotor_loss", "--out", "x", expect=4)
        self.assertIn("--plant simulator", done.stderr)
