"""The effect `controller_mismatch` acts in a flight: what the allocator asks for is not what the rotors get."""

import csv

import system

MODEL = ("schema: omniflight.model/1\neffects:\n"
         "  - {id: controller_mismatch, parameters: {force: 0.1, roll_pitch: -0.3, yaw: -0.5}}\n")


class ControllerMismatch(system.SystemTest):
    def flight(self, out, *options):
        return self.fly("trajectory_1", "--in-process", "--sensors", "ideal", *options, out=out)

    def speed_ratio(self, out):
        """Mean of measured over commanded speed, all rotors, after the take-off."""
        self.run_command("export", f"{out}/flight.mcap", "--to", "csv", "--out", f"{out}.csv", "--quiet")
        ratios, command = [], {}
        with open(self.dir / f"{out}.csv", newline="") as file:
            rows = csv.DictReader(file)
            for row in rows:
                for rotor in range(1, 9):
                    if row[f"rotor{rotor}_cmd_radps"]:
                        command[rotor] = float(row[f"rotor{rotor}_cmd_radps"])
                    speed = row[f"rotor{rotor}_radps"]
                    if speed and float(row["t_s"]) > 5 and command.get(rotor):
                        ratios.append(float(speed) / command[rotor])
        return sum(ratios) / len(ratios)

    def test_it_tracks_worse_and_the_rotors_turn_faster_than_asked(self):
        calm = self.flight("calm")
        wrong = self.flight("wrong", "--effects", self.write("wrong.yaml", MODEL))
        self.assertEqual(wrong["verdict"], "flown")
        for axis in "xy":
            error = [f["metrics"]["true"]["position_rmse_m"][axis] for f in (calm, wrong)]
            self.assertGreater(error[1], 1.5 * error[0])
        self.assertAlmostEqual(self.speed_ratio("calm"), 1.0, delta=0.005)
        # a force gain of 1.1 at equal lift: the controller asks for 1/1.1 of it, so sqrt(1.1) in speed
        self.assertAlmostEqual(self.speed_ratio("wrong"), 1.1 ** 0.5, delta=0.01)
