"""Flights that must succeed: nominal tracking, lockstep, emulated boards, runs beside each other."""

import csv
import fcntl
import math
import os
import shutil
import signal
import subprocess
import time
import unittest

import system

AXES = ("x", "y", "z")
ANGLES = ("roll", "pitch", "yaw")

# The *simulated* column of the thesis (chapter 7), RMSE [m] x y z and [deg] roll pitch yaw.
THESIS = {
    "trajectory_1": ((0.002, 0.005, 0.011), (0.010, 0.011, 0.011)),
    "trajectory_2": ((0.003, 0.020, 0.004), (0.015, 0.015, 0.018)),
}


def errors(tracking):
    return (tuple(tracking["position_rmse_m"][a] for a in AXES), tuple(tracking["attitude_rmse_deg"][a] for a in ANGLES))


class NominalTracking(system.SystemTest):
    def check(self, mission):
        ideal = self.fly(mission, "--sensors", "ideal", out="ideal")
        noisy = self.fly(mission, "--sensors", "laboratory", out="laboratory")
        position, attitude = errors(ideal["metrics"]["true"])
        print(f"\n{mission}: true state, ideal sensors: {position} m {attitude} deg")
        print(f"{mission}: true state, laboratory sensors: {errors(noisy['metrics']['true'])}")
        for axis, error, limit in zip(AXES + ANGLES, position + attitude, THESIS[mission][0] + THESIS[mission][1]):
            self.assertLessEqual(error, limit, axis)
        self.assertEqual(ideal["verdict"], "flown")
        self.assertGreater(math.hypot(*errors(noisy["metrics"]["measured"])[0]), math.hypot(*position),
                           "with noise the measured error must be larger than the true one without")

    def test_long_trajectory_1_tracks_as_the_thesis(self):
        self.check("trajectory_1")

    def test_trajectory_2_tracks_as_the_thesis(self):
        self.check("trajectory_2")


class Told(system.SystemTest):
    def test_a_flight_tells_its_gains_and_biases_to_whoever_diagnoses_it(self):
        self.fly(self.short_mission(), "--in-process", "--sensors", "laboratory", "-p", "controller.kp=[10, 11, 12.5]")
        told = (self.dir / "flight/told.yaml").read_text()
        self.assertIn("kp: [10, 11, 12.5]", told)
        self.assertIn("kR: [100, 100, 100]", told)
        self.assertIn("accelerometer: {bias_mps2: 0.015}", told)
        found = self.run_command("diagnose", "flight/flight.mcap", "--vehicle", "omnimorph", "--check", "--out", "check")
        self.assertNotIn("told, but not used", found.stdout)


class MovingTilt(system.SystemTest):
    def test_the_tilt_follows_the_mission_and_the_vehicle_stays_on_its_way(self):
        flown = self.fly("tilt_sweep", "--sensors", "ideal", out="sweep")
        position, attitude = errors(flown["metrics"]["true"])
        print(f"\ntilt_sweep: {position} m {attitude} deg")
        self.assertLess(max(position), 0.003)
        self.assertLess(max(attitude), 0.1)
        self.run_command("export", "sweep/flight.mcap", "--to", "csv", "--out", "sweep.csv", "--quiet")
        with open(self.dir / "sweep.csv", newline="") as file:
            tilt = [math.degrees(float(row["alpha_rad"])) for row in csv.DictReader(file) if row["alpha_rad"]]
        self.assertAlmostEqual(min(tilt), 18, delta=0.1)
        self.assertAlmostEqual(max(tilt), 42, delta=0.1)
        self.assertAlmostEqual(tilt[-1], 30, delta=0.1)

    def test_boards_that_cannot_move_it_refuse(self):
        done = self.run_command("fly", "tilt_sweep", "--plant", "emulator", "--out", "emulated", expect=4)
        self.assertIn("alpha_deg", done.stderr)
        self.assertIn("--plant simulator", done.stderr)


class LoadsOfTheMission(system.SystemTest):
    def loaded(self, keys):
        return self.write("loaded.yaml", system.SHORT.replace("start: {", keys + "start: {"))

    def test_a_flight_carries_the_payload_and_the_tether_of_its_mission(self):
        keys = ("payload: {mass_kg: 0.2, position: [0, 0, -0.05]}\n"
                "tether: {anchor: [0, 0, 0.6], length_m: 3, mass_kg_per_m: 0.1}\n")
        bare = self.fly(self.short_mission(), "--in-process", out="bare")
        loaded = self.fly(self.loaded(keys), "--in-process", out="loaded")
        model = (self.dir / "loaded/effects.yaml").read_text()
        self.assertIn("id: payload_mass", model)
        self.assertIn("id: hung_cable", model)
        self.assertFalse((self.dir / "bare/effects.yaml").exists())
        # hovering power goes with the carried mass to 3/2: 1.3 m high, 0.7 m of the tether hang
        mass = self.json("loaded/plan/certificate.json")["vehicle"]["mass_kg"]
        expected = ((mass + 0.2 + 0.1 * 0.75) / mass) ** 1.5
        power = [flight["metrics"]["power_W"] for flight in (bare, loaded)]
        print(f"\nmean power {power[0]:.1f} W bare, {power[1]:.1f} W loaded, {expected:.3f} times as much expected")
        self.assertAlmostEqual(power[1] / power[0], expected, delta=0.05)
        self.assertEqual(loaded["verdict"], "flown")

    def test_effects_of_a_file_are_flown_beside_the_loads(self):
        self.write("wind.yaml", "schema: omniflight.model/1\neffects:\n  - id: wind\n")
        self.fly(self.loaded("payload: {mass_kg: 0.1}\n"), "--in-process", "--effects", "wind.yaml", out="both")
        model = (self.dir / "both/effects.yaml").read_text()
        self.assertIn("id: wind", model)
        self.assertIn("id: payload_mass", model)

    def test_a_load_that_cannot_be_simulated_is_refused_before_anything_is_written(self):
        mission = self.loaded("payload: {mass_kg: 0.3, position: [0.4, 0, 0]}\n")
        done = self.run_command("fly", mission, "--out", "never", expect=4)
        self.assertIn("payload", done.stderr)
        self.assertFalse((self.dir / "never").exists())


class Lockstep(system.SystemTest):
    def digest(self, recording):
        text = subprocess.run([os.environ["OMNIFLIGHT_MCAP_DIGEST"], str(self.dir / recording)], check=True, text=True,
                              capture_output=True).stdout
        lines = [line.split() for line in text.splitlines()]
        # component states carry the process's own start-up order
        return {topic: (int(count), sha) for topic, count, sha in lines if topic != "/component_state"}

    def test_a_command_that_comes_late_is_asked_for_again_and_recorded_once(self):
        flight = ("fly", self.short_mission(), "--sensors", "laboratory", "--seed", "7", "--quiet")
        self.run_command(*flight, "--in-process", "--out", "inside")
        apart = self.start_command(*flight, "--out", "late")
        recording = self.dir / "late/flight.mcap"
        system.wait_until("the first samples", lambda: recording.exists() and recording.stat().st_size > 100_000, 20)
        allocator = system.children(apart.pid)["omniflight_allocator"]
        os.kill(allocator, signal.SIGSTOP)  # the plant asks again every 0.3 s and gives up after 2 s
        time.sleep(0.8)
        os.kill(allocator, signal.SIGCONT)
        self.assertEqual(apart.wait(30), 0)
        self.assertEqual(self.digest("late/flight.mcap"), self.digest("inside/flight.mcap"))

    def test_processes_and_container_record_the_same(self):
        together = ("--sensors", "laboratory", "--seed", "7")
        apart = self.fly("trajectory_1", *together, out="apart")
        inside = self.fly("trajectory_1", *together, "--in-process", out="inside")
        other = self.fly("trajectory_1", "--sensors", "laboratory", "--seed", "8", "--in-process", out="other")
        factor = {name: f["simulated_s"] / f["wall_s"] for name, f in (("apart", apart), ("inside", inside))}
        print(f"\nreal-time factor: separate processes {factor['apart']:.1f}, one container {factor['inside']:.1f}")
        a, b = self.digest("apart/flight.mcap"), self.digest("inside/flight.mcap")
        self.assertGreaterEqual(len(a), 9)
        for topic, (count, _) in a.items():
            self.assertGreater(count, 0, topic)
        self.assertEqual(a, b)
        self.assertNotEqual(self.digest("other/flight.mcap")["/omniflight/imu"], b["/omniflight/imu"],
                            "another seed must give another recording")
        self.assertEqual(other["verdict"], "flown")
        self.assertGreater(factor["apart"], 1)
        self.assertGreater(factor["inside"], 5)


class AntiWindup(system.SystemTest):
    def test_a_pull_that_saturates_the_rotors_winds_up_less(self):
        # At 5 degrees of tilt the rotors give 2.18 N sideways. A pull of 2 N leaves next to nothing for the way back, so
        # what the integrator gathers on the way out decides how far beyond the reference the vehicle swings.
        pull = self.write("pull.yaml", "schema: omniflight.model/1\neffects:\n  - id: constant_pull\n"
                                       "    parameters: {x: 2.0, y: 0, z: 0}\n")
        common = ("--in-process", "--effects", pull, "-p", "allocator.alpha_deg=5", "-p", "simulator.initial_alpha_deg=5",
                  "-p", "controller.max_acceleration_mps2=40", "-p", "controller.max_integral_acceleration_mps2=30")
        x = {}
        for told in ("true", "false"):
            flight = self.fly(self.short_mission(), *common, "-p", f"controller.anti_windup={told}", out=told,
                              expect=2)  # the rotors are at their limits
            self.assertEqual(flight["verdict"], "flown_badly", told)
            x[told] = flight["metrics"]["true"]["position_rmse_m"]["x"]
        print(f"\nRMSE x: {x['true']:.4f} m when told what was not achieved, {x['false']:.4f} m when not")
        self.assertLess(x["true"], 0.2 * x["false"])


class EmulatedBoards(system.SystemTest):
    def test_flight_through_the_boards_shows_half_periods(self):
        flight = self.fly(self.short_mission(), "--plant", "emulator", timeout=80)
        self.assertEqual(flight["verdict"], "flown")
        self.assertEqual(flight["plant"], "emulator")
        self.run_command("export", "flight/flight.mcap", "--out", "flight.csv")
        speeds = []
        with open(self.dir / "flight.csv", newline="") as file:
            for row in csv.DictReader(file):
                if row["rotor1_radps"]:
                    speeds += [abs(float(row[f"rotor{k}_radps"])) for k in range(1, 9)]
        turning = [w for w in speeds if w > 50]
        self.assertGreater(len(turning), 2000)
        # the boards count the microseconds n of half a turn:
        # the speed is 2 pi 0.5e6 / n rad/s
        off = max(abs(math.pi * 1e6 / w - round(math.pi * 1e6 / w)) for w in turning)
        self.assertLess(off, 0.02, "a measured speed is no whole number of microseconds for half a turn")
        self.assertGreater(len(set(turning)), 10)
        # a control: the simulator's ideal sensor is not on the grid, so that the test can tell
        self.fly(self.dir / "short.yaml", "--in-process", out="ideal")
        self.run_command("export", "ideal/flight.mcap", "--out", "ideal.csv")
        with open(self.dir / "ideal.csv", newline="") as file:
            ideal = [float(r["rotor1_radps"]) for r in csv.DictReader(file) if r["rotor1_radps"]]
        self.assertGreater(max(abs(math.pi * 1e6 / w - round(math.pi * 1e6 / w)) for w in ideal if w > 50), 0.1)

    def standing_still(self, who, how_long):
        """A flight through the boards of which components stand still for a while: (exit code, what it said)."""
        flight = self.start_command("fly", self.short_mission(), "--plant", "emulator", "--out", "flight", "--quiet")
        recording = self.dir / "flight/flight.mcap"
        system.wait_until("samples of a flight", lambda: recording.exists() and recording.stat().st_size > 100_000, 20)
        still = [pid for name, pid in system.children(flight.pid).items() if name.startswith(who)]
        self.assertTrue(still)
        for pid in still:
            os.kill(pid, signal.SIGSTOP)
        time.sleep(how_long)
        for pid in still:
            os.kill(pid, signal.SIGCONT)
        return flight.communicate(timeout=60)[1], flight.returncode

    def test_a_machine_that_stands_still_as_a_whole_ends_no_flight(self):
        error, code = self.standing_still("omniflight_", 0.5)
        self.assertEqual(code, 0, error)

    def test_a_controller_that_stands_still_stops_the_rotors_and_quiet_tells_why(self):
        error, code = self.standing_still("omniflight_controller", 1.5)
        self.assertEqual(code, 2, error)
        self.assertIn("stale_command", error)


class Monitored(system.SystemTest):
    def test_the_verdict_of_the_monitor_ends_the_flight_in_a_line(self):
        load = self.dir / "load.yaml"
        load.write_text("schema: omniflight.model/1\neffects:\n  - {id: payload_mass, parameters: {mass: 0.28}}\n")
        mission = self.short_mission()
        for name, effects, worst in (("plain", (), "OK"), ("loaded", ("--effects", load), "ERROR")):
            done = self.run_command("fly", mission, "--out", name, "--sensors", "laboratory", "--monitor", *effects)
            self.assertRegex(done.stdout, f"monitor: {worst}")
            self.assertEqual(self.json(f"{name}/flight.json")["monitor"]["worst"], worst)


class RunsBesideEachOther(system.SystemTest):
    def test_two_flights_at_once_use_two_domains(self):
        mission = self.short_mission()
        runs = [self.start_command("fly", mission, "--out", name, "--quiet") for name in ("one", "two")]
        for run, name in zip(runs, ("one", "two")):
            _, error = run.communicate(timeout=60)
            self.assertEqual(run.returncode, 0, error)
            self.assertEqual(self.json(f"{name}/flight.json")["verdict"], "flown")
        self.run_command("info", "one/flight.mcap")
        self.run_command("info", "two/flight.mcap")

    def test_a_claimed_domain_is_left_alone(self):
        runtime = self.dir / "runtime"
        runtime.mkdir(mode=0o700)
        environment = dict(os.environ, XDG_RUNTIME_DIR=str(runtime))
        with open(runtime / "omniflight-domain-1.lock", "w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self.fly(self.short_mission(), "--in-process", env=environment)
            claimed = sorted(p.name for p in runtime.glob("omniflight-domain-*.lock"))
            self.assertEqual(claimed, ["omniflight-domain-1.lock", "omniflight-domain-2.lock"])
            with open(runtime / "omniflight-domain-2.lock") as second:
                fcntl.flock(second, fcntl.LOCK_EX | fcntl.LOCK_NB)  # free again after the flight

    def test_no_free_domain_is_an_error(self):
        runtime = self.dir / "runtime"
        runtime.mkdir(mode=0o700)
        locks = [open(runtime / f"omniflight-domain-{k}.lock", "w") for k in range(1, 101)]
        for lock in locks:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            self.addCleanup(lock.close)
        done = self.run_command("fly", self.short_mission(), "--out", "flight", expect=4,
                                env=dict(os.environ, XDG_RUNTIME_DIR=str(runtime)))
        self.assertIn("every domain", done.stderr)
        self.assertFalse((self.dir / "flight/flight.mcap").exists())


class ReferenceReader(system.SystemTest):
    def test_flight_opens_in_the_reference_mcap_reader(self):
        modules = os.environ.get("OMNIFLIGHT_NODE_MODULES", "")
        if not shutil.which("node"):
            self.skipTest("node is not installed")
        if not os.path.isdir(os.path.join(modules, "@mcap/core")):
            self.skipTest("OMNIFLIGHT_NODE_MODULES names no folder with @mcap/core")
        self.fly(self.short_mission(), "--in-process")
        script = system.ROOT / "src/omniflight_recording/test/check_mcap.mjs"
        done = subprocess.run(["node", str(script), str(self.dir / "flight/flight.mcap")], text=True,
                              capture_output=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        print("\n" + done.stdout)
        self.assertIn('"poses"', done.stdout)


if __name__ == "__main__":
    unittest.main()
