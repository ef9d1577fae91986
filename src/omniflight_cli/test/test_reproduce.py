"""`omniflight reproduce`: figures without flights at once, kept ones, hostile files; all of it in the long set."""

import json
import unittest

import system


class Reproduce(system.SystemTest):
    def test_figures_without_flights_are_computed_once_and_kept(self):
        first = self.run_command("reproduce", "--fast", "--out", "r")
        result = self.json("r/reproduce.json")
        ids = [f["id"] for f in result["figures"]]
        self.assertEqual(result["schema"], "omniflight.reproduction/1")
        self.assertTrue({"table 4.1", "5.1", "5.8", "6.1", "6.4", "A.1", "A.4"} <= set(ids), ids)
        self.assertEqual(result["not_computed"], 0)
        self.assertFalse(any(f["kept"] for f in result["figures"]))
        self.assertIn(result["conclusion"], first.stdout)
        page = (self.dir / "r/report.html").read_text()
        self.assertIn(result["conclusion"], page)
        for text in ("Figure 5.7", "1213", "Table 4.1"):
            self.assertIn(text, page)
        again = self.run_command("reproduce", "--fast", "--out", "r")
        self.assertIn(f"({len(ids)} kept from before)", again.stdout)
        for old, new in zip(result["figures"], self.json("r/reproduce.json")["figures"]):
            self.assertTrue(new["kept"])
            self.assertEqual(old.get("rows"), new.get("rows"))

    def test_verdicts_follow_from_the_printed_number_and_ours(self):
        self.run_command("reproduce", "5.7", "A.4", "--out", "r", "--quiet")
        rows = {row["key"]: row for f in self.json("r/reproduce.json")["figures"] for row in f["rows"]}
        mass = rows["5.7/mass_30"]
        self.assertEqual(mass["verdict"], "explained", "with 5.95 N in place of Table 4.1's 6.25 N")
        values = {r["assumption"]: r["value"] for r in mass["readings"]}
        for f_max in (6.25, 5.95):  # four rotors at 30 deg, each half of its thrust aside
            self.assertAlmostEqual(values[f"largest thrust {f_max:.2f} N"], 1000 * 4 * f_max * 0.5 / 9.81, places=6)
        self.assertEqual(rows["A.4/inradius_50"]["verdict"], "contradicted")

    def test_a_figures_file_that_was_changed_is_computed_again(self):
        self.run_command("reproduce", "5.7", "--out", "r", "--quiet")
        file = self.dir / "r/figures/5.7.json"
        whole = file.read_bytes()
        for damaged in (whole[:len(whole) // 2], b"[]", whole.replace(b'"rows":[', b'"rows":[7,', 1), whole.replace(b'"key":"', b'"key":"0', 1),
                        b"\x00" * 100):
            file.write_bytes(damaged)
            done = self.run_command("reproduce", "5.7", "--out", "r")
            self.assertIn("(0 kept from before)", done.stdout)
        self.assertEqual(json.loads(file.read_text())["finding"]["rows"], json.loads(whole)["finding"]["rows"])

    def test_names_that_there_are_not_are_refused_with_the_nearest(self):
        done = self.run_command("reproduce", "table 7.2", expect=4)
        self.assertIn("there is no figure 'table 7.2'", done.stderr)
        self.assertIn("Did you mean", done.stderr)
        self.assertIn("must be more than 0", self.run_command("reproduce", "--budget-s", "0", expect=4).stderr)

    def test_a_budget_that_is_over_leaves_the_rest_for_the_next_run(self):
        done = self.run_command("reproduce", "7.2", "--budget-s", "0.000001", "--out", "r", expect=2)
        self.assertIn("1 not computed", done.stdout)
        self.assertEqual(self.json("r/reproduce.json")["not_computed"], 1)

    def test_all_are_listed(self):
        listed = json.loads(self.run_command("reproduce", "--list", "--json").stdout)
        ids = {f["id"] for f in listed}
        wanted = {f"5.{k}" for k in range(1, 9)} | {f"6.{k}" for k in range(1, 5)} | {f"7.{k}" for k in range(2, 10)}
        wanted |= {f"A.{k}" for k in range(1, 9)} | {"table 4.1", "table 7.1"}
        self.assertTrue(wanted <= ids, wanted - ids)

    def test_long_everything_within_twenty_minutes(self):
        done = self.run_command("reproduce", "--jobs", "2", "--budget-s", "1200", "--out", "r", timeout=1500)
        result = self.json("r/reproduce.json")
        print(done.stdout)
        self.assertEqual(result["not_computed"], 0)
        rows = {row["key"]: row for f in result["figures"] for row in f.get("rows", []) if row["key"]}
        self.assertEqual(rows["7.1/t1/more"]["verdict"], "explained")
        self.assertEqual(rows["7.1/t2/more"]["verdict"], "explained")


if __name__ == "__main__":
    unittest.main()
