"""`fly --neighbour`: the wash of another vehicle presses the one below it down, and what is no track is refused."""

import system


class Neighbour(system.SystemTest):
    def height_error(self, out, *options):
        flight = self.fly("trajectory_1", "--in-process", "--sensors", "ideal", *options, out=out)
        self.assertEqual(flight["verdict"], "flown")
        return flight["metrics"]["true"]["position_rmse_m"]["z"]

    def track(self, height):
        return self.write(f"at_{height}.csv", f"t_s,px_m,py_m,pz_m\n0,0,0,{height}\n")

    def test_a_neighbour_above_presses_and_one_far_away_does_not(self):
        calm = self.height_error("calm")
        below = self.height_error("below", "--neighbour", self.track(2.5))
        self.assertGreater(below, 1.5 * calm)
        away = self.height_error("away", "--neighbour", self.track(-500))
        self.assertAlmostEqual(away, calm, delta=1e-6)

    def test_what_is_no_track_is_refused(self):
        bad = self.write("bad.csv", "t_s,alpha_rad\n0,0.1\n1,0.1\n")
        done = self.run_command("fly", "trajectory_1", "--neighbour", bad, "--out", "x", expect=4)
        self.assertIn("px_m", done.stderr)
        done = self.run_command("fly", "trajectory_1", "--neighbour", "nowhere.csv", "--out", "x", expect=4)
        self.assertIn("nowhere.csv", done.stderr)
        done = self.run_command("fly", "trajectory_1", "--plant", "emulator", "--neighbour", self.track(2.5), "--out", "x",
                                expect=4)
        self.assertIn("--plant simulator", done.stderr)
