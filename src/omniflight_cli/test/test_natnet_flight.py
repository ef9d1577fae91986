"""Flights through emulated boards whose poses come over NatNet, by multicast on the loopback interface."""

import os
import pathlib
import re
import signal
import time
import unittest

import board_flight
import board_line
import test_rotor_line


class NatNetFlight(board_flight.BoardFlight):
    def fly_over_natnet(self, version, **values):
        flight = self.fly(self.short_mission(), "--plant", "emulator", "--sensors", "laboratory", "--natnet",
                          self.natnet_config(**values), "-p", f"natnet_emulator.version='{version}'", timeout=90)
        said = pathlib.Path(self.dir / "flight/log/natnet.log").read_text()
        error = flight["metrics"]["true"]["position_rmse_m"]
        print(f"\nNatNet {version}: {flight['verdict']}, RMSE {1e3 * max(error.values()):.2f} mm; "
              + " ".join(re.findall(r"\[natnet\] (.*frames.*)", said)))
        self.assertEqual(flight["verdict"], "flown", said)
        self.assertIn(f"bit stream {version}", said)
        self.assertIn("another clock is followed", said)
        frames = int(re.search(r"(\d+) frames", said).group(1))
        self.assertGreater(frames, 1000)
        return flight

    def test_y_up_in_millimetres_by_version_4_1(self):
        self.fly_over_natnet("4.1")

    def test_long_other_versions(self):
        for version, up, unit in (("2.7", "z", "m"), ("3.1", "y", "m"), ("4.0", "z", "mm")):
            for left in self.dir.glob("flight/*.mcap"):
                left.unlink()
            self.fly_over_natnet(version, up=up, unit=unit)

    def test_without_its_receiver_the_vehicle_descends_and_is_not_dropped(self):
        """The descent lasts longer than the rest of the plan and than other losses are given."""
        fly, pids = self.take_off(parameters=["--natnet", self.natnet_config(), "-p", "controller.descend_speed_mps=0.05"])
        os.kill(pids["omniflight_natnet"], signal.SIGKILL)
        killed = time.monotonic()
        said = "".join(fly.communicate(timeout=90))
        self.assertEqual(fly.returncode, 2, said)
        landed = pathlib.Path(self.dir / "flight/log/gateway.log").read_text()
        print(f"\n{time.monotonic() - killed:.1f} s from the loss to the end; {landed.strip()}; "
              + self.json("flight/flight.json")["reason"])
        self.assertIn("gate ramping: failsafe", landed)
        speeds = [(t, largest) for t, largest, _ in board_line.Line(self.log).board(0)]
        flown_s = max(t for t, largest in speeds if largest > test_rotor_line.HOVER_RADPS) - killed
        self.assertGreater(flown_s, 6, "rotors wound down in the air")

    def test_a_body_that_is_not_streamed_starts_no_rotor(self):
        config = self.natnet_config()
        log = self.dir / "line.txt"
        done = self.run_command("fly", self.short_mission(), "--plant", "emulator", "--out", "x", "--natnet", config, "-p",
                                "gateway.connect_timeout_s=4", "-p", f"emulator.line_log={log}", "-p",
                                "natnet_emulator.mocap_topic=/nobody", expect=2, timeout=60)
        self.assertIn("no pose has come", done.stdout + done.stderr)

    def test_a_file_that_makes_no_sense_is_refused(self):
        for change, where in (("up_axis: y", "up_axis: x"), ("unit: mm", "unit: feet"), ("version: auto", "version: 9.9"),
                              ("server: 127.0.0.1", "server: motive"), ("multicast: ", "multicats: ")):
            config = self.natnet_config()
            config.write_text(config.read_text().replace(change, where))
            done = self.run_command("fly", self.short_mission(), "--plant", "emulator", "--natnet", config, "--out", "x",
                                    expect=4)
            self.assertIn("natnet.yaml", done.stderr)
        done = self.run_command("fly", self.short_mission(), "--natnet", "optitrack", "--out", "x", expect=4)
        self.assertIn("--plant emulator or hardware", done.stderr)


if __name__ == "__main__":
    unittest.main()
