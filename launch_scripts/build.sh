#!/usr/bin/env bash
# Builds the workspace (Release, without tests) into build/ and install/. Extra arguments go to CMake.
# Example: ./launch_scripts/build.sh -DOMNIFLIGHT_NATIVE=ON
source "$(dirname "$0")/common.sh"
./launch_scripts/install_dependencies.sh
say "building (Release, $JOBS jobs)"
omniflight_build "$OMNIFLIGHT_ROOT" -DBUILD_TESTING=OFF "$@"
