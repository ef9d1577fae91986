"""What a diagnosis may say: checked is no answer, stopped is unfinished, and the page begins in a pilot's words."""

import html
import os
import re
import shutil
import signal
import subprocess
import time
import unittest

import system

PROMISED_S = 1.0  # from Ctrl-C to the end of the process


# Measures a page in a frame that is as wide as a telephone: how wide it wants to be, and how wide it is.
MEASURE = """<script>addEventListener("load", () => setTimeout(() => {
const p = parent.document.createElement("pre"); p.id = "width";
p.textContent = document.documentElement.scrollWidth + " " + innerWidth; parent.document.body.append(p)}, 500))</script></body>"""


class Answers(system.SystemTest):
    def setUp(self):
        super().setUp()
        self.fly(self.short_mission(), "--in-process", "--sensors", "laboratory", "--seed", "2", "--effects", "tether", out="t")

    def begin(self, *arguments):
        shutil.rmtree(self.dir / "d", ignore_errors=True)
        return self.start_command("diagnose", "t/flight.mcap", "--vehicle", "omnimorph", "--out", "d", *arguments)

    def check_unfinished(self, text):
        found = self.json("d/diagnosis.json")
        self.assertEqual(found["verdict"], "unfinished", text)
        self.assertTrue(found["summary"].startswith("Not finished"), found["summary"])
        self.assertTrue(found["left_out"], "what is still open is named")
        self.assertIn(found["left_out"][0], found["summary"])
        self.assertEqual({f["probability"] for f in found["findings"]} - {None}, set())
        page = (self.dir / "d/report.html").read_text()
        first = re.search(r'<div class="verdict (\w+)">.*?<h2>(.*?)</h2>', page)
        self.assertEqual(first.group(1), "warn")
        self.assertIn("Not finished", first.group(2))
        for claim in ("The model explains", "Nothing is missing", "Probability of each named effect"):
            self.assertNotIn(claim, page)
        self.assertIn("verdict: unfinished", text)
        self.assertEqual(found["sets"], [])
        return found

    def test_a_check_is_no_answer(self):
        done = self.run_command("diagnose", "t/flight.mcap", "--vehicle", "omnimorph", "--check", "--out", "d")
        self.assertIn("verdict: checked", done.stdout)
        found = self.json("d/diagnosis.json")
        self.assertEqual(found["verdict"], "checked")
        page = (self.dir / "d/report.html").read_text()
        self.assertRegex(page, r'<div class="verdict unknown">.*?<h2>Only looked at: nothing was fitted')
        for text in (done.stdout, found["summary"], page):
            for claim in ("nothing_missing", "Nothing is missing", "The model explains", "\u2713"):
                self.assertNotIn(claim, text)

    def ends_in_time(self, begin, after, what, check, limit):
        """Ctrl-C so long [s] after each start of listening, or when a file is there; a busy machine may be late twice, what does not listen
        is so every time."""
        took = []
        for _ in range(3):
            process = begin()
            system.wait_until("it to listen", lambda: system.listens(process.pid) or process.poll() is not None, 60)
            if isinstance(after, float):
                time.sleep(after)
            else:
                system.wait_until(after.name, lambda: after.exists() or process.poll() is not None, 200)
            self.assertIsNone(process.poll(), "it ended before it could be stopped")
            stopped = time.monotonic()
            process.send_signal(signal.SIGINT)
            text = "".join(process.communicate(timeout=limit))
            took.append(time.monotonic() - stopped)
            self.assertEqual(process.returncode, 2, text)
            check(text)
            if took[-1] < PROMISED_S:
                break
        print(f"\nstopped {what}: ended {took[-1]:.2f} s later", end="")
        self.assertLess(min(took), PROMISED_S)

    def test_control_c_ends_it_within_a_second(self):
        for after in (0.4, 1.5):
            self.ends_in_time(self.begin, after, f"after {after} s", self.check_unfinished, limit=30)

    def test_control_c_ends_it_while_it_reads(self):
        rest = ",0,0,1,1,0,0,0" + ",0,0,9.81,0,0,0" + ",1000" * 8 + "\n"
        header = ("t_s,px_m,py_m,pz_m,qw,qx,qy,qz,acc_x_mps2,acc_y_mps2,acc_z_mps2,gyro_x_radps,gyro_y_radps,gyro_z_radps,"
                  + ",".join(f"rotor{k}_radps" for k in range(1, 9)) + "\n")
        with (self.dir / "long.csv").open("w") as file:
            file.write(header)
            file.writelines(f"{k * 1e-3:.3f}{rest}" for k in range(1_000_000))

        def check(text):
            found = self.json("r/diagnosis.json")
            self.assertEqual(found["verdict"], "unfinished", text)
            self.assertEqual([os.path.basename(x["file"]) for x in found["inputs"]], ["long.csv"])

        self.ends_in_time(lambda: self.start_command("diagnose", "long.csv", "--vehicle", "omnimorph", "--out", "r"), 0.5,
                          "while it read", check, limit=60)

    def test_control_c_after_the_search_keeps_what_was_found(self):
        """While a flight is proposed, while the reference is flown again, and while the mission is."""
        model, proposal = self.dir / "d/model.yaml", self.dir / "d/next_flight.yaml"
        for what, file, only, wanted, arguments in (
                ("while it proposed a flight", proposal, "payload_mass,thrust_scale", "a proposed flight", ()),
                ("while it flew the reference again", model, "payload_mass", "the recorded flight again", ("--refly-recorded",)),
                ("while it flew the mission again", self.dir / "d/nominal/flight.mcap", "payload_mass", "the flight again in the simulator",
                 ("--refly", "trajectory_2"))):
            def check(text):
                found = self.json("d/diagnosis.json")
                self.assertNotIn(found["verdict"], ("unfinished", "checked"), text)
                self.assertTrue(any(x.startswith(wanted) and "stopped" in x for x in found["left_out"]), found["left_out"])
                self.assertEqual(proposal.exists(), bool(found["next_flight"]["mission"]))
                self.assertIn("Left out", (self.dir / "d/report.html").read_text())

            self.ends_in_time(lambda: self.begin("--only", only, *arguments), file, what, check, limit=60)

    def test_one_folder_takes_one_diagnosis(self):
        first = self.begin()
        system.wait_until("its folder", lambda: (self.dir / "d/.lock").exists() or first.poll() is not None, 60)
        second = self.run_command("diagnose", "t/flight.mcap", "--vehicle", "omnimorph", "--out", "d", expect=4)
        self.assertIn(f"in use by another run (process {first.pid})", second.stderr)
        first.send_signal(signal.SIGINT)
        self.check_unfinished("".join(first.communicate(timeout=30)))

    def test_what_was_found_is_kept_when_it_cannot_be_flown_again(self):
        text = self.ask("--only", "payload_mass", "--refly", "trajectory_2", "--plan", "nowhere", expect=4)
        self.assertIn("nowhere", text)
        found = self.json("d/diagnosis.json")
        self.assertNotEqual(found["verdict"], "unfinished")
        self.assertIn("the flight again in the simulator", " ".join(found["left_out"]))

    def test_out_of_time_is_unfinished(self):
        done = self.run_command("diagnose", "t/flight.mcap", "--vehicle", "omnimorph", "--budget-s", "1", "--out", "d", expect=2)
        found = self.check_unfinished(done.stdout)
        self.assertLess(found["runtime_s"], 3)

    def ask(self, *arguments, expect=0):
        done = self.run_command("diagnose", "t/flight.mcap", "--vehicle", "omnimorph", "--out", "d", *arguments, expect=expect,
                                timeout=180)
        return done.stdout + done.stderr

    def test_only_and_exclude_bound_the_search_and_why_tells_what_became_of_an_effect(self):
        text = self.ask("--only", "payload_mass,hung_cable", "--exclude", "wind", "--why", "hung_cable",
                        expect=None)
        found = self.json("d/diagnosis.json")
        wrench = {f["effect"] for f in found["findings"] if f["stage"] == "wrench"}
        self.assertTrue(wrench and wrench <= {"payload_mass", "hung_cable"}, wrench)
        asked = {x["about"] for x in found["decisions"] if x["asked"] == "evidence alone against nothing"}
        self.assertEqual({a for a in asked if not a.startswith("unknown")}, {"payload_mass", "hung_cable"})
        self.assertAlmostEqual(sum(x["probability"] for x in found["sets"]), 1, places=3)
        self.assertIn([], [x["effects"] for x in found["sets"]])  # nothing at all is one
        self.assertTrue({e for x in found["sets"] for e in x["effects"] if not e.startswith("unknown")} <= {"payload_mass", "hung_cable"})
        self.assertIn(found["estimator"]["name"], ("direct", "instrumental"))
        self.assertRegex(text, r"why hung_cable:\n +evidence alone against nothing: [-+.e\d]+ against [-+.e\d]+ .*(kept|refused)")
        text = self.ask("--only", "payload_mass", "--why", "rotor_drag", expect=None)
        self.assertIn("not among the effects that the caller asks for", text)
        text = self.ask("--check", "--why", "neighbour_downwash")
        self.assertIn("why neighbour_downwash:", text)

    def test_questions_that_have_no_answer_are_refused(self):
        self.assertIn("Did you mean 'payload_mass'?", self.ask("--only", "payload_mas", expect=4))
        self.assertIn("Did you mean 'rotor_drag'?", self.ask("--why", "rotor_drug", expect=4))
        self.assertIn("asked for and excluded", self.ask("--only", "wind", "--exclude", "wind", expect=4))
        prior = str(self.write("prior.json", '{"schema": "omniflight.diagnosis/1", "findings": [{"effect": "wind"}]}'))
        self.assertIn("--engine", self.ask("--engine", "posterior", expect=4))
        self.assertIn("field 'probability' of finding 'wind'", self.ask("--prior", prior, expect=4))
        self.assertIn("omniflight.diagnosis/1", self.ask("--prior", "t/flight.json", expect=4))

    def test_long_pages_fit_a_telephone(self):
        if not shutil.which("chromium"):
            self.skipTest("chromium is not installed")
        self.run_command("diagnose", "t/flight.mcap", "--vehicle", "omnimorph", "--budget-s", "12", "--out", "d", expect=None)
        self.run_command("compare", "t/flight.mcap", "t/flight.mcap", "--vehicle", "omnimorph", "--out", "c")
        for page in ("d/report.html", "c/report.html"):
            text = (self.dir / page).read_text().replace("</body>", MEASURE)
            frame = self.write("frame.html", '<!doctype html><body><iframe style="width:390px;height:3000px;border:0" srcdoc="'
                               + html.escape(text) + '"></iframe></body>')
            done = subprocess.run(["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--window-size=600,844",
                                   "--virtual-time-budget=8000", "--dump-dom", frame.as_uri()], capture_output=True, text=True,
                                  timeout=120)
            wants, has = map(int, re.search(r'<pre id="width">(\d+) (\d+)</pre>', done.stdout).groups())
            self.assertEqual(has, 390)
            self.assertLessEqual(wants, has, page)


if __name__ == "__main__":
    unittest.main()
