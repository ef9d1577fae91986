#!/usr/bin/env bash
# Counts the branches that the tests take, by clang's source-based coverage: all of the failsafe ladder's, and of the flight
# path no smaller share than tests/coverage.json records. Ends with a line a package and exit code 0 when both hold.
# Options: --only PACKAGE   one of safety, control, allocation, gateway;   --record   writes the shares of today when all are
#          at least the recorded ones
# Example: ./launch_scripts/coverage.sh --only safety
source "$(dirname "$0")/common.sh"
packages=(safety control allocation gateway) record=""
while [ $# -gt 0 ]; do
  case "$1" in
    --only) packages=("${2:?--only needs a package}"); shift 2 ;;
    --record) record=--record; shift ;;
    *) sed -n '2,6p' "$0"; exit 4 ;;
  esac
done
for tool in clang++ llvm-profdata llvm-cov; do
  command -v "$tool" >/dev/null || { echo "$tool is not there: apt install clang llvm" >&2; exit 4; }
done
base="$OMNIFLIGHT_ROOT/build/coverage"
export CC=clang CXX=clang++
export OMNIFLIGHT_COLCON_SELECT="--packages-up-to ${packages[*]/#/omniflight_}"
say "building with clang"
omniflight_build "$base" -DBUILD_TESTING=ON -DOMNIFLIGHT_COVERAGE=ON

say "testing"
export OMNIFLIGHT_CONFIGS="$OMNIFLIGHT_ROOT/configs" OMNIFLIGHT_BIN="$base/install"
profiles="$base/profiles"
for package in "${packages[@]}"; do
  rm -rf "${profiles:?}/$package"
  mkdir -p "$profiles/$package"
  # a file a program (%m), which its runs add to
  (cd "$base/build/omniflight_$package" && LLVM_PROFILE_FILE="$profiles/$package/%m.profraw" ctest -LE long --output-on-failure -Q -O "$profiles/$package/ctest.log") \
    || { tail -n 30 "$profiles/$package/ctest.log"; exit 1; }
  llvm-profdata merge -sparse "$profiles/$package"/*.profraw -o "$profiles/$package/merged.profdata"
  programs=()
  for program in "$base/build/omniflight_$package"/test_*; do
    if [ -f "$program" ] && [ -x "$program" ]; then programs+=(-object "$program"); fi
  done
  llvm-cov export "${programs[@]:1}" --instr-profile "$profiles/$package/merged.profdata" \
    --ignore-filename-regex '/(test|testing)/' >"$profiles/$package/coverage.json"
done
python3 "$OMNIFLIGHT_ROOT/launch_scripts/coverage_table.py" "$profiles" $record "${packages[@]}"
