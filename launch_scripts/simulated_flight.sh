#!/usr/bin/env bash
# Starts the components of a simulated flight one by one, as on a laboratory bench, and waits for the flight to end.
# Usage:   ./launch_scripts/simulated_flight.sh [MISSION] [OUTPUT_FOLDER]
# Example: ./launch_scripts/simulated_flight.sh trajectory_1 runs/by_hand
# OMNIFLIGHT_DOMAIN (default 77) chooses the domain; OMNIFLIGHT_EFFECTS a model file that the plant flies.
source "$(dirname "$0")/flight_common.sh"
prepare_flight "${1:-trajectory_1}" "${2:-runs/simulated_by_hand}"

cat >"$out/params.yaml" <<YAML
/**: {ros__parameters: {}}
recorder: {ros__parameters: {file: "$out/flight.mcap", overwrite: true}}
planner: {ros__parameters: {plan: "$out/plan"}}
allocator: {ros__parameters: {vehicle: omnimorph, alpha_deg: $alpha}}
simulator:
  ros__parameters: {vehicle: omnimorph, sensors: "$configs/sensors/laboratory.yaml", model: "${OMNIFLIGHT_EFFECTS:-}",
    initial_position_m: $start, initial_alpha_deg: $alpha, duration_s: $duration, rate: realtime}
YAML
start_component recorder
start_component planner
start_component allocator
start_component controller
start_component simulator
wait_for_flight simulator
