#!/usr/bin/env bash
# The main job from nothing: installs, builds, plans trajectory 2, flies it nominally and with a hidden tether, compares,
# diagnoses, flies the model that was found, and writes a report. With real recordings at hand
# (OMNIFLIGHT_REAL_DATA, default ../shared/data) the same verb diagnoses real flights.
# Example: ./launch_scripts/demo.sh [OUTPUT_FOLDER]
source "$(dirname "$0")/common.sh"
out="${1:-$OMNIFLIGHT_ROOT/runs/demo-$(date +%Y%m%d-%H%M%S)}"
./launch_scripts/build.sh
omniflight="$OMNIFLIGHT_ROOT/install/omniflight_cli/bin/omniflight"
mkdir -p "$out"

# exit code 2 of diagnose only says that something remains unexplained; the report tells what
diagnose() { "$omniflight" diagnose "$@" || [ $? -eq 2 ]; }

say "planning trajectory 2 in the test bed"
"$omniflight" plan trajectory_2 --out "$out/plan"
"$omniflight" plan verify "$out/plan"

say "flying it over the bus in the nominal simulator, every component a process"
"$omniflight" fly trajectory_2 --plan "$out/plan" --sensors laboratory --seed 1 --out "$out/nominal"

say "flying it again with a tether that the diagnosis is not told about"
"$omniflight" fly trajectory_2 --plan "$out/plan" --sensors laboratory --seed 2 --effects tether --out "$out/tethered"

say "comparing (layout of the thesis's Table 7.1)"
"$omniflight" compare "$out/nominal/flight.mcap" "$out/tethered/flight.mcap" --vehicle omnimorph --out "$out/compare"

say "diagnosing the tethered recording, and flying the model that was found"
diagnose "$out/tethered/flight.mcap" --vehicle omnimorph --refly trajectory_2 --plan "$out/plan" --out "$out/diagnosis"

# what this flight cannot tell apart, and the flight that would
python3 - "$out/diagnosis/diagnosis.json" <<'PY'
import json, sys
d = json.load(open(sys.argv[1]))
for finding in d["findings"]:
    alike = finding.get("cannot_be_told_apart_from") or []
    if alike:
        print("cannot be told apart: %s from %s" % (finding["effect"], ", ".join(alike)))
    else:
        print("told apart from every candidate: " + finding["effect"])
following = d.get("next_flight") or {}
if following.get("mission"):
    pairs = "; ".join(" and ".join(pair) for pair in following.get("separates", []))
    print("next flight: %s separates %s (%.3g sigma predicted)"
          % (following["mission"], pairs, following.get("predicted_separation_sigma", 0)))
PY

say "the nominal recording must raise no alarm"
diagnose "$out/nominal/flight.mcap" --vehicle omnimorph --out "$out/nominal_diagnosis"

data="${OMNIFLIGHT_REAL_DATA:-$OMNIFLIGHT_ROOT/../shared/data}"
flights="$data/flights/crazyflie_brushless"
if [ -d "$flights" ]; then
  say "real flights: a nominal quadrotor, some flights held out"
  diagnose "$flights"/eckart{00,06,12,17,22,27} --held-out "$flights"/eckart{01,07,13,18,23,28} \
    --vehicle crazyflie_brushless --out "$out/real" >"$out/real.txt"
  grep -v '^  held out:.* [FM][xyz]:' "$out/real.txt"
else
  say "no real recordings at hand ($flights is absent): that part is left out"
fi

say "done"
echo "report of the tethered flight: $out/diagnosis/report.html"
[ ! -d "$out/real" ] || echo "report of the real flights:    $out/real/report.html"
