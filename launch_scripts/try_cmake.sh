#!/usr/bin/env bash
# The first ten minutes with the package libomniflight-dev: its example is copied, configured, compiled and run, and a component that
# is not there is named. Needs cmake, make and g++. Uses nothing of the checkout.
# Example: ./launch_scripts/try_cmake.sh
set -euo pipefail
[ $# -eq 0 ] || { sed -n '2,4p' "$0"; exit 4; }
examples=/usr/share/doc/libomniflight-dev/examples
[ -d "$examples/hover" ] || { echo "try_cmake.sh: libomniflight-dev is not installed" >&2; exit 4; }
unset OMNIFLIGHT_CONFIGS CMAKE_PREFIX_PATH
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
cd "$work"
cp -r "$examples/hover" .
cmake -S hover -B build -DCMAKE_BUILD_TYPE=Release
cmake --build build
./build/hover omnimorph | tee hover.txt
grep -q '^tilt  0 deg: .* W, largest load 0\.' hover.txt
sed -i 's/COMPONENTS vehicle/COMPONENTS vehicel/' hover/CMakeLists.txt
if cmake -S hover -B wrong >wrong.txt 2>&1; then echo "try_cmake.sh: a misspelt component was found" >&2; exit 1; fi
tr -s ' \n' ' ' <wrong.txt | grep -o "omniflight has no component 'vehicel'"
mkdir all && cat >all/CMakeLists.txt <<'CMAKE'
cmake_minimum_required(VERSION 3.22)
project(all LANGUAGES CXX)
find_package(omniflight 0.2 REQUIRED)
foreach(component core files msgs vehicle physics allocation control planning recording identification gateway safety simulation
        diagnosis report reproduction view jobs campaign bus)
  if(NOT TARGET omniflight::${component})
    message(FATAL_ERROR "omniflight::${component} is missing")
  endif()
endforeach()
CMAKE
cmake -S all -B every >/dev/null
echo "the libraries work from CMake"
