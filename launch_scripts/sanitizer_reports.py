"""Reports that sanitizers wrote into a folder, those of our own accesses apart from those inside libraries.

ThreadSanitizer cannot see the atomics of a library that is not built with it, Debian's Cyclone DDS: whether one of its own
accesses races is guesswork. A race is ours when both accesses are of our code, which the innermost frame that is neither the
sanitizer's nor a header-only library's tells; where its callers stand does not matter, so that our listeners, which Cyclone DDS
calls, are judged, too. Any other report (deadlock, use after free, undefined behaviour) is ours when a stack of it begins there.

Example: launch_scripts/sanitizer_reports.py build/flight-path-thread/reports
"""
import re
import sys
from pathlib import Path

FRAME = re.compile(r"^ +#\d+ ")
ACCESS = re.compile(r"^ +(?:Previous )?(?:\[failed to restore|(?:atomic |heap-use-after-free )?(?:[Rr]ead|[Ww]rite))")
RUNTIME = ("libtsan", "libasan", "libubsan", "/usr/include/", "libsanitizer", "libc.so", "libstdc++", "/libc/")


def ours(stack):
    """Whether the innermost frame that says whose code it is lies in our sources."""
    for frame in stack:
        if "/src/omniflight_" in frame or "/omniflight_msgs/" in frame:
            return True
        if not any(word in frame for word in RUNTIME):
            return False
    return False


def stacks(report):
    """[(heading, [frames])] of a report."""
    found, heading = [], ""
    for line in report.splitlines():
        if FRAME.match(line):
            if not found or found[-1][0] != heading:
                found.append((heading, []))
            found[-1][1].append(line)
        elif line.strip():
            heading = line
    return found


def split(text):
    """Reports of one file."""
    begin = re.compile(r"^(?:WARNING: ThreadSanitizer|==\d+==(?:ERROR|WARNING): |\S+: runtime error: )", re.M)
    starts = [m.start() for m in begin.finditer(text)]
    return [text[a:b] for a, b in zip(starts, [*starts[1:], len(text)])]


def is_ours(report):
    all_stacks = stacks(report)
    if "data race" in report.splitlines()[0]:
        accesses = [stack for heading, stack in all_stacks if ACCESS.match(heading)]
        return len(accesses) >= 2 and all(map(ours, accesses[:2]))
    if "runtime error" in report.splitlines()[0]:
        return True
    return any(ours(stack) for _, stack in all_stacks)


def self_test():
    race = ("WARNING: ThreadSanitizer: data race (pid=1)\n  Write of size 8 at 0x1 by thread T1:\n    #0 memcpy <null> (libtsan.so.2+0x1)\n"
            "    #1 A::heard() ../src/omniflight_bus/src/a.cpp:1 (x+0x1)\n    #2 <null> <null> (libddsc.so.0+0x1)\n\n"
            "  Previous read of size 8 at 0x1 by main thread:\n    #0 {} (x+0x2)\n    #1 main ../src/omniflight_bus/src/b.cpp:2 (x+0x2)\n\n"
            "  Thread T1 created by main thread at:\n    #0 pthread_create <null> (libtsan.so.2+0x3)\n")
    own = race.format("A::get() ../src/omniflight_bus/src/a.cpp:2")
    theirs = race.format("dds_write <null> (libddsc.so.0+0x3)")
    undefined = "src/a.cpp:1:2: runtime error: signed integer overflow\n    #0 f ../src/omniflight_core/a.cpp:1\n"
    assert [is_ours(r) for r in split(own + theirs + undefined)] == [True, False, True]


def main():
    self_test()
    mine, others = [], 0
    for file in sorted(Path(sys.argv[1]).iterdir()):
        text = file.read_text(errors="replace")
        found = split(text)
        if not found and text.strip():
            found = [text]  # the sanitizer itself failed
            mine.append((file.name, text))
            continue
        for report in found:
            if is_ours(report):
                mine.append((file.name, report))
            else:
                others += 1
    shown = {}
    for name, report in mine:
        key = re.findall(r"/src/(omniflight_\S+:\d+)", report)[:2]
        shown.setdefault(tuple(key), (name, report))
    for name, report in shown.values():
        print(f"--- {name}\n" + "\n".join(report.splitlines()[:40]))
    print(f"{len(mine)} reports of our code ({len(shown)} different), {others} inside libraries")
    return 1 if mine else 0


if __name__ == "__main__":
    sys.exit(main())
