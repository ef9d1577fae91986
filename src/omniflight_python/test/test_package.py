"""The package as a user meets it. Run by CTest with PYTHONPATH at the built package."""
import ast
import gc
import inspect
import os
import pathlib
import pickle
import signal
import tempfile
import threading
import time
import unittest

import numpy as np
import omniflight as of

PACKAGE = pathlib.Path(of.__file__).parent

# Half a metre up in four seconds: rest, motion, rest (minimum jerk), all at one attitude and tilt.
TIMES = np.linspace(0, 4, 41)


def climb():
    s = TIMES / 4
    position = np.zeros((len(s), 3))
    position[:, 2] = 1 + 0.5 * (10 * s**3 - 15 * s**4 + 6 * s**5)
    velocity, acceleration = np.zeros_like(position), np.zeros_like(position)
    velocity[:, 2] = 0.5 / 4 * (30 * s**2 - 60 * s**3 + 30 * s**4)
    acceleration[:, 2] = 0.5 / 16 * (60 * s - 180 * s**2 + 120 * s**3)
    attitude = np.tile([1.0, 0, 0, 0], (len(s), 1))
    return of.Trajectory(TIMES, position, attitude, velocity=velocity, acceleration=acceleration,
                         alpha=np.full(len(s), np.radians(30)))


class Recordings(unittest.TestCase):
    def made(self):
        t = np.arange(200_000) * 0.001
        return of.Recording.from_arrays({"position": (t, np.column_stack([t, 2 * t, 3 * t])), "alpha": (t, 0 * t)})

    def test_arrays_are_views_that_keep_the_recording_alive(self):
        recording = self.made()
        signal_ = recording["position"]
        first, second = signal_.values, recording["position"].values
        self.assertEqual(first.__array_interface__["data"], second.__array_interface__["data"])
        self.assertTrue(np.shares_memory(first, second))
        self.assertFalse(first.flags.owndata)
        del recording, signal_, second
        gc.collect()
        rubbish = [np.full(600_000, 7.0) for _ in range(8)]  # would land where freed memory was
        self.assertEqual(first.shape, (200_000, 3))
        np.testing.assert_array_equal(first[-1], [199.999, 2 * 199.999, 3 * 199.999])
        del rubbish

    def test_arrays_cannot_be_written(self):
        recording = self.made()
        with self.assertRaises(ValueError):
            recording["position"].values[0, 0] = 1.0
        with self.assertRaises(ValueError):
            recording["position"].t_s[0] = 1.0

    def test_reading_back_what_was_written(self):
        recording = self.made()
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "log.csv"
            recording["position"].window(0, 1)
            small = of.Recording.from_arrays({"position": (recording["position"].t_s[:50],
                                                           recording["position"].values[:50])})
            small.write_csv(path)
            again = of.load(path)
        self.assertEqual(list(again), ["position"])
        self.assertEqual(again.format, "csv")
        np.testing.assert_allclose(again["position"].values, small["position"].values, atol=1e-9)

    def test_resampling_is_linear_and_nan_outside(self):
        position = self.made()["position"]
        out = position.resample([0.0005, 500.0])
        np.testing.assert_allclose(out[0], [0.0005, 0.001, 0.0015])
        self.assertTrue(np.isnan(out[1]).all())

    def test_hostile_arrays_are_refused(self):
        t = np.array([0.0, 1.0])
        for signals, word in (
                ({"nonsense": (t, t)}, "no canonical signal"),
                ({"position": (t, np.zeros((3, 3)))}, "2 times and 3 rows"),
                ({"position": (t, np.zeros((2, 4)))}, "needs 3"),
                ({"alpha": (t[::-1], t)}, "not later"),
                ({"alpha": (t, [0, np.nan])}, "not finite"),
                ({"alpha": 3}, "not (times, values)")):
            with self.assertRaises(of.Error) as caught:
                of.Recording.from_arrays(signals)
            self.assertIn(word, str(caught.exception))
            self.assertIn(next(iter(signals)), caught.exception.field)
            self.assertTrue(caught.exception.next_step)

    def test_a_data_frame_has_a_column_a_component(self):
        try:
            import pandas  # noqa: F401
        except ImportError:
            with self.assertRaises(of.Error) as caught:
                of.frame(self.made())
            self.assertIn("python3-pandas", caught.exception.next_step)
            return
        table = of.frame(self.made(), ["position", "alpha"], t_s=[0.5, 1.5])
        self.assertEqual(list(table.columns), ["position_0", "position_1", "position_2", "alpha"])
        self.assertAlmostEqual(table["position_1"][1.5], 3.0)


class Errors(unittest.TestCase):
    def test_file_line_field_unit_and_next_step(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "bad.yaml"
            good = pathlib.Path(of.load_vehicle("quadrotor_1200g").file).read_text()
            lines = ["mass: -1" if line.startswith("mass:") else line for line in good.splitlines()]
            self.assertIn("mass: -1", lines)
            path.write_text("\n".join(lines) + "\n")
            with self.assertRaises(of.Error) as caught:
                of.load_vehicle(path)
        e = caught.exception
        self.assertEqual((e.code, e.file, e.line, e.field, e.unit),
                         ("bad_input", str(path), lines.index("mass: -1") + 1, "mass", "kg"))
        self.assertTrue(e.next_step)
        self.assertEqual(str(pickle.loads(pickle.dumps(e))), str(e))

    def test_a_damaged_file_is_an_error_or_a_note_and_never_a_crash(self):
        flight = of.simulate(climb(), of.load_vehicle("omnimorph"), hold_s=0.1)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "log.csv"
            flight.write_csv(path)
            whole = path.read_bytes()
            for cut in (0, 1, 100, len(whole) // 2, len(whole) - 3):
                path.write_bytes(whole[:cut])
                try:
                    of.load(path)
                except of.Error as e:
                    self.assertIn(str(path), str(e))

    def test_unknown_names_suggest_the_nearest(self):
        with self.assertRaises(of.Error) as caught:
            of.effect("hung_cabel")
        self.assertIn("hung_cable", caught.exception.next_step)
        with self.assertRaises(of.Error) as caught:
            of.Model([("payload_mass", {"mass": 99})])
        self.assertEqual(caught.exception.unit, "kg")
        with self.assertRaises(of.Error):
            of.Model([("payload_mass", {"weight": 0.1})])


class VehiclesAndWrenches(unittest.TestCase):
    def test_the_allocation_matrix_is_force_and_lever(self):
        vehicle = of.load_vehicle("omnimorph", {"mass": 1.4})
        self.assertEqual(vehicle.mass_kg, 1.4)
        alpha = np.radians(30)
        matrix = vehicle.allocation_matrix(alpha)
        self.assertEqual(matrix.shape, (6, len(vehicle.rotors)))
        for k, rotor in enumerate(vehicle.rotors):
            axis = vehicle.rotor_axis(k, alpha)
            np.testing.assert_allclose(matrix[:3, k], axis, atol=1e-12)
            torque = np.cross(rotor.position_m, axis) + rotor.spin * rotor.drag_ratio_m * axis
            np.testing.assert_allclose(matrix[3:, k], torque, atol=1e-12)

    def test_a_corner_of_the_force_set_needs_all_of_a_rotor(self):
        wrenches = of.WrenchSet(of.load_vehicle("omnimorph"), np.radians(45))
        forces = wrenches.force_at_torque()
        self.assertEqual((wrenches.rank, forces.dimension, forces.vertices.shape[1], forces.facets.shape[1]),
                         (6, 3, 3, 4))
        for corner in forces.vertices:
            self.assertAlmostEqual(wrenches.load([*corner, 0, 0, 0]), 1.0, places=6)
        inside = forces.facets[:, :3] @ forces.vertices.T <= forces.facets[:, 3:] + 1e-9
        self.assertTrue(inside.all())

    def test_the_design_is_the_commands_json(self):
        self.assertEqual(of.design(of.load_vehicle("omnimorph"), [0.5])["schema"], "omniflight.design/1")


class Flights(unittest.TestCase):
    def test_a_simulated_flight_follows_and_repeats_to_the_bit(self):
        vehicle = of.load_vehicle("omnimorph")
        flights = [of.simulate(climb(), vehicle, sensors="laboratory", hold_s=0.5, seed=3) for _ in range(2)]
        np.testing.assert_array_equal(flights[0]["position"].values, flights[1]["position"].values)
        tracking = of.assess(flights[0], vehicle)
        self.assertLess(tracking.worst_position_m, 0.05)
        self.assertEqual(tracking.error.shape, (len(tracking.t_s), 6))
        lift = flights[0]["truth_power"].values
        self.assertGreater(lift.min(), 0)

    def test_a_model_acts_on_the_flight_and_the_comparison_shows_it(self):
        vehicle = of.load_vehicle("omnimorph")
        heavy = of.simulate(climb(), vehicle, of.Model([("payload_mass", {"mass": 0.2})]), hold_s=0.5)
        wrench = heavy["truth_wrench"]
        at_rest = wrench.resample([0.4])[0]
        self.assertAlmostEqual(at_rest[2], -0.2 * 9.81, delta=0.1)
        rows = {r.channel: r for r in of.compare(of.simulate(climb(), vehicle, hold_s=0.5), heavy, vehicle)}
        self.assertGreater(rows["mean power"].ratio, 1.05)

    def test_a_quadrotor_leans_with_gains_of_its_own(self):
        plan = of.plan("sideways", "quadrotor_1200g")
        self.assertEqual(plan.verdict, "certified")
        vehicle = of.load_vehicle("quadrotor_1200g")
        flight = of.simulate(plan, vehicle, hold_s=1.0)
        self.assertLess(of.assess(flight, vehicle).worst_position_m, 0.1)

    def test_a_plan_is_read_back_as_it_was_written(self):
        plan = of.plan("trajectory_1", seed=4)
        with tempfile.TemporaryDirectory() as folder:
            plan.write(folder)
            again = of.read_plan(folder)
        t = np.linspace(0, plan.duration_s, 50)
        np.testing.assert_allclose(again.trajectory.sample(t)["position"], plan.trajectory.sample(t)["position"],
                                   atol=1e-9)

    def test_the_plant_falls_with_g(self):
        plant = of.Plant(of.load_vehicle("quadrotor_1200g"), position_m=[0, 0, 10])
        plant.step(500)
        self.assertAlmostEqual(plant.velocity_mps[2], -9.81 * 0.5, delta=0.02)
        with self.assertRaises(of.Error):
            plant.set_command([np.nan] * 4)

    def test_wrong_gains_are_named(self):
        with self.assertRaises(of.Error) as caught:
            of.simulate(climb(), of.load_vehicle("omnimorph"), gains={"kq": [1, 1, 1]})
        self.assertEqual(caught.exception.field, "gains.kq")


class Diagnoses(unittest.TestCase):
    def test_other_threads_run_and_a_budget_ends_it(self):
        vehicle = of.load_vehicle("omnimorph")
        flight = of.simulate(of.plan("trajectory_2"), vehicle, sensors="laboratory", seed=7)
        ticks, over = [], threading.Event()

        def tick():
            while not over.wait(0.01):
                ticks.append(time.monotonic())

        other = threading.Thread(target=tick)
        other.start()
        try:
            begin = time.monotonic()
            answer = of.diagnose([flight], vehicle, budget_s=0.2, threads=1)
            took = time.monotonic() - begin
        finally:
            over.set()
            other.join()
        self.assertEqual(answer.verdict, "unfinished")
        during = [t for t in ticks if begin < t < begin + took]
        self.assertGreater(len(during), 5)
        self.assertEqual(answer.data["schema"], "omniflight.diagnosis/1")

    def test_check_fits_nothing(self):
        vehicle = of.load_vehicle("omnimorph")
        flight = of.simulate(climb(), vehicle, sensors="laboratory", hold_s=1.0)
        self.assertEqual(of.check([flight], vehicle).verdict, "checked")

    def test_ctrl_c_ends_a_long_call(self):
        vehicle = of.load_vehicle("omnimorph")
        flight = of.simulate(of.plan("trajectory_2"), vehicle, sensors="laboratory", seed=7)
        timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
        timer.start()
        try:
            with self.assertRaises(KeyboardInterrupt):
                of.diagnose([flight], vehicle, threads=1)
                time.sleep(5)  # a diagnosis that was quicker is interrupted here
        finally:
            timer.cancel()


class Stubs(unittest.TestCase):
    """The stubs name what there is, and nothing else."""

    def members(self):
        tree = ast.parse((PACKAGE / "__init__.pyi").read_text())
        out = {}
        for node in tree.body:
            if isinstance(node, ast.ClassDef):
                out[node.name] = {n.name for n in node.body if isinstance(n, ast.FunctionDef)} | \
                                 {n.target.id for n in node.body if isinstance(n, ast.AnnAssign)}
            elif isinstance(node, ast.FunctionDef):
                out[node.name] = set()
        return out

    def test_names_are_those_of_the_package(self):
        self.assertEqual(set(self.members()), set(of.__all__))

    def test_members_are_those_of_the_classes(self):
        for name, stubbed in self.members().items():
            thing = getattr(of, name)
            if not inspect.isclass(thing) or name in ("Error", "Diagnosis", "Tracking", "ComparedRow"):
                continue
            real = {n for n in vars(thing) if not n.startswith("_")}
            self.assertEqual({n for n in stubbed if not n.startswith("_")}, real, name)

    def test_everything_public_is_documented(self):
        for name in of.__all__:
            thing = getattr(of, name)
            self.assertTrue(inspect.getdoc(thing), name)


if __name__ == "__main__":
    unittest.main()
