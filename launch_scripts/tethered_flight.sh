#!/usr/bin/env bash
# Starts the components of a tethered flight one by one: gateway, controller, allocator, planner and recorder as on the
# vehicle's side. Without DEVICES the boards are emulated on pseudo terminals. On two machines start the emulator (or
# the boards) on one and the rest on the other, with the same OMNIFLIGHT_DOMAIN and your own CYCLONEDDS_URI.
# Usage:   ./launch_scripts/tethered_flight.sh [MISSION] [OUTPUT_FOLDER] [DEVICES]
# Example: ./launch_scripts/tethered_flight.sh trajectory_1 runs/tethered "/dev/ttyACM0;/dev/ttyACM1;/dev/ttyUSB0"
source "$(dirname "$0")/flight_common.sh"
prepare_flight "${1:-trajectory_1}" "${2:-runs/tethered_by_hand}"
devices="${3:-$out/boards/board0;$out/boards/board1;$out/boards/board2}"

cat >"$out/params.yaml" <<YAML
/**: {ros__parameters: {}}
recorder: {ros__parameters: {file: "$out/flight.mcap", overwrite: true}}
planner: {ros__parameters: {plan: "$out/plan"}}
allocator: {ros__parameters: {vehicle: omnimorph, alpha_deg: $alpha}}
emulator:
  ros__parameters: {vehicle: omnimorph, sensors: "$configs/sensors/laboratory.yaml", model: "${OMNIFLIGHT_EFFECTS:-}",
    initial_position_m: $start, initial_alpha_deg: $alpha, link_directory: "$out/boards", epoch_ns: $epoch_ns}
gateway:
  ros__parameters: {vehicle: omnimorph, devices: "$devices", alpha_deg: $alpha, flight_s: $flight, epoch_ns: $epoch_ns}
YAML
start_component recorder
start_component planner
start_component allocator
start_component controller
[ -n "${3:-}" ] || start_component emulator
start_component gateway
wait_for_flight gateway
