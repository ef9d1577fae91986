#!/usr/bin/env bash
# Runs the tests that stand for the 25 reliability tests on the tree that test.sh has built, and
# prints a table: pass figure, what was measured, and what is short.
# Options: --only N,N   these rows alone
#          --long       also their long tests, hours in all
#          --soak-hours H   simulated flight of row 20 (0.5; the whole test is 8, about H / 3 of wall time)
# Example: ./launch_scripts/test.sh && ./launch_scripts/reliability.sh
source "$(dirname "$0")/common.sh"
only="" long=""
while [ $# -gt 0 ]; do
  case "$1" in
    --only) only="${2:?--only needs numbers}"; shift 2 ;;
    --long) long=long; shift ;;
    --soak-hours) export OMNIFLIGHT_SOAK_HOURS="${2:?--soak-hours needs a number}"; shift 2 ;;
    *) sed -n '2,7p' "$0"; exit 4 ;;
  esac
done
export OMNIFLIGHT_CONFIGS="$OMNIFLIGHT_ROOT/configs" OMNIFLIGHT_BIN="$OMNIFLIGHT_ROOT/build/testing/install"
exec python3 "$OMNIFLIGHT_ROOT/launch_scripts/reliability_table.py" "$OMNIFLIGHT_ROOT/build/testing/build" "$only" "$long"
