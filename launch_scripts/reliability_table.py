"""The table of reliability.sh: for each row the tests that stand for it are run by CTest and their printed figures shown.

Example: launch_scripts/reliability_table.py build/testing/build 3,8 long
"""
import re
import subprocess
import sys
import time
from pathlib import Path

# number, what, pass figure, package and CTest name pattern (empty: nothing stands for it), figure in the output, what is
# short; then what --long adds: patterns of long tests, and scripts beside this one.
ROWS = [
    (1, "recorder killed", "loss <= 100 ms, no gap", [("recording", "McapCrash.AKilledWriter"), ("components", "RecorderKill")],
     r".*(?:kills).*", "8 and 50 kills; 200 with --long",
     [("recording", "recording.killed_200_times"), ("components", "components.recorder_killed_200_times")]),
    (2, "recording cut at every byte, bits flipped", "every loss reported",
     [("recording", "Mcap.(CutAtEveryByte|FlippedBits)|Checkpoints")], r".*(?:cuts|flips|bits).*", "", []),
    (3, "disk full", "error within a flush, readable", [("recording", "McapCrash.(AFullDisk|AnErrorInTheMiddle)")], "",
     "a flight on a full disk with --long", [("cli", "test_long_full_disk_ends_no_flight")]),
    (4, "recorder under load", "0 lost, or loss counted", [("recording", "McapCrash.DroppedMessages"), ("bus", "Delivery")], "",
     "5000 messages/s in row 1; 10 min of a flight beside busy processors and disk with --long",
     [("cli", "test_long_ten_minutes_under_load")]),
    (5, "hung subscriber, full disk", "0 blocked writes, control period + 2 ms", [("bus", "Events.AReaderThatHangs")],
     r"hung reader.*", "the control period beside them with --long", [("cli", "test_long_a_recorder_(that_hangs|on_a_full_disk)")]),
    (6, "component killed in flight", "ladder, no command older than 15 ms",
     [("cli", "test_rotor_line.EndsOnTheLine.test_(control_c|killed_fly|killed_allocator|killed_recorder)")], r"test_.*repeated.*",
     "one kill each; 20 of each with --long; a killed component is not started again", [("cli", "test_long_.*_killed_twenty_times")]),
    (7, "component stopped and continued", "noticed in 20 ms on the line, named within its lease + 5 ms, back in 2 s",
     [("cli", "test_rotor_line.EndsOnTheLine.test_(paused_allocator|a_component_that_stands_still)"), ("bus", "Heartbeat")],
     r"(?:paused allocator|stopped for).*", "allocator, controller, recorder, emulator; one pause each", []),
    (8, "failsafe ladder, 10^6 random sequences, 34 behaviours", "no forbidden transition", [("safety", "Ladder|Behaviour")], "",
     "", [("script", "coverage.sh --only safety")]),
    (9, "ladder timings in simulated flights", "+- 1.5 control periods", [("components", "FailsafeFlight")],
     r"(?:descended|an outlier|frozen IMU).*", "rotor faults in row 10, commands in rows 6 and 7", []),
    (10, "a dead rotor", "share that recovers", [("cli", "test_faults.Faults.test_a_rotor_without_power")], "",
     "one instant; 100 with --long", [("cli", "test_long_a_rotor_dies_at_a_hundred_instants")]),
    (11, "hostile numbers into control laws, estimators, allocation, gate", "finite, bounded, no trace of refused ones",
     [("control", "Hostile"), ("allocation", "HostileNumbers"), ("gateway", "SafetyGate.AnyInput")], r".*hostile inputs.*",
     "200000; 10^7 with --long",
     [("control", "control.ten_million_hostile_numbers"), ("allocation", "allocation.ten_million_hostile_numbers")]),
    (12, "mutated inputs: maps, URDF, YAML, recordings, boards' line, NatNet", "10^6 each, 0 findings",
     [(package, "^fuzz_[a-z]+$") for package in ("planning", "vehicle", "files", "recording", "gateway")], r".*mutated inputs.*",
     "2000 each, without coverage; 10^6, and a minute each by libFuzzer, with --long",
     [(package, "^fuzz_[a-z]+.million$") for package in ("planning", "vehicle", "files", "recording", "gateway")]
     + [("script", "fuzz.sh")]),
    (13, "hostile files", "typed error", [("cli", "test_bad_input")], "", "", []),
    (14, "map integrity, map bombs", "100 % refused, in 100 MB and 0.5 s", [("planning", "OctreeFile|MapBombs")], r".*MB, .* s", "",
     []),
    (15, "serial noise", "<= 1 frame lost at a resync", [("gateway", "Noise.TenMegabytes")], r".*(?:frames|noise|MB).*", "", []),
    (16, "line cut, short writes", "reopens 50/50", [("gateway", "GatewayFaults.(ReopensFifty|ALineThatTakes|AnUnplugged)")], "", "",
     []),
    (17, "planner deadline", "limit + 100 ms", [("planning", "Plans/Budget")], r"budget.*",
     "30 runs at 1 to 200 ms; 200 each, to 6 s, with --long", [("planning", "planning.budget_200_times")]),
    (18, "control loop jitter at 1 kHz beside 4 hogs", "p99 <= 150 us, missed <= 0.05 %, counted",
     [("components", "Jitter"), ("cli", "test_rotor_line.EndsOnTheLine.test_missed_periods")], r"(?:gateway paused|.*beside 4 hogs).*",
     "2 s; a minute with --long", [("components", "components.a_minute_of_jitter")]),
    (19, "no allocation and no page fault in the loop", "0, <= 10",
     [("bus", "HotPath"), ("allocation", "[Aa]llocates|Malloc"), ("components", "RealTime"), ("cli", "test_rotor_line.EndsOnTheLine.test_missed_periods")],
     r".*page faults.*", "publishing and allocation; page faults of a flight of 8 s, from arming to the end of the loop", []),
    (20, "soak", "RSS slope < 1 MB/h, files constant, 0 lost", [], "", "half an hour of flight with --long; --soak-hours 8 is the whole test",
     [("cli", "test_long_soak")]),
    (21, "determinism", "equal hashes", [("cli", "test_flights.Lockstep.test_processes_and_container")], r"real-time factor.*",
     "one compiler", []),
    (22, "DDS security, 22 attacks and mistakes", "all denied, fail closed", [("bus", "Security"), ("cli", "test_secure_flight")],
     r"lockstep: .*", "a patched library with honest keys of another role is not tried", []),
    (23, "mutated RTPS packets under live identities", "alive, RSS + < 5 MB", [("bus", "MutatedPackets")], r".*damaged packets.*",
     "20000 packets; 500000 with --long; the middleware is not built with ASan", [("bus", "bus.half_a_million_mutated_packets")]),
    (24, "log storm", "<= 15 lines/s, the rest counted, calls < 50 us", [("bus", "LineLimit|Say")], r".*lines: .*", "", []),
    (25, "sanitizers on the flight path, coverage", "0 reports, no branch less than recorded", [], "", "with --long alone",
     [("script", "sanitize.sh --sanitize thread"), ("script", "sanitize.sh --sanitize address,undefined"),
      ("script", "coverage.sh")]),
]


def run(build, package, pattern, figure, long_ones):
    """(passed, failed, [figures], seconds) of the tests whose names match."""
    folder = build / f"omniflight_{package}"
    if not (folder / "CTestTestfile.cmake").exists():
        return 0, 0, [f"omniflight_{package} is not built"], 0.0
    label = ["-L", "long"] if long_ones else ["-LE", "long"]
    done = subprocess.run(["ctest", "-V", *label, "-R", pattern], cwd=folder, text=True, capture_output=True, timeout=7200)
    lines = [re.sub(r"^\d+: ", "", line).strip() for line in done.stdout.splitlines()]
    results = [line for line in lines if re.match(r"\d+/\d+ Test\s+#", line)]
    passed = sum("Passed" in line for line in results)
    skipped = sum("Skipped" in line for line in results)
    said = [f"{line.split()[3]}: {line.split('***')[-1]}" for line in results if "***" in line and "Skipped" not in line]
    said += [line for line in lines if figure and re.fullmatch(figure, line) and not re.search(NO_FIGURE, line)]
    said += [f"{skipped} skipped"] if skipped else []
    seconds = re.search(r"Total Test time \(real\) =\s*(\S+)", done.stdout)
    return passed, len(results) - passed - skipped, said, float(seconds.group(1)) if seconds else 0.0


def run_script(build, words):
    """The same of a script beside this one, which builds a tree of its own and ends with its figures."""
    name, *options = words.split()
    begin = time.monotonic()
    log = build.parent / f"{words.replace(' ', '_')}.log"
    with open(log, "w") as output:
        code = subprocess.run([Path(__file__).parent / name, *options], stdout=output, stderr=subprocess.STDOUT,
                              timeout=4 * 3600).returncode
    said = [line.strip() for line in log.read_text(errors="replace").splitlines() if re.fullmatch(SCRIPT_FIGURE, line.strip())]
    return int(code == 0), int(code != 0), said + ([] if code == 0 else [f"see {log}"]), time.monotonic() - begin


NO_FIGURE = r"\[|Test|^Start +\d+:|\(test_\S+\)"  # lines of GoogleTest, CTest and unittest
SCRIPT_FIGURE = r"\S+: .*(?:reports|branches taken|runs in \d+ s|FOUND).*"
LONG_FIGURE = r".*(?:kill|hung recorder|full disk|under load|hostile inputs|mutated inputs|damaged packets|budget|hogs|soak|dead from|repeated).*"


def main():
    build, only = Path(sys.argv[1]), {int(n) for n in sys.argv[2].split(",") if n}
    long_too = len(sys.argv) > 3 and sys.argv[3] == "long"
    bad = short = 0
    print("| # | test | pass figure | result | measured | short |\n|---|---|---|---|---|---|")
    for number, what, wanted, tests, figure, lacks, long_tests in ROWS:
        if only and number not in only:
            continue
        passed = failed = empty = 0
        said, seconds = [], 0.0
        todo = [(*t, figure, False) for t in tests] + [(*t, LONG_FIGURE, True) for t in long_tests if long_too]
        for package, pattern, shown, long_ones in todo:
            p, f, figures, s = run_script(build, pattern) if package == "script" else run(build, package, pattern, shown, long_ones)
            passed, failed, seconds, empty = passed + p, failed + f, seconds + s, empty + (p + f == 0)
            said += figures[:12]
        result = f"{passed} passed" if passed else "none"
        result += f", {failed} FAILED" if failed else ""
        result += f", {empty} NOT FOUND" if empty else ""
        bad += failed > 0 or empty > 0
        short += bool(lacks)
        measured = "; ".join(said) or (f"in {seconds:.1f} s" if todo else "")
        print(f"| {number} | {what} | {wanted} | {result} | {measured} | {lacks} |", flush=True)
    print(f"{len(only) or len(ROWS)} rows, {bad} failed or not found, {short} short of the whole test"
          + ("" if long_too else " (--long runs more)"))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
