#!/usr/bin/python3
"""A small proof from end to end: hide, analyse behind the wall, freeze, open, score; killed once on the way, and
tampered with afterwards. The salt is fixed, so that it repeats.

campaign_subset.py PROGRAMS OMNIFLIGHT CONFIGS [CASES NULLS ABLATIONS]
  ABLATIONS: cases that are diagnosed again with every ablation
  PROGRAMS: folder of omniflight_proof_*; OMNIFLIGHT: the command. Exit code 77 with the reason when it is not there.
"""
import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def need(condition, what):
    if not condition:
        sys.exit("FAILED: " + what)
    print("ok: " + what, flush=True)


def main():
    programs, omniflight, configs = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3]
    cases, nulls, ablations = (sys.argv[4:7] if len(sys.argv) > 6 else ("3", "2", "0"))
    if not omniflight.is_file():
        print(f"skipped: {omniflight} is not built; the analysis is the whole program")
        return 77
    environment = {**os.environ, "OMNIFLIGHT_CONFIGS": configs}
    folder = Path(tempfile.mkdtemp(prefix="prove-subset-", dir="/var/tmp"))
    folder.chmod(0o755)
    out, seal = folder / "out", folder / "seal"
    command = [str(programs / "omniflight_proof_campaign"), "--out", str(out), "--seal", str(seal), "--cases", cases,
               "--nulls", nulls, "--salt", "the salt of the subset", "--command", str(omniflight), "--jobs", "2", "--ablations", ablations]
    score = [str(programs / "omniflight_proof_score"), "--out", str(out), "--seal", str(seal)]
    try:
        # killed while it diagnoses, then resumed
        first = subprocess.Popen(command, env=environment, start_new_session=True)
        end = time.monotonic() + 200
        while time.monotonic() < end and first.poll() is None and len(list(out.glob("answers/case-*"))) < 2:
            time.sleep(0.05)
        if first.poll() is not None and first.returncode == 4:
            print("skipped: the analysis cannot be confined here (neither root nor user namespaces)")
            return 77
        need(first.poll() is None, "it was still at work when it was killed")
        os.kill(first.pid, signal.SIGKILL)
        first.wait()
        before = {p: hashlib.sha256(p.read_bytes()).hexdigest() for p in out.glob("answers/*/diagnosis.json")}
        need(not (out / "proof.json").exists(), "nothing is scored before the answers are frozen")
        need(subprocess.run(score, capture_output=True).returncode != 0, "the scorer refuses answers that are not frozen")
        second = subprocess.run(command, env=environment, capture_output=True, text=True)
        print(second.stderr)
        need(second.returncode == 0, "it resumes and, given --seal alone, leaves the seal closed")
        need(not (out / "proof.json").exists(), "the seal stays closed")
        need(all(hashlib.sha256(p.read_bytes()).hexdigest() == h for p, h in before.items()),
             "answers from before the kill are kept as they were")

        # the protocol
        commitment = json.loads((out / "commitment.json").read_text())
        truth = seal / "truth.json"
        need(hashlib.sha256(truth.read_bytes()).hexdigest() == commitment["truth_sha256"], "the commitment is to the truth")
        need(truth.stat().st_mode & 0o777 == 0o600 and seal.stat().st_mode & 0o777 == 0o700, "the seal is private")
        probe = json.loads((out / "probe.json").read_text())
        need(probe["sealed"] and not probe["leaks"] and len(probe["refused"]) >= 6, "the analysis could not read the seal")
        sizes = {p.stat().st_size for p in out.glob("cases/*/flight.csv.gz")}
        told = {p.stat().st_size for p in out.glob("cases/*/told.yaml")}
        need(len(sizes) == 1 and len(told) == 1, "all recordings have one size")
        need(not any(b"payload" in p.read_bytes() or b"truth" in p.read_bytes() for p in out.glob("cases/*/told.yaml")),
             "nothing beside a recording tells what is hidden")

        reveal = [command[0], "--out", str(out), "--reveal", str(seal)]
        opened = subprocess.run(reveal, env=environment, capture_output=True, text=True)
        print(opened.stdout)
        need(opened.returncode == 0, "opened and scored")
        proof = json.loads((out / "proof.json").read_text())
        need(len(proof["cases"]) == int(cases) + int(nulls), "every case is listed")
        need(proof["sealed"], "the result says that it was sealed")
        need(all("must" in s and "goal" in s for s in proof["scores"] if not s["name"].startswith("  ") and s["name"] != "refused"),
             "must and goal stand beside what came out")
        need({"false alarms", "right effect, top-1", "two effects exact"} <= {s["name"] for s in proof["scores"]},
             "the table has its lines")
        leak = proof["leak_test"]
        need(all(leak[k]["p_value"] >= 0.01 for k in ("which_effect", "whether_any")), f"nothing but the data tells: {leak}")
        need(len(proof["baselines"]) >= 6, "baselines were judged on the same cases")
        flown_again = [json.loads(p.read_text())["fit"] for p in out.glob("answers/case-*/diagnosis.json")]
        need(all(len(f["closed_loop"]) == 6 and f["power"]["simulated_after_W"] > 100 for f in flown_again),
             "every flight was flown again in closed loop, without and with the model")
        proposed = {p.parent.name for p in out.glob("answers/*/next_flight.yaml")}
        flown = {p.name for p in out.glob("next/*")}
        need(flown <= proposed, "only what was proposed was flown again")
        need({p.name for p in out.glob("answers_next/*")} == flown, "and analysed: " + str(sorted(flown)))
        need(not flown or proof["answers_next_sha256"], "those answers were frozen, too")
        if int(ablations) > 0:
            whole = proof["ablations"].pop("nothing left out")
            need(len(proof["ablations"]) == 6 and
                 all(a["cases"] == whole["cases"] == int(ablations) for a in proof["ablations"].values()),
                 "every ablation was judged on the same cases")
        need("B6 oracle, told what is hidden" in proof["baselines"], "the oracle was asked")
        by_name = {s["name"]: s for s in proof["scores"]}
        first = re.search(r'<div class="verdict \w+">.*?<h2>(.*?)</h2>', (out / "report.html").read_text()).group(1)
        need("{k} of {n} flights with nothing hidden accused wrongly".format(**by_name["false alarms"]) in first,
             f"the page begins with what the proof came to: {first}")
        need(by_name["refused"]["k"] == 0, "every case was answered")

        # tampering
        victim = next(out.glob("answers/case-*/diagnosis.json"))
        kept = victim.read_bytes()
        victim.chmod(0o644)
        victim.write_bytes(kept + b"\n")
        changed = subprocess.run(score, capture_output=True, text=True)
        need(changed.returncode != 0 and "not those that were frozen" in changed.stderr, "changed answers are refused")
        victim.write_bytes(kept)
        truth.write_text(truth.read_text().replace("0.15", "0.16"))
        changed = subprocess.run(score, capture_output=True, text=True)
        need(changed.returncode != 0 and "not the truth that was committed to" in changed.stderr, "a changed truth is refused")
        return 0
    finally:
        shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    sys.exit(main())
