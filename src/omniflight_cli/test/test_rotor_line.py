"""How a flight through boards ends, measured on the boards' line: bytes that the emulated boards received.

After the last good command no command is repeated for longer than one period and 5 ms; then the speeds fall over the
ramp of the gate (0.5 s) to a stop, whatever ended the flight.
"""

import os
import pty
import re
import signal
import subprocess
import time
import unittest

import board_flight
import board_line
import system

NO_RESULT = 2
RAMP_S = 0.5  # of the gateway's gate
FRESH_S = 0.015  # one period of 100 Hz and 5 ms
HOVER_RADPS = 150.0  # less than any rotor turns at in hover
# s that this computer may keep the gateway or the emulator from running while it is measured
LATE_S = 0.05


class EndsOnTheLine(board_flight.BoardFlight):
    def wait_for_silence(self, pids, limit=15):
        system.wait_until("the components to end", lambda: not any(map(system.alive, pids.values())), limit)

    def check_ramp(self, ended_s, board=0):
        """The ramp on the line after ended_s [CLOCK_MONOTONIC]: {figure: value}."""
        line = board_line.Line(self.log).board(board)
        after = [command for command in line if command[0] >= ended_s]
        self.assertGreater(len(after), 20, "nothing but silence after the end")
        self.assertGreater(after[0][1], HOVER_RADPS, "the vehicle did not hover when it was ended")
        # the last command that is not yet of the ladder: from there on the largest speed never rises again
        top = len(after) - 1
        while top > 0 and after[top - 1][1] >= after[top][1] - 1e-9:
            top -= 1
        self.assertGreater(after[top][1], HOVER_RADPS, "no ladder from hover speed")
        hover = after[top][1]
        repeats = [t for t, largest, speeds in after[top:] if speeds == after[top][2]]
        down = [(t, largest) for t, largest, _ in after[top:]]
        steps = [(t1 - t0, (s0 - s1) / hover) for (t0, s0), (t1, s1) in zip(down, down[1:]) if s0 > 0.2 * hover]
        stop = next((t for t, _, speeds in after[top:] if speeds is None), None)
        self.assertIsNotNone(stop, "the boards were never told to stop")
        figures = {"repeated_s": repeats[-1] - repeats[0], "largest_step": max(share for _, share in steps),
                   "ramp_s": stop - repeats[-1], "flown_on_s": repeats[0] - ended_s}
        print("\n" + self.id().rsplit(".", 1)[1] + ": last command repeated for {repeated_s:.4f} s, largest step {largest_step:.3f} "
              "of hover speed, {ramp_s:.3f} s from it to the stop".format(**figures))
        self.assertLessEqual(figures["repeated_s"], FRESH_S + LATE_S)
        for dt, share in steps:
            self.assertLessEqual(share, (dt + LATE_S) / RAMP_S)
        self.assertGreater(figures["ramp_s"], 0.8 * RAMP_S)
        self.assertLess(figures["ramp_s"], 2 * RAMP_S)
        return figures

    def test_control_c(self):
        fly, pids = self.take_off(mission=self.hovering_mission())
        ended = time.monotonic()
        fly.send_signal(signal.SIGINT)
        output = fly.communicate(timeout=20)
        self.assertEqual(fly.returncode, NO_RESULT, output)
        self.assertEqual(self.json("flight/flight.json")["reason"], "interrupted")
        self.wait_for_silence(pids)
        self.check_ramp(ended)

    def test_killed_fly(self):
        fly, pids = self.take_off(mission=self.hovering_mission())
        ended = time.monotonic()
        fly.kill()
        fly.wait(timeout=5)
        self.wait_for_silence(pids)
        self.check_ramp(ended)

    def test_long_full_disk_ends_no_flight(self):
        disk = self.small_disk(3)
        fly, pids = self.take_off(disk / "flight", parameters=["-p", "gateway.least_free_MB=0"])
        began = time.monotonic()
        output = fly.communicate(timeout=40)
        self.assertEqual(fly.returncode, NO_RESULT, output)
        self.assertIn("No space left", "".join(output))
        self.check_ramp(began)

    def test_killed_allocator(self):
        fly, pids = self.take_off(mission=self.hovering_mission())
        ended = time.monotonic()
        os.kill(pids["omniflight_allocator"], signal.SIGKILL)
        output = fly.communicate(timeout=30)
        self.assertEqual(fly.returncode, NO_RESULT, output)
        self.assertIn("omniflight_allocator", self.json("flight/flight.json")["reason"])
        self.check_ramp(ended)

    def test_long_sigterm(self):
        fly, pids = self.take_off(mission=self.hovering_mission())
        ended = time.monotonic()
        fly.terminate()
        output = fly.communicate(timeout=20)
        self.assertEqual(fly.returncode, NO_RESULT, output)
        self.wait_for_silence(pids)
        self.check_ramp(ended)

    def test_a_closed_terminal(self):
        # whoever runs the tests may do so under nohup, which children inherit
        fly, pids = self.take_off(mission=self.hovering_mission(),
                                  preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL))
        ended = time.monotonic()
        fly.send_signal(signal.SIGHUP)
        output = fly.communicate(timeout=20)
        self.assertEqual(fly.returncode, NO_RESULT, output)
        self.assertEqual(self.json("flight/flight.json")["reason"], "interrupted")
        self.wait_for_silence(pids)
        self.check_ramp(ended)

    def test_control_c_twice_at_the_gateway(self):
        # as somebody does who started it by hand and finds that it takes long
        fly, pids = self.take_off(mission=self.hovering_mission())
        ended = time.monotonic()
        os.kill(pids["omniflight_gateway"], signal.SIGINT)
        time.sleep(RAMP_S / 2)
        os.kill(pids["omniflight_gateway"], signal.SIGINT)
        output = fly.communicate(timeout=30)
        self.assertEqual(fly.returncode, NO_RESULT, output)
        self.check_ramp(ended)

    def test_paused_allocator_is_noticed_and_rejoins(self):
        fly, pids = self.take_off()
        paused = time.monotonic()
        os.kill(pids["omniflight_allocator"], signal.SIGSTOP)
        time.sleep(0.25)
        os.kill(pids["omniflight_allocator"], signal.SIGCONT)
        continued = time.monotonic()
        output = fly.communicate(timeout=40)
        self.assertEqual(fly.returncode, 0, output)
        line = board_line.Line(self.log).board(0)
        during = [(t, largest, speeds) for t, largest, speeds in line if paused <= t < continued]
        last = next(k for k, (_, _, speeds) in enumerate(during) if speeds == during[k + 1][2] == during[k + 2][2])
        begun = next(t for t, largest, _ in during[last:] if largest < during[last][1])
        hover = during[last][1]
        back = next(t for t, largest, _ in line if t >= continued and largest > 0.95 * hover)
        low = min(largest for _, largest, _ in during) / hover
        print(f"\npaused allocator: noticed {1e3 * (begun - during[last][0]):.1f} ms after its last command, at {low:.2f} of "
              f"hover speed after 0.25 s, back {1e3 * (back - continued):.0f} ms after it continued")
        self.assertLess(begun - during[last][0], FRESH_S + 0.005 + LATE_S)
        self.assertLess(low, 0.8, "the ladder has 0.235 s of 0.5 s")
        self.assertLess(back - continued, 2.0)

    def test_a_component_that_stands_still_is_named_within_its_lease(self):
        fly, pids = self.take_off(mission=self.hovering_mission(8))
        for name in ("recorder", "controller", "emulator"):
            os.kill(pids[f"omniflight_{name}"], signal.SIGSTOP)
            time.sleep(0.4)
            os.kill(pids[f"omniflight_{name}"], signal.SIGCONT)
            time.sleep(0.4)
        output = "".join(fly.communicate(timeout=60))
        flown = self.json("flight/flight.json")
        said = (self.dir / "flight/log/gateway.log").read_text()
        # all of them came back: the flight goes on to its end, though not where it should be
        self.assertTrue(flown["complete"], f"{flown['reason']}\n{said}")
        silent, noticed = flown["silent"], {}
        for name in ("recorder", "controller", "emulator"):
            found = re.findall(rf"{name} has been silent for ([\d.]+) ms", said)
            self.assertTrue(found, said)
            noticed[name] = max(map(float, found))
            self.assertTrue(any(s["component"] == name and s["back"] and 0.35 < s["for_s"] < 2.4 for s in silent), silent)
            self.assertIn(f"{name} stood still for", output)
        # the gate slowed the rotors down while the controller gave no commands
        self.assertNotIn("does not turn as commanded", (self.dir / "flight/log/allocator.log").read_text())
        print(f"\nstopped for 0.4 s: noticed after a silence of {noticed} ms, of a lease of 100 ms")
        self.assertLess(min(noticed.values()), 105)
        self.assertLess(max(noticed.values()), 105 + 1e3 * LATE_S)

    def test_missed_periods_are_shown(self):
        fly, pids = self.take_off()
        os.kill(pids["omniflight_gateway"], signal.SIGSTOP)
        time.sleep(0.1)
        os.kill(pids["omniflight_gateway"], signal.SIGCONT)
        output = "".join(fly.communicate(timeout=40))
        said = self.json("flight/flight.json")
        print(f"\ngateway paused for 100 ms: {said['periods_missed']} of {said['periods']} periods of 2 ms missed, the latest "
              f"{said['period_latest_ms']:.1f} ms late; {said['page_faults']} page faults of the loop")
        self.assertGreaterEqual(said["periods_missed"], 45)
        self.assertGreater(said["periods"], 2000)
        self.assertGreaterEqual(said["period_latest_ms"], 95)
        self.assertLessEqual(said["page_faults"], 10)
        self.assertIn(f"{said['periods_missed']} of {said['periods']} control periods missed", output)

    def test_emergency_stop_is_acknowledged(self):
        fly, pids = self.take_off(mission=self.hovering_mission())
        stopped = time.monotonic()
        done = self.run_command("estop", "--json")
        said = system.json.loads(done.stdout)
        self.assertTrue(any(run["acknowledged"] and "emergency_stop" in run["gate"] for run in said), said)
        output = fly.communicate(timeout=20)
        self.assertEqual(fly.returncode, NO_RESULT, output)
        self.assertIn("emergency_stop", self.json("flight/flight.json")["reason"])
        line = board_line.Line(self.log).board(0)
        stop = next(t for t, _, speeds in line if t > stopped and speeds is None)
        before = [largest for t, largest, _ in line if stop - 0.05 < t < stop]
        print(f"\nemergency stop on the boards' line {1e3 * (stop - stopped):.0f} ms after the program was started")
        self.assertGreater(min(before), HOVER_RADPS, "no ramp: off at once")
        self.assertEqual([c for c in line if c[0] > stop and c[2] is not None], [], "commands after the stop")

    def test_rotors_wait_for_the_operator_who_arms(self):
        log = self.dir / "line.txt"
        fly = self.start_command("fly", self.short_mission(), "--plant", "emulator", "--out", "flight", "-p",
                                 f"emulator.line_log={log}", "-p", "gateway.operator_arms=true")
        said = self.dir / "flight/log/gateway.log"
        system.wait_until("the gateway", lambda: said.exists() and "activated" in said.read_text(), 30)
        time.sleep(3)
        self.assertEqual(board_line.Line(log).commands, [], "nobody has armed")
        self.assertIsNone(fly.poll())
        asked = time.monotonic()
        done = self.run_command("arm", "--json")
        said = system.json.loads(done.stdout)
        self.assertTrue(said["armed"], said)
        first = next(t for t, _, speeds in board_line.Line(log).commands if speeds)
        print(f"\nfirst rotor command {first - asked:.2f} s after omniflight arm was started")
        self.assertGreater(first, asked)
        self.assertEqual(fly.wait(timeout=60), 0, fly.communicate())

    def test_arming_while_something_is_missing_starts_nothing(self):
        log = self.dir / "line.txt"
        fly = self.start_command("fly", self.short_mission(), "--plant", "emulator", "--out", "flight", "-p",
                                 f"emulator.line_log={log}", "-p", "gateway.operator_arms=true", "-p",
                                 "gateway.least_battery_V=999", "-p", "gateway.connect_timeout_s=8")
        said = self.dir / "flight/log/gateway.log"
        system.wait_until("the gateway", lambda: said.exists() and "activated" in said.read_text(), 30)
        done = self.run_command("arm", expect=NO_RESULT)
        self.assertIn("NOT armed", done.stdout)
        self.assertIn("at least 999", done.stdout)
        output = fly.communicate(timeout=60)
        self.assertEqual(fly.returncode, NO_RESULT, output)
        self.assertEqual([c for c in board_line.Line(log).commands if c[2] is not None], [], "stops alone")

    def test_a_plan_of_another_vehicle_starts_no_gateway(self):
        self.run_command("plan", self.short_mission(), "--out", "plan", "--quiet")
        gateway = system.PROGRAMS / "omniflight_gateway"
        done = subprocess.run([gateway, "--domain", "120", "--loopback", system.CONFIGS / "cyclonedds_loopback.xml", "-p",
                               "vehicle:=omnimorph", "-p", "vehicle_set:=mass=1.4", "-p", "devices:=/dev/null", "-p",
                               f"plan:={self.dir / 'plan'}"], text=True, capture_output=True, timeout=20)
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("is of another vehicle, or of other overrides", done.stderr)

    def test_nobody_to_stop_is_said(self):
        runtime = self.dir / "runtime"
        runtime.mkdir(mode=0o700)
        done = self.run_command("estop", expect=NO_RESULT, env=dict(os.environ, XDG_RUNTIME_DIR=str(runtime)))
        self.assertIn("no run", done.stderr)

    def test_long_keys_of_the_terminal_stop(self):
        self.log = self.dir / "line.txt"
        master, slave = pty.openpty()
        fly = subprocess.Popen([system.COMMAND, "fly", self.hovering_mission(), "--plant", "emulator", "--out", "flight", "-p",
                                f"emulator.line_log={self.log}"], cwd=self.dir, stdin=slave, stdout=subprocess.PIPE,
                               stderr=subprocess.STDOUT, text=True)
        self.addCleanup(fly.kill)
        system.wait_until("commands on the line", lambda: self.log.exists() and self.log.stat().st_size > 20_000, 30)
        time.sleep(2.5)
        os.write(master, b"s")
        output = fly.communicate(timeout=20)[0]
        self.assertEqual(fly.returncode, NO_RESULT, output)
        self.assertIn("keys:", output)
        self.assertIn("requested", self.json("flight/flight.json")["reason"])

    def test_killed_recorder_ends_no_flight(self):
        fly, pids = self.take_off()
        lost = time.monotonic()
        os.kill(pids["omniflight_recorder"], signal.SIGKILL)
        output = fly.communicate(timeout=30)
        self.assertEqual(fly.returncode, NO_RESULT, output)
        self.assertIn("omniflight_recorder", self.json("flight/flight.json")["reason"])
        self.assertIn("flown to the end without it: omniflight_recorder", "".join(output))
        figures = self.check_ramp(lost)
        self.assertGreater(figures["flown_on_s"], 2.0, "the mission goes on for more than that")


if __name__ == "__main__":
    unittest.main()
