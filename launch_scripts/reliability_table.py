"""The table of reliability.sh: for each row the tests that stand for it are run by CTest and their printed figures shown.

Example: launch_scripts/reliability_table.py build/testing/build 3,8
"""
import re
import subprocess
import sys
from pathlib import Path

# number, what, pass figure, package and CTest name pattern (empty: nothing stands for it), figure in the output, what is short
ROWS = [
    (1, "recorder killed", "loss <= 100 ms, no gap", "recording", "McapCrash.AKilledWriter", r".*(?:kill|lost).*", ""),
    (2, "recording cut at every byte, bits flipped", "every loss reported", "recording", "Mcap.(CutAtEveryByte|FlippedBits)|Checkpoints",
     r".*(?:cuts|flips|bits).*", ""),
    (3, "disk full", "error within a flush, readable", "recording", "McapCrash.AFullDisk", "", "flight through boards on a full "
     "disk: label long (test_long_full_disk_ends_no_flight)"),
    (4, "recorder under load", "0 lost, or loss counted", "recording", "McapCrash.DroppedMessages", "", "10 min at 20 k msg/s is not run"),
    (5, "hung subscriber", "0 blocked writes", "bus", "Events.AReaderThatHangs", r".*(?:hang|block).*", "control period is not measured"),
    (6, "component killed in flight", "ladder, no command older than 15 ms", "cli",
     "test_rotor_line.EndsOnTheLine.test_(control_c|killed_fly|killed_allocator|killed_recorder)", r"test_.*repeated.*",
     "one kill each, not 20"),
    (7, "component stopped and continued", "noticed in 20 ms on the line, named within its lease + 5 ms, back in 2 s", "cli",
     "test_rotor_line.EndsOnTheLine.test_(paused_allocator|a_component_that_stands_still)", r"(?:paused allocator|stopped for).*",
     "allocator, controller, recorder, emulator; one pause each"),
    (8, "failsafe ladder, 10^6 random sequences, 34 behaviours", "no forbidden transition", "safety", "Ladder", "", ""),
    (9, "ladder timings in simulated flights", "+- 1.5 control periods", "components", "FailsafeFlight", r"(?:descended|an outlier|frozen IMU).*",
     "rotor faults in the pure ladder only; commands in rows 6 and 7"),
    (10, "a dead rotor", "share that recovers", "cli", "test_faults.Faults.test_a_rotor_without_power", "", "one instant, not 100"),
    (11, "hostile numbers into control", "finite, bounded", "gateway", "SafetyGate.AnyInput", "", "gate only; controller and allocator not"),
    (12, "fuzzing", "10^6 runs, 0 findings", "", "", "", "no libFuzzer targets"),
    (13, "hostile files", "typed error", "cli", "test_bad_input", "", ""),
    (14, "map integrity, map bombs", "100 % refused, in 100 MB and 0.5 s", "planning", "OctreeFile|MapBombs", r".*MB, .* s", ""),
    (15, "serial noise", "<= 1 frame lost at a resync", "gateway", "Noise.TenMegabytes", r".*(?:frames|noise|MB).*", ""),
    (16, "line cut, short writes", "reopens 50/50", "gateway", "GatewayFaults.(ReopensFifty|ALineThatTakes|AnUnplugged)", "", ""),
    (17, "planner deadline", "limit + 100 ms", "planning", "Budget", r"budget.*", "5 runs a mission and budget; 200: label long"),
    (18, "control loop jitter", "p99 <= 150 us, misses counted", "cli", "test_rotor_line.EndsOnTheLine.test_missed_periods",
     r"gateway paused.*", "misses counted and shown; p99 under load is not measured"),
    (19, "no allocation in the loop", "0", "bus", "HotPath", "", ""),
    (20, "soak, 8 h", "RSS slope < 1 MB/h", "", "", "", "not run"),
    (21, "determinism", "equal hashes", "cli", "test_flights.Lockstep.test_processes_and_container", r"real-time factor.*", ""),
    (22, "DDS security, 17 cases", "17/17 denied", "", "", "", "no --secure yet"),
    (23, "mutated RTPS packets", "alive", "", "", "", "not run"),
    (24, "log storm", "<= 15 lines/s", "", "", "", "no token bucket; refusals are said once a second"),
    (25, "sanitizers, coverage", "0 reports", "", "", "", "./launch_scripts/test.sh --sanitize; no coverage ratchet"),
]


def run(build, package, pattern, figure):
    """(passed, failed, measured words) of the tests whose names match."""
    folder = build / f"omniflight_{package}"
    if not (folder / "CTestTestfile.cmake").exists():
        return 0, 0, "not built"
    done = subprocess.run(["ctest", "-V", "-R", pattern], cwd=folder, text=True, capture_output=True, timeout=1800)
    lines = [re.sub(r"^\d+: ", "", line).strip() for line in done.stdout.splitlines()]
    results = [line for line in lines if re.match(r"\d+/\d+ Test\s+#", line)]
    passed = sum("Passed" in line for line in results)
    said = [line for line in lines if figure and re.fullmatch(figure, line) and "[" not in line and "Test" not in line]
    seconds = re.search(r"Total Test time \(real\) =\s*(\S+)", done.stdout)
    return passed, len(results) - passed, "; ".join(said[:4]) or f"in {seconds.group(1) if seconds else '?'} s"


def main():
    build, only = Path(sys.argv[1]), {int(n) for n in sys.argv[2].split(",") if n}
    bad = short = 0
    print("| # | test | pass figure | result | measured | short |\n|---|---|---|---|---|---|")
    for number, what, wanted, package, pattern, figure, lacks in ROWS:
        if only and number not in only:
            continue
        if package:
            passed, failed, measured = run(build, package, pattern, figure)
            result = f"{passed} passed" + (f", {failed} FAILED" if failed else "") if passed + failed else "NOT FOUND"
            bad += failed > 0 or passed == 0
        else:
            result, measured = "none", ""
        short += bool(lacks)
        print(f"| {number} | {what} | {wanted} | {result} | {measured} | {lacks} |", flush=True)
    print(f"{len(only) or len(ROWS)} rows, {bad} failed or not found, {short} short of the whole test")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
