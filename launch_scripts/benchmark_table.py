#!/usr/bin/env python3
"""Prints the table of ratios from what the benchmarks wrote.

Two kinds of files are read. Text: a line that counts is a JSON object with id, what, ours, ours_value, peer,
peer_value, unit, ratio (theirs over ours), must and stretch (0: no goal), or with `skipped` and the reason; other lines
are left alone. JSON of Google Benchmark: PAIRS below says which of its figures are compared.

Example: benchmark_table.py build/benchmark/results/bench_*
"""
import json
import os
import sys

# id, what, (program, our benchmark), figure (or ours and the peer's), (peers: name, benchmark), must, stretch. A peer that is not installed is not
# in the file, and skipped.
QP_PEERS = [("quadprog", "peer<QuadprogPeer>"), ("dlib", "peer<DlibPeer>"), ("NLopt SLSQP", "peer<NloptPeer>")]
LLT = [("Eigen's LLT, bounds ignored", "floor_eigen_llt")]
# Peers that no Debian package brings, with what they took in terms of Eigen's LLT where all were built from their sources
# (DAQP 11e0fd8, qpmad a39cd70 with fixed sizes, programs of the same kind): the goals against LLT below are 1.5 times faster than DAQP.
NOT_PACKAGED = [("DAQP, warm", "median 1.09, 99 % 3.13 of LLT's median"), ("qpmad", "median 1.07, 99 % 5.15 of LLT's median")]
PAIRS = [
    ("A-1", "one quadratic program, median", ("bench_allocation", "ours/warm"), "median_ns", QP_PEERS, 2, 3),
    ("A-1", "one quadratic program, 99 %", ("bench_allocation", "ours/warm"), "p99_ns", QP_PEERS, 2.5, 4),
    ("A-1", "one quadratic program, median", ("bench_allocation", "ours/warm"), "median_ns", LLT, 1.39, 2.5),
    ("A-1", "one quadratic program, 99 %, over the median of the peer", ("bench_allocation", "ours/warm"),
     ("p99_ns", "median_ns"), LLT, 0.476, 1),
    ("A-2", "one with the matrix of the last, median", ("bench_allocation", "ours_kept_matrix"), "median_ns", LLT, 0, 0),
    ("A-3", "period with eight tilts, median", ("bench_allocation", "period/search_of_eight_tilts"), "median_ns", LLT, 0, 0),
    ("A-3", "period with three tilts, median", ("bench_allocation", "period/search_of_three_tilts"), "median_ns",
     [("quadprog", "peer_period_search_of_three_tilts")], 4, 8),
    ("P-1", "is a pose free", ("bench_planning", "PoseIsFree"), "real_time", [("FCL", "PeerPoseIsFreeFcl")], 0, 0),
]


def read_lines(path):
    with open(path, encoding="utf-8") as file:
        for line in file:
            if line.startswith('{"id"'):
                try:
                    yield json.loads(line)
                except ValueError:
                    print(f"{path}: not JSON: {line.strip()}", file=sys.stderr)


def read_pairs(path):
    """Rows of PAIRS that concern one program."""
    with open(path, encoding="utf-8") as file:
        text = file.read()
    if not text.strip():
        return
    runs = {}
    for run in json.loads(text)["benchmarks"]:
        runs[run["name"].split("/iterations:")[0].removesuffix("/real_time")] = run
    program = os.path.basename(path).removesuffix(".json")
    for identity, what, (of, ours), figure, peers, must, stretch in PAIRS:
        if of != program or ours not in runs:
            continue
        figure, peer_figure = figure if isinstance(figure, tuple) else (figure, figure)
        if peers is LLT and ours == "ours/warm" and figure == "median_ns":
            for name, known in NOT_PACKAGED:
                yield {"id": identity, "what": what, "peer": name, "skipped": f"not in Debian; elsewhere {known}"}
        own = runs[ours][figure]
        for name, peer in peers:
            row = {"id": identity, "what": what, "peer": name}
            if peer not in runs:
                yield row | {"skipped": "not installed when it was built"}
                continue
            theirs = runs[peer][peer_figure]
            yield row | {"ours": ours, "ours_value": own, "peer_value": theirs, "unit": "ns", "ratio": theirs / own,
                         "must": must, "stretch": stretch}


def read(paths):
    for path in paths:
        yield from (read_pairs if path.endswith(".json") else read_lines)(path)


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
