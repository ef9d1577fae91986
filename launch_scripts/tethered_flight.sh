#!/usr/bin/env bash
# Starts the components of a tethered flight one by one: gateway, controller, allocator, planner and recorder as on the
# vehicle's side. Without DEVICES the boards are emulated, behind local sockets.
# Usage:   ./launch_scripts/tethered_flight.sh [MISSION] [OUTPUT_FOLDER] [DEVICES]
# Example: ./launch_scripts/tethered_flight.sh trajectory_1 runs/tethered "/dev/ttyACM0;/dev/ttyACM1;/dev/ttyUSB0"
source "$(dirname "$0")/flight_common.sh"
prepare_flight "${1:-trajectory_1}" "${2:-runs/tethered_by_hand}"
gateway="vehicle: \"$vehicle\", alpha_deg: $alpha, flight_s: $flight, epoch_monotonic_ns: $epoch_ns"
if [ -n "${3:-}" ]; then
  emulator=() gateway+=", devices: \"$3\""
else
  # no rotor turns: a loaded machine may starve a component for longer than hardware may wait
  emulator=(emulator)
  gateway+=", devices: \"$out/boards/board0;$out/boards/board1;$out/boards/board2\", stale_after_s: 0.3, board_silence_s: 1.5, board_stall_s: 1.5"
  echo "controller: {ros__parameters: {mocap_timeout_s: 1.5, imu_timeout_s: 1.0}}" >>"$out/params.yaml"
  plant_params emulator "link_directory: \"$out/boards\", epoch_monotonic_ns: $epoch_ns"
fi
echo "gateway: {ros__parameters: {$gateway}}" >>"$out/params.yaml"
fly_with "${emulator[@]}" gateway
