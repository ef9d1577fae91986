"""Completion, manual pages and version: the command's own words, tried in the shells that are there."""

import os
import re
import shutil
import subprocess
import unittest

import system


class Words(system.SystemTest):
    def shell(self, program, script, timeout=30):
        if not shutil.which(program):
            self.skipTest(f"no {program}: apt-get install {program}")
        env = dict(os.environ, PATH=os.path.dirname(system.COMMAND) + ":" + os.environ["PATH"], HOME=str(self.dir))
        done = subprocess.run([program, script] if script.endswith(".sh") else [program, "-c", script], cwd=self.dir,
                              text=True, capture_output=True, timeout=timeout, env=env)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return done.stdout.split()

    def complete_in_bash(self, *words):
        """What bash offers for the last word."""
        self.write("words.bash", self.run_command("completion", "bash").stdout)
        return self.shell("bash", f"source ./words.bash; COMP_WORDS=({' '.join(words)} {'' if words[-1] else chr(39) * 2}); "
                                  f"COMP_CWORD={len(words) - 1}; _omniflight; printf '%s\\n' \"${{COMPREPLY[@]}}\"")

    def test_bash_completes_verbs_options_and_names(self):
        self.assertEqual(self.complete_in_bash("omniflight", "diag"), ["diagnose"])
        self.assertIn("--held-out", self.complete_in_bash("omniflight", "diagnose", "--h"))
        self.assertEqual(self.complete_in_bash("omniflight", "fly", "--vehicle", "omnim"), ["omnimorph"])
        self.assertEqual(self.complete_in_bash("omniflight", "effects", "hung_c"), ["hung_cable"])
        self.assertEqual(self.complete_in_bash("omniflight", "plan", "trajectory_"), ["trajectory_1", "trajectory_2"])

    def test_fish_completes_the_same(self):
        self.write("words.fish", self.run_command("completion", "fish").stdout)
        self.assertIn("diagnose", self.shell("fish", "source words.fish; complete -C 'omniflight diagn'"))
        self.assertIn("--held-out", self.shell("fish", "source words.fish; complete -C 'omniflight diagnose --held'"))

    def test_zsh_reads_its_script(self):
        self.write("_omniflight", self.run_command("completion", "zsh").stdout)
        self.shell("zsh", "autoload -Uz compinit; compinit -u -D; source ./_omniflight; whence -w _omniflight > /dev/null")

    def test_every_verb_has_a_page_without_complaints(self):
        self.run_command("man", "--out", "pages")
        verbs = re.findall(r"^  ([a-z-]+) ", self.run_command("--help").stdout.split("Subcommands:")[1], re.M)
        self.assertGreater(len(verbs), 20)
        for verb in verbs:
            text = (self.dir / f"pages/omniflight-{verb}.1").read_text()
            self.assertIn(".SH EXAMPLE", text)
            self.assertIn("\\-\\-json", text)
        if shutil.which("groff"):
            for page in sorted((self.dir / "pages").glob("*.1")):
                done = subprocess.run(["groff", "-man", "-ww", "-Tutf8", "-z", str(page)], text=True, capture_output=True, timeout=30)
                self.assertEqual((done.returncode, done.stderr), (0, ""), page.name)

    def test_the_version_names_its_source(self):
        said = self.run_command("--version").stdout
        self.assertRegex(said, r"^omniflight \d+\.\d+\.\d+ \((revision unknown|[0-9a-f]{10,40}(, modified)?)\)\n$")


if __name__ == "__main__":
    unittest.main()
