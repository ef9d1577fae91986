"""The error-state filter beside the fixed-gain observer, in flights: the figures by which the default is chosen."""

import math
import unittest

import system


class Estimators(system.SystemTest):
    def errors(self, sensors, estimator, seed):
        """True position [mm] and attitude [deg] RMSE of trajectory_2."""
        flight = self.fly("trajectory_2", "--plan", "plan", "--sensors", sensors, "--in-process", "--seed", seed, "-p",
                          f"controller.estimator={estimator}", out=f"{sensors}_{estimator}_{seed}")
        self.assertEqual(flight["verdict"], "flown")
        true = flight["metrics"]["true"]
        return [math.sqrt(sum(v * v for v in true[key].values())) for key in ("position_rmse_m", "attitude_rmse_deg")]

    def test_long_the_filter_flies_closer_than_the_observer(self):
        self.run_command("plan", "trajectory_2", "--out", "plan", "--quiet")
        for sensors in ("laboratory", "degraded"):
            mean = {}
            for estimator in ("fixed_gain", "error_state"):
                flights = [self.errors(sensors, estimator, seed) for seed in (1, 2)]
                mean[estimator] = [sum(column) / len(flights) for column in zip(*flights)]
                print(f"\n{sensors} {estimator}: {1e3 * mean[estimator][0]:.3f} mm, {mean[estimator][1]:.4f} deg")
            for filtered, observed in zip(mean["error_state"], mean["fixed_gain"]):
                self.assertLess(filtered, observed)

    def test_an_unknown_estimator_is_refused(self):
        done = self.run_command("fly", self.short_mission(), "--in-process", "-p", "controller.estimator=kalman", "--out", "x",
                                expect=4)
        self.assertIn("neither fixed_gain nor error_state", done.stderr)


if __name__ == "__main__":
    unittest.main()
