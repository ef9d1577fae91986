#!/usr/bin/env python3
"""Prints what the commands of a build took: build_time_table.py FOLDER, as build_time.sh has filled it."""

import pathlib
import re
import sys

SLOWEST = 15
PROCESSORS = 2


def wall(seconds):
    """Time [s] of commands one after the other on PROCESSORS, each on the first that is free."""
    busy = [0.0] * PROCESSORS
    for one in seconds:
        first = busy.index(min(busy))
        busy[first] += one
    return max(busy)


def read(path):
    """(seconds, what was made) of each command, in the order of their ends."""
    out = []
    for line in path.read_text().splitlines():
        user, system, made = line.split(" ", 2)
        out.append((float(user) + float(system), made))
    return out


def whole(path):
    """Wall and processor time [s] of the whole build; nothing where it did not end or was not whole."""
    words = path.read_text().split() if path.exists() else []
    if len(words) != 5:  # seconds; user and system of the shell, then of its children
        return None
    minutes = [re.fullmatch(r"(\d+)m([\d.]+)s", word) for word in words[3:]]
    return float(words[0]), sum(60 * int(m[1]) + float(m[2]) for m in minutes)


def main(folder):
    packages = {p.name: read(p) for p in sorted(folder.iterdir()) if p.name != "whole"}
    if not packages:
        sys.exit(f"{folder} has no times: run build_time.sh")
    commands, walls = 0.0, 0.0
    print("processor time [s]   commands   package")
    for name, made in sorted(packages.items(), key=lambda kv: -sum(s for s, _ in kv[1])):
        spent = sum(s for s, _ in made)
        commands += spent
        walls += wall([s for s, _ in made])
        print(f"{spent:18.1f}   {len(made):8d}   {name}")
    print("\nprocessor time [s]   slowest")
    every = [(s, f"{name}/{what}") for name, made in packages.items() for s, what in made]
    for seconds, what in sorted(every, reverse=True)[:SLOWEST]:
        print(f"{seconds:18.1f}   {what}")
    print(f"\ncompilers and linkers: {commands:.0f} s of processor time")
    total = whole(folder / "whole")
    if total:
        other = max(0.0, total[1] - commands)
        print(f"whole build: {total[1]:.0f} s of processor time, {other:.0f} s of them CMake, Ninja and colcon; it took {total[0]:.0f} s")
        # CMake works on one processor, package after package
        print(f"on {PROCESSORS} idle processors: about {(walls + other) / 60:.1f} minutes")
    else:
        print(f"on {PROCESSORS} idle processors: about {walls / 60:.1f} minutes without CMake's time")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(pathlib.Path(sys.argv[1]))
