"""`effects`: the list, one in full, the page of documentation, and the gallery."""

import json
import re
import unittest

import system


class Effects(system.SystemTest):
    def effects(self):
        return json.loads(self.run_command("effects", "--json").stdout)

    def test_list_and_single_say_the_same_and_everything(self):
        listed = self.effects()
        self.assertGreaterEqual(len(listed), 54)
        for entry in listed:
            for key in ("term", "equation", "latex", "source", "stage", "separated_by"):
                self.assertTrue(entry[key], f"{entry['id']} {key}")
        one = json.loads(self.run_command("effects", "guide_friction", "--json").stdout)
        self.assertEqual(one, next(e for e in listed if e["id"] == "guide_friction"))
        text = self.run_command("effects", "guide_friction").stdout
        for parameter in one["parameters"]:
            self.assertIn(parameter["name"], text)
            self.assertIn(f"[{parameter['unit']}]", text)
        self.assertIn(one["equation"], text)

    def test_written_documentation_is_the_committed_one(self):
        self.run_command("effects", "--write-docs", "effects.md")
        self.assertEqual((self.dir / "effects.md").read_text(), (system.ROOT / "docs/reference/effects.md").read_text())

    def test_unknown_effect_is_bad_input_and_the_near_one_is_named(self):
        for arguments in (["tilt_ofset"], ["--gallery", "--only", "tilt_ofset"]):
            done = self.run_command("effects", *arguments, expect=4)
            self.assertIn("tilt_offset", done.stderr)

    def test_gallery_shows_what_an_effect_does(self):
        self.run_command("effects", "--gallery", "--mission", self.short_mission(), "--only", "constant_pull",
                         "accelerometer_error", "--out", "gallery", "--quiet", timeout=80)
        page = (self.dir / "gallery" / "gallery.html").read_text()
        for text in ("constant_pull", "accelerometer_error", "force [N]", "torque [Nm]", "power [W]",
                     "speed difference [rad/s]", "error [m]", "error [deg]"):
            self.assertIn(text, page)
        self.assertIsNone(re.search(r"(src|href)=\"https?:", page), "the page stands alone")
        flights = {f["effect"]: f for f in json.loads((self.dir / "gallery" / "gallery.json").read_text())["flights"]}
        self.assertEqual({f["verdict"] for f in flights.values()}, {"flown"})
        self.assertEqual(flights["none"]["force_peak_N"], 0)
        self.assertEqual(flights["accelerometer_error"]["force_peak_N"], 0)
        # typical values: 0.2 N twice sideways and 1 N down
        self.assertAlmostEqual(flights["constant_pull"]["force_peak_N"], (0.2**2 + 0.2**2 + 1) ** 0.5, places=6)
        self.assertGreater(flights["constant_pull"]["mean_power_W"], 1.05 * flights["none"]["mean_power_W"])
        self.assertFalse((self.dir / "gallery" / "none" / "flight.mcap").exists(), "recordings go unless --keep")


if __name__ == "__main__":
    unittest.main()
