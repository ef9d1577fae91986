"""Pages in a real browser: on a phone, on paper, in the dark, by keyboard, with contrast; and what each says first."""

import time
import unittest

import system
from browser import Browser, pages_on_paper


class ReportsInBrowser(system.SystemTest):
    def readable(self, browser, path):
        """Opens a page: 390 px without sideways scrolling, contrast in both colour schemes, paper, first key, no errors."""
        browser.size(390, 844, phone=True)
        browser.media("light")
        browser.go((self.dir / path).as_uri())
        browser.wait_for("document.readyState === 'complete' && !!document.querySelector('main')")
        browser.value("document.querySelectorAll('details').forEach(d => d.open = true)")
        browser.value("for (const e of ['beforeprint', 'afterprint']) dispatchEvent(new Event(e))")  # makes plots that are far away, too
        time.sleep(0.3)  # plots are drawn when they have a width
        self.assertEqual(browser.wider_than_the_screen(), [], path)
        self.assertEqual(browser.torn_words(), [], path)
        for scheme in ("light", "dark"):
            browser.media(scheme)
            self.assertEqual(browser.faint_texts(), [], f"{path}, {scheme}")
        browser.size(1280, 800)
        browser.media("light")
        self.assertEqual(browser.wider_than_the_screen(), [], path)
        browser.size(720, 1000)
        browser.media("light", "print")
        self.assertEqual(browser.wider_than_the_screen(), [], path + ", on paper")
        browser.media("light")
        browser.press("Tab", 9)
        self.assertNotEqual(browser.value("getComputedStyle(document.activeElement).outlineStyle"), "none", path)
        self.assertEqual(browser.errors, [], path)

    def test_design_shows_hulls(self):
        self.run_command("design", "omnimorph", "--alpha", 0, "--alpha", 30, "--alpha", 54.7356, "--hover-power", "--out", "design",
                         "--quiet", timeout=120)
        browser = Browser(self)
        self.readable(browser, "design/report.html")
        self.assertGreater(pages_on_paper(self.dir / "design/report.html"), 0)
        self.assertEqual(browser.value("document.querySelectorAll('.outlines polygon').length"), 12, "3 tilts, 2 views, forces and torques")

    def test_a_plan_says_how_near_it_comes(self):
        self.run_command("plan", self.short_mission(), "--out", "plan", "--quiet")
        browser = Browser(self)
        self.readable(browser, "plan/report.html")
        told = self.json("plan/certificate.json")
        said = browser.value("document.querySelector('.verdict').innerText")
        self.assertIn(f"never nearer than {told['clearance']['min_m']:.2f} m", said)
        self.assertIn(f"{told['clearance']['asked_m']:.2f} m were asked", said)
        self.assertEqual(browser.value("document.querySelectorAll('figure.plot').length"), 4)
        browser.size(1280, 800)
        table = "document.querySelector('figure.table.wide')"
        self.assertEqual(browser.value(f"{table}.classList.contains('blocks')"), False, "four columns fit")
        browser.value(f"{table}.querySelectorAll('tr').forEach(r => r.append(...[1, 2, 3, 4, 5].flatMap(() => [...r.cells].map(c => c.cloneNode(true)))))")
        browser.size(1270, 800)
        browser.wait_for(f"{table}.classList.contains('blocks')", 20)
        self.assertEqual(browser.wider_than_the_screen(), [], "as many columns as do not fit are blocks")

    def test_a_plan_is_shown_in_space(self):
        self.run_command("plan", self.short_mission(), "--out", "plan", "--quiet")
        browser = Browser(self)
        self.readable(browser, "plan/report.html")
        space = "document.querySelector('figure.space')"
        browser.value(f"{space}.scrollIntoView()")
        browser.wait_for(f"{space}.dataset.drawn !== undefined", 20)
        data = f"JSON.parse({space}.querySelector('script').textContent)"
        self.assertGreater(browser.value(f"{data}.solids.length"), 5, "the map")
        self.assertEqual(browser.value(f"{data}.discs.length % 8"), 0, "eight rotors a place")
        painted = "[...c.getContext('2d').getImageData(0, 0, c.width, c.height).data].some(x => x > 0)"
        self.assertTrue(browser.value(f"(c => {painted})({space}.querySelector('canvas'))"))
        turned = browser.value(f"{space}.dataset.drawn")
        browser.value(f"{space}.querySelector('canvas').dispatchEvent(new KeyboardEvent('keydown', {{key: 'ArrowLeft'}}))")
        self.assertNotEqual(browser.value(f"{space}.dataset.drawn"), turned)

    def test_a_diagnosis_begins_with_its_evidence(self):
        self.fly("trajectory_2", "--in-process", "--sensors", "laboratory", "--seed", "2", "--effects", "tether", out="flight")
        self.run_command("diagnose", "flight/flight.mcap", "--vehicle", "omnimorph", "--only", "payload_mass", "hung_cable", "wind",
                         "--out", "diagnosis", "--quiet", timeout=200, expect=None)
        browser = Browser(self)
        self.readable(browser, "diagnosis/report.html")
        sections = browser.value("[...document.querySelectorAll('h2.section')].map(h => h.innerText)")
        self.assertEqual(sections[:2], ["Evidence", "Which physics"])
        self.assertIn("RMS before", browser.value("document.querySelector('.verdict').innerText"))
        held_out = self.json("diagnosis/diagnosis.json")["fit"]["held_out"]
        before, after = (sum(f[k] ** 2 for f in held_out if f["channel"] == "Fz") for k in ("rms_before", "rms_after"))
        self.assertLess(after, before / 4)
        self.assertIn("Yes: Fz:", browser.value("document.querySelector('table').innerText"))
        self.assertIn("<i>\u03bb</i>", browser.value("document.querySelector('main').innerHTML"), "symbols are typeset")

    def test_two_designs_turn_together_in_space(self):
        self.run_command("design", "omnimorph", "omnicopter", "--out", "both", "--quiet", timeout=120)
        browser = Browser(self)
        self.readable(browser, "both/report.html")
        figures = "document.querySelectorAll('figure.surfaces')"
        browser.wait_for(f"{figures}.length === 2 && [...{figures}].every(f => f.dataset.drawn)")
        painted = f"""[...{figures}].flatMap(f => [...f.querySelectorAll('canvas')]).map(c => {{
            const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
            let sum = 0;
            for (let i = 3; i < d.length; i += 4) sum += d[i] > 100;
            return sum / (d.length / 4); }})"""
        for small, large in zip(*[iter(browser.value(painted))] * 2):
            self.assertGreater(small, 0.01, "share of a view that its hull covers: axes alone take less")
            self.assertGreater(large, 4 * small, "the omnicopter's hulls are four times as wide, in one scale")
        picture = f"[...{figures}[0].querySelectorAll('canvas')].map(c => c.toDataURL())"
        before, other = browser.value(picture), browser.value(f"{figures}[1].dataset.drawn")
        browser.value(f"{figures}[0].querySelector('canvas').dispatchEvent(new KeyboardEvent('keydown', {{key: 'ArrowLeft'}}))")
        after = browser.value(picture)
        self.assertEqual([a == b for a, b in zip(before, after)], [False, False], "both views of the figure turn")
        self.assertEqual(browser.value(f"{figures}[1].dataset.drawn"), other, "the next figure does not")
        self.assertEqual(browser.errors, [])

    def test_long_the_map_of_survival(self):
        self.run_command("design", "omnimorph", "--survival", "--out", "map", "--quiet", timeout=300)
        browser = Browser(self)
        self.readable(browser, "map/report.html")
        self.assertEqual(browser.value("document.querySelectorAll('figure.matrix').length"), 7)
        self.assertIn("look-ahead survive", browser.value("document.querySelector('main').innerText.slice(0, 300)"))

    def test_the_thesis_figure_by_figure(self):
        self.run_command("reproduce", "--fast", "--out", "thesis", "--quiet")
        browser = Browser(self)
        self.readable(browser, "thesis/report.html")
        self.assertGreater(browser.value("document.querySelectorAll('.outlines polygon').length"), 100, "rotors and hulls are drawn")
        self.assertIn("contradicted", browser.value("document.querySelector('main').innerText.slice(0, 600)"), "the conclusion comes first")

    def test_the_gallery_is_filtered_by_words(self):
        self.run_command("effects", "--gallery", "--mission", self.short_mission(), "--only", "constant_pull", "accelerometer_error",
                         "--out", "gallery", "--quiet", timeout=80)
        browser = Browser(self)
        self.readable(browser, "gallery/gallery.html")
        seen = "[...document.querySelectorAll('h2.section')].filter(h => h.getClientRects().length).map(h => h.innerText).join(' ').toLowerCase()"
        jumps = "[...document.querySelectorAll('.toc li')].filter(l => !l.hidden).length"
        both, entries = browser.value(seen), browser.value(jumps)
        self.assertIn("pull", both)
        self.assertIn("accelerometer", both)
        browser.press("/", 191, "/")
        self.assertEqual(browser.value("document.activeElement.closest('.filter') !== null"), True, "a slash goes to the filter")
        browser.call("Input.insertText", text="Accelerometer")
        self.assertNotIn("pull", browser.value(seen))
        self.assertIn("accelerometer", browser.value(seen))
        shown, of = browser.value("document.querySelector('.filter output').textContent").split(" of ")
        self.assertLess(int(shown), int(of), "what does not fit is not counted")
        self.assertLess(browser.value(jumps), entries, "the jump list follows")
        folded = "document.querySelector('details:not([open]) figure.plot').closest('details')"
        self.assertEqual(browser.value("document.querySelectorAll('canvas').length > 0"), True, "readable() unfolds: these plots are drawn")
        browser.go((self.dir / "gallery/gallery.html").as_uri())
        browser.wait_for("document.readyState === 'complete' && !!document.querySelector('details')")
        self.assertEqual(browser.value("document.querySelectorAll('figure.plot canvas').length"), 0, "plots that are folded are not made")
        browser.value(f"{folded}.scrollIntoView(), {folded}.open = true")
        browser.wait_for("!!document.querySelector('details[open] figure.plot canvas')", 20)
        browser.press("/", 191, "/")
        browser.call("Input.insertText", text="accelerometer zzz")
        self.assertEqual(browser.value(seen), "", "no section has both words")
        self.assertEqual(browser.errors, [])

    def test_long_flights_side_by_side_and_a_campaign(self):
        mission = self.short_mission()
        self.fly(mission, "--in-process", "--seed", "1", out="first")
        self.fly(mission, "--in-process", "--seed", "2", "--effects", system.CONFIGS / "effects/light_load.yaml", out="second")
        self.run_command("compare", "first/flight.mcap", "second/flight.mcap", "--vehicle", "omnimorph", "--out", "compare", "--quiet")
        self.write("campaign.yaml", "schema: omniflight.campaign/1\nname: two\nmissions: [short.yaml]\neffects: [none]\nseeds: [1, 2]\n")
        self.run_command("campaign", "campaign.yaml", "--out", "many", "--quiet", timeout=200)
        browser = Browser(self)
        for page in ("first/report.html", "compare/report.html", "many/report.html"):
            self.readable(browser, page)


if __name__ == "__main__":
    unittest.main()
