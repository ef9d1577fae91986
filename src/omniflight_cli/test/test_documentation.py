"""The documentation held against the command: links, headings, verbs, options and names at once; pages run as they stand."""

import os
import re
import subprocess
import unittest

import documentation
import system
from test_foreign_logs import ulog
from test_motor_verbs import motor_log

LINK = re.compile(r"\]\(([^)\s#]*)(#[^)\s]*)?\)")
MENTION = re.compile(r"(?<![\w./-])docs/[\w/]+\.(?:md|png|sh|py|yml)")


class Pages(system.SystemTest):
    def test_links_and_anchors_lead_somewhere(self):
        faults = []
        for page in documentation.pages():
            text = documentation.BLOCK.sub("", page.read_text())
            for target, anchor in LINK.findall(text):
                path = (page.parent / target).resolve() if target else page
                if re.match(r"[a-z]+:", target) or "auto&" in target:
                    continue
                if not path.exists():
                    faults.append(f"{page.relative_to(system.ROOT)}: no {target}")
                elif anchor and path.suffix == ".md" and anchor[1:] not in documentation.anchors(path.read_text()):
                    faults.append(f"{page.relative_to(system.ROOT)}: no heading {anchor} in {target or 'itself'}")
        self.assertEqual(faults, [])

    def test_pages_that_sources_name_exist(self):
        listed = []
        for folder, suffixes in (("src", (".hpp", ".cpp", ".py", ".md")), ("tests", (".py",)), ("launch_scripts", (".sh", ".py"))):
            for file in sorted((system.ROOT / folder).rglob("*")):
                if file.suffix in suffixes:
                    listed += MENTION.findall(file.read_text())
        self.assertGreater(len(listed), 20)
        self.assertEqual([name for name in sorted(set(listed)) if not (system.ROOT / name).exists()], [])

    def test_every_page_is_reached_from_the_index(self):
        docs = (system.ROOT / "docs").resolve()
        seen, todo = set(), [docs / "index.md"]
        while todo:
            page = todo.pop()
            if page in seen or page.suffix != ".md" or not page.is_file():
                continue
            seen.add(page)
            todo += [(page.parent / target).resolve() for target, _ in LINK.findall(page.read_text()) if target]
        pages = [page.resolve() for page in documentation.pages()]
        self.assertEqual([str(p) for p in pages if p.is_relative_to(docs) and p not in seen], [])

    def test_commands_have_verbs_options_and_names_that_exist(self):
        checker = documentation.Checker(lambda *words: self.run_command(*words).stdout)
        faults, count = [], 0
        for page in filter(documentation.commands_hold_in, documentation.pages()):
            for words, line in documentation.calls_of(page.read_text()):
                count += 1
                faults += [f"{page.relative_to(system.ROOT)}: {fault}: {line}" for fault in checker.faults(words)]
        self.assertEqual(faults, [])
        self.assertGreater(count, 120)

    def test_the_checker_finds_what_is_wrong(self):
        checker = documentation.Checker(lambda *words: self.run_command(*words).stdout)
        for call, fault in (("flly trajectory_1", "no verb 'flly'"), ("fly trajectory_9", "'trajectory_9' is none of the missions"),
                            ("fly trajectory_1 --plnt emulator", "fly has no option --plnt"),
                            ("fly trajectory_1 --plant simulated", "--plant takes simulator, mujoco, emulator, hardware, not 'simulated'"),
                            ("diagnose a.bin --vehicle omnimorf", "'omnimorf' is none of the vehicles"),
                            ("effects hung_cabel", "'hung_cabel' is none of the effects")):
            self.assertEqual(checker.faults(call.split()), [fault])
        self.assertEqual(list(documentation.calls_of("```bash\nomniflight a --b  # c\n```\n`omniflight d` `e`")),
                         [(["a", "--b"], "omniflight a --b  # c"), (["d"], "omniflight d")])

    def test_scripts_that_pages_call_exist(self):
        for page in filter(documentation.commands_hold_in, documentation.pages()):
            for script in re.findall(r"(?<![\w/])(?:\./)?(launch_scripts/\w+\.(?:sh|py))", page.read_text()):
                self.assertTrue(os.access(system.ROOT / script, os.R_OK), f"{page}: {script}")

    def test_every_page_with_commands_is_run(self):
        run = {name.split("page_")[1] for name in dir(RunPages) if name.startswith("test_long_page_")}
        with_commands = {page.stem for page in documentation.pages()
                         if page.parent.name in ("tutorials", "how_to", "reference") and list(documentation.lines_of(page.read_text()))}
        self.assertEqual(with_commands - {"own_airframe"}, run, "own_airframe has test_own_airframe.py")


class RunPages(system.SystemTest):
    """Every ```bash line of a page, in order, in one folder; `# exit code N` says what it ends with."""

    def setUp(self):
        super().setUp()
        (self.dir / "configs").symlink_to(system.CONFIGS)

    def run_page(self, name, timeout=900):
        """A script of launch_scripts/ is not run here: test_launch_scripts.py and the CI do."""
        env = dict(os.environ, PATH=f"{os.path.dirname(system.COMMAND)}:{os.environ['PATH']}", OMNIFLIGHT_PROGRAMS=str(system.PROGRAMS))
        ran = 0
        for line in documentation.lines_of((system.ROOT / "docs" / name).read_text()):
            if line.startswith("./launch_scripts/"):
                continue
            expect = int(found.group(1)) if (found := re.search(r"# exit code (\d)", line)) else 0
            done = subprocess.run(["bash", "-c", line], cwd=self.dir, env=env, text=True, capture_output=True, timeout=timeout)
            self.assertEqual(done.returncode, expect, f"{line}\n{done.stdout}\n{done.stderr}")
            ran += 1
        self.assertGreater(ran, 0)

    def hover_flights(self, vehicle, **files):
        """CSV logs of a vehicle that moves sideways: {name: (seed, model file or None)}; synthetic."""
        self.run_command("plan", "sideways", "--vehicle", vehicle, "--out", "setup/plan", "--quiet", timeout=300)
        for name, (seed, model) in files.items():
            self.run_command("fly", "sideways", "--vehicle", vehicle, "--plan", "setup/plan", "--sensors", "laboratory", "--seed", seed,
                             "--in-process", "--out", f"setup/{name}", "--quiet", *(("--effects", model) if model else ()), timeout=300)
            self.run_command("export", f"setup/{name}/flight.mcap", "--to", "csv", "--out", f"{name}.csv", "--quiet")

    def test_long_page_first_flight(self):
        self.run_page("tutorials/first_flight.md")
        self.assertEqual(self.json("nothing/diagnosis.json")["verdict"], "nothing_missing")
        power = {name: {row["channel"]: row["ratio"] for row in self.json(f"{name}/compare.json")["rows"]}["mean power"]
                 for name in ("compared", "mended")}
        self.assertGreater(power["compared"], 1.4)
        self.assertAlmostEqual(power["mended"], 1, delta=0.05)

    def test_long_page_command_line(self):
        self.run_page("reference/command_line.md")

    def test_long_page_install(self):
        self.run_page("how_to/install.md")

    def test_long_page_logs(self):
        (self.dir / "flight.ulg").write_bytes(ulog())
        self.run_page("how_to/logs.md")

    def test_long_page_diagnosing(self):
        self.run_command("new", "vehicle", "my_quad", "--out", "setup", "--quiet")
        model = self.write("load.yaml", "schema: omniflight.model/1\neffects:\n  - {id: payload_mass, parameters: {mass: 0.08}}\n")
        self.hover_flights("setup/configs/vehicles/my_quad/my_quad.yaml", flight=(1, model), other=(2, model), third=(3, model))
        for name, gain in (("motors", (1, 1, 1.2, 1)), ("good1", (1, 1, 1, 1)), ("good2", (1.01, 1, 1, 1)), ("good3", (1, 1, 1, 1.01))):
            self.write(name + ".csv", "t_s,pwm1,pwm2,pwm3,pwm4\n" + "".join(
                f"{k / 100:.2f}," + ",".join(f"{0.5 * g + 0.01 * ((k * (7 + r)) % 5 - 2):.4f}" for r, g in enumerate(gain)) + "\n"
                for k in range(3000)))
        self.run_page("how_to/diagnosing.md")

    def test_long_page_motors(self):
        for name in ("a", "b", "c"):
            motor_log(self.dir / f"{name}.csv", rotors=4)
        self.write("loop.csv", ",".join(["t_s"] + [f"{name}{k}{unit}" for name, unit in (("rotor", "_cmd_radps"), ("rotor", "_radps")) for k in range(1, 5)])
                   + "\n" + "".join(f"{k / 200:.3f}" + f",{600 + 20 * (k // 50 % 2)}" * 4 + f",{600 + 20 * ((k - 5) // 50 % 2)}" * 4 + "\n"
                                    for k in range(2000)))
        self.write("sweep.csv", "rpm,Thrust (g)\n" + "".join(f"{n},{1.2e-5 * n * n / 1000:.3f}\n" for n in range(2000, 9000, 500)))
        self.run_page("how_to/motors.md")

    def test_long_page_reproduce(self):
        self.run_page("how_to/reproduce.md")

    def test_long_page_boards(self):
        self.run_page("how_to/boards.md")

    def test_long_page_campaigns(self):
        self.run_page("how_to/campaigns.md", timeout=3000)


if __name__ == "__main__":
    unittest.main()
