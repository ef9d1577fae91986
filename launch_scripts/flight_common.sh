# Sourced by the flight scripts: plan a mission, start components in the background, stop them in order.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
bin="$OMNIFLIGHT_ROOT/install/omniflight_components/bin"
omniflight="$OMNIFLIGHT_ROOT/install/omniflight_cli/bin/omniflight"
configs="$OMNIFLIGHT_ROOT/configs"
domain="${OMNIFLIGHT_DOMAIN:-77}"
names=() pids=()

[ -x "$omniflight" ] || { echo "not built yet: run ./launch_scripts/build.sh first" >&2; exit 4; }

# prepare_flight MISSION FOLDER: sets out, alpha, start, duration, flight, epoch_ns
prepare_flight() {
  mkdir -p "$2/log"
  out="$(cd "$2" && pwd)"
  "$omniflight" plan "$1" --out "$out/plan"
  # what the plant needs to know: where the plan begins, its tilt and its length (1 s held, 3 s hover, 1 s after)
  eval "$(python3 - "$out/plan" <<'PY'
import csv, json, math, sys, time
folder = sys.argv[1]
rows = list(csv.DictReader(open(folder + "/trajectory.csv")))
first, last = rows[0], rows[-1]
print("alpha=%.9g" % math.degrees(float(first["alpha_cmd_rad"])))
print("start='[%s, %s, %s]'" % (first["ref_px_m"], first["ref_py_m"], first["ref_pz_m"]))
print("duration=%.6f" % (float(last["t_s"]) + 5.0))
print("flight=%.6f" % (float(last["t_s"]) + 4.0))
print("epoch_ns=%d" % time.time_ns())
PY
)"
}

start_component() {
  echo "starting $1"
  "$bin/omniflight_$1" --params "$configs/components/default.yaml" "$out/params.yaml" --domain "$domain" \
    --loopback "$configs/cyclonedds_loopback.xml" >"$out/log/$1.log" 2>&1 &
  names+=("$1")
  pids+=("$!")
}

stop_all() {
  local i
  for ((i = ${#pids[@]} - 1; i >= 0; --i)); do kill -TERM "${pids[$i]}" 2>/dev/null || true; sleep 0.2; done
  # nothing may be left behind: five seconds to end in order, then by force
  for _ in $(seq 50); do kill -0 "${pids[@]}" 2>/dev/null || return 0; sleep 0.1; done
  kill -KILL "${pids[@]}" 2>/dev/null || true
}
trap stop_all EXIT

# wait_for_flight NAME: until the clock master ends, at most the flight plus a minute
wait_for_flight() {
  local pid="${pids[-1]}" deadline=$((SECONDS + ${duration%.*} + 60)) code=0
  while kill -0 "$pid" 2>/dev/null; do
    [ "$SECONDS" -lt "$deadline" ] || { echo "the flight did not end in time; see $out/log" >&2; exit 2; }
    sleep 0.2
  done
  wait "$pid" || code=$?
  tail -n 2 "$out/log/$1.log"
  trap - EXIT
  stop_all
  "$omniflight" info "$out/flight.mcap" | head -n 1
  echo "recording: $out/flight.mcap"
  exit "$code"
}
