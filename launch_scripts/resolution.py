#!/usr/bin/env python3
"""What the resolution of evidence and the rates of effects are worth, from the `sets` of answers to synthetic flights that
ablations.py has made: probabilities are shared again with other resolutions, nothing is diagnosed again. The oracle's aliases
are not applied: a name counts when it is that of the truth.

Example: launch_scripts/ablations.py --out build/ablations no-resolution && launch_scripts/resolution.py build/ablations
"""
import argparse
import json
import math
import os

ALARM = 0.25  # kAlarm of search/posterior.hpp
LAW_ERROR = 0.1
UNKNOWN_ODDS = -8.5  # ln prior odds of one pattern outside the library, about


def shares(sets, nothing_factor, rivals_factor, equal):
    """Probability of each set; factors on the squared law error."""
    likely = lambda e, odds, chance: math.exp(min(700, odds + e / chance))
    evidence = [s["log_evidence_over_nothing"] for s in sets]
    odds = [s["log_prior"] if not equal else sum(UNKNOWN_ODDS if n.startswith("unknown") else equal for n in s["effects"]) for s in sets]
    most = max(0.0, max(evidence))
    by = {k: [likely(e - most, o, 1 + factor * LAW_ERROR ** 2 * most) for e, o in zip(evidence, odds)]
          for k, factor in (("nothing", nothing_factor), ("rivals", rivals_factor))}
    empty = [not s["effects"] for s in sets]
    nothing = sum(x for x, e in zip(by["nothing"], empty) if e) / sum(by["nothing"])
    among = sum(x for x, e in zip(by["rivals"], empty) if not e)
    return [nothing if e else (1 - nothing) * x / among for x, e in zip(by["rivals"], empty)], nothing


def named(sets, p, nothing):
    """Names and their probabilities, as the answer has them."""
    inclusion = {}
    for s, x in zip(sets, p):
        for name in set(s["effects"]):
            inclusion[name] = inclusion.get(name, 0) + x
    out = []
    if nothing >= ALARM:
        return out, inclusion
    best = max((x, k) for k, x in enumerate(p) if sets[k]["effects"])[1]
    for name in sorted(set(sets[best]["effects"]), key=lambda n: -inclusion[n]):
        if sum(x for s, x in zip(sets, p) if len(s["effects"]) > len(out)) <= 1 - ALARM:
            break
        out.append(name)
    return out, inclusion


def row(flights, title, **how):
    alarms = [0, 0]
    first, whole, beside, sure = [0, 0], [0, 0], [0, 0], [0, 0]
    false, log_score, statements = 0, 0.0, 0
    for sets, truth in flights:
        p, nothing = shares(sets, **how)
        names, inclusion = named(sets, p, nothing)
        effects = truth["effects"]
        real = {e["id"] for e in effects}
        present = set(truth.get("present", []))
        wrench = [e for e in effects if e["stage"] == "wrench"]
        if not effects:
            alarms = [alarms[0] + (nothing < ALARM), alarms[1] + 1]
        if len(effects) == 1 and wrench and wrench[0]["id"] != "unknown" and wrench[0]["sigma"] > 0.9:
            first = [first[0] + (names[:1] == [wrench[0]["id"]]), first[1] + 1]
        if wrench and len(wrench) == len(effects):
            whole = [whole[0] + (set(names) == real), whole[1] + 1]
        if len(effects) > 1:
            told = {e["id"] for e in wrench if e["sigma"] > 0.9}
            beside = [beside[0] + len(told & set(names)), beside[1] + len(told)]
        for name in names:
            if name.startswith("unknown"):
                continue
            right, x = name in real or name in present, inclusion[name]
            false += not right
            statements += 1
            log_score -= math.log(min(1, max(0.01, x if right else 1 - x)))
            if x > 0.95:
                sure = [sure[0] + right, sure[1] + 1]
    rate = lambda r: f"{r[0]}/{r[1]}"
    print("| " + " | ".join([title, rate(alarms), rate(first), rate(whole), rate(beside), f"{false} of {statements}", rate(sure), f"{log_score / max(1, statements):.2f}"]) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", help="folder that ablations.py wrote")
    options = parser.parse_args()
    flights, known = [], set()
    with open(os.path.join(options.out + "_seal", "truth.json"), encoding="utf-8") as file:
        for truth in json.load(file)["cases"]:
            answer = os.path.join(options.out, "whole", "answers", truth["id"], "diagnosis.json")
            if not os.path.exists(answer):
                continue
            with open(answer, encoding="utf-8") as said:
                d = json.load(said)
            known.add(sum(x["asked"] == "evidence alone against nothing" and not x["about"].startswith("unknown") for x in d["decisions"]))
            if d["sets"]:
                flights.append((d["sets"], truth))
    equal = math.log(math.log(2) / max(known))
    print(f"{len(flights)} answers")
    print("| | nominal alarms | named first, of 1 sigma or more | whole truth, nothing else | named beside others | false names | above 0.95 come true | log score of a name [nat] |")
    print("|---|---|---|---|---|---|---|---|")
    row(flights, "every nat counts", nothing_factor=0, rivals_factor=0, equal=0)
    row(flights, "one law is wrong", nothing_factor=1, rivals_factor=1, equal=0)
    row(flights, "rivals are both wrong", nothing_factor=1, rivals_factor=2, equal=0)
    row(flights, "the same, all effects equally likely", nothing_factor=1, rivals_factor=2, equal=equal)
    for factor in (4, 9, 16):
        row(flights, f"rivals {factor} times", nothing_factor=1, rivals_factor=factor, equal=0)


if __name__ == "__main__":
    main()
