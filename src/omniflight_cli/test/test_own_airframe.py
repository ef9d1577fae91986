"""The tutorial docs/tutorials/own_airframe.md, followed word by word."""

import re
import shlex
import unittest

import system


class OwnAirframe(system.SystemTest):
    def test_the_tutorial_works_as_it_is_written(self):
        page = (system.ROOT / "docs/tutorials/own_airframe.md").read_text()
        commands = [line for block in re.findall(r"```bash\n(.*?)```", page, re.S) for line in block.splitlines() if line]
        self.assertGreaterEqual(len(commands), 9)
        for line in commands:
            words = shlex.split(line, comments=True)
            self.assertEqual(words.pop(0), "omniflight", line)
            expect = int(found.group(1)) if (found := re.search(r"# exit code (\d)", line)) else 0
            done = self.run_command(*words, *(("--in-process",) if words[0] == "fly" else ()), expect=expect, timeout=200)
            if words[0] == "vehicles":
                self.assertIn("underactuated (thrust along 0.00 0.00 1.00)", done.stdout)
            if expect == 4:
                self.assertIn("reachable with attitude", done.stderr)
        for out in ("flight", "cascaded", "incremental", "softer"):
            self.assertEqual(self.json(f"{out}/flight.json")["verdict"], "flown", out)


if __name__ == "__main__":
    unittest.main()
