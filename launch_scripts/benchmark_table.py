#!/usr/bin/env python3
"""Prints the table of ratios from what the benchmarks wrote.

A line of a benchmark that counts is a JSON object with id, what, ours, ours_value, peer, peer_value, unit, ratio
(theirs over ours), must and stretch (0: no goal), or with `skipped` and the reason. Other lines are left alone.

Example: benchmark_table.py build/benchmark/results/bench_simulation.txt
"""
import json
import sys


def read(paths):
    for path in paths:
        with open(path, encoding="utf-8") as file:
            for line in file:
                if line.startswith('{"id"'):
                    try:
                        yield json.loads(line)
                    except ValueError:
                        print(f"{path}: not JSON: {line.strip()}", file=sys.stderr)


def time(value, unit):
    if unit == "ns" and value >= 10000:
        return f"{value / 1000:.1f} us"
    return f"{value:.4g} {unit}"


def goal(row):
    if not row["must"]:
        return "-"
    return f"{row['must']:g}" + (f" ({row['stretch']:g})" if row["stretch"] else "")


def verdict(row):
    if not row["must"]:
        return ""
    if row["ratio"] < row["must"]:
        return "SHORT"
    return "met, stretch" if row["stretch"] and row["ratio"] >= row["stretch"] else "met"


def main(paths):
    head = ["id", "what", "ours", "peer", "", "ratio", "must (stretch)", "verdict"]
    table = [head]
    for row in read(paths):
        if "skipped" in row:
            table.append([row["id"], row["what"], "", row["peer"], "", "", "", "skipped: " + row["skipped"]])
            continue
        table.append([row["id"], row["what"], time(row["ours_value"], row["unit"]), row["peer"],
                      time(row["peer_value"], row["unit"]), f"{row['ratio']:.2f}", goal(row), verdict(row)])
    if len(table) == 1:
        print("no figures: run launch_scripts/benchmark.sh first", file=sys.stderr)
        return 2
    widths = [max(len(r[k]) for r in table) for k in range(len(head))]
    for index, row in enumerate(table):
        print("  ".join(c.rjust(w) if k in (2, 4, 5) else c.ljust(w) for k, (c, w) in enumerate(zip(row, widths))).rstrip())
        if index == 0:
            print("  ".join("-" * w for w in widths))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
