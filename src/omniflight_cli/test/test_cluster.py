"""Campaigns on a cluster: a real Slurm of two emulated nodes, one of which is lost; and clusters that refuse."""

import os
import signal
import unittest

import cluster
import system

MONTE_CARLO = """schema: omniflight.campaign/1
name: many
missions: [{mission}]
seeds: {{from: 1, count: {count}}}
vary:
  - {{effect: payload_mass, parameter: mass, uniform: [0, 0.2]}}
  - {{start: x, normal: [0, 0.01]}}
"""


class Refused(system.SystemTest):
    def test_without_slurm_the_missing_command_is_named(self):
        file = self.write("many.yaml", MONTE_CARLO.format(mission=self.short_mission(), count=4))
        done = self.run_command("campaign", file, "--in-process", "--executor", "slurm", "--out", "many", expect=4,
                                env={**os.environ, "PATH": "/nonexistent"})
        for words in ("--executor slurm", "sbatch", "slurm-client"):
            self.assertIn(words, done.stderr)
        self.assertFalse((self.dir / "many").exists())

    def test_a_cluster_that_does_not_answer_is_told(self):
        """Commands that say what Slurm's say while their controller is down."""
        folder = self.dir / "bin"
        folder.mkdir()
        for name in ("sbatch", "squeue", "scancel", "scontrol"):
            program = folder / name
            program.write_text("#!/bin/sh\necho 'slurm_load_ctl_conf error: Unable to contact slurm controller "
                               "(connect failure)' >&2\nexit 1\n")
            program.chmod(0o755)
        file = self.write("many.yaml", MONTE_CARLO.format(mission=self.short_mission(), count=4))
        done = self.run_command("campaign", file, "--in-process", "--executor", "slurm", "--out", "many", expect=4,
                                env={**os.environ, "PATH": str(folder)})
        for words in ("--executor slurm", "does not answer", "Unable to contact slurm controller", "sinfo", "SLURM_CONF"):
            self.assertIn(words, done.stderr)


class TwoNodes(system.SystemTest):
    def setUp(self):
        super().setUp()
        if cluster.missing():
            self.skipTest(f"not installed: {', '.join(cluster.missing())} "
                          "(apt-get install slurmctld slurmd slurm-client munge)")
        self.cluster = cluster.Cluster(self.dir / "cluster")
        self.cluster.__enter__()
        self.addCleanup(self.cluster.__exit__)

    def many(self, count):
        return self.write("many.yaml", MONTE_CARLO.format(mission=self.short_mission(), count=count))

    def arguments(self, *more, file="many.yaml"):
        return ("campaign", file, "--in-process", "--executor", "slurm", "--out", "many", *more)

    def parts(self):
        return list((self.dir / "many/parts").glob("*-standard-*"))

    def assert_each_once(self, count):
        result = self.json("many/campaign.json")
        self.assertEqual(sorted(int(f["name"].rsplit("seed", 1)[1]) for f in result["flights"]),
                         list(range(1, count + 1)), "nothing is lost, nothing is there twice")
        self.assertEqual(result["missing"], [])
        self.assertEqual(list((self.dir / "many/parts").glob(".partial-*")), [])
        return result

    def test_long_two_thousand_flights_and_a_node_that_is_lost(self):
        self.many(2000)
        campaign = self.start_command(*self.arguments("--flights-per-job", "1", "--jobs-per-task", "50"),
                                      env=self.cluster.environment())
        system.wait_until("a quarter of the flights", lambda: len(self.parts()) >= 500 or campaign.poll() is not None, 1800)
        self.assertIsNone(campaign.poll(), "it ended before the node was lost")
        running = self.cluster.run("squeue", "-h", "-t", "R", "-o", "%N").stdout.split()
        self.assertIn("node2", running)
        self.cluster.kill_node("node2")
        self.assertLess(len(self.parts()), 1500, "the node was lost too late")
        out, error = campaign.communicate(timeout=1800)
        self.assertEqual(campaign.returncode, 0, out + error)
        result = self.assert_each_once(2000)
        self.assertGreaterEqual(result["executor"]["requeued"] + result["executor"]["arrays"] - 1, 1,
                                "somebody did the lost node's work again")
        self.assertEqual(len(self.parts()), 2000)
        # the same flights on this machine alone: to the bit
        self.run_command("campaign", "many.yaml", "--in-process", "--out", "alone", "--quiet", timeout=1800)
        self.assertEqual(self.json("alone/campaign.json")["flights"], result["flights"])
        print(out)

    def test_long_a_killed_campaign_waits_for_its_array(self):
        self.many(300)
        first = self.start_command(*self.arguments("--flights-per-job", "2", "--jobs-per-task", "15", "--quiet"),
                                   env=self.cluster.environment())
        system.wait_until("the first results", lambda: len(self.parts()) >= 10 or first.poll() is not None, 300)
        self.assertIsNone(first.poll())
        os.kill(first.pid, signal.SIGKILL)
        first.wait(timeout=10)
        done = self.run_command(*self.arguments("--flights-per-job", "2", "--jobs-per-task", "15", "--resume"),
                                env=self.cluster.environment(), timeout=900)
        self.assertIn("of an earlier run is still at work", done.stdout)
        result = self.assert_each_once(300)
        self.assertGreaterEqual(result["kept"], 20)
        self.assertEqual(result["executor"]["arrays"], 0, "what the first array did was enough")

    def test_long_flights_over_the_bus_and_jobs_that_fail(self):
        mission = self.short_mission()
        self.write("four.yaml", f"schema: omniflight.campaign/1\nname: four\nsensors: laboratory\nmissions: [{mission}]\n"
                                "seeds: [1, 2]\nvariants:\n  - {name: pid}\n"
                                "  - {name: bad, parameters: {controller.no_such_gain: 1}}\n")
        done = self.run_command("campaign", "four.yaml", "--executor", "slurm", "--out", "four", expect=2, timeout=600,
                                env=self.cluster.environment())
        result = self.json("four/campaign.json")
        flights = {f["name"]: f for f in result["flights"]}
        self.assertEqual(len(flights), 4)
        for name, flight in flights.items():
            if "-bad-" in name:
                self.assertIn("no_such_gain", flight["reason"], "the program's own words arrive")
            else:
                self.assertEqual(flight["verdict"], "flown")
        self.assertEqual(result["executor"]["arrays"], 1, "what a program refuses is not tried again")
        self.assertIn("cluster: 1 array", done.stdout)

    def test_long_a_task_that_takes_too_long_goes_on_in_another_array(self):
        mission = self.short_mission(changes={"hold_s: 0.5}": "hold_s: 60}"})
        self.write("many.yaml", MONTE_CARLO.format(mission=mission, count=4000))
        done = self.run_command(*self.arguments("--flights-per-job", "40", "--jobs-per-task", "100", "--time", "1",
                                                "--attempts", "20"),
                                env=self.cluster.environment(), timeout=3000)
        result = self.assert_each_once(4000)
        self.assertGreater(result["executor"]["arrays"], 1)
        self.assertIn("they are submitted again", done.stdout)

    def test_long_what_the_cluster_refuses(self):
        self.many(4)
        for arguments, words in ((("--partition", "nope"), ("--partition", "Invalid partition name", "sinfo")),
                                 (("--time", "600"), ("--time", "PartitionTimeLimit", "sinfo"))):
            done = self.run_command(*self.arguments(*arguments, "--force"), env=self.cluster.environment(), timeout=120,
                                    expect=4)
            for word in words:
                self.assertIn(word, done.stderr)
        self.assertEqual(self.cluster.run("squeue", "-h").stdout, "", "nothing is left in the queue")
        self.cluster.daemons["slurmctld"].terminate()
        self.cluster.daemons["slurmctld"].wait(timeout=20)
        done = self.run_command(*self.arguments("--force"), env=self.cluster.environment(), timeout=120, expect=4)
        for word in ("--executor slurm", "does not answer", "sinfo"):
            self.assertIn(word, done.stderr)

    def test_long_the_proof_on_the_cluster(self):
        if not (system.PROGRAMS.parent.parent / "omniflight_proof/bin/omniflight_proof_campaign").exists():
            self.skipTest("built without MuJoCo")
        self.dir.chmod(0o755)  # the analysis runs as a user who must not read the truth, and must enter here
        self.run_command("prove", "--cases", "2", "--nulls", "2", "--tuning", "--no-second", "--no-baselines",
                         "--ablations", "0", "--executor", "slurm", "--out", "proof", "--allow-unsealed",
                         env=self.cluster.environment(), timeout=3000)
        self.assertEqual(len(list((self.dir / "proof/answers").glob("case-*/run.json"))), 4)
        self.assertTrue((self.dir / "proof/proof.json").exists())


if __name__ == "__main__":
    unittest.main()
