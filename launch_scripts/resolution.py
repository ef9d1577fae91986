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

ALARM, BESIDE = 0.25, 0.5  # kAlarm and kBeside of search/posterior.hpp
LAW_ERROR = 0.1
UNKNOWN_ODDS = -8.5  # ln prior odds of one pattern outside the library, about


def shares(sets, nothing, rivals, equal=0):
    """Probability of each set, and that of none. `nothing`: factor on the squared law error where a set is compared with nothing;
    `rivals`: factors where it is compared with others, equally likely; `equal`: ln prior odds of every effect, if not zero."""
    likely = lambda e, odds, chance: math.exp(min(700, odds + e / chance))
    evidence = [s["log_evidence_over_nothing"] for s in sets]
    odds = [s["log_prior"] if not equal else sum(UNKNOWN_ODDS if n.startswith("unknown") else equal for n in s["effects"]) for s in sets]
    most = max(0.0, max(evidence))
    empty = [not s["effects"] for s in sets]
    by = lambda factor: [likely(e - most, o, 1 + factor * LAW_ERROR ** 2 * most) for e, o in zip(evidence, odds)]
    against = by(nothing)
    none = sum(x for x, e in zip(against, empty) if e) / sum(against)
    out = [none if e else 0 for e in empty]
    for factor in rivals:
        among = [0 if e else x for x, e in zip(by(factor), empty)]
        for k, x in enumerate(among):
            out[k] += (1 - none) * x / max(1e-300, sum(among)) / len(rivals)
    return out, none


def inclusions(sets, p):
    """Probability of each name."""
    out = {}
    for s, x in zip(sets, p):
        for name in set(s["effects"]):
            out[name] = out.get(name, 0) + x
    return out


def named(sets, p, nothing):
    """Names and their probabilities, as the answer has them."""
    inclusion = inclusions(sets, p)
    out = []
    if nothing >= ALARM:
        return out, inclusion
    likelier = lambda s: s["log_evidence_over_nothing"] + s["log_prior"] > 0  # than nothing
    sharp, _ = shares(sets, 1, [2])
    best = max((likelier(sets[k]), x, k) for k, x in enumerate(sharp) if sets[k]["effects"])[2]
    for name in sorted(set(sets[best]["effects"]), key=lambda n: -inclusion[n]):
        if not out or inclusion[name] > BESIDE:
            out.append(name)
    return out, inclusion


def expected_error(statements):
    """Expected calibration error over ten bins."""
    bins = {}
    for x, right in statements:
        bins.setdefault(min(9, int(10 * x)), []).append((x, right))
    return sum(abs(sum(x for x, _ in b) - sum(r for _, r in b)) for b in bins.values()) / max(1, len(statements))


def answered(sets, found):
    """Names and their probabilities as they are in the answer; the probability of nothing."""
    inclusion = inclusions(sets, [s["probability"] for s in sets])
    nothing = sum(s["probability"] for s in sets if not s["effects"])
    return [name for name in found if name in inclusion], inclusion, nothing


def row(flights, title, **how):
    """Scores with other resolutions; without any, of what was answered."""
    alarms = [0, 0]
    first, whole, beside, sure = [0, 0], [0, 0], [0, 0], [0, 0]
    statements = []
    for sets, found, truth in flights:
        if how:
            p, nothing = shares(sets, **how)
            names, inclusion = named(sets, p, nothing)
        else:
            names, inclusion, nothing = answered(sets, found)
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
            statements.append((x, right))
            if x > 0.95:
                sure = [sure[0] + right, sure[1] + 1]
    rate = lambda r: f"{r[0]}/{r[1]}"
    false = sum(not right for _, right in statements)
    log_score = -sum(math.log(min(1, max(0.01, x if right else 1 - x))) for x, right in statements)
    print("| " + " | ".join([title, rate(alarms), rate(first), rate(whole), rate(beside), f"{false} of {len(statements)}", rate(sure),
                             f"{expected_error(statements):.2f}", f"{log_score / max(1, len(statements)):.2f}"]) + " |")


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
                flights.append((d["sets"], [f["effect"] for f in d["findings"]], truth))
    equal = math.log(math.log(2) / max(known))
    print(f"{len(flights)} answers")
    print("| | nominal alarms | named first, of 1 sigma or more | whole truth, nothing else | named beside others | false names | above 0.95 come true | ECE | log score of a name [nat] |")
    print("|---|---|---|---|---|---|---|---|---|")
    row(flights, "as answered: 1, 2 or 4 times as much by what is left")
    row(flights, "every nat counts", nothing=0, rivals=[0])
    row(flights, "one law is wrong", nothing=1, rivals=[1])
    row(flights, "rivals are both wrong", nothing=1, rivals=[2])
    row(flights, "rivals are both wrong, by 1, 2 or 4 times as much", nothing=1, rivals=[2, 8, 32])
    row(flights, "the same, all effects equally likely", nothing=1, rivals=[2, 8, 32], equal=equal)
    row(flights, "1, 2 or 4 times as much against nothing, too", nothing=16, rivals=[2, 8, 32])
    for factors in ([8], [32], [2, 8], [2, 32], [0.5, 2, 8, 32]):
        row(flights, "rivals, variances of " + " or ".join(f"{x:g}" for x in factors) + " errors squared", nothing=1, rivals=factors)


if __name__ == "__main__":
    main()
