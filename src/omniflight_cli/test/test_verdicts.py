"""`flown` is judged: reached, tracked, clear of the map, rotors to spare; what ended early is no complete flight."""

import os
import signal
import unittest

import system


class Verdicts(system.SystemTest):
    def pull(self, x, y=0.0, z=0.0):
        return self.write(f"pull{x}.yaml", "schema: omniflight.model/1\neffects:\n  - id: constant_pull\n"
                                           f"    parameters: {{x: {x}, y: {y}, z: {z}}}\n")

    def badly(self, word, *arguments, mission=None, out="flight", reason):
        done = self.run_command("fly", mission or self.short_mission(), "--in-process", "--out", out, *arguments, expect=2)
        flight = self.json(f"{out}/flight.json")
        self.assertEqual(flight["verdict"], word, flight["reason"])
        self.assertIn(reason, flight["reason"])
        self.assertIn("NOT flown", done.stdout)
        return flight

    def test_a_good_flight_is_judged_by_figures(self):
        flight = self.fly(self.short_mission(), "--in-process", "--sensors", "laboratory")
        judged = flight["judged"]
        self.assertEqual(flight["verdict"], "flown")
        self.assertEqual(judged["position_bound_m"], 0.08)
        self.assertLess(judged["worst_position_m"], 0.02)
        self.assertGreater(judged["min_clearance_m"], 0.08)
        self.assertGreater(judged["least_headroom"], 0.1)
        self.assertEqual(self.json("flight/plan/certificate.json")["tube"]["position_m"], 0.08)

    def test_outside_the_tube_is_flown_badly(self):
        flight = self.badly("flown_badly", "--effects", self.pull(2.0), "-p", "controller.ki=[0, 0, 0]",
                            reason="from its reference")
        self.assertTrue(flight["complete"])
        self.assertGreater(flight["judged"]["worst_position_m"], 0.08)

    def test_rotors_at_their_limit_are_flown_badly(self):
        # 3.2 kg take 0.82 of the thrust, 7.9 N more take the rest while it moves
        arguments = ("--set", "mass=3.2", "--effects", self.pull(0.0, z=-7.9))
        judged = self.badly("flown_badly", *arguments, reason="a rotor was at its limit for")["judged"]
        self.assertGreater(judged["share_at_limit"], 0.01)
        self.assertEqual(judged["share_at_limit_bound"], 0.01)
        self.assertLess(judged["worst_position_m"], judged["position_bound_m"], "it is tracked all the same")
        # who plans with whole rotors may use them
        whole = self.short_mission("whole.yaml", changes={"rotor_headroom: 0.1": "rotor_headroom: 0"})
        self.assertGreater(self.fly(whole, "--in-process", *arguments, out="whole")["judged"]["share_at_limit"], 0.01)

    def test_the_mission_can_set_its_bounds(self):
        wide = self.short_mission("wide.yaml", changes={"seed: 1": "seed: 1\ntracking: {position_m: 0.4, attitude_deg: 20}"})
        arguments = ("--in-process", "--effects", self.pull(2.0), "-p", "controller.ki=[0, 0, 0]")
        self.fly(wide, *arguments, out="wide")
        tight = self.short_mission("tight.yaml", changes={"seed: 1": "seed: 1\ntracking: {position_m: 0.001}"})
        self.badly("flown_badly", "--sensors", "degraded", mission=tight, out="tight", reason="0.001 m are allowed")

    def test_blown_into_the_frame_is_lost(self):
        # 0.36 m towards a beam without integral action
        near = self.short_mission("near.yaml", changes={"[0, 0, 1.3]": "[0.15, 0.15, 1.8]", "[0.1, 0, 0.1]": "[0, 0, -0.05]",
                                                        "seed: 1": "seed: 1\ntracking: {position_m: 1, attitude_deg: 90}",
                                                        "clearance_m: 0.08": "clearance_m: 0.02"})
        flight = self.badly("lost", "--effects", self.pull(4.0, 4.0), "-p", "controller.ki=[0, 0, 0]", mission=near,
                            reason="into the obstacles")
        self.assertLess(flight["judged"]["min_clearance_m"], 0)

    def test_a_simulator_or_gateway_that_is_ended_is_no_complete_flight(self):
        for name, plant in (("omniflight_simulator", ("--rate", "realtime")), ("omniflight_gateway", ("--plant", "emulator"))):
            out = name
            fly = self.start_command("fly", self.hovering_mission(), *plant, "--out", out, "--quiet")
            recording = self.dir / out / "flight.mcap"
            system.wait_until("a recording that grows",
                              lambda: recording.exists() and recording.stat().st_size > 300_000 or fly.poll() is not None, 30)
            os.kill(system.children(fly.pid)[name], signal.SIGTERM)
            output, error = fly.communicate(timeout=40)
            self.assertEqual(fly.returncode, 2, output + error)
            flight = self.json(f"{out}/flight.json")
            self.assertEqual(flight["verdict"], "not flown to the end", name)
            self.assertFalse(flight["complete"], name)


if __name__ == "__main__":
    unittest.main()
