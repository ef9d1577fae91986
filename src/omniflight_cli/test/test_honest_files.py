"""Nothing is overwritten unasked, one folder takes one run, one recording has one time base, and export keeps everything."""

import os
import re
import shutil
import signal
import subprocess
import time
import unittest

import system


def times(recording):
    """{topic: (first, last)} log times [s] of an MCAP file."""
    text = subprocess.run([os.environ["OMNIFLIGHT_MCAP_DIGEST"], "--times", str(recording)], check=True, text=True,
                          capture_output=True).stdout
    return {topic: (float(first), float(last)) for topic, first, last in map(str.split, text.splitlines())}


def digest(recording):
    """{topic: digest of its messages}."""
    text = subprocess.run([os.environ["OMNIFLIGHT_MCAP_DIGEST"], str(recording)], check=True, text=True,
                          capture_output=True).stdout
    return {line.split()[0]: line for line in text.splitlines()}


def flown(recording):
    """digest() without what components say of themselves: that carries wall time."""
    return {topic: line for topic, line in digest(recording).items() if topic != "/component_state"}


class Overwriting(system.SystemTest):
    def test_a_recording_is_not_overwritten_without_force(self):
        mission = self.short_mission()
        self.fly(mission, "--in-process")
        recording = self.dir / "flight/flight.mcap"
        before = recording.read_bytes()
        done = self.run_command("fly", mission, "--in-process", "--seed", "2", "--out", "flight", expect=4)
        for word in ("flight/flight.mcap", "not overwritten", "--force"):
            self.assertIn(word, done.stderr)
        self.assertEqual(recording.read_bytes(), before)
        self.fly(mission, "--in-process", "--seed", "2", "--sensors", "laboratory", "--force")
        self.assertNotEqual(recording.read_bytes(), before)
        self.run_command("export", recording, "--out", "x.csv")
        done = self.run_command("export", recording, "--out", "x.csv", expect=4)
        self.assertIn("--force", done.stderr)
        self.run_command("export", recording, "--out", "x.csv", "--force")
        self.run_command("plan", mission, "--out", "plan")
        done = self.run_command("plan", mission, "--out", "plan", expect=4)
        self.assertIn("--force", done.stderr)

    def test_default_folders_carry_the_time(self):
        mission = self.short_mission()
        for _ in range(2):
            self.run_command("fly", mission, "--in-process", "--quiet")
        self.run_command("plan", mission)
        names = sorted(p.name for p in (self.dir / "runs").iterdir())
        self.assertEqual(len(names), 3, names)
        self.assertEqual([bool(re.fullmatch(r"(plan-short|short-simulator)-\d{8}-\d{6}(-\d+)?", n)) for n in names],
                         [True] * 3, names)

    def test_one_folder_takes_one_run(self):
        mission = self.short_mission()
        first = self.start_command("fly", mission, "--rate", "realtime", "--out", "flight", "--quiet")
        system.wait_until("the lock", lambda: (self.dir / "flight/.lock").exists(), 20)
        done = self.run_command("fly", mission, "--out", "flight", "--force", expect=4)
        self.assertIn("in use by another run", done.stderr)
        self.assertIn(str(first.pid), done.stderr)
        _, error = first.communicate(timeout=60)
        self.assertEqual(first.returncode, 0, error)
        self.fly(mission, "--in-process", "--force")  # the lock has gone with its process


class Resume(system.SystemTest):
    CAMPAIGN = ("schema: omniflight.campaign/1\nname: {name}\nsensors: laboratory\nmissions: [{mission}]\nseeds: [1, 2, 3]\n"
                "variants:\n  - {{name: {variant}}}\n{extra}")

    def campaign(self, name="three", variant="pid", extra=""):
        return self.write("three.yaml", self.CAMPAIGN.format(name=name, mission=self.short_mission(), variant=variant,
                                                             extra=extra))

    def test_resume_looks_at_the_recordings(self):
        self.run_command("campaign", self.campaign(), "--out", "campaign", "--quiet")
        again = self.run_command("campaign", "three.yaml", "--out", "campaign", expect=4)
        self.assertIn("--resume", again.stderr)
        folders = sorted((self.dir / "campaign").glob("short-*"))
        self.assertEqual(len(folders), 3)
        whole = (folders[0] / "flight.mcap").read_bytes()
        messages = flown(folders[0] / "flight.mcap")
        (folders[0] / "flight.mcap").write_bytes(whole[:len(whole) // 2])  # no footer
        (folders[1] / "flight.mcap").unlink()
        shutil.copy(folders[2] / "flight.mcap", folders[1] / "flight.mcap")  # another flight's
        self.run_command("campaign", "three.yaml", "--out", "campaign", "--resume", "--quiet")
        result = self.json("campaign/campaign.json")
        self.assertEqual(result["kept"], 1)
        self.assertEqual([f["verdict"] for f in result["flights"]], ["flown"] * 3)
        self.assertEqual(flown(folders[0] / "flight.mcap"), messages, "lockstep repeats to the bit")
        self.assertNotEqual(flown(folders[1] / "flight.mcap"), flown(folders[2] / "flight.mcap"))

    def test_names_and_parameters_stay_in_the_folder(self):
        secret = self.write("secret.txt", "not for a recording")
        for campaign, words in (
                (dict(variant="../../escaped"), ("../../escaped", "plain")),
                (dict(name="../up"), ("../up", "plain")),
                (dict(extra=f"parameters: {{recorder.file: {self.dir}/elsewhere.mcap}}\n"), ("recorder.file",)),
                (dict(extra=f"parameters: {{recorder.attachments: {secret}}}\n"), ("recorder.attachments",)),
                (dict(extra='parameters: {controller.kp: "[1, 1, 1]\\nrecorder:\\n  ros__parameters: {overwrite: true}"}\n'),
                 ("controller.kp", "several lines"))):
            done = self.run_command("campaign", self.campaign(**campaign), "--out", "a/b/campaign", expect=4)
            for word in words:
                self.assertIn(word, done.stderr)
            self.assertEqual(sorted(p.name for p in self.dir.iterdir()), ["secret.txt", "short.yaml", "three.yaml"])

    def test_none_of_one_flown_is_no_success(self):
        # a pull that no rotor can hold
        self.write("pull.yaml", "schema: omniflight.model/1\neffects:\n  - id: constant_pull\n"
                                "    parameters: {x: 10.0, y: 10.0, z: 0}\n")
        file = self.write("one.yaml", f"schema: omniflight.campaign/1\nname: one\nmissions: [{self.short_mission()}]\n"
                                      f"effects: [{self.dir}/pull.yaml]\nseeds: [1]\n")
        done = self.run_command("campaign", file, "--out", "campaign", expect=2)
        self.assertIn("0 of 1 flights flown", done.stdout)


class OneTimeBase(system.SystemTest):
    def test_simulated_and_wall_times_do_not_mix(self):
        flight = self.fly(self.short_mission(), "--sensors", "laboratory", "--monitor")
        for topic, (first, last) in times(self.dir / "flight/flight.mcap").items():
            self.assertGreaterEqual(first, 0, topic)
            self.assertLess(last, flight["simulated_s"] + 1, topic)

    def test_of_a_flight_through_boards_too(self):
        self.fly(self.short_mission(), "--plant", "emulator", timeout=80)
        all_times = times(self.dir / "flight/flight.mcap")
        first, last = all_times["/omniflight/tick"]
        for topic, (a, b) in all_times.items():
            self.assertLess(abs(a - first), 60, topic)
            self.assertLess(abs(b - last), 60, topic)


class Export(system.SystemTest):
    def test_every_topic_and_message_is_kept_and_info_reads_it(self):
        self.fly(self.short_mission(), "--in-process", "--sensors", "laboratory", "--monitor")
        original = digest(self.dir / "flight/flight.mcap")
        self.assertIn("/omniflight/tick", original)
        self.run_command("export", "flight/flight.mcap", "--to", "mcap", "--out", "copy.mcap")
        self.assertEqual(digest(self.dir / "copy.mcap"), original)
        self.run_command("export", "flight/flight.mcap", "--to", "rosbag2", "--out", "bag")
        self.assertEqual(digest(self.dir / "bag/bag_0.mcap"), original)
        told = system.json.loads(self.run_command("info", "flight/flight.mcap", "--json").stdout)
        for exported in ("copy.mcap", "bag"):
            info = system.json.loads(self.run_command("info", exported, "--json").stdout)
            self.assertEqual(info["signals"], told["signals"], exported)
            for key in ("omniflight.mission", "omniflight.inputs_sha256", "attachment.certificate.json"):
                self.assertEqual(info["metadata"][key], told["metadata"][key], exported)
        self.run_command("export", "bag", "--to", "csv", "--out", "bag.csv")
        self.run_command("info", "bag.csv")


if __name__ == "__main__":
    unittest.main()
