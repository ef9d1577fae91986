"""Verbs of every day: import, export, replay, topic, new, compare."""

import csv
import os
import re
import subprocess
import unittest

import system


def samples(path):
    """{column: [(t, value)]} of a canonical CSV."""
    out = {}
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            for key, value in row.items():
                if key != "t_s" and value:
                    out.setdefault(key, []).append((float(row["t_s"]), float(value)))
    return out


class Exported(system.SystemTest):
    def setUp(self):
        super().setUp()
        self.fly(self.short_mission(), "--in-process", "--sensors", "laboratory")

    def test_mcap_round_trip_keeps_every_sample(self):
        self.run_command("export", "flight/flight.mcap", "--to", "csv", "--out", "flight.csv")
        self.run_command("export", "flight/flight.mcap", "--to", "mcap", "--out", "again.mcap", "--quiet")
        self.run_command("export", "again.mcap", "--to", "csv", "--out", "again.csv")
        before, after = samples(self.dir / "flight.csv"), samples(self.dir / "again.csv")
        lost = {c for c in before if c not in after}
        self.assertLessEqual(lost, {"phase"}, "only the phase of a tick has no topic of its own")
        for column in after:
            self.assertEqual(len(before[column]), len(after[column]), column)
            worst = max(abs(a[1] - b[1]) for a, b in zip(before[column], after[column]))
            self.assertLess(worst, 1e-6 if column in ("vbat_V", "ibat_A") else 1e-12, column)
            self.assertLess(max(abs(a[0] - b[0]) for a, b in zip(before[column], after[column])), 2e-9, column)

    def test_rosbag2(self):
        self.run_command("export", "flight/flight.mcap", "--to", "rosbag2", "--out", "bag")
        metadata = (self.dir / "bag/metadata.yaml").read_text()
        self.assertIn("storage_identifier: mcap", metadata)
        self.assertIn("name: /omniflight/imu, type: sensor_msgs/msg/Imu", metadata)
        total = int(re.search(r"message_count: (\d+)\n  topics", metadata).group(1))
        self.assertEqual(total, sum(map(int, re.findall(r"\n      message_count: (\d+)", metadata))))
        info = system.json.loads(self.run_command("info", "bag/bag_0.mcap", "--json").stdout)
        self.assertIn("gyro", [s["name"] for s in info["signals"]])
        done = self.run_command("export", "flight/flight.mcap", "--to", "rosbag2", "--out", "bag", expect=4)
        self.assertIn("exists already", done.stderr)
        done = self.run_command("export", "flight/flight.mcap", "--to", "rosbag2", "--out", "bag", "--force", expect=4)
        self.assertIn("exists already", done.stderr)

    def test_nothing_half_written(self):
        done = self.run_command("export", "flight/flight.mcap", "--to", "mcap", "--out", "nowhere/x.mcap", expect=4)
        self.assertIn("nowhere", done.stderr)
        self.write("little.csv", "t_s,vx_mps,vy_mps,vz_mps\n0,1,2,3\n1,1,2,3\n")
        done = self.run_command("export", "little.csv", "--to", "mcap", "--out", "little.mcap", expect=4)
        self.assertIn("no signal that one of our topics carries", done.stderr)
        self.assertEqual([p.name for p in self.dir.iterdir() if "little.mcap" in p.name], [])
        done = self.run_command("export", "little.csv", "--out", "little.csv", expect=4)
        self.assertIn("is the recording itself", done.stderr)

    def test_import_a_foreign_csv(self):
        rows = "\n".join(f"{k * 0.01},0,0,{1 + k * 0.001},1,0,0,0" for k in range(100))
        self.write("foreign.csv", "t_s,px_m,py_m,pz_m,qw,qx,qy,qz\n" + rows + "\n")
        done = self.run_command("import", "foreign.csv", "--out", "foreign.mcap", "--json")
        self.assertEqual(system.json.loads(done.stdout)["messages"], {"/omniflight/mocap": 100})
        self.run_command("export", "foreign.mcap", "--out", "back.csv")
        back = samples(self.dir / "back.csv")["pz_m"]
        self.assertAlmostEqual(back[-1][1], 1.099, places=12)

    def test_compare_shows_control_signals(self):
        self.fly("short.yaml", "--in-process", "--set", "mass=1.5", out="heavy")
        self.run_command("compare", "flight/flight.mcap", "heavy/flight.mcap", "--out", "cmp", "--quiet")
        result = self.json("cmp/compare.json")
        rows = {(r["stage"], r["channel"]): r for r in result["control"]}
        self.assertEqual({s for s, _ in rows}, {"control", "allocation", "actuation", "power"})
        for key, unit in ((("actuation", "speed 1"), "rad/s"), (("allocation", "u1"), "N"), (("allocation", "alpha"), "deg"),
                          (("control", "qddr z"), "m/s2"), (("power", "mechanical"), "W")):
            self.assertEqual(rows[key]["unit"], unit)
        # thrust goes with the mass, power with its 3/2
        mass = 1.5 / 1.315
        self.assertAlmostEqual(rows["allocation", "u1"]["ratio"], mass, delta=0.03)
        self.assertAlmostEqual(rows["power", "mechanical"]["ratio"], mass ** 1.5, delta=0.05)
        self.assertAlmostEqual(rows["allocation", "alpha"]["real_rms"], 30, places=6)
        page = (self.dir / "cmp/report.html").read_text()
        self.assertIn("Rotor speeds (actuation)", page)
        headline = re.search(r'class="verdict warn".*?<h2>(.*?)</h2>', page, re.S)
        power = next(r for r in result["rows"] if r["channel"] == "mean power")["ratio"]
        self.assertIn(f" takes {power:.2f} times the power", headline.group(1), "what differs is said first")
        self.assertLess(headline.start(), page.index("<table"))


class OnTheBus(system.SystemTest):
    def test_replay_is_heard(self):
        self.fly(self.short_mission(), "--in-process")
        domain = ("--domain", "191")
        ear = self.start_command("topic", "hz", "/omniflight/imu", "--for-s", "8", "--json", *domain)
        echo = self.start_command("topic", "echo", "/omniflight/mocap", "--count", "3", "--for-s", "8", *domain)
        record = self.start_command("topic", "record", "--for-s", "8", "--out", "heard.mcap", "--quiet", *domain)
        done = self.run_command("replay", "flight/flight.mcap", "--rate", "4", "--wait-s", "5", "--json", *domain)
        sent = system.json.loads(done.stdout)["messages"]
        heard, error = ear.communicate(timeout=30)
        self.assertEqual(ear.returncode, 0, error)
        result = system.json.loads(heard)
        self.assertGreater(result["messages"], 0.9 * sent["/omniflight/imu"])
        self.assertAlmostEqual(result["stamp_Hz"], 1000, delta=5)
        lines, error = echo.communicate(timeout=30)
        self.assertEqual(echo.returncode, 0, error)
        self.assertIn('"signal":"position"', lines)
        _, error = record.communicate(timeout=30)
        self.assertEqual(record.returncode, 0, error)
        info = system.json.loads(self.run_command("info", "heard.mcap", "--json").stdout)
        self.assertIn("rotor_speed", [s["name"] for s in info["signals"]])

    def test_a_silent_bus(self):
        quick = ("--domain", "192", "--for-s", "0.5")
        done = self.run_command("topic", "list", *quick, expect=2)
        self.assertIn("/omniflight/imu", done.stdout)
        self.assertIn("nothing was said", self.run_command("topic", "echo", "/omniflight/imu", *quick, expect=2).stdout)
        done = self.run_command("topic", "hz", "/omniflight/imus", *quick, expect=4)
        self.assertIn("Did you mean '/omniflight/imu'", done.stderr)

    def test_replay_of_what_is_no_mcap(self):
        self.write("x.csv", "t_s,px_m\n0,1\n")
        self.assertIn("x.csv", self.run_command("replay", "x.csv", expect=4).stderr)


class New(system.SystemTest):
    def test_mission_plans(self):
        self.run_command("new", "mission", "my_mission", "--out", ".")
        self.run_command("plan", "configs/missions/my_mission.yaml", "--out", "plan", "--quiet")
        done = self.run_command("new", "mission", "my_mission", "--out", ".", expect=4)
        self.assertIn("exists already", done.stderr)

    def test_vehicle_loads(self):
        self.run_command("new", "vehicle", "my_quad", "--out", ".")
        self.run_command("design", "configs/vehicles/my_quad/my_quad.yaml", "--alpha", "0", "--out", "design", "--quiet")

    def test_effect_compiles(self):
        folder = self.dir / "src/omniflight_physics/src/effects"
        folder.mkdir(parents=True)
        source = system.ROOT / "src/omniflight_physics"
        for name in ("table.hpp", "table.cpp"):
            (folder / name).write_text((source / "src/effects" / name).read_text())
        self.run_command("new", "effect", "my_effect", "--out", ".")
        self.assertIn("&my_effect_effect(),", (folder / "table.cpp").read_text())
        includes = [self.dir / "src/omniflight_physics/src", source / "src", "/usr/include/eigen3"]
        includes += [system.ROOT / f"src/omniflight_{p}/include" for p in ("physics", "core", "vehicle", "files")]
        for name in ("my_effect.cpp", "table.cpp"):
            done = subprocess.run(["c++", "-std=c++20", "-fsyntax-only", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow",
                                   "-Werror", *(f"-I{i}" for i in includes), str(folder / name)], text=True,
                                  capture_output=True, timeout=80)
            self.assertEqual(done.returncode, 0, done.stderr)

    def test_names(self):
        for name in ("../x", "Xy", "a b", ""):
            self.run_command("new", "mission", name, "--out", ".", expect=4)
        self.assertFalse(os.path.exists(self.dir / "configs"))


class Help(system.SystemTest):
    def test_every_verb_has_an_example_and_the_common_options(self):
        verbs = re.findall(r"^  ([a-z]+) ", self.run_command("--help").stdout.split("Subcommands:")[1], re.M)
        self.assertGreaterEqual(len(verbs), 16)
        for verb in verbs:
            text = self.run_command(verb, "--help").stdout
            for word in (f"Example: omniflight {verb}", "--json", "--out", "--quiet"):
                self.assertIn(word, text, verb)


if __name__ == "__main__":
    unittest.main()
