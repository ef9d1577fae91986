"""The long half of launch_scripts/reliability.sh: kills, dead rotors and hours, each with a printed figure.

OMNIFLIGHT_REPETITIONS shortens them.
"""

import csv
import json
import os
import random
import re
import signal
import subprocess
import sys
import time
import unittest

import board_line
import system
import test_rotor_line

FRESH_S = test_rotor_line.FRESH_S
NO_RESULT = 2


def repetitions(usual):
    return int(os.environ.get("OMNIFLIGHT_REPETITIONS", usual))


def slope(points):
    """Least-squares slope of [(x, y)]."""
    n = len(points)
    mx, my = sum(x for x, _ in points) / n, sum(y for _, y in points) / n
    return sum((x - mx) * (y - my) for x, y in points) / sum((x - mx) ** 2 for x, _ in points)


class Kills(test_rotor_line.EndsOnTheLine):
    """Each component of a flight through boards killed at random instants of free flight."""

    def kills(self, component, code=NO_RESULT, parameters=(), meanwhile=lambda pids: None):
        """Of each flight, after its end: (its folder, instant of the kill [s, CLOCK_MONOTONIC], answer of meanwhile(pids))."""
        pick = random.Random(component)
        for k in range(repetitions(20)):
            fly, pids = self.take_off(out=f"flight{k}", parameters=parameters)
            time.sleep(pick.uniform(0, 0.5))
            killed = time.monotonic()
            os.kill(pids[component], signal.SIGKILL)
            answer = meanwhile(pids)
            said = "".join(fly.communicate(timeout=60))
            self.assertEqual(fly.returncode, code, said)
            flight = self.json(f"flight{k}/flight.json")
            self.assertIn(component, str([flight["reason"], flight["losses"]]))
            yield self.dir / f"flight{k}", killed, answer
            self.log.unlink()

    def kill_repeatedly(self, component, check, code=NO_RESULT, parameters=()):
        figures = []
        for _, killed, _ in self.kills(component, code, parameters):
            figures.append(self.check_ramp(killed))
            check(figures[-1])
        print(f"\n{component} killed {len(figures)} times: all rotors wound down; last command repeated for at most "
              f"{1e3 * max(f['repeated_s'] for f in figures):.1f} ms, flown on for {min(f['flown_on_s'] for f in figures):.2f} to "
              f"{max(f['flown_on_s'] for f in figures):.2f} s")

    def test_long_gateway_killed_twenty_times(self):
        """Nobody commands any more: the boards' own watchdog (0.5 s) and ramp (0.5 s) stop the motors."""
        def boards_end(pids):
            killed = time.monotonic()
            # the boards keep their power for as long as a motor turns, 3 s at most
            system.wait_until("the boards to stop their motors", lambda: not system.alive(pids["omniflight_emulator"]), 10)
            return time.monotonic() - killed

        silent, stopped = [], []
        for _, killed, stop_s in self.kills("omniflight_gateway", meanwhile=boards_end):
            silent.append(max(t for t, _, _ in board_line.Line(self.log).commands) - killed)
            stopped.append(stop_s)
        print(f"\nomniflight_gateway killed {len(silent)} times: the last command at most {1e3 * max(silent):.1f} ms later; boards "
              f"stopped their motors and ended within {min(stopped):.2f} to {max(stopped):.2f} s")
        self.assertLess(max(silent), FRESH_S)
        self.assertGreater(min(stopped), 0.9, "the boards ramp down, they do not cut")
        self.assertLess(max(stopped), 2.0)

    def test_long_emulator_killed_twenty_times(self):
        """The boards are gone: the gate trips at once, and the flight ends."""
        noticed = []
        for folder, killed, _ in self.kills("omniflight_emulator"):
            epoch_s = 1e-9 * int(re.search(r"epoch_monotonic_ns: (\d+)", (folder / "params.yaml").read_text()).group(1))
            said = (folder / "log/gateway.log").read_text()
            tripped = re.search(r"gate ramping: link_lost at ([\d.]+) s", said)
            self.assertTrue(tripped, said)
            noticed.append(float(tripped.group(1)) - (killed - epoch_s))
        print(f"\nomniflight_emulator killed {len(noticed)} times: the gate wound down {1e3 * min(noticed):.1f} to "
              f"{1e3 * max(noticed):.1f} ms later")
        self.assertLess(max(noticed), FRESH_S + test_rotor_line.LATE_S)

    def test_long_allocator_killed_twenty_times(self):
        self.kill_repeatedly("omniflight_allocator", lambda f: self.assertLess(f["flown_on_s"], 0.2))

    def test_long_controller_killed_twenty_times(self):
        self.kill_repeatedly("omniflight_controller", lambda f: self.assertLess(f["flown_on_s"], 0.2))

    def test_long_recorder_killed_twenty_times(self):
        self.kill_repeatedly("omniflight_recorder", lambda f: self.assertGreater(f["flown_on_s"], 1.0))

    def test_long_planner_killed_twenty_times(self):
        self.kill_repeatedly("omniflight_planner", lambda f: self.assertGreater(f["flown_on_s"], 1.0), code=0)

    def test_long_natnet_receiver_killed_twenty_times(self):
        """No pose any more: the vehicle descends on the gyroscopes and accelerometers, and stops on what is below it.

        Below the short mission the map has a counter of 0.60 m; a vehicle tilted by 30 deg touches it with its origin 0.1758 m
        above, and 0.12 m more count as landed (test_faults)."""
        figures, lowest = [], []
        for folder, killed, _ in self.kills("omniflight_natnet", parameters=("--natnet", self.natnet_config())):
            self.assertIn("gate ramping: failsafe", (folder / "log/gateway.log").read_text())
            figures.append(self.check_ramp(killed))
            self.run_command("export", str(folder / "flight.mcap"), "--to", "csv", "--out", "flight.csv", "--force", "--quiet")
            with open(self.dir / "flight.csv", newline="") as file:
                heights = [float(row["ref_pz_m"]) for row in csv.DictReader(file) if row["ref_pz_m"]]
            lowest.append(min(heights))
            self.assertLess(lowest[-1], 0.6 + 0.1758 + 0.12, "rotors wound down in the air")
            # at 0.3 m/s from 1.3 m or more above the floor
            self.assertGreater(figures[-1]["flown_on_s"], (1.3 - lowest[-1]) / 0.3, "dropped")
        print(f"\nomniflight_natnet killed {len(figures)} times: descended for {min(f['flown_on_s'] for f in figures):.2f} to "
              f"{max(f['flown_on_s'] for f in figures):.2f} s to {min(lowest):.2f} to {max(lowest):.2f} m, then wound down")


class BlockedWrites(test_rotor_line.EndsOnTheLine):
    """The gateway's control period beside a recorder that cannot write, against quiet flights in turn with it."""

    def fly_beside(self, trouble, out, where=None):
        """flight.json of a flight through boards; trouble(pids, folder) happens while it flies freely."""
        fly, pids = self.take_off((where or self.dir) / out, parameters=["-p", "gateway.least_free_MB=0"])
        trouble(pids, where)
        output = "".join(fly.communicate(timeout=60))
        flight = self.json((where or self.dir) / out / "flight.json")
        self.log.unlink()
        self.assertGreater(flight["periods"], 2000, output)
        return flight, output

    def compare(self, name, trouble, where=None):
        latest, missed, said = {True: [], False: []}, {True: 0, False: 0}, ""
        for k in range(repetitions(3)):
            for troubled in (False, True):
                flight, output = self.fly_beside(trouble if troubled else lambda *_: None, f"{k}{'beside' if troubled else 'quiet'}",
                                                 where if troubled else None)
                latest[troubled].append(flight["period_latest_ms"])
                missed[troubled] += flight["periods_missed"]
                said += output if troubled else ""
        quiet, beside = (sorted(latest[key])[len(latest[key]) // 2] for key in (False, True))
        print(f"\n{name} repeated {len(latest[True])} times: a control period of 2 ms began at most {beside:.2f} ms late "
              f"(median of flights; {quiet:.2f} ms beside a sound recorder), {missed[True]} missed ({missed[False]})")
        self.assertLessEqual(beside, quiet + 2.0)
        return said

    def test_long_a_recorder_that_hangs(self):
        def hang(pids, _):
            os.kill(pids["omniflight_recorder"], signal.SIGSTOP)
            time.sleep(3)
            os.kill(pids["omniflight_recorder"], signal.SIGCONT)
        self.compare("hung recorder", hang)

    def test_long_a_recorder_on_a_full_disk(self):
        disk = self.small_disk(64)

        def fill(_, folder):
            ballast = folder / "ballast"
            with open(ballast, "wb", buffering=0) as file, self.assertRaises(OSError):
                while True:
                    file.write(bytes(4096))
            time.sleep(2)
            ballast.unlink()  # room for the results of the flight
        said = self.compare("full disk", fill, disk)
        self.assertIn("No space left", said)


class Load(system.SystemTest):
    """Ten minutes (OMNIFLIGHT_SECONDS) through boards, in real time, beside what takes all processors and the disk."""

    PROCESSOR = "while True: pass"
    DISK = ("import os, sys\n"
            "while True:\n"
            "    with open(sys.argv[1], 'wb') as file:\n"
            "        for _ in range(16):\n"
            "            file.write(bytes(1 << 20)); file.flush(); os.fsync(file.fileno())\n")

    def test_long_ten_minutes_under_load(self):
        seconds = int(os.environ.get("OMNIFLIGHT_SECONDS", 600))
        mission = self.short_mission(changes={"by: [0.1, 0, 0.1], hold_s: 0.5": f"by: [0.1, 0, 0.1], hold_s: {seconds}"})
        programs = [[self.PROCESSOR]] * 2 * os.cpu_count() + [[self.DISK, self.dir / "ballast"]]
        hogs = [subprocess.Popen([sys.executable, "-c", *map(str, program)]) for program in programs]

        def end():
            for hog in hogs:
                hog.kill()
                hog.wait()
        self.addCleanup(end)
        flight = self.fly(mission, "--plant", "emulator", "--sensors", "laboratory", timeout=2 * seconds + 120, expect=None)
        end()
        info = json.loads(self.run_command("info", "flight/flight.mcap", "--json", timeout=600).stdout)
        stored = sum(topic["messages"] for topic in info["topics"])
        dropped = {key.removeprefix("omniflight.dropped."): int(value) for key, value in info["metadata"].items()
                   if key.startswith("omniflight.dropped.")}
        ticks = next(topic["messages"] for topic in info["topics"] if topic["name"] == "/omniflight/tick")
        sent = flight["periods"] - flight["periods_missed"]  # one tick a period that was kept
        print(f"\nunder load for {flight['simulated_s']:.0f} s, {len(hogs) - 1} processes on {os.cpu_count()} processors and one on the "
              f"disk: {stored} messages stored, {sum(dropped.values())} dropped and counted, {flight['periods_missed']} of "
              f"{flight['periods']} periods missed, {flight['verdict']}")
        self.assertEqual(flight["verdict"], "flown", flight["reason"])
        self.assertEqual(len(dropped), len(info["topics"]), "drops are counted topic by topic")
        self.assertGreaterEqual(ticks + dropped["/omniflight/tick"], sent, "a tick is missing that nobody counted")
        # the emulator publishes for some periods while the recorder does not hear it yet, or any more
        self.assertLessEqual(sum(dropped.values()), 1e-4 * stored, dropped)


class Rotors(system.SystemTest):
    def test_long_a_rotor_dies_at_a_hundred_instants(self):
        pick = random.Random(1)
        self.run_command("plan", "trajectory_1", "--out", "plan", "--quiet")
        ends, worst = {}, []
        for k in range(repetitions(100)):
            at, rotor = pick.uniform(4, 14), pick.randint(1, 8)
            schedule = self.write("faults.yaml", "schema: omniflight.faults/1\nfaults:\n"
                                  f"  - {{at_s: {at:.3f}, kind: rotor_loss, rotor: {rotor}, for_s: 60}}\n")
            done = self.run_command("fly", "trajectory_1", "--plan", "plan", "--in-process", "--faults", schedule, "--out",
                                    f"flight{k}", "--quiet", expect=None)
            self.assertIn(done.returncode, (0, NO_RESULT), done.stderr)
            flight = self.json(f"flight{k}/flight.json")
            ends[flight["verdict"]] = ends.get(flight["verdict"], 0) + 1
            if flight["verdict"] in ("flown", "flown_badly"):
                worst.append(flight["metrics"]["true"]["worst_position_m"])
            else:
                print(f"\n{flight['verdict']}: rotor {rotor} dead from {at:.3f} s on: {flight['reason']}")
            csv = self.dir / "flight.csv"
            self.run_command("export", f"flight{k}/flight.mcap", "--to", "csv", "--out", csv, "--quiet", "--force")
            text = csv.read_text().lower()
            self.assertNotRegex(text, r"[,\n]-?(nan|inf)", "a number that is none was commanded or recorded")
        recovered = len(worst)
        print(f"\n{sum(ends.values())} flights with one rotor of eight dead from a random instant on: {recovered} flown to the end"
              + (f" within {max(worst):.2f} m" if worst else "") + f", {ends}; every number finite")
        self.assertEqual(ends, {"flown": repetitions(100)})


class Hours(system.SystemTest):
    """One flight of OMNIFLIGHT_SOAK_HOURS (0.5) simulated hours."""

    def test_long_soak(self):
        hold_s = 600
        holds = max(1, round(3600 * float(os.environ.get("OMNIFLIGHT_SOAK_HOURS", 0.5)) / hold_s))
        mission = self.short_mission(changes={
            "budget_ms: 5000": "budget_ms: 120000",  # beside other work hours of holds are not checked in seconds
            "{name: aside and up, by: [0.1, 0, 0.1], hold_s: 0.5}":
            "\n  - ".join(f"{{name: hold {k}, by: [0, 0, {0.02 * (-1) ** k}], hold_s: {hold_s}}}" for k in range(holds))})
        fly = self.start_command("fly", mission, "--sensors", "laboratory", "--out", "flight", "--quiet")
        begin = time.monotonic()
        memory, files = {}, {}
        while fly.poll() is None:
            self.assertLess(time.monotonic() - begin, 300 + holds * hold_s)
            for name, pid in system.children(fly.pid).items():
                try:
                    with open(f"/proc/{pid}/statm") as statm:
                        resident = int(statm.read().split()[1]) * os.sysconf("SC_PAGESIZE") * 1e-6
                    opened = len(os.listdir(f"/proc/{pid}/fd"))
                except OSError:
                    continue
                memory.setdefault(name, []).append((time.monotonic() - begin, resident))
                files.setdefault(name, []).append(opened)
            time.sleep(0.5)
        said = fly.communicate()
        self.assertEqual(fly.returncode, 0, said)
        flight = self.json("flight/flight.json")
        self.assertEqual(flight["losses"], {} if isinstance(flight["losses"], dict) else [], flight["losses"])
        wall, hours = time.monotonic() - begin, flight["simulated_s"] / 3600
        slopes = {}
        for name, points in memory.items():
            late = [(t / wall * hours, m) for t, m in points if 0.3 * wall < t < 0.95 * wall]
            if len(late) > 10:
                slopes[name] = slope(late)
                settled = files[name][len(files[name]) // 3:-4]
                self.assertEqual(min(settled), max(settled), f"{name} opens or closes files")
        print(f"\nsoak of {hours:.2f} h in {wall:.0f} s, nothing lost, files constant, memory in MB/h: "
              + ", ".join(f"{name.removeprefix('omniflight_')} {s:.2f}" for name, s in sorted(slopes.items())))
        self.assertGreaterEqual(len(slopes), 4)
        for name, mb_per_hour in slopes.items():
            # the recorder keeps the index of its chunks until it closes the file
            self.assertLess(mb_per_hour, 20.0 if name == "omniflight_recorder" else 1.0, name)


if __name__ == "__main__":
    unittest.main()
