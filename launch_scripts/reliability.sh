#!/usr/bin/env bash
# What flights, files and plans promise, each row with the figure that was measured just now and what the test allows.
# The tests must be built (./launch_scripts/test.sh builds them). Rows whose program is not built say so.
# Options: --long   200 repetitions where a row has them (minutes instead of seconds)
# Example: ./launch_scripts/reliability.sh
source "$(dirname "$0")/common.sh"
build="$OMNIFLIGHT_ROOT/build/testing/build"
export OMNIFLIGHT_CONFIGS="$OMNIFLIGHT_ROOT/configs"
repetitions=5
[ "${1:-}" = "--long" ] && repetitions=200
failed=0

# row NAME PROMISE PROGRAM FILTER PATTERN: runs the test program's tests and prints the lines of its output that match
row() {
  local name="$1" promise="$2" program="$build/$3" filter="$4" pattern="$5" output verdict=kept
  printf '\n%s (%s)\n' "$name" "$promise"
  if [ ! -x "$program" ]; then printf '  not built: %s\n' "$3"; failed=1; return; fi
  output="$(OMNIFLIGHT_REPETITIONS=$repetitions nice -n 10 "$program" --gtest_filter="$filter" 2>&1)" || { verdict=BROKEN; failed=1; }
  grep -E "$pattern" <<<"$output" | sed 's/^/  /' || true
  printf '  %s\n' "$verdict"
}

row "plan deadline" "limit + 100 ms, also at 1 ms" omniflight_planning/test_budget '*' '^budget'
row "map bombs" "refused within 100 MB and 0.5 s" omniflight_planning/test_map_bombs '*' ' MB, .* s$'
row "hostile maps" "every file refused with a reason" omniflight_planning/test_map 'OctreeFile.*' 'PASSED|FAILED'
row "underactuated vehicles, unknown space, plan and vehicle" "refused" omniflight_planning/test_actuation '*' 'PASSED|FAILED'
row "gzip bombs" "refused while they unpack, 100 MB, 0.5 s" omniflight_files/test_files '*Bomb*' 'refused after'
row "bit flips of an unclosed recording" "none changes what is read silently" omniflight_recording/test_mcap_checkpoints '*' 'flips'
row "truncations and bit flips of recordings" "no loss without a note" omniflight_recording/test_mcap '*' 'PASSED|FAILED'
row "killed recorder, full disk" "at most one flush period is lost" omniflight_recording/test_mcap_crash '*' 'ms|PASSED|FAILED'
exit $failed
