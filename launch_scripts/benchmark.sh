#!/usr/bin/env bash
# Builds the benchmarks (Release, portable) into build/benchmark, runs those of all packages and prints a table: our
# figure, the peer's in the same run, the ratio, the goal. Peers are optional; one that is absent is reported as
# skipped, with the reason.
# Example: ./launch_scripts/benchmark.sh                           (everything)
#          ./launch_scripts/benchmark.sh omniflight_simulation     (one package)
#          OMNIFLIGHT_BENCHMARK_BASE=/tmp/b ./launch_scripts/benchmark.sh    (build elsewhere)
source "$(dirname "$0")/common.sh"
case "${1:-}" in -*) sed -n '2,7p' "$0"; exit 4 ;; esac
./launch_scripts/install_dependencies.sh --benchmarks
base="${OMNIFLIGHT_BENCHMARK_BASE:-$OMNIFLIGHT_ROOT/build/benchmark}"
packages=("$@")
if [ "$#" -eq 0 ]; then
  for dir in src/*/benchmark; do packages+=("$(basename "$(dirname "$dir")")"); done
fi
say "building the benchmarks of ${packages[*]}"
OMNIFLIGHT_COLCON_SELECT="--packages-up-to ${packages[*]}" omniflight_build "$base" -DBUILD_TESTING=OFF -DOMNIFLIGHT_BENCHMARKS=ON
results="$base/results"
rm -rf "$results"  # never a figure of another run
mkdir -p "$results"
failed=()
export OMNIFLIGHT_CONFIGS="$OMNIFLIGHT_ROOT/configs"
for package in "${packages[@]}"; do
  for program in "$base/install/$package/lib/$package"/bench_*; do
    [ -x "$program" ] || continue
    say "$package: $(basename "$program")"
    name="$results/$(basename "$program")"
    if ! "$program" "--benchmark_out=$name.json" --benchmark_out_format=json | tee "$name.txt"; then
      failed+=("$(basename "$program")")
    fi
  done
done
say "ratios (peer's time over ours in the same run; above 1 we are faster)"
python3 launch_scripts/benchmark_table.py "$results"/bench_*
if [ "${#failed[@]}" -gt 0 ]; then
  echo "these benchmarks failed: ${failed[*]}" >&2
  exit 1
fi
