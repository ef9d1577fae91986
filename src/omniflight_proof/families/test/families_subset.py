#!/usr/bin/python3
"""Families from end to end: draw, resume, commit; fixed answers, scored.

families_subset.py PROGRAMS    folder of omniflight_proof_families*
"""
import hashlib
import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path


def need(condition, what):
    if not condition:
        sys.exit("FAILED: " + what)
    print("ok: " + what, flush=True)


def main():
    programs = Path(sys.argv[1])
    folder = Path(tempfile.mkdtemp(prefix="families-"))
    out, seal = folder / "out", folder / "seal"
    draw = [str(programs / "omniflight_proof_families"), "--out", str(out), "--seal", str(seal), "--tuning", "--seed", "12",
            "--cases", "3", "--nulls", "2", "--vehicles", "quadrotor_1200g", "--effects", "constant_pull", "com_offset",
            "rotor_thrust_scale", "--quiet", "--jobs", "2"]
    try:
        drawn = subprocess.run(draw, capture_output=True, text=True, timeout=300)
        need(drawn.returncode == 0, "cases are drawn and flown: " + drawn.stderr)
        commitment = json.loads((out / "commitment.json").read_text())
        truth = json.loads((seal / "truth.json").read_text())
        need(hashlib.sha256((seal / "truth.json").read_bytes()).hexdigest() == commitment["truth_sha256"],
             "the commitment is to the truth")
        need((seal / "truth.json").stat().st_mode & 0o777 == 0o600, "the truth is private")
        cases = sorted((out / "cases").iterdir())
        need(len(cases) == 5 and all({p.name for p in c.iterdir()} == {"flight.csv.gz", "vehicle.yaml", "told.yaml"}
                                     for c in cases), "every case has what a laboratory gives, and no more")
        ids = {e["id"] for c in truth["cases"] for e in c["effects"]}
        seen = "".join(p.read_text() for c in cases for p in c.glob("*.yaml"))
        need(not any(i in seen for i in ids), "no file names what is hidden")
        need(all(abs(e["sigma"] / c["sigma"] - 1) < 0.2 for c in truth["cases"] for e in c["effects"]),
             "effects have the sizes that were asked for")
        before = {p: p.read_bytes() for p in out.rglob("*") if p.is_file()}
        (out / "commitment.json").unlink()
        victim = truth["cases"][2]["id"]
        shutil.rmtree(seal / "staging" / victim)
        again = subprocess.run(draw, capture_output=True, text=True, timeout=300)
        need(again.returncode == 0 and all(p.read_bytes() == b for p, b in before.items()),
             "a case that was lost is made again, the same to the bit")
        other = subprocess.run(draw[:-6] + ["payload_mass", "--quiet"], capture_output=True, text=True)
        need(other.returncode == 4 and "begun with other options" in other.stderr, "other options do not resume it")
        loose = subprocess.run([draw[0], "--out", str(out), "--seal", str(seal), "--seed", "3"], capture_output=True, text=True)
        need(loose.returncode == 4 and "--tuning" in loose.stderr, "a sealed run takes no seed")

        # fixed answers: the first hidden effect right, the others nothing; an alarm on one nominal flight
        answers = folder / "answers"
        right, alarmed = 0, 0
        for case in truth["cases"]:
            findings = []
            if case["effects"] and not right:
                right = 1
                findings = [{"effect": e["id"], "probability": 0.9, "cannot_be_told_apart_from": [], "stage": e["stage"],
                             "channels": [], "parameters": []} for e in case["effects"]]
            if not case["effects"] and not alarmed:
                alarmed = 1
                findings = [{"effect": "vibration", "probability": 0.6, "cannot_be_told_apart_from": [], "stage": "sensing",
                             "channels": [], "parameters": []}]
            (answers / case["id"]).mkdir(parents=True)
            (answers / case["id"] / "diagnosis.json").write_text(json.dumps(
                {"schema": "omniflight.diagnosis/1", "verdict": "explained" if findings else "nothing_missing",
                 "findings": findings, "unexplained": [], "mismatch": []}))
        score = [str(programs / "omniflight_proof_families_score"), "--answers", str(answers), "--seal", str(seal), "--out",
                 str(folder / "scores"), "--commitment", str(out / "commitment.json")]
        scored = subprocess.run(score, capture_output=True, text=True)
        need(scored.returncode == 0, "answers are scored: " + scored.stderr)
        result = json.loads((folder / "scores" / "family_scores.json").read_text())
        alarms = next(s for s in result["scores"] if s["name"] == "false alarms")
        need((alarms["rate"]["k"], alarms["rate"]["n"]) == (1, 2), "one of two nominal flights is in alarm")
        whole = result["groups"][0]
        need(whole["detection"]["k"] == 1 and whole["detection"]["n"] == 3, "one of three effects is found")
        first = re.search(r'<div class="verdict \w+">.*?<h2>(.*?)</h2>', (folder / "scores" / "report.html").read_text()).group(1)
        need("1 of 2 flights with nothing hidden accused wrongly" in first, f"the page begins with what the proof came to: {first}")
        need("SHORT" in scored.stdout and "quadrotor_1200g" in scored.stdout, "the table says by family what is short")
        (seal / "truth.json").write_text((seal / "truth.json").read_text().replace("constant_pull", "payload_mass"))
        forged = subprocess.run(score, capture_output=True, text=True)
        need(forged.returncode == 4 and "is not to this truth" in forged.stderr, "a changed truth is refused")
        return 0
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
