"""What goes wrong in flight: killed components, Ctrl-C, a full disk. The rest stops, the recording stays readable."""

import os
import resource
import signal
import time
import unittest

import system

NO_RESULT = 2


class InFlight(system.SystemTest):
    def take_off(self, *arguments, **options):
        """A flight in real time that has been recording for a while: (process, {component: pid})."""
        # a loaded machine may starve a component for longer than the usual 0.1 s
        fly = self.start_command("fly", self.short_mission(), "--rate", "realtime", "--out", "flight", "--param",
                                 "simulator.stale_after_s=0.5", *arguments, **options)
        return fly, self.wait_for_recording(fly, 600_000)

    def wait_for_recording(self, fly, size):
        """Waits until so many bytes are recorded, more than the trajectory alone takes: {component: pid}."""
        recording = self.dir / "flight/flight.mcap"
        system.wait_until("a recording that grows",
                          lambda: recording.exists() and recording.stat().st_size > size or fly.poll() is not None, 30)
        if fly.poll() is not None:
            self.fail("the flight ended early: " + "".join(fly.communicate()))
        return system.children(fly.pid)

    def land(self, fly, pids, limit):
        """Waits for the end: everything printed. Fails when it takes longer than limit [s] or leaves processes."""
        begin = time.monotonic()
        output, error = fly.communicate(timeout=limit + 5)
        self.assertLess(time.monotonic() - begin, limit)
        left = [name for name, pid in pids.items() if system.alive(pid)]
        self.assertEqual(left, [])
        return output + error

    def recorded(self):
        """Seconds in the recording; fails when it cannot be read."""
        info = self.run_command("info", "flight/flight.mcap", "--json")
        return system.json.loads(info.stdout)["duration_s"]


class KilledComponents(InFlight):
    def kill(self, name):
        fly, pids = self.take_off()
        self.assertEqual(len(pids), 5, pids)
        os.kill(pids[name], signal.SIGKILL)
        text = self.land(fly, pids, 15)
        self.assertEqual(fly.returncode, NO_RESULT, text)
        self.assertIn(name, text)
        flight = self.json("flight/flight.json")
        self.assertEqual(flight["verdict"], "not flown to the end")
        self.assertIn(name, flight["reason"])
        self.assertGreater(self.recorded(), 0.5)

    def test_controller(self):
        self.kill("omniflight_controller")
        self.assertIn("the rotors are stopped", (self.dir / "flight/log/simulator.log").read_text())

    def test_allocator(self):
        self.kill("omniflight_allocator")
        self.assertIn("the rotors are stopped", (self.dir / "flight/log/simulator.log").read_text())

    def test_simulator(self):
        self.kill("omniflight_simulator")

    def test_recorder(self):
        self.kill("omniflight_recorder")
        self.assertIn("without its summary", self.run_command("info", "flight/flight.mcap").stdout)

    def test_controller_in_lockstep(self):
        fly = self.start_command("fly", "around_frame", "--out", "flight")
        pids = self.wait_for_recording(fly, 4_000_000)
        os.kill(pids["omniflight_controller"], signal.SIGKILL)
        text = self.land(fly, pids, 15)
        self.assertEqual(fly.returncode, NO_RESULT, text)
        self.assertIn("omniflight_controller", self.json("flight/flight.json")["reason"])
        self.assertIn("no command for the tick", (self.dir / "flight/log/simulator.log").read_text())
        self.recorded()


class ControlC(InFlight):
    def test_everything_stops_in_order(self):
        fly, pids = self.take_off()
        fly.send_signal(signal.SIGINT)
        text = self.land(fly, pids, 10)
        self.assertEqual(fly.returncode, NO_RESULT, text)
        self.assertEqual(self.json("flight/flight.json")["reason"], "interrupted")
        info = self.run_command("info", "flight/flight.mcap").stdout
        self.assertNotIn("without its summary", info)  # closed, not cut
        for log in (self.dir / "flight/log").glob("*.log"):
            self.assertIn("shut down", log.read_text(), log.name)

    def test_a_killed_command_leaves_no_components(self):
        fly, pids = self.take_off()
        fly.kill()
        fly.wait(timeout=5)
        system.wait_until("the components to end", lambda: not any(map(system.alive, pids.values())), 15)
        self.assertGreater(self.recorded(), 0.5)


class FullDisk(system.SystemTest):
    def check(self, fly, out, limit=30):
        begin = time.monotonic()
        output, error = fly.communicate(timeout=limit + 5)
        self.assertLess(time.monotonic() - begin, limit)
        self.assertEqual(fly.returncode, NO_RESULT, output + error)
        self.assertIn("omniflight_recorder", output + error)
        self.assertIn("flight.mcap", output + error)
        self.assertTrue((out / "flight.mcap").exists())
        self.run_command("info", out / "flight.mcap")
        return output + error

    def test_file_system_without_space(self):
        disk = self.small_disk(3)
        fly = self.start_command("fly", "trajectory_1", "--out", disk / "flight")
        text = self.check(fly, disk / "flight")
        self.assertIn("No space left", text)

    def test_file_size_limit(self):
        def limit():
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (2_000_000, 2_000_000))

        fly = self.start_command("fly", "trajectory_1", "--out", "flight", preexec_fn=limit, restore_signals=False)
        text = self.check(fly, self.dir / "flight")
        self.assertIn("File too large", text)

    def test_folder_that_cannot_be_made(self):
        self.write("file", "")
        done = self.run_command("fly", self.short_mission(), "--out", "file/flight", expect=4)
        self.assertIn("file/flight", done.stderr)
        self.assertIn("Choose another --out", done.stderr)


if __name__ == "__main__":
    unittest.main()
