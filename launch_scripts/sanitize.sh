#!/usr/bin/env bash
# Builds the flight path with sanitizers in a folder of its own, runs the tests of its packages, and flies with its components:
# in one process, in one process each, and through emulated boards. Closes with "N tests passed, N failed, N flights,
# N reports of our code"; exit code 0 when nothing failed and none is. Needs the tree of test.sh.
# Options: --sanitize thread | address,undefined   (thread)
#          --quick    only what has threads and what they share is built with it (core, messages, bus, recording, control,
#                     safety, gateway, components); other libraries are linked as test.sh has built them
#          --only PACKAGE,PACKAGE   tests of these alone (control,allocation,safety,gateway,recording,bus,components); builds no
#                     more than they and the flights need
#          --no-flights, --flights-only
# Example: ./launch_scripts/test.sh && ./launch_scripts/sanitize.sh --sanitize address,undefined
source "$(dirname "$0")/common.sh"
sanitize=thread packages="control,allocation,safety,gateway,recording,bus,components" quick="" fly=yes
while [ $# -gt 0 ]; do
  case "$1" in
    --sanitize) sanitize="${2:?--sanitize needs a list}"; shift 2 ;;
    --only) packages="${2:?--only needs packages}"; shift 2 ;;
    --quick) quick=-quick; shift ;;
    --no-flights) fly=""; shift ;;
    --flights-only) packages=""; shift ;;
    *) sed -n '2,11p' "$0"; exit 4 ;;
  esac
done
base="$OMNIFLIGHT_ROOT/build/flight-path-${sanitize//,/-}$quick"
plain="$OMNIFLIGHT_ROOT/build/testing/install"
omniflight="${OMNIFLIGHT_COMMAND:-$plain/omniflight_cli/bin/omniflight}"
[ -z "$fly$quick" ] || [ -x "$omniflight" ] || { echo "$omniflight is not there: run ./launch_scripts/test.sh first, or name one in OMNIFLIGHT_COMMAND" >&2; exit 4; }

if [ -n "$quick" ]; then packages="${packages/allocation,/}"; fi
IFS=, read -r -a tested <<<"$packages"
select="--packages-up-to"
if [ "${#tested[@]}" -gt 0 ]; then select+=" ${tested[*]/#/omniflight_}"; fi
if [ -n "$fly" ]; then select+=" omniflight_components"; fi
if [ -n "$quick" ]; then
  instrumented=(cmake core msgs bus recording control safety gateway components)
  select+=" --packages-select ${instrumented[*]/#/omniflight_}"  # of both lists
  for prefix in "$plain"/omniflight_*; do CMAKE_PREFIX_PATH="${CMAKE_PREFIX_PATH:-}:$prefix"; done
  # colcon asks for what it was not told to build in the workspaces that are named here
  export CMAKE_PREFIX_PATH COLCON_PREFIX_PATH="$plain"
fi
say "building with -fsanitize=$sanitize"
OMNIFLIGHT_COLCON_SELECT="$select" omniflight_build "$base" -DBUILD_TESTING=OFF "-DOMNIFLIGHT_SANITIZE=$sanitize"
if [ "${#tested[@]}" -gt 0 ]; then
  say "building the tests"
  OMNIFLIGHT_COLCON_SELECT="--packages-select ${tested[*]/#/omniflight_}" \
    omniflight_build "$base" -DBUILD_TESTING=ON "-DOMNIFLIGHT_SANITIZE=$sanitize"
fi

# Every process writes what it has to report into a file of its own, so that none is lost with the exit code of a component.
# Of ThreadSanitizer, sanitizer_reports.py judges afterwards which are ours.
reports="$base/reports"
rm -rf "$reports"
mkdir -p "$reports"
export TSAN_OPTIONS="exitcode=0 log_path=$reports/thread ${TSAN_OPTIONS:-}"
export ASAN_OPTIONS="log_path=$reports/address ${ASAN_OPTIONS:-}"
export UBSAN_OPTIONS="halt_on_error=1 print_stacktrace=1 log_path=$reports/undefined ${UBSAN_OPTIONS:-}"
export OMNIFLIGHT_CONFIGS="$OMNIFLIGHT_ROOT/configs" OMNIFLIGHT_BIN="$base/install"

passed=0 failed=0
for package in "${tested[@]}"; do
  say "tests of $package"
  log="$base/$package.ctest.log"
  (cd "$base/build/omniflight_$package" && ctest -LE long --output-on-failure -Q -O "$log") || true
  good="$(grep -cE 'Test +#[0-9]+:.*Passed' "$log" || true)" bad="$(grep -cE '\*\*\*(Failed|Timeout|Exception)' "$log" || true)"
  grep -E '\*\*\*(Failed|Timeout|Exception)' "$log" || true
  echo "$package: $good passed, $bad failed; log: $log"
  passed=$((passed + good)) failed=$((failed + bad))
  [ "$good" -gt 0 ] || { echo "$package: no test has passed" >&2; failed=$((failed + 1)); }
done

say "flights"
flights=0
fly_once() {
  local name="$1" least="$2" code=0
  shift 2
  rm -rf "$base/flights/$name"
  OMNIFLIGHT_PROGRAMS="$base/install/omniflight_components/bin" "$omniflight" fly trajectory_1 --plan "$base/flights/plan" \
    --sensors laboratory --out "$base/flights/$name" --quiet "$@" >"$base/flights/$name.log" 2>&1 || code=$?
  local verdict
  verdict="$(python3 -c 'import json, sys; f = json.load(open(sys.argv[1])); print(f["verdict"], f["reason"])' "$base/flights/$name/flight.json" 2>/dev/null || echo "no result, exit code $code")"
  echo "$name: $verdict"
  flights=$((flights + 1))
  if [[ "$verdict" != $least* ]]; then failed=$((failed + 1)); tail -n 20 "$base/flights/$name.log"; fi
}
if [ -n "$fly" ]; then
  mkdir -p "$base/flights"
  "$omniflight" plan trajectory_1 --out "$base/flights/plan" --force --quiet
  fly_once one_process flown --in-process
  fly_once a_process_each flown
  # Real time: a sanitizer makes everything several times slower, so that periods are missed and the deadlines are longer.
  fly_once through_boards flown --plant emulator -p controller.missed_share=1 -p gateway.most_missed_share=1 \
    -p gateway.fresh_for_s=0.1 -p gateway.stale_after_s=1 -p gateway.board_silence_s=2 -p gateway.board_stall_s=2 -p controller.mocap_timeout_s=2 -p controller.imu_timeout_s=2
fi

python3 "$OMNIFLIGHT_ROOT/launch_scripts/sanitizer_reports.py" "$reports" | tee "$base/reports.txt" || failed=$((failed + 1))
echo "$sanitize: $passed tests passed, $failed failed, $flights flights, $(tail -n 1 "$base/reports.txt")"
[ "$failed" -eq 0 ]
