#!/usr/bin/env bash
# Starts the components of a simulated flight one by one, as on a laboratory bench, and waits for the flight to end.
# Usage:   ./launch_scripts/simulated_flight.sh [MISSION] [OUTPUT_FOLDER]
# Example: ./launch_scripts/simulated_flight.sh trajectory_1 runs/by_hand
# OMNIFLIGHT_DOMAIN (default 77) chooses the domain; OMNIFLIGHT_EFFECTS a model file that the plant flies;
# OMNIFLIGHT_RATE=max flies in lockstep, as fast as it goes, instead of in real time.
source "$(dirname "$0")/flight_common.sh"
prepare_flight "${1:-trajectory_1}" "${2:-runs/simulated_by_hand}"
plant_params simulator "duration_s: $duration, rate: ${OMNIFLIGHT_RATE:-realtime}"
fly_with simulator
