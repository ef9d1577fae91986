#!/usr/bin/env python3
"""What each assumption of the diagnosis is worth: synthetic flights of the families are drawn for tuning, and diagnosed whole
and with every ablation (`omniflight diagnose --ablation`). Prints a table of scores, differences on the same flights with the
sign test's probability, and processor time; each ablation and the whole are scored in OUT/ID/scores. Resumes after a kill.

Example: launch_scripts/ablations.py --out build/ablations --cases 140 --nulls 60 --seed 1501 --longest 40
"""
import argparse
import json
import math
import os
import subprocess
import sys
import threading

IDS = ["no-law-error", "no-resolution", "no-initial-states", "no-load-starts", "no-instruments", "no-horizons",
       "no-tolerance-factors", "no-told-totals", "no-told-noise", "no-spectrum-correction", "no-occurrence",
       "no-unknown-physics", "no-velocity-observer", "no-late-thrust", "no-heavy-tails"]
WHOLE = "whole"


def diagnose(options, case, ablation):
    """One answer; its processor time [s] stands beside it."""
    folder = os.path.join(options.out, ablation, "answers", case)
    told = os.path.join(folder, "processor_s")
    if os.path.exists(told):
        return
    os.makedirs(folder, exist_ok=True)
    at = os.path.join(options.out, "cases", case)
    command = [options.omniflight, "diagnose", f"{at}/flight.csv.gz", "--vehicle", f"{at}/vehicle.yaml", "--jobs", "1",
               "--budget-s", str(options.budget_s), "--out", folder]
    if ablation != WHOLE:
        command += ["--ablation", ablation]
    with open(os.path.join(folder, "output"), "w", encoding="utf-8") as output:
        child = subprocess.Popen(command, stdout=output, stderr=output)
    watchdog = threading.Timer(4 * options.budget_s, child.kill)
    watchdog.start()
    _, _, usage = os.wait4(child.pid, 0)
    watchdog.cancel()
    with open(told, "w", encoding="utf-8") as file:
        file.write(str(usage.ru_utime + usage.ru_stime))


def scores(options, ablation):
    folder = os.path.join(options.out, ablation)
    subprocess.run([options.score, "--answers", os.path.join(folder, "answers"), "--seal", options.seal, "--out",
                    os.path.join(folder, "scores"), "--quiet"], check=True, stdout=subprocess.DEVNULL)
    with open(os.path.join(folder, "scores", "family_scores.json"), encoding="utf-8") as file:
        out = json.load(file)
    out["processor_s"] = 0
    for case in out["cases"]:
        with open(os.path.join(folder, "answers", case["case"], "processor_s"), encoding="utf-8") as file:
            out["processor_s"] += float(file.read())
    return out


def good(case):
    """Whether an answer is what it should be: nothing in a nominal flight, the whole truth and nothing else otherwise."""
    return not case["alarm"] if case["kind"] in ("null", "decoy") else case["exact"] or case["unknown_right"]


def sign_test(better, worse):
    """Two-sided probability of so uneven a split where both are equally likely."""
    n, least = better + worse, min(better, worse)
    return min(1.0, 2 * sum(math.comb(n, k) for k in range(least + 1)) / 2 ** n)


def row(name, s, whole):
    group = s["groups"][0]
    here, there = ({c["case"]: good(c) for c in x["cases"]} for x in (s, whole))
    worse = sum(there[k] and not here[k] for k in here)
    better = sum(here[k] and not there[k] for k in here)
    rate = lambda r: f'{r["k"]}/{r["n"]}'
    return [name, rate(group["false_alarms"]), rate(group["detection"]), rate(group["top1"]), rate(group["in_set"]),
            "-" if group["set_size"] is None else f'{group["set_size"]:.1f}', rate(group["pairs_exact"]), rate(group["unknown"]), rate(group["intervals"]),
            f'{s["reliability"]["expected_calibration_error"]:.2f}', f'{group["log_score"]:.2f}', rate(group["unanswered"]),
            str(sum(here.values())), f"{worse}, {better}" if s is not whole else "", f"{sign_test(better, worse):.2f}" if s is not whole else "",
            f'{s["processor_s"] / len(here):.1f}']


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", required=True, help="folder")
    parser.add_argument("--cases", type=int, default=140, help="flights with hidden effects")
    parser.add_argument("--nulls", type=int, default=60, help="nominal flights")
    parser.add_argument("--seed", type=int, default=1501)
    parser.add_argument("--longest", type=float, default=40, help="longest flight [s]")
    parser.add_argument("--budget-s", type=float, default=60, help="of an answer [s]")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--bin", default="build/testing/install", help="where the programs are installed")
    parser.add_argument("ablation", nargs="*", help="only these: " + ", ".join(IDS))
    options = parser.parse_args()
    options.seal = options.out + "_seal"
    options.omniflight = os.path.join(options.bin, "omniflight_cli/bin/omniflight")
    options.score = os.path.join(options.bin, "omniflight_proof/lib/omniflight_proof/omniflight_proof_families_score")
    subprocess.run([options.score.removesuffix("_score"), "--tuning", "--seed", str(options.seed), "--cases", str(options.cases),
                    "--nulls", str(options.nulls), "--longest", str(options.longest), "--jobs", str(options.jobs), "--out", options.out, "--seal",
                    options.seal], check=True, stdout=subprocess.DEVNULL)
    asked = [WHOLE] + (options.ablation or IDS)
    work = [(case, a) for a in asked for case in sorted(os.listdir(os.path.join(options.out, "cases")))]
    total, lock = len(work), threading.Lock()

    def worker():
        while True:
            with lock:
                if not work:
                    return
                case, ablation = work.pop(0)
                done = total - len(work)
                if sys.stderr.isatty() or done % 50 == 0:
                    print(f"diagnosis {done} of {total}: {ablation}, {case}", file=sys.stderr)
            diagnose(options, case, ablation)

    threads = [threading.Thread(target=worker) for _ in range(options.jobs)]
    for t in threads:
        t.start()
    for t in threads:
        t.join()
    whole = scores(options, WHOLE)
    table = [["ablation", "false alarms", "detected", "top-1", "in set", "size", "pairs", "unknown", "intervals", "ECE", "log", "unanswered",
              "whole truth", "lost, won", "p", "CPU [s]"], row(WHOLE, whole, whole)]
    table += [row(a, scores(options, a), whole) for a in asked[1:]]
    print(f"{len(whole['cases'])} synthetic flights, seed {options.seed}")
    for k, line in enumerate(table):
        print("| " + " | ".join(line) + " |")
        if k == 0:
            print("|" + "---|" * len(line))


if __name__ == "__main__":
    main()
