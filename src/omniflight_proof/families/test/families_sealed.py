#!/usr/bin/python3
"""A sealed run by families from end to end: hide, analyse behind the wall, freeze; the seal stays closed, then it is
opened and scored.

families_sealed.py PROGRAMS OMNIFLIGHT    exit code 77 with the reason when the analysis is not there
"""
import hashlib
import json
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
    programs, omniflight = Path(sys.argv[1]), Path(sys.argv[2])
    if not omniflight.is_file():
        print(f"skipped: {omniflight} is not built; the analysis is the whole program")
        return 77
    folder = Path(tempfile.mkdtemp(prefix="families-sealed-", dir="/var/tmp"))
    folder.chmod(0o755)
    out, seal = folder / "out", folder / "seal"
    command = [str(programs / "omniflight_proof_campaign"), "--families", "--out", str(out), "--seal", str(seal), "--cases", "2",
               "--nulls", "2", "--salt", "the salt of the families", "--command", str(omniflight), "--limit-s", "120"]
    try:
        closed = subprocess.run(command, capture_output=True, text=True)
        if closed.returncode == 4 and "confined" in closed.stderr:
            print("skipped: the analysis cannot be confined here (neither root nor user namespaces)")
            return 77
        need(closed.returncode == 0, "hidden, analysed, frozen: " + closed.stderr[-2000:])
        need("nothing is tuned on a sealed run" in closed.stderr, "the rules are printed")
        need(not (out / "family_scores.json").exists(), "the seal stays closed")
        commitment = json.loads((out / "commitment.json").read_text())
        need(commitment["box"] == "sealed", "numbers are those of the sealed boxes")
        need(hashlib.sha256((seal / "truth.json").read_bytes()).hexdigest() == commitment["truth_sha256"],
             "the commitment is to the truth")
        probe = json.loads((out / "probe.json").read_text())
        need(probe["sealed"] and not probe["leaks"], "the analysis could not read the seal")
        answers = list(out.glob("answers/case-*/diagnosis.json"))
        need(len(answers) == 4, "every case is answered, each with its own vehicle")
        opened = subprocess.run([command[0], "--out", str(out), "--reveal", str(seal)], capture_output=True, text=True)
        need(opened.returncode == 0, "opened and scored: " + opened.stderr[-2000:])
        scores = json.loads((out / "family_scores.json").read_text())
        need(scores["box"] == "sealed" and len(scores["cases"]) == 4, "every case is listed")
        need("whoever opens a seal draws the next" in opened.stderr, "the rules are printed again")
        return 0
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
