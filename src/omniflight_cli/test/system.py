"""What the system tests share: running the command in a folder of its own, missions, processes."""

import json
import os
import pathlib
import signal
import subprocess
import tempfile
import time
import unittest

COMMAND = os.environ["OMNIFLIGHT_COMMAND"]
PROGRAMS = pathlib.Path(os.environ["OMNIFLIGHT_PROGRAMS"])
ROOT = pathlib.Path(os.environ["OMNIFLIGHT_SOURCE_ROOT"])
CONFIGS = ROOT / "configs"

# 0.1 m aside and up: about two seconds of motion after four seconds of hover.
SHORT = """schema: omniflight.mission/1
name: short
vehicle: omnimorph
test_bed: pyramid
alpha_deg: 30
clearance_m: 0.08
seed: 1
budget_ms: 5000
limits: {speed_mps: 0.3, acceleration_mps2: 0.4, rate_dps: 30, angular_acceleration_dps2: 90, rotor_headroom: 0.1}
start: {position: [0, 0, 1.3], attitude: {rpy_deg: [0, 0, 0]}, hold_s: 0.5}
waypoints:
  - {name: aside and up, by: [0.1, 0, 0.1], hold_s: 0.5}
"""


def wait_until(what, condition, timeout):
    """The first true value of condition(); a failure that names `what` after timeout [s]."""
    deadline = time.monotonic() + timeout
    while time.monotonic() < deadline:
        value = condition()
        if value:
            return value
        time.sleep(0.01)
    raise AssertionError(f"waited {timeout} s for {what}")


def children_of(pid):
    """Process ids of the direct children of a process."""
    found = []
    for task in pathlib.Path(f"/proc/{pid}/task").glob("*"):
        try:
            found += map(int, (task / "children").read_text().split())
        except OSError:
            pass
    return found


def children(pid):
    """{name: pid} of the direct children of a process."""
    found = {}
    for child in children_of(pid):
        try:
            found[os.path.basename(os.readlink(f"/proc/{child}/exe"))] = child
        except OSError:
            pass
    return found


def alive(pid):
    try:
        state = pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except OSError:
        return False
    return state != "Z"


def listens(pid):
    """Whether a process has begun to catch Ctrl-C; one that has not yet begun is killed by it."""
    try:
        status = pathlib.Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return False
    caught = int(status.split("SigCgt:")[1].split()[0], 16)
    return bool(caught >> (signal.SIGINT - 1) & 1)


class SystemTest(unittest.TestCase):
    """A temporary folder `self.dir` and ways to run the command in it."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="omniflight_system_")
        self.addCleanup(folder.cleanup)
        self.dir = pathlib.Path(folder.name)

    def small_disk(self, megabytes):
        """A file system of that size, self.dir/disk, until the test ends; the test is skipped where it cannot be mounted."""
        disk = self.dir / "disk"
        disk.mkdir()
        if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={megabytes}m", "tmpfs", str(disk)],
                                               capture_output=True).returncode != 0:
            self.skipTest("mounting a small tmpfs needs root")
        self.addCleanup(subprocess.run, ["umount", str(disk)], check=True)
        return disk

    def run_command(self, *arguments, timeout=60, expect=0, **options):
        """Runs `omniflight ARGUMENTS`; the completed process. Fails when the exit code is not `expect`."""
        done = subprocess.run([COMMAND, *map(str, arguments)], cwd=self.dir, text=True, capture_output=True,
                              timeout=timeout, **options)
        if expect is not None:
            self.assertEqual(done.returncode, expect, f"omniflight {arguments}\n{done.stdout}\n{done.stderr}")
        return done

    def start_command(self, *arguments, **options):
        """Starts it; it is killed with its children at the end of the test when it still runs."""
        process = subprocess.Popen([COMMAND, *map(str, arguments)], cwd=self.dir, text=True, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, **options)

        def end():
            left = list(children(process.pid).values())
            if process.poll() is None:
                process.kill()
            for pid in left:
                try:
                    os.kill(pid, signal.SIGKILL)
                except ProcessLookupError:
                    pass
            process.communicate()

        self.addCleanup(end)
        return process

    def write(self, name, text):
        path = self.dir / name
        path.write_text(text)
        return path

    def short_mission(self, name="short.yaml", **replace):
        """SHORT in a file, with replace={old: new} applied."""
        text = SHORT
        for old, new in replace.get("changes", {}).items():
            self.assertIn(old, text)
            text = text.replace(old, new)
        return self.write(name, text)

    def hovering_mission(self, hold_s=60):
        """The short mission, which then hovers for hold_s: a test may end the flight however slow the machine is."""
        moved = "by: [0.1, 0, 0.1], hold_s: "
        return self.short_mission(changes={moved + "0.5": moved + str(hold_s)})

    def json(self, path):
        return json.loads((self.dir / path).read_text())

    def fly(self, mission, *arguments, out="flight", **options):
        """Flies to the end and returns flight.json."""
        self.run_command("fly", mission, "--out", out, "--quiet", *arguments, **options)
        return self.json(f"{out}/flight.json")
