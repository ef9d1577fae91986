#!/usr/bin/env bash
# Builds the workspace from nothing (Release, without tests, without ccache) into a folder of its own, and prints the
# processor time of every package and of the slowest sources. Processor time hardly depends on what else the machine
# does; the wall time on two idle processors is estimated from it, sources of a package two at a time, packages in turn.
# Options: --tests         with the tests, as test.sh builds
#          --only "A B"    these packages alone; their dependencies are taken from the folder
#          --folder F      where; default build/timing, which is emptied unless --only is given
#          --report        prints the figures of the last build there again
# Example: ./launch_scripts/build_time.sh
source "$(dirname "$0")/common.sh"
base="$OMNIFLIGHT_ROOT/build/timing" testing=OFF only="" report=""
while [ $# -gt 0 ]; do
  case "$1" in
    --tests) testing=ON; shift ;;
    --only) only="${2:?--only needs packages}"; shift 2 ;;
    --folder) base="${2:?--folder needs a folder}"; shift 2 ;;
    --report) report=yes; shift ;;
    *) sed -n '2,10p' "$0"; exit 4 ;;
  esac
done
if [ -z "$report" ]; then
  if [ -n "$only" ]; then
    for package in $only; do rm -rf "$base/build/$package" "$base/times/$package"; done
    export OMNIFLIGHT_COLCON_SELECT="--packages-select $only"
  else
    rm -rf "$base"
  fi
  mkdir -p "$base/times"
  export OMNIFLIGHT_TIMES="$base/times" OMNIFLIGHT_WITHOUT_CCACHE=yes
  times="$OMNIFLIGHT_ROOT/launch_scripts/timed_command.sh"
  begin="$(date +%s)"
  omniflight_build "$base" "-DBUILD_TESTING=$testing" "-DCMAKE_C_COMPILER_LAUNCHER=$times" \
    "-DCMAKE_CXX_COMPILER_LAUNCHER=$times" "-DCMAKE_C_LINKER_LAUNCHER=$times" "-DCMAKE_CXX_LINKER_LAUNCHER=$times"
  rm -f "$base/times/whole"
  if [ -z "$only" ]; then  # what the children of this shell took: the commands, and CMake, Ninja and colcon besides
    echo "$(($(date +%s) - begin))" >"$base/times/whole"
    times >>"$base/times/whole"
  fi
fi
python3 launch_scripts/build_time_table.py "$base/times"
