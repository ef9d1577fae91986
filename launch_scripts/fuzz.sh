#!/usr/bin/env bash
# Builds every test/fuzz_*.cpp with clang, libFuzzer, ASan and UBSan, and runs each for some time. Ends with a line each and
# exit code 0 when nothing was found; inputs that were found stay in build/fuzz/found.
# Options: --seconds N   for each (60); --only NAME   one of them, for instance fuzz_yaml; builds no more than it needs
# Example: ./launch_scripts/fuzz.sh --seconds 900
source "$(dirname "$0")/common.sh"
seconds=60 only=""
while [ $# -gt 0 ]; do
  case "$1" in
    --seconds) seconds="${2:?--seconds needs a number}"; shift 2 ;;
    --only) only="${2:?--only needs a name}"; shift 2 ;;
    *) sed -n '2,5p' "$0"; exit 4 ;;
  esac
done
command -v clang++ >/dev/null || { echo "clang++ is not there: apt install clang" >&2; exit 4; }
base="$OMNIFLIGHT_ROOT/build/fuzz"
export CC=clang CXX=clang++
select="omniflight_planning omniflight_recording omniflight_gateway"
if [ -n "$only" ]; then
  source_file="$(compgen -G "$OMNIFLIGHT_ROOT/src/*/test/$only.cpp")" || { echo "there is no src/*/test/$only.cpp" >&2; exit 4; }
  select="$(basename "$(dirname "$(dirname "$source_file")")")"
fi
export OMNIFLIGHT_COLCON_SELECT="--packages-up-to $select"
say "building with clang"
omniflight_build "$base" -DBUILD_TESTING=ON -DOMNIFLIGHT_FUZZ=ON -DOMNIFLIGHT_SANITIZE=address,undefined,fuzzer-no-link

export UBSAN_OPTIONS="halt_on_error=1 print_stacktrace=1"
found="$base/found"
mkdir -p "$found"
status=0
for program in "$base"/build/omniflight_*/fuzz_*; do
  name="$(basename "$program")"
  [ -f "$program" ] && [ -x "$program" ] || continue
  [ -z "$only" ] || [ "$only" = "$name" ] || continue
  mkdir -p "$base/corpus/$name"
  log="$base/$name.log"
  if "$program" "$base/corpus/$name" -max_total_time="$seconds" -timeout=1 -rss_limit_mb=1024 \
    -artifact_prefix="$found/$name-" -print_final_stats=1 >"$log" 2>&1; then
    runs="$(sed -n 's/stat::number_of_executed_units: *//p' "$log")"
    covered="$(sed -n 's/.*DONE *cov: \([0-9]*\).*/\1/p' "$log" | tail -n 1)"
    echo "$name: $runs runs in $seconds s, $covered edges covered, nothing found"
  else
    echo "$name: FOUND something, see $log and $found"
    status=1
  fi
done
exit "$status"
