# Sourced by the flight scripts: plan a mission, write the parameters, start components in the background, stop them in
# order. OMNIFLIGHT_PROGRAMS and OMNIFLIGHT_COMMAND name another build than the one in install/.
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
bin="${OMNIFLIGHT_PROGRAMS:-$OMNIFLIGHT_ROOT/install/omniflight_components/bin}"
omniflight="${OMNIFLIGHT_COMMAND:-$OMNIFLIGHT_ROOT/install/omniflight_cli/bin/omniflight}"
configs="$OMNIFLIGHT_ROOT/configs"
domain="${OMNIFLIGHT_DOMAIN:-77}"
names=() pids=()

[ -x "$omniflight" ] || { echo "not built yet: run ./launch_scripts/build.sh first" >&2; exit 4; }

# prepare_flight MISSION FOLDER: sets out, vehicle, alpha, start, duration, flight, epoch_ns; writes params.yaml with what
# every flight has
prepare_flight() {
  mkdir -p "$2/log"
  out="$(cd "$2" && pwd)"
  "$omniflight" plan "$1" --out "$out/plan" --force
  # what the plant needs to know: where the plan begins, its tilt and its length (1 s held, 3 s hover, 1 s after)
  eval "$(python3 - "$out/plan" "$configs" <<'PY'
import csv, json, math, os, shlex, sys, time
folder = sys.argv[1]
rows = list(csv.DictReader(open(folder + "/trajectory.csv")))
first, last = rows[0], rows[-1]
w, x, y, z = (float(first["ref_q" + c]) for c in "wxyz")
rpy = (math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)), math.asin(max(-1, min(1, 2 * (w * y - z * x)))),
       math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
print("alpha=%.9g" % math.degrees(float(first["alpha_cmd_rad"])))
print("start='initial_position_m: [%s, %s, %s], initial_rpy_deg: [%.9g, %.9g, %.9g]'"
      % (first["ref_px_m"], first["ref_py_m"], first["ref_pz_m"], *map(math.degrees, rpy)))
print("duration=%.6f" % (float(last["t_s"]) + 5.0))
print("flight=%.6f" % (float(last["t_s"]) + 4.0))
print("epoch_ns=%d" % time.monotonic_ns())
vehicle = json.load(open(folder + "/certificate.json"))["vehicle"]
known = os.path.isdir(sys.argv[2] + "/vehicles/" + vehicle["name"].split("@")[0])
print("vehicle=" + shlex.quote(vehicle["name"] if known else vehicle["file"]))
PY
)"
  cat >"$out/params.yaml" <<YAML
recorder: {ros__parameters: {file: "$out/flight.mcap", overwrite: true, attachments: "$out/plan/certificate.json"}}
planner: {ros__parameters: {plan: "$out/plan"}}
allocator: {ros__parameters: {vehicle: "$vehicle", alpha_deg: $alpha}}
YAML
}

# plant_params NAME 'key: value, ...': the simulated plant, whichever component plays it
plant_params() {
  cat >>"$out/params.yaml" <<YAML
$1:
  ros__parameters: {vehicle: "$vehicle", sensors: "$configs/sensors/laboratory.yaml", model: "${OMNIFLIGHT_EFFECTS:-}",
    $start, initial_alpha_deg: $alpha, $2}
YAML
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
trap 'exit 130' INT TERM

# fly_with NAME...: starts these after recorder, planner, allocator and controller, waits until the last one (the clock
# master) ends, at most the flight plus a minute, and tells what was recorded
fly_with() {
  local name code=0 i
  for name in recorder planner allocator controller "$@"; do start_component "$name"; done
  local master="${pids[-1]}" deadline=$((SECONDS + ${duration%.*} + 60))
  while kill -0 "$master" 2>/dev/null; do
    [ "$SECONDS" -lt "$deadline" ] || { echo "the flight did not end in time; see $out/log" >&2; exit 2; }
    for i in "${!pids[@]}"; do
      if ! kill -0 "${pids[$i]}" 2>/dev/null && [ "${pids[$i]}" != "$master" ]; then
        echo "the ${names[$i]} ended in flight:" >&2
        tail -n 2 "$out/log/${names[$i]}.log" >&2
        exit 2
      fi
    done
    sleep 0.2
  done
  wait "$master" || code=$?
  tail -n 2 "$out/log/${names[-1]}.log"
  trap - EXIT
  stop_all
  "$omniflight" info "$out/flight.mcap" | grep -E '^[^ ]|^  note' || true
  echo "recording: $out/flight.mcap"
  exit "$code"
}
