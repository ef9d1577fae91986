#!/usr/bin/env bash
# The first ten minutes with the packages installed: plans, flies twice, compares, diagnoses, and flies what was found; then a
# flight from Python. Uses nothing of the checkout. With PREFIX, packages that were only unpacked (dpkg-deb -x) there.
# Usage:   ./launch_scripts/try_packages.sh [PREFIX]
# Example: ./launch_scripts/try_packages.sh
set -euo pipefail
case "${1:-}" in -*) sed -n '2,5p' "$0"; exit 4 ;; esac
if [ -n "${1:-}" ]; then
  prefix="$(realpath "$1")"
  export PATH="$prefix/usr/bin:/usr/bin:/bin" PYTHONPATH="$prefix/usr/lib/python3/dist-packages"
else
  prefix=""
fi
unset OMNIFLIGHT_CONFIGS OMNIFLIGHT_PROGRAMS
[ "$(command -v omniflight)" = "$prefix/usr/bin/omniflight" ] || { echo "try_packages.sh: omniflight is not installed in $prefix/usr/bin" >&2; exit 4; }
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
cd "$work"
for compiler in g++ c++ clang++; do
  if command -v "$compiler" >/dev/null; then echo "note: there is a compiler here ($compiler), which is not used"; break; fi
done
omniflight --version
omniflight plan trajectory_2 --out plan
omniflight fly trajectory_2 --plan plan --sensors laboratory --seed 1 --out nominal
omniflight fly trajectory_2 --plan plan --sensors laboratory --seed 2 --effects tether --out tethered
omniflight compare nominal/flight.mcap tethered/flight.mcap --vehicle omnimorph --out compared
omniflight diagnose tethered/flight.mcap --vehicle omnimorph --out diagnosis || [ $? -eq 2 ]
omniflight fly trajectory_2 --plan plan --effects diagnosis/model.yaml --out again
/usr/bin/python3 - <<'PY'
import omniflight as of

flight = of.load("nominal/flight.mcap")
print("Python:", of.__file__, "reads", len(flight["position"].values), "positions;", of.load_vehicle("omnimorph").name)
PY
[ -s diagnosis/report.html ] && [ -s again/flight.json ]
echo "the packages work"
