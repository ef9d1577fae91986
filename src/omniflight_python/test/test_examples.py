"""Every example runs and says what it is about. Run by CTest with PYTHONPATH at the built package."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

EXAMPLES = pathlib.Path(__file__).parent.parent / "examples"


class Examples(unittest.TestCase):
    def run_example(self, name):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, "-B", str(EXAMPLES / name)], cwd=folder, text=True,
                                  capture_output=True, timeout=200)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout

    def test_t01(self):
        out = self.run_example("t01_recording_as_arrays.py")
        self.assertIn("median speed", out)
        self.assertRegex(out, r"position +m +\d{3,} samples")

    def test_t02(self):
        out = self.run_example("t02_wrench_sets.py")
        self.assertIn("tilt 60 deg: rank 6", out)
        self.assertNotIn("None", out)

    def test_t03(self):
        self.assertIn("mean power", self.run_example("t03_plan_and_fly.py"))

    def test_t04(self):
        self.assertRegex(self.run_example("t04_diagnose.py"), r"payload_mass: mass = 0\.1[345]\d+ .* kg")

    def test_t05(self):
        self.assertRegex(self.run_example("t05_own_loop.py"), r"20 g more: rests at 0\.98\d+ m")

    def test_none_is_left_out(self):
        here = pathlib.Path(__file__).read_text()
        for example in EXAMPLES.glob("*.py"):
            self.assertIn(f'"{example.name}"', here)


if __name__ == "__main__":
    unittest.main()
