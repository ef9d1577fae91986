"""Logs of other systems, written here from the descriptions of their formats: info, import, new --from, --check."""

import math
import shutil
import sqlite3
import struct
import unittest

import system

START_US = 5_000_000
FORMATS = [
    "sensor_combined:uint64_t timestamp;float[3] gyro_rad;float[3] accelerometer_m_s2;",
    "vehicle_attitude:uint64_t timestamp;float[4] q;uint8_t[4] _padding0;",
    "vehicle_local_position:uint64_t timestamp;float x;float y;float z;float vx;float vy;float vz;bool xy_valid;"
    "bool z_valid;bool v_xy_valid;bool v_z_valid;",
    "esc_report:uint64_t timestamp;int32_t esc_rpm;uint8_t[4] _padding0;",
    "esc_status:uint64_t timestamp;uint8_t esc_count;uint8_t[7] _padding0;esc_report[8] esc;",
    "battery_status:uint64_t timestamp;float voltage_v;float current_a;",
]
TOPICS = ["sensor_combined", "vehicle_attitude", "vehicle_local_position", "esc_status", "battery_status"]


def record(kind, body):
    return struct.pack("<HB", len(body), ord(kind)) + body


def parameter(name, value):
    key = ("int32_t " if isinstance(value, int) else "float ") + name
    return record("P", bytes([len(key)]) + key.encode() + struct.pack("<i" if isinstance(value, int) else "<f", value))


def ulog(seconds=20):
    """A hover that climbs and sinks by 0.3 m, nose to the north, in PX4's NED and FRD; 1 kg on four rotors."""
    out = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", START_US) + record("B", bytes(40))
    out += record("I", bytes([len("char[3] sys_name")]) + b"char[3] sys_namePX4")
    out += b"".join(record("F", f.encode()) for f in FORMATS)
    out += parameter("CA_ROTOR_COUNT", 4) + parameter("MAV_TYPE", 2)
    for i, (x, y, km) in enumerate(((0.1, 0.12, 0.02), (-0.1, -0.12, 0.02), (0.1, -0.12, -0.02), (-0.1, 0.12, -0.02))):
        out += parameter(f"CA_ROTOR{i}_PX", x) + parameter(f"CA_ROTOR{i}_PY", y) + parameter(f"CA_ROTOR{i}_KM", km)
    out += b"".join(record("A", struct.pack("<BH", 0, i) + name.encode()) for i, name in enumerate(TOPICS))

    def data(topic, body):
        return record("D", struct.pack("<H", TOPICS.index(topic)) + body)

    for k in range(seconds * 200):
        t, us = k / 200, START_US + k * 5000
        height, speed, acceleration = 1 + 0.3 * math.sin(t), 0.3 * math.cos(t), -0.3 * math.sin(t)
        out += data("sensor_combined", struct.pack("<Q6f", us, 0, 0, 0, 0, 0, -(9.81 + acceleration)))
        if k % 2:
            continue
        out += data("vehicle_attitude", struct.pack("<Q4f", us, 1, 0, 0, 0))
        out += data("vehicle_local_position", struct.pack("<Q6f4B", us, 0, 0, -height, 0, 0, -speed, 1, 1, 1, 1))
        rpm = round(400 * math.sqrt((9.81 + acceleration) / 9.81) * 30 / math.pi)
        out += data("esc_status", struct.pack("<QB7x", us, 4) + struct.pack("<Qi4x", us, rpm) * 4 + bytes(64))
        out += data("battery_status", struct.pack("<Q2f", us, 15.8 - 0.02 * t, 8.0))
    return out


class ForeignLogs(system.SystemTest):
    def setUp(self):
        super().setUp()
        (self.dir / "flight.ulg").write_bytes(ulog())

    def test_info_says_what_feeds_what(self):
        done = self.run_command("info", "flight.ulg", "--json")
        info = system.json.loads(done.stdout)
        self.assertEqual(info["format"], "ulog")
        counts = {t["name"]: (t["messages"], t["feeds"]) for t in info["topics"]}
        self.assertEqual(counts["sensor_combined"], (4000, ["gyro", "acc"]))
        self.assertEqual(counts["esc_status"], (2000, ["rotor_speed"]))
        self.assertEqual(info["vehicle"]["rotor_count"], 4)
        self.assertEqual([r["spin"] for r in info["vehicle"]["rotors"]], [-1, -1, 1, 1])
        self.assertEqual(info["notes"], [])
        text = self.run_command("info", "flight.ulg").stdout
        self.assertIn("from vehicle_attitude q, converted from NED/FRD", text)
        self.assertRegex(text, r"topic esc_status +2000 messages: rotor_speed")

    def test_a_vehicle_file_of_the_log_is_one_that_it_is_checked_against(self):
        done = self.run_command("new", "vehicle", "mine", "--from", "flight.ulg", "--out", "here")
        self.assertIn("missing: mass: made up; put the vehicle on a scale", done.stdout)
        vehicle = (self.dir / "here/configs/vehicles/mine/mine.yaml").read_text()
        self.assertIn("position: [0.1, -0.12, 0]", vehicle)  # PX4 has y to the right
        self.assertRegex(vehicle, r"thrust_coefficient: 1\.5\d+e-05")  # 9.81 N / 4 / (400 rad/s)^2
        done = self.run_command("diagnose", "flight.ulg", "--vehicle", "here/configs/vehicles/mine/mine.yaml", "--check",
                                "--out", "check", timeout=200)
        self.assertRegex(done.stdout, r"rotor_speed .*100\.0 Hz.*from esc_status esc\.esc_rpm")
        self.assertNotIn("missing: rotor_speed", done.stdout)
        self.assertIn("missing: ref_position", done.stdout)
        self.assertIn("motors: their order cannot be told", done.stdout)  # it does not turn
        self.assertEqual(self.json("check/diagnosis.json")["verdict"], "checked")
        self.run_command("new", "mission", "mine", "--from", "flight.ulg", expect=4)
        self.write("empty.csv", "t_s,vbat_V\n0,12\n1,12\n")
        done = self.run_command("new", "vehicle", "other", "--from", "empty.csv", "--out", "here", expect=4)
        self.assertIn("how many rotors", done.stderr)

    def test_import_keeps_every_sample(self):
        self.run_command("import", "flight.ulg", "--out", "flight.mcap", "--quiet")
        for log in ("flight.ulg", "flight.mcap"):
            info = system.json.loads(self.run_command("info", log, "--json").stdout)
            counts = {s["name"]: s["samples"] for s in info["signals"]}
            self.assertEqual({name: counts[name] for name in ("gyro", "acc", "rotor_speed", "vbat")},
                             {"gyro": 4000, "acc": 4000, "rotor_speed": 2000, "vbat": 2000}, log)

    def test_a_log_in_ned_is_turned_as_told_and_none_twice(self):
        self.write("ned.csv", "t_s,px_m,py_m,pz_m,qw,qx,qy,qz,gyro_x_radps,gyro_y_radps,gyro_z_radps\n" +
                   "".join(f"{0.01 * k:.2f},1,2,-3,1,0,0,0,0.1,0.2,0.3\n" for k in range(300)))
        done = self.run_command("import", "ned.csv", "--axes", "ned", "--out", "enu.csv")
        self.assertIn("position from NED", done.stdout)
        header, first = [line.split(",") for line in (self.dir / "enu.csv").read_text().splitlines()[:2]]
        values = dict(zip(header, map(float, first)))
        self.assertEqual([values[k] for k in ("px_m", "py_m", "pz_m", "gyro_x_radps", "gyro_y_radps", "gyro_z_radps")], [2, 1, 3, 0.1, -0.2, -0.3])
        for got, expected in zip((values[k] for k in ("qw", "qx", "qy", "qz")), (0.5 ** 0.5, 0, 0, 0.5 ** 0.5)):
            self.assertAlmostEqual(abs(got), expected)
        done = self.run_command("info", "flight.ulg", "--axes", "ned", expect=4)
        self.assertIn("not to be turned twice", done.stderr)

    def table(self, log, *options):
        """The samples of a log: {column: {time [ns]: value}}; times count from the first."""
        self.run_command("import", log, "--out", "table.csv", "--quiet", "--force", *options)
        header, *rows = [line.split(",") for line in (self.dir / "table.csv").read_text().splitlines()]
        first = float(rows[0][0])
        return {name: {round(1e9 * (float(row[0]) - first)): float(row[i]) for row in rows if row[i]}
                for i, name in enumerate(header) if i > 0}

    def test_what_is_written_of_every_format_reads_back_the_same(self):
        self.write("negative.csv", "t_s,px_m,py_m,pz_m\n" + "".join(f"{k / 8 - 1},{k},0,{k / 3}\n" for k in range(16)))
        logs = sorted((system.CONFIGS / "sample_logs").glob("synthetic_*"))
        self.assertEqual(len(logs), 7)
        for log in [*logs, self.dir / "negative.csv"]:
            read = self.table(log)
            done = self.run_command("import", log, "--out", "copy.mcap", "--force", "--json")
            left_out = system.json.loads(done.stdout)["left_out"]
            self.run_command("import", log, "--out", "copy.csv", "--quiet", "--force")
            shutil.rmtree(self.dir / "bag", ignore_errors=True)
            self.run_command("export", log, "--to", "rosbag2", "--out", "bag", "--quiet")
            for copy in ("copy.mcap", "copy.csv", "bag"):
                again = self.table(copy)
                lost = set(read) - set(again)
                self.assertTrue(all(any(name.startswith(signal) for signal in left_out) for name in lost), (log, lost))
                for name in set(read) - lost:
                    self.assertEqual(read[name].keys(), again[name].keys(), (log, copy, name))  # times to 1 ns
                    # sensor_msgs/BatteryState has float32; everything else is the same to the bit
                    rounded = name in ("vbat_V", "ibat_A") and copy != "copy.csv"
                    expected = {t: float(struct.unpack("f", struct.pack("f", v))[0]) if rounded else v for t, v in read[name].items()}
                    self.assertEqual(expected, again[name], (log, copy, name))

    def test_what_was_written_once_is_written_again_byte_for_byte(self):
        for log in sorted((system.CONFIGS / "sample_logs").glob("synthetic_*")):
            for to in ("csv", "mcap"):
                self.run_command("import", log, "--out", f"first.{to}", "--quiet", "--force")
                self.run_command("import", f"first.{to}", "--out", f"second.{to}", "--quiet", "--force")
                first, second = (self.signals(f"{name}.{to}") for name in ("first", "second"))
                self.assertGreater(len(first), 1, log)
                self.assertEqual(first, second, (log, to))

    def signals(self, recording):
        """Rows of the recording as a table, in the digits that tell every double from its neighbours."""
        self.run_command("export", recording, "--to", "csv", "--out", "signals.csv", "--quiet", "--force")
        return (self.dir / "signals.csv").read_text().splitlines()

    def test_a_map_for_a_table_is_started_from_its_columns(self):
        rows = "".join(f"{10 * k};0,5;1;{k / 8};0,01;0;1;11100;7\n".replace(".", ",") for k in range(50))
        self.write("board.csv", "Time [ms];px;py;pz;acc_x;acc_y;acc_z;vbat;remark\n" + rows)
        self.assertIn("describe the columns with --map FILE", self.run_command("info", "board.csv", expect=4).stderr)
        done = self.run_command("new", "map", "board", "--from", "board.csv", "--out", "here")
        self.assertIn("guessed: acc [m/s2] from 'acc_x' 'acc_y' 'acc_z', g by its size", done.stdout)
        self.assertIn("not used: 'remark', 7 to 7", done.stdout)
        info = system.json.loads(
            self.run_command("info", "board.csv", "--map", "here/configs/csv_maps/board.yaml", "--json").stdout)
        self.assertEqual({s["name"]: s["samples"] for s in info["signals"]}, {"position": 50, "acc": 50, "vbat": 50})
        self.assertAlmostEqual(info["duration_s"], 0.49)
        self.run_command("new", "map", "board", "--from", "board.csv", "--out", "here", expect=4)  # it exists
        self.assertIn("needs the CSV", self.run_command("new", "map", "other", expect=4).stderr)
        self.assertIn("is no CSV", self.run_command("new", "map", "other", "--from", "flight.ulg", expect=4).stderr)

    def test_a_map_chooses_the_topic(self):
        self.write("mine.yaml", "schema: omniflight.topic_map/1\ntopics:\n  - topic: vehicle_local_position\n"
                                "    time: {fields: [timestamp], unit: us}\n    signals:\n"
                                "      - {signal: position, fields: [x, y, z], frame: ned}\n")
        info = system.json.loads(self.run_command("info", "flight.ulg", "--map", "mine.yaml", "--json").stdout)
        names = [s["name"] for s in info["signals"]]
        self.assertIn("position", names)
        self.assertNotIn("est_position", names)
        self.write("wrong.yaml", "schema: omniflight.topic_map/1\ntopics:\n  - topic: x\n    signals:\n"
                                 "      - {signal: postion, fields: [x]}\n")
        done = self.run_command("info", "flight.ulg", "--map", "wrong.yaml", expect=4)
        self.assertRegex(done.stderr, r"wrong\.yaml:5.*Did you mean 'position'\?")

    def test_sqlite_bags_are_left_as_they_are(self):
        bag = self.dir / "bag/bag_0.db3"
        bag.parent.mkdir()
        with sqlite3.connect(bag) as db:
            db.execute("CREATE TABLE topics(id INTEGER PRIMARY KEY, name, type, serialization_format, offered_qos_profiles)")
            db.execute("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)")
            db.execute("INSERT INTO topics VALUES(1, '/mocap/pose', 'geometry_msgs/msg/PoseStamped', 'cdr', '')")
            for k in range(50):
                pose = struct.pack("<4sII", b"\0\1\0\0", 1000 + k, 0) + struct.pack("<I4s", 4, b"map\0") + struct.pack(
                    "<7d", k, 0, 1, 0, 0, 0, 1)
                db.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES(1, ?, ?)", (k * 10**9, pose))
        before = bag.read_bytes()
        info = system.json.loads(self.run_command("info", "bag", "--json").stdout)
        self.assertEqual({s["name"]: s["samples"] for s in info["signals"]}, {"position": 50, "attitude": 50})
        self.assertEqual(bag.read_bytes(), before)
        self.assertEqual([p.name for p in bag.parent.iterdir()], ["bag_0.db3"])

    def test_what_is_not_read_is_named(self):
        (self.dir / "log.bin").write_bytes(b"\xa3\x95\x80\x80\x59FMT" + bytes(80))
        done = self.run_command("info", "log.bin", expect=4)
        self.assertIn("ArduPilot log (.bin), which is not read", done.stderr)
        self.assertIn("mavlogdump.py --format csv", done.stderr)


if __name__ == "__main__":
    unittest.main()
