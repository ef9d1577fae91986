#!/usr/bin/env bash
# Flies every plant (simulator, emulator, mujoco) with every sensor set (ideal, laboratory, degraded) in four worlds (nominal,
# tether, payload, cable), diagnoses each recording, and prints a table: about two minutes a flight. Needs the tree of test.sh.
# Options: --only WORD,WORD   these plants, sensors and worlds alone
#          --keep DIR   recordings and diagnoses, DIR/PLANT-WORLD-SENSORS/flight.mcap and diagnosis/diagnosis.json
# Example: ./launch_scripts/test.sh && ./launch_scripts/diagnosis_table.sh --only simulator,laboratory
source "$(dirname "$0")/common.sh"
while [ $# -gt 0 ]; do
  case "$1" in
    --only) export OMNIFLIGHT_ONLY="${2:?--only needs words}"; shift 2 ;;
    --keep) OMNIFLIGHT_KEEP="$(realpath -m "${2:?--keep needs a folder}")"; export OMNIFLIGHT_KEEP; shift 2 ;;
    *) sed -n '2,6p' "$0"; exit 4 ;;
  esac
done
tests="$OMNIFLIGHT_ROOT/build/testing/build/omniflight_cli"
[ -f "$tests/CTestTestfile.cmake" ] || { echo "$tests is not built: run ./launch_scripts/test.sh first" >&2; exit 4; }
export OMNIFLIGHT_CONFIGS="$OMNIFLIGHT_ROOT/configs" OMNIFLIGHT_BIN="$OMNIFLIGHT_ROOT/build/testing/install"
cd "$tests"
ctest -V -L long -R test_long_diagnosis_table 2>&1 | sed -un 's/^[0-9]*: //; /^|/p; /^diagnosed/p; /Error/p; /FAILED/p; /tests passed/p'
