"""Branches of each package's sources that its own tests take, held against tests/coverage.json.

A branch is one outcome of one condition, as written: of a template or inlined function it is taken when one instance takes it.
Example: launch_scripts/coverage_table.py build/coverage/profiles safety control
"""
import json
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
RECORDED = ROOT / "tests" / "coverage.json"
LADDER = "safety"  # the package whose branches are all to be taken
TOLERANCE = 0.05  # % that rounding and the order of threads may take away


def branches(export, package):
    """{(file, line, column): [times true, times false]} of the package's own sources."""
    own = f"/src/omniflight_{package}/"
    found = {}
    for file in export["data"][0]["files"]:
        name = file["filename"]
        if own not in name:
            continue
        for line, column, _, _, taken, not_taken, *_ in file["branches"]:
            counts = found.setdefault((name.split("/src/", 1)[1], line, column), [0, 0])
            counts[0] += taken
            counts[1] += not_taken
    return found


def main():
    arguments = sys.argv[1:]
    record = "--record" in arguments
    profiles, *packages = [a for a in arguments if a != "--record"]
    recorded = json.loads(RECORDED.read_text())
    today, bad = {}, 0
    for package in packages:
        found = branches(json.loads((Path(profiles) / package / "coverage.json").read_text()), package)
        missing = sorted((*place, word) for place, counts in found.items()
                         for word, count in zip(("never true", "never false"), counts) if count == 0)
        total = 2 * len(found)
        if total == 0:
            print(f"{package}: no branches found")
            bad += 1
            continue
        today[package] = round(100.0 * (total - len(missing)) / total, 2)
        least = 100.0 if package == LADDER else recorded.get(package)
        if least is None:
            verdict, bad = "not recorded: --record", bad + (not record)
        elif today[package] < least - (0.0 if package == LADDER else TOLERANCE):
            verdict, bad = f"FELL below {least:.2f} %", bad + 1
        else:
            verdict = f"at least {least:.2f} %"
        print(f"{package}: {total - len(missing)} of {total} branches taken, {today[package]:.2f} %, {verdict}")
        if package == LADDER:
            for file, line, column, word in missing:
                print(f"  {file}:{line}:{column} {word}")
    if record and not bad:
        RECORDED.write_text(json.dumps({**recorded, **today}, indent=2, sort_keys=True) + "\n")
        print(f"recorded in {RECORDED.relative_to(ROOT)}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
